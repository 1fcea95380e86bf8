"""Missions whose robots may begin anywhere."""

from __future__ import annotations

from dataclasses import replace

from rota.model.mission import Mission


def without_starts(mission: Mission) -> Mission:
    """The same mission, its robots anywhere to begin with; itself when they are."""
    if not mission.has_starts:
        return mission
    robots = mission.fleet.robots
    anywhere = None if robots is None else tuple(replace(robot, start=None) for robot in robots)
    return replace(mission, fleet=replace(mission.fleet, robots=anywhere, start=None))
