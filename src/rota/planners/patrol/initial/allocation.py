"""Which tours a team size begins with: period classes grouped, robots handed to the groups, nested loops besides."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from rota.model.mission import inner_reach_m
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.initial.first_tours import (
    DETOUR,
    PlaceGroup,
    class_groups,
    place_groups,
    shared_tour,
    tours_apart,
)
from rota.planners.patrol.initial.nested_loops import can_nest, nest_tours, slowest
from rota.planners.patrol.initial.standing import robots_stand
from rota.planners.patrol.settings import AllocationSettings
from rota.planners.patrol.tours.tour import Tour, tour_length_m


@dataclass(frozen=True, kw_only=True)
class PeriodGrouping:
    """One way to group the period classes.

    groups: the places of each tour. tours: one for each. ideal_m: metres of ideal lanes over the ground of each.
    """

    groups: list[PlaceGroup]
    tours: list[Tour]
    ideal_m: list[float]

    def with_robots(self, robots: list[int]) -> PeriodGrouping:
        """The same grouping with so many robots on each of its tours."""
        tours = [replace(tour, robots=n) for tour, n in zip(self.tours, robots, strict=True)]
        return replace(self, tours=tours)


@dataclass(frozen=True, kw_only=True)
class Allocation:
    """Tours that the search may begin with.

    slack: the slack factor that they are ranked by. nested: whether some are nested loops.
    """

    slack: float
    tours: list[Tour]
    nested: bool


def period_groupings(problem: Problem, most: int) -> list[PeriodGrouping]:
    """Up to ``most`` ways to group the period classes, those with the fewest expected robots first."""
    groupings = []
    for classes, _ in zip(class_groups(problem), range(most), strict=False):
        groups = place_groups(problem, classes)
        tours = [shared_tour(problem, group) for group in groups]
        groupings.append(PeriodGrouping(groups=groups, tours=tours, ideal_m=ideal_lengths_m(problem, tours)))
    return groupings


def ideal_lengths_m(problem: Problem, tours: list[Tour]) -> list[float]:
    """Metres that each tour would take if it swept its ground in perfect lanes.

    A tour's ground asks for its period or a longer one, up to the next longer period of a tour; tours of one period
    share it in proportion to their lengths. No tour is ideal below a hundredth of its own length. Robots that stand
    need no more than they move.
    """
    served = sorted({tour.period_class for tour in tours})
    ideal_m = []
    for tour in tours:
        own_m = tour_length_m(tour)
        if robots_stand(problem, tour.period_s):
            ideal_m.append(own_m)
            continue
        later = [c for c in served if c > tour.period_class]
        classes = range(tour.period_class, min(later, default=len(problem.periods_s)))
        ground_m2 = sum(
            region.shape.area
            for region, c in zip(problem.regions, problem.region_class, strict=True)
            if c in classes and region.demand == "every_point"
        )
        alike_m = sum(tour_length_m(other) for other in tours if other.period_class == tour.period_class)
        share = own_m / alike_m if alike_m > 0 else 1.0
        ideal_m.append(max(0.01 * own_m, share * problem.lanes_m(ground_m2)))
    return ideal_m


def detour_factor(groupings: list[PeriodGrouping]) -> float:
    """How many times longer than ideal the shortest first tours are: near 1 in the open, more in buildings."""
    return min(
        sum(tour_length_m(tour) for tour in grouping.tours) / max(1e-9, sum(grouping.ideal_m)) for grouping in groupings
    )


def robots_per_tour(grouping: PeriodGrouping, robots: int) -> list[int] | None:
    """So many robots handed to the tours one by one, each where the load is greatest.

    None when there are fewer than tours, or more but no tour with anything to do: robots that stand need no others.
    """
    if robots < len(grouping.tours) or (robots > len(grouping.tours) and not any(grouping.ideal_m)):
        return None
    budgets_m = single_budgets_m(grouping)
    counts = [1] * len(budgets_m)
    for _ in range(robots - len(budgets_m)):
        k = int(np.argmax([m / (n * b) for m, n, b in zip(grouping.ideal_m, counts, budgets_m, strict=True)]))
        counts[k] += 1
    return counts


def single_budgets_m(grouping: PeriodGrouping) -> list[float]:
    """The budget of each tour with one robot on it."""
    return [replace(tour, robots=1).budget_m for tour in grouping.tours]


def as_lanes_m(tour: Tour) -> float:
    """Metres of lane that see as much as a convex tour of the tour's budget does.

    Those who go round a convex ring of length L see pi r^2 + r L of ground outside of it or on it, and inside all if it
    is small: L^2 / (4 pi) in a circle. From L = 2 pi r on lanes see more.
    """
    budget_m, reach_m = tour.budget_m, inner_reach_m(tour.robot.sensor)
    if budget_m >= 2 * math.pi * reach_m or driving_of(tour.robot).has_mass:
        return budget_m
    return (math.pi * reach_m**2 + reach_m * budget_m + budget_m**2 / (4 * math.pi)) / (2 * reach_m)


def slack_factor(
    grouping: PeriodGrouping, tours: list[Tour] | None = None, worth_m: Callable[[Tour], float] = as_lanes_m
) -> float:
    """How many times the lanes asked for the tours may see with the robots they have; below 1 there is little hope.

    A tour may serve any ground of its component whose period is at least its own: within each component, all that
    the quickest classes ask for must fit into what the tours of these classes see. inf without such ground.
    tours: those that are to serve the grouping's ground; None: its own. worth_m: how many metres of lane a tour is.
    """
    return min((slack for _, slack in slack_factors(grouping, tours, worth_m)), default=math.inf)


def slack_factors(
    grouping: PeriodGrouping, tours: list[Tour] | None = None, worth_m: Callable[[Tour], float] = as_lanes_m
) -> Iterator[tuple[int, float]]:
    """Each class that tours of a component serve, and the slack factor of the tours of it and all quicker classes."""
    serving = grouping.tours if tours is None else tours
    for component in {tour.component for tour in grouping.tours}:
        own = [k for k, tour in enumerate(grouping.tours) if tour.component == component]
        for period_class in {grouping.tours[k].period_class for k in own}:
            asked_m = sum(grouping.ideal_m[k] for k in own if grouping.tours[k].period_class <= period_class)
            quick = [t for t in serving if t.component == component and t.period_class <= period_class]
            if asked_m > 0:
                yield period_class, sum(worth_m(tour) for tour in quick) / asked_m


def allocations(
    problem: Problem,
    groupings: list[PeriodGrouping],
    robots: int,
    settings: AllocationSettings,
    *,
    least_slack: float,
) -> list[Allocation]:
    """Every set of tours with which so many robots might do; the ones with most slack first.

    Robots that would share a tour are tried on tours of their own too, and nested loops where budgets are tight. Tours
    of their own count with the slack of shared ones, for there is no telling which see more of what lies between walls.
    least_slack: allocations with a smaller slack factor are left out.
    """
    plain: list[Allocation] = []
    nested_loops: list[Allocation] = []
    seen: set[tuple[tuple[int, int], ...]] = set()
    for grouping in groupings:
        counts = robots_per_tour(grouping, robots)
        if counts is None:
            continue
        shared = grouping.with_robots(counts)
        slack = slack_factor(shared)
        if can_nest(problem) and slack < settings.nested_slack_limit:
            bases = nesting_bases(problem, grouping, counts, robots)
            nested_loops += nested_allocations(problem, bases, settings, least_slack=least_slack)
        if slack >= least_slack:
            plain.append(Allocation(slack=slack, tours=shared.tours, nested=False))
        shape = tuple(sorted((tour.period_class, tour.robots) for tour in shared.tours))
        fresh = shape not in seen or problem.robot.body_radius_m > 0
        if 1 < max(counts) <= 64 and fresh:  # tours for more robots take long to lay
            tours = own_tours(problem, shared)
            if len(tours) == robots and slack_factor(shared, tours) >= least_slack:
                plain.append(Allocation(slack=slack, tours=tours, nested=False))
        seen.add(shape)
    return sorted([*plain, *nested_loops], key=lambda allocation: -allocation.slack)


def own_tours(problem: Problem, shared: PeriodGrouping) -> list[Tour]:
    """A tour for each robot, where neighbourhoods of its own can be found for it."""
    tours: list[Tour] = []
    for group, tour in zip(shared.groups, shared.tours, strict=True):
        tours += tours_apart(problem, group, tour.robots) if tour.robots > 1 else [tour]
    return [replace(tour, robots=1) for tour in tours]


def nesting_bases(problem: Problem, grouping: PeriodGrouping, counts: list[int], robots: int) -> list[PeriodGrouping]:
    """What nested loops may be built on: the robots as their loads are, or as few on quick ground as can be.

    In the second every quick ground has as many robots as it needs, that take turns on one hub, and the slowest the
    rest; in the third each of these robots has a hub of its own.
    """
    bases = [grouping.with_robots(counts)]
    load = [m / b for m, b in zip(grouping.ideal_m, single_budgets_m(grouping), strict=True)]
    slow = slowest(grouping.tours, load)
    needed = [1 if k == slow else max(1, math.ceil(DETOUR * x)) for k, x in enumerate(load)]
    needed[slow] += robots - sum(needed)
    if needed[slow] < 1:
        return bases
    if needed != counts:
        bases.append(grouping.with_robots(needed))
    if max((n for k, n in enumerate(needed) if k != slow), default=1) > 1:
        separate = with_own_hubs(problem, grouping, needed, slow)
        if sum(tour.robots for tour in separate.tours) == robots:
            bases.append(separate)
    return bases


def with_own_hubs(problem: Problem, grouping: PeriodGrouping, needed: list[int], slow: int) -> PeriodGrouping:
    """The grouping with so many robots, each of them on a tour of its own but for those of the slowest tour."""
    hubs: list[tuple[PlaceGroup, Tour, float]] = []
    for k, (group, tour, ideal_m) in enumerate(zip(grouping.groups, grouping.tours, grouping.ideal_m, strict=True)):
        apart = tours_apart(problem, group, needed[k]) if k != slow and needed[k] > 1 else [tour]
        whole_m = sum(tour_length_m(hub) for hub in apart)
        for hub in apart:
            share = tour_length_m(hub) / whole_m if whole_m > 0 else 1 / len(apart)
            hubs.append((group, replace(hub, robots=needed[k] if k == slow else 1), share * ideal_m))
    return PeriodGrouping(groups=[g for g, _, _ in hubs], tours=[t for _, t, _ in hubs], ideal_m=[m for *_, m in hubs])


def nested_allocations(
    problem: Problem, bases: list[PeriodGrouping], settings: AllocationSettings, *, least_slack: float
) -> Iterator[Allocation]:
    """The nested loops on these bases, where neither the quick tours nor the rest are too tight.

    The way to every piece of slow ground and back makes them longer than a tour of it all.
    """
    for base, separate in itertools.product(bases, (False, True) if len(settings.estimates) > 1 else (False,)):
        latest = max(tour.period_class for tour in base.tours)
        hubs = [slack for period_class, slack in slack_factors(base) if period_class < latest]
        if min(hubs, default=math.inf) < least_slack:
            continue
        for estimate in settings.estimates:
            loops = nest_tours(
                problem, base.groups, base.tours, base.ideal_m,
                least_slack=least_slack, separate=separate, estimate=estimate,
            )  # fmt: skip
            if loops is not None:
                yield Allocation(slack=min([loops[0], *hubs]), tours=loops[1], nested=True)
