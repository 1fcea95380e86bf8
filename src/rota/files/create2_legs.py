"""Trajectories of bouncing robots -> what an iRobot Create 2 does leg by leg: drive, bump, back off, turn, wait.

On the grid a blocked robot stays at its cell's centre and turns there. A real one drives on until it bumps, and back:
each leg knows how far back from the contact that centre is. Where the plan leaves too little time for that, the leg is
driven faster than planned, up to the robot's own speed, and the plan's clock runs slower, as little as is needed. What
robots then do is another motion than the plan's, so their bodies' distances are looked at again, as driven.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from rota.errors import PlanError
from rota.files.create2_course import SAME_RAD, Contact, Stretch, Surroundings, angle_turned, stretches_of
from rota.files.create2_driven import Driven, touching_legs
from rota.model.mission import Place
from rota.model.plan import Plan, Trajectory

BODY_RADIUS_M = 0.17  # iRobot Create 2: 34 cm across
WHEEL_BASE_M = 0.235
FASTEST_M_S, SLOWEST_M_S = 0.5, 0.02
BACK_OFF_SPEED_M_S = 0.2
TURN_SPEED_M_S = 0.2  # of the wheels, where the mission gives no turn_rate_rad_s
LEAST_BACK_OFF_M = 0.005  # nearer to the wall the bumper would rub along it while the robot turns
REACTION_S = 0.05  # from the contact to the command that answers it, and to stop and go again
MOST_SLOWING = 20.0  # of the plan's clock
ROUNDS = 60  # in which legs that would make bodies touch are changed


@dataclass(frozen=True, kw_only=True)
class Leg:
    """Straight on from a place, then a turn. ``bumps``: a contact ends it, otherwise the clock does, after drive_s.

    length_m: to where the robot turns; back_off_m: from the contact to there; turn_rad: to the left, -pi..pi;
    begin_s, next_s: when this leg and the next one begin, on the plan's clock as it is slowed; spare_s: the time left
    before that, below 0 where it is short. ``meets``: the contact is with another robot.
    """

    start_m: Place
    heading_rad: float
    speed_m_s: float
    length_m: float
    bumps: bool
    ahead_m: float
    back_off_m: float
    turn_rad: float
    begin_s: float
    next_s: float
    spare_s: float
    meets: bool

    @property
    def drive_s(self) -> float:
        """How long the robot drives to where it turns."""
        return self.length_m / self.speed_m_s


@dataclass(frozen=True, kw_only=True)
class Drive:
    """All legs of a robot, the first from ``first_s`` on; after the last those from number ``loop_from`` on, again.

    Every round takes ``loop_s``. ``loop_from`` None: the robot stops for good. ``slowing``: of the plan's clock, by
    which all times here are longer than the plan's.
    """

    legs: tuple[Leg, ...]
    first_s: float
    loop_from: int | None
    loop_s: float
    turn_speed_m_s: float
    slowing: float


def drives_of(plan: Plan, *, most_slowing: float = MOST_SLOWING) -> tuple[Drive, ...]:
    """What every robot of the plan does, in the plan's order.

    At first as planned: robots that meet bump into each other if every meeting's time allows that, otherwise all turn
    by the clock before they touch. Where that leaves some leg too little time, or makes bodies touch on their ways from
    a cell's centre to a wall and back, legs are driven faster than planned, all robots' clocks run slower by one factor
    of at most ``most_slowing``, and a leg at whose contact bodies would touch turns by the clock. Raises PlanError for
    a plan that is not one for bouncing robots, or whose robots cannot be iRobot Create 2: smaller than one, faster, or
    with too little time all the same.
    """
    require_bouncing(plan)
    courses = tuple(stretches_of(trajectory) for trajectory in plan.trajectories)
    surroundings = Surroundings(plan, courses, BODY_RADIUS_M)
    ways = tuple(
        _ways(trajectory, course, _contact_of(surroundings, number))
        for number, (trajectory, course) in enumerate(zip(plan.trajectories, courses, strict=True))
    )
    wheels_m_s = [turning_speed_m_s(plan, trajectory) for trajectory in plan.trajectories]
    for meetings in (True, False):
        drives = tuple(
            _drive(t, w, [_leg_as_planned(way, wheels, meetings=meetings) for way in w.ways], wheels, 1.0)
            for t, w, wheels in zip(plan.trajectories, ways, wheels_m_s, strict=True)
        )
        legs = [leg for drive in drives for leg in drive.legs]
        in_time = all(leg.spare_s >= -1e-9 or abs(leg.turn_rad) <= SAME_RAD for leg in legs)
        possible = all(SLOWEST_M_S <= leg.speed_m_s <= FASTEST_M_S for leg in legs)
        if in_time and possible and not touching_legs([motion_of(drive) for drive in drives], 2 * BODY_RADIUS_M):
            return drives
    return _slow_down(plan, ways, wheels_m_s, most_slowing)


@dataclass(frozen=True, kw_only=True)
class _Way:
    """A leg before it is known how fast it is driven: times on the plan's own clock."""

    way: Stretch
    contact: Contact | None
    turn_rad: float
    begin_s: float
    next_s: float


@dataclass(frozen=True, kw_only=True)
class _Ways:
    """All ways of a robot up to where one begins as one began a round of the loop before."""

    ways: tuple[_Way, ...]
    loop_from: int | None


def require_bouncing(plan: Plan) -> None:
    """Raise PlanError for a plan whose robots do not bounce, are none, or cannot be Create 2 robots."""
    mission = plan.mission
    if mission.planning.bouncing is None:
        raise PlanError(
            f"mission {mission.name} is planned by {mission.planning.planner}: its robots must know where they are, and"
            " a Create 2 with a bump sensor and a clock does not; a plan of the planner bounce is needed"
        )
    if not plan.trajectories:
        raise PlanError(f"mission {mission.name}: the plan has no robots; there is nothing for a Create 2 to drive")
    for trajectory in plan.trajectories:
        robot = mission.fleet.robot(trajectory.robot)
        if robot.body_radius_m < BODY_RADIUS_M:
            raise PlanError(
                f"robot {robot.name}: body_radius_m: {robot.body_radius_m:.6g} is not allowed for a Create 2; must be"
                f" {BODY_RADIUS_M} or more, for that is its radius"
            )


def _contact_of(surroundings: Surroundings, number: int) -> Callable[[Stretch, float], Contact | None]:
    def contact(pause: Stretch, heading_rad: float) -> Contact | None:
        return surroundings.contact(number, pause, heading_rad)

    return contact


def turning_speed_m_s(plan: Plan, trajectory: Trajectory) -> float:
    """The speed in m/s of a wheel of this robot while it turns on the spot."""
    turn_rate = plan.mission.fleet.robot(trajectory.robot).turn_rate_rad_s
    return round(TURN_SPEED_M_S if turn_rate is None else min(turn_rate * WHEEL_BASE_M / 2, FASTEST_M_S), 3)


def _ways(
    trajectory: Trajectory, course: tuple[Stretch, ...], contact_of: Callable[[Stretch, float], Contact | None]
) -> _Ways:
    """The straight ways of a course with the turns behind them, and how many come before the loop."""
    ways: list[_Way] = []
    at = 1 if course[0].stays else 0  # it is put down facing its first way, and waits
    while at < len(course):
        way = course[at]
        pause = course[at + 1] if at + 1 < len(course) and course[at + 1].stays else None
        at += 1 if pause is None else 2
        following = course[at] if at < len(course) else None
        turn_rad = 0.0 if following is None else angle_turned(following.heading_rad - way.heading_rad)
        turns = pause is not None and abs(turn_rad) > SAME_RAD
        ways.append(
            _Way(
                way=way,
                contact=contact_of(pause, way.heading_rad) if turns and pause is not None else None,
                turn_rad=turn_rad,
                begin_s=way.begin_s,
                next_s=way.end_s if following is None else following.begin_s,
            )
        )
    loop_s = trajectory.loop_duration_s
    if loop_s == 0:
        return _Ways(ways=tuple(ways), loop_from=None)
    for k, earlier in enumerate(ways):
        again = [n for n, later in enumerate(ways) if abs(later.begin_s - earlier.begin_s - loop_s) <= 1e-6]
        if earlier.begin_s >= trajectory.loop_start_s - 1e-9 and again:
            return _Ways(ways=tuple(ways[: again[0]]), loop_from=k)
    raise PlanError(f"robot {trajectory.robot}: its loop never turns; a bouncing robot would leave the area")


def _drive(trajectory: Trajectory, ways: _Ways, legs: list[Leg], wheels_m_s: float, slowing: float) -> Drive:
    return Drive(
        legs=tuple(legs),
        first_s=legs[0].begin_s,
        loop_from=ways.loop_from,
        loop_s=trajectory.loop_duration_s * slowing,
        turn_speed_m_s=wheels_m_s,
        slowing=slowing,
    )


def _leg_as_planned(way: _Way, wheels_m_s: float, *, meetings: bool) -> Leg:
    """The leg at the plan's speed, in whole millimetres per second."""
    contact = way.contact if meetings or way.contact is None or not way.contact.of_robots else None
    return _leg(way, contact, _planned_mm_s(way), wheels_m_s, 1.0)


def _planned_mm_s(way: _Way) -> int:
    """The plan's speed, rounded; upwards where no turn follows, in whose time a robot that is late would catch up."""
    planned_mm_s = 1e3 * way.way.length_m / (way.way.end_s - way.way.begin_s)
    whole = round(planned_mm_s) if abs(way.turn_rad) > SAME_RAD else math.ceil(planned_mm_s - 1e-6)
    return max(whole, 1)


def _leg(way: _Way, contact: Contact | None, speed_mm_s: int, wheels_m_s: float, slowing: float) -> Leg:
    """A way as the robot drives it at this speed, with the time that is left over."""
    ahead_m = 0.0 if contact is None else contact.ahead_m
    speed_m_s = speed_mm_s / 1e3
    needed_s = (way.way.length_m + ahead_m) / speed_m_s + _beside_driving_s(way, contact, wheels_m_s)
    return Leg(
        start_m=(float(way.way.begin_m[0]), float(way.way.begin_m[1])),
        heading_rad=way.way.heading_rad,
        speed_m_s=speed_m_s,
        length_m=way.way.length_m,
        bumps=contact is not None,
        ahead_m=ahead_m,
        back_off_m=max(ahead_m, LEAST_BACK_OFF_M),
        turn_rad=way.turn_rad,
        begin_s=way.begin_s * slowing,
        next_s=way.next_s * slowing,
        spare_s=(way.next_s - way.begin_s) * slowing - needed_s,
        meets=contact is not None and contact.of_robots,
    )


def _beside_driving_s(way: _Way, contact: Contact | None, wheels_m_s: float) -> float:
    """What a leg takes besides driving: to back off, to turn, and to answer what happens."""
    back_off_s = 0.0 if contact is None else max(contact.ahead_m, LEAST_BACK_OFF_M) / BACK_OFF_SPEED_M_S
    turns = abs(way.turn_rad) > SAME_RAD
    return back_off_s + (abs(way.turn_rad) * WHEEL_BASE_M / 2 / wheels_m_s + REACTION_S if turns else 0.0)


# ---------------------------------------------------------------- slower clocks, faster legs


def _slow_down(plan: Plan, ways: tuple[_Ways, ...], wheels_m_s: list[float], most_slowing: float) -> tuple[Drive, ...]:
    """Drives on a slower clock, in which no robot meets another on purpose."""
    fastest_mm_s = [
        max(math.floor(1e3 * min(plan.mission.fleet.robot(t.robot).speed_m_s, FASTEST_M_S) + 1e-6), 20)
        for t in plan.trajectories
    ]
    by_clock = {
        (number, k)
        for number, own in enumerate(ways)
        for k, way in enumerate(own.ways)
        if way.contact is None or way.contact.of_robots
    }
    for _ in range(ROUNDS):
        slowing = _slowing_needed(plan, ways, by_clock, fastest_mm_s, wheels_m_s, most_slowing)
        drives = tuple(
            _drive(
                trajectory, own,
                [
                    _leg_in_time(way, None if (number, k) in by_clock else way.contact, fastest_mm_s[number],
                                 wheels_m_s[number], slowing)
                    for k, way in enumerate(own.ways)
                ],
                wheels_m_s[number], slowing,
            )
            for number, (trajectory, own) in enumerate(zip(plan.trajectories, ways, strict=True))
        )  # fmt: skip
        touching = touching_legs([motion_of(drive) for drive in drives], 2 * BODY_RADIUS_M)
        if not touching:
            return drives
        if touching <= by_clock:
            number, k = min(touching)
            leg = drives[number].legs[k]
            raise PlanError(
                f"robot {plan.trajectories[number].robot}: on its way until {leg.next_s / slowing:.6g} s of the plan"
                " its body would touch another robot's, as a Create 2 drives it; a plan with wider bodies, or with"
                " bounce.clock_drift, keeps them farther apart"
            )
        by_clock |= touching
    raise PlanError(f"mission {plan.mission.name}: no way was found to keep Create 2 robots apart as they drive")


def _slowing_needed(
    plan: Plan,
    ways: tuple[_Ways, ...],
    by_clock: set[tuple[int, int]],
    fastest_mm_s: list[int],
    wheels_m_s: list[float],
    most_slowing: float,
) -> float:
    """The smallest factor of the clock, 1 at least, with which every leg has time; PlanError above ``most_slowing``."""
    worst, tightest = 1.0, (0, 0)
    for number, own in enumerate(ways):
        for k, way in enumerate(own.ways):
            contact = None if (number, k) in by_clock else way.contact
            way_m = way.way.length_m + (0.0 if contact is None else contact.ahead_m)
            needed_s = way_m / (fastest_mm_s[number] / 1e3) + _beside_driving_s(way, contact, wheels_m_s[number])
            factor = needed_s / (way.next_s - way.begin_s)
            if factor > worst:
                worst, tightest = factor, (number, k)
    if worst > most_slowing * (1 + 1e-9):
        number, k = tightest
        way = ways[number].ways[k]
        bump = "" if (number, k) in by_clock or way.contact is None else "bump, back off and "
        raise PlanError(
            f"robot {plan.trajectories[number].robot}: the plan leaves too little time to {bump}turn by"
            f" {math.degrees(way.turn_rad):.0f} degrees until {way.next_s:.6g} s; a Create 2 needs {worst:.3g} times as"
            f" long for the whole plan, and at most {most_slowing:.3g} times is allowed: periods must be longer by"
            f" {worst / most_slowing:.3g} times, or cells larger"
        )
    return worst


def _leg_in_time(way: _Way, contact: Contact | None, fastest_mm_s: int, wheels_m_s: float, slowing: float) -> Leg:
    """The leg as slowly as its time allows, and no slower than the slowed plan drives it."""
    way_m = way.way.length_m + (0.0 if contact is None else contact.ahead_m)
    driving_s = (way.next_s - way.begin_s) * slowing - _beside_driving_s(way, contact, wheels_m_s)
    planned_m_s = way.way.length_m / (way.way.end_s - way.way.begin_s) / slowing
    least_m_s = max(planned_m_s, way_m / driving_s, SLOWEST_M_S)
    speed_mm_s = min(math.ceil(1e3 * least_m_s - 1e-6), fastest_mm_s)
    return _leg(way, contact, speed_mm_s, wheels_m_s, slowing)


def motion_of(drive: Drive) -> Driven:
    """How the robot's centre moves as it drives, contacts included."""
    times_s, places_m, legs = [0.0], [drive.legs[0].start_m], [0]
    for k, leg in enumerate(drive.legs):
        dx, dy = math.cos(leg.heading_rad), math.sin(leg.heading_rad)
        x, y = leg.start_m
        stops = [
            (leg.begin_s, 0.0),
            (leg.begin_s + (leg.length_m + leg.ahead_m) / leg.speed_m_s, leg.length_m + leg.ahead_m),
        ]
        if leg.ahead_m > 0:
            stops.append((stops[-1][0] + leg.ahead_m / BACK_OFF_SPEED_M_S, leg.length_m))
        stops.append((max(leg.next_s, stops[-1][0] + 1e-9), leg.length_m))
        for time_s, along_m in stops:
            if time_s > times_s[-1]:
                times_s.append(time_s)
                places_m.append((x + along_m * dx, y + along_m * dy))
                legs.append(k)
    loop_s = 0.0 if drive.loop_from is None else drive.loop_s
    return Driven(times_s=times_s, places_m=places_m, legs=legs, loop_s=loop_s)
