"""The shortest ways on the map for the bodies of a swarm."""

from __future__ import annotations

import numpy as np
from shapely import MultiPolygon

from rota.errors import PlanError
from rota.geometry.free_space import nearest_free_point, standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.model.arrays import Floats
from rota.model.mission import Mission, Robot

OFF_M = 1e-6  # that ways keep off what stops a body, so that none goes along it


class Ways:
    """Shortest ways for the robots of a mission; the map for a body is made when it is first asked for.

    wider_m: by which bodies are wider where they move.
    """

    def __init__(self, mission: Mission, wider_m: float) -> None:
        self._mission, self._wider_m = mission, wider_m
        self._maps: dict[float, tuple[MultiPolygon, ShortestPaths]] = {}

    def lasts_s(self, robots: tuple[Robot, ...], from_m: Floats, to_m: Floats) -> Floats:
        """Seconds (n, m) that n robots take from places (n, 2), one each, to places (m, 2); inf: there is no way."""
        found = np.empty((len(robots), len(to_m)))
        bodies = np.array([robot.body_radius_m for robot in robots])
        for body_m in np.unique(bodies):
            own = np.flatnonzero(bodies == body_m)
            space, paths = self._map_for(float(body_m))
            found[own] = paths.distances(_inside(space, from_m[own]), _inside(space, to_m))
        return np.asarray(found / np.array([robot.ground_speed_m_s for robot in robots])[:, None])

    def path_m(self, robot: Robot, from_m: Floats, to_m: Floats) -> Floats:
        """The places (k, 2) that a robot comes by on its shortest way, the last one included and the first one not.

        The last place alone where there is no way.
        """
        space, paths = self._map_for(robot.body_radius_m)
        try:
            line = paths.path(*_inside(space, np.array([from_m, to_m])))
        except PlanError:
            line = np.array([from_m, to_m])
        return np.vstack([line[1:-1], to_m[None]])

    def _map_for(self, body_m: float) -> tuple[MultiPolygon, ShortestPaths]:
        """Where the middle of a body may be, and shortest paths there."""
        if body_m not in self._maps:
            space = standing_space(self._mission, body_m + self._wider_m + OFF_M)
            self._maps[body_m] = space, ShortestPaths(space)
        return self._maps[body_m]


def _inside(space: MultiPolygon, places_m: Floats) -> Floats:
    """The nearest places (n, 2) of a space to places that may be beside it by rounding."""
    return np.array([nearest_free_point(space, (x, y)) for x, y in places_m.tolist()])
