"""Fewest robots where every demand is met from one place: rounds may come to a place several times, each in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rota.model.arrays import Floats
from rota.planners.patrol.context import Context
from rota.planners.patrol.cycles.in_step import with_one_less
from rota.planners.patrol.cycles.teams import Share, share_places
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.targets import Targets, draw_together, targets_of
from rota.planners.patrol.planner_settings import Effort, PatrolSettings
from rota.planners.patrol.repair.repair import Repaired, plan_of
from rota.planners.patrol.tolerances import SLOWER
from rota.planners.patrol.tours.tour import Pace, Tour

STATES: dict[Effort, int] = {"quick": 20_000, "normal": 100_000, "high": 400_000}  # looked at for some places
STATES_IN_STEP = 50  # times as many, of several robots together
ROUNDS: dict[Effort, int] = {"quick": 20, "normal": 60, "high": 200}  # in which large teams are made anew in parts
MOST_TARGETS = 100


@dataclass(frozen=True, kw_only=True)
class Team:
    """Who comes to which targets, in what time."""

    targets: Targets
    shares: list[Share]

    @property
    def robots(self) -> int:
        """The robots of all shares."""
        return sum(share.robots for share in self.shares)

    @property
    def is_plain(self) -> bool:
        """Whether no round comes to a place twice."""
        return all(share.is_plain for share in self.shares)


def teams_for_all(context: Context) -> list[Team]:
    """Teams that meet all demands from single places; none where some demand is not met so."""
    targets = targets_of(context.problem)
    return teams_for(context, targets) if meet_all(context.problem, targets) else []


def meet_all(problem: Problem, targets: Targets) -> bool:
    """Whether nothing is asked beside the targets."""
    return set(problem.points.region.tolist()) == set(targets.regions)


def teams_for(context: Context, targets: Targets) -> list[Team]:
    """Teams for the targets, those first that count least for corners; a later one takes more robots.

    Places near the borders of their zones are taken where that spares a robot. None for more than ``MOST_TARGETS``
    places, or fewer than two.
    """
    if not 1 < len(targets) <= MOST_TARGETS:
        return []
    teams, nearer = (teams_for_places(context, each) for each in (targets, draw_together(targets)))
    return nearer if nearer and nearer[-1].robots < teams[-1].robots else teams


def teams_for_places(context: Context, targets: Targets) -> list[Team]:
    """The same for the places as they are."""
    straight_s, turning_s = leg_times(context.problem, targets)
    teams = list[Team]()
    for share in (1.0, 0.5, 0.0):  # of what turning round at both ends of each leg takes
        if context.should_stop():
            break
        ways = np.isfinite(straight_s)
        legs_s = straight_s.copy()
        legs_s[ways] += share * (turning_s[ways] - straight_s[ways])
        team = Team(targets=targets, shares=best_shares(context, targets, legs_s))
        if not teams or team.robots < teams[0].robots:
            teams.insert(0, team)
        if np.array_equal(straight_s, turning_s):
            break
    return teams


def teams_in_step(context: Context, teams: Sequence[Team], enough: int) -> list[Team]:
    """The first team with fewer robots, no less than ``enough``, that share places in step; none where none was found.

    Robots that take time at corners keep no step.
    """
    if not teams or teams[0].robots <= enough or context.should_stop():
        return []
    targets = teams[0].targets
    straight_s, turning_s = leg_times(context.problem, targets)
    if not np.array_equal(straight_s, turning_s):
        return []
    most_states = STATES_IN_STEP * STATES[PatrolSettings.of(context.problem.mission).effort]
    shares = with_one_less(
        teams[0].shares, straight_s, targets.period_s, most_states=most_states, enough=enough,
        should_stop=context.should_stop,
    )  # fmt: skip
    team = Team(targets=targets, shares=shares)
    return [team] if team.robots < teams[0].robots else []


def leg_times(problem: Problem, targets: Targets) -> tuple[Floats, Floats]:
    """Seconds (n, n) from place to place, without and with turning round at both ends; inf where there is no way."""
    driving, places_m = driving_of(problem.robot), targets.places_m
    per_m = 1 / (driving.pace_m_s * SLOWER)
    way_m = problem.paths.all_pairs(places_m)
    there_and_back_m = way_m.copy()
    for i in range(len(places_m)):
        for k in range(i):
            if np.isfinite(way_m[i, k]):
                line_m = problem.paths.path(places_m[i], places_m[k])
                round_m = driving.round_m(np.vstack([line_m, line_m[-2:0:-1]]))
                there_and_back_m[i, k] = there_and_back_m[k, i] = max(way_m[i, k], round_m / 2)
    return way_m * per_m, there_and_back_m * per_m


def best_shares(context: Context, targets: Targets, legs_s: Floats) -> list[Share]:
    """The fewest robots found for such times of legs, in each part of the space by itself."""
    effort = PatrolSettings.of(context.problem.mission).effort
    shares = list[Share]()
    for part in np.unique(targets.component):
        own = np.flatnonzero(targets.component == part)
        found = share_places(
            legs_s[np.ix_(own, own)], targets.period_s[own], most_states=STATES[effort], rounds=ROUNDS[effort],
            seed=context.seed, should_stop=context.should_stop,
        )  # fmt: skip
        shares += [share._replace(order=own[share.order]) for share in found]
    return shares


def tours_of(problem: Problem, team: Team) -> list[Tour]:
    """The tours of a team."""
    return [tour_of(problem, team.targets, share) for share in team.shares]


def judge_tours(context: Context, tours: list[Tour]) -> Repaired:
    """The tours with their plan and its verdict."""
    plan = plan_of(context.problem, tours, seed=context.seed, bound=context.bound)
    return Repaired(tours=tours, plan=plan, verdict=context.judge(plan), extra=no_points())


def tour_of(problem: Problem, targets: Targets, share: Share) -> Tour:
    """The round as a tour: its period is how far apart robots may come by at all places alike."""
    places_m = targets.places_m[share.order]
    lines_m = [places_m]
    if len(places_m) > 1:
        ends_m = np.roll(places_m, -1, axis=0)
        lines_m = [problem.paths.path(a, b)[:-1] for a, b in zip(places_m, ends_m, strict=True)]
    return Tour(
        vertices_m=np.vstack(lines_m), period_class=int(targets.period_class[share.order].min()),
        period_s=share.headway_s, robots=share.robots, robot=problem.robot,
        component=int(targets.component[share.order[0]]), revisits=not share.is_plain,
        pace=None if share.times_s is None else pace_of(problem, share, [len(line_m) for line_m in lines_m]),
    )  # fmt: skip


def pace_of(problem: Problem, share: Share, lengths: Sequence[int]) -> Pace:
    """When the robot is at each place; lengths (m,): how many vertices there are from each place to the next."""
    assert share.times_s is not None
    per_s = problem.robot.ground_speed_m_s * SLOWER
    first = np.cumsum([0, *lengths[:-1]]).tolist()
    rounds_m = per_s * np.diff(np.append(share.times_s, share.times_s[0] + share.round_s))
    return Pace(first=tuple(first), rounds_m=tuple(rounds_m.tolist()), lead_m=-per_s * float(share.times_s[0]))


def first_met(context: Context, teams: Sequence[Team]) -> Repaired | None:
    """The first plan of the teams that passes."""
    for team in teams:
        found = judge_tours(context, tours_of(context.problem, team))
        if found.met:
            return found
    return None
