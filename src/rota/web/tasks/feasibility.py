"""What cannot work, or hardly, of a mission whose every value is allowed: starts, speeds, ranges, periods."""

from __future__ import annotations

import math
from collections.abc import Iterator

import shapely
from shapely import Polygon

from rota.model.fleet import Robot, StartBox, StartPoints, inner_reach_m
from rota.model.mission import Mission
from rota.web.refusal import Json
from rota.web.tasks.context import fault_json

FASTEST_M_S = 150.0  # no patrolling robot is faster
FAR = 10.0  # times across the area: a sensor that reaches farther was meant in another unit
HARDLY = 0.1  # of its sensor's reach: with so short a way there and back a robot watches as if it stood
DENSEST = math.sqrt(12)  # room of a disc over its radius squared, when discs lie as close as they can
EXACT = 1e-3  # of its size, to which the widest circle of the area is found
SLACK = 1.01

START = ("fleet", "start")


def hopeless(mission: Mission, least_robots: int) -> Iterator[Json]:
    """Faults of a mission that no plan can mend.

    least_robots: any plan needs so many, as is proved; 1 where nothing is.
    """
    fleet = mission.fleet
    if isinstance(fleet.start, StartPoints) and fleet.robots is None and len(fleet.start.points_m) < least_robots:
        given = _count_in_words(len(fleet.start.points_m), "start is", "starts are")
        yield fault_json(START, f"{given} given, and at least {least_robots} robots are needed, each with its own")
    if isinstance(fleet.start, StartBox):
        robots = max(least_robots, sum(robot.start is None for robot in fleet.robots or ()))
        if (room := _most_in(fleet.start, min(robot.body_radius_m for robot in _robots(mission)))) < robots:
            room_for = _count_in_words(max(room, 0), "robot", "robots")
            message = f"there is room for at most {room_for}, and at least {robots} start there: make it larger"
            yield fault_json((*START, "box"), message)


def doubtful(mission: Mission, least_robots: int) -> Iterator[Json]:
    """Warnings of what is allowed, and is hardly meant."""
    across_m = math.dist(mission.area.bounds[:2], mission.area.bounds[2:])
    periods = [mission.period_s, *(zone.period_s for zone in mission.zones)]
    shortest_s = min((period for period in periods if period is not None), default=None)
    for robot, place in _different(mission):
        if robot.speed_m_s > FASTEST_M_S:
            told = (
                f"{robot.speed_m_s:,.6g} m/s is {robot.speed_m_s * 3.6:,.6g} km/h, faster than any robot that patrols"
            )
            yield fault_json((*place, "speed_m_s"), told)
        reach_m = inner_reach_m(robot.sensor)
        if reach_m > FAR * across_m:
            told = f"it reaches {reach_m:,.6g} m, and the area is {across_m:,.4g} m across: is it meant in metres?"
            yield fault_json((*place, "sensor"), told)
        way_m = robot.speed_m_s * (shortest_s or math.inf)
        if way_m / 2 < HARDLY * min(reach_m, across_m):
            told = (
                f"in the shortest period, {shortest_s:.6g} s, a robot drives {way_m:.4g} m: it watches as if it stood"
            )
            yield fault_json((*place, "speed_m_s"), told)
    if shortest_s is not None:  # what is asked again and again takes loops
        yield from _too_wide_turns(mission)
    fleet = mission.fleet
    if fleet.robots is not None and len(fleet.robots) < least_robots:
        have = _count_in_words(len(fleet.robots), "robot", "robots")
        told = (
            f"{have} cannot meet the periods, which take at least {least_robots}: the plan will be the least late one"
        )
        yield fault_json(("fleet", "robots"), told)
    if isinstance(fleet.start, StartPoints) and fleet.robots is None and len(fleet.start.points_m) == least_robots:
        told = "there are as many starts as robots are surely needed; a plan that needs more has nowhere to start them"
        yield fault_json(START, told)


def _robots(mission: Mission) -> tuple[Robot, ...]:
    return mission.fleet.unlike_robots


def _different(mission: Mission) -> Iterator[tuple[Robot, tuple[str | int, ...]]]:
    """Robots that differ in what they drive and see, the first of each kind, and where in the document they stand."""
    fleet = mission.fleet
    yield fleet.equal_robot("robot-1"), ("fleet",)
    seen = {(fleet.speed_m_s, fleet.sensor)}
    for k, robot in enumerate(fleet.robots or ()):
        if (robot.speed_m_s, robot.sensor) not in seen:
            seen.add((robot.speed_m_s, robot.sensor))
            yield robot, ("fleet", "robots", k)


def _most_in(start: StartBox, body_radius_m: float) -> float:
    """Bodies whose centres fit into a box, at most: no convex room is filled denser with discs than the plane."""
    if body_radius_m == 0:
        return math.inf
    (x0, y0), (x1, y1) = start.low_m, start.high_m
    room_m2 = (x1 - x0 + 2 * body_radius_m) * (y1 - y0 + 2 * body_radius_m)
    return max(1, math.floor(SLACK * room_m2 / (DENSEST * body_radius_m**2)))


def _too_wide_turns(mission: Mission) -> Iterator[Json]:
    """Of turn radii with which no loop stays inside: one that bends no tighter than a radius goes round a disc of it.

    Pestov and Ionin, On the largest possible circle embedded in a given closed curve (1959). Holes count as ground.
    """
    radius_m = mission.fleet.turn_radius_m
    if radius_m > 0 and radius_m > SLACK * max(_inner_radius_m(polygon) for polygon in mission.area.geoms):
        told = f"no loop on arcs of {radius_m:.6g} m fits into the area: a robot can only stand in one place"
        yield fault_json(("fleet", "turn_radius_m"), told)


def _inner_radius_m(polygon: Polygon) -> float:
    """The radius of the largest circle in a polygon without its holes."""
    filled = Polygon(polygon.exterior)
    x0, y0, x1, y1 = filled.bounds
    exact_m = EXACT * min(x1 - x0, y1 - y0)
    return float(shapely.length(shapely.maximum_inscribed_circle(filled, tolerance=exact_m))) + float(exact_m)


def _count_in_words(number: float, one: str, more: str) -> str:
    return f"{number:g} {one if number == 1 else more}"
