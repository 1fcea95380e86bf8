"""The fewest robots of a traditional method: groups of zones and reserves tried in turn, each repaired and judged."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from rota.errors import NoPlanFound
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.initial.first_tours import class_groups
from rota.planners.patrol.methods.sweeping.methods import Sweeping, decomposition, parallel, sequential
from rota.planners.patrol.methods.sweeping.routes import SweepGround, sweep_grounds
from rota.planners.patrol.repair.repair import Repaired, repair_until_feasible
from rota.planners.patrol.tours.tour import Tour, tour_length_m

LEAST_LANES = 0.95  # of area / swath: what a robot holds in view at either end of its lanes makes them shorter


@dataclass(frozen=True, kw_only=True)
class Proposal:
    """Tours that a method gives for one grouping of the period classes.

    reserve: number of the share of the budgets that is kept for the repair, among those of the settings.
    """

    tours: list[Tour]
    groups: tuple[tuple[int, ...], ...]
    reserve: int

    @property
    def rank(self) -> tuple[int, float]:
        """Robots, then travel."""
        return sum(tour.robots for tour in self.tours), sum(tour_length_m(tour) for tour in self.tours)


def sweep_sequentially(context: Context) -> Repaired:
    """The method ``sequential``: one route over everything, shared by robots; see ``sweep_with_fewest_robots``."""
    return sweep_with_fewest_robots(sequential, context)


def sweep_in_parallel(context: Context) -> Repaired:
    """The method ``parallel``: strips side by side, a robot each; see ``sweep_with_fewest_robots``."""
    return sweep_with_fewest_robots(parallel, context)


def sweep_decomposed(context: Context) -> Repaired:
    """The method ``decomposition``: sub-areas of a robot each; see ``sweep_with_fewest_robots``."""
    return sweep_with_fewest_robots(decomposition, context)


def sweep_with_fewest_robots(sweeping: Sweeping, context: Context) -> Repaired:
    """The best plan of a way to sweep ground in lanes (met unless all repair failed).

    The methods know one period; here the period classes are grouped in every way that could be best, a single group
    included, and each group's ground is swept at its shortest period by routes of its own. The proposals are repaired
    and judged, those with the fewest robots first; one that exceeds its budgets then comes back with a larger reserve.
    Raises NoPlanFound when no robot can stand near anything that is asked.
    """
    settings = context.settings
    tries, rounds = settings.sweeping.tries, settings.repair.rounds
    exact = replace(context, problem=judge_by_lanes(context.problem))
    proposals = list(first_proposals(sweeping, exact))
    if not proposals:
        raise NoPlanFound("no lane lies where a robot can be")
    best: Repaired | None = None
    last_resort = min(proposals, key=lambda proposal: proposal.rank)
    for turn in range(tries):
        proposals = sorted((p for p in proposals if is_smaller(p, best)), key=lambda proposal: proposal.rank)
        if not proposals or context.should_stop():
            break
        proposal = proposals.pop(0)
        context.progress(0.3 + 0.6 * turn / tries, f"trying {proposal.rank[0]} robots")
        repaired = repair_until_feasible(exact, proposal.tours, no_points(), may_add=False, rounds=rounds)
        if repaired.met and (best is None or repaired.robots < best.robots):
            best = repaired
        elif proposal.reserve + 1 < len(settings.sweeping.reserves):
            most = None if best is None else best.robots - 1
            careful = propose(sweeping, exact, proposal.groups, proposal.reserve + 1, most)
            proposals += [] if careful is None else [careful]
    if best is None:
        context.progress(0.9, "finishing with the robots that the repair asks for")
        rounds = settings.repair.patient_rounds
        best = repair_until_feasible(exact, last_resort.tours, no_points(), may_add=True, rounds=rounds)
    return best


def judge_by_lanes(problem: Problem) -> Problem:
    """The problem with points that stand for themselves alone: lanes leave no gaps between them, the check decides.

    Lanes that overlap are bent round obstacles, and what then lies between samples is covered as everywhere.
    """
    if problem.lanes_overlap_m > 0:
        return problem
    return replace(problem, points=replace(problem.points, shrink_m=0.0 * problem.points.shrink_m))


def is_smaller(proposal: Proposal, best: Repaired | None) -> bool:
    """Whether a proposal has fewer robots than the best plan."""
    return best is None or proposal.rank[0] < best.robots


def first_proposals(sweeping: Sweeping, context: Context) -> Iterator[Proposal]:
    """What the method gives for each grouping of the period classes, nothing kept in reserve."""
    groupings = list(class_groups(context.problem))[: context.settings.sweeping.groupings]
    fewest: int | None = None
    for k, groups in enumerate(groupings):
        context.progress(0.3 * k / len(groupings), "laying lanes")
        proposal = propose(sweeping, context, groups, 0, fewest)
        if proposal is not None and proposal.tours:
            fewest = min(proposal.rank[0], fewest or proposal.rank[0])
            yield proposal
        if context.should_stop():
            break


def propose(
    sweeping: Sweeping, context: Context, groups: tuple[tuple[int, ...], ...], reserve: int, most: int | None
) -> Proposal | None:
    """The method's tours over the ground of every group and component; None when they are surely more than ``most``."""
    problem, share = context.problem, context.settings.sweeping.reserves[reserve]
    left = sweep_grounds(problem, groups)
    tours: list[Tour] = []
    while left:
        ground = left.pop(0)
        others = sum(tour.robots for tour in tours) + sum(least_robots(problem, ground) for ground in left)
        allowed = None if most is None else most - others
        if allowed is not None and least_robots(problem, ground) > allowed:
            return None
        swept = sweeping(problem, ground, share, allowed)
        if swept is None:
            return None
        tours += swept
    return Proposal(tours=tours, groups=groups, reserve=reserve)


def least_robots(problem: Problem, ground: SweepGround) -> int:
    """Robots below which no lanes over a ground can keep its period: its area over what one sweeps."""
    swept_m2 = problem.swath_m * problem.pace_m_s * problem.periods_s[ground.period_class]
    return max(1, math.ceil(LEAST_LANES * float(ground.shape.area) / swept_m2))
