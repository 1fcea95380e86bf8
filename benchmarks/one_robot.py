"""One robot, one loop: its length when everything is seen, beside coverage-path-planner from PyPI in the same run.

That package names no licence. It is therefore no dependency of this project: the benchmark installs it into a folder
that is thrown away, and says so where that cannot be done.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely

from benchmarks.peer_environment import peer_answer
from benchmarks.planning import Planned, plan_and_check, plan_file_of, told
from benchmarks.row import Options, Row
from benchmarks.warm_cache import measured_warm
from rota.check import check_plan
from rota.files.plan_file import read_plan
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.model.plan import Plan, Trajectory

SIDE_M, RADIUS_M = 120.0, 5.0
BLOCKS = ((30, 60, 45, 85), (75, 30, 100, 45))  # left, bottom, right, top in metres
ASKED_M, ASKED_CPU_S = 1500.0, 60.0
SPEED_M_S, PERIOD_S = 1.0, 1620.0  # the robot's loop is as short as can be found, whatever the period
PEER = "coverage-path-planner>=1.4,<2"
# lanes that are exactly two radii apart leave a line between them that is decided by rounding: all get this much more
MORE_SIGHT_M = 1e-3
NEARLY = 0.99  # share seen by the second of the peer's paths that is told


class Loop(NamedTuple):
    """A route and how much of the ground it sees, by Rota's check, to a hundredth of a per cent.

    sees_all: the check has shown it of every point.
    """

    length_m: float
    seen_share: float
    sees_all: bool
    stays_inside: bool


def one_robot(options: Options) -> Iterator[Row]:
    """Rota's loop, then the peer's path."""
    yield shortest_loop(options)
    yield from peer_rows(options.folder)


# ---------------------------------------------------------------- Rota


def mission_text() -> str:
    """A mission (JSON) with one robot, whose plan sees everything after as short a time as was found."""
    rings = [shapely.box(*block).exterior.coords[:-1] for block in BLOCKS]
    mission = {
        "rota": 1,
        "name": "one-robot",
        "area": [[0, 0], [SIDE_M, 0], [SIDE_M, SIDE_M], [0, SIDE_M]],
        "obstacles": [[list(corner) for corner in ring] for ring in rings],
        "period_s": PERIOD_S,
        "fleet": {"robots": 1, "speed_m_s": SPEED_M_S, "sensor": {"shape": "disc", "radius_m": RADIUS_M}},
    }
    return json.dumps(mission)


def shortest_loop(options: Options) -> Row:
    """The loop of a team of one robot, planned once."""
    mission = options.folder / "one-robot.json"
    mission.write_text(mission_text())
    (planned,) = measured_warm(
        lambda: plan_and_check(mission, options.folder, effort=options.effort), lambda one: one.wall_s, repeats=1
    )
    if not planned.met:
        return loop_row(planned, None, options.effort)
    (trajectory,) = read_plan(plan_file_of(mission, options.folder))
    return loop_row(planned, judged(trajectory.positions_m), options.effort)


def loop_row(planned: Planned, loop: Loop | None, effort: str) -> Row:
    """The row of a loop, and of none."""
    name = f"one robot, {SIDE_M:.0f} m square with two obstacles: closed loop, {effort}"
    asked = f"at most {ASKED_M:,.0f} m at 100 % seen, CPU at most {ASKED_CPU_S:.0f} s"
    if loop is None:
        return Row(name, asked, f"none within {SPEED_M_S * PERIOD_S:,.0f} m: {told([planned])}", False)
    sees_all = loop.sees_all and loop.stays_inside
    reached = round(loop.length_m) <= ASKED_M and sees_all and planned.cpu_s <= ASKED_CPU_S
    measured = (
        f"{loop.length_m:,.0f} m, {100 * loop.seen_share:.2f} % seen; {told([planned])}; CPU {planned.cpu_s:.0f} s"
    )
    return Row(name, asked, measured, reached)


# ---------------------------------------------------------------- what a route sees


def ground() -> Mission:
    """The mission by which routes are judged: one round in whatever time."""
    blocks = tuple(Obstacle(shape=shapely.MultiPolygon([shapely.box(*block)])) for block in BLOCKS)
    return Mission(
        name="one-robot",
        area=shapely.MultiPolygon([shapely.box(0, 0, SIDE_M, SIDE_M)]),
        obstacles=blocks,
        period_s=1e6,
        fleet=Fleet(speed_m_s=10.0, sensor=DiscSensor(radius_m=RADIUS_M + MORE_SIGHT_M)),
    )


def judged(points_m: np.ndarray) -> Loop:
    """What the route through the points (n, 2) sees, on the way there and back, which sees just as much."""
    there_and_back = np.vstack([points_m, points_m[-2::-1]])
    there_and_back = there_and_back[np.r_[True, (np.diff(there_and_back, axis=0) != 0).any(axis=1)]]
    legs_m = np.hypot(*np.diff(there_and_back, axis=0).T)
    mission = ground()
    times_s = np.concatenate([[0.0], np.cumsum(legs_m / mission.fleet.speed_m_s)])
    route = Trajectory(robot="robot-1", times_s=times_s, positions_m=there_and_back)
    report = check_plan(Plan(mission=mission, trajectories=(route,)))
    (area,) = report.demands
    inside = all(violation.kind == "gap" for violation in report.violations)
    return Loop(float(legs_m.sum()) / 2, 1 - area.unseen_area_m2 / area.area_m2, area.outcome == "met", inside)


# ---------------------------------------------------------------- the peer


def peer_settings() -> list[dict[str, Any]]:
    """What the peer is tried with: patterns, distances of lanes and borders, directions, rounds along borders."""
    lanes = itertools.product(("lines", "rings"), np.arange(0, 5.5, 0.5), np.arange(8, 10.25, 0.25))
    found = []
    for pattern, border_m, apart_m in lanes:
        turns = (0.0, math.pi / 2) if pattern == "lines" else (0.0,)
        for angle, along_obstacles, along_border in itertools.product(turns, (False, True), (False, True)):
            found.append(
                {
                    "pattern": pattern,
                    "distanceToBorder": float(border_m),
                    "offset": float(apart_m),
                    "angle": angle,
                    "mowArea": True,
                    "mowBorder": along_border,
                    "borderLaps": int(along_border),
                    "mowExclusionsBorder": along_obstacles,
                    "mowExclusionsBoder": along_obstacles,  # the name under which the package reads it
                    "exclusionsBorderLaps": int(along_obstacles),
                }
            )
    return found


def peer_rows(folder: Path) -> Iterator[Row]:
    """The shortest of the peer's paths that see everything, and the shortest that nearly do."""
    name = "the same, coverage-path-planner: open path, best of {} settings"
    settings = peer_settings()
    found = peer_paths(folder, settings)
    if isinstance(found, str):
        yield Row(name.format(len(settings)), "", f"not measured: {found}", None)
        return
    seconds = sum(path["seconds"] for path in found["paths"])
    for least in (1.0, NEARLY):
        best = shortest_that_sees([np.array(path["points"]) for path in found["paths"]], least)
        told_share = f"at least {100 * least:.0f} % seen"
        measured = f"none of {told_share}"
        if best is not None:
            measured = f"{best.length_m:,.0f} m, {100 * best.seen_share:.2f} % seen"
        version = found["version"]
        yield Row(
            f"{name.format(len(settings))}, {told_share}",
            "",
            f"{measured}; all in {seconds:.1f} s; version {version}",
            None,
        )


def shortest_that_sees(routes_m: list[np.ndarray], least: float) -> Loop | None:
    """The shortest route of which the check shows that it sees at least this share and stays inside."""
    free = ground().area.difference(shapely.union_all([shapely.box(*block) for block in BLOCKS]))
    lines = [shapely.LineString(route) for route in routes_m if len(route) > 1]
    for line in sorted(lines, key=lambda line: line.length):
        # a disc along the route, through walls and all, is more than it sees: no need to judge what even that misses
        most = line.buffer(1.001 * RADIUS_M, quad_segs=64).intersection(free).area / free.area
        if most < least - 1e-6:
            continue
        loop = judged(shapely.get_coordinates(line))
        if loop.stays_inside and (loop.sees_all if least == 1 else loop.seen_share >= least):
            return loop
    return None


def peer_paths(folder: Path, settings: list[dict[str, Any]]) -> dict[str, Any] | str:
    """What ``peer_paths.py`` prints, from an environment made for it in ``folder``; or why there is none."""
    rings = [[list(corner) for corner in shapely.box(*block).exterior.coords[:-1]] for block in BLOCKS]
    square = [[0, 0], [SIDE_M, 0], [SIDE_M, SIDE_M], [0, SIDE_M]]
    problem = {"area": square, "obstacles": rings, "start": [0, 0], "settings": settings}
    return peer_answer(folder, PEER, "peer_paths.py", problem)
