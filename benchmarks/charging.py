"""Robots that charge: Sun 2019's cases, tiny missions beside brute force, random yards and docks, a large check.

Brute force. Places lie on a line, a second apart; one is the charger. In each second a robot goes to the next place,
hovers, or charges. A state is where all robots are, how full they are, and how long ago each place was visited. States
without a next one are struck out again and again: robots do for ever if a state with full batteries is left.
"""

from __future__ import annotations

import itertools
import random
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from shapely import MultiPolygon, box

from benchmarks.row import Options, Row
from benchmarks.sun_cases import CASES, write_case
from rota import DiscSensor, Fleet, Mission, NoPlanFound, PatrolSettings, Zone, make_plan
from rota.check import check_plan
from rota.files.mission_file import read_mission
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger
from rota.model.motion_limits import MotionLimits
from rota.model.plan import Plan

Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

MOST_RATIO = 1.35  # of robots to the proved bound, over all cases
TINY, YARDS, DOCKS = 100, 40, 60
MOST_BY_FORCE = 2
RELIEFS, TEAM = 40, 20
EXAMPLES = Path(__file__).parents[1] / "examples"
MOTIONS = (
    ("port-relief", "2.5 m/s2, corners cut by 1.5 m", "  acceleration_m_s2: 2.5\n  corner_m: 1.5\n"),
    ("port-relief", "turns of 15 m and no standing", "  turn_radius_m: 15\n  standing_endurance_s: 0\n"),
    ("port-relief", "26 s of landing and 13 s of climbing", "  landing_s: 26\n  climbing_s: 13\n"),
    ("warehouse-relief", "0.8 m/s2, turns at 1.5 rad/s", "  acceleration_m_s2: 0.8\n  turn_rate_rad_s: 1.5\n"),
)


def charging(options: Options) -> Iterator[Row]:
    """Sun's cases, the check of the largest of their plans, robots in motion, and the tiny missions."""
    plans = [plan_of_case(options, k) for k in range(len(CASES))]
    robots, bound = sum(map(len, plans)), sum(plan.lower_bound_robots or 0 for plan in plans)
    each = ", ".join(f"{len(plan)} ({plan.lower_bound_robots})" for plan in plans)
    what = "Sun 2019, the seven cases, endurance 10 and recharge 20 times the longest period, one pad in the middle"
    measured = f"{robots} robots (bound {bound}), {robots / bound:.2f} times: {each}"
    yield Row(
        f"{what}, {options.effort}", f"at most {MOST_RATIO} times the bound", measured, robots <= MOST_RATIO * bound
    )
    yield checked_row(min((plan for plan in plans if len(plan) >= TEAM), key=len, default=max(plans, key=len)))
    yield from (motion_row(options, *each) for each in MOTIONS)
    yield random_row("yards, robots with a limited jerk", [yard(seed) for seed in range(YARDS)])
    yield random_row("missions with docks of one place", [docks(seed) for seed in range(DOCKS)])
    yield tiny_row()


def motion_row(options: Options, name: str, told: str, lines: str) -> Row:
    """An example whose robots charge, planned at effort quick with these lines of the fleet, beside that without."""
    text = (EXAMPLES / f"{name}.yaml").read_text()
    path, found = options.folder / f"{name}-in-motion.yaml", list[tuple[Plan, float]]()
    for fleet in ("fleet:\n", f"fleet:\n{lines}"):
        path.write_text(text.replace("fleet:\n", fleet))
        mission, began_s = read_mission(path).mission.with_effort("quick"), time.process_time()
        found.append((make_plan(mission), time.process_time() - began_s))
    (without, _), (plan, cpu_s) = found
    verdict = check_plan(plan).verdict
    measured = (
        f"{verdict}, {len(plan)} robots (bound {plan.lower_bound_robots}), {len(without)} without; CPU {cpu_s:.0f} s"
    )
    return Row(f"{name}, {told}", "met", measured, verdict == "met")


def random_row(name: str, missions: Sequence[Mission]) -> Row:
    """How many random missions have a plan; for some there is none: batteries are too small, or places too few."""
    robots, began_s = list[int](), time.process_time()
    for mission in missions:
        with suppress(NoPlanFound):
            plan = make_plan(mission)
            if check_plan(plan).verdict == "met":
                robots.append(len(plan))
    cpu_s = time.process_time() - began_s
    measured = f"{len(robots)} of {len(missions)} met, {sum(robots)} robots; CPU {cpu_s:.0f} s"
    return Row(f"{len(missions)} random {name}", "", measured, None)


def yard(seed: int) -> Mission:
    """A yard at random with a charger of nine places, for robots that cut corners and take time to change speed."""
    chance = random.Random(seed)
    wide_m, high_m = chance.choice([15, 25, 40, 60]), chance.choice([8, 12, 20])
    speed_m_s = chance.choice([0.3, 0.5, 1, 2])
    acceleration_m_s2 = speed_m_s * chance.choice([0.3, 0.6, 1, 2])
    corner_m = chance.choice([0.2, 0.3, 0.5, 1])
    jerk_m_s3 = acceleration_m_s2 * chance.choice([0.5, 1, 2, 4])
    reach_m = chance.choice([2, 3])
    period_s = wide_m * high_m / (2 * reach_m) / speed_m_s * chance.choice([0.6, 0.9, 1.3, 2])
    endurance_s = period_s * chance.choice([1.5, 2.5, 4])
    recharge_s = endurance_s * chance.choice([0.5, 1, 1.5])
    fleet = Fleet(
        speed_m_s=speed_m_s, sensor=DiscSensor(radius_m=reach_m), body_radius_m=chance.choice([0, 0, 0.2]),
        motion=MotionLimits(acceleration_m_s2=acceleration_m_s2, corner_m=corner_m, jerk_m_s3=jerk_m_s3),
        battery=BatteryLimits(endurance_s=round(endurance_s), recharge_s=round(recharge_s)),
    )  # fmt: skip
    return Mission(
        name="yard", area=MultiPolygon([box(0, 0, wide_m, high_m)]), period_s=round(period_s), fleet=fleet,
        chargers=(Charger(name="pad", at=(wide_m / 2, 2), places=9),), planning=PatrolSettings(effort="quick"),
    )  # fmt: skip


def docks(seed: int) -> Mission:
    """Ground at random for drones, a zone in it or none, and two to six docks anywhere."""
    chance = random.Random(seed)
    speed_m_s, reach_m = chance.choice([5, 10, 15]), chance.choice([20, 40, 60])
    wide_m, high_m = chance.choice([200, 400, 800]), chance.choice([150, 300, 600])
    period_s = round(wide_m * high_m / (2 * reach_m * speed_m_s) * chance.choice([0.6, 1.0, 1.5, 2.5]) + 20)
    zones = list[Zone]()
    if chance.random() < 0.4:
        x, y = chance.uniform(0.1, 0.6) * wide_m, chance.uniform(0.1, 0.5) * high_m
        shape = MultiPolygon([box(x, y, x + 0.2 * wide_m, y + 0.2 * high_m)])
        own_s = round(period_s * chance.choice([0.4, 0.7]))
        zones.append(Zone(name="gate", period_s=own_s, shape=shape, demand=chance.choice(["visit", "every_point"])))
    endurance_s, count = chance.choice([900, 1500, 2400]), chance.choice([2, 3, 4, 6])
    recharge_s = endurance_s * chance.choice([0.5, 1, 1.5])
    fleet = Fleet(
        speed_m_s=speed_m_s, sensor=DiscSensor(radius_m=reach_m), body_radius_m=chance.choice([0, 0, 0, 0.5]),
        battery=BatteryLimits(endurance_s=endurance_s, recharge_s=recharge_s),
    )  # fmt: skip
    places = [(chance.uniform(0.05, 0.95) * wide_m, chance.uniform(0.05, 0.95) * high_m) for _ in range(count)]
    return Mission(
        name="docks", area=MultiPolygon([box(0, 0, wide_m, high_m)]), period_s=period_s, zones=tuple(zones),
        fleet=fleet, chargers=tuple(Charger(name=f"dock {k}", at=at, places=1) for k, at in enumerate(places)),
        planning=PatrolSettings(effort="quick"),
    )  # fmt: skip


def plan_of_case(options: Options, number: int) -> Plan:
    """The plan of a case whose robots charge on a pad in the middle of the map."""
    mission = read_mission(write_case(CASES[number], options.folder)).mission.with_effort(options.effort)
    longest_s = max(CASES[number].periods_s)
    fleet = replace(mission.fleet, battery=BatteryLimits(endurance_s=10 * longest_s, recharge_s=20 * longest_s))
    x0, y0, x1, y1 = mission.area.bounds
    pad = Charger(name="pad", at=((x0 + x1) / 2, (y0 + y1) / 2), places=99)
    return make_plan(replace(mission, fleet=fleet, chargers=(pad,)))


def checked_row(plan: Plan) -> Row:
    """How long the check of a whole round of flights and charges takes."""
    reliefs = sum(len(trajectory.charges) for trajectory in plan)
    check_plan(plan)
    took_s = []
    for _ in range(3):
        begin = time.perf_counter()
        verdict = check_plan(plan).verdict
        took_s.append(time.perf_counter() - begin)
    legs = sum(len(trajectory.times_s) - 1 for trajectory in plan)
    measured = f"{sorted(took_s)[1]:.1f} s; {len(plan)} robots, {reliefs} reliefs, {legs:,} legs, {verdict}"
    reached = sorted(took_s)[1] < 10 and verdict == "met" and len(plan) >= TEAM and reliefs >= RELIEFS
    return Row(
        "check of a round of flights and charges", f"< 10 s for {TEAM} robots, {RELIEFS} reliefs", measured, reached
    )


class Tiny(NamedTuple):
    """A line of places a second apart: which is the charger, periods of those to visit, and the battery in seconds."""

    places: int
    charger: int
    periods_s: dict[int, int]
    endurance_s: int
    recharge: float


def tiny_row() -> Row:
    """Robots of tiny missions beside the fewest by brute force, which is for steps of a second."""
    more, beyond = list[int](), list[int]()
    unplanned = below_bound = 0
    for seed in range(TINY):
        tiny = tiny_line(seed)
        fewest = fewest_by_force(tiny)
        plan = make_plan(mission_of(tiny))
        unplanned += check_plan(plan).verdict != "met"
        below_bound += fewest <= MOST_BY_FORCE and (plan.lower_bound_robots or 0) > fewest
        if fewest > MOST_BY_FORCE:
            beyond.append(len(plan))
        else:
            more.append(len(plan) - fewest)
    counts = ", ".join(f"{more.count(k)} by {k:+d}" for k in sorted(set(more)))
    planned = ", ".join(f"{beyond.count(k)} with {k}" for k in sorted(set(beyond)))
    measured = f"{TINY - unplanned} met; robots differ from brute force: {counts}; bound above it: {below_bound}"
    measured += f"; planned where it takes more than {MOST_BY_FORCE}: {planned}"
    return Row(f"{TINY} tiny missions with a charger", "as many robots as by brute force", measured, max(more) <= 0)


def tiny_line(seed: int) -> Tiny:
    """A line at random on which one robot can reach each place and come back."""
    chance = np.random.default_rng(seed)
    places = int(chance.integers(2, 5))
    charger = int(chance.integers(places))
    asked = chance.choice(places, int(chance.integers(1, min(places, 2) + 1)), replace=False)
    far = max(abs(int(k) - charger) for k in asked)
    return Tiny(
        places=places,
        charger=charger,
        periods_s={int(k): int(chance.integers(2, 11)) for k in asked},
        endurance_s=2 * far + int(chance.integers(2, 7)),
        recharge=float(chance.choice([0.5, 1.0, 2.0])),
    )


def mission_of(tiny: Tiny) -> Mission:
    """The line as a mission: places are small zones to visit."""
    zones = tuple(
        Zone(
            name=f"place {k}",
            shape=MultiPolygon([box(k - 1e-3, -1e-3, k + 1e-3, 1e-3)]),
            period_s=period_s,
            demand="visit",
        )
        for k, period_s in tiny.periods_s.items()
    )
    battery = BatteryLimits(endurance_s=tiny.endurance_s, recharge_s=tiny.recharge * tiny.endurance_s)
    return Mission(
        name="tiny",
        area=MultiPolygon([box(-1, -1, tiny.places, 1)]),
        zones=zones,
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=0.1), battery=battery),
        chargers=(Charger(name="pad", at=(tiny.charger, 0), places=9),),
        planning=PatrolSettings(effort="quick"),
    )


def fewest_by_force(tiny: Tiny) -> int:
    """The fewest robots in steps of a second; MOST_BY_FORCE + 1 for any more than that."""
    return next((n for n in range(1, MOST_BY_FORCE + 1) if goes_on_for_ever(tiny, n)), MOST_BY_FORCE + 1)


def goes_on_for_ever(tiny: Tiny, robots: int) -> bool:
    """Whether so many robots, with full batteries at first, keep all periods for ever."""
    follows, visited = steps_of(tiny)
    each, moves = follows.shape
    joint = np.indices((each,) * robots).reshape(robots, -1)
    periods = list(tiny.periods_s.values())
    clocks = np.indices(periods).reshape(len(periods), -1)  # seconds since a visit, below the period
    alive = np.ones((joint.shape[1], clocks.shape[1]), np.bool_)
    while True:
        goes = np.zeros_like(alive)
        for chosen in itertools.product(range(moves), repeat=robots):
            nexts = [follows[joint[k], move] for k, move in enumerate(chosen)]
            possible = np.all([state >= 0 for state in nexts], axis=0)
            place = np.ravel_multi_index([np.maximum(state, 0) for state in nexts], (each,) * robots)
            seen = np.bitwise_or.reduce([visited[joint[k], move] for k, move in enumerate(chosen)])
            for mask in np.unique(seen[possible]):
                own = np.flatnonzero(possible & (seen == mask))
                later = [np.where(mask >> z & 1, 0, clocks[z] + 1) for z in range(len(periods))]
                kept = np.all([clock < period for clock, period in zip(later, periods, strict=True)], axis=0)
                there = np.ravel_multi_index(later, periods, mode="clip")
                goes[own] |= alive[place[own]][:, there] & kept
        goes &= alive
        if (goes == alive).all():
            break
        alive = goes
    full = np.all(joint % (2 * tiny.endurance_s + 1) == 2 * tiny.endurance_s, axis=0)
    return bool(alive[full].any())


def steps_of(tiny: Tiny) -> tuple[Ints, Ints]:
    """What one robot's state (place, half seconds of battery left) becomes by each move, -1: impossible; and visits."""
    levels = 2 * tiny.endurance_s + 1
    bits = {place: 1 << number for number, place in enumerate(tiny.periods_s)}
    follows, visited = np.full((tiny.places * levels, 4), -1), np.zeros((tiny.places * levels, 4), np.int64)
    for place, level in itertools.product(range(tiny.places), range(levels)):
        for move, to in enumerate((place - 1, place, place + 1)):
            if 0 <= to < tiny.places and level >= 2:
                follows[place * levels + level, move] = to * levels + level - 2
                visited[place * levels + level, move] = bits.get(to, 0)
        if place == tiny.charger:
            follows[place * levels + level, 3] = place * levels + min(levels - 1, level + round(2 / tiny.recharge))
    return follows, visited
