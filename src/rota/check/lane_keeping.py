"""Whether robots keep to lanes: along them, the way they run, no faster, and from one to the next at their ends."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely

from rota.check.arrays import Flags, Floats, Ints
from rota.check.lane_kernels import first_jumps
from rota.check.motion import row_ahead
from rota.check.report import MOST_PER_ROBOT, Violation, violation
from rota.check.routes import lines_of
from rota.check.tolerances import FLOAT_EPS, SPEED_TOLERANCE, STILL_M, TOUCH_M
from rota.model.mission import Lane
from rota.model.plan import Plan, Trajectory


class _Pieces(NamedTuple):
    """The straight pieces (s, 4) of all lanes, the corners (s, 2) at their ends, and the lane (s,) of each.

    A corner is a number: lanes that end at one place have it in common, other corners are of one lane alone.
    """

    ends_m: Floats
    corners: Ints
    lane: Ints
    tree: shapely.STRtree


class _Ways(NamedTuple):
    """The pieces (c,) along which legs (c,) are driven, and the corners (c,) at which these begin and end; -1: none."""

    leg: Ints
    piece: Ints
    begins_at: Ints
    ends_at: Ints

    def where(self, kept: Flags) -> _Ways:
        """Those that are kept, (c,)."""
        return _Ways(*(values[kept] for values in self))


def lane_violations(plan: Plan) -> list[Violation]:
    """All legs that no lane allows, at most 20 of a kind for each robot; none where the mission has no lanes.

    A leg is driven along a straight piece of a lane, from which it is no farther than 1e-6 m: the way that a one-way
    lane runs, and no faster than the lane's length and least time allow, evenly over the lane. From one piece to the
    next a robot comes at a corner that both have; so it changes lanes at their ends only. A robot that stands may do so
    anywhere on a lane. The loop's last leg leads on to its first.
    """
    lanes = plan.mission.lanes
    if not lanes:
        return []
    pieces = _pieces_of(lanes)
    return [found for trajectory in plan for found in _robot_violations(plan, trajectory, pieces)]


def _pieces_of(lanes: tuple[Lane, ...]) -> _Pieces:
    """The pieces of all lanes, ready to be looked up."""
    places = [np.array(lane.line_m) for lane in lanes]
    ends_m = np.vstack([np.hstack([line_m[:-1], line_m[1:]]) for line_m in places])
    lane = np.repeat(np.arange(len(lanes)), [len(line_m) - 1 for line_m in places])
    corners = np.stack([np.arange(len(lane)), np.arange(len(lane)) + 1], axis=1) + lane[:, None]
    last = np.append(lane[1:] != lane[:-1], True)
    first = np.append(True, last[:-1])
    met_m = np.vstack([ends_m[first, :2], ends_m[last, 2:]])
    shared = np.unique(met_m, axis=0, return_inverse=True)[1].ravel() + int(corners.max()) + 1
    corners[first, 0], corners[last, 1] = np.split(shared, 2)
    return _Pieces(ends_m, corners, lane, shapely.STRtree(lines_of(ends_m)))


def _robot_violations(plan: Plan, trajectory: Trajectory, pieces: _Pieces) -> list[Violation]:
    """What is wrong with one robot's legs; legs of which one thing is wrong are not judged further."""
    xy, times_s = trajectory.positions_m[:, :2], trajectory.times_s
    if len(xy) == 1:
        xy, times_s = np.vstack([xy, xy]), np.append(times_s, times_s + 1.0)
    ways = _ways_along(pieces, xy)
    legs, found = len(xy) - 1, list[Violation]()

    def tell(kind: str, wrong: Ints, value: Floats, limit: Floats, unit: str) -> None:
        """A violation for each of the first legs."""
        for k in wrong[:MOST_PER_ROBOT].tolist():
            told = violation(kind, trajectory.robot, xy[k], float(times_s[k]), value[k], limit[k], unit)  # type: ignore[arg-type]
            found.append(told)

    off = np.flatnonzero(~np.isin(np.arange(legs), ways.leg))
    if len(off):
        away_m = np.zeros(legs)
        away_m[off] = _away_m(pieces, xy, off)
        tell("off the lanes", off, away_m, np.full(legs, TOUCH_M), "m")
    steps_m = np.diff(xy, axis=0)
    length_m, duration_s = np.hypot(*steps_m.T), np.diff(times_s)
    runs = _runs_along(pieces, ways, steps_m)
    one_way = np.array([lane.one_way for lane in plan.mission.lanes])[pieces.lane]
    right = ways.where(~one_way[ways.piece] | (runs > 0) | (length_m[ways.leg] <= STILL_M))
    against = np.setdiff1d(ways.leg, right.leg)
    tell("against a one-way lane", against, length_m, np.zeros(legs), "m")
    speed_m_s = _most_m_s(plan, trajectory.robot)[pieces.lane]
    bends = np.zeros(legs) if len(trajectory.bends) != legs else trajectory.bends
    fastest_m = length_m * (1 + np.abs(bends))
    noise_m = 4 * FLOAT_EPS * float(np.abs(xy).max()) + 2 * TOUCH_M
    grain_s = duration_s * (1 + SPEED_TOLERANCE) + 2 * FLOAT_EPS * times_s[1:]
    slow = right.where(fastest_m[right.leg] <= speed_m_s[right.piece] * grain_s[right.leg] + noise_m)
    fast = np.setdiff1d(right.leg, slow.leg)
    most_m_s = np.zeros(legs)
    np.maximum.at(most_m_s, right.leg, speed_m_s[right.piece])
    tell("faster than its lane", fast, fastest_m / duration_s, most_m_s, "m/s")
    if not found:  # what single legs may be too fast does not add up, but for how far off corners may be
        at_corner = np.isin(np.arange(legs), right.leg[(right.begins_at >= 0) | (right.ends_at >= 0)])
        ahead_m = length_m - most_m_s * duration_s * (1 + SPEED_TOLERANCE) - np.where(at_corner, noise_m, 0.0)
        for k, end in row_ahead(ahead_m, np.maximum(most_m_s * 2 * FLOAT_EPS * times_s[1:], noise_m)):
            mean_m_s = np.full(legs, length_m[k:end].sum() / duration_s[k:end].sum())
            tell("faster than its lane", np.array([k]), mean_m_s, most_m_s, "m/s")
    if len(slow.leg) and not found:
        tell("leaves a lane between its ends", *_jumps(trajectory, slow, legs), "ways")
    return found


def _ways_along(pieces: _Pieces, xy: Floats) -> _Ways:
    """All pairs of a leg between places (n, 2) and a piece on which both of its ends lie, by leg."""
    at, on = pieces.tree.query(shapely.points(xy), predicate="dwithin", distance=TOUCH_M)
    count = len(pieces.ends_m)
    keys = np.sort(at * count + on)
    both = keys[np.isin(keys + count, keys) & (keys // count < len(xy) - 1)]
    leg, piece = both // count, both % count
    return _Ways(leg, piece, _corner_at(pieces, piece, xy[leg]), _corner_at(pieces, piece, xy[leg + 1]))


def _corner_at(pieces: _Pieces, piece: Ints, places_m: Floats) -> Ints:
    """The corner (c,) of a piece (c,) that is at a place (c, 2); -1 where none is."""
    corner = np.full(len(piece), -1)
    for end, columns in enumerate((slice(0, 2), slice(2, 4))):
        near = np.hypot(*(pieces.ends_m[piece, columns] - places_m).T) <= 2 * TOUCH_M
        corner[near] = pieces.corners[piece[near], end]
    return corner


def _runs_along(pieces: _Pieces, ways: _Ways, steps_m: Floats) -> Floats:
    """By how much (c,) each leg leads along its piece, from the piece's first end to its last."""
    along = pieces.ends_m[ways.piece, 2:] - pieces.ends_m[ways.piece, :2]
    return np.asarray((along * steps_m[ways.leg]).sum(axis=1))


def _most_m_s(plan: Plan, name: str) -> Floats:
    """How fast a robot may drive along each lane, worked out here anew: planners have it from the model."""
    lanes, speed_m_s = plan.mission.lanes, plan.mission.fleet.robot(name).speed_m_s
    drawn_m = np.array([np.hypot(*np.diff(np.array(lane.line_m), axis=0).T).sum() for lane in lanes])
    length_m = np.array([np.nan if lane.length_m is None else lane.length_m for lane in lanes])
    least_s = np.array([0.0 if lane.least_s is None else lane.least_s for lane in lanes])
    return np.asarray(drawn_m / np.maximum(np.fmax(length_m, drawn_m) / speed_m_s, least_s))


def _away_m(pieces: _Pieces, xy: Floats, legs: Ints) -> Floats:
    """How far the farther end of each leg (k,) is from the nearest lane; 0 where both are on lanes, not on one."""
    lines = lines_of(pieces.ends_m)
    away_m = np.zeros(len(legs))
    for ends in (xy[legs], xy[legs + 1]):
        _, nearest = pieces.tree.query_nearest(shapely.points(ends), all_matches=False)
        away_m = np.maximum(away_m, shapely.distance(lines[nearest], shapely.points(ends)))
    return away_m


def _jumps(trajectory: Trajectory, ways: _Ways, legs: int) -> tuple[Ints, Floats, Floats]:
    """The legs to which no lane leads from the leg before; ways that do, none; and ways that are needed, one."""
    first = np.searchsorted(ways.leg, np.arange(legs + 1))
    loop = np.arange(trajectory.loop_index, legs) if trajectory.loop_duration_s > 0 else np.arange(0)
    order = np.concatenate([np.arange(legs), loop])
    jumps = first_jumps(first, ways.piece, ways.begins_at, ways.ends_at, order)
    return np.unique(order[np.flatnonzero(jumps)]), np.zeros(legs), np.ones(legs)
