"""How full batteries are at a moment of a plan, and which changes of a mission leave that as it is."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from rota.errors import MissionError
from rota.model.battery_limits import BATTERY_FIELDS
from rota.model.mission import Mission
from rota.model.plan import Driven, Plan, Trajectory

Level = Callable[[float], float]


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
