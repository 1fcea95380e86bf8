"""Robots that surely serve all places by going round them, so that no proof can ask for more.

Statement. Robots that follow each other evenly on a closed way past all places, k of them on a way of k V T metres,
are at each place once in every T seconds. Where ways are straight, the way may pass each place where it is nearest.
"""

from __future__ import annotations

import math

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.model.mission import Robot
from rota.planners.patrol.bounds.witness_points import Witnesses
from rota.planners.patrol.tolerances import ROUNDING
from rota.planners.patrol.tours.visiting_order import short_order


def robots_on_rounds(witnesses: Witnesses, robot: Robot) -> float:
    """How many robots surely serve all places, each component's on a round of its own.

    Infinitely many where there is no way between places that may belong to one component.
    """
    component = witnesses.component
    parts = np.unique(component) if len(component) and component.min() >= 0 else [None]
    each = [witnesses if part is None else witnesses.choose(component == part) for part in parts]
    return sum(_robots_on_a_round(own, robot.ground_speed_m_s) for own in each)


def _robots_on_a_round(own: Witnesses, speed_m_s: float) -> float:
    """How many follow each other on one short way past all places."""
    if not len(own) or not np.isfinite([own.way_m, own.apart_m]).all():
        return math.inf
    order, xy_m = short_order(own.way_m), own.centre_m
    round_m = float(own.way_m[order, np.roll(order, -1)].sum())
    straight_m = np.hypot(*(xy_m[:, None] - xy_m[None]).transpose(2, 0, 1))
    if (own.way_m <= straight_m * (1 + ROUNDING) + ROUNDING).all():
        on_way_m = points_passed(own.choose(order))
        round_m = min(round_m, float(np.hypot(*(on_way_m - np.roll(on_way_m, -1, axis=0)).T).sum()))
    return max(1, math.ceil(round_m / (float(own.period_s.min()) * speed_m_s)))


def points_passed(places: Witnesses) -> Floats:
    """Points (n, 2) from which the places are served one after another, on a way that was made shorter."""
    xy_m, n = places.centre_m.copy(), len(places)
    for turn in range(60):  # more passes shorten a way by next to nothing
        which = np.arange(turn % 2, n, 2)
        before, after = xy_m[which - 1], xy_m[(which + 1) % n]
        along, centre = after - before, places.centre_m[which]
        square = (along**2).sum(axis=1)
        share = ((centre - before) * along).sum(axis=1) / np.where(square > 0, square, 1)
        xy_m[which] = points_within(places, which, before + np.clip(share, 0, 1)[:, None] * along)
    return xy_m


def points_within(places: Witnesses, which: Ints, xy_m: Floats) -> Floats:
    """Points (k, 2) led straight to the centres of the places ``which`` (k,) until they serve them."""
    centre, corners = places.centre_m[which], places.corners[which]
    off = xy_m - centre
    away = np.hypot(*off.T)
    least = np.minimum(places.range_m, places.spread_m)[which] / np.where(away > 0, away, 1)
    rank = np.arange(places.corner_m.shape[1])
    begin = places.corner_m[which]
    following = np.where(rank + 1 < corners[:, None], rank + 1, 0)
    side = np.take_along_axis(begin, following[..., None], axis=1) - begin
    # how far a point is to the left of each side of its polygon: at the centre, and how much less at the point
    inside = side[..., 0] * (centre[:, None, 1] - begin[..., 1]) - side[..., 1] * (centre[:, None, 0] - begin[..., 0])
    less = side[..., 1] * off[:, None, 0] - side[..., 0] * off[:, None, 1]
    leaves = (less > 0) & (rank < corners[:, None])
    shares = np.where(leaves, np.maximum(inside, 0) / np.where(leaves, less, 1), np.inf)
    share = np.minimum(np.minimum(least, shares.min(axis=1)), 1)
    within_m: Floats = centre + share[:, None] * off
    return within_m
