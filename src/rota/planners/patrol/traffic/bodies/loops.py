"""Loops as bodies drive them: places on a common clock, and which of them come near each other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from rota.model.arrays import Floats, Ints
from rota.planners.patrol.driving.timed_line import TimedLine
from rota.planners.patrol.ground.samples import MOST_CELLS
from rota.planners.patrol.tours.timetable import line_of, loop_timetable, paced_timetable
from rota.planners.patrol.tours.tour import Tour

FEW_TRIED = 4  # clocks, cuts of a loop, places to begin it, or robots that may step aside: the most promising


@dataclass(frozen=True, kw_only=True, eq=False)
class Loop:
    """One round of a tour at full speed, and the robots that share it at equal headways.

    line: begins and ends at the same place; one row: the robot stays. may_wait: the robot can stop anywhere at once.
    is_one_way: it may not be driven backwards.
    """

    line: TimedLine
    robots: int
    period_s: float
    speed_m_s: float
    may_wait: bool = True
    is_one_way: bool = False

    @property
    def places_m(self) -> Floats:
        """The places (n, 2) of its line."""
        return self.line.places_m

    @property
    def stays(self) -> bool:
        """Whether its robot never moves."""
        return self.line.stays

    @property
    def natural_s(self) -> float:
        """What a round takes at full speed; 0 for a robot that stays."""
        return self.line.duration_s


class Timed(NamedTuple):
    """A round as it is driven: at time 0 its first robot is ``offset_s`` into it; the others follow evenly."""

    line: TimedLine
    offset_s: float


class Clock(NamedTuple):
    """Headways that are whole multiples (k,) of one unit; those of robots that stay are 1.

    Two loops meet in phases modulo the greatest common divisor of their headways.
    """

    multiples: list[int]
    unit_s: float


class Grid(NamedTuple):
    """A clock in samples: ``bins`` to its unit, ``step_s`` apart.

    Robots whose samples are ``apart_m`` apart never touch: between samples each is within half a step of the nearer.
    """

    bins: int
    step_s: float
    apart_m: float


def loop_of(tour: Tour) -> Loop:
    """The tour's round at full speed, or in step with others."""
    if tour.pace is None:
        line = loop_timetable(tour.vertices_m, tour.robot)
    else:
        line = paced_timetable(tour.vertices_m, tour.robot, tour.pace)
    return Loop(
        line=line,
        robots=tour.robots,
        period_s=tour.period_s,
        speed_m_s=tour.robot.ground_speed_m_s,
        may_wait=not tour.robot.motion.has_mass,
    )


def crowds(loops: Sequence[Loop], apart_m: float) -> list[list[int]]:
    """Loops in groups, such that no two of different groups ever come nearer than ``apart_m``, whatever the time."""
    lines = [line_of(loop.places_m) for loop in loops]
    a, b = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=apart_m)
    n = len(loops)
    _, label = connected_components(coo_array((np.ones(len(a)), (a, b)), shape=(n, n)), directed=False)
    return [np.flatnonzero(label == k).tolist() for k in dict.fromkeys(label.tolist())]


def clocks(loops: Sequence[Loop]) -> list[Clock]:
    """Headways within the periods, no shorter than the rounds allow, in whole multiples of a unit; the best first.

    Those are best whose common measures, taken pair by pair, are greatest: phases matter only modulo these, so that
    great ones leave most freedom. At least one loop takes all of its period.
    """
    longest_s = [loop.period_s * (1 - 1e-6) for loop in loops]
    moving = [k for k, loop in enumerate(loops) if not loop.stays]
    if not moving:
        return [Clock([1] * len(loops), 1.0)]
    if len(moving) == 1 and not loops[moving[0]].may_wait:
        # as fast as it goes: autopilots cut corners as they do at that speed
        return [Clock([1] * len(loops), loops[moving[0]].natural_s / loops[moving[0]].robots)]
    shortest_s = min(longest_s[k] for k in moving)
    by_headways: dict[tuple[float, ...], Clock] = {}
    for full_s in sorted({longest_s[k] for k in moving}):
        fewest = math.ceil(full_s / shortest_s - 1e-9)
        for division in range(fewest, fewest * 12 + 1):  # the common unit is at least a twelfth of the shortest headway
            unit_s = full_s / division
            multiples = [
                1 if loop.stays else math.floor(s / unit_s + 1e-9) for loop, s in zip(loops, longest_s, strict=True)
            ]
            if all(loops[k].robots * multiples[k] * unit_s >= loops[k].natural_s for k in moving):
                headways = tuple(round(m * unit_s, 9) for m in multiples)
                by_headways.setdefault(headways, Clock(multiples, unit_s))
    return sorted(by_headways.values(), key=lambda clock: -freedom_s(clock, moving))[:FEW_TRIED]


def freedom_s(clock: Clock, moving: Sequence[int]) -> float:
    """The sum of the common measures of all pairs of headways; of one loop alone its headway."""
    measures = [math.gcd(clock.multiples[i], clock.multiples[k]) for n, k in enumerate(moving) for i in moving[:n]]
    return clock.unit_s * (sum(measures) or clock.multiples[moving[0]])


def near_pairs(one: cKDTree, other: cKDTree, apart_m: float) -> tuple[Ints, Ints] | None:
    """Indices (m,) into both of all pairs of places nearer than ``apart_m``; None where they are too many to hold.

    Then both loops keep near each other most of the time, and are taken as always near.
    """
    if one.count_neighbors(other, apart_m) > MOST_CELLS:
        return None
    near = one.sparse_distance_matrix(other, apart_m, output_type="ndarray")
    return near["i"].astype(np.int64), near["j"].astype(np.int64)


def grid_of(loops: Sequence[Loop], clock: Clock, speed_m_s: float, body_radius_m: float, most_samples: int) -> Grid:
    """The clock in samples a tenth of a body apart at the greatest speed driven, or so that a round has so many."""
    longest_s = max(loop.robots * m * clock.unit_s for loop, m in zip(loops, clock.multiples, strict=True))
    step_s = max(0.1 * body_radius_m / max(speed_m_s, 1e-12), longest_s / most_samples)
    bins = max(1, math.ceil(clock.unit_s / step_s))
    step_s = clock.unit_s / bins
    return Grid(bins, step_s, 2 * body_radius_m + speed_m_s * step_s)
