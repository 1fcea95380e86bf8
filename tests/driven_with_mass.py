"""Trajectories of robots with mass, made by hand: straight legs that speed up and brake, and corners that are cut."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from rota.model.plan import Trajectory

OFF_M = 0.05


@dataclass
class Drive:
    """Points, times and accelerations so far."""

    times_s: list[float] = field(default_factory=lambda: [0.0])
    points: list[np.ndarray] = field(default_factory=list)
    accelerations: list[float] = field(default_factory=list)

    def leg(self, to: np.ndarray, duration_s: float, acceleration: float = 0.0) -> None:
        if duration_s > 1e-9:
            self.times_s.append(self.times_s[-1] + duration_s)
            self.points.append(to)
            self.accelerations.append(acceleration)

    def straight(self, end: np.ndarray, v0: float, v1: float, top: float, a: float) -> None:
        """From the last point: up to at most ``top``, on, and down; from the speed v0 to v1."""
        begin = self.points[-1]
        length = float(np.linalg.norm(end - begin))
        if length < 1e-9:
            return
        along = (end - begin) / length
        peak = min(top, math.sqrt((2 * a * length + v0**2 + v1**2) / 2))
        assert peak >= max(v0, v1) - 1e-9, "too short a way for these speeds"
        up, down = (peak**2 - v0**2) / (2 * a), (peak**2 - v1**2) / (2 * a)
        self.leg(begin + up * along, (peak - v0) / a, a)
        self.leg(begin + (length - down) * along, (length - up - down) / peak)
        self.leg(end, (peak - v1) / a, -a)

    def curve(self, corner: np.ndarray, u0: np.ndarray, u1: np.ndarray, v: float, a: float, least: int) -> None:
        """The parabola past a corner by its tangents, which are never off by more than OFF_M."""
        total_s = 2 * v * math.sin(turn(u0, u1) / 2) / a
        count = max(least, math.ceil(total_s / math.sqrt(8 * OFF_M / a)))
        at = corner - u0 * v * total_s / 2
        step_s = total_s / count
        for k in range(count + 1):
            leg_s = step_s / 2 if k in (0, count) else step_s
            at = at + v * (u0 + (u1 - u0) * k / count) * leg_s
            self.leg(at, leg_s)


def turn(u0: np.ndarray, u1: np.ndarray) -> float:
    return 2 * math.asin(min(1.0, float(np.linalg.norm(u1 - u0)) / 2))


def reach(u0: np.ndarray, u1: np.ndarray, v: float, a: float) -> float:
    """How far before and after a corner its parabola reaches."""
    return v * v * math.sin(turn(u0, u1) / 2) / a


def rounded(
    corners: np.ndarray,
    speeds: np.ndarray,
    holds_s: np.ndarray,
    *,
    top: float,
    a: float,
    once: np.ndarray | None = None,
    least_tangents: int = 1,
) -> Trajectory:
    """A loop round the corners (n, d), past each at its speed, or 0: stops there and waits.

    It begins at the first corner, which must have the speed 0, or at the last point of ``once``, which is that corner:
    a way from rest, past its corners at the same speed as the loop's fastest.
    """
    drive = Drive()
    path = [*([] if once is None else [(p, 1.0, 0.0) for p in once[:-1]])]
    path = [(p, 0.0 if k == 0 else float(speeds.max()), 0.0) for k, (p, _, _) in enumerate(path)]
    path += [(corners[k], speeds[k], holds_s[k]) for k in range(len(corners))]
    path.append((corners[0], 0.0, 0.0))
    assert speeds[0] == 0
    drive.points.append(path[0][0])
    loop_at = 0 if once is None else len(once) - 1
    loop_start_s = 0.0
    for k in range(len(path)):
        place, v, hold = path[k]
        if k == loop_at:
            loop_start_s = drive.times_s[-1]
        drive.leg(place, hold)
        if k == len(path) - 1:
            break
        after, v1, _ = path[k + 1]
        u = (after - place) / np.linalg.norm(after - place)
        if v > 0:
            before = path[k - 1][0]
            drive.curve(place, (place - before) / np.linalg.norm(place - before), u, v, a, least_tangents)
        end = after
        if v1 > 0:
            w = path[k + 2][0] - after
            end = after - u * reach(u, w / np.linalg.norm(w), v1, a)
        drive.straight(end, v, v1, top, a)
    points = np.array(drive.points)
    points[-1] = path[loop_at][0]
    return Trajectory(
        robot="a",
        times_s=drive.times_s,
        positions_m=points,
        accelerations_m_s2=held(np.array(drive.times_s), points, np.array(drive.accelerations)),
        loop_start_s=loop_start_s,
    )


def held(times_s: np.ndarray, points: np.ndarray, accelerations: np.ndarray) -> np.ndarray:
    """Accelerations that rounding makes no leg drive backwards by."""
    most = 2 * np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(times_s) ** 2
    return np.clip(accelerations, -most, most)


def begun_at(trajectory: Trajectory, share: float) -> Trajectory:
    """The loop begun at another moment, which may be amidst a leg; without what came before it."""
    k, span = trajectory.loop_index, trajectory.loop_duration_s
    times = trajectory.times_s[k:] - trajectory.loop_start_s
    points, given = trajectory.positions_m[k:], trajectory.accelerations_m_s2
    assert given is not None
    given = given[k:]
    cut = share * span
    there = trajectory.at(trajectory.loop_start_s + cut)
    i = int(np.searchsorted(times, cut + 1e-9, side="right")) - 1
    if cut - times[i] < 1e-9:
        head, new_times = points[i:-1], times[i:-1] - times[i]
        rest = given[i:]
        return _looped(head, new_times, rest, points[: i + 1], times[: i + 1] + span - times[i], given[:i])
    head = np.concatenate([[there], points[i + 1 : -1]])
    new_times = np.concatenate([[0.0], times[i + 1 : -1] - cut])
    tail, tail_times = np.concatenate([points[: i + 1], [there]]), np.append(times[: i + 1] + span - cut, span)
    return _looped(head, new_times, given[i:], tail, tail_times, given[: i + 1])


def _looped(head, head_times, head_given, tail, tail_times, tail_given) -> Trajectory:  # type: ignore[no-untyped-def]
    times, points = np.concatenate([head_times, tail_times]), np.concatenate([head, tail])
    points[-1] = points[0]
    given = held(times, points, np.concatenate([head_given, tail_given]))
    return Trajectory(robot="a", times_s=times, positions_m=points, accelerations_m_s2=given)
