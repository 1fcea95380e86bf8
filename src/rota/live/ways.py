"""Who could still make it: how long robots take, round obstacles, to where they see a place."""

from __future__ import annotations

import math

import numpy as np
import shapely

from rota.errors import MissionError
from rota.geometry.free_space import border_corners, nearest_free_point, sight_walls, standing_space
from rota.geometry.line_of_sight import edge_grid, sees
from rota.geometry.shortest_path import ShortestPaths
from rota.live.places import Places
from rota.model.arrays import Floats
from rota.model.fleet import Robot, Sensor, inner_reach_m
from rota.model.mission import Mission

DIRECTIONS = 24
SHARES_OF_REACH = (0.98, 0.5)  # how far off a place it is looked at from
BORDER_STEPS = 48
MOST_CORNERS = 1_500  # of the standing space: ways round more of them would hold up what is watched


class Ways:
    """The ways of robots round obstacles, at their own speeds.

    A place is looked at from itself, from the free place nearest to it and from two rings round it: a robot that could
    see it only from elsewhere is not told. ``known`` False: the ground has too many corners, and nobody is told.
    """

    def __init__(self, mission: Mission, robots: list[Robot], places: Places) -> None:
        self._robots, self._places = robots, places
        self._sight = edge_grid(sight_walls(mission))
        bodies = dict.fromkeys(robot.body_radius_m for robot in robots)
        spaces = {body: standing_space(mission, body) for body in bodies}
        self.known = all(len(border_corners(space)[0]) <= MOST_CORNERS for space in spaces.values())
        self._spaces = spaces if self.known else {}
        self._paths = {body: ShortestPaths(space) for body, space in self._spaces.items()}

    def times_s(self, place: int, robots: list[int], from_m: Floats) -> Floats:
        """Seconds (n,) that robots at from_m (n, 2) take to see (or visit) a place; inf where no way was found."""
        takes_s = np.full(len(robots), math.inf)
        kinds: dict[tuple[float, Sensor], list[int]] = {}
        for m, number in enumerate(robots):
            kinds.setdefault((self._robots[number].body_radius_m, self._robots[number].sensor), []).append(m)
        for members in kinds.values():
            one = self._robots[robots[members[0]]]
            speeds_m_s = np.array([self._robots[robots[m]].speed_m_s for m in members])
            takes_s[members] = self._ways_m(one, from_m[members], self._views(place, one)) / speeds_m_s
        return takes_s

    def home_s(self, robot: int, route_m: Floats, home_m: Floats) -> float:
        """Seconds home from the farthest of the places (n, 2) of a robot's route; inf where no way was found."""
        body = self._robots[robot].body_radius_m
        if not self.known:
            return math.inf
        try:
            ends = np.array([nearest_free_point(self._spaces[body], (float(x), float(y))) for x, y in route_m])
            home = np.array([nearest_free_point(self._spaces[body], (float(home_m[0]), float(home_m[1])))])
        except MissionError:
            return math.inf
        return float(self._paths[body].distances(home, ends).max()) / self._robots[robot].speed_m_s

    def _ways_m(self, robot: Robot, from_m: Floats, views_m: Floats) -> Floats:
        """Lengths (n,) of the shortest ways of such a robot from places (n, 2) to one of several places (m, 2).

        From outside of where it can stand, by way of the nearest place.
        """
        if not self.known or not len(views_m):
            return np.full(len(from_m), math.inf)
        space = self._spaces[robot.body_radius_m]
        try:
            begin = np.array([nearest_free_point(space, (float(x), float(y))) for x, y in from_m]).reshape(-1, 2)
        except MissionError:
            return np.full(len(from_m), math.inf)
        lengths = self._paths[robot.body_radius_m].distances(begin, views_m)
        return np.asarray(np.hypot(*(begin - from_m).T) + lengths.min(axis=1))

    def _views(self, place: int, robot: Robot) -> Floats:
        """Places (n, 2) where a robot can stand and sees a point, or is inside what it is to visit."""
        if not self.known:
            return np.empty((0, 2))
        space, at = self._spaces[robot.body_radius_m], self._places.points_m[place]
        demand = self._places.demands[self._places.demand[place]]
        if demand.demand == "visit":
            inside = shapely.intersection(demand.region, space)
            if inside.is_empty:
                return np.empty((0, 2))
            border = shapely.boundary(inside)
            steps = shapely.line_interpolate_point(border, np.linspace(0, 1, BORDER_STEPS), normalized=True)
            stands: Floats = shapely.get_coordinates([shapely.point_on_surface(inside), *steps])
            return stands
        angles = 2 * math.pi * np.arange(DIRECTIONS) / DIRECTIONS
        ring = np.column_stack([np.cos(angles), np.sin(angles)])
        reach_m = inner_reach_m(robot.sensor)
        spots = [at[None], *(at + share * reach_m * ring for share in SHARES_OF_REACH)]
        try:
            spots.append(np.array([nearest_free_point(space, (float(at[0]), float(at[1])))]))
        except MissionError:
            return np.empty((0, 2))
        views: Floats = np.vstack(spots)
        near = np.hypot(*(views - at).T) <= reach_m
        return np.asarray(views[near & sees(views, np.tile(at, (len(views), 1)), self._sight)])
