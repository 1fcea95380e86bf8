"""The method ``tours``: closed tours over all zones at once, with as few robots as the search finds."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rota.mission import Effort
from rota.planners.patrol.annealing.schedule import annealed_all, shaped
from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.initial.allocation import Split, Start, robots_each, splits, squeeze, starts, winding
from rota.planners.patrol.methods.anneal_and_repair import cool_and_settle
from rota.planners.patrol.repair.repair import Settled, settle
from rota.planners.patrol.tours.tour import Tour

Floats = NDArray[np.float64]

EFFORTS: tuple[Effort, ...] = ("quick", "normal", "high")
HOPELESS = 0.045  # share of the ground unseen after a quarter of the moves: all of them bring down a fifth of it
NEST_HOPELESS = 0.09  # the same for loops within loops, of which they bring down four fifths
COMFORT = 1.3  # budgets of the robots tried first, as a multiple of the ideal lengths
OPEN = 1.5  # first tours on open ground are at most so many times longer than ideal
MOST_DEAR = 6.0  # times more than there that it is worth to see anything where the ways wind
WORTH_SEEDS = 1.5  # what others than the most promising split may lack then, as a multiple, to be begun with many seeds
DEARER = (1.0, 2.0)  # times what it is worth to see anything, in turn
NEST_GAIN = 0.8  # what loops within loops lack then, over what others lack that come as far in the end


def fewest_robots(context: Context) -> Settled:
    """The settled plan with the fewest robots found (met unless all repair failed).

    Every effort begins with what the lesser ones find and looks for fewer: more effort never takes more robots.
    """
    asked = context.problem.mission
    efforts = EFFORTS[: EFFORTS.index(asked.patrol.effort) + 1]
    best = None
    for turn, effort in enumerate(efforts):
        here = context if effort == asked.patrol.effort else with_less_effort(context, effort)
        best = with_fewer(replace(here, progress=part_of(context.progress, turn, len(efforts))), best)
        if context.should_stop() or (best.met and robots_of(best) <= context.enough_robots):
            break
    assert best is not None
    return best if best.plan.mission is asked else replace(best, plan=replace(best.plan, mission=asked))


def with_less_effort(context: Context, effort: Effort) -> Context:
    """The same search with less effort: a coarser lattice, less work, the same bound."""
    return replace(context, problem=set_up_problem(context.problem.mission.with_effort(effort)))


def part_of(progress: Callable[[float, str], None], turn: int, turns: int) -> Callable[[float, str], None]:
    """Progress told within one of so many turns."""
    return lambda share, what: progress((turn + share) / turns, what)


def robots_of(settled: Settled) -> int:
    """The robots of all its tours."""
    return sum(tour.robots for tour in settled.tours)


def with_fewer(context: Context, best: Settled | None) -> Settled:
    """The settled plan with the fewest robots found, the best one given if none has fewer.

    Begins with a number that should be comfortable and goes up until a plan is met; or, when the first one was, down
    one by one until none is, no further than the proved bound.
    """
    problem, work = context.problem, context.work
    ways = starts(problem, work.groupings)
    if problem.is_ragged and not work.searches_ragged:
        mended = as_they_are(context, ways)
        if mended.met:
            return mended
    context = replace(context, dear=worth_of_seeing(ways))
    comfortable = max(context.enough_robots, min(fewest_with_room(ways, COMFORT), surely_enough(ways)))
    if best is None or not best.met or robots_of(best) > comfortable + 1:
        best = comfortably(context, ways, comfortable, best)
        if robots_of(best) > comfortable:
            return best  # fewer were tried on the way up
    robots = first = robots_of(best)
    least = context.enough_robots
    while best.met and robots > least and not context.should_stop():
        robots -= 1
        share = (first - robots) / (first - least)
        context.progress(0.4 + 0.5 * share, f"trying {robots} robots")
        found = with_so_many(context, ways, robots, least_squeeze=work.least_squeeze)
        if found is None or robots_of(found) >= robots_of(best):
            break  # mending may post robots of their own
        best = found
    return best


def worth_of_seeing(ways: list[Start]) -> float:
    """How many times more than on open ground it is worth to see anything: the more, the more the ways wind."""
    return min(MOST_DEAR, max(1.0, winding(ways) / OPEN))


def comfortably(context: Context, ways: list[Start], robots: int, best: Settled | None) -> Settled:
    """A plan with so many robots or more, fewer than the best has; else the best; else as many as surely do.

    After some numbers tried one by one, the steps are an eighth.
    """
    fewest, most = robots, surely_enough(ways)
    turn = 0
    while turn < context.work.tries or robots < most:
        if best is not None and best.met and robots >= robots_of(best):
            return best
        context.progress(0.1 + 0.3 * (robots - fewest) / max(most, robots + 1 - fewest), f"trying {robots} robots")
        found = with_so_many(context, ways, robots, least_squeeze=1.0)
        if found is not None:
            return found
        if context.should_stop():
            break
        turn += 1
        robots += 1 if turn < context.work.tries else max(1, robots // 8)
    if best is not None and best.met:
        return best
    return as_they_are(context, ways)


def as_they_are(context: Context, ways: list[Start]) -> Settled:
    """The first tours mended until they pass, with as many robots as they then need."""
    context.progress(0.4, "finishing with the robots that surely suffice")
    return settle(context, ways[0].tours, no_points(), may_add=True, rounds=3 * context.work.repairs)


def fewest_with_room(ways: list[Start], room: float) -> int:
    """The fewest robots with which the budgets of some way are so many times the ideal lengths.

    More robots have no less room, so doubling and halving find it: where turning takes minutes they are thousands.
    """

    def have_room(robots: int) -> bool:
        handed = ((way, robots_each(way, robots)) for way in ways)
        return any(counts is not None and squeeze(way, counts) >= room for way, counts in handed)

    fewest = min(len(way.tours) for way in ways)
    step = 1
    while not have_room(fewest):
        fewest, step = fewest + step, 2 * step
    # the last step led here from too few robots
    too_few = fewest - step // 2
    while fewest - too_few > 1:
        middle = (too_few + fewest) // 2
        too_few, fewest = (too_few, middle) if have_room(middle) else (middle, fewest)
    return fewest


def surely_enough(ways: list[Start]) -> int:
    """The fewest robots that the first tours of some way need as they are."""
    return min(sum(tour.robots for tour in way.tours) for way in ways)


def with_so_many(context: Context, ways: list[Start], robots: int, *, least_squeeze: float) -> Settled | None:
    """A plan with so many robots that the judge passes, or None.

    All splits are annealed a little; then the most promising ones in full, as many at a time as there are cores.
    """
    seed = context.seed + 1000 * robots
    work = context.work
    tried = splits(context.problem, ways, robots, least_squeeze, handings=work.handings, scattered=work.scattered)
    begun = promising(context, tried, seed=seed)
    return first_to_pass(context, in_full(context, begun, seed=seed), seed=seed)


def first_to_pass(context: Context, searches: list[Annealing], *, seed: int) -> Settled | None:
    """The plan of the search that passes after the fewest mendings, the first of several; None when none passes.

    One stops as soon as another is ahead of it for good, so that the answer is the same on any number of cores.
    """
    passed_after: list[float] = [math.inf] * len(searches)

    def raced(turn: int) -> Settled | None:
        """What comes of one search; None, too, when another wins."""
        mended = 0

        def beaten() -> bool:
            return any((after, other) < (mended, turn) for other, after in enumerate(passed_after))

        here = replace(context, should_stop=lambda: context.should_stop() or beaten())
        for found in cool_and_settle(here, searches[turn], seed=seed + 100 * turn):
            if found is not None:
                passed_after[turn] = mended
                return found
            mended += 1
        return None

    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        found = list(pool.map(raced, range(len(searches))))
    return min(zip(passed_after, found, strict=True), key=lambda one: one[0], default=(math.inf, None))[1]


def promising(context: Context, begun: list[Split], *, seed: int) -> list[list[Tour]]:
    """The tours of the splits after a little annealing, the least shortfall first; none of those without hope.

    Loops within loops take longer to find their shape.
    """
    if len(begun) < 2:
        return [split.tours for split in begun]
    work = context.work
    some = (work.screened + 1) // 2
    nests = sifted(context, [split for split in begun if split.nests][: max(some, work.sifted)], some, seed=seed)
    begun = [*[split for split in begun if not split.nests][:some], *nests]
    tours = [split.tours for split in begun]
    searches = annealed_all(context, tours, moves=work.screening_moves, seed=seed, coarse=work.seeds > 1)
    ranked = []
    for split, search in zip(begun, searches, strict=True):
        if search.unseen_share <= (NEST_HOPELESS if split.nests else HOPELESS):
            ranked.append(((NEST_GAIN if split.nests else 1.0) * search.shortfall_m, search.tours))
    ranked.sort(key=lambda one: one[0])
    most = math.inf if work.seeds == 1 else WORTH_SEEDS * min((short for short, _ in ranked), default=0.0)
    return [tours for short, tours in ranked if short <= most]


def sifted(context: Context, begun: list[Split], most: int, *, seed: int) -> list[Split]:
    """So many of the splits at most, those that come best out of annealings that the better half of them goes through.

    The last is half as long as those of the screening, each before it half as long as the next.
    """
    rounds = max(0, math.ceil(math.log2(len(begun) / most))) if begun else 0
    for turn in range(rounds, 0, -1):
        moves = context.work.screening_moves >> turn
        searches = annealed_all(context, [split.tours for split in begun], moves=moves, seed=seed, coarse=True)
        order = sorted(range(len(begun)), key=lambda k: searches[k].shortfall_m)
        begun = [begun[k] for k in order[: max(most, (len(begun) + 1) // 2)]]
    return begun


def in_full(context: Context, begun: list[list[Tour]], *, seed: int) -> list[Annealing]:
    """The searches from these tours, the most promising first, that come nearest to what is asked, in their order.

    Several seeds begin from one, and every second makes it dearer to leave anything unseen: now this, now that finds
    the better shape. Neither kind is preferred.
    """
    work = context.work
    few = min(len(begun), work.whole)
    turns = range(few if work.seeds == 1 else work.whole * work.seeds)
    kind = [0 if few == 0 else turn // few % 2 for turn in turns]

    def search(turn: int) -> Annealing:
        here = replace(context, dear=DEARER[kind[turn]] * context.dear)
        return shaped(here, begun[turn % few], seed=seed + 100 * turn)

    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        found = list(pool.map(search, turns if few else ()))
    nearest = sorted(turns, key=lambda turn: found[turn].shortfall_m) if few else []
    alike = [[turn for turn in nearest if kind[turn] == one] for one in range(len(DEARER))]
    best = [turn for pair in itertools.zip_longest(*alike) for turn in pair if turn is not None]
    return [found[turn] for turn in sorted(best[: work.cooled])]
