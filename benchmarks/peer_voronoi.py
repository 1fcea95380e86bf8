"""Robots of CoverageControl: ``python peer_voronoi.py PROBLEM.json`` prints JSON of where they end, and its costs.

Runs in an environment of its own, in which that package (GPL-3.0) is installed and Rota is not. Its compiled core is
loaded without the rest, which wants torch. The problem: the map's side, sensor, speed and time step, features of
importance (x, y, spread, peak; none: all ground is worth as much), starts, most steps, and the file for its map.
"""

from __future__ import annotations

import importlib.util
import json
import sys
from importlib.metadata import files, version
from pathlib import Path
from typing import Any

import numpy as np


def core_of(package: str) -> Any:
    """The compiled module of CoverageControl."""
    (library,) = [file for file in files(package) or () if file.name.startswith("_core.")]
    spec = importlib.util.spec_from_file_location("_core", str(library.locate()))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def parameters_of(core: Any, problem: dict[str, Any]) -> Any:
    """The package's own defaults but for what the problem gives."""
    asked = core.Parameters()
    asked.pNumRobots, asked.pWorldMapSize = len(problem["starts"]), problem["side_m"]
    asked.pRobotMapSize, asked.pSensorSize = problem["side_m"], problem["sensor_m"]
    asked.pMaxRobotSpeed, asked.pTimeStep = problem["speed_m_s"], problem["time_step_s"]
    return asked


def outcome(core: Any, problem: dict[str, Any]) -> dict[str, Any]:
    """Where the robots of its controller by the whole map (ClairvoyantCVT) end."""
    asked = parameters_of(core, problem)
    world = core.WorldIDF(asked)
    if problem["features"]:
        for x, y, spread, peak in problem["features"]:
            scale = 2 * np.pi * spread * spread * peak
            world.AddNormalDistribution(core.BivariateNormalDistribution(np.array([x, y]), spread, scale))
        world.GenerateMapCPU()
    else:
        world = core.WorldIDF(asked, np.ones((problem["side_m"], problem["side_m"]), np.float32))
    system = core.CoverageSystem(asked, world, core.PointVector([np.array(start) for start in problem["starts"]]))
    np.save(problem["map_file"], system.GetWorldMap())
    controller, steps, converged = core.ClairvoyantCVT(asked, system), 0, False
    while steps < problem["most_steps"] and not converged:
        controller.ComputeActions()
        converged = controller.IsConverged()
        steps += 0 if converged or system.StepActions(controller.GetActions()) else 1
    ends = [[float(value) for value in place] for place in system.GetRobotPositions()]
    told = {"version": version("coverage_control"), "ends": ends, "steps": steps, "converged": bool(converged)}
    return {**told, "cost": float(system.GetObjectiveValue())}


if __name__ == "__main__":
    print(json.dumps(outcome(core_of("coverage_control"), json.loads(Path(sys.argv[1]).read_text()))))
