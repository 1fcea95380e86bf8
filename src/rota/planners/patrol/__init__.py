"""Closed routes, periods per zone, the fewest robots (Sun et al., Sensors 19(9):1994, 2019, and better)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rota.planners.patrol.method_table import METHODS
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planning.planner import Answer, Handover, Planner, Request

if TYPE_CHECKING:
    from rota.compiled.parts import Part
    from rota.model.mission import Mission
    from rota.model.plan import Plan
    from rota.planning.planner import Report


class PatrolPlanner(Planner):
    """The door of the planner patrol; the compiled loops are loaded only when they are needed."""

    methods = tuple(METHODS)
    plans_near_origin = True
    settings = PatrolSettings

    def plan(self, request: Request) -> Answer:
        """A plan that the judge passes, by the method of the mission's settings; see ``planner.plan_patrol``."""
        from rota.planners.patrol.planner import plan_patrol

        return Answer(plan=plan_patrol(request))

    def takeovers(self, asked: Handover) -> Iterator[Plan]:
        """Robots keep their rounds where they can; others come into rounds that nobody drives now, or join some."""
        from rota.planners.patrol.handover.takeovers import takeovers

        return takeovers(asked)

    def sentences(self, answer: Answer, report: Report) -> Iterator[str | None]:
        """The table of robots and loops, then robots against the bound, why, the worst gap, the way there, pockets."""
        from rota.planners.patrol.pockets import pockets_sentence
        from rota.planning.charging_summary import charging_sentence, charging_table
        from rota.planning.plan_summary import (
            approach_sentence,
            bound_sentence,
            ratio_sentence,
            robots_sentence,
            robots_table,
        )

        plan = answer.plan
        if report.demands:
            yield charging_table(plan) if plan.mission.chargers else robots_table(plan)
        yield from answer.facts
        yield from (robots_sentence(plan), bound_sentence(plan), ratio_sentence(plan, report), approach_sentence(plan))
        if plan.mission.chargers:
            yield charging_sentence(plan)
        yield pockets_sentence(plan)

    def proved_bound(self, mission: Mission) -> tuple[int, str]:
        """The highest of the bounds of ``bounds/``, for the mission as it is asked."""
        from rota.planners.patrol.bounds.best_bound import prove_bound
        from rota.planners.patrol.ground.problem import set_up_problem

        bound = prove_bound(set_up_problem(mission))
        return bound.robots, bound.reason

    def hasty_bound(self, mission: Mission) -> tuple[int, str]:
        """The same without the bound by tours."""
        from rota.planners.patrol.bounds.best_bound import prove_bound
        from rota.planners.patrol.ground.problem import set_up_problem

        bound = prove_bound(set_up_problem(mission), tours=False)
        return bound.robots, bound.reason

    def compiled_packages(self, mission: Mission) -> tuple[str, ...]:
        """The annealing, and the geometry that it stands on."""
        return "planners/patrol/annealing", "geometry"

    def parts_to_compile(self) -> tuple[Part, ...]:
        """The annealing, the ground it stands on, and the bending of its loops."""
        from rota.planners.patrol.compile_ahead import PARTS

        return PARTS

    def small_mission(self) -> Mission:
        """A small yard, swept in lanes."""
        import shapely

        from rota.model.mission import DiscSensor, Fleet, Mission

        return Mission(
            name="yard",
            area=shapely.MultiPolygon([shapely.box(0, 0, 20, 20)]),
            period_s=100,
            fleet=Fleet(speed_m_s=5, sensor=DiscSensor(radius_m=5)),
            planning=PatrolSettings(effort="quick", method="sequential"),
        )

    def omission(self, mission: Mission) -> str | None:
        """Ground that nobody can see from where robots can be."""
        from rota.planners.patrol.left_out import sentence_of_what_is_left_out

        return sentence_of_what_is_left_out(mission)

    def long_work(self, mission: Mission) -> Iterator[str]:
        """Large ground, many robots, many corners and slow turning."""
        from rota.planners.patrol.work_ahead import planning_ahead

        return planning_ahead(mission)
