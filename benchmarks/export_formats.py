"""What a plan of 100,000 timed points costs to export, in each format that takes it."""

from __future__ import annotations

import statistics
from collections.abc import Iterator

import numpy as np
from shapely import box

from benchmarks.row import Options, Row
from benchmarks.shell import rota
from benchmarks.warm_cache import measured_warm
from rota.exports import FORMATS
from rota.files.plan_file import write_plan
from rota.model.mission import DiscSensor, Fleet, GeoPoint, Mission, Obstacle, Robot
from rota.model.plan import Plan, Trajectory

ROBOTS, POINTS, MOST_S = 20, 100_000, 5.0
NOT_FOR_IT = ("create2-sketch",)  # takes plans of bouncing robots


def export_formats(options: Options) -> Iterator[Row]:
    """Processor time of `rota export` from the shell, start-up and reading the plan included."""
    plan_file = options.folder / "wound.rota.json"
    write_plan(wound_loops(), plan_file)
    for name in FORMATS:
        if name in NOT_FOR_IT:
            continue
        target = options.folder / ("wound.bag" if name == "rosbag1" else f"wound-{name}")
        runs = measured_warm(lambda n=name, t=target: rota("export", plan_file, "--to", n, "-o", t), lambda r: r.cpu_s)
        cpu_s = statistics.median(run.cpu_s for run in runs)
        failed = [run.failure() for run in runs if run.code]
        measured = failed[0] if failed else f"{cpu_s:.1f} s of CPU"
        what = f"{ROBOTS} robots with {POINTS:,} timed points, export --to {name}"
        yield Row(what, f"< {MOST_S:g} s", measured, not failed and cpu_s < MOST_S)


def wound_loops() -> Plan:
    """Robots on Lissajous figures beside each other, 5,000 points each, at up to 5 m/s."""
    fleet = Fleet(
        speed_m_s=5,
        sensor=DiscSensor(radius_m=40),
        robots=tuple(Robot(name=f"robot-{k + 1}", speed_m_s=5, sensor=DiscSensor(radius_m=40)) for k in range(ROBOTS)),
    )
    mission = Mission(
        name="wound loops",
        area=box(-100, -100, 1000, 800),
        obstacles=(Obstacle(shape=box(140, 140, 160, 160)),),
        period_s=4000,
        fleet=fleet,
        origin=GeoPoint(lat=48.1, lon=11.5),
    )
    phase = np.linspace(0, 2 * np.pi, POINTS // ROBOTS)
    figure_m = 60 * np.column_stack([np.cos(7 * phase), np.sin(11 * phase)])
    figure_m[-1] = figure_m[0]
    times_s = np.append(0.0, np.cumsum(np.hypot(*np.diff(figure_m, axis=0).T) / 5 * (1 + 1e-9)))
    middles = [np.array([50 + k % 5 * 200, 50 + k // 5 * 200]) for k in range(ROBOTS)]
    ways = tuple(
        Trajectory(robot=robot.name, times_s=times_s, positions_m=middle + figure_m)
        for robot, middle in zip(fleet.robots or (), middles, strict=True)
    )
    return Plan(mission=mission, trajectories=ways)
