"""Robots that set out from their starts one after the other, each as soon as bodies stay apart on its way."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from rota.model.arrays import Floats
from rota.model.trajectory import Trajectory
from rota.planners.patrol.tolerances import SHORTEST_S
from rota.routes.flights import on_charger

WAITS = 40  # at the starts, each longer than the one before by what a robot takes for four of its bodies
Unit = Callable[[float], Sequence[Trajectory]]  # what robots drive who set out that much later; empty: they cannot


def set_out_in_turn(units: Sequence[Unit], bodies_m: Mapping[str, float], step_s: float) -> list[Trajectory]:
    """What the robots of all units drive; empty where some unit finds no time to set out.

    Those who stand farthest ahead, where all of them go, set out first. Who is not yet under way stands at its start.
    bodies_m: radii by robot. step_s: by how much longer each waits.
    """
    begun = [unit(0.0) for unit in units]
    if not all(begun):
        return []
    stands_m = np.array([np.mean([one.positions_m[0, :2] for one in own], axis=0) for own in begun])
    goes_m = np.array([np.mean([one.at(one.loop_start_s)[:2] for one in own], axis=0) for own in begun])
    ahead_m = stands_m @ (goes_m - stands_m).mean(axis=0)
    order = np.argsort(-ahead_m, kind="stable").tolist()
    placed: list[Trajectory] = []
    for n, k in enumerate(order):
        standing = [_standing(one) for later in order[n + 1 :] for one in begun[later]]
        tried = (units[k](step_s * wait) for wait in range(WAITS))
        own = next((ways for ways in tried if ways and _are_apart(ways, placed + standing, bodies_m)), None)
        if own is None:
            return []
        placed += own
    return placed


def _standing(way: Trajectory) -> Trajectory:
    """A robot that stays where it begins."""
    return Trajectory(robot=way.robot, loop_start_s=0.0, times_s=np.zeros(1), positions_m=way.positions_m[:1])


def _are_apart(ways: Sequence[Trajectory], others: Sequence[Trajectory], bodies_m: Mapping[str, float]) -> bool:
    """Whether bodies stay apart until all of them are on their rounds; who is on a charger is in nobody's way."""
    return all(
        _least_apart_m(one, other) >= bodies_m[one.robot] + bodies_m[other.robot] - SHORTEST_S
        for one in ways
        for other in others
    )


def _least_apart_m(one: Trajectory, other: Trajectory) -> float:
    """How near two robots come to each other before the later one is on its round; inf: one is always on a charger."""
    until_s = max(one.loop_start_s, other.loop_start_s)
    moments_s = np.unique(np.concatenate([np.linspace(0, until_s, 200), one.times_s, other.times_s]))
    moments_s = moments_s[moments_s <= until_s]
    off_m = one.at(moments_s)[:, :2] - other.at(moments_s)[:, :2]
    if len(moments_s) < 2:
        return float(np.hypot(*off_m[0]))
    middles_s = (moments_s[:-1] + moments_s[1:]) / 2
    free = ~(on_charger(one, middles_s) | on_charger(other, middles_s))
    return float(np.min(_nearest_m(off_m[:-1], off_m[1:])[free], initial=np.inf))


def _nearest_m(begins_m: Floats, ends_m: Floats) -> Floats:
    """How near straight lines (n, 2) come to the origin."""
    steps_m = ends_m - begins_m
    squares = np.maximum((steps_m**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(-(begins_m * steps_m).sum(axis=1) / squares, 0.0, 1.0)
    return np.asarray(np.hypot(*(begins_m + share[:, None] * steps_m).T))
