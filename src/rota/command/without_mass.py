"""What is said below the verdict on a plan without motion limits: robots change speed at once; what a copter takes."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rota.model.plan import Plan

WORTH_SAYING = 1.02  # a vehicle that takes no more than this many times as long


def without_mass(plan: Plan, *, is_flown: bool = False) -> str | None:
    """That the plan is for robots that change speed at once, with what a copter takes; None where no such robot loops.

    Bouncing robots, and those of a vehicle, are told of without the copter. Where one can be sent, since the mission
    lies on the globe or is_flown, it is told how to see more of that.
    """
    fleet = plan.mission.fleet
    loops = [each for each in plan if each.loop_duration_s and not fleet.robot(each.robot).motion.has_mass]
    if not loops:
        return None
    told = "for robots that change speed at once"
    if len(loops) < sum(each.loop_duration_s > 0 for each in plan):
        told += f" ({', '.join(each.robot for each in loops)})"
    if plan.mission.planning.bouncing is not None or any(fleet.robot(each.robot).motion.vehicle for each in loops):
        return told
    from rota.files.executed.plan_as_flown import way_of
    from rota.vehicles.models import model_of
    from rota.vehicles.presets import ARDUCOPTER

    model = model_of(ARDUCOPTER)
    factor = max(model.round_s(way_of(plan, each)) / each.loop_duration_s for each in loops)
    if factor <= WORTH_SAYING:
        return told
    told += f"; {ARDUCOPTER.told} takes up to {factor:.1f} times as long"
    can_be_sent = plan.mission.origin is not None or is_flown
    return f"{told} (--executed waypoints --vehicle arducopter)" if can_be_sent else told
