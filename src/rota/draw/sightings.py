"""When each cell of a cell map was last seen, kept up to date as the robots move."""

from __future__ import annotations

import math

import numpy as np
import shapely
from shapely import GeometryCollection
from shapely.geometry.base import BaseGeometry

from rota.cells.cell_map import CellMap
from rota.check.counting import counts
from rota.draw.footprint import cut_footprint, open_footprint, sensor_from, walls_of
from rota.model.arrays import Flags, Floats
from rota.model.mission import DiscSensor, Mission, Sensor, inner_reach_m
from rota.model.plan import Plan
from rota.routes.flights import on_charger
from rota.routes.moments import corner_times_s

# looks per reach of the sensor: beside obstacles, where a look is one footprint, four miss less than 1 % of its width
LOOKS_PER_REACH = 4


def in_range(sensor: Sensor, leg_m: Floats, x_m: Floats, y_m: Floats) -> Flags:
    """Which points come into the sensor's range while its robot goes along a straight leg (2, 2), obstacles aside."""
    along_x, along_y = leg_m[1] - leg_m[0]
    to_x, to_y = x_m - leg_m[0, 0], y_m - leg_m[0, 1]
    if isinstance(sensor, DiscSensor):
        part = np.clip((to_x * along_x + to_y * along_y) / max(along_x**2 + along_y**2, 1e-300), 0, 1)
        return np.asarray((to_x - part * along_x) ** 2 + (to_y - part * along_y) ** 2 <= sensor.radius_m**2)
    enters, leaves = np.zeros_like(to_x), np.ones_like(to_x)
    for to, along in ((to_x, along_x), (to_y, along_y)):
        # the part of the leg from which the point is within half a side along this axis
        reach = sensor.side_m / 2 / max(abs(along), 1e-300)
        middle = to * np.sign(along) / max(abs(along), 1e-300)
        outside = np.abs(to) > sensor.side_m / 2
        enters = np.maximum(enters, np.where(along == 0, np.where(outside, 2.0, 0.0), middle - reach))
        leaves = np.minimum(leaves, np.where(along == 0, 1.0, middle + reach))
    return np.asarray(enters <= leaves)


def cells_that_count(mission: Mission, cell_map: CellMap, sensor: Sensor) -> Flags:
    """Which cells (rows, columns) a robot's looks count for: all but those of zones that name other sensors."""
    found = np.ones(cell_map.period_s.shape, np.bool_)
    x_m, y_m = np.meshgrid(cell_map.x_m, cell_map.y_m)
    for zone in mission.zones:
        if zone.demand == "every_point" and not counts(sensor, zone.sensors):
            found &= ~shapely.contains_xy(zone.shape, x_m, y_m)
    return found


class Sightings:
    """The last time each cell was seen by a robot that counts there; -inf: not yet.

    last_seen_s: (rows, columns) seconds, as in ``cell_map``. ``advance`` moves the clock on, never back.
    """

    def __init__(self, plan: Plan, cell_map: CellMap) -> None:
        self.cell_map = cell_map
        self.last_seen_s = np.full(cell_map.period_s.shape, -np.inf)
        self._plan = plan
        self._walls = walls_of(plan.mission)
        self._robots = [plan.mission.fleet.robot(trajectory.robot) for trajectory in plan]
        sensors = {robot.sensor for robot in self._robots}
        self._counting = {sensor: cells_that_count(plan.mission, cell_map, sensor) for sensor in sensors}

    def advance(self, from_s: float, to_s: float) -> None:
        """See what the robots see from ``from_s`` to ``to_s``, both counted in, in looks a quarter of a reach apart."""
        for trajectory, robot in zip(self._plan, self._robots, strict=True):
            if from_s < robot.joins_s or (robot.leaves_s is not None and to_s > robot.leaves_s):
                continue
            step_s = robot.sensor.reach_m / LOOKS_PER_REACH / robot.speed_m_s
            even_s = np.linspace(from_s, to_s, max(1, math.ceil((to_s - from_s) / step_s)) + 1)
            times_s = np.union1d(even_s, corner_times_s(trajectory, from_s, to_s))
            times_s = times_s if len(times_s) > 1 else np.repeat(times_s, 2)
            places_m = trajectory.at(times_s)
            # of a wait only its end counts
            moves = np.append((places_m[2:] != places_m[1:-1]).any(axis=1), True)
            if trajectory.charges:  # on a charger it sees nothing, and just before it counts
                docked = on_charger(trajectory, (times_s[:-1] + times_s[1:]) / 2)
                moves = (moves | np.append(docked[1:], False)) & ~docked
            for k in np.flatnonzero(moves):
                leg_m = places_m[k : k + 2]
                sensor, counting = sensor_from(robot.sensor, leg_m), self._counting[robot.sensor]
                self._look(sensor, leg_m[:, :2], float(times_s[k + 1]), counting)

    def footprints(self, time_s: float) -> list[BaseGeometry]:
        """What each robot sees at ``time_s``, in the order of the plan; nothing while it takes no part or charges."""
        shapes = []
        for trajectory, robot in zip(self._plan, self._robots, strict=True):
            away = time_s < robot.joins_s or (robot.leaves_s is not None and time_s > robot.leaves_s)
            if away or on_charger(trajectory, np.array([time_s]))[0]:
                shapes.append(GeometryCollection())
                continue
            places_m = trajectory.at([time_s])
            sensor, place_m = sensor_from(robot.sensor, places_m), places_m[0, :2]
            cut = cut_footprint(self._walls, sensor, place_m)
            shapes.append(open_footprint(sensor, place_m) if cut is None else cut)
        return shapes

    def age_in_periods(self, time_s: float) -> Floats:
        """Time since last seen over the period, (rows, columns); inf: not yet seen, nan: nothing asked."""
        return (time_s - self.last_seen_s) / self.cell_map.period_s

    def _look(self, sensor: Sensor, leg_m: Floats, time_s: float, counting: Flags) -> None:
        """What is seen along a short leg (2, 2), of cells that count; beside obstacles: from its end."""
        cut = cut_footprint(self._walls, sensor, leg_m[1])
        if cut is not None:
            leg_m = leg_m[[1, 1]]
        half_m = inner_reach_m(sensor)
        low_m, high_m = leg_m.min(axis=0) - half_m, leg_m.max(axis=0) + half_m
        columns = slice(*np.searchsorted(self.cell_map.x_m, [low_m[0], high_m[0]]))
        rows = slice(*np.searchsorted(self.cell_map.y_m, [low_m[1], high_m[1]]))
        x_m, y_m = np.meshgrid(self.cell_map.x_m[columns], self.cell_map.y_m[rows])
        seen = in_range(sensor, leg_m, x_m, y_m) & counting[rows, columns]
        if cut is not None:
            shapely.prepare(cut)
            seen &= shapely.contains_xy(cut, x_m, y_m)
        window = self.last_seen_s[rows, columns]
        # another robot may have looked here later within the same step
        window[seen] = np.maximum(window[seen], time_s)
