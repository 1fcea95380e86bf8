"""Plan and report -> the bytes that a player needs, so that it can show any moment without having played the rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rota.check.batteries import Battery, batteries_of
from rota.check.report import Report, report_to_json
from rota.check.routes import routes_of
from rota.files.mission_json import mission_to_json
from rota.model.field_values import Json
from rota.model.mission import DiscSensor, Mission, Robot
from rota.model.plan import Plan, Seam, Trajectory
from rota.planning.plan_summary import approach_sentence, bound_sentence, ratio_sentence, robots_sentence
from rota.playback.bounces import cell_arrays, turn_arrays
from rota.playback.cells import SeenCells, seen_cells
from rota.playback.container import pack
from rota.playback.coverage import Coverage, coverage_over_time, range_over_time
from rota.routes.constant_speeds import plan_at_constant_speeds

Arrays = dict[str, NDArray[Any]]

CELLS = 20_000
EXACT_BELOW_M = 4_096.0  # so far from 0, a 32-bit coordinate is right to half a millimetre
MOST_TURNS = 20  # of the longest loop, within which a common period of all loops is worth showing
SHOWN_BEFORE_S = 30.0  # of what was driven before the plan took over
LOOPS_SHOWN = 4  # of the longest loop, where there is no such period


def playback_of(plan: Plan, report: Report, cells: int = CELLS) -> bytes:
    """The playback of a plan, see ``container``; ``cells``: about how many over the area's bounding box.

    A place was last seen at the latest moment at which one of its sightings was on, so its age at any time follows from
    its sightings alone. They come from the check's kernels, in closed form. Robots drive legs with accelerations as
    shorter ones at constant speeds, never off by more than 5 cm.
    """
    plan = plan_at_constant_speeds(plan)
    seen = seen_cells(plan, report, cells)
    batteries = batteries_of(plan)
    bounces, more = _bounces(plan, report)
    coverage = bounces.pop("coverage", None) or range_over_time(plan)
    header: Json = {
        "plan": _plan_header(plan, report),
        "seam": None if plan.seam is None else _seam_header(plan.seam),
        "mission": {
            **ground_to_json(plan.mission),
            "moving_obstacles": _moving(plan),
            "chargers": [{"name": charger.name, "at": list(charger.at)} for charger in plan.mission.chargers],
        },
        "bounds_m": [float(value) for value in plan.mission.area.bounds],
        "clock": clock_of(plan),
        "robots": [_robot_header(plan, one, battery) for one, battery in zip(plan, batteries, strict=True)],
        "demands": [
            {
                "name": demand.name,
                "period_s": demand.period_s,
                "demand": demand.demand,
                "area_m2": demand.area_m2,
                "worst_gap_s": demand.worst_gap_s if math.isfinite(demand.worst_gap_s) else None,
                "outcome": demand.outcome,
            }
            for demand in report.demands
        ],
        "report": report_to_json(report),
        "grid": seen.grid,
        "coverage": None if coverage is None else coverage.header,
        "cells": bounces.get("cells"),
    }
    return pack(
        header,
        {
            **_corner_arrays(plan),
            **_cell_arrays(seen),
            **_coverage_arrays(coverage),
            **_battery_arrays(batteries),
            **more,
        },
    )


def clock_of(plan: Plan) -> Json:
    """What a slider runs over: ``from_s`` the latest loop start; ``repeat_s`` the common period of all loops.

    repeat_s: None where loops share none that is at most 20 of the longest loop; 0 where all robots stay. ``end_s``:
    two such periods after from_s, so that the second is how it goes on for ever; without one, some loops after it.
    """
    routes = routes_of(plan)
    moving = routes.durations_s > 0
    if not moving.any():
        last_s = max((float(trajectory.times_s[-1]) for trajectory in plan), default=0.0)
        return {"from_s": last_s, "repeat_s": 0.0, "end_s": last_s}
    longest_s, from_s = float(routes.durations_s.max()), float(routes.from_s)
    repeat_s = None
    classes = np.unique(routes.classes[moving])
    if len(classes) == 1:
        common_s = math.lcm(*(int(part) for part in routes.parts[moving])) * float(routes.units_s[classes[0]])
        repeat_s = common_s if common_s <= MOST_TURNS * longest_s else None
    shown_s = LOOPS_SHOWN * longest_s if repeat_s is None else 2 * repeat_s
    return {"from_s": from_s, "repeat_s": repeat_s, "end_s": from_s + shown_s}


def _plan_header(plan: Plan, report: Report) -> Json:
    """The plan in words."""
    sentences = (robots_sentence(plan), bound_sentence(plan), ratio_sentence(plan, report), approach_sentence(plan))
    return {
        "name": plan.mission.name,
        "planner": plan.mission.planning.planner,
        "seed": int(plan.seed),
        "bound": plan.lower_bound_robots,
        "bound_reason": plan.lower_bound_reason,
        "facts": [sentence for sentence in sentences if sentence],
    }


def _seam_header(seam: Seam) -> Json:
    """Where the plan takes over from another one, and how each robot came there: corners of the last seconds."""
    ways = []
    for driven in seam.driven:
        first = max(0, int(np.searchsorted(driven.times_s, -SHOWN_BEFORE_S)) - 1)
        ways.append({"robot": driven.robot, "positions_m": driven.positions_m[first:].tolist()})
    return {"at_s": seam.at_s, "lost": list(seam.lost), "ways": ways}


def _robot_header(plan: Plan, trajectory: Trajectory, battery: Battery | None) -> Json:
    """One robot, its clock, its stays at chargers by their numbers, and its battery."""
    robot = plan.mission.fleet.robot(trajectory.robot)
    names = [charger.name for charger in plan.mission.chargers]
    return {
        "name": robot.name,
        "sensor": _sensor(robot),
        "body_radius_m": float(robot.body_radius_m),
        "speed_m_s": float(robot.speed_m_s),
        "loop_start_s": trajectory.loop_start_s,
        "end_s": float(trajectory.times_s[-1]),
        "loops": trajectory.loop_duration_s > 0,
        "joins_s": float(robot.joins_s),
        "leaves_s": None if robot.leaves_s is None else float(robot.leaves_s),
        "charges": [[charge.from_s, charge.until_s, names.index(charge.charger)] for charge in trajectory.charges],
        "battery": None if battery is None else _battery_header(battery),
    }


def _battery_header(battery: Battery) -> Json:
    """The share that is the reserve, and from when on the levels repeat."""
    reserve = battery.reserve_s / battery.full_s
    return {"reserve": reserve, "again_s": float(battery.again_s), "every_s": float(battery.round_s)}


def _sensor(robot: Robot) -> Json:
    """What it sees with."""
    if isinstance(robot.sensor, DiscSensor):
        half_angle = robot.sensor.half_angle_deg
        return {"shape": "disc", "radius_m": float(robot.sensor.radius_m), "half_angle_deg": half_angle}
    return {"shape": "square", "side_m": float(robot.sensor.side_m), "half_angle_deg": None}


def _moving(plan: Plan) -> list[Json]:
    """The mission's moving obstacles."""
    return [
        {"radius_m": float(m.radius_m), "times_s": list(m.times_s), "positions_m": [list(at) for at in m.positions_m]}
        for m in plan.mission.moving_obstacles
    ]


def _bounces(plan: Plan, report: Report) -> tuple[Json, Arrays]:
    """Of robots that bounce: the grid of their cells, what they entered over time, and their arrays."""
    rules = plan.mission.planning.bouncing
    if rules is None or not len(plan.trajectories):
        return {}, {}
    arrays = turn_arrays(plan)
    if rules.cell_m == 0:
        return {}, arrays
    grid, added, entered_s = cell_arrays(plan)
    told: Json = {"cells": grid}
    if report.cells_entered is not None:
        told["coverage"] = coverage_over_time(entered_s, report.cells_entered[1])
    return told, {**arrays, **added}


def _corner_arrays(plan: Plan) -> Arrays:
    """The trajectories' corners, robot by robot; heights only where a plan has some."""
    offsets = np.cumsum([0, *(len(trajectory.times_s) for trajectory in plan)])
    times_s = np.concatenate([np.empty(0), *(trajectory.times_s for trajectory in plan)])
    far_m = max(abs(float(value)) for value in plan.mission.area.bounds)
    kind = np.float32 if far_m < EXACT_BELOW_M else np.float64
    places_m = np.concatenate([np.empty((0, 2)), *(trajectory.positions_m[:, :2] for trajectory in plan)])
    arrays: Arrays = {
        "corner_offsets": offsets.astype(np.uint32),
        "corner_time_s": times_s,
        "corner_x_m": places_m[:, 0].astype(kind),
        "corner_y_m": places_m[:, 1].astype(kind),
    }
    if any(trajectory.positions_m.shape[1] == 3 for trajectory in plan):
        heights = [
            t.positions_m[:, 2] if t.positions_m.shape[1] == 3 else np.zeros(len(t.times_s)) for t in plan
        ]  # fmt: skip
        arrays["corner_z_m"] = np.concatenate(heights).astype(np.float32)
    return arrays


def _cell_arrays(seen: SeenCells) -> Arrays:
    """The asked cells and when they are seen."""
    before = {} if seen.before_s is None else {"cell_before_s": seen.before_s.astype(np.float64)}
    return {
        **before,
        "cell_index": seen.index.astype(np.uint32),
        "cell_demand": seen.demand.astype(np.uint16),
        "cell_worst": seen.worst.astype(np.float32),
        "excluded_index": seen.excluded.astype(np.uint32),
        "sight_offsets": seen.sights.offsets.astype(np.uint32),
        "sight_robot": seen.sights.robots.astype(np.uint16),
        "sight_start_s": seen.sights.starts_s.astype(np.float32),
        "sight_end_s": seen.sights.ends_s.astype(np.float32),
        "sight_loops": seen.sights.again.astype(np.uint8),
    }


def _battery_arrays(batteries: Sequence[Battery | None]) -> Arrays:
    """The share that is left in each battery until it repeats, and once more; a swap has two shares at one time."""
    if not any(batteries):
        return {}
    lines = [
        (np.empty(0), np.empty(0)) if battery is None else battery.line(battery.again_s + battery.round_s)
        for battery in batteries
    ]
    return {
        "battery_offsets": np.cumsum([0, *(len(times_s) for times_s, _ in lines)]).astype(np.uint32),
        "battery_time_s": np.concatenate([times_s for times_s, _ in lines]),
        "battery_share": np.concatenate([shares for _, shares in lines]).astype(np.float32),
    }


def _coverage_arrays(coverage: Coverage | None) -> Arrays:
    """The curve of robots that spread, or that cover a floor."""
    if coverage is None:
        return {}
    return {
        "coverage_time_s": coverage.times_s.astype(np.float32),
        "coverage_share": coverage.shares.astype(np.float32),
    }


def ground_to_json(mission: Mission) -> Json:
    """Area, obstacles, zones and the period outside zones as plan files have them; the origin, null without one."""
    whole = mission_to_json(mission)
    return {name: whole[name] for name in ("area", "obstacles", "zones", "period_s", "origin")}
