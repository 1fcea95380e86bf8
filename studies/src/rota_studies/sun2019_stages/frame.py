"""The frame as the second stage leaves it, and as the third one cuts it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.model.mission import DiscSensor, Robot

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Frame:
    """A closed path past all sensors, and what it is made of.

    order: (n,) the sensors as they follow each other. Leg i goes from sensor order[i] to the next one (the last to
    order[0]); its polyline is path_m[leg_start[i] : leg_start[i + 1] + 1] and its length legs_m[i].
    path_m: (k, 2) metres; it ends where it begins. legs_m: (n,). length_m: their sum, without alpha.
    tour_length: what was minimised, the sum of Eq. 14's distances (alpha included) or of the straight ones.
    zone_crossings: changes of sub-region along the path. blocked_legs: legs that no robot can travel as they are,
    because an obstacle or the outside is in the way; only straight distances give any.
    history: the shortest tour_length so far; of a local search by hundredth of its kicks.
    """

    order: Ints
    path_m: Floats
    leg_start: Ints
    legs_m: Floats
    tour_length: float
    zone_crossings: int
    blocked_legs: int
    history: Floats

    @property
    def length_m(self) -> float:
        """Actual length of the closed path."""
        return float(self.legs_m.sum())


@dataclass(frozen=True, kw_only=True)
class PartFrame:
    """The frame past the sensors in one connected part of the space; the paper's ground has one part.

    frame: its order counts the part's sensors; sensors: (n,) their numbers in the deployment. waypoint_periods_s: (n,)
    along the frame. part: of ``ShortestPaths.parts``. legs_m: (n,) the length that each leg counts as in the partition:
    its own, until routes round it turn out longer or shorter than Eq. 26 has them. route_lengths_m: (n, n) metres round
    each stretch of the frame; None where the partition estimates them.
    """

    frame: Frame
    sensors: Ints
    waypoint_periods_s: Floats
    part: int
    legs_m: Floats
    route_lengths_m: Floats | None = None


def radius_m(robot: Robot) -> float:
    """r_s, of a robot with a disc sensor; deployment has refused any other."""
    assert isinstance(robot.sensor, DiscSensor)
    return robot.sensor.radius_m
