"""Closed ways of robots that bounce without a grid: attracting limit cycles, with times, and when they are in zones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import MultiPolygon

from rota.geometry.free_space import free_ground
from rota.model.arrays import Floats
from rota.model.mission import Mission, Robot, Zone
from rota.model.plan import Trajectory
from rota.planners.bounce.clock_kernels import nearest_touch
from rota.planners.bounce.polygon import BounceRule, make_rim
from rota.planners.bounce.polygon_cycles import PolygonCycle, limit_cycles, random_starts

STARTS, BOUNCES, LONGEST = 1500, 1200, 128  # random starts, contacts until a cycle is looked for, and in a cycle
FRAMES = 24  # headings that starts have, equally spaced
SAME_TIME = 1e-9  # share of a round by which two times on it may differ


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    """One round of a robot on a limit cycle.

    times_s (n,), from 0 to the round's duration; places_m (n, 2), the last the first; headings_rad (n,) in 0..2 pi,
    after the turns that end at these times. visits: for each zone (k, 2), when a round is in it.
    """

    cycle: PolygonCycle
    body_radius_m: float
    times_s: Floats
    places_m: Floats
    headings_rad: Floats
    visits: tuple[Floats, ...]

    @property
    def round_s(self) -> float:
        """How long a round takes."""
        return float(self.times_s[-1])

    def gap_s(self, zone: int, robots: int) -> float:
        """The longest time in seconds between visits of a zone by ``robots`` robots, evenly spaced; inf: none."""
        visits = self.visits[zone]
        if not len(visits):
            return math.inf
        apart_s = self.round_s / robots
        begins, lasting = visits[:, 0] % apart_s, visits[:, 1] - visits[:, 0]
        order = np.argsort(begins)
        begins, ends = begins[order], (begins + lasting)[order]
        latest = np.maximum.accumulate(np.concatenate([[ends.max() - apart_s], ends]))[:-1]
        return float(max((begins - latest).max(), 0.0))

    def margin_s(self, robots: int, apart_m: float) -> float:
        """By how many seconds clocks of ``robots`` robots, evenly spaced, may differ before bodies touch."""
        if robots < 2:
            return math.inf
        shifts = np.arange(1, robots) * (self.round_s / robots)
        return float(nearest_touch(self.times_s, np.ascontiguousarray(self.places_m), apart_m, shifts))

    def trajectory(self, robot: str, late_s: float) -> Trajectory:
        """The round for ever, begun ``late_s`` into it, or at a timed point that is the same but for rounding."""
        times = self.times_s
        nearest_s = float(times[np.abs(times - late_s).argmin()])
        late_s = nearest_s if abs(nearest_s - late_s) <= SAME_TIME * self.round_s else late_s
        first = int(np.searchsorted(times, late_s, side="right"))
        cut = np.array([np.interp(late_s, times, self.places_m[:, k]) for k in (0, 1)])
        facing = self._facing(first - 1, late_s)
        next_round = slice(1, first) if times[first - 1] < late_s else slice(1, first - 1)
        after = np.concatenate([times[first:] - late_s, times[next_round] + self.round_s - late_s])
        if late_s == 0:
            return Trajectory(
                robot=robot, times_s=times, positions_m=self.places_m, headings_rad=self.headings_rad, loop_start_s=0.0
            )
        return Trajectory(
            robot=robot,
            times_s=np.concatenate([[0.0], after, [self.round_s]]),
            positions_m=np.vstack([cut, self.places_m[first:], self.places_m[next_round], cut]),
            headings_rad=np.concatenate([[facing], self.headings_rad[first:], self.headings_rad[next_round], [facing]]),
            loop_start_s=0.0,
        )

    def _facing(self, k: int, time_s: float) -> float:
        """The heading at a time between timed points k and k + 1: it turns on the spot, and never on its way."""
        heading = float(self.headings_rad[k])
        if (self.places_m[k] != self.places_m[k + 1]).any():
            return heading
        turn = (self.headings_rad[k + 1] - heading) % math.tau
        share = (time_s - self.times_s[k]) / (self.times_s[k + 1] - self.times_s[k])
        return float((heading + share * turn) % math.tau)


def tracks_of(mission: Mission, robot: Robot, angle_deg: float, zones: Sequence[Zone], seed: int) -> list[Track]:
    """The tracks of a robot on all attracting limit cycles that random starts come to, most of them first.

    The widest body of the fleet counts at walls. Cycles longer than LONGEST contacts are not looked for.
    """
    widest_m = max(member.body_radius_m for member in (mission.fleet.robots or (robot,)))
    rim = make_rim(free_ground(mission), widest_m)
    rule = BounceRule(angle_rad=math.radians(angle_deg))
    frames = [k * 2 * math.pi / FRAMES for k in range(FRAMES)]
    places, headings = random_starts(rim, STARTS, seed, frames)
    long_run = limit_cycles(rim, rule, places, headings, bounces=BOUNCES, longest=LONGEST)
    shapes = [zone.shape for zone in zones]
    return [track(cycle, robot, shapes) for cycle in long_run.cycles if cycle.stability == "attracting"]


def track(cycle: PolygonCycle, robot: Robot, zones: Sequence[MultiPolygon]) -> Track:
    """A cycle with the robot's times: at its speed from contact to contact, turning counterclockwise at each."""
    corners, headings = cycle.positions_m, cycle.headings_rad
    turns = (headings - np.roll(headings, 1)) % (2 * math.pi)  # at each contact, before leaving it
    times, places, faced = [0.0], [corners[0]], [float(headings[0])]
    for k in range(len(corners)):
        following = corners[(k + 1) % len(corners)]
        times.append(times[-1] + math.dist(corners[k], following) / robot.ground_speed_m_s)
        places.append(following)
        faced.append(float(headings[k]))
        left = float(headings[(k + 1) % len(corners)])
        if robot.turn_rate_rad_s is None:
            faced[-1] = left
        else:
            times.append(times[-1] + float(turns[(k + 1) % len(corners)]) / robot.turn_rate_rad_s)
            places.append(following)
            faced.append(left)
    times_s, places_m = np.array(times), np.array(places)
    return Track(
        cycle=cycle,
        body_radius_m=robot.body_radius_m,
        times_s=times_s,
        places_m=places_m,
        headings_rad=np.array(faced),
        visits=tuple(_visits(times_s, places_m, zone) for zone in zones),
    )


def _visits(times_s: Floats, places_m: Floats, zone: MultiPolygon) -> Floats:
    """(k, 2) when a round is in the zone, leg by leg."""
    visits: list[tuple[float, float]] = []
    for k in range(len(times_s) - 1):
        begin, end = places_m[k], places_m[k + 1]
        lasts_s, length_m = times_s[k + 1] - times_s[k], math.dist(begin, end)
        if length_m == 0:
            if shapely.covers(zone, shapely.Point(begin)):
                visits.append((times_s[k], times_s[k + 1]))
            continue
        line = shapely.linestrings(np.stack([begin, end]))
        for part in shapely.get_parts(shapely.intersection(line, zone)):
            corners = shapely.get_coordinates(part)
            if not len(corners):
                continue
            along = shapely.line_locate_point(line, shapely.points(corners)) / length_m
            visits.append((times_s[k] + along.min() * lasts_s, times_s[k] + along.max() * lasts_s))
    return np.array(visits, dtype=np.float64).reshape(-1, 2)
