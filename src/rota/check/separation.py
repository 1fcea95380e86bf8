"""Whether bodies touch: the closest approach of any two legs that two robots are ever on at once, exactly.

Bodies are balls where both robots have heights, so that one may pass above another. Where one has none, nothing is
known of that, and both are judged as if they were at one height.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rota.check.approach import gaps_at, nearest_shares
from rota.check.arrays import Flags, Floats, Ints
from rota.check.charging import undocked_routes
from rota.check.distances import segment_distances
from rota.check.near_legs import near_legs
from rota.check.report import APART, Violation, violation
from rota.check.routes import HOLD, LOOP, TRANSIENT, Routes, routes_of
from rota.check.tolerances import SAME_TURN, TOUCH_M
from rota.model.plan import Plan

BOUNCING_CELLS = 1e-3  # that a bouncing robot's body is wide at least, as a radius
MOST_MEETINGS = 5_000_000  # of legs in one phase; of pairs with more every phase is taken to occur, on the safe side
CHUNK = 1_000_000


class _Way(NamedTuple):
    """Where n robots are first and last, and how far their ways bend in time; (n, 3) each, see ``nearest_shares``."""

    begin: Floats
    end: Floats
    bow: Floats


@dataclass
class _Closest:
    """The closest approach of two robots: metres, place, and time in seconds; None: at some time in the loops."""

    distance_m: float
    place_m: tuple[float, float]
    time_s: float | None


def separation_violations(plan: Plan) -> list[Violation]:
    """Pairs of robots whose bodies overlap by more than 1e-6 m at some time, each at its closest approach.

    Before the loops robots are compared by time. In the loops they are compared in every phase that occurs: shifts by
    multiples of the periods' common measure, or all shifts where there is none. ``time_s`` None: at some time in the
    loops. Bouncing robots count as a thousandth of a cell wide at least, so that no two are in one place.
    """
    routes = undocked_routes(routes_of(plan), plan)
    bodies = np.array([plan.mission.fleet.robot(trajectory.robot).body_radius_m for trajectory in plan])
    rules = plan.mission.planning.bouncing
    if rules is not None:
        # no two of them are in one cell: even points would have bumped into each other (without cells: 0 m)
        bodies = np.maximum(bodies, BOUNCING_CELLS * rules.cell_m)
    if len(bodies) < 2 or np.sort(bodies)[-2:].sum() <= TOUCH_M:
        return []
    closest: dict[tuple[int, int], _Closest] = {}
    for a, b in near_legs(routes, bodies):
        for k in range(0, len(a), CHUNK):
            _note_pairs(closest, routes, bodies, a[k : k + CHUNK], b[k : k + CHUNK])
    violations = []
    for (i, j), close in sorted(closest.items()):
        who, limit_m = f"{plan.trajectories[i].robot}, {plan.trajectories[j].robot}", bodies[i] + bodies[j]
        violations.append(violation("bodies touch", who, close.place_m, close.time_s, close.distance_m, limit_m, APART))
    return violations


def _note_pairs(closest: dict[tuple[int, int], _Closest], routes: Routes, bodies: Floats, a: Ints, b: Ints) -> None:
    """Look at all times at which the robots are on the legs a and b (n,) together."""
    kind_a, kind_b = routes.kinds[a], routes.kinds[b]
    both = (kind_a == LOOP) & (kind_b == LOOP)
    same = routes.classes[routes.robots[a]] == routes.classes[routes.robots[b]]
    free = (both & ~same) | ((kind_a == HOLD) & (kind_b != TRANSIENT)) | ((kind_b == HOLD) & (kind_a != TRANSIENT))
    step = np.zeros(len(a))
    parts = np.gcd(routes.parts[routes.robots[a]], routes.parts[routes.robots[b]])
    step[both & same] = (parts * routes.units_s[routes.classes[routes.robots[a]]])[both & same]
    # a leg of the loop comes back every turn; it meets a leg before the loop in the turns that overlap it
    once = ~both & ~free
    step[once & (kind_a == LOOP)] = -routes.durations_s[routes.robots[a]][once & (kind_a == LOOP)]
    step[once & (kind_b == LOOP)] = routes.durations_s[routes.robots[b]][once & (kind_b == LOOP)]
    low, high = _shift_range(routes, a, b, step, both)
    count = np.where(free, 0, np.maximum(high - low + 1, 0))
    order = np.argsort(count, kind="stable")
    dense = np.zeros(len(a), np.bool_)
    dense[order[np.cumsum(count[order]) > MOST_MEETINGS]] = True
    free, count = free | dense, np.where(dense, 0, count)
    pair = np.repeat(np.arange(len(a)), count.astype(np.int64))
    turn = np.arange(len(pair)) - np.repeat(np.cumsum(count) - count, count.astype(np.int64)) + low[pair]
    shift = turn * step[pair]
    for k in range(0, len(pair), CHUNK):
        chosen = pair[k : k + CHUNK]
        _note_meetings(closest, routes, bodies, a[chosen], b[chosen], shift[k : k + CHUNK], both[chosen])
    _note_any_phase(closest, routes, bodies, a[free], b[free])


def _shift_range(routes: Routes, a: Ints, b: Ints, step: Floats, both: Flags) -> tuple[Floats, Floats]:
    """First and last multiple of ``step`` by which the time of b must be shifted to overlap a; 0, 0 where step is 0."""
    (a0, a1), (b0, b1) = routes.times_s[a].T, routes.times_s[b].T.copy()
    a1 = np.where(routes.kinds[a] == HOLD, np.inf, a1)
    b1 = np.where(routes.kinds[b] == HOLD, np.inf, b1)
    size = np.where(step == 0, 1.0, np.abs(step))
    with np.errstate(invalid="ignore"):
        begin, end = (a0 - b1) / np.where(step < 0, -size, size), (a1 - b0) / np.where(step < 0, -size, size)
    low, high = np.ceil(np.minimum(begin, end) - SAME_TURN), np.floor(np.maximum(begin, end) + SAME_TURN)
    low = np.where(both, low, np.maximum(low, 0.0))
    return np.where(step == 0, 0.0, low), np.where(step == 0, 0.0, high)


def _note_meetings(
    closest: dict[tuple[int, int], _Closest],
    routes: Routes,
    bodies: Floats,
    a: Ints,
    b: Ints,
    shift_s: Floats,
    in_loops: Flags,
) -> None:
    """Closest approach while a robot is on leg a and the other on leg b, whose times are ``shift_s`` later."""
    start = np.maximum(routes.times_s[a, 0], routes.times_s[b, 0] + shift_s)
    end_a = np.where(routes.kinds[a] == HOLD, np.inf, routes.times_s[a, 1])
    end_b = np.where(routes.kinds[b] == HOLD, np.inf, routes.times_s[b, 1])
    end = np.minimum(end_a, end_b + shift_s)
    meet = (end >= start) & np.isfinite(start)
    a, b, start, end, shift_s, in_loops = a[meet], b[meet], start[meet], end[meet], shift_s[meet], in_loops[meet]
    end = np.where(np.isfinite(end), end, start)
    way_a, way_b = _way(routes, a, start, end), _way(routes, b, start - shift_s, end - shift_s)
    # the gap goes from what it is first to what it is last, along a line where both move evenly
    gap, last = np.nan_to_num(way_b.begin - way_a.begin), np.nan_to_num(way_b.end - way_a.end)
    bow = np.nan_to_num(way_b.bow - way_a.bow) if routes.bends.any() else np.zeros_like(gap)
    share = nearest_shares(gap, last - gap, bow)
    nearest = gaps_at(gap, last - gap, bow, share)
    distance = np.sqrt((nearest**2).sum(axis=1))
    allowed = bodies[routes.robots[a]] + bodies[routes.robots[b]] - TOUCH_M
    for k in _worst_of_pairs(routes, a, b, distance, distance < allowed):
        time = float(start[k] + share[k] * (end[k] - start[k]))
        begin, along, bent = way_a.begin[[k]], way_a.end[[k]] - way_a.begin[[k]], way_a.bow[[k]]
        place = gaps_at(begin, along, bent, share[[k]])[0]
        middle = (place + nearest[k] / 2)[:2]
        # turns of a are counted by shifting b backwards
        absolute: float | None = time - min(float(shift_s[k]), 0.0)
        if in_loops[k]:
            absolute = _absolute_time(routes, int(a[k]), int(b[k]), time, float(shift_s[k]))
        _note(closest, routes, a[k], b[k], float(distance[k]), middle, absolute)


def _way(routes: Routes, legs: Ints, from_s: Floats, to_s: Floats) -> _Way:
    """What robots do on legs (n,) between two times (n,); a leg of no duration stands still."""
    start, length, bends = routes.times_s[legs, 0], np.diff(routes.times_s[legs], axis=1)[:, 0], routes.bends[legs]
    begin, end = _ends(routes, legs)
    # as a share of the leg, since no speed tells anything of a leg that lasts next to no time
    long = np.where(length > 0, length, 1.0)
    first, last = (np.clip((time_s - start) / long, 0.0, 1.0) * (length > 0) for time_s in (from_s, to_s))
    if not bends.any():
        from_m, to_m = (begin + share[:, None] * (end - begin) for share in (first, last))
        return _Way(from_m, to_m, np.zeros_like(begin))
    from_m, to_m = (begin + (share + bends * share * (share - 1))[:, None] * (end - begin) for share in (first, last))
    return _Way(from_m, to_m, (bends * (last - first) ** 2)[:, None] * (end - begin))


def _ends(routes: Routes, legs: Ints) -> tuple[Floats, Floats]:
    """Both ends (n, 3) of legs; heights are nan where there are none."""
    flat, heights = routes.legs_m[legs], routes.heights_m[legs]
    return np.column_stack([flat[:, :2], heights[:, 0]]), np.column_stack([flat[:, 2:], heights[:, 1]])


def _line_distances(routes: Routes, a: Ints, b: Ints) -> tuple[Floats, Floats]:
    """Distance of the legs a and b (n,) as lines, and where along a it is reached, in 0..1."""
    p, p_end = _ends(routes, a)
    q, q_end = _ends(routes, b)
    if np.isnan(p[:, 2] + q[:, 2]).all():
        return segment_distances(routes.legs_m[a], routes.legs_m[b])
    unknown = np.isnan(p[:, 2] + q[:, 2])
    for end in (p, p_end, q, q_end):
        end[unknown, 2] = 0.0
    d, e, w = p_end - p, q_end - q, q - p
    dd, de, ee, dw, ew = ((u * v).sum(axis=1) for u, v in ((d, d), (d, e), (e, e), (d, w), (e, w)))
    best, where = np.full(len(a), np.inf), np.zeros(len(a))

    def note(u: Floats, v: Floats) -> None:
        distance = np.sqrt(((w + v[:, None] * e - u[:, None] * d) ** 2).sum(axis=1))
        where[:] = np.where(distance < best, u, where)
        best[:] = np.minimum(distance, best)

    # nearest to each of the four ends, and within both lines where they are askew
    some_d, some_e, ends = np.where(dd > 0, dd, 1.0), np.where(ee > 0, ee, 1.0), (np.zeros(len(a)), np.ones(len(a)))
    for end in ends:
        note(end, np.clip((end * de - ew) / some_e, 0.0, 1.0))
        note(np.clip((end * de + dw) / some_d, 0.0, 1.0), end)
    askew = dd * ee - de * de
    ok = askew > 0
    u = np.clip(np.where(ok, (dw * ee - de * ew) / np.where(ok, askew, 1.0), 0.0), 0.0, 1.0)
    note(u, np.clip((u * de - ew) / some_e, 0.0, 1.0))
    return best, where


def _absolute_time(routes: Routes, a: int, b: int, time_s: float, shift_s: float) -> float | None:
    """A time at which both robots are in their loops and in that phase; None when it is far beyond their first turn."""
    period_a, period_b = routes.durations_s[routes.robots[[a, b]]]
    unit = routes.units_s[routes.classes[routes.robots[a]]]
    turns = int(routes.parts[routes.robots[b]]) // math.gcd(
        int(routes.parts[routes.robots[a]]), int(routes.parts[routes.robots[b]])
    )
    for k in range(min(turns, 10_000)):
        # after k turns of a, b must have done a whole number of turns more or less than the shift says
        turns_b = (k * period_a + shift_s) / period_b
        if abs(turns_b - round(turns_b)) * period_b <= 1e-3 * unit:
            common = turns * period_a
            time = time_s + k * period_a
            return float(time + max(0.0, math.ceil((routes.from_s - time) / common) * common))
    return None


def _note_any_phase(closest: dict[tuple[int, int], _Closest], routes: Routes, bodies: Floats, a: Ints, b: Ints) -> None:
    """Legs that are met in every phase: as close as their lines."""
    distance, along = _line_distances(routes, a, b)
    allowed = bodies[routes.robots[a]] + bodies[routes.robots[b]] - TOUCH_M
    for k in _worst_of_pairs(routes, a, b, distance, distance < allowed):
        leg = routes.legs_m[a[k]]
        place = leg[:2] + along[k] * (leg[2:] - leg[:2])
        _note(closest, routes, a[k], b[k], float(distance[k]), place, None)


def _worst_of_pairs(routes: Routes, a: Ints, b: Ints, distance: Floats, chosen: Flags) -> Ints:
    """For each pair of robots the index of its smallest distance among the chosen."""
    index = np.flatnonzero(chosen)
    order = index[np.argsort(distance[index], kind="stable")]
    pair = routes.robots[a[order]] * len(routes.durations_s) + routes.robots[b[order]]
    return np.asarray(order[np.unique(pair, return_index=True)[1]])


def _note(
    closest: dict[tuple[int, int], _Closest],
    routes: Routes,
    a: int,
    b: int,
    distance_m: float,
    place_m: Floats,
    time_s: float | None,
) -> None:
    """Keep this distance, place and time of legs a and b where it is the least so far of their two robots."""
    pair = (int(routes.robots[a]), int(routes.robots[b]))
    if pair not in closest or distance_m < closest[pair].distance_m:
        closest[pair] = _Closest(distance_m, (float(place_m[0]), float(place_m[1])), time_s)
