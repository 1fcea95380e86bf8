"""Ways from starts to loops, for bodies of every size in the fleet."""

from __future__ import annotations

import numpy as np

from rota.geometry.free_space import nearest_free_point, standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Floats
from rota.model.mission import Mission, Robot
from rota.planners.patrol.tours.curves import approach_curve


class PathsByBody:
    """Shortest paths for bodies of every size in the fleet, made when they are needed."""

    def __init__(self, mission: Mission) -> None:
        self._mission = mission
        self._paths: dict[float, ShortestPaths] = {}

    def paths(self, body_radius_m: float) -> ShortestPaths:
        """Shortest paths of the centre of such a body."""
        if body_radius_m not in self._paths:
            self._paths[body_radius_m] = ShortestPaths(standing_space(self._mission, body_radius_m))
        return self._paths[body_radius_m]

    def standing(self, robot: Robot, place_m: Floats) -> Floats:
        """The place (2,) itself, or the nearest in the standing space, which rounds off corners a little more."""
        paths = self.paths(robot.body_radius_m)
        if paths.part_of(place_m[None])[0] >= 0:
            return place_m
        nearest = nearest_free_point(standing_space(self._mission, robot.body_radius_m), (place_m[0], place_m[1]))
        return np.array(nearest)

    def line(
        self, robot: Robot, start_m: Floats, end_m: Floats, onward_m: Floats | None, heading_rad: float | None = None
    ) -> Floats:
        """The shortest path (n, 2) from a start to a place of a loop; a curve for a robot with a turn radius.

        onward_m: (2,), where the loop goes on to; a curve ends in its direction. None: the robot stays. heading_rad: in
        which a curve begins; None: in any.
        """
        paths = self.paths(robot.body_radius_m)
        line_m = np.vstack([start_m, paths.path(self.standing(robot, start_m), end_m)])
        if robot.turn_radius_m == 0:
            return line_m
        return approach_curve(line_m, robot.turn_radius_m, paths.grid, onward_m, heading_rad)
