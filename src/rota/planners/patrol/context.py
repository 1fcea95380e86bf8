"""What every stage of a search is given: the problem, its settings, who judges, whom to tell, when to stop."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import Executor, Future, wait
from dataclasses import dataclass, replace
from functools import partial
from typing import Concatenate, ParamSpec, TypeVar

from rota.engines.placing import answer_of, submit_with
from rota.model.mission import Mission
from rota.planners.patrol.bounds.best_bound import prove_bound, prove_by_area
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.efforts import EFFORTS
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.settings import SearchSettings
from rota.planners.patrol.verdict import Judge
from rota.planning.planner import Request
from rota.planning.progress import Watch

Result = TypeVar("Result")
Given = ParamSpec("Given")


@dataclass(frozen=True, kw_only=True)
class Context:
    """One search: the problem, the seed and the caller's wishes.

    asked: the mission with its starts and without a reserve.
    settings: of every stage of the search.
    bound: what is proved of the mission as it is asked. proves_later: the best bound is still to be proved
    (``with_best_bound``).
    enough_robots: fewer are not looked for; the bound, or the number of a fixed team.
    coverage_weight: multiple of the weight of seeing on open ground.
    watch: told of the states of the search, from several threads; it changes nothing of the result.
    executor: does what can be done side by side, without telling ``watch``; None: threads do.
    """

    problem: Problem
    asked: Mission
    settings: SearchSettings
    bound: ProvedBound
    enough_robots: int
    seed: int
    judge: Judge
    progress: Callable[[float, str], None]
    should_stop: Callable[[], bool]
    coverage_weight: float = 1.0
    watch: Watch | None = None
    executor: Executor | None = None
    proves_later: bool = False

    @property
    def keeps_first_tours(self) -> bool:
        """Whether a plan with the first tours will do, however many robots are proved necessary.

        To look for fewer takes hours over the thousands of corners of ragged ground.
        """
        return self.problem.is_ragged and not self.settings.team_size.searches_ragged

    @property
    def threads(self) -> int | None:
        """How many threads may work side by side, each by ``run``; those that only wait for an executor may be many."""
        return os.cpu_count() if self.executor is None else 200  # that only wait

    def run(
        self, function: Callable[Concatenate[Context, Given], Result], *args: Given.args, **kwargs: Given.kwargs
    ) -> Result:
        """``function(context, ...)``, done by the executor if there is one; the result is the same.

        A function that is done there is not told to stop. Once the search is to stop it is called here instead, which
        then returns at once.
        """
        if self.executor is None:
            return function(self, *args, **kwargs)
        there = replace(
            self, problem=None, progress=silent, should_stop=_never, watch=None, executor=None,  # type: ignore[arg-type]
        )  # fmt: skip
        future: Future[Result] = submit_with(self.executor, self.problem, _run_there, there, function, args, kwargs)
        while not wait([future], timeout=0.1).done:  # between two looks at the stop flag
            if self.should_stop():
                future.cancel()
                return function(self, *args, **kwargs)
        return answer_of(future)

    def with_all_moves(self) -> Context:
        """The same search with no fewer moves for short tours, for what is tried once."""
        annealing = replace(self.settings.annealing, least_share=1.0)
        return replace(self, settings=replace(self.settings, annealing=annealing))

    @property
    def anneals(self) -> bool:
        """Whether the mission's method anneals tours, so that each team size can be searched by itself."""
        return PatrolSettings.of(self.problem.mission).method == "tours"


def _run_there(
    problem: Problem,
    context: Context,
    function: Callable[..., Result],
    args: tuple[object, ...],
    kwargs: dict[str, object],
) -> Result:
    """What a worker does: the function with the context that was sent without its problem."""
    return function(replace(context, problem=problem), *args, **kwargs)


def silent(share: float, what: str) -> None:
    """Tell nobody."""


def _never() -> bool:
    """Whether to stop, where nobody can say so."""
    return False


def begin_search(
    problem: Problem,
    asked: Request,
    prove: Callable[[Problem], ProvedBound] = prove_bound,
    *,
    judge: Judge | None = None,
) -> Context:
    """A search with the settings of the mission's effort and the bound of the mission as it is asked.

    asked: its mission has starts and no reserve. prove: any other bound than the best one is to do for the beginning.
    judge: of plans for the problem's mission; None: the one asked.
    """
    bound, enough_robots = what_is_proved(problem, asked.mission, prove)
    return Context(
        problem=problem, asked=asked.mission, settings=EFFORTS[PatrolSettings.of(problem.mission).effort], bound=bound,
        enough_robots=enough_robots, seed=asked.seed, judge=judge or asked.judge, progress=asked.progress,
        should_stop=asked.should_stop, watch=asked.watch, executor=asked.executor,
        proves_later=prove is not prove_bound,
    )  # fmt: skip


def with_best_bound(context: Context) -> Context:
    """The search with the highest of all bounds; with the one it has where it is to stop."""
    if not context.proves_later or context.should_stop():
        return context
    best = with_bound(context, partial(prove_bound, should_stop=context.should_stop))
    return replace(best, proves_later=False)


def with_bound_by_area(context: Context) -> Context:
    """The search with the bound of areas and periods, where the best one is still to be proved."""
    return with_bound(context, prove_by_area) if context.proves_later else context


def with_bound(context: Context, prove: Callable[[Problem], ProvedBound]) -> Context:
    """The search with the bound that this proof gives."""
    bound, enough_robots = what_is_proved(context.problem, context.asked, prove)
    return replace(context, bound=bound, enough_robots=enough_robots)


def what_is_proved(
    problem: Problem, asked: Mission, prove: Callable[[Problem], ProvedBound]
) -> tuple[ProvedBound, int]:
    """The bound of the mission as it is asked, and the number of robots at which the search ends."""
    bound = prove(problem)
    as_asked = bound if asks_alike(asked, problem.mission) else prove(set_up_problem(asked))
    return as_asked, robots_enough(problem, asked, bound)


def asks_alike(one: Mission, other: Mission) -> bool:
    """Whether two missions of one ground, that may differ in their starts, have the same periods and sensors."""
    sensors = [[robot.sensor for robot in (m.fleet.equal_robot("r"), *(m.fleet.robots or ()))] for m in (one, other)]
    periods = [[m.period_s, *(zone.period_s for zone in m.zones)] for m in (one, other)]
    return sensors[0] == sensors[1] and periods[0] == periods[1]


def robots_enough(problem: Problem, asked: Mission, bound: ProvedBound) -> int:
    """The number of robots at which the search ends: the bound of what is searched, or the number of a fixed team.

    Robots that start in different components of the ground cannot help each other: then it is the bound.
    """
    apart = asked.has_starts and len(problem.paths.parts) > 1
    return bound.robots if apart else max(bound.robots, len(problem.mission.fleet.robots or ()))
