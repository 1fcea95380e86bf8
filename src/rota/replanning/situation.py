"""How things are when a plan is changed: which robots remain and where, the mission as it is now, what was driven."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import shapely
from shapely import MultiPolygon

from rota.errors import MissionError
from rota.geometry.free_space import free_ground, nearest_free_point, standing_space
from rota.model.battery_limits import BATTERY_FIELDS
from rota.model.limits import LARGEST_M, LONGEST_S
from rota.model.mission import TOUCH_M, Fleet, Mission, Obstacle, Robot, Sensor
from rota.model.plan import Driven, Plan, Seam, Trajectory
from rota.model.polygons import polygons_of
from rota.routes.charging_legs import charging_legs
from rota.routes.moments import delay, earlier_by, go_on, join_ways, way_before

Level = Callable[[float], float]
Place = tuple[float, float]

INSIDE_M = 0.01  # so far inside of a space a place to go to stays in it when it is rounded to centimetres
TOLD = 2.0  # times the longest period and round: so much of what was driven is told
BEFORE = " (before)"  # added to the name of a robot that goes on from another place than where it came to


@dataclass(frozen=True, kw_only=True)
class Change:
    """What changes at ``at_s`` of a plan's clock, seconds.

    lost: robots that are there no more. joined: robots that are there from then on, and where, metres. late: robots
    that have driven all so many seconds later than planned. mission: as it is from then on; None: as before.
    battery: how full batteries are then, 0 to 1, of robots that join, full unless said, and of others where it is less
    than the plan leaves them.
    """

    at_s: float
    lost: tuple[str, ...] = ()
    joined: Mapping[str, Place]
    late: Mapping[str, float]
    mission: Mission | None = None
    battery: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Situation:
    """mission: of the robots that remain, each with its start, but on lanes. seam: what a plan takes over from.

    places: where robots are that remain. going_on: what they would drive from now on by the plan before, by name;
    loops: what all would, lost ones too. The clock is 0 now. team: the fleet of the plan before. batteries: of those
    that remain, 0 to 1.
    """

    mission: Mission
    seam: Seam
    places: dict[str, Place]
    going_on: dict[str, Trajectory]
    loops: tuple[Trajectory, ...]
    team: Fleet
    batteries: dict[str, float]


def situation_after(plan: Plan, change: Change) -> Situation:
    """The situation once the change has happened. Raises MissionError for a change that the plan or mission rules out.

    It names the robot or the option, the value, and what is allowed.
    """
    _require_right(plan, change)
    delayed = [delay(trajectory, change.late.get(trajectory.robot, 0.0)) for trajectory in plan]
    levels = levels_of_plan(plan, delayed)
    batteries = {name: min(level(change.at_s), change.battery.get(name, 1.0)) for name, level in levels.items()}
    now = {line.robot: go_on(line, change.at_s, batteries[line.robot]) for line in delayed}
    remain = {name: line for name, line in now.items() if name not in change.lost}
    places = {name: (float(line.positions_m[0, 0]), float(line.positions_m[0, 1])) for name, line in remain.items()}
    places |= change.joined
    mission = _mission_of(plan, change, places)
    return Situation(
        mission=mission,
        seam=_seam_of(plan, change, mission, delayed, levels),
        going_on=remain,
        places=places,
        loops=tuple(now.values()),
        team=plan.mission.fleet,
        batteries={name: batteries[name] if name in remain else change.battery.get(name, 1.0) for name in places},
    )


def _require_right(plan: Plan, change: Change) -> None:
    """MissionError for times, names and places that cannot be."""
    names = [trajectory.robot for trajectory in plan]
    has = f"the plan has {', '.join(names) or 'no robots'}"
    if not 0 <= change.at_s <= LONGEST_S:
        raise MissionError(
            f"at_s: {change.at_s!r} is not allowed; seconds from 0, where the plan begins, to {LONGEST_S:g} are needed"
        )
    if change.mission is not None:
        require_same_batteries(plan, change.mission, change.lost)
    for name in change.lost:
        if name not in names:
            raise MissionError(f"lost: robot {name!r} is not in the plan; {has}")
    for name, late_s in change.late.items():
        if name not in names or name in change.lost:
            raise MissionError(f"late: robot {name!r} is {'lost' if name in names else 'not in the plan'}; {has}")
        if not 0 <= late_s <= LONGEST_S:
            raise MissionError(f"late: {name}={late_s!r} is not allowed; seconds from 0 to {LONGEST_S:g} are needed")
    for name, place in change.joined.items():
        if name in names and name not in change.lost:
            raise MissionError(f"joined: robot {name!r} is in the plan already; give it another name, or as lost, too")
        if not all(abs(at_m) <= LARGEST_M for at_m in place):
            raise MissionError(
                f"joined: {name}={place[0]},{place[1]} is not allowed; x,y in metres, from {-LARGEST_M:g} to"
                f" {LARGEST_M:g}, are needed"
            )
    for name, share in change.battery.items():
        if name not in change.joined and (name not in names or name in change.lost):
            raise MissionError(f"battery: robot {name!r} is {'lost' if name in names else 'not in the plan'}; {has}")
        if not 0 <= share <= 1:
            raise MissionError(f"battery: {name}={share!r} is not allowed; 0 (empty) to 1 (full) is needed")
        if all(robot.battery.endurance_s is None for robot in plan.mission.fleet.unlike_robots):
            raise MissionError(f"battery: {name}={share!r} is not allowed; batteries never run low in this plan")
    if not set(names) - set(change.lost) and not change.joined:
        raise MissionError(f"lost: all of {', '.join(names)}: no robot remains; give some that join")


def _mission_of(plan: Plan, change: Change, places: Mapping[str, Place]) -> Mission:
    """The mission as it is now, of these robots, each with its start; on lanes they have none."""
    asked = change.mission or plan.mission
    fleet = asked.fleet
    listed = {robot.name: robot for robot in fleet.robots or ()}
    for name in places:
        if change.mission is not None and listed and name not in listed:
            told = "add it there" if name in change.joined else "add it there, or say that it is lost"
            raise MissionError(f"fleet.robots: robot {name!r} is not among those of the changed mission; {told}")
    for name in listed:
        if change.mission is not None and name not in places and name not in change.lost:
            raise MissionError(
                f"fleet.robots: robot {name!r} of the changed mission is not in the plan; say where it joins, or take"
                " it out"
            )
    holds_s = None if change.mission is None else asked.holds_within_s
    robots = [listed.get(name) or _robot(fleet, name) for name in places]
    for robot in robots:
        _require_room(asked, robot, change, places[robot.name])

    def mission_with(starts: Mapping[str, Place]) -> Mission:
        """The mission of these robots with starts."""
        own = tuple(replace(robot, start=starts.get(robot.name)) for robot in robots)
        team = replace(fleet, sensor=_usual_sensor(asked, robots), robots=own, kinds=(), start=None)
        return replace(asked, fleet=team, holds_within_s=holds_s)

    try:
        return mission_with(places)
    except MissionError:  # on lanes, and where autopilots begin their rounds by themselves, robots have none
        return mission_with({})


def _usual_sensor(mission: Mission, robots: Sequence[Robot]) -> Sensor:
    """The sensor of robots unless said: where all are lost that have one which a zone names, that one."""
    known = {robot.sensor.name for robot in robots} | {mission.fleet.sensor.name}
    for zone in mission.zones:
        if zone.sensors and not known & set(zone.sensors):
            return next(one.sensor for one in mission.fleet.unlike_robots if one.sensor.name in zone.sensors)
    return mission.fleet.sensor


def _robot(fleet: Fleet, name: str) -> Robot:
    """A robot that the fleet does not list: of the kind that its name tells, or one of the equals."""
    return fleet.kind_of(name).robot(name) if fleet.kinds else fleet.equal_robot(name)


def _require_room(mission: Mission, robot: Robot, change: Change, place: Place) -> None:
    """MissionError, with the nearest place where it can be, for a robot whose body is where none can be now."""
    free, point = free_ground(mission), shapely.Point(place)
    # a place on the way past a corner may be off it by rounding
    if free.distance(point) <= TOUCH_M and free.boundary.distance(point) >= robot.body_radius_m - TOUCH_M:
        return
    space = standing_space(mission, robot.body_radius_m)
    walls = [(k, one) for k, one in enumerate(mission.obstacles) if one.blocks_motion]
    near_m = robot.body_radius_m + TOUCH_M
    there = next((f"obstacles[{k}]" for k, one in walls if one.shape.distance(point) < near_m), None)
    has = (
        f"has {there or 'no area'}" if not free.covers(point) else f"has {there or 'its border'} too near for its body"
    )
    told = (
        f"robot {robot.name}: at t = {change.at_s:g} s it is at ({place[0]:.2f}, {place[1]:.2f}), where the mission as"
        f" it is now {has}"
    )
    if space.is_empty:
        raise MissionError(f"{told}; no robot of its size can be anywhere")
    x, y = _place_told(space, place)
    how = "give it" if robot.name in change.joined else "from there, give it as lost, and"
    raise MissionError(
        f"{told}; it can go to ({x:.12g}, {y:.12g}), {math.dist(place, (x, y)):.2f} m away: {how} as joined at"
        f" {x:.12g},{y:.12g}"
    )


def _place_told(space: MultiPolygon, place: Place) -> Place:
    """A place in a space as near as can be to another one, in whole centimetres but where these are all outside."""
    nearest = nearest_free_point(space, place)
    for inside_m in (0.0, INSIDE_M):
        if not (smaller := polygons_of(space.buffer(-inside_m))).is_empty:
            x, y = nearest_free_point(smaller, place)
            if space.covers(shapely.Point(round(x, 2), round(y, 2))):
                return round(x, 2), round(y, 2)
    return nearest


def _seam_of(
    plan: Plan, change: Change, mission: Mission, delayed: Sequence[Trajectory], levels: Mapping[str, Level]
) -> Seam:
    """What was driven before, as far back as any period may ask for it."""
    periods_s = [
        period_s or 0.0
        for asked in (plan.mission, mission)
        for period_s in (asked.period_s, *(zone.period_s for zone in asked.zones))
    ]
    told_s = TOLD * max([*periods_s, *(trajectory.loop_duration_s for trajectory in delayed)], default=0.0)
    earlier = _driven_earlier(plan, change.at_s)
    driven = []
    for trajectory in delayed:
        sensor, from_s = plan.mission.fleet.robot(trajectory.robot).sensor, max(0.0, change.at_s - told_s)
        one = way_before(trajectory, sensor, change.at_s, told_s, levels[trajectory.robot](from_s))
        if (was := earlier.pop(trajectory.robot, None)) is not None:
            one = join_ways(later_part(plan, was, told_s), one, told_s)
        one = replace(one, climbed_s=_climbed_s(plan, trajectory, one, change.at_s))
        moved = trajectory.robot in change.lost and trajectory.robot in change.joined
        driven.append(replace(one, robot=trajectory.robot + BEFORE) if moved else one)
    lost = [name + BEFORE if name in change.joined else name for name in dict.fromkeys(change.lost)]
    taken = {one.robot for one in driven} | set(change.joined)
    gone = [one for name, one in earlier.items() if name not in taken and one.times_s[-1] > -told_s]
    return Seam(
        at_s=change.at_s,
        lost=(*lost, *(one.robot for one in gone)),
        driven=(*driven, *gone),
        obstacles=_walls_before(plan.mission, mission),
    )


def _climbed_s(plan: Plan, line: Trajectory, driven: Driven, at_s: float) -> float:
    """For how long a robot has been climbing off its charger at a moment, up to which it was driven."""
    robot = plan.mission.fleet.robot(line.robot)
    climbing_s = robot.battery.climbing_s
    if climbing_s == 0:
        return 0.0
    legs = charging_legs(go_on(line, at_s), robot, plan.mission.chargers)
    if legs.docks[0] >= 0:
        return max(climbing_s - float(legs.leaves_s[0]), 0.0)
    return climbing_s if driven.charges and driven.charges[-1].until_s == 0 else 0.0


def _driven_earlier(plan: Plan, at_s: float) -> dict[str, Driven]:
    """What was driven before the plan itself took over from another one, by name; nothing where walls were others."""
    if plan.seam is None or plan.seam.obstacles is not None:
        return {}
    return {one.robot: earlier_by(one, at_s) for one in plan.seam.driven}


def _walls_before(before: Mission, now: Mission) -> tuple[Obstacle, ...] | None:
    """What blocked sight before, where that is not what does now; None: it is."""
    walls = [tuple(one for one in mission.obstacles if one.blocks_sight) for mission in (before, now)]
    return None if walls[0] == walls[1] else walls[0]


def levels_of_plan(plan: Plan, driven: Sequence[Trajectory]) -> dict[str, Level]:
    """The share of each robot's battery that is left at a moment, by its name; 1 of one that never runs low.

    driven: the trajectories of the plan, as they were driven.
    """
    from rota.check.charging import battery_levels

    def level_of(line: Trajectory) -> Level:
        """The share of one robot's battery at a moment."""
        full_s = plan.mission.fleet.robot(line.robot).battery.endurance_s
        if full_s is None:
            return lambda time_s: 1.0
        levels = battery_levels(plan, line)
        return lambda time_s: float(np.clip(levels.at(time_s, line) / full_s, 0.0, 1.0))

    return {line.robot: level_of(line) for line in driven}


def later_part(plan: Plan, driven: Driven, least_s: float) -> Driven:
    """What was driven in the last ``least_s`` seconds and the leg before, with how full the battery was then."""
    from rota.check.charging import level_after_s

    first = max(0, int(np.searchsorted(driven.times_s, -least_s, side="right")) - 1)
    full_s = plan.mission.fleet.robot(driven.robot).battery.endurance_s
    if plan.mission.fleet.robot(driven.robot).battery.landing_s > 0:  # a stay that is told begins with its landing
        since_s = float(driven.times_s[first])
        own = [one.from_s for one in driven.charges if one.from_s < since_s < one.until_s]
        first = int(np.searchsorted(driven.times_s, own[0])) if own else first
    if first == 0 or full_s is None:
        return driven
    since_s = float(driven.times_s[first])
    level_s = level_after_s(plan, driven, since_s)
    changes = driven.accelerations_m_s2
    return replace(
        driven,
        times_s=driven.times_s[first:],
        positions_m=driven.positions_m[first:],
        accelerations_m_s2=None if changes is None else changes[first:],
        charges=tuple(replace(one, from_s=max(one.from_s, since_s)) for one in driven.charges if one.until_s > since_s),
        battery=float(np.clip(level_s / full_s, 0.0, 1.0)),
    )


def require_same_batteries(plan: Plan, changed: Mission, lost: Collection[str]) -> None:
    """MissionError where a changed mission has other batteries, or lacks a charger: levels go on from the plan's."""
    there = {charger.name: (charger.at, charger.swap_s) for charger in changed.chargers}
    for charger in plan.mission.chargers:
        if there.get(charger.name) != (charger.at, charger.swap_s):
            raise MissionError(
                f"chargers: {charger.name!r} of the changed mission is not where, or as, it is in the plan; give it as"
                " it was: other places, and more chargers, are allowed"
            )
    listed = {robot.name for robot in changed.fleet.robots or ()}
    for line in plan:
        if line.robot in lost or (listed and line.robot not in listed):
            continue
        if plan.mission.fleet.robot(line.robot).battery != changed.fleet.robot(line.robot).battery:
            raise MissionError(
                f"fleet: the battery of robot {line.robot} in the changed mission is not as in the plan; give its"
                f" {', '.join(BATTERY_FIELDS)} as they were"
            )
