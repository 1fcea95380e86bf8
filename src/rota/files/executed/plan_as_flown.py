"""The plan as vehicles fly a format's files by their own firmware."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np

from rota.errors import RotaError
from rota.files.executed.mavlink import Told, read_qgroundcontrol, read_waypoints
from rota.model.fleet import Fleet, Robot
from rota.model.motion_limits import AT_ONCE
from rota.model.plan import Plan, Trajectory
from rota.routes.driven_route import from_start
from rota.routes.route import route_of
from rota.vehicles.facts import Vehicle
from rota.vehicles.models import model_of
from rota.vehicles.motion import Motion, MotionModel, Way, Wind

TOLD: dict[str, Callable[[Plan, Trajectory], Told]] = {
    "qgroundcontrol": partial(read_qgroundcontrol, autopilot="ardupilot"),
    "waypoints": read_waypoints,
}

Kind = TypeVar("Kind", Fleet, Robot)


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotFlown:
    """One robot's motion beside the round that is planned, in seconds; 0: it stays. way: what its file tells it."""

    planned_s: float
    way: Way
    motion: Motion

    @property
    def factor(self) -> float:
        """How many times the planned round its round takes; 1 where the robot stays."""
        return self.motion.round_s / self.planned_s if self.planned_s else 1.0


def plan_as_flown(plan: Plan, name: str, vehicle: Vehicle, wind: Wind) -> tuple[Plan, tuple[RobotFlown, ...]]:
    """The plan with the motion that a vehicle's firmware makes of a format's files, and each robot's, in its order.

    The plan's mission then allows the speeds and the turns that the vehicles make.

    Raises RotaError for a vehicle whose motion is not modelled, for a format that it does not fly by, and for legs that
    it cannot fly; PlanError for what the format cannot say.
    """
    model = model_of(vehicle)
    if name not in vehicle.formats:
        raise RotaError(
            f"--executed: {name!r} is not allowed with --vehicle {vehicle.name}: {vehicle.told} flies by"
            f" {' or '.join(vehicle.formats)}"
        )
    robots = tuple(_robot_flown(plan, trajectory, TOLD[name](plan, trajectory), model, wind) for trajectory in plan)
    made = [
        robot.motion.trajectory(flat=trajectory.positions_m.shape[1] == 2)
        for robot, trajectory in zip(robots, plan, strict=True)
    ]
    fleet = _as_fast_as(plan.mission.fleet, max((_fastest_m_s(each) for each in made), default=0.0))
    mission = replace(plan.mission, fleet=fleet)
    return replace(plan, mission=mission, trajectories=tuple(made)), robots


def way_of(plan: Plan, trajectory: Trajectory) -> Way:
    """What a robot is to drive by the plan itself, whatever a format makes of it."""
    route = route_of(trajectory, plan.mission.fleet.altitude_m)
    return Way(robot=trajectory.robot, once=from_start(route), every_round=route.every_round)


def _robot_flown(plan: Plan, trajectory: Trajectory, told: Told, model: MotionModel, wind: Wind) -> RobotFlown:
    way = Way(robot=trajectory.robot, once=tuple(told.once), every_round=tuple(told.every_round))
    return RobotFlown(planned_s=trajectory.loop_duration_s, way=way, motion=model.drive(way, wind))


def _fastest_m_s(trajectory: Trajectory) -> float:
    steps_m = np.linalg.norm(np.diff(trajectory.positions_m, axis=0), axis=1)
    return float((steps_m / np.diff(trajectory.times_s)).max(initial=0.0))


def _as_fast_as(fleet: Fleet, most_m_s: float) -> Fleet:
    """The fleet whose robots may be so fast, and turn and change speed as they like."""

    def free(one: Kind) -> Kind:
        speed_m_s = max(one.speed_m_s, most_m_s)
        return replace(one, speed_m_s=speed_m_s, turn_rate_rad_s=None, turn_radius_m=0.0, motion=AT_ONCE)

    return replace(free(fleet), robots=fleet.robots and tuple(map(free, fleet.robots)))
