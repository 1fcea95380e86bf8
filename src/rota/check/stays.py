"""Stays at chargers: how long robots are there in all, and whether that is long enough to land and to climb.

Who comes to a charger in flight lands first, and who leaves it climbs before: neither charges. A stay may go on across
the seam of a loop, and from what was driven before a plan took over into the plan. Who is at a charger where all begins
has landed, and may have begun to climb.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from rota.check.report import Violation, violation
from rota.check.tolerances import SAME_TIME
from rota.model.plan import Charge, Driven, Plan, Trajectory


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
