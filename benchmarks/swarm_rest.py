"""Whether swarms rest, and cover, where steps are short, news late, robots too many, or a door hardly wider."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from shapely import MultiPolygon, box

from benchmarks.row import Options, Row
from benchmarks.swarm_coverage import mission
from rota.model.mission import DiscSensor, Mission, Obstacle, StartBox
from rota.planners.swarm.metrics import covered_share
from rota.planners.swarm.planner import SwarmRun, run_mission
from rota.planners.swarm.planner_settings import SwarmSettings

SHARES = np.geomspace(1e-4, 0.1, 10)  # of the sensor's radius that a robot drives in a step
DELAYS, LEAST_OF_PROMPT = (1, 2), 0.95
SIDE, APART_M, AREA_M, SENSOR_M, BODY_M, TIME_STEP_S = 5, 4.0, 100.0, 10.0, 0.2, 0.25
MANY, CROWD_SENSOR_M, SEEDS = (60, 100), 20.0, range(5)
DOOR_ROBOTS, WIDER_M, ROOM_M = 12, 0.1, 10.0  # a room of 10 m x 20 m, and 30 m x 20 m beyond the door
DIAMETERS_M = (0.3, 0.4, 0.6, 1.0)


def swarm_rest(options: Options) -> Iterator[Row]:
    """The controller by default."""
    yield late_row()
    for robots in MANY:
        start = StartBox(low_m=(2, 2), high_m=(58, 58))
        asked = like(mission(robots, (60, 60), start, 6000), CROWD_SENSOR_M, 2.0, 0.5)
        runs = [run_mission(asked, seed=seed) for seed in SEEDS]
        rest, steps = sum(run.at_rest for run in runs), [run.steps for run in runs]
        name = f"swarm, {robots} robots with discs of 20 m in 60 m x 60 m, seeds 0 to {len(SEEDS) - 1}"
        measured = f"{rest} of {len(runs)} at rest, after {min(steps):,} to {max(steps):,} steps"
        yield Row(name, f"{len(runs)} of {len(runs)} at rest", measured, rest == len(runs))
    passed = [
        int((places_of(run_mission(door(diameter_m), seed=seed))[:, 0] > ROOM_M).sum())
        for diameter_m in DIAMETERS_M
        for seed in SEEDS
    ]
    yield Row(
        f"swarm, {DOOR_ROBOTS} robots of 0.3 m to 1 m in a quarter of the ground, a door {WIDER_M} m wider",
        f"{DOOR_ROBOTS // 2} pass in each of {len(passed)} runs",
        f"{min(passed)} to {max(passed)} pass",
        min(passed) >= DOOR_ROBOTS // 2,
    )
    yield blocked_row()


def blocked_row() -> Row:
    """In how many runs robots are told as blocked: behind one that stands in the door, and with nobody in the way."""
    behind = [is_blocked(gated(diameter_m), seed) for diameter_m in DIAMETERS_M for seed in SEEDS]
    free = [
        is_blocked(door(diameter_m, wider_m), seed)
        for diameter_m in DIAMETERS_M
        for wider_m in (WIDER_M, -diameter_m)
        for seed in SEEDS
    ]
    return Row(
        f"swarm, blocked robots told: {len(behind)} runs with one in the door, {len(free)} with nobody, or no door",
        "all; none",
        f"{sum(behind)}; {sum(free)}",
        all(behind) and not any(free),
    )


def is_blocked(asked: Mission, seed: int) -> bool:
    """Whether a run ends with robots that are told as blocked."""
    end = run_mission(asked, seed=seed).plan.run_end
    return end is not None and end.reason == "blocked"


def late_row() -> Row:
    """25 robots by steps of all lengths: what they cover with late news, as a share of that with prompt ones."""
    least, at_rest, runs = np.inf, 0, 0
    for share in SHARES.tolist():
        prompt = covered(run_mission(grid(share, 0), seed=0))
        for delay in DELAYS:
            run = run_mission(grid(share, delay), seed=0)
            least, at_rest, runs = min(least, covered(run) / prompt), at_rest + run.at_rest, runs + 1
    return Row(
        f"swarm, 25 robots with news 1 and 2 steps late, steps of {SHARES[0]:g} to {SHARES[-1]:g} R",
        f"each at least {LEAST_OF_PROMPT:.0%} of what prompt news cover, told at rest",
        f"worst {least:.1%}; {at_rest} of {runs} at rest",
        least >= LEAST_OF_PROMPT and at_rest == runs,
    )


def grid(share: float, delay_steps: int) -> Mission:
    """25 robots in a grid in the middle of a square that their discs could cover by 78.5 %."""
    asked = mission(SIDE * SIDE, (AREA_M, AREA_M), StartBox(low_m=(0, 0), high_m=(AREA_M, AREA_M)), 1)
    asked = like(asked, SENSOR_M, share * SENSOR_M / TIME_STEP_S, BODY_M)
    offsets = (np.arange(SIDE * SIDE)[:, None] // (1, SIDE) % SIDE - (SIDE - 1) / 2) * APART_M + AREA_M / 2
    robots = tuple(
        replace(robot, start=(float(x), float(y)))
        for robot, (x, y) in zip(asked.fleet.robots or (), offsets, strict=True)
    )
    settings = SwarmSettings(delay_steps=delay_steps, time_step_s=TIME_STEP_S, most_steps=20_000 + int(40 / share))
    return replace(asked, fleet=replace(asked.fleet, robots=robots, start=None), planning=settings)


def gated(diameter_m: float) -> Mission:
    """The same, with one of them that stands in the door and takes part no more."""
    asked = door(diameter_m)
    first, *others = asked.fleet.robots or ()
    gate = replace(first, start=(ROOM_M + 0.1, 10.0), leaves_s=TIME_STEP_S)
    return replace(asked, fleet=replace(asked.fleet, robots=(gate, *others)))


def door(diameter_m: float, wider_m: float = WIDER_M) -> Mission:
    """Robots in a room with a door that is wider than they are by so much; none where it has no width."""
    half = (diameter_m + wider_m) / 2
    walls = (box(ROOM_M, 0, ROOM_M + 0.2, 10 - half), box(ROOM_M, 10 + half, ROOM_M + 0.2, 20))
    asked = mission(DOOR_ROBOTS, (40, 20), StartBox(low_m=(1, 5), high_m=(9, 15)), 6000)
    obstacles = tuple(Obstacle(shape=MultiPolygon([wall])) for wall in walls)
    return replace(like(asked, 5.0, 1.0, diameter_m / 2), obstacles=obstacles)


def like(asked: Mission, sensor_m: float, speed_m_s: float, body_m: float) -> Mission:
    """The mission with robots of this kind."""
    what = {"sensor": DiscSensor(radius_m=sensor_m), "speed_m_s": speed_m_s, "body_radius_m": body_m}
    robots = tuple(replace(robot, **what) for robot in asked.fleet.robots or ())  # type: ignore[arg-type]
    return replace(asked, fleet=replace(asked.fleet, robots=robots, **what))  # type: ignore[arg-type]


def covered(run: SwarmRun) -> float:
    """The share of the area in range in the end."""
    return covered_share(places_of(run), np.full(SIDE * SIDE, SENSOR_M), run.plan.mission.area)


def places_of(run: SwarmRun) -> np.ndarray:
    """(n, 2): where the robots hold."""
    return np.array([trajectory.positions_m[-1] for trajectory in run.plan])
