"""The better plans that a search comes by before its end, for those who want to see them at once."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from rota.planning.progress import SearchState, rank

if TYPE_CHECKING:
    from rota.check.report import Report
    from rota.model.mission import Mission
    from rota.model.plan import Plan

OnBetter = Callable[["Plan", "Report"], None]


class BetterPlans:
    """Tells every plan of the whole mission that is better than all before it, in the order of ``rank``.

    ``best``: the last one told, with its report. on_the_way: as ``check_plan`` takes it.

    Planners also try other periods, missions without starts, and equal robots in place of those that the fleet names.
    Such a plan is checked again for the mission as it is asked: always until a plan meets it, and then only if the plan
    met what it was tried for with fewer robots. A plan for more robots than the fleet names is not told.
    """

    def __init__(self, mission: Mission, tell: OnBetter | None, on_the_way: Callable[[], None] | None = None) -> None:
        self._mission, self._tell, self._on_the_way = mission, tell, on_the_way
        self._state: SearchState | None = None  # of the best
        self.best: tuple[Plan, Report] | None = None
        self._lock = threading.Lock()

    def note(self, plan: Plan, report: Report) -> None:
        """Note a plan that was judged, in any thread; tells it if it is better. The tellings do not overlap."""
        from rota.check import check_plan

        if not self._is_for_all(plan.mission):
            return
        with self._lock:
            if plan.mission is not self._mission:
                if not self._worth_a_check(plan, report):
                    return
                own = _with_fleet_of(self._mission, plan)
                if own is None:
                    return
                plan, report = own, check_plan(own, on_the_way=self._on_the_way)
            state = checked_state(plan, report)
            if self._state is None or rank(state) < rank(self._state):
                self._state, self.best = state, (plan, report)
                if self._tell is not None:
                    self._tell(plan, report)

    def _is_for_all(self, mission: Mission) -> bool:
        """Whether a mission that a planner tries asks for all ground, and of robots that charge and differ so."""
        asked, kinds = self._mission, [each.fleet.kinds for each in (mission, self._mission)]
        zones = [[zone.name for zone in each.zones] for each in (mission, asked)]
        alike = zones[0] == zones[1] and kinds[0] == kinds[1]
        return alike and mission.area == asked.area and mission.chargers == asked.chargers

    def _worth_a_check(self, plan: Plan, report: Report) -> bool:
        """Whether a plan for other demands may be better than the best for those that are asked."""
        best = self._state
        return best is None or not best.met or (report.verdict == "met" and len(plan.trajectories) < best.robots)


def _with_fleet_of(mission: Mission, plan: Plan) -> Plan | None:
    """The plan as one for this mission; None where the mission's fleet names too few robots for it."""
    named, trajectories = mission.fleet.robots, tuple(plan)
    if named is not None and any(one.robot not in {robot.name for robot in named} for one in trajectories):
        if len(named) < len(trajectories):
            return None
        own = zip(trajectories, named, strict=False)  # robots of the fleet may be left without a trajectory
        trajectories = tuple(replace(one, robot=robot.name) for one, robot in own)
    return replace(plan, mission=mission, trajectories=trajectories)


def checked_state(plan: Plan, report: Report) -> SearchState:
    """Where a search stands with a plan that was judged."""
    whole_m2 = sum(demand.area_m2 for demand in report.demands)
    unseen_m2 = sum(demand.unseen_area_m2 for demand in report.demands)
    ratios = [d.worst_gap_at_least_s / d.period_s for d in report.demands if math.isfinite(d.worst_gap_at_least_s)]
    return SearchState(
        stage="checked",
        robots=len(plan.trajectories),
        unseen_share=unseen_m2 / whole_m2 if whole_m2 else 0.0,
        late_share=max(0.0, *(ratio - 1 for ratio in ratios)) if ratios else 0.0,
        met=report.verdict == "met",
        drivable=all(fault.kind in ("gap", "unseeable", "holds too late") for fault in report.violations),
    )
