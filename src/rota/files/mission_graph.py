"""A mission in a graph: its lanes, the ground about them, and a zone to visit at each place with a period."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from shapely import LineString, MultiPolygon, Polygon

from rota.errors import MissionError
from rota.files.blocks import read_field
from rota.files.graph_file import ROUNDED, Edge, Graph, Point, read_graph
from rota.files.mission_schema import mission_field
from rota.files.mission_shapes import Frame, Stop
from rota.files.rings import circle_ring
from rota.model.limits import DURATION
from rota.model.mission import Lane, Zone
from rota.model.polygons import polygons_of
from rota.model.refusals import show_value

USUAL_WIDTH_M = 1.0
APART = 0.45  # of the way to the nearest other place: how far round a place a robot is there, at most

HERE = ("area", "graph")


@dataclass(frozen=True, kw_only=True)
class GraphGround:
    """Lanes, the ground about them, and around each place, by its name, where a robot is there."""

    lanes: tuple[Lane, ...]
    area: MultiPolygon
    spots: Mapping[str, MultiPolygon]
    periods_s: Mapping[str, Any]

    def spot(self, name: str) -> MultiPolygon | None:
        """The ground of a place; None where there is none of this name."""
        return self.spots.get(name)

    def zones(self, period_s: float | None, named: Iterable[str]) -> Iterator[Zone]:
        """A zone to visit at each place, but those that are ``named`` by other zones, and those without a period."""
        field, others = mission_field("zones", "period_s"), set(named)
        for name, shape in self.spots.items():
            told, wrong = read_field(field, self.periods_s.get(name, period_s))
            if wrong:
                allowed = f"seconds from {DURATION[0]:g} to {DURATION[1]:.9g}, or null, are needed"
                raise Stop(HERE, f"node {name!r} has period_s {show_value(self.periods_s[name])}; {allowed}")
            if told is not None and name not in others:
                yield Zone(name=name, period_s=told, demand="visit", shape=shape)


def load_graph(frame: Frame, block: Mapping[str, Any]) -> Graph:
    """The graph that an area names; Stop where it cannot be read."""
    try:
        return read_graph(frame.file(block["graph"]))
    except MissionError as error:
        raise Stop(HERE, *error.faults) from None


def bounds_of(graph: Graph) -> tuple[float, float, float, float]:
    """The least and the greatest coordinates of its places."""
    x, y = zip(*graph.places.values(), strict=True)
    return min(x), min(y), max(x), max(y)


def ground_of_graph(frame: Frame, graph: Graph, width_m: float | None) -> GraphGround:
    """The ground of a graph, in local metres. Stop where an edge is longer than it is said to be."""
    lanes = tuple(lane_of(edge, to_metres(frame, edge.line_m)) for edge in graph.edges)
    half_m = (width_m or USUAL_WIDTH_M) / 2
    names, places_m = list(graph.places), to_metres(frame, list(graph.places.values()))
    points = shapely.points(places_m)
    spots = {}
    for name, (x, y), other_m in zip(names, places_m, to_nearest_m(points), strict=True):
        ring = circle_ring((float(x), float(y)), min(half_m, APART * float(other_m)))
        spots[name] = MultiPolygon([Polygon(ring)])
    ribbons = [LineString(lane.line_m).buffer(half_m) for lane in lanes]
    return GraphGround(
        lanes=lanes,
        area=polygons_of(shapely.union_all([*ribbons, *spots.values()])),
        spots=spots,
        periods_s=graph.periods_s,
    )


def to_metres(frame: Frame, points: Iterable[Point]) -> Any:
    """Places (n, 2) as the file has them in local metres (n, 2)."""
    at = np.array(list(points), dtype=np.float64)
    if not frame.in_degrees:
        return at
    assert frame.projection is not None
    return np.column_stack(frame.projection.to_metres(*at.T))


def to_nearest_m(points: Any) -> Any:
    """How far (n,) each point (n,) is from the nearest other one; inf for one alone."""
    if len(points) < 2:
        return np.full(len(points), np.inf)
    tree = shapely.STRtree(points)
    (mine, _), away_m = tree.query_nearest(points, exclusive=True, return_distance=True)
    nearest_m = np.full(len(points), np.inf)
    np.minimum.at(nearest_m, mine, away_m)
    return nearest_m


def lane_of(edge: Edge, line_m: Any) -> Lane:
    """An edge as a lane along its line (n, 2); Stop where it is said to be shorter than that."""
    drawn_m = float(np.hypot(*np.diff(line_m, axis=0).T).sum())
    length_m = edge.length_m
    if length_m is not None and length_m < drawn_m * (1 - ROUNDED):
        message = (
            f"the edge from {edge.source!r} to {edge.target!r} is {length_m:.6g} m long, but {drawn_m:.6g} m are"
            " between its ends; lengths and coordinates must be metres, or name the length otherwise"
        )
        raise Stop(HERE, message)
    try:
        return Lane(
            line_m=tuple(map(tuple, line_m.tolist())), one_way=edge.one_way, least_s=edge.least_s,
            length_m=None if length_m is None or length_m <= drawn_m else length_m,
        )  # fmt: skip
    except MissionError as error:
        raise Stop(HERE, *(f"from {edge.source!r} to {edge.target!r}: {fault}" for fault in error.faults)) from None
