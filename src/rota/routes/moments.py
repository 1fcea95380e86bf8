"""A trajectory at a moment: what was driven until then, and what its robot would drive from then on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rota.model.arrays import Floats
from rota.model.mission import Sensor
from rota.model.plan import Charge, Driven, Trajectory
from rota.model.trajectory import bends_of, forward_accelerations
from rota.routes.route import Route, route_of

Way = tuple[Floats, Floats, Floats]

CUT_M = 1e-8  # by which a place that only cuts a leg may be off it
ALIKE = 1e-3  # of an acceleration by which two of one curve may differ
SOON_S = 1e-6  # stays on chargers that end so soon are over
STAY_S = 1.0  # told of a robot that is on a charger for ever
APART_S = 1e-9  # rows nearer to each other than this, and than a share as small of the time, are one
STAYED_S = 1e-12  # the same of rows between which a robot stays


def delay(trajectory: Trajectory, by_s: float) -> Trajectory:
    """The same driven so much later: its robot stands where it begins until then, on a charger if it begins there."""
    if by_s == 0:
        return trajectory
    changes = trajectory.accelerations_m_s2
    charges = [replace(one, from_s=one.from_s + by_s, until_s=one.until_s + by_s) for one in trajectory.charges]
    if charges and charges[0].from_s == by_s:  # by itself, since it is not flown again with the loop
        charges.insert(0, replace(charges[0], from_s=0.0, until_s=by_s))
    return replace(
        trajectory,
        times_s=np.append(0.0, trajectory.times_s + by_s),
        positions_m=np.vstack([trajectory.positions_m[:1], trajectory.positions_m]),
        headings_rad=None,
        accelerations_m_s2=None if changes is None else np.append(0.0, changes),
        loop_start_s=trajectory.loop_start_s + by_s,
        waypoints=None,
        charges=tuple(charges),
    )


def way_before(trajectory: Trajectory, sensor: Sensor, at_s: float, least_s: float, battery: float = 1.0) -> Driven:
    """What was driven in the ``least_s`` seconds before a moment, or since the beginning; times end with 0.

    battery: 0 to 1, how full it was when that begins.
    """
    at_s = _in_early_round(trajectory, at_s, least_s)
    from_s = max(0.0, at_s - least_s)
    times_s, places_m, changes = _rows(trajectory, from_s, at_s)
    times_s = times_s - at_s
    return Driven(
        robot=trajectory.robot,
        sensor=sensor,
        times_s=times_s,
        positions_m=places_m[:, :2],
        accelerations_m_s2=_forward(times_s, places_m, changes),
        charges=_charges(_stays(trajectory, from_s, at_s), times_s, -at_s),
        battery=battery,
    )


def earlier_by(driven: Driven, by_s: float) -> Driven:
    """The same driven so much earlier."""
    charges = tuple(replace(one, from_s=one.from_s - by_s, until_s=one.until_s - by_s) for one in driven.charges)
    return replace(driven, times_s=driven.times_s - by_s, charges=charges)


def join_ways(earlier: Driven | None, way: Driven, least_s: float) -> Driven:
    """What was driven in the last ``least_s`` seconds and a leg before, where it began in what was driven earlier.

    The way alone where it does not begin there, or with another sensor.
    """
    if earlier is None or earlier.times_s[-1] != way.times_s[0] or earlier.sensor != way.sensor:
        return way
    times_s, places_m, changes = without_cuts(
        (
            np.append(earlier.times_s[:-1], way.times_s),
            np.vstack([earlier.positions_m[:-1], way.positions_m]),
            np.concatenate([_changes_of(earlier), _changes_of(way)]),
        ),
        [len(earlier.times_s) - 1],
    )
    first = max(0, int(np.searchsorted(times_s, -least_s, side="right")) - 1)
    return replace(
        way,
        times_s=times_s[first:],
        positions_m=places_m[first:],
        accelerations_m_s2=changes[first:] if changes.any() else None,
        charges=_charges(
            [(one.charger, one.from_s, one.until_s) for one in (*earlier.charges, *way.charges)], times_s[first:], 0.0
        ),
        battery=earlier.battery,
    )


def _changes_of(way: Driven | Trajectory) -> Floats:
    """The accelerations of a way along its legs."""
    changes = way.accelerations_m_s2
    return np.zeros(len(way.times_s) - 1) if changes is None else changes


def go_on(trajectory: Trajectory, at_s: float, battery: float = 1.0) -> Trajectory:
    """What is driven from a moment on, whose clock begins there; the loop begins there if it has begun before.

    battery: 0 to 1, how full it is then.
    """
    loop_s, at_s = trajectory.loop_duration_s, _in_early_round(trajectory, at_s, 0.0)
    if at_s >= trajectory.loop_start_s and loop_s == 0:
        if _ends_docked(trajectory):
            charger = trajectory.charges[-1].charger
            return replace(
                trajectory, times_s=np.array([0.0, STAY_S]), positions_m=trajectory.positions_m[[-1, -1]],
                loop_start_s=STAY_S, headings_rad=None, accelerations_m_s2=None, waypoints=None,
                charges=(Charge(charger=charger, from_s=0.0, until_s=STAY_S),), battery=battery,
            )  # fmt: skip
        return replace(
            trajectory, times_s=np.zeros(1), positions_m=trajectory.positions_m[-1:], loop_start_s=0.0,
            headings_rad=None, accelerations_m_s2=None, waypoints=None, charges=(), battery=battery,
        )  # fmt: skip
    begins_s, soon_s = max(trajectory.loop_start_s, at_s), APART_S * max(1.0, at_s)
    if at_s < begins_s <= at_s + soon_s:  # later, so that no leg to there is hardly any
        begins_s = at_s + soon_s if loop_s == 0 else float(trajectory.times_s[trajectory.loop_index + 1])
    times_s, places_m, changes = _rows(trajectory, at_s, begins_s + loop_s)
    times_s = times_s - at_s
    if loop_s > 0:  # rounding must not open the loop
        times_s = np.append(times_s[:-1], begins_s - at_s + loop_s)
        first = int(np.argmin(np.abs(times_s - (begins_s - at_s))))
        times_s[first] = begins_s - at_s
        places_m[-1] = places_m[first]
    return replace(
        trajectory, times_s=times_s, positions_m=places_m, loop_start_s=begins_s - at_s, headings_rad=None,
        accelerations_m_s2=_forward(times_s, places_m, changes), waypoints=None, battery=battery,
        charges=_charges(_stays(trajectory, at_s, begins_s + loop_s), times_s, -at_s),
    )  # fmt: skip


def flight_after(trajectory: Trajectory, at_s: float) -> Trajectory | None:
    """The flight that a robot is on at a moment, or leaves its charger for: from there until it stays on a charger.

    Its clock is 0 at that moment. None: the robot is on a charger then. All that is driven from then on where the robot
    comes to no charger any more.
    """
    rest = go_on(trajectory, at_s)
    lands = min((one for one in rest.charges if one.until_s > SOON_S), key=lambda one: one.from_s, default=None)
    if lands is None:
        return rest
    if lands.from_s <= SOON_S:
        return None
    flown, ends_s = int(np.searchsorted(rest.times_s, lands.from_s)) + 1, lands.from_s + STAY_S
    changes = rest.accelerations_m_s2
    return replace(
        rest,
        times_s=np.append(rest.times_s[:flown], ends_s),
        positions_m=np.vstack([rest.positions_m[:flown], rest.positions_m[flown - 1 : flown]]),
        accelerations_m_s2=None if changes is None else np.append(changes[: flown - 1], 0.0),
        loop_start_s=ends_s,
        charges=(replace(lands, until_s=ends_s),),
    )


def route_after(trajectory: Trajectory, at_s: float, altitude_m: float) -> Route | None:
    """The route of ``flight_after``, at the fleet's altitude; None: the robot is on a charger then."""
    flight = flight_after(trajectory, at_s)
    return None if flight is None else route_of(flight, altitude_m)


def _ends_docked(trajectory: Trajectory) -> bool:
    """Whether a robot stays at a charger for ever."""
    charges = trajectory.charges
    return trajectory.loop_duration_s == 0 and bool(charges) and charges[-1].until_s == trajectory.times_s[-1]


def _stays(trajectory: Trajectory, from_s: float, to_s: float) -> list[tuple[str, float, float]]:
    """Stays at chargers between two moments: at which, from when and until when."""
    loop_s, stays = trajectory.loop_duration_s, list[tuple[str, float, float]]()
    first = 0 if loop_s == 0 else max(0, math.floor((from_s - trajectory.loop_start_s) / loop_s))
    last = 0 if loop_s == 0 else max(0, math.ceil((to_s - trajectory.loop_start_s) / loop_s))
    for turn in sorted({0, *range(first, last + 1)}):
        stays += [
            (one.charger, one.from_s + turn * loop_s, one.until_s + turn * loop_s)
            for one in trajectory.charges
            if turn == 0 or one.from_s >= trajectory.loop_start_s
        ]
    if _ends_docked(trajectory):
        stays[-1] = (stays[-1][0], stays[-1][1], max(stays[-1][2], to_s))
    return [(name, max(a, from_s), min(b, to_s)) for name, a, b in stays if a < to_s and b > from_s]


def _charges(stays: Sequence[tuple[str, float, float]], times_s: Floats, later_s: float) -> tuple[Charge, ...]:
    """The stays, told so much later, each from one of the times (n,) to another one; those that take none are not."""
    found = []
    for name, begin_s, end_s in stays:
        begin, end = (int(np.argmin(np.abs(times_s - later_s - moment_s))) for moment_s in (begin_s, end_s))
        if begin < end:
            found.append(Charge(charger=name, from_s=float(times_s[begin]), until_s=float(times_s[end])))
    return tuple(found)


def _forward(times_s: Floats, places_m: Floats, changes: Floats) -> Floats | None:
    """The accelerations along legs as rounding leaves them; None: none."""
    return forward_accelerations(times_s, places_m, changes) if changes.any() else None


def _in_early_round(trajectory: Trajectory, at_s: float, least_s: float) -> float:
    """The same moment of the first round before which as much is driven: times are rounded more in later ones."""
    loop_s, start_s = trajectory.loop_duration_s, trajectory.loop_start_s
    if loop_s == 0 or at_s < start_s:
        return at_s
    return min(at_s, start_s + math.fmod(at_s - start_s, loop_s) + math.ceil(least_s / loop_s) * loop_s)


def _rows(trajectory: Trajectory, from_s: float, to_s: float) -> tuple[Floats, Floats, Floats]:
    """Times (n,) from one moment to another, places (n, d) then, and accelerations (n - 1,) along the legs between.

    No leg that is driven is so short that rounding hides how fast; a stay beside it is where that would end or begin.
    """
    rows_s, rows_m, along = _rounds(trajectory, from_s, to_s)
    from_m, to_m = trajectory.at([from_s, to_s])
    soon, late = max(1.0, from_s), max(1.0, to_s)
    first = int(np.searchsorted(rows_s, from_s + APART_S * soon, side="right"))
    end = int(np.searchsorted(rows_s, to_s - APART_S * late))
    if 0 < first <= end and rows_s[first - 1] > from_s and (rows_m[first - 1] != from_m).any():
        stay = rows_m[first:end] == rows_m[first - 1]
        stays = int(np.logical_and.accumulate(stay.all(axis=1)).sum())
        rows_s[first : first + stays] -= rows_s[first - 1] - from_s
        rows_m[first : first + stays] = from_m
    if first <= end < len(rows_s) and rows_s[end] < to_s and (rows_m[end] != to_m).any():
        stay = rows_m[first:end][::-1] == rows_m[end]
        stays = int(np.logical_and.accumulate(stay.all(axis=1)).sum())
        rows_s[end - stays : end] += to_s - rows_s[end]
        rows_m[end - stays : end] = to_m
    after_s = soon * np.where((rows_m == from_m).all(axis=1), STAYED_S, APART_S)
    before_s = late * np.where((rows_m == to_m).all(axis=1), STAYED_S, APART_S)
    inside = (rows_s > from_s + after_s) & (rows_s < to_s - before_s)
    last = [to_s] if to_s > from_s else []
    kept_s = np.concatenate([[from_s], rows_s[inside], last])
    places_m = np.vstack([from_m, rows_m[inside], *([to_m] if last else [])])
    middle_s = (kept_s[1:] + kept_s[:-1]) / 2
    leg = np.clip(np.searchsorted(rows_s, middle_s, side="right") - 1, 0, max(0, len(along) - 1))
    after = middle_s > rows_s[-1]  # a robot that stays
    own = np.where(after, 0.0, along[leg]) if len(along) else np.zeros(len(kept_s) - 1)
    return kept_s, places_m, own


def _rounds(trajectory: Trajectory, from_s: float, to_s: float) -> tuple[Floats, Floats, Floats]:
    """The timed points (n,), (n, d) of all rounds that meet a span of time, and accelerations (n - 1,) between them.

    Without those at which rounds begin where these only cut a leg of a curve.
    """
    times_s, loop_s, index = trajectory.times_s, trajectory.loop_duration_s, trajectory.loop_index
    changes = _changes_of(trajectory)
    turns = 0 if loop_s == 0 else max(0, int(np.ceil((to_s - times_s[-1]) / loop_s)))
    skipped = 0 if loop_s == 0 else max(0, int(np.floor((from_s - trajectory.loop_start_s) / loop_s)))
    first = 0 if skipped == 0 else index
    rows, places, legs = [times_s[first:] + skipped * loop_s], [trajectory.positions_m[first:]], [changes[first:]]
    seams = list[int]()
    for turn in range(skipped + 1, turns + 1):
        seams.append(sum(map(len, rows)) - 1)
        rows.append(times_s[index + 1 :] + turn * loop_s)
        places.append(trajectory.positions_m[index + 1 :])
        legs.append(changes[index:])
    return without_cuts((np.concatenate(rows), np.concatenate(places), np.concatenate(legs)), seams)


def corner_times_s(trajectory: Trajectory, from_s: float, to_s: float) -> Floats:
    """The times (n,) in seconds between ``from_s`` and ``to_s`` at which a robot is at one of its timed points."""
    times_s, start_s, duration_s = trajectory.times_s, trajectory.loop_start_s, trajectory.loop_duration_s
    if duration_s > 0:
        rounds = np.arange(max(0, np.floor((from_s - start_s) / duration_s)), np.ceil((to_s - start_s) / duration_s))
        looped_s = times_s[trajectory.loop_index + 1 :] + rounds[:, None] * duration_s
        times_s = np.concatenate([times_s[: trajectory.loop_index + 1], looped_s.ravel()])
    return times_s[(times_s > from_s) & (times_s < to_s)]


def without_cuts(way: Way, points: Sequence[int]) -> Way:
    """A way without those of the points that cut a leg of a curve: times (n,), places (n, d), accelerations (n - 1,).

    A curve is told by tangents, and the jumps of velocity at both ends of one tell how it bends: a half has one of
    them. So such a point stays only where the way without it bends otherwise, as where a curve goes on in a straight.
    """
    cuts = [k for k in points if _cuts(way, k)]
    return np.delete(way[0], cuts), np.delete(way[1], cuts, axis=0), np.delete(way[2], cuts)


def _cuts(way: Way, k: int) -> bool:
    """Whether the k-th point cuts a leg of a curve that the leg before or behind belongs to as well."""
    first = max(0, k - 3)
    near = way[0][first : k + 4], way[1][first : k + 4], way[2][first : k + 3]
    k -= first
    if k < 2 or k > len(near[0]) - 3 or (near[1][k - 1 : k + 2] == near[1][k]).all(axis=1).sum() > 1:
        return False  # nothing tells, or a stay begins or ends there, maybe on a charger
    joined = np.delete(near[0], k), np.delete(near[1], k, axis=0), np.delete(near[2], k)
    (begin_s, at_s, end_s), (begin_m, at_m, end_m) = near[0][k - 1 : k + 2], near[1][k - 1 : k + 2]
    share = (at_s - begin_s) / (end_s - begin_s)
    along = share + bends_of(*joined)[k - 1] * share * (share - 1)
    if np.abs(begin_m + along * (end_m - begin_m) - at_m).max() > CUT_M:
        return False
    bent_m_s2 = _accelerations(*joined)
    whole, parts = bent_m_s2[k - 2], _accelerations(*near)[k - 2 : k]
    beside = [bent_m_s2[leg] for leg in (k - 3, k - 1) if 0 <= leg < len(bent_m_s2)]
    return any(_alike(whole, each) for each in beside) and not all(_alike(part, whole) for part in parts)


def _accelerations(times_s: Floats, places_m: Floats, changes_m_s2: Floats) -> Floats:
    """What all legs but the first and last are accelerated by (n - 3, d): the jumps at their ends count half."""
    lasts_s = np.diff(times_s)[:, None]
    mean_m_s = np.diff(places_m, axis=0) / lasts_s
    half_m_s = mean_m_s * bends_of(times_s, places_m, changes_m_s2)[:, None]
    at_m_s = (mean_m_s[:-1] + half_m_s[:-1] + mean_m_s[1:] - half_m_s[1:]) / 2
    return np.asarray(np.diff(at_m_s, axis=0) / lasts_s[1:-1])


def _alike(one: Floats, other: Floats) -> bool:
    """Whether two accelerations (d,) may be those of one curve."""
    return bool(np.abs(one - other).max() <= ALIKE * np.abs(other).max())
