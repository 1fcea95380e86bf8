"""Plan -> where each robot is and where it faces, at its timed points and often enough in between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rota.errors import PlanError
from rota.files.ros.names import namespaces
from rota.model.plan import Floats, Plan, Trajectory
from rota.routes.constant_speeds import at_constant_speeds, plan_at_constant_speeds
from rota.routes.moments import corner_times_s

USUAL_STEP_S = 0.1
MOST_BETWEEN = 50_000  # poses of a whole plan that are not at timed points: beyond that steps are longer

MOST_POINTS = 2_000_000  # timed points of all robots in all rounds


@dataclass(frozen=True, kw_only=True)
class Track:
    """A robot's poses at times_s (n,), rising: positions_m (n, 3), yaws_rad (n,) from x towards y.

    Heights are 0 where the plan has none: the plane of the map.
    """

    namespace: str
    times_s: Floats
    positions_m: Floats
    yaws_rad: Floats
    still: bool = False


class Motion:
    """A trajectory made ready to be asked for poses, of an endless time. ``still``: it neither moves nor turns.

    Between timed points it turns the shorter way. Without headings it faces the way it goes; while it waits, the way
    it came; and 0 where it never moves.
    """

    def __init__(self, trajectory: Trajectory) -> None:
        self._trajectory = trajectory = at_constant_speeds(trajectory)
        given = trajectory.headings_rad
        self._turns = given is not None
        self._yaws = _ways_rad(trajectory.positions_m) if given is None else np.unwrap(given)
        points = trajectory.positions_m
        self.still = bool((points == points[0]).all() and (self._yaws == self._yaws[0]).all())

    def at(self, times_s: Floats) -> tuple[Floats, Floats]:
        """Positions (n, 3) in metres and yaws (n,) in radians at ``times_s`` (n,) from 0 on."""
        trajectory = self._trajectory
        known_s, start_s, duration_s = trajectory.times_s, trajectory.loop_start_s, trajectory.loop_duration_s
        times_s = np.asarray(times_s, np.float64)
        if duration_s > 0:
            times_s = np.where(times_s > known_s[-1], start_s + np.mod(times_s - start_s, duration_s), times_s)
        positions = np.zeros((len(times_s), 3))
        positions[:, : trajectory.positions_m.shape[1]] = trajectory.at(times_s)
        if self._turns:
            return positions, np.interp(times_s, known_s, self._yaws)
        return positions, self._yaws[np.searchsorted(known_s, times_s, side="right") - 1]

    def track(self, namespace: str, times_s: Floats) -> Track:
        """The poses at ``times_s`` (n,)."""
        positions_m, yaws_rad = self.at(times_s)
        return Track(namespace=namespace, times_s=times_s, positions_m=positions_m, yaws_rad=yaws_rad, still=self.still)


def own_tracks(plan: Plan) -> list[Track]:
    """Each robot's timed points: its approach and one round of its loop."""
    return [
        Motion(trajectory).track(namespace, trajectory.times_s)
        for trajectory, namespace in zip(plan_at_constant_speeds(plan), namespaces(plan), strict=True)
    ]


def sampled_tracks(plan: Plan, span_s: float) -> list[Track]:
    """Each robot's poses from 0 to ``span_s``, in as many rounds as that takes: its timed points, and steps between.

    A step is at most 0.1 s, or longer so that there are at most 50,000 poses in between, of all robots together. Raises
    PlanError for more than 2,000,000 timed points in all rounds.
    """
    plan = plan_at_constant_speeds(plan)
    poses = sum(_points_until(trajectory, span_s) for trajectory in plan)
    if poses > MOST_POINTS:
        raise PlanError(
            f"a bag of {span_s:.6g} s has {poses:.4g} timed points, since short loops come round so often; at most"
            f" {MOST_POINTS:,} are allowed"
        )
    step_s = max(USUAL_STEP_S, span_s * len(plan.trajectories) / MOST_BETWEEN)
    return [
        Motion(trajectory).track(namespace, _with_steps(corner_times_s(trajectory, -1.0, span_s), span_s, step_s))
        for trajectory, namespace in zip(plan, namespaces(plan), strict=True)
    ]


def _with_steps(times_s: Floats, span_s: float, step_s: float) -> Floats:
    """The times and ``span_s``, with as many between them, evenly, as keep them at most ``step_s`` apart."""
    times_s = np.union1d(times_s, [span_s])
    apart_s = np.diff(times_s)
    parts = np.maximum(np.ceil(apart_s / step_s - 1e-9), 1).astype(np.int64)
    begins = np.repeat(np.cumsum(parts) - parts, parts)
    share = (np.arange(len(begins)) - begins) / np.repeat(parts, parts)
    return np.append(np.repeat(times_s[:-1], parts) + share * np.repeat(apart_s, parts), times_s[-1])


def _points_until(trajectory: Trajectory, span_s: float) -> float:
    """About how many timed points a robot passes."""
    if trajectory.loop_duration_s == 0:
        return len(trajectory.times_s)
    return len(trajectory.times_s) * (1 + max(span_s - trajectory.loop_start_s, 0.0) / trajectory.loop_duration_s)


def _ways_rad(points: Floats) -> Floats:
    """Where a robot faces from each of its points (n, 2 or 3) on, (n,); at the last: as it came."""
    steps = np.diff(points[:, :2], axis=0)
    ways = np.append(np.arctan2(steps[:, 1], steps[:, 0]), 0.0)
    moves = np.append((steps != 0).any(axis=1), False)
    if not moves.any():
        return np.zeros(len(points))
    last = np.maximum.accumulate(np.where(moves, np.arange(len(points)), -1))
    return ways[np.where(last < 0, np.argmax(moves), last)]
