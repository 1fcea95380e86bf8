"""One robot fewer on a tour that several share: they then follow each other in more than a period.

A place that is seen from c metres of a tour is out of sight only for the rest of a headway. So robots may follow each
other V T + c metres apart where every place is seen from so much of the tour. The search for fewest robots, for which
they are V T apart, leaves this out. Here tours that lack little for one robot less are searched once more, with c
metres a robot to spare and with a sensor that reaches less far. The judge is asked for what the mission asks.
"""

from __future__ import annotations

import math
from dataclasses import replace

from rota.errors import NoPlanFound
from rota.model.mission import DiscSensor, Mission, Sensor
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.methods.fewest.one_fewer import give_up_robots
from rota.planners.patrol.repair.repair import Repaired
from rota.planners.patrol.shortening.search import LARGEST, reaches
from rota.planners.patrol.tours.tour import Tour, tour_length_m

MOST_LACKING = 0.3  # of the reach, a robot: tours that lack more hardly ever pass
TO_SPARE, LEAST_TO_SPARE = 2.0, 0.02  # times what is lacking, and of the reach: c
FROM_TURNS = 0.2  # of the way from the reach that is enough beside straight ways to that which is enough at any turn
NEARER = 0.25  # of c: by how much nearer, in every round of repair, tours are led to what is late


def with_longer_headways(context: Context, best: Repaired) -> Repaired:
    """The plan with as many robots fewer as still pass, one after the other; the plan given where none do.

    Very large ground is left as it is, and so are curves, since a search takes minutes.
    """
    takes_long = reaches(context.problem) > LARGEST
    if takes_long or context.problem.robot.turn_radius_m > 0:
        return best
    while best.met and best.robots > context.enough_robots and not context.should_stop():
        lacking_m = least_lacking_m(best.tours)
        reach_m = context.problem.reach_m
        if lacking_m > MOST_LACKING * reach_m:
            break
        seen_m = max(LEAST_TO_SPARE * reach_m, TO_SPARE * lacking_m)
        try:
            easier = with_time_in_sight(context, seen_m)
        except NoPlanFound:
            break  # a sensor that reaches less far leaves too much out of sight
        context.progress(0.9, f"trying {best.robots - 1} robots farther apart")
        smaller = give_up_robots(easier, on_other_terms(best, context.problem, easier.problem))
        if smaller is None:
            break
        best = on_other_terms(smaller, easier.problem, context.problem)
    return best


def least_lacking_m(tours: list[Tour]) -> float:
    """Metres a robot, of the shared tour that lacks least, by which it is too long for one robot less; inf: none is.

    Loops within loops are left out: how often their robots come by differs from place to place.
    """
    shared = [tour for tour in tours if tour.robots > 1 and tour.nest < 0]
    lacking_m = (tour_length_m(t) / (t.robots - 1) - replace(t, robots=1).budget_m for t in shared)
    return max(0.0, min(lacking_m, default=math.inf))


def with_time_in_sight(context: Context, seen_m: float) -> Context:
    """The search for tours of which ``seen_m`` metres see every place, and that are as much longer for each robot."""
    problem, settings = context.problem, context.settings
    easier = set_up_problem(mission_with_longer_headways(problem.mission, seen_m))
    growth = NEARER * seen_m / easier.range_margin_m
    repair = replace(
        settings.repair,
        tight_bend_growth=max(growth, settings.repair.tight_bend_growth),
        roomy_bend_growth=max(growth, settings.repair.roomy_bend_growth),
    )
    return replace(context, problem=replace(easier, mission=problem.mission), settings=replace(settings, repair=repair))


def mission_with_longer_headways(mission: Mission, seen_m: float) -> Mission:
    """The mission with all periods but those of visits longer by ``seen_m`` metres, and sensors that reach less far."""
    longer_s = seen_m / mission.fleet.equal_robot("any").ground_speed_m_s
    zones = tuple(
        zone if zone.period_s is None or zone.demand == "visit" else replace(zone, period_s=zone.period_s + longer_s)
        for zone in mission.zones
    )
    outside_s = None if mission.period_s is None else mission.period_s + longer_s
    sensor = reaching_less(mission.fleet.sensor, seen_m)
    return replace(mission, zones=zones, period_s=outside_s, fleet=replace(mission.fleet, sensor=sensor))


def reaching_less(sensor: Sensor, seen_m: float) -> Sensor:
    """The sensor that reaches so much less that what it sees is seen from about ``seen_m`` metres of the way.

    Beside a straight way, what is at most sqrt(r^2 - c^2 / 4) off is in reach for c metres; at any turn, what is at
    most r - c / 2 off. In between lies what few tours have to be repaired from.
    """

    def less(reach_m: float) -> float:
        beside_m, at_turns_m = math.sqrt(reach_m**2 - seen_m**2 / 4), reach_m - seen_m / 2
        return beside_m + FROM_TURNS * (at_turns_m - beside_m)

    if isinstance(sensor, DiscSensor):
        return replace(sensor, radius_m=less(sensor.radius_m))
    return replace(sensor, side_m=2 * less(sensor.side_m / 2))


def on_other_terms(found: Repaired, problem: Problem, other: Problem) -> Repaired:
    """The plan with its tours as those of another problem, of the same regions with other periods and sensors.

    A tour that serves several of the other's periods gets the shortest.
    """
    periods_s = [
        min(region.period_s for region, k in zip(other.regions, problem.region_class, strict=True) if k == period_class)
        for period_class in range(len(problem.periods_s))
    ]
    tours = [
        replace(
            tour,
            period_s=periods_s[tour.period_class],
            period_class=other.periods_s.index(periods_s[tour.period_class]),
            robot=other.robot,
        )
        for tour in found.tours
    ]
    return replace(found, tours=tours)
