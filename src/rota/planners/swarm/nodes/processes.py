"""The door to robots as processes of their own: one of them, or all with a recorder."""

from __future__ import annotations

from collections.abc import Callable

from rota.errors import MissionError
from rota.model.mission import Mission
from rota.planners.swarm.nodes.launch import run_swarm
from rota.planners.swarm.nodes.process import run_robot, scene_for
from rota.planning.robot_processes import Launch, ProcessSettings, SwarmRecord


class SwarmProcesses:
    """See ``robot_processes.RobotProcesses``; MissionError for robots that charge."""

    def __init__(self, mission: Mission, settings: ProcessSettings) -> None:
        if mission.chargers:
            raise MissionError("chargers: robots in processes of their own do not charge: remove them, and endurance_s")
        self._scene, self._settings = scene_for(mission, settings), settings

    def run_robot(self, robot: int, should_stop: Callable[[], bool]) -> int:
        """Be the robot of this number."""
        return run_robot(self._scene, robot, self._settings, should_stop=should_stop).dropped

    def run_all(self, launch: Launch) -> SwarmRecord:
        """Start them, record and end them."""
        return run_swarm(self._scene, self._settings, launch)
