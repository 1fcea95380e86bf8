"""Robots with a bump sensor and a clock (Alam & Bobadilla, Robotics 9(2):47, 2020, and better)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rota.planner import Answer, Planner, Request
from rota.planners.bounce.planner_settings import BounceSettings

if TYPE_CHECKING:
    from rota.mission import Mission
    from rota.planner import Report


class BouncePlanner(Planner):
    """The door of the planner bounce; the compiled loops are loaded only when they are needed."""

    settings = BounceSettings

    def plan(self, request: Request) -> Answer:
        """A plan by which bouncing robots monitor the mission's zones, or cover its area; see ``planner``.

        Raises NoPlanFound, with the best there is, when cells stay uncovered or no team watches all zones.
        """
        from rota.planners.bounce.planner import plan_bounce

        return plan_bounce(
            request.mission, seed=request.seed, progress=request.progress, should_stop=request.should_stop
        )

    def sentences(self, answer: Answer, report: Report) -> Iterator[str | None]:
        """The table of robots and loops, what the search found, and what is left of the plan when turns are inexact."""
        from rota.plan_summary import approach_sentence, ratio_sentence, robots_table
        from rota.planners.bounce.physics_sentences import clocks_sentence, errors_sentence
        from rota.planners.bounce.sentences import rattling_sentence, swept_sentence

        plan = answer.plan
        if report.demands:
            yield robots_table(plan)
        yield from answer.facts
        if BounceSettings.of(plan.mission).task == "cover":
            yield swept_sentence(plan)
        else:
            yield from (ratio_sentence(plan, report), rattling_sentence(plan), approach_sentence(plan))
        yield from (clocks_sentence(plan, report), errors_sentence(plan))

    def compiled_packages(self, mission: Mission) -> tuple[str, ...]:
        """Cells, cycles and groups."""
        return ("planners/bounce",)
