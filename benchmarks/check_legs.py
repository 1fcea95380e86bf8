"""What the check of bodies costs as one robot's legs grow: 25 robots that tremble side by side."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
from shapely import box

from benchmarks.row import Options, Row
from rota.check.separation import separation_violations
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.model.plan import Plan, Trajectory

LEGS = (1000, 4000, 16000)


def check_legs(options: Options) -> Iterator[Row]:
    """CPU seconds by legs of each robot; four times the legs should take four times as long, not sixteen times."""
    separation_violations(trembling(10))  # loads what is needed
    spent_s = {}
    for legs in LEGS:
        begin = time.process_time()
        found = separation_violations(trembling(legs))
        spent_s[legs] = time.process_time() - begin
        assert not found
    growth = spent_s[LEGS[-1]] / spent_s[LEGS[0]]
    told = ", ".join(f"{spent:.2f} s of CPU for {legs:,}" for legs, spent in spent_s.items())
    yield Row(
        f"bodies of 25 robots that tremble, {LEGS[0]:,} to {LEGS[-1]:,} legs each",
        f"at most {1.5 * LEGS[-1] / LEGS[0]:.0f} times as long for {LEGS[-1] // LEGS[0]} times the legs",
        f"{told}; {growth:.1f} times",
        growth <= 1.5 * LEGS[-1] / LEGS[0],
    )


def trembling(legs: int) -> Plan:
    """Five rows of five bodies of 0.5 m, 1.05 m apart, each anywhere within 2 cm of its place every quarter second."""
    rng = np.random.default_rng(1)
    times = 0.25 * np.arange(legs + 1)
    ways = tuple(
        Trajectory(
            robot=f"r{k}",
            times_s=times,
            positions_m=3 + 1.05 * np.array([k % 5, k // 5]) + rng.uniform(-0.02, 0.02, (legs + 1, 2)),
            loop_start_s=times[-1],
        )
        for k in range(25)
    )
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1), body_radius_m=0.5)
    return Plan(mission=Mission(name="box", area=box(0, 0, 12, 12), period_s=9, fleet=fleet), trajectories=ways)
