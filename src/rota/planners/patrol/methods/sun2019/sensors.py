"""The first two stages: virtual sensors that cover all ground, and a frame, a short closed tour past them.

A virtual sensor sees twice as far as a robot: a robot that goes round the frame at the sensor's range sees to there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rota.errors import NoPlanFound
from rota.model.arrays import Flags, Floats, Ints, ShortInts
from rota.model.mission import DiscSensor
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.samples import lay_out
from rota.planners.patrol.ground.viewpoints import choose_viewpoints, what_places_see
from rota.planners.patrol.methods.sun2019.cover import exact_cover
from rota.planners.patrol.tours.visiting_order import short_order

ACROSS_ZONES_M = 10_000.0  # alpha of Eq. 12: metres that a step to a sensor of another period counts as


@dataclass(frozen=True, kw_only=True)
class Frame:
    """A closed tour past the sensors in one part of the space.

    places_m: (n, 2) the sensors in their order; period_class: (n,) whose ground each is there for; legs_m: (n,) metres
    of the way from each to the next, the last to the first.
    """

    places_m: Floats
    period_class: Ints
    legs_m: Floats
    part: int


def frames_past_sensors(problem: Problem, cover: str) -> list[Frame]:
    """The frames, one in each part of the space that has sensors. cover: "greedy" or "exact"."""
    places_m, period_class = deployed_sensors(problem, cover)
    parts = problem.paths.part_of(places_m)
    return [
        frame_past(problem, places_m[parts == part], period_class[parts == part], int(part))
        for part in np.unique(parts)
    ]


def deployed_sensors(problem: Problem, cover: str) -> tuple[Floats, Ints]:
    """Sensors (n, 2), and the period class (n,) that each is there for: ground of the shortest periods has its first.

    Places are chosen among those to look from, for samples as far apart as the paper's cells. Raises NoPlanFound for
    square sensors.
    """
    sensor = problem.robot.sensor
    if not isinstance(sensor, DiscSensor):
        raise NoPlanFound(
            f"fleet.sensor: a square of side {sensor.side_m:.6g} m cannot be used with patrol.method sun2019, which is"
            " made for discs; give shape: disc and a radius_m, or another method"
        )
    wide = replace(problem.robot, sensor=DiscSensor(radius_m=2 * sensor.radius_m))
    step = max(1, round(0.48 * sensor.radius_m / problem.spacing_m))
    lattice = (problem.points.row % step == 0) & (problem.points.column % step == 0)
    points, samples, _ = lay_out(problem.points[(problem.points.row < 0) | lattice], problem.walls, wide)
    places_m = problem.viewpoints.xy_m
    # routes cut corners: discs overlap a little
    start, items = what_places_see(places_m, wide, problem.range_margin_m + 0.04 * sensor.radius_m, samples)
    left, chosen, classes = np.ones(len(points), dtype=bool), list[Ints](), list[Ints]()
    for period_class in range(len(problem.periods_s)):
        wanted = left & (points.period == period_class)
        found = chosen_places(start, items, wanted, cover)
        chosen.append(found)
        classes.append(np.full(len(found), period_class))
        for place in found:
            left[items[start[place] : start[place + 1]]] = False
    return places_m[np.concatenate(chosen)], np.concatenate(classes)


def chosen_places(start: Ints, items: ShortInts, wanted: Flags, cover: str) -> Ints:
    """Places (k,) that see all wanted samples (s,) that any sees. start (c + 1,), items: what each place sees."""
    if cover == "greedy":
        return choose_viewpoints(start, items, wanted, np.ones(len(wanted)))[0]
    kept = wanted[items]
    number = np.cumsum(wanted) - 1
    own_start = np.concatenate([[0], np.cumsum(kept)])[start]
    return exact_cover(own_start, number[items[kept]], int(wanted.sum()))[0]


def frame_past(problem: Problem, places_m: Floats, period_class: Ints, part: int) -> Frame:
    """A short closed tour past the sensors (n, 2) of one part, which changes seldom from one period to another."""
    changes = period_class[:, None] != period_class[None]
    order = short_order(problem.paths.all_pairs(places_m) + ACROSS_ZONES_M * changes)
    places_m = places_m[order]
    legs_m = [problem.paths.distances(a[None], b[None])[0, 0] for a, b in _legs(places_m)]
    return Frame(places_m=places_m, period_class=period_class[order], legs_m=np.array(legs_m), part=part)


def _legs(places_m: Floats) -> zip[tuple[Floats, Floats]]:
    return zip(places_m, np.roll(places_m, -1, axis=0), strict=True)
