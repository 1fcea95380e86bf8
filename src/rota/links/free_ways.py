"""Ways of robots in the air from where they are to where they go: round obstacles, in layers where they come close."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from shapely import LineString, MultiPolygon

from rota.errors import MissionError, PlanError
from rota.geometry.free_space import nearest_free_point, standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import Mission
from rota.routes.route import Place3

Place = tuple[float, float]

CLEAR_M = (3.0, 1.0, 0.0)  # beside obstacles, the widest that leaves a way: what satellite fixes err by, and less
APART_M = 5.0  # two ways nearer than this, bodies not counted, are flown at different heights
LAYER_M = 3.0  # between two layers


@dataclass(frozen=True, kw_only=True)
class LayeredWay:
    """A robot's way over ``places_m``, from where it is, all at ``height_m``."""

    robot: str
    places_m: tuple[Place, ...]
    height_m: float

    @property
    def length_m(self) -> float:
        """Metres from its first place to its last."""
        return sum(math.dist(a, b) for a, b in zip(self.places_m, self.places_m[1:], strict=False))

    @property
    def stops_m(self) -> tuple[Place3, ...]:
        """Its places after the first with their height."""
        return tuple((x, y, self.height_m) for x, y in self.places_m[1:])


def layered_ways(mission: Mission, ends_m: Mapping[str, tuple[Place, Place]]) -> tuple[LayeredWay, ...]:
    """The shortest way of each robot from its first place to its second, the lowest at the fleet's altitude.

    All may be flown at once, after all have climbed: those at one height stay ``APART_M`` and their bodies apart, as
    do their ends. Whoever stands outside of where it may fly goes straight to the nearest place where it may, and the
    other way round. Raises PlanError where no way leads from one place to the other.
    """
    ways: list[LayeredWay] = []
    lines: list[tuple[LineString, float, int]] = []
    spaces: dict[float, tuple[MultiPolygon, ShortestPaths] | None] = {}
    for name, (from_m, to_m) in ends_m.items():
        body_m = mission.fleet.robot(name).body_radius_m
        places_m = _way(mission, name, body_m, (from_m, to_m), spaces)
        line = LineString(places_m if len(places_m) > 1 else [places_m[0], places_m[0]])
        taken = {layer for other, reach_m, layer in lines if other.distance(line) < APART_M + body_m + reach_m}
        layer = next(k for k in range(len(lines) + 1) if k not in taken)
        lines.append((line, body_m, layer))
        ways.append(LayeredWay(robot=name, places_m=places_m, height_m=mission.fleet.altitude_m + layer * LAYER_M))
    return tuple(ways)


def _way(
    mission: Mission,
    robot: str,
    body_m: float,
    ends_m: tuple[Place, Place],
    spaces: dict[float, tuple[MultiPolygon, ShortestPaths] | None],
) -> tuple[Place, ...]:
    """The shortest way between two places that keeps as clear of walls as it can."""
    from_m, to_m = ends_m
    for clear_m in CLEAR_M:
        radius_m = body_m + clear_m
        if radius_m not in spaces:
            space = standing_space(mission, radius_m)
            spaces[radius_m] = None if space.is_empty else (space, ShortestPaths(space))
        known = spaces[radius_m]
        if known is None:
            continue
        space, paths = known
        try:
            inner = [nearest_free_point(space, place) for place in ends_m]
            line = paths.path(*inner).tolist()
        except (MissionError, PlanError):
            continue
        places = [from_m, *((float(x), float(y)) for x, y in line), to_m]
        return tuple(place for k, place in enumerate(places) if k == 0 or place != places[k - 1])
    raise PlanError(
        f"robot {robot}: no way leads from ({from_m[0]:.1f}, {from_m[1]:.1f}) to ({to_m[0]:.1f}, {to_m[1]:.1f})"
        " round the obstacles"
    )
