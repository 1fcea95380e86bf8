"""What a plan asks of batteries, as arrays for the compiled loops of runs."""

from __future__ import annotations

import math

import numpy as np

from rota.model.plan import Plan
from rota.rehearsal.drive_kernels import Batteries
from rota.routes.charging_legs import ChargingLegs, charging_legs


def batteries_of(plan: Plan) -> Batteries:
    """What the plan asks of the battery of each robot."""
    robots = [plan.mission.fleet.robot(way.robot) for way in plan]
    legs = [charging_legs(way, robot, plan.mission.chargers) for way, robot in zip(plan, robots, strict=True)]
    firsts = np.concatenate([[0], np.cumsum([len(own.ends_s) for own in legs], dtype=np.int64)])
    joined = {name: np.concatenate([getattr(own, name) for own in legs]) for name in ChargingLegs._fields}
    return Batteries(
        firsts=firsts,
        again=firsts[:-1] + np.array([way.loop_index for way in plan], np.int64),
        loops_s=np.array([way.loop_duration_s for way in plan], np.float64),
        endurance_s=np.array([robot.battery.endurance_s or math.inf for robot in robots], np.float64),
        takeoff_s=np.array([robot.battery.departure_s for robot in robots], np.float64),
        landing_s=np.array([robot.battery.landing_s for robot in robots], np.float64),
        climbing_s=np.array([robot.battery.climbing_s for robot in robots], np.float64),
        reserve_s=np.array([robot.battery.reserve_s for robot in robots], np.float64),
        **joined,
    )
