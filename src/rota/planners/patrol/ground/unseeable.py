"""Ground that nobody can see: a little of it is left out, if the mission allows that; more ends the planning."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from rota.errors import NoPlanFound
from rota.geometry.free_space import DemandedRegion
from rota.model.arrays import Flags, Ints
from rota.model.mission import Mission, inner_reach_m
from rota.planners.patrol.ground.limits_of_sight import area_in_range
from rota.planners.patrol.ground.nearest_places import nearest_places
from rota.planners.patrol.ground.samples import SamplePoints
from rota.planners.patrol.ground.sight import Sight

MOST_EXCLUDED = 0.05  # of the demanded area: beyond it, planning always stops
CLOSE_LOOKS = 1_000  # for a figure


class Unseeable(NamedTuple):
    """Ground that nobody sees, and how many m2 that is; the shape may be a little more or less."""

    shape: BaseGeometry
    m2: float


def refuse_much_unseeable(mission: Mission, regions: tuple[DemandedRegion, ...], sight: Sight) -> None:
    """Raise NoPlanFound when nobody can see more than a plan may leave out; told before anything takes long.

    sight: from where robots surely come to. What is out of range is known to the last digit; what walls hide is
    counted in pieces, first in few.
    """
    asked = ground_asked_for(regions)
    near = area_in_range(sight.space, sight.robot, 0.0)
    far, allowed_m2 = out_of_range(asked, near, sight), MOST_EXCLUDED * asked.area
    is_refused = mission.unseeable == "refuse" and not far.is_empty
    hidable = _hidable(asked, near, sight, allowed_m2 - far.area)
    if not is_refused:
        if far.area + hidable.area <= allowed_m2:
            return
        # 300 squares make a guess, which will do if it is so low
        if far.area + hidden_ground(hidable, sight, 300).m2 <= 0.6 * allowed_m2:
            return
    found = _both(far, hidden_ground(hidable, sight, CLOSE_LOOKS, closely=True))
    if is_refused or found.m2 > allowed_m2:
        raise NoPlanFound(_refusal(mission, found, asked.area))


def refuse_unseeable(
    mission: Mission, points: SamplePoints, hopeless: Ints, regions: tuple[DemandedRegion, ...], sight: Sight
) -> None:
    """Raise NoPlanFound when nobody can see some of the points, and the mission refuses that; they are told."""
    if mission.unseeable != "refuse" or not len(hopeless):
        return
    asked = ground_asked_for(regions)
    found = unseeable_ground(asked, sight)
    if found.shape.is_empty:
        round_m = 1e-9 + np.sqrt(points.area_m2[hopeless]) / 2
        found = found._replace(shape=shapely.union_all(shapely.buffer(shapely.points(points.xy_m[hopeless]), round_m)))
    raise NoPlanFound(_refusal(mission, found, asked.area))


def out_of_range(asked: BaseGeometry, near: BaseGeometry, sight: Sight) -> BaseGeometry:
    """The ground that no place where robots can be has in range (``near``), whatever walls there are."""
    hair_m = 5e-4 * inner_reach_m(sight.robot.sensor)  # ground beyond the reach that is no wider is rounding of arcs
    parts = _parts(shapely.difference(asked, near))
    return shapely.union_all([part for part in parts if not part.buffer(-hair_m).is_empty])


def hidden_ground(hidable: BaseGeometry, sight: Sight, looks: int, *, closely: bool = False) -> Unseeable:
    """What walls hide from all places where robots can be, of ground that they may hide.

    looks: squares into which the ground is cut, about. What lies in one falls into pieces that are joined; a piece is
    hidden if a place on it is. closely: those at the edge of what is hidden are cut into four.
    """
    shapes: list[BaseGeometry] = []
    m2 = 0.0
    pieces, boxes = _cut_up(hidable, float(np.sqrt(hidable.area / looks)))
    for cuts in (True, False) if closely else (False,):
        hidden = _are_hidden(pieces, sight)
        at_edge = _beside_others(boxes, hidden) if cuts else np.zeros(len(boxes), dtype=np.bool_)
        shapes += list(pieces[hidden & ~at_edge])
        m2 += float(shapely.area(pieces[hidden & ~at_edge]).sum())
        pieces, boxes = _quarter(pieces[at_edge], boxes[at_edge])
    return Unseeable(shapely.union_all(shapes), m2)


def _are_hidden(pieces: NDArray[np.object_], sight: Sight) -> Flags:
    """Whether walls hide a place on each of the pieces (n,) from all places in range."""
    if not len(pieces):
        return np.zeros(0, dtype=np.bool_)
    places_m = shapely.get_coordinates(shapely.point_on_surface(pieces))
    _, ranges_m = nearest_places(places_m, sight.space, sight.walls, sight.robot)
    return np.asarray(ranges_m > inner_reach_m(sight.robot.sensor))


def unseeable_ground(asked: BaseGeometry, sight: Sight) -> Unseeable:
    """What nobody sees of the ground that is asked for: all that is out of range, and what walls hide."""
    near = area_in_range(sight.space, sight.robot, 0.0)
    hidden = hidden_ground(_hidable(asked, near, sight), sight, CLOSE_LOOKS, closely=True)
    return _both(out_of_range(asked, near, sight), hidden)


def _both(far: BaseGeometry, hidden: Unseeable) -> Unseeable:
    """What is out of range and what is hidden."""
    return Unseeable(shapely.union_all([far, hidden.shape]), float(far.area) + hidden.m2)


def ground_asked_for(regions: tuple[DemandedRegion, ...]) -> BaseGeometry:
    """All ground of which every point must be seen."""
    return shapely.union_all([region.shape for region in regions if region.demand == "every_point"])


def _hidable(asked: BaseGeometry, near: BaseGeometry, sight: Sight, enough_m2: float = 0.0) -> BaseGeometry:
    """The ground in range (``near``) that walls may hide: robots do not stand on it, and a wall is in reach.

    It may be more, as long as it is not more than is enough.
    """
    space, walls, robot, _ = sight
    if not len(walls):
        return shapely.MultiPolygon()
    ground = shapely.intersection(shapely.difference(asked, space), near)
    if ground.area > enough_m2 and len(walls) <= 2_000:  # ground that is clear of so few is soon worked out
        round_walls = shapely.buffer(shapely.linestrings(walls.reshape(-1, 2, 2)), 1.01 * robot.sensor.reach_m)
        ground = shapely.intersection(ground, shapely.union_all(round_walls))
    return ground


def _cut_up(ground: BaseGeometry, side_m: float) -> tuple[NDArray[np.object_], NDArray[np.object_]]:
    """The ground in pieces (n,) that are joined, each with the square of a lattice (n,) that it lies in.

    It is cut into four again and again: to cut each square out of the whole takes ten times as long on scanned floors.
    """
    pieces, boxes = np.zeros(0, dtype=object), np.zeros(0, dtype=object)
    if side_m > 0:
        x0, y0, x1, y1 = ground.bounds
        wide_m = max(x1 - x0, y1 - y0)
        pieces, boxes = np.array([ground]), np.array([shapely.box(x0, y0, x0 + wide_m, y0 + wide_m)])
        while len(pieces) and wide_m > 1.5 * side_m:
            pieces, boxes = _quarter(pieces, boxes)
            wide_m /= 2
    return pieces, boxes


def _quarter(
    pieces: NDArray[np.object_], boxes: NDArray[np.object_]
) -> tuple[NDArray[np.object_], NDArray[np.object_]]:
    """The pieces (n,) in the quarters of their boxes (n,): those that are joined, each with its quarter."""
    quarters = _quarters(boxes)
    parts, of_quarter = shapely.get_parts(shapely.intersection(np.tile(pieces, 4), quarters), return_index=True)
    polygons, of_part = shapely.get_parts(parts, return_index=True)
    has_area = shapely.area(polygons) > 0
    return polygons[has_area], quarters[of_quarter[of_part[has_area]]]


def _quarters(boxes: NDArray[np.object_]) -> NDArray[np.object_]:
    """The four quarters of each of the boxes (n,)."""
    x0, y0, x2, y2 = shapely.bounds(boxes).reshape(-1, 4).T
    x1, y1 = (x0 + x2) / 2, (y0 + y2) / 2
    corners = [(x0, y0, x1, y1), (x1, y0, x2, y1), (x0, y1, x1, y2), (x1, y1, x2, y2)]
    return np.concatenate([shapely.box(*sides) for sides in corners])


def _beside_others(boxes: NDArray[np.object_], kind: Flags) -> Flags:
    """Whether each of the boxes (n,) touches one of the other kind."""
    one, other = shapely.STRtree(boxes).query(boxes, predicate="intersects")
    found = np.zeros(len(boxes), dtype=np.bool_)
    found[one[kind[one] != kind[other]]] = True
    return found


def _parts(shape: BaseGeometry) -> list[BaseGeometry]:
    """The polygons of a shape."""
    return [part for part in shapely.get_parts(shapely.get_parts(np.atleast_1d(shape))) if part.geom_type == "Polygon"]


def in_words(mission: Mission, found: Unseeable, asked_m2: float) -> str:
    """How much of what is asked nobody sees, and where."""
    most = 5  # places
    parts = sorted(_parts(found.shape), key=lambda part: -float(part.area))[:most]
    middles = [part.point_on_surface() for part in parts]
    places = ", ".join(f"({middle.x:.2f}, {middle.y:.2f})" for middle in middles)
    where, entrances = "a robot can stand", mission.fleet.entrances
    if entrances is not None:
        listed = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in entrances[:most])
        more = f" and {len(entrances) - most} more" if len(entrances) > most else ""
        where = f"a robot can come to from fleet.entrances: {listed}{more}"
    lost = f"about {found.m2:.2f} m2 ({found.m2 / asked_m2:.1%}" if found.m2 >= 0.01 else "less than 0.01 m2 (0.0%"
    return f"{lost} of what is asked) cannot be seen from anywhere {where}, for instance round {places}"


def _refusal(mission: Mission, found: Unseeable, asked_m2: float) -> str:
    """The same, with what is allowed, and what to do about it."""
    allowed = "unseeable: refuse allows none" if mission.unseeable == "refuse" else f"{MOST_EXCLUDED:.0%} is allowed"
    return f"{in_words(mission, found, asked_m2)}; {allowed}; {_what_helps(mission, found)}"


def _what_helps(mission: Mission, found: Unseeable) -> str:
    """What leaves the unseeable ground out, or brings robots nearer to it."""
    no_fly = [o.shape for o in mission.obstacles if o.blocks == "motion" and o.asks == "all"]
    under_m2 = float(shapely.intersection(found.shape, shapely.union_all(no_fly)).area)
    helps = []
    if under_m2 > found.shape.area / 100:
        share = min(1.0, under_m2 / found.shape.area)
        helps.append(
            f"{share:.0%} of it is under obstacles with blocks: motion, whose ground is asked for unless asks: nothing"
            " stands beside that"
        )
    if mission.fleet.entrances is not None:
        helps.append(
            "robots see rooms that have a place among fleet.entrances, where a ROS map without any has its inside;"
            " entrances: null lets them be anywhere; close_gaps_m beside map, as wide as bodies, takes rooms behind"
            " narrower doors out of the area"
        )
    return "; ".join([*helps, "a zone with period_s: null leaves ground out"])
