"""Bouncing without a grid: a disc that moves straight in a polygon with holes and turns where it touches.

The bounce map takes the place and heading of one contact to those of the next. Two rules of bouncing are in use: Alam
and Bobadilla 2020, Eq. 6, turn left by the bouncing angle from the current heading, again while the way is blocked;
Nilles, Becerra and LaValle, "Periodic trajectories of mobile robots" (IROS 2017; their reference 13) leave at a fixed
angle from the wall, wherever the robot came from. What the map does in the long run tells ``polygon_cycles``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np
import shapely
from shapely import MultiPolygon, Point, Polygon

from rota.errors import MissionError
from rota.model.arrays import Floats, Ints
from rota.planners.bounce.polygon_kernels import (
    ARC,
    FROM_WALL,
    TOUCH_M,
    TURN,
    WALL,
    RimElements,
    Turning,
    first_contact,
    follow,
    is_blocked,
    place_on,
)

Bounce = Literal["turn", "from_wall"]

_MOST_TURNS_TO_WHOLE = 3600  # bouncing angles in tenths of degrees come back to the first heading after these at most
_STRAIGHT_RAD = 1e-9


@dataclass(frozen=True, kw_only=True)
class BounceRule:
    """What a robot does at a contact.

    ``bounce`` "turn": it turns left by ``angle_rad`` from its heading, again while something it touches is in the way.
    "from_wall": it leaves at ``angle_rad`` from the wall's direction with the free space on the left, 0 < angle < pi.
    """

    angle_rad: float
    bounce: Bounce = "turn"

    def __post_init__(self) -> None:
        top, bound = (2 * math.pi, "2 pi") if self.bounce == "turn" else (math.pi, "pi")
        if self.bounce not in ("turn", "from_wall"):
            raise MissionError(f"bounce: {self.bounce!r} is not allowed; turn or from_wall")
        if not (math.isfinite(self.angle_rad) and 0 < self.angle_rad < top):
            raise MissionError(f"angle_rad: {self.angle_rad!r} is not allowed; must lie between 0 and {bound}")

    @property
    def turns_to_whole(self) -> int:
        """After how many bouncing angles the heading is the first again; 0: never, as far as floats can tell."""
        share = Fraction(self.angle_rad / (2 * math.pi)).limit_denominator(_MOST_TURNS_TO_WHOLE)
        return share.denominator if math.isclose(float(share) * 2 * math.pi, self.angle_rad, rel_tol=1e-14) else 0

    @property
    def compiled(self) -> Turning:
        """The rule as compiled loops read it."""
        return Turning(TURN if self.bounce == "turn" else FROM_WALL, self.angle_rad, self.turns_to_whole)


@dataclass(frozen=True, kw_only=True, eq=False)
class Rim:
    """Where a disc's centre is when it touches a wall or a corner; see ``polygon_kernels``.

    elements: (n, 6) float64, kinds: (n,) int64, both in the order of walking round each ring with the free space on
    the left; the last column is the arc length in metres at which an element begins. ``free``: the polygons themselves.
    """

    free: MultiPolygon
    body_radius_m: float
    elements: Floats
    kinds: Ints

    @property
    def compiled(self) -> RimElements:
        """The rim as compiled loops read it."""
        return RimElements(self.elements, self.kinds, self.body_radius_m)

    @property
    def length_m(self) -> float:
        """Arc length of all rings together, with the parts that other walls keep the disc from."""
        return float(self.elements[-1, 5] + self.elements[-1, 4])

    def at(self, arcs_m: Floats) -> tuple[Ints, Floats]:
        """Element number and length from its beginning, (k,) each, of arc lengths (k,); MissionError outside."""
        if not ((arcs_m >= 0) & (arcs_m <= self.length_m)).all():
            raise MissionError(f"arcs_m: {arcs_m!r} is not allowed; must lie in 0..{self.length_m:.6g} m")
        element = np.searchsorted(self.elements[:, 5], arcs_m, side="right") - 1
        return element, np.minimum(arcs_m - self.elements[element, 5], self.elements[element, 4])

    def arcs_m(self, element: Ints, s_m: Floats) -> Floats:
        """Arc lengths (k,) of places given by element number and length from its beginning, (k,) each."""
        return np.asarray(self.elements[element, 5] + s_m, dtype=np.float64)

    def places_m(self, element: Ints, s_m: Floats) -> Floats:
        """Centres of the disc, (k, 2), at places given by element number and length from its beginning, (k,) each."""
        places = [place_on(self.compiled, int(e), float(s))[:2] for e, s in zip(element, s_m, strict=True)]
        return np.array(places, dtype=np.float64).reshape(-1, 2)


@dataclass(frozen=True, kw_only=True, eq=False)
class BouncePath:
    """A way from contact to contact. positions_m (k + 1, 2): the start, then contacts; headings_rad (k,): between them.

    arcs_m (k,) are the contacts'. Shorter than asked for when the robot got stuck.
    """

    positions_m: Floats
    headings_rad: Floats
    arcs_m: Floats

    @property
    def length_m(self) -> float:
        """Length of the way."""
        return float(np.linalg.norm(np.diff(self.positions_m, axis=0), axis=1).sum())


def make_rim(free: Polygon | MultiPolygon, body_radius_m: float = 0.0) -> Rim:
    """The rim of a disc of ``body_radius_m`` in ``free``, the area minus obstacles, with holes.

    Circular obstacles are polygons here as everywhere. Raises MissionError for an empty or invalid shape, and for one
    in which no such disc fits anywhere.
    """
    if not (math.isfinite(body_radius_m) and body_radius_m >= 0):
        raise MissionError(f"body_radius_m: {body_radius_m!r} is not allowed; must be a finite number, 0 or more")
    shape = MultiPolygon([free]) if isinstance(free, Polygon) else free
    if shape.is_empty or not shape.is_valid:
        raise MissionError("free space: an empty or invalid shape is not allowed; rings may not cross themselves")
    if shape.buffer(-body_radius_m).is_empty:
        raise MissionError(f"body_radius_m: {body_radius_m:.6g} m is not allowed; such a disc fits nowhere")
    rows: list[tuple[float, ...]] = []
    kinds: list[int] = []
    for polygon in shape.geoms:
        turned = shapely.orient_polygons(polygon)
        for ring in (turned.exterior, *turned.interiors):
            _add_ring(np.asarray(ring.coords)[:-1, :2], body_radius_m, rows, kinds)
    elements = np.array([(*row, 0.0) for row in rows], dtype=np.float64)
    elements[1:, 5] = np.cumsum(elements[:-1, 4])
    return Rim(free=shape, body_radius_m=body_radius_m, elements=elements, kinds=np.array(kinds, dtype=np.int64))


def _add_ring(corners: Floats, radius_m: float, rows: list[tuple[float, ...]], kinds: list[int]) -> None:
    """Append a ring's walls, and an arc after each wall that ends in a corner pointing into the free space."""
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    corners, sides, lengths = corners[lengths > TOUCH_M], sides[lengths > TOUCH_M], lengths[lengths > TOUCH_M]
    along = sides / lengths[:, None]
    for k in range(len(corners)):
        (ux, uy), (vx, vy) = along[k], along[(k + 1) % len(corners)]
        rows.append((*corners[k], ux, uy, lengths[k]))
        kinds.append(WALL)
        turn = math.atan2(ux * vy - uy * vx, ux * vx + uy * vy)
        if radius_m > 0 and turn < -_STRAIGHT_RAD:
            rows.append((*corners[(k + 1) % len(corners)], math.atan2(ux, -uy), 0.0, -turn * radius_m))
            kinds.append(ARC)


def bounce_path(
    rim: Rim, rule: BounceRule, start_m: tuple[float, float], heading_rad: float, bounces: int
) -> BouncePath:
    """The way of a disc from ``start_m``, x and y in metres, with ``heading_rad``, to contact number ``bounces``.

    A disc on the rim whose heading leads into what it touches turns first. Raises MissionError for a start at which the
    disc does not fit.
    """
    require_room(rim, np.array([start_m], dtype=np.float64))
    x, y = float(start_m[0]), float(start_m[1])
    heading, blocked = heading_rad, True
    for k in range(max(rule.turns_to_whole, 1)):
        heading = heading_rad + k * rule.angle_rad
        blocked = is_blocked(rim.compiled, x, y, math.cos(heading), math.sin(heading))
        if not blocked:
            break
    if blocked or bounces < 1:
        return BouncePath(positions_m=np.array([[x, y]]), headings_rad=np.empty(0), arcs_m=np.empty(0))
    e, s, _ = first_contact(rim.compiled, x, y, math.cos(heading), math.sin(heading))
    out = np.empty((bounces, 6))
    filled = follow(rim.compiled, rule.compiled, heading, e, s, 0, out)
    if filled == 0:
        out, filled = np.array([[e, s, 0, 0, 0, 0]], dtype=np.float64), 1
    element, s_m = out[:filled, 0].astype(np.int64), out[:filled, 1]
    return BouncePath(
        positions_m=np.vstack([[[x, y]], rim.places_m(element, s_m)]),
        headings_rad=np.concatenate([[heading], out[: filled - 1, 3]]) % (2 * math.pi),
        arcs_m=rim.arcs_m(element, s_m),
    )


def require_room(rim: Rim, places_m: Floats) -> None:
    """Raise MissionError for the first of places (k, 2) at which the disc does not fit."""
    points = shapely.points(places_m)
    inside = shapely.covers(rim.free, points)
    gaps_m = shapely.distance(rim.free.boundary, points)
    bad = np.flatnonzero(~inside & (gaps_m > TOUCH_M) | (gaps_m < rim.body_radius_m - TOUCH_M))
    if len(bad):
        point = Point(places_m[bad[0]])
        raise MissionError(
            f"start [{point.x:.9g}, {point.y:.9g}] is not allowed; a disc of radius {rim.body_radius_m:.6g} m must fit"
            " there in the free space"
        )
