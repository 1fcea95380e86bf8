"""Kinds of robots that share places at chargers in time: where one is away, the other one charges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rota.model.arrays import Floats
from rota.model.mission import Charger
from rota.model.plan import Plan, Trajectory
from rota.routes.moments import go_on

Stays = list[tuple[str, float, float]]

MOST_TURNS = 4  # of one kind to so many of another one, so that what they do together repeats soon


def turns_beside(plan: Plan) -> Floats:
    """Lengths of turns (n,) with which what robots do repeats together with what those of a plan do."""
    counts = np.arange(1.0, MOST_TURNS + 1)
    return np.unique(np.divide.outer(counts, counts)) * plan.trajectories[0].loop_duration_s


def later_with_room(plan: Plan, others: Sequence[Trajectory], chargers: Sequence[Charger]) -> Plan | None:
    """The plan begun at another moment of its round, so that chargers have places beside others; None: never."""
    lasts_s = max(one.loop_duration_s for one in (*plan, *others)) * MOST_TURNS
    theirs = [stay for one in others for stay in stays_until(one, lasts_s)]
    mine = [stay for one in plan for stay in stays_until(one, lasts_s)]
    round_s = plan.trajectories[0].loop_duration_s
    # some stay begins as another one ends
    moments_s = np.unique([(a - end_s) % round_s for _, a, _ in mine for _, _, end_s in theirs])
    for moment_s in moments_s:
        later = tuple(go_on(one, float(moment_s)) for one in plan)
        own = [stay for one in later for stay in stays_until(one, lasts_s)]
        if all(most_at_once([*own, *theirs], charger.name) <= charger.places for charger in chargers):
            return Plan(mission=plan.mission, trajectories=later, seed=plan.seed)
    return None


def stays_until(one: Trajectory, until_s: float) -> Stays:
    """The stays at chargers of a robot that does the same again and again, which begin until a moment."""
    rounds = np.arange(int(until_s / one.loop_duration_s) + 1) * one.loop_duration_s
    return [(each.charger, each.from_s + late_s, each.until_s + late_s) for late_s in rounds for each in one.charges]


def most_at_once(stays: Stays, charger: str) -> int:
    """How many of these stays are at a charger at once, at most; one ends at the moment at which another one begins."""
    spans = np.array([span for name, *span in stays if name == charger]).reshape(-1, 2)
    moments_s = spans[:, 0] + 1e-6
    return int(((spans[:, 0] <= moments_s[:, None]) & (moments_s[:, None] < spans[:, 1])).sum(axis=1).max(initial=0))
