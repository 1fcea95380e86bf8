"""Trajectories whose legs have accelerations drawn at random."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rota.model.plan import Plan, Trajectory


def accelerated(trajectory: Trajectory, rng: np.random.Generator) -> Trajectory:
    """The same points at the same times: legs from rest, to rest, at constant speed, and in between."""
    legs = len(trajectory.times_s) - 1
    bends = rng.choice([-1.0, 1.0, 0.0, 2.0], legs)
    bends = np.where(bends == 2, rng.uniform(-1, 1, legs), bends)
    lengths = np.sqrt((np.diff(trajectory.positions_m, axis=0) ** 2).sum(axis=1))
    return replace(trajectory, accelerations_m_s2=2 * bends * lengths / np.diff(trajectory.times_s) ** 2)


def all_accelerated(plan: Plan, rng: np.random.Generator) -> Plan:
    """The plan with such legs for each of its robots."""
    return replace(plan, trajectories=tuple(accelerated(each, rng) for each in plan))
