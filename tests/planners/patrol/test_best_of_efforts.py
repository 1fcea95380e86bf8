"""More effort never takes more robots, though batteries and kinds are heeded after loops are found."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from benchmarks.charging import yard
from benchmarks.kinds import field
from benchmarks.random_missions import random_mission

from rota import check_plan
from rota.errors import NoPlanFound
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.best_of_efforts import best_of_efforts
from rota.planners.patrol.planner_settings import Effort, PatrolSettings
from rota.planning.planner import Request

YARD = yard(0)


def stands(robot: str) -> Trajectory:
    """A robot that stands."""
    return Trajectory(robot=robot, times_s=np.array([0.0, 1.0]), positions_m=np.ones((2, 2)), loop_start_s=0.0)


def asked(
    effort: Effort, mission: Mission = YARD, *, shares: list[float] | None = None, stopped: bool = False
) -> Request:
    """A request for a plan of the mission with this effort; shares: to which the progress told is added."""
    told = [] if shares is None else shares
    return Request(
        mission=mission.with_effort(effort), seed=0, judge=check_plan,
        progress=lambda share, _: told.append(share), should_stop=lambda: stopped,
    )  # fmt: skip


class Plans:
    """A search that finds so many robots with each effort, and proves so many; none where it says 0."""

    def __init__(self, **robots: int) -> None:
        self.robots, self.searched = robots, list[str]()

    def __call__(self, request: Request) -> Plan:
        """The plan, or NoPlanFound with the effort's name."""
        effort = PatrolSettings.of(request.mission).effort
        self.searched.append(effort)
        request.progress(1.0, "done")
        if not self.robots[effort]:
            raise NoPlanFound(effort)
        ways = tuple(stands(f"robot-{k + 1}") for k in range(self.robots[effort]))
        return Plan(mission=request.mission, trajectories=ways, lower_bound_robots=len(self.searched))


@pytest.mark.parametrize(
    ("found", "robots", "bound"),
    [
        ({"quick": 3, "normal": 3}, 3, 2),
        ({"quick": 2, "normal": 3}, 2, 2),
        ({"quick": 4, "normal": 3}, 3, 2),
        ({"quick": 0, "normal": 3}, 3, 2),
        ({"quick": 2, "normal": 0}, 2, 1),
    ],
)
def test_the_plan_with_the_fewest_robots_is_kept_with_the_best_bound(
    found: dict[str, int], robots: int, bound: int
) -> None:
    told: list[float] = []
    request, plans = asked("normal", shares=told), Plans(**found)
    plan = best_of_efforts(request, plans)
    assert plans.searched == ["quick", "normal"]
    assert (plan.mission, len(plan), plan.lower_bound_robots) == (request.mission, robots, bound)
    assert told == sorted(told)
    assert told[-1] == 1.0


def test_of_equal_plans_that_of_the_mission_s_own_effort_is_kept() -> None:
    plans = Plans(quick=2, normal=2, high=2)
    assert best_of_efforts(asked("high"), plans).lower_bound_robots == 3
    assert plans.searched == ["quick", "normal", "high"]


def test_where_no_effort_has_a_plan_its_own_says_why() -> None:
    with pytest.raises(NoPlanFound, match="normal"):
        best_of_efforts(asked("normal"), Plans(quick=0, normal=0))


def test_a_search_that_is_to_stop_ends_with_what_lesser_efforts_found() -> None:
    plans = Plans(quick=2, normal=1)
    assert len(best_of_efforts(asked("normal", stopped=True), plans)) == 2
    assert plans.searched == ["quick"]


def test_quick_and_robots_that_do_not_charge_are_searched_once() -> None:
    plans = Plans(quick=2, normal=2)
    best_of_efforts(asked("quick"), plans)
    alike = dataclasses.replace(random_mission(1), planning=PatrolSettings())
    best_of_efforts(asked("normal", alike), plans)
    assert plans.searched == ["quick", "normal"]


def test_of_kinds_the_cheaper_fleet_is_kept() -> None:
    """Two robots of the cheaper kind cost less than one of the dearer."""
    mission = field(0)
    cheap, dear = sorted(mission.fleet.kinds, key=lambda kind: kind.cost)
    assert 2 * cheap.cost < dear.cost, "another field is needed"
    ways = {"quick": (f"{cheap.name}-1", f"{cheap.name}-2"), "normal": (f"{dear.name}-1",)}

    def plan(request: Request) -> Plan:
        own = ways[PatrolSettings.of(request.mission).effort]
        return Plan(mission=request.mission, trajectories=tuple(map(stands, own)))

    assert [way.robot for way in best_of_efforts(asked("normal", mission), plan)] == list(ways["quick"])
