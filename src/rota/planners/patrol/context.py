"""What a search is given besides the problem: how much work, who judges, whom to tell, when to stop."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from rota.mission import Effort, Mission
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.verdict import Judge
from rota.progress import Watch


@dataclass(frozen=True, kw_only=True)
class Work:
    """Bounds of the work.

    moves: of one annealing, for tours of a few hundred corners; most_moves: for any. handings: ways to hand ground to
    loops within loops; scattered: whether their excursions may begin at different vertices. screened: splits of the
    ground for one number of robots, the roomiest, that are annealed a little, with ``screening_moves``; of loops within
    loops, those that do best of ``sifted`` with less. whole: the best of these, from each of which ``seeds`` annealings
    are made in full. cooled: those of them that see most, which are annealed up to ``coolings`` times more, with
    ``cooling_moves``, cooler and cooler; those that come close have so many ``chances``, with other seeds.
    cooled_unseen, bent_over: the share of the ground that may be unseen after the first of these, and that by which
    bent tours may be over their budgets before the first mending: with more, mending would not find the rest.
    later_heat, later_dear: of the reach, twice the heat of the first of these that begins from mended tours, and how
    many times more than usual it is worth then to see anything. tries: numbers of robots tried one by one. repairs:
    rounds of mending; mends_over: the share of a budget by which tours may be over it meanwhile; tight_margin,
    tight_bend: where budgets are tight, the share of the range margin that is kept, and how much farther than to what
    is missed tours are bent, of the reach. groupings: of the period classes. least_squeeze: budgets, as a multiple of
    the ideal lengths, below which a number of robots is not tried. stretches: of the periods, tried for the best that a
    fixed number of robots can do, until one that failed and one that passed differ by no more than the factor
    ``nearness``. begins_anew: whether from new tours too, after some have passed. searches_ragged: whether fewer robots
    than the first tours need are looked for on ground with very many corners, where every look takes minutes.
    """

    moves: int
    most_moves: int
    handings: int
    scattered: bool
    sifted: int
    screened: int
    screening_moves: int
    whole: int
    seeds: int
    cooled: int
    tries: int
    coolings: int
    cooling_moves: int
    chances: int
    cooled_unseen: float
    bent_over: float
    later_heat: float
    later_dear: float
    repairs: int
    mends_over: float
    tight_margin: float
    tight_bend: float
    groupings: int
    least_squeeze: float
    stretches: int
    nearness: float
    begins_anew: bool
    searches_ragged: bool


WORK: dict[Effort, Work] = {
    "quick": Work(
        moves=300_000,
        most_moves=2_000_000,
        handings=1,
        scattered=False,
        sifted=0,
        screened=6,
        screening_moves=50_000,
        whole=2,
        seeds=1,
        cooled=2,
        tries=2,
        coolings=4,
        cooling_moves=150_000,
        chances=1,
        cooled_unseen=0.015,
        bent_over=math.inf,
        later_heat=1 / 8,
        later_dear=6.0,
        repairs=12,
        mends_over=0.0,
        tight_margin=1.0,
        tight_bend=0.005,
        groupings=4,
        least_squeeze=1.15,
        stretches=4,
        nearness=1.025,
        begins_anew=False,
        searches_ragged=False,
    ),
    "normal": Work(
        moves=600_000,
        most_moves=10_000_000,
        handings=4,
        scattered=True,
        sifted=24,
        screened=8,
        screening_moves=50_000,
        whole=2,
        seeds=2,
        cooled=2,
        tries=2,
        coolings=4,
        cooling_moves=600_000,
        chances=1,
        cooled_unseen=0.0008,
        bent_over=0.005,
        later_heat=1 / 8,
        later_dear=6.0,
        repairs=20,
        mends_over=0.0002,
        tight_margin=1.0,
        tight_bend=0.005,
        groupings=8,
        least_squeeze=1.1,
        stretches=6,
        nearness=1.015,
        begins_anew=True,
        searches_ragged=True,
    ),
    "high": Work(
        moves=800_000,
        most_moves=100_000_000,
        handings=7,
        scattered=True,
        sifted=56,
        screened=16,
        screening_moves=100_000,
        whole=4,
        seeds=6,
        cooled=8,
        tries=8,
        coolings=8,
        cooling_moves=1_200_000,
        chances=6,
        cooled_unseen=0.015,
        bent_over=math.inf,
        later_heat=1 / 16,
        later_dear=20.0,
        repairs=30,
        mends_over=0.001,
        tight_margin=0.1,
        tight_bend=0.002,
        groupings=16,
        least_squeeze=1.05,
        stretches=9,
        nearness=1.01,
        begins_anew=True,
        searches_ragged=True,
    ),
}


@dataclass(frozen=True, kw_only=True)
class Context:
    """One search: the problem, the seed and the caller's wishes.

    bound: what is proved of the mission as it is asked. enough_robots: fewer need not be looked for; the bound, or a
    fixed fleet's number. dear: how many times more than on open ground it is worth, while annealing, to see anything.
    watch: told of the states that the search comes to, from several threads; it changes nothing of what is found.
    """

    problem: Problem
    bound: ProvedBound
    enough_robots: int
    seed: int
    judge: Judge
    progress: Callable[[float, str], None]
    should_stop: Callable[[], bool]
    dear: float = 1.0
    watch: Watch | None = None

    @property
    def work(self) -> Work:
        """The bounds that the mission's effort sets."""
        return WORK[self.problem.mission.patrol.effort]


def begin_search(
    problem: Problem,
    *,
    asked: Mission,
    seed: int,
    judge: Judge,
    progress: Callable[[float, str], None],
    should_stop: Callable[[], bool],
    watch: Watch | None = None,
) -> Context:
    """A search that knows its bound: that of the mission as it is asked, with starts and without a reserve.

    It ends at the bound of what is searched, with the reserve, or at a fixed fleet's number.
    """
    bound = prove_bound(problem)
    return Context(
        problem=problem, bound=bound if asks_alike(asked, problem.mission) else prove_bound(set_up_problem(asked)),
        enough_robots=robots_enough(problem, asked, bound), seed=seed, judge=judge, progress=progress,
        should_stop=should_stop, watch=watch,
    )  # fmt: skip


def asks_alike(one: Mission, other: Mission) -> bool:
    """Whether two missions of one ground, that may differ in their starts, have the same periods and sensors."""
    sensors = [[robot.sensor for robot in (m.fleet.equal_robot("r"), *(m.fleet.robots or ()))] for m in (one, other)]
    periods = [[m.period_s, *(zone.period_s for zone in m.zones)] for m in (one, other)]
    return sensors[0] == sensors[1] and periods[0] == periods[1]


def robots_enough(problem: Problem, asked: Mission, bound: ProvedBound) -> int:
    """Robots of which fewer need not be looked for: the bound of what is searched, or a fixed fleet's number.

    Robots that start in different parts of the ground cannot help each other: each part makes do with as few as it can.
    """
    apart = asked.has_starts and len(problem.paths.parts) > 1
    return bound.robots if apart else max(bound.robots, len(problem.mission.fleet.robots or ()))
