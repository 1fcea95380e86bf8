"""A mission as JSON, as plan files hold it: bit for bit, its shapes in local metres, its defaults filled in."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from shapely import MultiPolygon

from rota.model.field_values import Json, in_file_form
from rota.model.mission import Mission, Obstacle


def mission_to_json(mission: Mission) -> Json:
    """The mission as plain dicts, lists, strings and numbers, with its shapes resolved to rings."""
    told = block_to_json(mission)
    planner, settings = mission.planning.planner, told.pop("planning")
    if not mission.planning.heeds_moving_obstacles:
        del told["moving_obstacles"]
    return {**told, "planner": planner, planner: settings}


def block_to_json(block: Any, without: Collection[str] = ()) -> Json:
    """A part of a mission or a plan likewise; without: fields to leave out."""
    return in_file_form(
        block, lambda value: polygons_to_json(value) if isinstance(value, MultiPolygon) else value, without
    )


def obstacle_to_json(obstacle: Obstacle) -> Json:
    """An obstacle, with what it asks only where that is nothing."""
    return block_to_json(obstacle)


def polygons_to_json(shape: MultiPolygon) -> list[list[list[list[float]]]]:
    """A list of polygons, each a list of rings, the outer one first, whose first point is not repeated."""

    def ring_to_json(ring: Any) -> list[list[float]]:
        """One ring's corners in the plane."""
        return [[float(x), float(y)] for x, y, *_ in ring.coords[:-1]]

    return [[ring_to_json(ring) for ring in (polygon.exterior, *polygon.interiors)] for polygon in shape.geoms]
