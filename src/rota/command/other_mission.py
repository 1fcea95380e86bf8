"""A plan, judged for another mission than the one in its file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from rota.command.arguments import read_and_warn
from rota.command.terminal import say
from rota.model.plan import Plan


def plan_for_mission(plan: Plan, mission: Path) -> Plan:
    """The plan's trajectories as an answer to a mission file; says what that asks otherwise than the plan's own.

    The bound that the plan claims is left out where the missions differ. Raises MissionError for a mission that cannot
    be read, PlanError for one whose fleet or area the trajectories do not fit.
    """
    from rota.files.mission_changes import changes
    from rota.files.mission_json import mission_to_json

    now = read_and_warn(mission)
    told = changes(mission_to_json(plan.mission), mission_to_json(now))
    if not told:
        return replace(plan, mission=now)
    say(f"the plan was made for another mission than {mission}: {'; '.join(told)}")
    return replace(plan.without_bound(), mission=now)
