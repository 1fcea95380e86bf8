"""The fewest robots of a traditional method: groups of zones and reserves tried in turn, each mended and judged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from rota.errors import NoPlanFound
from rota.mission import Method
from rota.planners.patrol.annealing.search import Tour, tour_length_m
from rota.planners.patrol.classic.methods import METHODS
from rota.planners.patrol.classic.routes import grounds
from rota.planners.patrol.context import Context
from rota.planners.patrol.problem import Problem
from rota.planners.patrol.repair import Settled, no_points, settle
from rota.planners.patrol.start.first_tours import class_groups

GROUPINGS = 8  # ways to group the period classes that are tried, the most promising first
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


def fewest_robots_of(method: Method, context: Context) -> Settled:
    """The best settled plan of a traditional method (met unless all repair failed).

    The methods know one period; here the period classes are grouped in every way that could be best, a single group
    included, and each group's ground is swept at its shortest period by routes of its own. The proposals are mended
    and judged, those with the fewest robots first; one that mending drives over its budgets comes back with more kept
    in reserve. Raises NoPlanFound when no robot can stand near anything that is asked.
    """
    exact = replace(context, problem=judged_by_lanes(context.problem))
    proposals = list(first_proposals(method, exact))
    if not any(proposal.tours for proposal in proposals):
        raise NoPlanFound("no lane lies where a robot can be")
    best: Settled | None = None
    last_resort = min(proposals, key=lambda proposal: proposal.rank)
    for turn in range(context.work.tries):
        proposals = sorted((p for p in proposals if worth_a_try(p, best)), key=lambda proposal: proposal.rank)
        if not proposals or context.should_stop():
            break
        proposal = proposals.pop(0)
        context.progress(0.3 + 0.6 * turn / context.work.tries, f"trying {proposal.rank[0]} robots")
        found = settle(exact, proposal.tours, no_points(), may_add=False, rounds=context.work.repairs)
        if found.met and found.fits and (best is None or len(found.plan.trajectories) < len(best.plan.trajectories)):
            best = found
        elif proposal.reserve + 1 < len(RESERVES):
            proposals.append(proposed(method, exact.problem, proposal.groups, proposal.reserve + 1))
    if best is None:
        context.progress(0.9, "finishing with the robots that mending asks for")
        best = settle(exact, last_resort.tours, no_points(), may_add=True, rounds=3 * context.work.repairs)
    return best


def judged_by_lanes(problem: Problem) -> Problem:
    """The problem with points that stand for themselves alone: lanes leave no gaps between them, the check decides."""
    return replace(problem, points=replace(problem.points, shrink_m=0.0 * problem.points.shrink_m))


def worth_a_try(proposal: Proposal, best: Settled | None) -> bool:
    """Whether a proposal has tours at all, and fewer robots than the best plan."""
    return bool(proposal.tours) and (best is None or proposal.rank[0] < len(best.plan.trajectories))


def first_proposals(method: Method, context: Context) -> Iterator[Proposal]:
    """What the method gives for each grouping of the period classes, nothing kept in reserve."""
    ways = list(class_groups(context.problem))[:GROUPINGS]
    for k, groups in enumerate(ways):
        context.progress(0.3 * k / len(ways), "laying lanes")
        yield proposed(method, context.problem, groups, 0)
        if context.should_stop():
            break


def proposed(method: Method, problem: Problem, groups: tuple[tuple[int, ...], ...], reserve: int) -> Proposal:
    """The method's tours over the ground of every group and part."""
    tours = [
        tour for ground in grounds(problem, groups) for tour in METHODS[method](problem, ground, RESERVES[reserve])
    ]
    return Proposal(tours=tours, groups=groups, reserve=reserve)
