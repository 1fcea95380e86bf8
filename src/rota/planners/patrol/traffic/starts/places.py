"""Robots spread over a box: apart by more than their bodies, inside the standing space, the same every time."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from rota.model.arrays import Floats
from rota.model.mission import StartBox
from rota.planners.patrol.tolerances import TO_SPARE

MOST_CANDIDATES = 4_000  # places that are looked at together


def spread_in_box(
    box: StartBox, part: Polygon, robots: int, body_radius_m: float, taken_m: Floats | None = None
) -> Floats:
    """Places (n, 2) in metres for robots in the box and in this part of the standing space; fewer: no room.

    taken_m: (k, 2) places to keep away from as from each other, more than two body radii. Each robot in turn gets the
    place farthest from those before it; when that wastes too much room, they are packed row by row.
    """
    ground = shapely.box(*box.low_m, *box.high_m).intersection(part)
    places = candidates(ground, body_radius_m)
    barred = np.zeros((0, 2)) if taken_m is None else taken_m
    apart_m = 2 * body_radius_m * (1 + TO_SPARE)
    if not len(places) or robots == 0:
        return np.zeros((0, 2))
    spread = farthest_first(places, barred, robots, apart_m)
    return spread if len(spread) == robots else pack(places, barred, robots, apart_m)


def candidates(ground: BaseGeometry, body_radius_m: float) -> Floats:
    """A lattice of places (n, 2) in some ground, borders included, row by row; never none when the ground has any."""
    if ground.is_empty:
        return np.zeros((0, 2))
    x0, y0, x1, y1 = ground.bounds
    wide, high = x1 - x0, y1 - y0
    longest = max(wide, high)
    step = max(math.sqrt(wide * high / MOST_CANDIDATES), longest / MOST_CANDIDATES)
    if body_radius_m > 0:
        # rows two bodies apart must be among them, or a full box is packed badly
        pitch = 2 * body_radius_m * (1 + TO_SPARE)
        step = max(pitch / math.ceil(pitch / step), pitch / 8) if step < pitch else pitch
    if step == 0:
        return np.array([[x0, y0]])
    x = np.append(np.arange(x0, x1, step), x1)
    y = np.append(np.arange(y0, y1, step), y1)
    lattice = np.column_stack([axis.ravel() for axis in np.meshgrid(x, y)])
    inside = lattice[shapely.intersects_xy(ground, *lattice.T)]
    points = [shapely.get_coordinates(shapely.point_on_surface(piece)) for piece in shapely.get_parts(ground)]
    middle = shapely.get_coordinates(ground.centroid)
    points += [middle[shapely.intersects_xy(ground, *middle.T)]]
    return np.unique(np.vstack([inside, *points])[:, ::-1], axis=0)[:, ::-1]


def farthest_first(places_m: Floats, barred_m: Floats, robots: int, apart_m: float) -> Floats:
    """Places (n, 2), the first in the middle and each next one farthest from all before; fewer than asked: too near."""
    room = np.full(len(places_m), np.inf)
    for barred in barred_m:
        room = np.minimum(room, np.hypot(*(places_m - barred).T))
    middle = np.hypot(*(places_m - (places_m.min(axis=0) + places_m.max(axis=0)) / 2).T)
    chosen: list[int] = []
    for _ in range(robots):
        k = int(np.argmax(room)) if chosen or len(barred_m) else int(np.argmin(middle))
        if room[k] <= apart_m:
            break
        chosen.append(k)
        room = np.minimum(room, np.hypot(*(places_m - places_m[k]).T))
    return places_m[chosen]


def pack(places_m: Floats, barred_m: Floats, robots: int, apart_m: float) -> Floats:
    """Places (n, 2), in their order each one that is apart from all before."""
    chosen: list[Floats] = []
    others = [*barred_m]
    for place in places_m:
        if len(chosen) == robots:
            break
        if not others or bool((np.hypot(*(np.array(others) - place).T) >= apart_m).all()):
            chosen.append(place)
            others.append(place)
    return np.array(chosen).reshape(-1, 2)


def in_turn(
    box: StartBox, parts: Sequence[Polygon], robots: Sequence[int], body_radius_m: float, taken_m: Floats
) -> list[Floats]:
    """The places (n, 2) in each part for the robots (their number) in it; fewer where the box has no more room.

    taken_m: (k, 2), where robots stand already.
    """
    each: list[Floats] = []
    taken = taken_m
    for part, count in zip(parts, robots, strict=True):
        each.append(spread_in_box(box, part, count, body_radius_m, taken))
        taken = np.vstack([taken, each[-1]])
    return each
