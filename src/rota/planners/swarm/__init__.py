"""Robots that sense their neighbours, spread and hold (Chen, Xu, Li, Sensors 18(6):1864, 2018, and better)."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rota.checkpoint import SwarmState
    from rota.mission import Mission
    from rota.plan import Plan
    from rota.planners.swarm.metrics import History


def plan_swarm(
    mission: Mission,
    *,
    seed: int,
    judge: object,
    progress: Callable[[float, str], None],
    should_stop: Callable[[], bool],
    watch: object = None,
    resume: SwarmState | None = None,
    keep: Callable[[SwarmState], None] = lambda _state: None,
    observe: Callable[[History], None] | None = None,
) -> Plan:
    """A plan in which the mission's robots spread and then hold; see ``asked.run_mission``, which tells more.

    The robots know nothing of demands, so ``judge`` is not asked here: whether what they cover meets one, the check
    finds out afterwards. ``resume``: go on from there; ``keep`` is called with a run that ends before robots rest, and
    ``observe``, where it is given, with what every step came to. All cores are used, and the plan is the same on any
    number of them.
    """
    from rota.planners.swarm.planner import run_mission  # loads the compiled loops only when they are needed

    run = run_mission(
        mission,
        seed=seed,
        progress=progress,
        should_stop=should_stop,
        threads=os.cpu_count() or 1,
        observed=observe is not None,
        resume=resume,
    )
    if observe is not None and run.history is not None:
        observe(run.history)
    if not run.at_rest:
        keep(run.state)
    return run.plan
