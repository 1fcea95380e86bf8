"""How bouncing robots move in their plan, and what a real disc bumps into where the grid blocks a move."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import shapely

from rota.errors import PlanError
from rota.model.mission import Mission
from rota.model.plan import Floats, Plan, Trajectory
from rota.model.polygons import polygons_of

SAME_M = 1e-6
SAME_RAD = 1e-6
TOUCHING_M = 1e-4
_LONGEST_MOVE_CELLS = 7


@dataclass(frozen=True, kw_only=True, eq=False)
class Stretch:
    """A straight way at constant speed, or a stay, between two times; the ends are positions in metres."""

    begin_s: float
    end_s: float
    begin_m: Floats
    end_m: Floats

    @property
    def length_m(self) -> float:
        """Length of the way; 0 for a stay."""
        return math.dist(self.begin_m, self.end_m)

    @property
    def stays(self) -> bool:
        """Whether it is a stay."""
        return self.length_m <= SAME_M

    @property
    def heading_rad(self) -> float:
        """Direction of the way."""
        dx, dy = self.end_m - self.begin_m
        return math.atan2(dy, dx)

    @property
    def velocity_m_s(self) -> Floats:
        """(2,) velocity."""
        return np.asarray((self.end_m - self.begin_m) / (self.end_s - self.begin_s), dtype=np.float64)

    def goes_on_as(self, other: Stretch) -> bool:
        """Whether the other is the same motion, continued."""
        faster = np.linalg.norm(self.velocity_m_s - other.velocity_m_s)
        return self.stays == other.stays and bool(faster <= SAME_M)


def stretches_of(trajectory: Trajectory) -> tuple[Stretch, ...]:
    """The trajectory and two rounds of its loop more, in the fewest stretches; without a stay at the end.

    Raises PlanError when the robot never moves.
    """
    k, loop_s = trajectory.loop_index, trajectory.loop_duration_s
    times, places = trajectory.times_s, trajectory.positions_m[:, :2]
    rounds = 2 if loop_s > 0 else 0
    times = np.concatenate([times, *(times[k + 1 :] + (n + 1) * loop_s for n in range(rounds))])
    places = np.concatenate([places, *([places[k + 1 :]] * rounds)])
    stretches: list[Stretch] = []
    for n in range(len(times) - 1):
        stretch = Stretch(begin_s=float(times[n]), end_s=float(times[n + 1]), begin_m=places[n], end_m=places[n + 1])
        if stretches and stretches[-1].goes_on_as(stretch):
            stretches[-1] = replace(stretches[-1], end_s=stretch.end_s, end_m=stretch.end_m)
        else:
            stretches.append(stretch)
    if stretches and stretches[-1].stays:
        stretches.pop()
    if not stretches:
        raise PlanError(f"robot {trajectory.robot}: it never moves; there is nothing for a Create 2 to drive")
    return tuple(stretches)


def angle_turned(angle_rad: float) -> float:
    """The angle in -pi..pi; half a turn is one to the left."""
    angle = math.remainder(angle_rad, 2 * math.pi)
    return math.pi if angle <= -math.pi + SAME_RAD else angle


@dataclass(frozen=True, kw_only=True)
class Contact:
    """How far a robot drives on, from where the plan lets it stay, until it bumps; and whether into another robot."""

    ahead_m: float
    of_robots: bool


class Surroundings:
    """What discs of ``body_radius_m`` can bump into on their plan's grid: walls, and each other."""

    def __init__(self, plan: Plan, courses: tuple[tuple[Stretch, ...], ...], body_radius_m: float) -> None:
        self._cell_m = plan.mission.bouncing.cell_m
        self._loops = [(t.loop_start_s, t.loop_duration_s) for t in plan.trajectories]
        self._courses = courses
        self._ends_s = [np.array([stretch.end_s for stretch in course]) for course in courses]
        self._radius_m = body_radius_m
        self._walls = _walls(plan.mission)
        if self._cell_m == 0:
            return
        # a step in which a robot turns: straight ones may be shorter
        stays_s = [stretch.end_s - stretch.begin_s for course in courses for stretch in course if stretch.stays]
        way = next(stretch for stretch in courses[0] if not stretch.stays)
        steps = way.length_m / self._move_m(way.heading_rad)
        self._step_s = min(stays_s, default=(way.end_s - way.begin_s) / steps)

    def contact(self, robot: int, pause: Stretch, heading_rad: float) -> Contact | None:
        """What a robot (its number) that stays and turns in the plan would bump into; None: nothing that can be told.

        There is nothing within its move where a diagonal one is blocked since a cell beside it holds but a bit of an
        obstacle. A robot that bumps into a wall meanwhile, and backs off, is met there or where it stays: a race.
        """
        direction = np.array([math.cos(heading_rad), math.sin(heading_rad)])
        if self._cell_m == 0:  # without a grid it turns where it touches
            touches = self._wall_ahead_m(pause.begin_m, direction) <= TOUCHING_M
            return Contact(ahead_m=0.0, of_robots=False) if touches else None
        move_m = self._move_m(heading_rad)
        wall_m = self._wall_ahead_m(pause.begin_m, direction)
        velocity_m_s = direction * move_m / self._step_s
        robots = (n for n in range(len(self._courses)) if n != robot)
        robot_m, other = min(
            ((self._robot_ahead_m(other, pause, velocity_m_s), other) for other in robots), default=(math.inf, -1)
        )
        nearest = Contact(ahead_m=min(wall_m, robot_m), of_robots=robot_m < wall_m)
        if nearest.ahead_m > move_m + SAME_M or (nearest.of_robots and self._is_at_a_wall(other, pause.begin_s)):
            return None
        return nearest

    def _move_m(self, heading_rad: float) -> float:
        """Length of one move along a heading: that of the shortest whole vector of cells in this direction."""
        dx, dy = math.cos(heading_rad), math.sin(heading_rad)
        for cells in range(1, _LONGEST_MOVE_CELLS + 1):
            x, y = (cells * part / max(abs(dx), abs(dy)) for part in (dx, dy))
            if abs(x - round(x)) <= 1e-3 and abs(y - round(y)) <= 1e-3:
                return math.hypot(x, y) * self._cell_m
        raise PlanError(f"a heading of {math.degrees(heading_rad):.6g} degrees leads from no cell to another")

    def _wall_ahead_m(self, place_m: Floats, direction: Floats) -> float:
        """How far a disc drives until it touches a wall; inf where none is ahead."""
        across = np.array([-direction[1], direction[0]])
        ends = (self._walls - np.tile(place_m, 2)).reshape(-1, 2, 2)
        along, aside = ends @ direction, ends @ across
        with np.errstate(invalid="ignore", divide="ignore"):
            # a wall's end is met a little before the disc's centre is beside it
            at_ends = along - np.sqrt(self._radius_m**2 - aside**2)
            at_ends[~((np.abs(aside) < self._radius_m - SAME_M) & (along > 0))] = np.inf
            # a wall itself where the way comes to a radius from its line, if the foot of that radius lies on the wall
            run, rise = along[:, 1] - along[:, 0], aside[:, 1] - aside[:, 0]
            length = np.hypot(run, rise)
            crosses_m = along[:, 0] - aside[:, 0] * run / rise
            meets = crosses_m - self._radius_m * length / np.abs(rise)
            foot = ((meets - along[:, 0]) * run - aside[:, 0] * rise) / length**2
            on = (crosses_m > 0) & (np.abs(rise) > SAME_RAD * length) & (foot >= 0) & (foot <= 1)
        meets[~on] = np.inf
        return max(float(min(at_ends.min(), meets.min())), 0.0)

    def _robot_ahead_m(self, other: int, pause: Stretch, velocity_m_s: Floats) -> float:
        """How far the disc drives until it touches another robot in the same step; inf: it does not."""
        place_m, its_velocity = self._motion_at(other, pause.begin_s)
        apart, closing = place_m - pause.begin_m, velocity_m_s - its_velocity
        speed2 = float(closing @ closing)
        if speed2 <= SAME_M**2:
            return math.inf
        nearest_s = float(apart @ closing) / speed2
        miss2 = float(apart @ apart) - nearest_s**2 * speed2
        if nearest_s <= 0 or miss2 >= (2 * self._radius_m) ** 2:
            return math.inf
        touch_s = max(nearest_s - math.sqrt(((2 * self._radius_m) ** 2 - miss2) / speed2), 0.0)
        return touch_s * float(np.linalg.norm(velocity_m_s)) if touch_s <= self._step_s else math.inf

    def _is_at_a_wall(self, robot: int, time_s: float) -> bool:
        """Whether a robot tries to move on, and a wall is in its way."""
        place_m, velocity_m_s = self._motion_at(robot, time_s)
        speed_m_s = float(np.linalg.norm(velocity_m_s))
        return speed_m_s > 0 and self._wall_ahead_m(place_m, velocity_m_s / speed_m_s) < speed_m_s * self._step_s

    def _motion_at(self, robot: int, time_s: float) -> tuple[Floats, Floats]:
        """Where a robot is and how it moves, or tries to: one that stays and turns afterwards has bumped, too."""
        course, (loop_start_s, loop_s) = self._courses[robot], self._loops[robot]
        if loop_s > 0 and time_s > loop_start_s + loop_s:
            time_s = loop_start_s + (time_s - loop_start_s) % loop_s
        k = int(np.searchsorted(self._ends_s[robot], time_s + SAME_M, side="right"))
        if k == len(course):
            return course[-1].end_m, np.zeros(2)
        now = course[k]
        if not now.stays:
            return np.asarray(now.begin_m + (time_s - now.begin_s) * now.velocity_m_s), now.velocity_m_s
        tried = 0 < k < len(course) - 1 and time_s < now.begin_s + self._step_s / 2
        if not tried or abs(angle_turned(course[k + 1].heading_rad - course[k - 1].heading_rad)) <= SAME_RAD:
            return now.begin_m, np.zeros(2)
        heading = course[k - 1].heading_rad
        speed_m_s = self._move_m(heading) / self._step_s
        return now.begin_m, speed_m_s * np.array([math.cos(heading), math.sin(heading)])


def _walls(mission: Mission) -> Floats:
    """(n, 4) ends of the borders of area minus obstacles."""
    blocking = shapely.union_all([o.shape for o in mission.obstacles if o.blocks_motion])
    rings = [
        np.asarray(ring.coords)[:, :2]
        for part in polygons_of(mission.area.difference(blocking)).geoms
        for ring in (part.exterior, *part.interiors)
    ]
    return np.concatenate([np.hstack([points[:-1], points[1:]]) for points in rings])
