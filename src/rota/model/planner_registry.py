"""Planners by their names: those of this package, and those that other distributions offer by an entry point."""

from __future__ import annotations

import importlib
from functools import cache
from typing import Any

from rota.errors import MissionError

DEFAULT = "patrol"  # the planner of a mission that names none
ENTRY_POINTS = "rota.planners"  # the group by which other distributions offer theirs
# a planner of this package: its name, and where its door is
PLANNERS = {
    "patrol": "rota.planners.patrol:PatrolPlanner",
    "swarm": "rota.planners.swarm:SwarmPlanner",
    "bounce": "rota.planners.bounce:BouncePlanner",
}


def planner_names() -> tuple[str, ...]:
    """All planners that can be named in a mission: this package's, then those of other distributions by name."""
    return (*PLANNERS, *sorted(set(offered_planners()) - set(PLANNERS)))


@cache
def offered_planners() -> dict[str, str]:
    """Names and places of the planners that other distributions offer."""
    return offers(ENTRY_POINTS)


def offers(group: str) -> dict[str, str]:
    """Names and places of what other distributions offer by the entry points of a group."""
    from importlib.metadata import entry_points

    return {point.name: point.value for point in entry_points(group=group)}


@cache
def door_of(name: str) -> Any:
    """The door of the planner of this name, a ``rota.planning.planner.Planner``.

    Raises MissionError for a name that is not known and for a door that cannot be loaded. Loading it compiles nothing.
    """
    where = PLANNERS.get(name) or offered_planners().get(name)
    if where is None:
        raise MissionError(f"planner: {name!r} is not known; {', '.join(planner_names())} are")
    module, _, door = where.partition(":")
    try:
        planner = getattr(importlib.import_module(module), door)()
        named = planner.settings.planner
    except Exception as error:
        if name in PLANNERS:
            raise
        raise MissionError(f"planner: {name} cannot be loaded from {where}: {error}") from error
    if named != name:
        raise MissionError(f"planner: {where} is offered as {name}, but its settings have the name {named}")
    return planner
