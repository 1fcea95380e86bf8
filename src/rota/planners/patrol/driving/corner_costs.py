"""What corners cost in a search, in a form that compiled loops take."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from rota.model.arrays import Floats
from rota.model.mission import Robot

Slopes = Callable[[Floats], tuple[Floats, Floats]]

LONGEST_REACHES = 6.5  # the longest leg of a table: a little more than a search has


class Timing(Protocol):
    """What takes rounds into metres at a pace."""

    robot: Robot
    pace_m_s: float

    def round_m(self, vertices_m: Floats) -> float:
        """Metres of one round of a closed polyline (n, 2)."""
        ...


def blind_m(off_m: float) -> float:
    """Metres of a leg's end that count as seen from nowhere, where a right angle is cut by ``off_m``.

    So far along its legs one sees as much outwards as from the corner as it is passed.
    """
    return math.sqrt(2) * off_m


def pace_on_lanes(timing: Timing, lane_m: float | None = None) -> float:
    """The speed of a robot on lanes two reaches apart, with a right angle at either end of each.

    lane_m: how long the lanes are; None: ten reaches.
    """
    swath_m = 2 * timing.robot.sensor.reach_m
    lane_m = 5 * swath_m if lane_m is None else lane_m
    ends = np.tile([[0.0, 0.0], [lane_m, 0.0], [lane_m, swath_m], [0.0, swath_m]], (4, 1))  # four stand for many
    ends[:, 1] += np.repeat(np.arange(4), 4) * 2 * swath_m
    legs_m = np.hypot(*(np.roll(ends, -1, axis=0) - ends).T)
    return timing.pace_m_s * float(legs_m.sum()) / timing.round_m(ends)


def quarter_turn_m(timing: Timing, leg_m: float) -> float:
    """Metres that a right angle between legs of this length adds to what they take at full speed."""
    square = leg_m * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    return timing.round_m(square) / 4 - leg_m * timing.pace_m_s / timing.robot.ground_speed_m_s


@dataclass(frozen=True, kw_only=True, eq=False)
class CornerCosts:
    """What corners add to a way, as metres at its pace.

    turn_m: for each radian. arc_m: the turn radius; what tight corners add on arcs is ``at_once.spool_m``. table:
    (a, l) of a robot with mass, by the sharpness of the corner and the length of each leg beside it, see
    ``rounded_kernels.corner_table``; (0, 0) without one. longest_m: the leg of its last column; longer ones cost as
    much. straight: what a metre of a leg adds that ends at no corner. limits: of robots whose speeds annealing finds by
    itself, in the order of ``speed_kernels``; (0,) of others. quarter_turn_m: what a right angle between long legs
    costs, beside what these are long.
    """

    turn_m: float
    arc_m: float
    table: Floats
    longest_m: float
    quarter_turn_m: float
    straight: float = 0.0
    limits: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def are_free(self) -> bool:
        """Whether corners cost nothing."""
        return self.turn_m == 0 and not self.table.size and not self.limits.size


def no_table() -> Floats:
    """The table of a robot whose corners need none."""
    return np.zeros((0, 0))
