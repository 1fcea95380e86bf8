"""Which bodies touch in one run."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import shapely

from rota.check.tolerances import TOUCH_M
from rota.model.arrays import Floats
from rota.model.plan import Plan
from rota.model.trajectory import Trajectory
from rota.rehearsal import contact_kernels
from rota.rehearsal.contact_kernels import Legs, Track
from rota.rehearsal.kernels import Driven

Pair = tuple[int, int, float]


class Contact(NamedTuple):
    """That the bodies of two robots touch: who, when and where. stands: one of them had failed."""

    robots: tuple[int, int]
    time_s: float
    place_m: tuple[float, float]
    stands: bool


def pairs_near(plan: Plan) -> tuple[Pair, ...]:
    """The robots, two at a time, whose ways come so near that bodies can touch, and how far apart these must stay."""
    bodies_m = np.array([plan.mission.fleet.robot(way.robot).body_radius_m for way in plan])
    widest_m = float(np.sort(bodies_m)[-2:].sum()) - TOUCH_M
    if widest_m <= 0:
        return ()
    lines = np.array([_line(way) for way in plan])
    a, b = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=widest_m)
    a, b = a[a < b], b[a < b]
    apart_m = bodies_m[a] + bodies_m[b] - TOUCH_M
    near = (apart_m > 0) & shapely.dwithin(lines[a], lines[b], apart_m)
    return tuple(sorted(zip(a[near].tolist(), b[near].tolist(), apart_m[near].tolist(), strict=True)))


def contacts_of(plan: Plan, pairs: tuple[Pair, ...], driven: Driven, until_s: Floats | None = None) -> list[Contact]:
    """The first contact of each two robots while both drive, and the first when one of them stands since it failed.

    until_s: (k,) until when each robot drives this plan; None: to the end.
    """
    tracks = {robot: _track(plan.trajectories[robot], driven, robot) for pair in pairs for robot in pair[:2]}
    found = []
    for a, b, apart_m in pairs:
        begins_s = float(driven.times_s[[a, b], 0].max())
        ends_s = driven.end_s if until_s is None else min(float(until_s[[a, b]].min()), driven.end_s)
        fails_s = min(max(float(driven.fails_s[[a, b]].min()), begins_s), ends_s)
        for from_s, to_s, stands in ((begins_s, fails_s, False), (fails_s, ends_s, True)):
            time_s, x, y = contact_kernels.first_touch(tracks[a], tracks[b], apart_m, from_s, to_s)
            if math.isfinite(time_s):
                found.append(Contact((a, b), float(time_s), (float(x), float(y)), stands))
    return found


def _track(way: Trajectory, driven: Driven, robot: int) -> Track:
    """Where a robot is in a run."""
    places_m = np.zeros((len(way.times_s), 3))
    places_m[:, : way.positions_m.shape[1]] = way.positions_m
    docked = np.zeros(len(way.times_s) - 1, np.bool_)
    for charge in way.charges:
        docked |= (way.times_s[:-1] >= charge.from_s) & (way.times_s[1:] <= charge.until_s)
    legs = Legs(way.times_s.copy(), places_m, np.array(way.bends), docked, way.loop_index)
    rounds = 2 + int(driven.end_s / way.loop_duration_s) if way.loop_duration_s else 1
    room = driven.times_s.shape[1] + rounds * len(way.times_s) + 3
    track = Track(np.empty(room), np.empty((room, 3)), np.zeros((room, 3)), np.zeros(room, np.bool_))
    n = contact_kernels.lay_track(legs, driven, robot, track)
    return Track(track.times_s[:n], track.places_m[:n], track.bows_m[:n], track.docked[:n])


def _line(way: Trajectory) -> object:
    flat_m = way.positions_m[:, :2]
    moves = len(flat_m) > 1 and np.ptp(flat_m, axis=0).any()
    return shapely.linestrings(flat_m) if moves else shapely.points(flat_m[0])
