"""Timed routes for teams of robots that must keep watching a whole area, and an independent check of every plan."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rota.check import check_plan, worst_gaps_s
    from rota.check.report import DemandVerdict, Report, Violation
    from rota.draw import animate_plan, draw_cells, draw_gaps, draw_plan
    from rota.errors import ArgumentError, CheckpointError, MissionError, NoPlanFound, PlanError, RotaError
    from rota.exports import export_plan
    from rota.files.checkpoint_file import read_checkpoint, write_checkpoint
    from rota.files.geojson import write_geojson
    from rota.files.mission_file import read_mission
    from rota.files.mission_writer import write_mission
    from rota.files.plan_file import read_plan, write_plan
    from rota.files.qgroundcontrol import write_qgroundcontrol
    from rota.model.battery_limits import BatteryLimits
    from rota.model.mission import (
        Charger,
        DiscSensor,
        Fleet,
        GeoPoint,
        ImportanceMap,
        Kind,
        Mission,
        MovingObstacle,
        Obstacle,
        Robot,
        SquareSensor,
        StartBox,
        StartPoints,
        Zone,
    )
    from rota.model.motion_limits import MotionLimits
    from rota.model.plan import Plan, Trajectory
    from rota.planners.bounce.planner_settings import BounceSettings
    from rota.planners.patrol.planner_settings import PatrolSettings
    from rota.planners.swarm.planner_settings import SwarmSettings
    from rota.planning.make_plan import PlanSearch, make_plan, search_plan
    from rota.planning.planner import prove_bound
    from rota.rehearsal import DemandOutcome, Rehearsal, draw_rehearsal, rehearse
    from rota.replanning.replan import Replanned, replan
    from rota.vehicles.battery_data import BatteryData

__all__ = [
    "ArgumentError",
    "BatteryData",
    "BatteryLimits",
    "BounceSettings",
    "Charger",
    "CheckpointError",
    "DemandOutcome",
    "DemandVerdict",
    "DiscSensor",
    "Fleet",
    "GeoPoint",
    "ImportanceMap",
    "Kind",
    "Mission",
    "MissionError",
    "MotionLimits",
    "MovingObstacle",
    "NoPlanFound",
    "Obstacle",
    "PatrolSettings",
    "Plan",
    "PlanError",
    "PlanSearch",
    "Rehearsal",
    "Replanned",
    "Report",
    "Robot",
    "RotaError",
    "SquareSensor",
    "StartBox",
    "StartPoints",
    "SwarmSettings",
    "Trajectory",
    "Violation",
    "Zone",
    "animate_plan",
    "check_plan",
    "draw_cells",
    "draw_gaps",
    "draw_plan",
    "draw_rehearsal",
    "export_plan",
    "make_plan",
    "prove_bound",
    "read_checkpoint",
    "read_mission",
    "read_plan",
    "rehearse",
    "replan",
    "search_plan",
    "worst_gaps_s",
    "write_checkpoint",
    "write_geojson",
    "write_mission",
    "write_plan",
    "write_qgroundcontrol",
]

_MODULES = {
    "rota.planning.planner": ["prove_bound"],
    "rota.exports": ["export_plan"],
    "rota.check.report": ["DemandVerdict", "Report", "Violation"],
    "rota.check": ["check_plan", "worst_gaps_s"],
    "rota.draw": ["animate_plan", "draw_cells", "draw_plan", "draw_gaps"],
    "rota.errors": ["ArgumentError", "MissionError", "NoPlanFound", "PlanError", "RotaError", "CheckpointError"],
    "rota.files.geojson": ["write_geojson"],
    "rota.files.mission_file": ["read_mission"],
    "rota.files.mission_writer": ["write_mission"],
    "rota.files.plan_file": ["read_plan", "write_plan"],
    "rota.files.qgroundcontrol": ["write_qgroundcontrol"],
    "rota.files.checkpoint_file": ["read_checkpoint", "write_checkpoint"],
    "rota.model.battery_limits": ["BatteryLimits"],
    "rota.model.mission": [
        "Charger",
        "DiscSensor",
        "Fleet",
        "GeoPoint",
        "ImportanceMap",
        "Kind",
        "Mission",
        "MovingObstacle",
        "Obstacle",
        "Robot",
        "SquareSensor",
        "StartBox",
        "StartPoints",
        "Zone",
    ],
    "rota.model.motion_limits": ["MotionLimits"],
    "rota.model.plan": ["Plan", "Trajectory"],
    "rota.planners.bounce.planner_settings": ["BounceSettings"],
    "rota.planners.patrol.planner_settings": ["PatrolSettings"],
    "rota.planners.swarm.planner_settings": ["SwarmSettings"],
    "rota.rehearsal": ["DemandOutcome", "Rehearsal", "draw_rehearsal", "rehearse"],
    "rota.replanning.replan": ["replan", "Replanned"],
    "rota.vehicles.battery_data": ["BatteryData"],
    "rota.planning.make_plan": ["make_plan", "search_plan", "PlanSearch"],
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    # loaded on first use, so that `import rota` stays quick
    if name == "__version__":
        from importlib.metadata import version

        return version("rota")
    if name not in _HOME:
        raise AttributeError(f"module 'rota' has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOME[name]), name)
    if not isinstance(value, type):
        from rota.argument_types import with_types_required

        value = with_types_required(value)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
