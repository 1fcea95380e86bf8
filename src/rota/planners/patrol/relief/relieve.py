"""Loops that were planned as if batteries lasted for ever, and robots that charge and take turns at them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

from rota.errors import NoPlanFound
from rota.model.arrays import Floats
from rota.model.battery_limits import ENDLESS
from rota.model.mission import Mission, Robot
from rota.model.plan import Plan
from rota.planners.patrol.bounds.charging_bound import charging_of
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.relief.posts import with_fewer_posts
from rota.planners.patrol.relief.shifts import Clearance, time_to_stop_s
from rota.planners.patrol.relief.slots import (
    Slot,
    slots_of,
    slower_slots,
    without_waits,
)
from rota.planners.patrol.relief.team import Team
from rota.planners.patrol.relief.ways import Ways
from rota.planners.patrol.traffic.starts.paths_by_body import PathsByBody
from rota.planners.patrol.verdict import Judge, crowding, worst_reached
from rota.planning.planner import Request

MOST_SHARED = 4  # chargers to which ways are planned for robots that land wherever a place is free
MOST_TRIES = 12  # of robots with bodies, which may touch on their ways: with turns at the same loops, and on circuits


def endless(mission: Mission) -> Mission:
    """The mission as if batteries lasted for ever, with as few robots as possible.

    Periods are shorter by what it takes to pass on a loop from body to body.
    """
    clearance_s = clearance_of(mission) / (1 - PatrolSettings.of(mission).period_margin)  # the reserve takes its share

    def shorter_s(period_s: float | None) -> float | None:
        return None if period_s is None else max(period_s - clearance_s, period_s / 2)

    zones = tuple(replace(zone, period_s=shorter_s(zone.period_s)) for zone in mission.zones)
    return replace(without_batteries(mission), period_s=shorter_s(mission.period_s), zones=zones)


def without_batteries(mission: Mission) -> Mission:
    """The mission as it is asked, but for batteries and the number of robots: what bounds are proved for."""
    return replace(mission, fleet=replace(mission.fleet, robots=None, battery=ENDLESS), chargers=())


def clearance_of(mission: Mission) -> float:
    """By how many seconds robots pass one place after each other when one relieves the other; 0 without bodies."""
    robot = mission.fleet.equal_robot("robot-1")
    return 3.0 * robot.body_radius_m / robot.ground_speed_m_s  # radii: at right angles their centres keep 2.1 apart


def require_reach(mission: Mission) -> None:
    """NoPlanFound where no flight lasts from a charger to ground that is asked for and back."""
    if (charging := charging_of(mission)).ways >= 1:
        battery = mission.fleet.battery
        taken = f" and {battery.departure_s:.6g} to take off" if battery.departure_s else ""
        raise NoPlanFound(
            f"fleet.endurance_s: {battery.endurance_s:.6g} less a reserve of {battery.reserve_s:.6g}{taken} is too"
            " short: from a charger to ground that is asked for and back takes at least"
            f" {charging.ways * battery.usable_s:.6g} s; give more, or a charger nearer by"
        )


def relieve(
    loops: Plan, mission: Mission, request: Request, *, briefly: bool = False, steadily: bool = False,
    turns_s: Floats | None = None,
) -> Plan:  # fmt: skip
    """A plan for the mission whose robots take turns at the loops of a plan for ``endless(mission)``.

    request: its seed, its judge, and what stops it: no other plan is tried then, once there is one. briefly: the first
    try alone. steadily: robots change where loops are driven at a constant velocity. turns_s: how long turns at loops
    may be; None: anything. Raises NoPlanFound where a loop is too far from all chargers for the battery, where chargers
    have too little room, and where the judge passes no plan.
    """
    judge, seed = request.judge, request.seed
    verdict = judge(loops)
    ratio = max((demand.worst_gap_s / demand.period_s for demand in verdict.demands), default=1.0)
    slots = slots_of(loops, ratio)
    robot = mission.fleet.equal_robot("robot-1")
    ways, found, full = Ways(robot, PathsByBody(mission), steadily=steadily), None, None
    shared: Plan | None = None

    has_bodies = clearance_of(mission) > 0
    numbers, modes = range(MOST_TRIES // 2 if has_bodies else 1), (False, True) if has_bodies else (False,)
    tries, crowded = list(itertools.product(_paces(slots, loops, robot, judge), numbers, modes)), False
    barren: Sequence[Slot] = ()
    for heeds_places, (tried, number, gives_way) in itertools.product((False, True), tries[: 1 if briefly else None]):
        # where some share chargers, other ways take as many robots
        if (heeds_places and (not crowded or tried is barren)) or (shared is not None and (number or gives_way)):
            continue
        if found is not None and request.should_stop():
            break
        own_plan = partial(
            _plan_of, loops, mission, ways, turns_s, seed + number, number=number, heeds_places=heeds_places,
            gives_way=gives_way,
        )  # fmt: skip
        try:
            found = own_plan(tried)
        except NoPlanFound as failure:
            if isinstance(failure.best, Plan):
                found, crowded = failure.best, True
            elif heeds_places:
                barren = tried
            elif not gives_way and shared is None:
                raise
            continue
        verdict = judge(found)
        if len(mission.chargers) > 1 and crowding(verdict) is not None:
            shared = min(_plans_that_share(own_plan, tried, judge, shared), key=len, default=None)
        if verdict.verdict == "met":
            if shared is not None and len(shared) <= len(found):
                return shared
            if mission.fleet.robots is not None:
                return found
            return with_fewer_posts(found, tried, own_plan, judge)
        crowded |= (lacks_places := crowding(verdict)) is not None
        if full is None and worst_reached(verdict) == lacks_places:
            full = found  # what would help is places, whatever else later plans come to
    if shared is not None:
        return shared
    best = full or found
    assert best is not None
    raise NoPlanFound(f"with relief the plan does not pass the check: {worst_reached(judge(best))}", best=best)


def _plan_of(
    loops: Plan, mission: Mission, ways: Ways, turns_s: Floats | None, seed: int, served: Sequence[Slot],
    below: float = math.inf, *, number: int, heeds_places: bool, gives_way: bool, sharing: int = 0,
) -> Plan:  # fmt: skip
    """The plan whose robots take turns at these slots, if less than ``below`` can; number: of the try.

    sharing: they land on any charger with a free place, and have time for ways to so many, the nearest ones.
    """
    robot, lands = mission.fleet.equal_robot("robot-1"), gives_way and number % 2 == 1  # or has time to stop, by turns
    stops_s = time_to_stop_s(robot) if gives_way and not lands else 0.0
    clearance = Clearance(clearance_of(mission) + stops_s, gives_way, lands)
    team = Team(mission, served, ways, turns_s, clearance, sharing)
    rotations = team.rotations(seed, varied=number > 0, below=below, heeds_places=heeds_places)
    robots, is_clear = (team.on_free_places(rotations), True) if sharing else team.trajectories(rotations, seed)
    plan = replace(loops, mission=mission, trajectories=tuple(robots))
    if not is_clear:
        raise NoPlanFound("bodies touch where robots relieve each other", best=plan)
    return plan


def _plans_that_share(
    plan_of: Callable[..., Plan], slots: Sequence[Slot], judge: Judge, known: Plan | None
) -> Iterator[Plan]:
    """Plans that pass the judge and whose robots land on any charger with a free place, and the one that is known."""
    if known is not None:
        yield known
    for sharing in range(1, MOST_SHARED + 1):
        with suppress(NoPlanFound):
            plan = plan_of(slots, sharing=sharing)
            if judge(plan).verdict == "met":
                yield plan


def _paces(slots: Sequence[Slot], loops: Plan, robot: Robot, judge: Judge) -> list[Sequence[Slot]]:
    """The slots of loops without waits and as slowly as may be, so slowly, as they are, and as fast as can be."""
    slower = slower_slots(loops, slots, judge)
    hasty = without_waits(slower, robot.ground_speed_m_s) if robot.turns_at_once else slower
    tight = [replace(slot, most_s=slot.most_s if slot.line.stays else slot.least_s) for slot in slots]
    return list({tuple(map(id, each)): each for each in (hasty, slower, slots, tight)}.values())  # some are the same
