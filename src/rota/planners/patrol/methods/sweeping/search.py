"""The fewest robots of a traditional method: groups of zones and reserves tried in turn, each mended and judged."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from rota.errors import NoPlanFound
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.initial.first_tours import class_groups
from rota.planners.patrol.methods.sweeping.methods import Sweeping
from rota.planners.patrol.methods.sweeping.routes import Ground, grounds
from rota.planners.patrol.repair.repair import Settled, settle
from rota.planners.patrol.tours.tour import Tour, tour_length_m

GROUPINGS = 8  # ways to group the period classes that are tried, the most promising first
LEAST_LANES = 0.95  # of area / swath: what a robot holds in view at either end of its lanes makes them shorter
RESERVES = (0.0, 0.02, 0.05, 0.1, 0.2)  # shares of the budgets kept for mending, one after the other


@dataclass(frozen=True, kw_only=True)
class Proposal:
    """Tours that a method gives for one grouping of the period classes and one reserve."""

    tours: list[Tour]
    groups: tuple[tuple[int, ...], ...]
    reserve: int

    @property
    def rank(self) -> tuple[int, float]:
        """Robots, then travel."""
        return sum(tour.robots for tour in self.tours), sum(tour_length_m(tour) for tour in self.tours)


def fewest_robots_of(sweeping: Sweeping, context: Context) -> Settled:
    """The best settled plan of a way to sweep ground in lanes (met unless all repair failed).

    The methods know one period; here the period classes are grouped in every way that could be best, a single group
    included, and each group's ground is swept at its shortest period by routes of its own. The proposals are mended
    and judged, those with the fewest robots first; one that mending drives over its budgets comes back with more kept
    in reserve. Raises NoPlanFound when no robot can stand near anything that is asked.
    """
    exact = replace(context, problem=judged_by_lanes(context.problem))
    proposals = list(first_proposals(sweeping, exact))
    if not proposals:
        raise NoPlanFound("no lane lies where a robot can be")
    best: Settled | None = None
    last_resort = min(proposals, key=lambda proposal: proposal.rank)
    for turn in range(context.work.tries):
        proposals = sorted((p for p in proposals if is_smaller(p, best)), key=lambda proposal: proposal.rank)
        if not proposals or context.should_stop():
            break
        proposal = proposals.pop(0)
        context.progress(0.3 + 0.6 * turn / context.work.tries, f"trying {proposal.rank[0]} robots")
        found = settle(exact, proposal.tours, no_points(), may_add=False, rounds=context.work.repairs)
        if found.met and found.fits and (best is None or len(found.plan.trajectories) < len(best.plan.trajectories)):
            best = found
        elif proposal.reserve + 1 < len(RESERVES):
            most = None if best is None else len(best.plan.trajectories) - 1
            careful = proposed(sweeping, exact.problem, proposal.groups, proposal.reserve + 1, most)
            proposals += [] if careful is None else [careful]
    if best is None:
        context.progress(0.9, "finishing with the robots that mending asks for")
        best = settle(exact, last_resort.tours, no_points(), may_add=True, rounds=3 * context.work.repairs)
    return best


def judged_by_lanes(problem: Problem) -> Problem:
    """The problem with points that stand for themselves alone: lanes leave no gaps between them, the check decides."""
    return replace(problem, points=replace(problem.points, shrink_m=0.0 * problem.points.shrink_m))


def is_smaller(proposal: Proposal, best: Settled | None) -> bool:
    """Whether a proposal has fewer robots than the best plan."""
    return best is None or proposal.rank[0] < len(best.plan.trajectories)


def first_proposals(sweeping: Sweeping, context: Context) -> Iterator[Proposal]:
    """What the method gives for each grouping of the period classes, nothing kept in reserve."""
    ways = list(class_groups(context.problem))[:GROUPINGS]
    fewest: int | None = None
    for k, groups in enumerate(ways):
        context.progress(0.3 * k / len(ways), "laying lanes")
        proposal = proposed(sweeping, context.problem, groups, 0, fewest)
        if proposal is not None and proposal.tours:
            fewest = min(proposal.rank[0], fewest or proposal.rank[0])
            yield proposal
        if context.should_stop():
            break


def proposed(
    sweeping: Sweeping, problem: Problem, groups: tuple[tuple[int, ...], ...], reserve: int, most: int | None
) -> Proposal | None:
    """The method's tours over the ground of every group and part; None when they surely are more than ``most``."""
    left = grounds(problem, groups)
    tours: list[Tour] = []
    while left:
        ground = left.pop(0)
        others = sum(tour.robots for tour in tours) + sum(least_robots(problem, ground) for ground in left)
        room = None if most is None else most - others
        if room is not None and least_robots(problem, ground) > room:
            return None
        found = sweeping(problem, ground, RESERVES[reserve], room)
        if found is None:
            return None
        tours += found
    return Proposal(tours=tours, groups=groups, reserve=reserve)


def least_robots(problem: Problem, ground: Ground) -> int:
    """Robots below which no lanes over a ground can keep its period: its area over what one sweeps."""
    swept_m2 = problem.swath_m * problem.robot.speed_m_s * problem.periods_s[ground.period_class]
    return max(1, math.ceil(LEAST_LANES * float(ground.shape.area) / swept_m2))
