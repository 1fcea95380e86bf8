"""Closed routes, periods per zone, the fewest robots (Sun et al., Sensors 19(9):1994, 2019, and better)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rota.mission import Mission
    from rota.plan import Plan
    from rota.planners.patrol.verdict import Judge
    from rota.progress import Watch


def plan_patrol(
    mission: Mission,
    *,
    seed: int,
    judge: Judge,
    progress: Callable[[float, str], None],
    should_stop: Callable[[], bool],
    watch: Watch | None = None,
) -> Plan:
    """A plan that the judge passes, by the method of the mission's settings; see ``planner.plan_patrol``."""
    from rota.planners.patrol.planner import plan_patrol as plan  # loads the compiled loops only when they are needed

    return plan(mission, seed=seed, judge=judge, progress=progress, should_stop=should_stop, watch=watch)
