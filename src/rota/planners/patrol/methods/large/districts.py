"""The districts of large ground searched by themselves, side by side, and their tours as those of the whole."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Protocol

from rota.errors import NoPlanFound
from rota.model.mission import Mission
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.context import Context, silent
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.tours.tour import Tour


class Found(Protocol):
    """What a search of one district comes to, whatever else it is."""

    @property
    def tours(self) -> list[Tour]:
        """The tours over the district."""
        ...


class DistrictSearch(Protocol):
    """A search for tours over one district."""

    def __call__(self, context: Context) -> Found:
        """The best tours found for the context's problem."""
        ...


def by_districts(context: Context, search: DistrictSearch, missions: list[Mission]) -> list[list[Tour]]:
    """The tours found for every district's mission by itself; none for those not begun when the search is to end."""
    districts: list[list[Tour]] = []
    alone = replace(context, problem=None, progress=silent, watch=None)  # type: ignore[arg-type]
    seeds = range(context.seed, context.seed + len(missions))

    def find(mission: Mission, seed: int) -> list[Tour]:
        return alone.run(tours_alone, search, mission, seed)

    with ThreadPoolExecutor(max_workers=context.threads) as pool:
        for tours in pool.map(find, missions, seeds):
            districts.append([of_whole(context.problem, tour) for tour in tours])
            share = len(districts) / len(missions)
            context.progress(0.3 + 0.6 * share, f"{len(districts)} of {len(missions)} districts planned")
    return districts


def tours_alone(context: Context, search: DistrictSearch, mission: Mission, seed: int) -> list[Tour]:
    """The tours that the search finds for one district's mission, whatever the context's problem is.

    None where nobody can see any of it from within: the repair of the whole will lead robots there. None either
    once the search is to end.
    """
    if context.should_stop():
        return []
    try:
        problem = set_up_problem(mission, is_whole=False)
    except NoPlanFound:
        return []
    bound = prove_bound(problem, should_stop=context.should_stop)
    own = replace(context, problem=problem, bound=bound, enough_robots=bound.robots, seed=seed, executor=None)
    return search(own).tours


def of_whole(problem: Problem, tour: Tour) -> Tour:
    """The tour of a district with its class and its part of the space as the whole problem numbers them."""
    component = int(problem.paths.part_of(tour.vertices_m[:1])[0])
    return replace(tour, period_class=problem.periods_s.index(tour.period_s), component=max(component, 0))


def join(districts: list[list[Tour]]) -> list[Tour]:
    """The tours of all districts, those that robots drive in turn numbered anew."""
    together: list[Tour] = []
    for tours in districts:
        first = 1 + max((tour.nest for tour in together), default=-1)
        together += [replace(tour, nest=tour.nest + first if tour.nest >= 0 else -1) for tour in tours]
    return together
