"""What `rota check` says of plans that are met: that robots change speed at once, and what a copter would take."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rota.plan import Plan

WORTH_SAYING = 1.02  # a vehicle that takes no more than this many times as long


def without_mass(plan: Plan, *, is_flown: bool = False) -> str | None:
    """That the verdict is for robots that change speed at once, with what a copter takes; None where nobody loops.

    The copter is told of missions that lie on the globe, where one can be sent. is_flown: it is sent one.
    """
    if plan.mission.planning.bouncing is not None or not any(each.loop_duration_s for each in plan):
        return None
    told = "for robots that change speed at once"
    if plan.mission.origin is None and not is_flown:
        return told
    from rota.files.executed.plan_as_flown import way_of
    from rota.vehicles.models import model_of
    from rota.vehicles.presets import ARDUCOPTER

    model, loops = model_of(ARDUCOPTER), [each for each in plan if each.loop_duration_s]
    factor = max(model.round_s(way_of(plan, each)) / each.loop_duration_s for each in loops)
    if factor <= WORTH_SAYING:
        return told
    return (
        f"{told}; {ARDUCOPTER.told} takes up to {factor:.1f} times as long (--executed waypoints --vehicle arducopter)"
    )
