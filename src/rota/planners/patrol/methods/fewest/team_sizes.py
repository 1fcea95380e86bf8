"""Where the search over team sizes begins, estimated from the lengths of first tours and of ideal lanes."""

from __future__ import annotations

import math

from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.initial.allocation import PeriodGrouping, detour_factor, robots_per_tour, slack_factor


def coverage_weight_for(groupings: list[PeriodGrouping]) -> float:
    """Multiple of the weight of seeing on open ground: the longer the detours round obstacles, the more.

    Where first tours are at most one and a half times as long as ideal ones, ground is open.
    """
    return min(6.0, max(1.0, detour_factor(groupings) / 1.5))


def most_slack(problem: Problem, robots: int) -> float:
    """A slack factor that so many robots do not exceed, whatever their tours: inf where that hangs on these.

    With one period all tours together have the robots' budgets, and all their ground is what is asked. Where there are
    several periods tours are grouped, and robots that hardly move see more than lanes would.
    """
    period_s, asked_m = problem.periods_s[0], problem.lanes_m(problem.asked_m2)
    budget_m = period_s * problem.pace_m_s
    if len(problem.periods_s) > 1 or budget_m < 2 * math.pi * problem.reach_m or asked_m == 0:
        return math.inf
    return robots * budget_m / asked_m


def sure_team_size(groupings: list[PeriodGrouping]) -> int:
    """The fewest robots that the first tours of some grouping need as they are."""
    return min(sum(tour.robots for tour in grouping.tours) for grouping in groupings)


def smallest_with_slack(groupings: list[PeriodGrouping], slack: float) -> int:
    """The fewest robots with which the slack factor of some grouping is at least this.

    More robots have no less slack, so that doubling and halving find it: where turning takes minutes they are many
    thousands.
    """

    def have_slack(robots: int) -> bool:
        handed = ((grouping, robots_per_tour(grouping, robots)) for grouping in groupings)
        return any(
            counts is not None and slack_factor(grouping.with_robots(counts)) >= slack for grouping, counts in handed
        )

    enough = min(len(grouping.tours) for grouping in groupings)
    step = 1
    while not have_slack(enough):
        enough, step = enough + step, 2 * step
    too_few = enough - step // 2  # the last step led away from there
    while enough - too_few > 1:
        middle = (too_few + enough) // 2
        too_few, enough = (too_few, middle) if have_slack(middle) else (middle, enough)
    return enough
