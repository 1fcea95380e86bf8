"""More effort begins with what the lesser efforts find, on a coarser lattice, and never takes more robots."""

from __future__ import annotations

import math
import time
from collections.abc import Generator, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota.check import check_plan
from rota.mission import DiscSensor, Effort, Fleet, Mission, Obstacle, PatrolSettings
from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.context import Context, begin_search
from rota.planners.patrol.ground import problem as problem_module
from rota.planners.patrol.ground.extra_points import no_points, prepared_with
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.initial.allocation import Split
from rota.planners.patrol.methods import anneal_and_repair as cooling, fewest as tours
from rota.planners.patrol.repair.repair import Settled
from rota.planners.patrol.tours.tour import Tour

YARD = Mission(
    name="yard", area=MultiPolygon([box(0, 0, 30, 20)]), obstacles=(Obstacle(shape=MultiPolygon([box(8, 5, 12, 9)])),),
    period_s=60, fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=2)), planning=PatrolSettings(effort="normal"),
)  # fmt: skip


def context(mission: Mission) -> Context:
    return begin_search(
        set_up_problem(mission), asked=mission, seed=0, judge=check_plan, progress=lambda _share, _what: None,
        should_stop=lambda: False,
    )  # fmt: skip


def test_less_effort_keeps_the_bound_and_lays_a_coarser_lattice() -> None:
    normal = context(YARD)
    normal = replace(normal, bound=ProvedBound(robots=7, reason="so"), enough_robots=9)
    quick = tours.with_less_effort(normal, "quick")
    assert quick.problem.spacing_m == pytest.approx(1.5 * normal.problem.spacing_m)
    assert quick.work.moves < normal.work.moves
    assert (quick.bound, quick.enough_robots) == (normal.bound, 9)


def test_fewer_robots_on_ragged_ground_are_looked_for_with_more_effort_only(monkeypatch: pytest.MonkeyPatch) -> None:
    def searched(*_: object, **__: object) -> None:
        raise AssertionError("a search")

    monkeypatch.setattr(problem_module, "MOST_DENSE", 0)
    monkeypatch.setattr(tours, "with_so_many", searched)
    quick = context(YARD.with_effort("quick"))
    assert quick.problem.is_ragged
    found = tours.with_fewer(quick, None)
    assert found.met
    assert check_plan(found.plan).verdict == "met"
    with pytest.raises(AssertionError, match="a search"):
        tours.with_fewer(context(YARD), None)


def test_more_effort_is_spent_only_while_fewer_robots_may_do(monkeypatch: pytest.MonkeyPatch) -> None:
    spent = []

    def recorded(here: Context, best: Settled | None) -> Settled:
        spent.append((here.problem.mission.patrol.effort, best))
        return with_fewer(here, best)

    with_fewer = tours.with_fewer
    monkeypatch.setattr(tours, "with_fewer", recorded)
    found = tours.fewest_robots(context(YARD))
    assert found.met
    assert found.plan.mission == YARD
    # two robots are the bound, and the least effort finds them
    assert (tours.robots_of(found), found.plan.lower_bound_robots) == (2, 2)
    assert spent == [("quick", None)]


def test_the_best_of_less_effort_is_kept_when_more_finds_no_better(monkeypatch: pytest.MonkeyPatch) -> None:
    quick = tours.fewest_robots(context(YARD.with_effort("quick")))
    monkeypatch.setattr(tours, "with_so_many", lambda *_args, **_kinds: None)
    here = context(YARD)
    here = replace(here, enough_robots=1)
    assert tours.with_fewer(here, quick) is quick


class Little(NamedTuple):
    """What ``sifted`` reads of a search."""

    shortfall_m: float


@pytest.mark.parametrize(
    ("begun", "most", "rounds"),
    [
        (8, 8, []),
        (9, 8, [(9, 1)]),
        (13, 2, [(13, 3), (7, 2), (4, 1)]),  # the better half goes on, to annealings twice as long
        (0, 8, []),
    ],
)
def test_of_many_nests_the_better_half_goes_on(
    monkeypatch: pytest.MonkeyPatch, begun: int, most: int, rounds: list[tuple[int, int]]
) -> None:
    made: list[tuple[int, int]] = []
    here = context(YARD.with_effort("high"))

    def annealed_all(
        _context: Context, given: list[list[Tour]], *, moves: int, seed: int, coarse: bool
    ) -> list[Little]:
        assert (seed, coarse) == (5, True)
        made.append((len(given), moves))
        return [Little(shortfall_m=(7 * one[0].period_class) % 13) for one in given]

    monkeypatch.setattr(tours, "annealed_all", annealed_all)
    spot = Tour(vertices_m=np.zeros((1, 2)), period_class=0, period_s=60, robots=1, robot=here.problem.robot)
    splits = [Split(room=1.0, tours=[replace(spot, period_class=k)], nests=True) for k in range(begun)]
    kept = [split.tours[0].period_class for split in tours.sifted(here, splits, most, seed=5)]
    assert made == [(n, here.work.screening_moves >> turn) for n, turn in rounds]
    best = sorted(range(begun), key=lambda k: 7 * k % 13)[:most]
    assert kept == (best if rounds else list(range(begun)))


class Cooled(NamedTuple):
    """What ``cooled_and_settled`` reads of a search."""

    unseen_share: float
    over_budget_share: float
    tours: list[Tour]


class Late(NamedTuple):
    """What it reads of tours that failed."""

    tours: list[Tour]
    met: bool
    fits: bool
    extra: object


ALL = ["anneal", "anneal", "bend", "mend"]


@pytest.mark.parametrize(
    ("effort", "turn_rate_rad_s", "unseen", "over", "done"),
    [
        ("normal", None, 0.0009, 0.0, ALL[:1]),  # bending would not find so much
        ("normal", None, 0.0007, 0.006, ALL[:3]),  # nor would mending make up for as many metres
        ("normal", None, 0.0007, 0.004, ALL),
        ("normal", 1.0, 0.014, 0.02, ALL),  # who is not bent is mended in another way
        ("normal", 1.0, 0.016, 0.0, ALL[:1]),
        ("quick", None, 0.014, 0.02, ALL),
        ("high", None, 0.014, 0.02, ALL),
        ("high", None, 0.016, 0.0, ALL[:1]),
    ],
)
def test_tours_without_hope_are_not_mended(
    monkeypatch: pytest.MonkeyPatch,
    effort: Effort,
    turn_rate_rad_s: float | None,
    unseen: float,
    over: float,
    done: list[str],
) -> None:
    made: list[str] = []

    def told(name: str, answer: object) -> object:
        made.append(name)
        return answer

    here = context(replace(YARD, fleet=replace(YARD.fleet, turn_rate_rad_s=turn_rate_rad_s)).with_effort(effort))
    points = no_points()
    spot = Tour(vertices_m=np.zeros((1, 2)), period_class=0, period_s=60, robots=1, robot=here.problem.robot)
    bent, late = [spot], Late(tours=[spot], met=False, fits=False, extra=points)
    cooled = Cooled(unseen_share=unseen, over_budget_share=0.0, tours=[spot])
    monkeypatch.setattr(cooling, "annealed", lambda *_args, **_kinds: told("anneal", cooled))
    monkeypatch.setattr(cooling, "shortened", lambda *_args: told("bend", bent))
    monkeypatch.setattr(cooling, "settle", lambda *_args, **_kinds: told("mend", late))
    monkeypatch.setattr(cooling, "over_budget_share", lambda given: over if given is bent else 0.04)
    begun = Cooled(unseen_share=0.01, over_budget_share=0.0, tours=[spot])
    settled = list(cooling.cooled_and_settled(here, begun, seed=0))  # type: ignore[arg-type]
    assert made == done
    assert settled == ([None] if done == ALL else [])


@pytest.mark.parametrize(
    ("effort", "overs", "made"),
    [
        ("high", [0.002, 0.001, 0.0], [5, 15, 25]),  # close, closer, within the budgets
        ("high", [0.001, 0.003, 0.0], [5, 15, 25]),  # one poor chance ends nothing
        ("high", [0.003, 0.0], [5]),  # with these tours it would be more than luck
        ("high", [0.001] * 9, [5, 15, 25, 35, 45, 55]),
        ("normal", [0.001, 0.0], [5]),
    ],
)
def test_tours_that_come_close_have_more_chances(
    monkeypatch: pytest.MonkeyPatch, effort: Effort, overs: list[float], made: list[int]
) -> None:
    tried: list[int] = []
    within = object()

    def cooled(_context: Context, _search: Annealing, *, seed: int) -> Generator[object, None, float]:
        tried.append(seed)
        over = overs[len(tried) - 1]
        yield within if over == 0 else None
        return over or math.inf

    monkeypatch.setattr(cooling, "cooled_and_settled", cooled)
    here = context(YARD.with_effort(effort))
    _, samples = prepared_with(here.problem, no_points())
    spot = Tour(vertices_m=np.array([[3.0, 3.0]]), period_class=0, period_s=60, robots=1, robot=here.problem.robot)
    search = Annealing(
        [spot], samples, here.problem.paths.grid,
        price=np.ones(1), over_price=np.ones(1), seed=0, range_margin_m=here.problem.range_margin_m,
    )  # fmt: skip
    found = list(cooling.cool_and_settle(here, search, seed=5))
    assert tried == made
    assert found == [None if over > 0 else within for over in overs[: len(made)]]


@pytest.mark.parametrize(
    ("mendings", "winner"),
    [
        ([[None, None, "a"], [None, "b"], [None, "c"]], "b"),  # after the fewest mendings, the first of several
        ([[None, None], [None, None, None, "b"]], "b"),
        ([["a"], ["b"]], "a"),
        ([[None], []], None),
        ([], None),
    ],
)
@pytest.mark.parametrize("cores", [1, 2, 8])
def test_the_first_to_pass_wins_on_any_number_of_cores(
    monkeypatch: pytest.MonkeyPatch, mendings: list[list[str | None]], winner: str | None, cores: int
) -> None:
    made: list[int] = []

    def cooled(here: Context, search: int, *, seed: int) -> Iterator[str | None]:
        assert seed == 7 + 100 * search
        for found in mendings[search]:
            time.sleep(0.002 * (len(mendings) - search))  # the less promising are ahead of the others
            if here.should_stop():
                return
            made.append(search)
            yield found

    monkeypatch.setattr(tours, "cool_and_settle", cooled)
    monkeypatch.setattr(tours.os, "cpu_count", lambda: cores)
    found = tours.first_to_pass(context(YARD), list(range(len(mendings))), seed=7)  # type: ignore[arg-type]
    assert found == winner
    if cores == 1 and winner == "b" and len(mendings) == 3:
        assert made == [0, 0, 0, 1, 1, 2]  # the last one is beaten once it failed to pass at first


class Shaped(NamedTuple):
    """What ``in_full`` reads of a search, and what it was asked for."""

    shortfall_m: float
    began: int
    seed: int
    dear: float


@pytest.mark.parametrize(
    ("effort", "begun", "expected"),
    [
        ("quick", 3, [(0, 5, 1), (1, 105, 1)]),  # one each of the two most promising, in their order
        ("quick", 1, [(0, 5, 1)]),
        ("quick", 0, []),
        # of each kind the four that lack least
        (
            "high",
            4,
            [(0, 5, 1), (1, 105, 1), (3, 305, 1), (0, 405, 2), (2, 605, 2), (1, 505, 2), (0, 805, 1), (0, 1205, 2)],
        ),
        (
            "high",
            1,
            [(0, 5, 1), (0, 105, 2), (0, 405, 1), (0, 305, 2), (0, 605, 1), (0, 505, 2), (0, 805, 1), (0, 905, 2)],
        ),
    ],
)
def test_of_many_seeds_those_that_lack_least_go_on(
    monkeypatch: pytest.MonkeyPatch, effort: Effort, begun: int, expected: list[tuple[int, int, float]]
) -> None:
    lacks_m = {5: 5.0, 105: 9.0, 205: 47.0, 305: 3.0, 405: 4.0, 505: 8.0, 605: 2.0, 705: 46.0}

    def shaped(here: Context, given: list[Tour], *, seed: int) -> Shaped:
        return Shaped(shortfall_m=lacks_m.get(seed, 40.0), began=given[0].period_class, seed=seed, dear=here.dear)

    monkeypatch.setattr(tours, "shaped", shaped)
    here = context(YARD.with_effort(effort))
    spot = Tour(vertices_m=np.zeros((1, 2)), period_class=0, period_s=60, robots=1, robot=here.problem.robot)
    searches = tours.in_full(here, [[replace(spot, period_class=k)] for k in range(begun)], seed=5)
    found = [(one.began, one.seed, one.dear) for one in searches if isinstance(one, Shaped)]
    assert len(found) == len(searches)
    assert sorted(found) == sorted(expected)
    assert [seed for _, seed, _ in found] == sorted(seed for _, seed, _ in found)  # in the order they began
