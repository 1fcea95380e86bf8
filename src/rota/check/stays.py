"""Stays at chargers: how long robots are there, whether that is enough to land and to climb, and how many there are.

Who comes to a charger in flight lands first, and who leaves it climbs before: neither charges. A stay may go on across
the seam of a loop, and from what was driven before a plan took over into the plan. Who is at a charger where all begins
has landed, and may have begun to climb.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from rota.check.arrays import Floats
from rota.check.report import Violation, violation
from rota.check.routes import commensurable_classes
from rota.check.tolerances import SAME_TIME
from rota.model.plan import Charge, Driven, Plan, Trajectory

MOST_STAYS = 2_000_000  # at one charger, counted one by one; of more, robots are taken to come all at once


def stays_on_s(way: Trajectory | Driven, charge: Charge, climbing_s: float) -> float:
    """How long the robot stays at the charger after a charge of a way has ended; inf: for ever, or nobody knows.

    climbing_s: how long it climbs in all; of what was driven it is told for how long it has climbed in the end.
    """
    after_s, number, charges = 0.0, way.charges.index(charge), way.charges
    for _ in range(len(charges) + 1):
        ends_s, later = charges[number].until_s, charges[number + 1 : number + 2]
        following = number + 1 if later and later[0].from_s == ends_s else None
        if ends_s == way.times_s[-1]:
            if isinstance(way, Driven):
                return after_s + climbing_s - way.climbed_s if way.climbed_s > 0 else math.inf
            if way.loop_duration_s == 0:
                return math.inf
            ends_s = way.loop_start_s
            following = next((k for k, one in enumerate(charges) if one.from_s <= ends_s < one.until_s), None)
        if following is None or charges[following].charger != charge.charger:
            return after_s
        after_s += charges[following].until_s - ends_s
        number = following
    return math.inf


def hasty_violations(plan: Plan) -> Iterator[Violation]:
    """Stays that are too short to land and to climb: the first of each robot.

    Who is at a charger as the plan takes over climbs from then on, but for what it had climbed already.
    """
    before = {one.robot: one for one in (() if plan.seam is None else plan.seam.driven)}
    for one in plan:
        battery, driven = plan.mission.fleet.robot(one.robot).battery, before.get(one.robot)
        if battery.grounding_s == 0:
            continue
        for charger, came_s, leaves_s in _stays(one, driven):
            needs_s, begins_s = battery.grounding_s, came_s
            if came_s < 0 and plan.seam is not None and leaves_s - came_s >= needs_s:
                needs_s, begins_s = battery.climbing_s - (0.0 if driven is None else driven.climbed_s), 0.0
            if leaves_s - begins_s < needs_s - SAME_TIME * max(1.0, leaves_s):
                yield violation(
                    "leaves before it can land and climb", f"{one.robot}, {charger}", one.at(leaves_s)[:2], leaves_s,
                    leaves_s - begins_s, needs_s, "s",
                )  # fmt: skip
                break


def _stays(one: Trajectory, driven: Driven | None) -> Iterator[tuple[str, float, float]]:
    """At which charger a robot stays, since when and until when; -inf: it was there when all began.

    Below 0: since then in what was driven before.
    """
    if driven is not None and len(driven.times_s) == 1:  # a moment tells nothing
        driven = None
    there = driven is not None and bool(driven.charges) and driven.charges[-1].until_s == 0
    if driven is not None and there and not (one.charges and one.charges[0].from_s == 0):
        yield driven.charges[-1].charger, _came_s(driven), 0.0
    for number, charge in enumerate(one.charges):
        begins_s = charge.from_s
        if number > 0 and one.charges[number - 1].until_s == begins_s:
            continue
        lasts_s = charge.until_s - begins_s + stays_on_s(one, charge, 0.0)
        if begins_s == 0 and (there or driven is None):
            came_s = -math.inf if driven is None else _came_s(driven)
            yield charge.charger, came_s, lasts_s
            if one.loop_start_s > 0 or one.loop_duration_s == 0 or one.charges[-1].until_s == one.times_s[-1]:
                continue
            begins_s = float(one.times_s[-1])  # it comes in flight the next time
        yield charge.charger, begins_s, begins_s + lasts_s


def _came_s(driven: Driven) -> float:
    """When a robot that is at a charger in the end has come there; -inf: it was there when all that is told began."""
    came_s = driven.charges[-1].from_s
    for charge in reversed(driven.charges[:-1]):
        if charge.until_s != came_s:
            break
        came_s = charge.from_s
    return -math.inf if came_s <= driven.times_s[0] else came_s


def crowded_violations(plan: Plan) -> Iterator[Violation]:
    """Chargers that have more robots at some time than places."""
    chargers = {charger.name: charger for charger in plan.mission.chargers}
    users: dict[str, list[Trajectory]] = defaultdict(list)
    for trajectory in plan:
        for name in dict.fromkeys(charge.charger for charge in trajectory.charges):
            users[name].append(trajectory)
    for name, robots in users.items():
        classes, parts, units_s = commensurable_classes([one.loop_duration_s for one in robots])
        from_s = max(one.loop_start_s for one in robots)
        count, time_s = 0, None
        for number in np.unique(classes):
            own = [one for one, its in zip(robots, classes, strict=True) if its == number]
            common_s = math.lcm(*(int(part) for part in parts[classes == number])) * float(units_s[number])
            most, when_s = _most_at_once(own, name, (from_s + common_s) * (1 + 2 * SAME_TIME))
            count, time_s = count + most, when_s if len(np.unique(classes)) == 1 else None
        if count > chargers[name].places:
            who = f"{name}: {', '.join(one.robot for one in robots)}"
            yield violation("charger too full", who, chargers[name].at, time_s, count, chargers[name].places, "robots")


def _most_at_once(robots: list[Trajectory], charger: str, until_s: float) -> tuple[int, float | None]:
    """How many of these robots are at a charger at once until a time, at most, and when."""
    spans: list[Floats] = []
    stays = 0.0
    for one in robots:
        turns = 1 if one.loop_duration_s == 0 else math.ceil((until_s - one.loop_start_s) / one.loop_duration_s)
        stays += turns * len(one.charges)
        if stays > MOST_STAYS:
            return len(robots), None
        own: list[Floats] = []
        for charge in (each for each in one.charges if each.charger == charger):
            again = np.arange(turns if charge.from_s >= one.loop_start_s else 1) * one.loop_duration_s
            for_ever = one.loop_duration_s == 0 and charge.until_s == one.times_s[-1]
            own.append(np.stack([charge.from_s + again, np.full(1, until_s) if for_ever else charge.until_s + again]))
        from_s, to_s = np.sort(np.hstack(own), axis=1)  # it is there once at a time
        moment_s = SAME_TIME * np.maximum(1.0, to_s)
        apart = from_s[1:] > to_s[:-1] + moment_s[:-1]
        from_s, to_s = from_s[np.append(True, apart)], to_s[np.append(apart, True)]
        # one leaves at the moment at which another one comes
        spans.append(np.stack([from_s, np.maximum(to_s - moment_s[np.append(apart, True)], (from_s + to_s) / 2)]))
    begin_s, end_s = np.hstack(spans)
    times_s = np.concatenate([begin_s, end_s])
    steps = np.concatenate([np.ones(len(begin_s)), -np.ones(len(end_s))])
    order = np.lexsort((steps, times_s))
    present = np.cumsum(steps[order])
    k = int(np.argmax(present))
    return int(present[k]), float(times_s[order[k]])
