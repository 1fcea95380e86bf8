"""The seam between what a robot can do and every search: metres of way into time, corners, timed rounds."""

from __future__ import annotations

import functools
from typing import Protocol

from rota.model.arrays import Floats
from rota.model.mission import Robot
from rota.planners.patrol.driving.at_once import AtOnce
from rota.planners.patrol.driving.auto import Auto
from rota.planners.patrol.driving.corner_costs import CornerCosts, Slopes
from rota.planners.patrol.driving.rounded import driving_with_mass
from rota.planners.patrol.driving.timed_line import TimedLine
from rota.vehicles.models import MODELS
from rota.vehicles.presets import vehicle_within


class Driving(Protocol):
    """What a robot can do. Times are told as the metres that it travels in them at its pace.

    pace_m_s: about its speed on its rounds, so that a metre of a usual round costs a metre; full speed without mass.
    has_mass: speeds take time to change. corner_costs: what corners add, for compiled loops; sums of them are near to
    ``round_m``, which is exact. off_m: how far from its polyline it drives at most, where it cuts corners. blind_m: of
    a leg's end at a right angle, from where a search counts nothing as seen, since the corner is cut.
    """

    robot: Robot
    pace_m_s: float
    has_mass: bool
    corner_costs: CornerCosts
    off_m: float
    blind_m: float

    def round_m(self, vertices_m: Floats) -> float:
        """Metres of one round of a closed polyline (n, 2), all that costs time included; 0 for one vertex."""
        ...

    def driven(self, vertices_m: Floats) -> tuple[Floats, Floats]:
        """The way (m + 1, 2) of one round of a closed polyline (n, 2), and beside what each of its chords lies.

        That is told (m, 2) in legs from the first vertex on, from where to where; a chord is beside one leg.
        """
        ...

    @property
    def slopes(self) -> Slopes | None:
        """What a round of a closed polyline (n, 2) costs more for each metre that a vertex moves along an axis.

        Twice (n, 2) in metres: as it grows with the move, and whichever way it goes, as bends of straight ways do. None
        where that is not known.
        """
        ...

    def timed(self, vertices_m: Floats) -> TimedLine:
        """One round of a closed polyline (n, 2) as fast as it can be driven; one row where it has no length."""
        ...


@functools.lru_cache(maxsize=64)
def driving_of(robot: Robot) -> Driving:
    """What a robot can do, by its limits; of a vehicle whose firmware is modelled, by that model."""
    if not robot.motion.has_mass:
        return AtOnce(robot)
    if robot.motion.vehicle in MODELS:
        return Auto(robot, MODELS[robot.motion.vehicle](vehicle_within(robot.motion)))
    return driving_with_mass(robot)
