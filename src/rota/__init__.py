"""Timed routes for teams of robots that must keep watching a whole area, and an independent check of every plan."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

# eager, and cheap: the submodule of this name would otherwise hide the function once anything imports it
from rota.make_plan import make_plan, search_plan

if TYPE_CHECKING:
    from rota.check import check_plan
    from rota.draw import animate_plan, draw_cells, draw_plan
    from rota.errors import MissionError, NoPlanFound, PlanError, RotaError, RunError
    from rota.files.geojson import write_geojson
    from rota.files.mission_file import read_mission
    from rota.files.plan_file import read_plan, write_plan
    from rota.files.qgroundcontrol import write_qgroundcontrol
    from rota.files.run_file import read_run, write_run
    from rota.mission import (
        BounceSettings,
        DiscSensor,
        Fleet,
        GeoPoint,
        Mission,
        MovingObstacle,
        Obstacle,
        PatrolSettings,
        Robot,
        SquareSensor,
        StartBox,
        StartPoints,
        SwarmSettings,
        Zone,
    )
    from rota.plan import Plan, Trajectory

__all__ = [
    "BounceSettings",
    "DiscSensor",
    "Fleet",
    "GeoPoint",
    "Mission",
    "MissionError",
    "MovingObstacle",
    "NoPlanFound",
    "Obstacle",
    "PatrolSettings",
    "Plan",
    "PlanError",
    "Robot",
    "RotaError",
    "RunError",
    "SquareSensor",
    "StartBox",
    "StartPoints",
    "SwarmSettings",
    "Trajectory",
    "Zone",
    "animate_plan",
    "check_plan",
    "draw_cells",
    "draw_plan",
    "make_plan",
    "read_mission",
    "read_plan",
    "read_run",
    "search_plan",
    "write_geojson",
    "write_plan",
    "write_qgroundcontrol",
    "write_run",
]

_MODULES = {
    "rota.check": ["check_plan"],
    "rota.draw": ["animate_plan", "draw_cells", "draw_plan"],
    "rota.errors": ["MissionError", "NoPlanFound", "PlanError", "RotaError", "RunError"],
    "rota.files.geojson": ["write_geojson"],
    "rota.files.mission_file": ["read_mission"],
    "rota.files.plan_file": ["read_plan", "write_plan"],
    "rota.files.qgroundcontrol": ["write_qgroundcontrol"],
    "rota.files.run_file": ["read_run", "write_run"],
    "rota.mission": [
        "BounceSettings",
        "DiscSensor",
        "Fleet",
        "GeoPoint",
        "Mission",
        "MovingObstacle",
        "Obstacle",
        "PatrolSettings",
        "Robot",
        "SquareSensor",
        "StartBox",
        "StartPoints",
        "SwarmSettings",
        "Zone",
    ],
    "rota.plan": ["Plan", "Trajectory"],
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
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
