"""Starts from which swarms could jam or tremble: heaps in corners, a hangar, rooms with doors; exact news and late."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from shapely import MultiPolygon, box, get_parts, union_all

from benchmarks.missions import EXAMPLES
from benchmarks.row import Options, Row
from benchmarks.swarm_coverage import mission
from rota.files.mission_file import read_mission
from rota.geometry.free_space import free_ground
from rota.model.mission import DiscSensor, Mission, Obstacle, StartBox
from rota.planners.swarm.metrics import covered_share
from rota.planners.swarm.planner import run_mission
from rota.planners.swarm.planner_settings import SwarmSettings

SEEDS = range(100, 103)  # none of which anything was tuned on
HEAPS = ((49, 10.0), (49, 15.0), (49, 20.0), (49, 30.0), (49, 50.0), (100, 50.0))  # robots, side of the corner box
SIDE_PER_ROBOT_M = 50.0  # of the area, times the root of the robots: discs can cover 78.5 %
MOST_STEPS = 6000
HANGAR = StartBox(low_m=(2.0, 2.0), high_m=(32.0, 32.0))
ROOMS_M, WALL_M, DOOR_M, ROOM_ROBOTS, ROOM_SENSOR_M = 100.0, 0.5, 1.5, 36, 10.0


def swarm_jams(options: Options) -> Iterator[Row]:
    """The controller by default, with all else by default but the delay."""
    for delay, mean, worst in ((0, 0.78, 0.77), (1, 0.77, 0.77), (2, 0.77, 0.77)):
        news = ("", ", a step late", ", two steps late")[delay]
        for robots, side_m in HEAPS:
            name = f"swarm, {robots} robots from a corner box of {side_m:.0f} m{news}"
            yield row(name, heap(robots, side_m, delay), mean, worst)
    yield row("swarm, 60 robots round the port's buildings, from a hangar of 30 m", port(), 0.87, 0.0)
    for delay, news in ((0, ""), (1, ", a step late")):
        name = f"swarm, 36 robots from one of 4 rooms, doors of 1.5 m{news}"
        yield row(name, rooms(delay), 0.9, 0.0)


def row(name: str, asked: Mission, least_mean: float, least_worst: float) -> Row:
    """Run a mission with each seed; shares are of the ground, and of the most possible where discs exceed it."""
    ground, shares, steps, rest = free_ground(asked), [], [], 0
    sensors = np.array([robot.sensor.reach_m for robot in asked.fleet.robots or ()])
    for seed in SEEDS:
        run = run_mission(asked, seed=seed)
        places = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
        shares.append(covered_share(places, sensors, ground))
        steps.append(run.steps)
        rest += run.at_rest
    mean, worst = statistics.mean(shares), min(shares)
    least = f", worst {least_worst:.0%}" if least_worst else ""
    most = min(1.0, float((math.pi * sensors**2).sum()) / ground.area)
    return Row(
        f"{name}, seeds {SEEDS[0]} to {SEEDS[-1]}",
        f"mean {least_mean:.0%}{least}, all at rest",
        f"{mean:.2%}, worst {worst:.2%}, of {most:.1%} at most; {rest} of {len(SEEDS)} at rest, after {min(steps):,} to"
        f" {max(steps):,} steps",
        mean >= least_mean and worst >= least_worst and rest == len(SEEDS),
    )


def heap(robots: int, side_m: float, delay_steps: int) -> Mission:
    """Robots as in Table 2 of Chen et al. 2018, at its density, from a box in the corner."""
    area_m = SIDE_PER_ROBOT_M * math.sqrt(robots)
    start = StartBox(low_m=(1.0, 1.0), high_m=(1.0 + side_m, 1.0 + side_m))
    return late(mission(robots, (area_m, area_m), start, MOST_STEPS), delay_steps)


def port() -> Mission:
    """The example's robots, all in a hangar."""
    asked = read_mission(EXAMPLES / "swarm-port.yaml").mission
    return replace(asked, fleet=replace(asked.fleet, start=HANGAR))


def rooms(delay_steps: int) -> Mission:
    """Four rooms round a crossing of walls, a door in each; discs of 10 m could cover a tenth more than there is."""
    half, ends = WALL_M / 2, [0.0, 0.25 * ROOMS_M, 0.75 * ROOMS_M, ROOMS_M]
    walls = []
    for begin, end in pairwise(ends):
        low, high = begin + DOOR_M / 2 * (begin > 0), end - DOOR_M / 2 * (end < ROOMS_M)
        walls += [box(ROOMS_M / 2 - half, low, ROOMS_M / 2 + half, high)]
        walls += [box(low, ROOMS_M / 2 - half, high, ROOMS_M / 2 + half)]
    start = StartBox(low_m=(1.0, 1.0), high_m=(ROOMS_M / 2 - 1.0, ROOMS_M / 2 - 1.0))
    like = mission(ROOM_ROBOTS, (ROOMS_M, ROOMS_M), start, MOST_STEPS)
    sensor = DiscSensor(radius_m=ROOM_SENSOR_M)
    robots = tuple(replace(robot, sensor=sensor) for robot in like.fleet.robots or ())
    obstacles = tuple(Obstacle(shape=MultiPolygon([wall])) for wall in get_parts(union_all(walls)))
    return late(
        replace(like, obstacles=obstacles, fleet=replace(like.fleet, sensor=sensor, robots=robots)), delay_steps
    )


def late(asked: Mission, delay_steps: int) -> Mission:
    """The same mission, with news of others that many steps old."""
    return replace(asked, planning=replace(SwarmSettings.of(asked), delay_steps=delay_steps))
