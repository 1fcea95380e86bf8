"""Trajectories of bouncing robots -> what an iRobot Create 2 does leg by leg: drive, bump, back off, turn, wait.

On the grid a blocked robot stays at its cell's centre and turns there. A real one drives on until it bumps, so each
leg knows how far back from the contact that centre is.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from rota.errors import PlanError
from rota.files.create2_course import SAME_RAD, Contact, Stretch, Surroundings, stretches_of, turned
from rota.mission import Place
from rota.plan import Plan, Trajectory

BODY_RADIUS_M = 0.17  # iRobot Create 2: 34 cm across
WHEEL_BASE_M = 0.235
FASTEST_M_S, SLOWEST_M_S = 0.5, 0.02
BACK_OFF_SPEED_M_S = 0.2
TURN_SPEED_M_S = 0.2  # of the wheels, where the mission gives no turn_rate_rad_s
LEAST_BACK_OFF_M = 0.01  # nearer to the wall the bumper would rub along it while the robot turns
REACTION_S = 0.05  # from the contact to the command that answers it, and to stop and go again


@dataclass(frozen=True, kw_only=True)
class Leg:
    """Straight on from a place, then a turn. ``bumps``: a contact ends it, otherwise the clock does, after drive_s.

    length_m: to where the robot turns; back_off_m: from the contact to there; turn_rad: to the left, -pi..pi;
    next_s: when the next leg begins, on the plan's clock; spare_s: the time left before that, below 0 where it is
    short. ``meets``: the contact is with another robot.
    """

    start_m: Place
    heading_rad: float
    speed_m_s: float
    length_m: float
    bumps: bool
    back_off_m: float
    turn_rad: float
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

    Every round takes ``loop_s``. ``loop_from`` None: the robot stops for good.
    """

    legs: tuple[Leg, ...]
    first_s: float
    loop_from: int | None
    loop_s: float
    turn_speed_m_s: float


def drives_of(plan: Plan) -> tuple[Drive, ...]:
    """What every robot of the plan does, in the plan's order.

    Robots that meet bump into each other if every meeting's time allows that, otherwise all turn by the clock before
    they touch. Raises PlanError for a plan that is not one for bouncing robots, or whose robots cannot be iRobot
    Create 2: smaller than one, faster, or with too little time to back off from a wall and turn.
    """
    _require_bouncing(plan)
    courses = tuple(stretches_of(trajectory) for trajectory in plan.trajectories)
    surroundings = Surroundings(plan, courses, BODY_RADIUS_M)
    drives = _drives(plan, courses, surroundings, meetings=True)
    if any(leg.meets and leg.spare_s < 0 for drive in drives for leg in drive.legs):
        drives = _drives(plan, courses, surroundings, meetings=False)
    for trajectory, drive in zip(plan.trajectories, drives, strict=True):
        for leg in drive.legs:
            _require_time(trajectory.robot, leg)
    return drives


def _require_bouncing(plan: Plan) -> None:
    mission = plan.mission
    if mission.planning.planner != "bounce":
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


def _drives(
    plan: Plan, courses: tuple[tuple[Stretch, ...], ...], surroundings: Surroundings, *, meetings: bool
) -> tuple[Drive, ...]:
    drives = []
    for number, (trajectory, course) in enumerate(zip(plan.trajectories, courses, strict=True)):
        turn_rate = plan.mission.fleet.robot(trajectory.robot).turn_rate_rad_s
        wheels_m_s = TURN_SPEED_M_S if turn_rate is None else min(turn_rate * WHEEL_BASE_M / 2, FASTEST_M_S)

        def contact(pause: Stretch, heading_rad: float, number: int = number) -> Contact | None:
            found = surroundings.contact(number, pause, heading_rad)
            return None if found is None or (found.of_robots and not meetings) else found

        drives.append(_drive(trajectory, course, contact, round(wheels_m_s, 3)))
    return tuple(drives)


def _drive(
    trajectory: Trajectory,
    course: tuple[Stretch, ...],
    contact_of: Callable[[Stretch, float], Contact | None],
    wheels_m_s: float,
) -> Drive:
    """The legs up to where one begins as one began a round of the loop before."""
    legs: list[Leg] = []
    begins_s: list[float] = []
    at = 1 if course[0].stays else 0  # it is put down facing its first way, and waits
    while at < len(course):
        way = course[at]
        pause = course[at + 1] if at + 1 < len(course) and course[at + 1].stays else None
        at += 1 if pause is None else 2
        following = course[at] if at < len(course) else None
        turn_rad = 0.0 if following is None else turned(following.heading_rad - way.heading_rad)
        turns = pause is not None and abs(turn_rad) > SAME_RAD
        contact = contact_of(pause, way.heading_rad) if turns and pause is not None else None
        begins_s.append(way.begin_s)
        legs.append(_leg(way, contact, turn_rad, way.end_s if following is None else following.begin_s, wheels_m_s))
    loop_s, first_s = trajectory.loop_duration_s, begins_s[0]
    if loop_s == 0:
        return Drive(legs=tuple(legs), first_s=first_s, loop_from=None, loop_s=0.0, turn_speed_m_s=wheels_m_s)
    for k, begin_s in enumerate(begins_s):
        again = [n for n, later_s in enumerate(begins_s) if abs(later_s - begin_s - loop_s) <= 1e-6]
        if begin_s >= trajectory.loop_start_s - 1e-9 and again:
            return Drive(
                legs=tuple(legs[: again[0]]), first_s=first_s, loop_from=k, loop_s=loop_s, turn_speed_m_s=wheels_m_s
            )
    raise PlanError(f"robot {trajectory.robot}: its loop never turns; a bouncing robot would leave the area")


def _leg(way: Stretch, contact: Contact | None, turn_rad: float, next_s: float, wheels_m_s: float) -> Leg:
    speed_m_s = max(round(way.length_m / (way.end_s - way.begin_s), 3), 0.001)  # in whole millimetres per second
    ahead_m = 0.0 if contact is None else contact.ahead_m
    back_off_m = max(ahead_m, LEAST_BACK_OFF_M)
    needed_s = way.length_m / speed_m_s
    if abs(turn_rad) > SAME_RAD:
        needed_s += abs(turn_rad) * WHEEL_BASE_M / 2 / wheels_m_s + REACTION_S
    if contact is not None:
        needed_s += ahead_m / speed_m_s + back_off_m / BACK_OFF_SPEED_M_S
    return Leg(
        start_m=(float(way.begin_m[0]), float(way.begin_m[1])),
        heading_rad=way.heading_rad,
        speed_m_s=speed_m_s,
        length_m=way.length_m,
        bumps=contact is not None,
        back_off_m=back_off_m,
        turn_rad=turn_rad,
        next_s=next_s,
        spare_s=next_s - way.begin_s - needed_s,
        meets=contact is not None and contact.of_robots,
    )


def _require_time(robot: str, leg: Leg) -> None:
    """Raise PlanError for a leg that a Create 2 cannot drive in its time, or at such a speed."""
    if not SLOWEST_M_S <= leg.speed_m_s <= FASTEST_M_S:
        raise PlanError(
            f"robot {robot}: before {leg.next_s:.6g} s it drives {leg.speed_m_s:.3f} m/s; a Create 2 can do"
            f" {SLOWEST_M_S} to {FASTEST_M_S} m/s; fleet.speed_m_s must be changed"
        )
    if abs(leg.turn_rad) > SAME_RAD and leg.spare_s < -1e-9:
        bump = f"bump, back off {1e3 * leg.back_off_m:.0f} mm and " if leg.bumps else ""
        raise PlanError(
            f"robot {robot}: the plan leaves too little time to {bump}turn by {math.degrees(leg.turn_rad):.0f} degrees"
            f" until {leg.next_s:.6g} s; a Create 2 needs {-leg.spare_s:.2g} s more; a lower fleet.speed_m_s, larger"
            " cells or another fleet.turn_rate_rad_s is needed"
        )
