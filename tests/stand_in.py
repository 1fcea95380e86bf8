"""A planner that tests put in the place of a mission's own."""

from __future__ import annotations

from collections.abc import Callable

from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.patrol import PatrolPlanner
from rota.planning.planner import Answer, Planner, Request


class StandIn(PatrolPlanner):
    """The planner patrol with a function of a mission, and what else a request holds, for its search."""

    def __init__(self, search: Callable[..., Plan]) -> None:
        self._search = search

    def plan(self, request: Request) -> Answer:
        plan = self._search(
            request.mission, seed=request.seed, judge=request.judge, progress=request.progress,
            should_stop=request.should_stop, watch=request.watch,
        )  # fmt: skip
        return Answer(plan=plan)


def standing_in(search: Callable[..., Plan]) -> Callable[[Mission], Planner]:
    """What finds the stand-in for every mission."""
    return lambda _mission: StandIn(search)
