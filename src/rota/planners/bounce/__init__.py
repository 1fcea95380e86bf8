"""Robots with a bump sensor and a clock (Alam & Bobadilla, Robotics 9(2):47, 2020, and better)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rota.mission import Mission
    from rota.plan import Plan


def plan_bounce(
    mission: Mission,
    *,
    seed: int,
    judge: object,
    progress: Callable[[float, str], None],
    should_stop: Callable[[], bool],
    watch: object = None,
    tell: Callable[[str], None] = lambda sentence: None,
) -> Plan:
    """A plan by which bouncing robots monitor the mission's zones, or cover its area; see ``asked``, which tells more.

    tell: called with sentences about what the planner knows beside the plan. Raises NoPlanFound, with the best there
    is, when cells stay uncovered or no team watches all zones.
    """
    from rota.planners.bounce.planner import plan_coverage, plan_monitoring  # loads the compiled loops

    if mission.bounce.cells == "none":
        from rota.planners.bounce.free_monitoring import plan_free_monitoring

        return plan_free_monitoring(mission, seed=seed, progress=progress, should_stop=should_stop)
    if mission.bounce.task == "cover":
        return plan_coverage(mission, seed=seed, tell=tell)
    return plan_monitoring(mission, seed=seed, progress=progress, should_stop=should_stop, tell=tell)
