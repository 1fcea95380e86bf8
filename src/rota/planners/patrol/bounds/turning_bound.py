"""Robots at least, when they turn on the spot: whoever stays within a circle keeps turning, and sweeps nothing then.

Statement. A robot that drives at speed V and turns on the spot at rate omega, at most, and never leaves a circle of
radius R, drives V' = V / (1 + V / (R omega)) metres per second in the long run, at most.

Proof. Let a path of straight legs, with unit directions t, have its corners at places p from the circle's middle. Its
length L is the sum of the legs' (change of p) . t. Summed by parts that is what its two ends give, at most 2 R, less
the sum over its corners of p . (change of t). A turn by theta changes t by 2 sin(theta / 2) <= theta, so that
L <= R (2 + all turns). Driving takes L / V, and turning takes (L / R - 2) / omega more.

Sweeping. ``area_bound`` holds with V' for V, since it counts what windows see on average: the share V' / V of a window
is driven. In ``rate_bound`` a robot at x earns v(t) / V' of the mean of G over its rim and the mean of H over its disc,
with G and H made for V'. The two means add up to 1 at most, those of G alone to the largest share G_max of a class, and
those of H alone to H_max = 1 - G_min. A robot that drives the share s = V' / V of its time where they are g and h, and
turns where H is at its largest, earns g + s h + (1 - s) H_max <= 1 + (1 - s) (G_max - G_min), for g <= 1 - h and
g <= G_max. So the weights, divided by that, are a lower bound on the robots; with one period nothing is lost.

Source. The length of a curve in a circle and its turning: I. Fary, "Sur certaines inegalites geometriques", Acta
Sci. Math. Szeged 12 (1950).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import shapely
from shapely import MultiPolygon

from rota.model.mission import Mission, Robot
from rota.planners.patrol.bounds.area_bound import area_rate
from rota.planners.patrol.bounds.rate_bound import swept_robots
from rota.planners.patrol.bounds.strongest_robot import footprint_m2, sweep_m2_s
from rota.planners.patrol.tolerances import SURELY


def circle_radius_m(mission: Mission) -> float:
    """The radius in metres of the circle that no middle of a robot leaves: that round the area, less the body's."""
    robots = mission.fleet.unlike_robots
    body_m = min(robot.body_radius_m for robot in robots)
    return max(0.0, float(shapely.minimum_bounding_radius(mission.area)) - body_m) * SURELY


def steady_speed_m_s(robot: Robot, radius_m: float) -> float:
    """The speed in m/s that the robot keeps in the long run within a circle of ``radius_m``, at most.

    That is its speed where turning takes it no time, and 0 in a circle of no size.
    """
    if robot.turn_rate_rad_s is None:
        return robot.ground_speed_m_s
    turning_m_s = radius_m * robot.turn_rate_rad_s  # of a robot that drives in no time
    return robot.ground_speed_m_s * turning_m_s / (robot.ground_speed_m_s + turning_m_s)


def turning_robots(
    shapes: Sequence[MultiPolygon],
    seeable_m2: Sequence[float],
    periods_s: Sequence[float],
    robot: Robot,
    radius_m: float,
) -> tuple[float, float]:
    """Robots at least, not rounded, and the area per second (m2/s) that they are asked to see.

    shapes (k,): disjoint ground to be seen, seeable_m2 (k,): how much of each can be seen, at least, periods_s (k,).
    radius_m: of a circle that no robot leaves. 0 robots when nothing is asked, or when turning takes no time.
    """
    steady_m_s = steady_speed_m_s(robot, radius_m)
    if not len(shapes) or robot.turn_rate_rad_s is None or steady_m_s <= 0:
        return 0.0, 0.0
    steady = replace(robot, speed_m_s=steady_m_s)
    shares = [1 / (1 + footprint_m2(steady) / (sweep_m2_s(steady) * period_s)) for period_s in periods_s]
    most_earned = 1 + (1 - steady_m_s / robot.ground_speed_m_s) * (max(shares) - min(shares))
    lost_m2 = [shape.area - m2 for shape, m2 in zip(shapes, seeable_m2, strict=True)]
    robots, asked_m2_s = swept_robots(shapes, lost_m2, periods_s, steady)
    return max(area_rate(seeable_m2, periods_s, steady), (robots / most_earned, asked_m2_s))
