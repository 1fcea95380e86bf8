"""Ways to share the ground among so many robots: which period classes go together, and who keeps to a tour alone."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.initial.first_tours import Ground, class_groups, grounds, shared_tour, tours_apart
from rota.planners.patrol.initial.nested_loops import HANDINGS, WINDING, can_nest, nested, slowest
from rota.planners.patrol.initial.standing import robots_stand
from rota.planners.patrol.tours.tour import Tour, tour_length_m

NEST_BELOW = 1.4  # budgets over ideal lengths, below which loops within loops are tried
MOST_APART = 64  # robots, beyond which each on a tour of its own is not tried


@dataclass(frozen=True, kw_only=True)
class Start:
    """One way to group the period classes: the grounds, a tour past each, and the metres of ideal lanes over each."""

    grounds: list[Ground]
    tours: list[Tour]
    ideal_m: list[float]


def starts(problem: Problem, most: int) -> list[Start]:
    """Up to ``most`` ways to group the classes, the fewest expected robots first."""
    found = []
    for groups, _ in zip(class_groups(problem), range(most), strict=False):
        here = grounds(problem, groups)
        tours = [shared_tour(problem, ground) for ground in here]
        found.append(Start(grounds=here, tours=tours, ideal_m=ideal_lengths_m(problem, tours)))
    return found


def ideal_lengths_m(problem: Problem, tours: list[Tour]) -> list[float]:
    """Metres that each tour would take if it swept its ground in perfect lanes.

    A tour's ground: what asks for its period or a longer one, up to the next longer period of a tour; shared among the
    tours of one period in proportion to their lengths. No tour is ideal below a hundredth of its own length. Robots
    that stand need no more than they move.
    """
    served = sorted({tour.period_class for tour in tours})
    found = []
    for tour in tours:
        if robots_stand(problem, tour.period_s):
            found.append(tour_length_m(tour))
            continue
        later = [c for c in served if c > tour.period_class]
        classes = range(tour.period_class, min(later, default=len(problem.periods_s)))
        ground_m2 = sum(
            region.shape.area
            for region, c in zip(problem.regions, problem.region_class, strict=True)
            if c in classes and region.demand == "every_point"
        )
        own_m = tour_length_m(tour)
        alike_m = sum(tour_length_m(other) for other in tours if other.period_class == tour.period_class)
        share = own_m / alike_m if alike_m > 0 else 1.0
        found.append(max(0.01 * own_m, share * ground_m2 / problem.swath_m))
    return found


def winding(ways: list[Start]) -> float:
    """How many times longer than ideal the shortest first tours are: near 1 in the open, more in buildings."""
    return min(sum(tour_length_m(tour) for tour in way.tours) / max(1e-9, sum(way.ideal_m)) for way in ways)


def robots_each(start: Start, robots: int) -> list[int] | None:
    """So many robots handed to the tours, each where the load is greatest.

    None when there are fewer than tours, or more but no tour with anything to do: robots that stand need no others.
    """
    if robots < len(start.tours) or (robots > len(start.tours) and not any(start.ideal_m)):
        return None
    one_m = [replace(tour, robots=1).budget_m for tour in start.tours]
    counts = [1] * len(one_m)
    for _ in range(robots - len(one_m)):
        k = int(np.argmax([m / (n * b) for m, n, b in zip(start.ideal_m, counts, one_m, strict=True)]))
        counts[k] += 1
    return counts


def squeeze(start: Start, counts: list[int]) -> float:
    """How much longer than ideal the tours may be with so many robots each; below 1 there is no hope.

    A tour may serve any ground of its component whose period is at least its own: within each component, all that
    the quickest classes ask for must fit into the budgets of the tours of these classes.
    """
    return min((room for _, room in squeezes(start, counts)), default=math.inf)


def squeezes(start: Start, counts: list[int]) -> Iterator[tuple[int, float]]:
    """The same for each class that tours serve, in each component: the class, and how much longer the tours may be."""
    for component in {tour.component for tour in start.tours}:
        here = [k for k, tour in enumerate(start.tours) if tour.component == component]
        for period_class in {start.tours[k].period_class for k in here}:
            quick = [k for k in here if start.tours[k].period_class <= period_class]
            asked_m = sum(start.ideal_m[k] for k in quick)
            budget_m = sum(replace(start.tours[k], robots=counts[k]).budget_m for k in quick)
            if asked_m > 0:
                yield period_class, budget_m / asked_m


def nest_bases(problem: Problem, start: Start, counts: list[int], robots: int) -> list[Start]:
    """What loops within loops may be built on: the robots as their loads are, or as few on quick ground as can be.

    In the second every quick ground has as many robots as it needs, that take turns on one hub, and the slowest the
    rest; in the third each of these robots has a hub of its own.
    """
    bases = [with_counts(start, counts)]
    one_m = [replace(tour, robots=1).budget_m for tour in start.tours]
    load = [m / b for m, b in zip(start.ideal_m, one_m, strict=True)]
    slow = slowest(start.tours, load)
    needed = [1 if k == slow else max(1, math.ceil(WINDING * x)) for k, x in enumerate(load)]
    needed[slow] += robots - sum(needed)
    if needed[slow] < 1:
        return bases
    if needed != counts:
        bases.append(with_counts(start, needed))
    if max((n for k, n in enumerate(needed) if k != slow), default=1) > 1:
        alone = hubs_apart(problem, start, needed, slow)
        if sum(tour.robots for tour in alone.tours) == robots:
            bases.append(alone)
    return bases


def with_counts(start: Start, counts: list[int]) -> Start:
    """The start with so many robots on each of its tours."""
    return replace(start, tours=[replace(tour, robots=n) for tour, n in zip(start.tours, counts, strict=True)])


def hubs_apart(problem: Problem, start: Start, needed: list[int], slow: int) -> Start:
    """The start with so many robots, each of them on a tour of its own but for those of the slowest tour."""
    hubs: list[tuple[Ground, Tour, float]] = []
    for k, (ground, tour, ideal_m) in enumerate(zip(start.grounds, start.tours, start.ideal_m, strict=True)):
        apart = tours_apart(problem, ground, needed[k]) if k != slow and needed[k] > 1 else [tour]
        whole_m = sum(tour_length_m(one) for one in apart)
        for one in apart:
            share = tour_length_m(one) / whole_m if whole_m > 0 else 1 / len(apart)
            hubs.append((ground, replace(one, robots=needed[k] if k == slow else 1), share * ideal_m))
    return Start(grounds=[g for g, _, _ in hubs], tours=[t for _, t, _ in hubs], ideal_m=[m for *_, m in hubs])


def nests_on(
    problem: Problem, bases: list[Start], least_squeeze: float, *, handings: int = 1, scattered: bool = False
) -> Iterator[Split]:
    """The loops within loops on these bases, where neither the quick tours nor the rest are too tight.

    The way to every piece of slow ground and back makes them longer than a tour of it all. handings: how many ways to
    hand ground to excursions are tried; scattered: with excursions from different vertices, too.
    """
    for base, apart in itertools.product(bases, (False, True) if scattered else (False,)):
        latest = max(tour.period_class for tour in base.tours)
        hubs = [room for period_class, room in squeezes(base, [t.robots for t in base.tours]) if period_class < latest]
        if min(hubs, default=math.inf) < least_squeeze:
            continue
        for handing in HANDINGS[:handings]:
            nest = nested(
                problem, base.grounds, base.tours, base.ideal_m, least_squeeze, scattered=apart, handing=handing
            )
            if nest is not None:
                yield Split(room=min([nest[0], *hubs]), tours=nest[1], nests=True)


@dataclass(frozen=True, kw_only=True)
class Split:
    """The tours to begin with, and how many times longer than ideal they may be; ``nests``: loops within loops."""

    room: float
    tours: list[Tour]
    nests: bool


def splits(
    problem: Problem,
    ways: list[Start],
    robots: int,
    least_squeeze: float,
    *,
    handings: int = 1,
    scattered: bool = False,
) -> list[Split]:
    """The tours to begin with for so many robots, every way in which they might suffice; the roomiest first.

    Robots that would share a tour are tried on tours of their own too, and where budgets are tight loops within loops,
    of which ``handings`` and ``scattered`` tell how many (see ``nests_on``).
    """
    found: list[Split] = []
    nests: list[Split] = []
    seen: set[tuple[tuple[int, int], ...]] = set()
    for start in ways:
        counts = robots_each(start, robots)
        if counts is None:
            continue
        room = squeeze(start, counts)
        shared = with_counts(start, counts).tours
        if can_nest(problem) and room < NEST_BELOW:
            bases = nest_bases(problem, start, counts, robots)
            nests += nests_on(problem, bases, least_squeeze, handings=handings, scattered=scattered)
        if room < least_squeeze:
            continue
        found.append(Split(room=room, tours=shared, nests=False))
        shape = tuple(sorted((tour.period_class, tour.robots) for tour in shared))
        if 1 < max(counts) <= MOST_APART and (shape not in seen or problem.robot.body_radius_m > 0):
            apart = [
                one
                for ground, tour in zip(start.grounds, shared, strict=True)
                for one in (tours_apart(problem, ground, tour.robots) if tour.robots > 1 else [tour])
            ]
            if len(apart) == robots:
                alone = [replace(tour, robots=1) for tour in apart]
                found.append(Split(room=room, tours=alone, nests=False))
        seen.add(shape)
    return sorted([*found, *nests], key=lambda split: -split.room)
