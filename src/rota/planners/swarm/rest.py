"""When a swarm is at rest, and which of its robots are blocked instead."""

from __future__ import annotations

import numpy as np

from rota.model.mission import Mission
from rota.planners.swarm.messages import hearing_of, oldest_steps
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.presence import Presence, last_motion
from rota.planners.swarm.rollout import Swarm
from rota.planners.swarm.space_rollout import SpaceSwarm

# momentum carries robots through places where they stand still for a moment and are not at rest
STEPS_AT_REST = {"reciprocal": 1, "voronoi": 1, "virtual_force": 1, "settle": 2}
# of the longest step: less is rest, and who wants more and stands is blocked; measured: behind one that stands in a
# door robots want 1, where nobody is in the way at most .01, before a door that is too narrow at most .34
AT_REST_SHARE, WANTS_SHARE = 0.01, 0.5


def steps_at_rest(settings: SwarmSettings) -> int:
    """How many steps without motion end a run; robots that settle must have heard of it as well."""
    hearing = hearing_of(settings)
    unheard = 0 if hearing is None or settings.controller != "settle" else oldest_steps(hearing)
    return STEPS_AT_REST[settings.controller] + unheard


def longest_rest_m(mission: Mission, step_s: float | None = None) -> float:
    """The longest step of a robot at rest: ``stop_m``, and no more than a small share of what any robot can drive.

    step_s: how long a step takes; None: as long as the mission says.
    """
    settings = SwarmSettings.of(mission)
    step_s = settings.time_step_s if step_s is None else step_s
    speeds = [robot.ground_speed_m_s for robot in mission.fleet.robots or () if robot.ground_speed_m_s > 0]
    return min([settings.stop_m, *(AT_REST_SHARE * speed * step_s for speed in speeds)])


def blocked_robots(swarm: Swarm | SpaceSwarm, mission: Mission) -> tuple[str, ...]:
    """The robots at rest that want to go on and cannot; only those that settle know where to."""
    if SwarmSettings.of(mission).controller != "settle":
        return ()
    most_m = np.array([robot.ground_speed_m_s for robot in mission.fleet.robots or ()]) * swarm.rule.time_step_s
    wants = swarm.wishes_m() > WANTS_SHARE * most_m
    return tuple(robot.name for robot, told in zip(mission.fleet.robots or (), wants.tolist(), strict=True) if told)


def last_change_of(mission: Mission) -> int:
    """The step from which on nobody joins or leaves and no obstacle moves."""
    return max(Presence(mission).last_change, last_motion(mission))
