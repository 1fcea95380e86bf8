"""How many robots at least where they charge: those in the air on average, those on chargers, and the ways between.

Statement. If no plan whose batteries last for ever earns its ground with fewer than W robots, in the sense of
``rate_bound``, ground within reach of chargers left out, then a plan with charging takes

    robots >= W (1 + k) / (1 - w)

where a robot charges for k seconds at least for each second away from chargers, and the share w at least of each flight
is spent on the ways between chargers and ground that is asked for. On average W k / (1 - w) robots are on chargers.

Proof. ``rate_bound`` weighs ground so that a robot earns 1 per second at most by bringing ground into range and by
holding it there; what comes into range also leaves it. A robot that takes off brings ground into range at once, and one
that lands loses it, but only within reach of a charger: with no weight there, nothing is earned by that. Robots on
chargers earn nothing, nor do those from which nothing is in range that has a weight. So W robots on average are away
from chargers and have such ground in range. A flight lasts u seconds at most. Its ways out and back take 2 d / v at
least, d from the nearest charger to where ground comes into range: w = 2 d / (u v). In the long run a battery takes as
much as it gives: k is the least of recharge over endurance, and of the seconds of a swap over those that a full battery
can be used. Where each flight costs t beside its seconds, u of driving at most, a second away takes 1 + t / u at least;
where each stay begins with a landing and ends with a climb, of g seconds in all, k is g / u more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

from rota.errors import NoPlanFound
from rota.model.mission import Mission
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.bounds.rate_bound import swept_robots
from rota.planners.patrol.bounds.seeable_area import surely_seeable_m2
from rota.planners.patrol.bounds.strongest_robot import strongest_robot
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.tolerances import ROUNDING


@dataclass(frozen=True, kw_only=True)
class Charging:
    """How a fleet charges: ``per_s`` seconds for each second away, and the share ``ways`` of each flight for ways."""

    per_s: float
    ways: float


def charging_of(mission: Mission) -> Charging:
    """The least that charging costs a mission's robots; ``ways`` is 1 or more where no flight reaches any ground."""
    robot, chargers = mission.fleet.equal_robot("robot-1"), mission.chargers
    battery, reach_m = robot.battery, strongest_robot(mission.fleet).sensor.reach_m
    endurance_s = battery.endurance_s or math.inf
    use = min(1.0, battery.standing_uses)  # of the battery, per second
    taken = 1 + battery.departure_s / battery.usable_s  # with take-offs, for each second's use
    each = [
        charger.swap_s / battery.usable_s
        if charger.swap_s is not None
        else (battery.recharge_s or 0.0) / endurance_s * taken
        for charger in chargers
    ]
    grounding = battery.grounding_s / battery.usable_s
    asked = [zone.shape for zone in mission.zones if zone.period_s is not None]
    ground = shapely.union_all([mission.area] if mission.period_s is not None else asked)
    away_m = min(shapely.distance(shapely.Point(charger.at), ground) for charger in chargers)
    ways_s = 2 * max(0.0, away_m - reach_m) / robot.ground_speed_m_s
    return Charging(per_s=use * (min(each) + grounding), ways=ways_s * use / battery.usable_s)


def charging_bound(problem: Problem, mission: Mission) -> ProvedBound:
    """Robots at least for a mission whose ground is laid out as ``problem``. NoPlanFound where places are too few."""
    charging, robot = charging_of(mission), strongest_robot(mission.fleet)
    flying, asked_m2_s = swept_robots(*_ground_off_chargers(problem, mission), robot)
    flying /= 1 - charging.ways
    places = sum(charger.places for charger in mission.chargers)
    if flying * charging.per_s > places * (1 + ROUNDING):
        raise NoPlanFound(
            f"chargers: they have {places} place{'s'[: places > 1]}, but {flying * charging.per_s:.4g} robots must be"
            f" on them on average: {asked_m2_s:.4g} m2/s are asked for, so that {flying:.4g} robots are away from them,"
            f" and each {_stays_in_words(mission)} {charging.per_s:.4g} s for a second away; give more places"
        )
    return ProvedBound(
        robots=math.ceil(flying * (1 + charging.per_s) - ROUNDING),
        reason=f"{asked_m2_s:.4g} m2/s are asked for, so that {flying:.4g} robots are away from chargers on average,"
        f" and each {_stays_in_words(mission)} {charging.per_s:.4g} s for a second away",
    )


def _stays_in_words(mission: Mission) -> str:
    """What robots do at chargers."""
    return "lands, charges and climbs for" if mission.fleet.battery.grounding_s > 0 else "charges"


def _ground_off_chargers(
    problem: Problem, mission: Mission
) -> tuple[list[shapely.MultiPolygon], list[float], list[float]]:
    """The ground of which every point is asked for, what of each counts for nothing in m2, and the periods."""
    reach_m = strongest_robot(mission.fleet).sensor.reach_m
    near = shapely.buffer(
        shapely.MultiPoint([charger.at for charger in mission.chargers]),
        reach_m * (1 + ROUNDING) / math.cos(math.pi / 64),
        quad_segs=16,
    )
    swept = [k for k, region in enumerate(problem.regions) if region.demand == "every_point"]
    seeable_m2 = surely_seeable_m2(problem.regions, problem.sure_space, problem.walls, problem.sure_robot)
    shapes = [problem.regions[k].shape for k in swept]
    lost_m2 = [
        float(np.minimum(shape.area - seeable_m2[k] + shapely.intersection(shape, near).area, shape.area))
        for k, shape in zip(swept, shapes, strict=True)
    ]
    return shapes, lost_m2, [problem.regions[k].period_s for k in swept]
