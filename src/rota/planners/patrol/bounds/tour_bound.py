"""Robots at least, since no fewer can pass all places in time about a moment at which some of them are served.

Statement. Let m places have periods T_i. There is a moment t about which each of them is served within
t -+ (1 - 1/m) T_i / 2. And every place p is served in [t - T_p, t], in [t - T_p / 2, t + T_p / 2] and in [t, t + T_p].
If k robots cannot do all that, whatever they do in which order, the team has at least k + 1 robots.

Proof. Place i is served at moments that are g <= T_i apart. Between two of them g - (1 - 1/m) T_i seconds at most, a
share 1/m of g, are farther than (1 - 1/m) T_i / 2 from both. If that were a share of less than 1/m for some place,
the m shares would not make up all time, and a moment is left: windows count as longer by a millionth. With m = 1 it is
any at which the place is served. The rest is what the periods ask for. ``tour_kernels`` looks at all orders, or proves
of some of the places in them that no robot passes them in time.

What it is for. A window alone is easily met, for each robot may drive an open path. With m = 1 one robot is in the
middle of its window, and comes no farther than half a window's travel to either side: on a line that is half as long as
it is for ever. With m places on a ring of length L, one robot drives (1 - 1/m) L within the windows of these places, so
that it needs L for ever. The windows before and after bind what robots do before and after that.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.model.mission import Robot
from rota.planners.patrol.bounds.length_kernels import Tasks
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.bounds.tour_kernels import search_orders
from rota.planners.patrol.bounds.witness_points import Witnesses
from rota.planners.patrol.cycles.deadline_kernels import Outcome
from rota.planners.patrol.tolerances import ROUNDING, SURELY
from rota.planners.patrol.tours.visiting_order import short_order
from rota.planners.patrol.verdict import robots_in_words

MOST_ROBOTS = 8


def tour_bound(
    witnesses: Witnesses, robot: Robot, least: int, most_states: int, should_stop: Callable[[], bool] = lambda: False
) -> ProvedBound:
    """The bound for the witnesses, from ``least`` on, which is known; what is proved so far once ``should_stop``.

    most_states: that are looked at of the orders about a moment, a fifth where several places tell when it is. Most
    proofs take five, so that each is tried with few first. Teams of more than MOST_ROBOTS have too many orders, and are
    not asked about; nor are those that surely do.
    """
    robots, most = least, min(MOST_ROBOTS + 1.0, robots_on_rounds(witnesses, robot))
    moments = list(moments_of(witnesses, robot.ground_speed_m_s)) if robots < most else []
    while robots < most and cannot_do(robots, moments, most_states, should_stop):
        robots += 1
    return ProvedBound(
        robots=robots,
        reason=f"about some moment {robots_in_words(robots - 1)} cannot pass all of {len(witnesses)} places in time",
    )


def cannot_do(robots: int, moments: list[tuple[int, Tasks]], most_states: int, should_stop: Callable[[], bool]) -> bool:
    """Whether so many robots surely cannot do all tasks about one of the moments; not proved once ``should_stop``."""
    for share, most_places in ((5, 3), (1, 1)):
        for places, tasks in moments:
            if should_stop():
                return False
            first = len(tasks.place) - places
            if places <= most_places and search_orders(robots, first, tasks, most_states // share) == Outcome.NONE:
                return True
    return False


def moments_of(witnesses: Witnesses, speed_m_s: float) -> Iterator[tuple[int, Tasks]]:
    """Moments told by one, two or three places far from each other; how many, and the tasks about the moment 0."""
    for place in spread_out(witnesses.centre_m, 24):  # more proved next to nothing
        group = spread_out(witnesses.centre_m, 3, int(place))
        for count in range(1, len(group) + 1):
            yield count, tasks_about(witnesses, speed_m_s, group[:count])


def tasks_about(witnesses: Witnesses, speed_m_s: float, group: Ints) -> Tasks:
    """What is to be done about the moment 0 that these places (m,) tell; their windows about it stand last."""
    travel_m, n = witnesses.period_s * speed_m_s * SURELY, len(witnesses)
    near_m = (1 - 1 / len(group)) / 2 * travel_m[group]
    return Tasks(
        place=np.concatenate([np.tile(np.arange(n), 3), group]),
        opens_m=np.concatenate([-travel_m / 2, -travel_m, np.zeros(n), -near_m]),
        closes_m=np.concatenate([travel_m / 2, np.zeros(n), travel_m, near_m]),
        centre_m=witnesses.centre_m,
        radius_m=witnesses.range_m,
        corners=witnesses.corners,
        corner_m=witnesses.corner_m,
        apart_m=witnesses.apart_m,
    )


def spread_out(xy_m: Floats, most: int, first: int | None = None) -> Ints:
    """``most`` of the points (n, 2): each as far as can be from those before, the first (None) from the middle."""
    order = np.zeros(min(most, len(xy_m)), dtype=np.int64)
    away = np.hypot(*(xy_m - (xy_m.mean(axis=0) if first is None else xy_m[first])).T) if len(xy_m) else np.zeros(0)
    for k in range(len(order)):
        order[k] = int(np.argmax(away)) if k > 0 or first is None else first
        from_it = np.hypot(*(xy_m - xy_m[order[k]]).T)
        away = from_it if k == 0 else np.minimum(away, from_it)
    return order


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
