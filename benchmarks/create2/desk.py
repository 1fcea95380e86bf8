"""The sketches of a plan, driven on the desk: an Uno and a Create 2 per robot, in one map and one time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from benchmarks.create2.robot import BOOT_TICKS, TICK_US, Create2, Faults
from benchmarks.create2.uno import Uno, build_sketch, simulator
from rota.files.create2_legs import Drive, drives_of
from rota.files.create2_sketch import write_create2_sketches
from rota.model.plan import Plan

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Desk:
    """The sketches of a plan, compiled, and the simulator that runs them."""

    plan: Plan
    drives: tuple[Drive, ...]
    firmware: tuple[Path, ...]
    simulator: Path


@dataclass(frozen=True, kw_only=True, eq=False)
class Driven:
    """What a robot did: (n,) times on the plan's clock, (n, 2) places, (n,) headings, one for each tick.

    ``turns`` (n,): how many turns in place it had begun by then. ``began_s``: when the plan's clock showed 0, seconds
    after all were switched on.
    """

    times_s: Floats
    places_m: Floats
    headings_rad: Floats
    turns: NDArray[np.int64]
    began_s: float


def set_up(plan: Plan, folder: Path) -> Desk:
    """Write and compile everything in ``folder``."""
    sketches = write_create2_sketches(plan, folder / "sketches")
    firmware = tuple(map(build_sketch, sketches))
    return Desk(plan=plan, drives=drives_of(plan), firmware=firmware, simulator=simulator())


def drive(
    desk: Desk,
    duration_s: float,
    faults: Faults | None = None,
    on_tick: Callable[[float, list[Create2]], None] | None = None,
    *,
    rates: Sequence[float] | None = None,
    signal: Callable[[float], bool] = lambda _: False,
) -> list[Driven]:
    """Let all robots drive for so long on the plan's clock. on_tick: called at each tick with this clock's time.

    rates: of the clocks of the Unos. signal: whether the common pulse is there, by seconds since the switching on.
    """
    robots = robots_of(desk, faults or Faults())
    begin_s = [math.inf] * len(robots)  # of the plan's clock, on the simulation's
    rows: list[list[tuple[float, ...]]] = [[] for _ in robots]
    tick, frames = 0, [b""] * len(robots)
    with ExitStack() as stack:
        unos = [
            stack.enter_context(closing(Uno(desk.simulator, firmware, rate)))
            for firmware, rate in zip(desk.firmware, rates or [1.0] * len(desk.firmware), strict=True)
        ]
        while tick * TICK_US / 1e6 < max(begin_s, default=0.0) + duration_s:
            if not tick < 10 * BOOT_TICKS + duration_s * 1e6 / TICK_US:
                raise RuntimeError("a robot has not begun to move")
            now_s = tick * TICK_US / 1e6
            sent = [
                (byte.at_us, number, byte.byte)
                for number, uno in enumerate(unos)
                for byte in uno.run(TICK_US, frames[number], signal=signal(now_s))
            ]
            _move_all(robots, sorted(sent))
            tick += 1
            for number, robot in enumerate(robots):
                if math.isinf(begin_s[number]) and (robot.right_m_s or robot.left_m_s):
                    begin_s[number] = now_s - desk.drives[number].first_s
                rows[number].append((now_s + TICK_US / 1e6, robot.x_m, robot.y_m, robot.heading_rad, robot.turns))
            frames = [robot.frame() for robot in robots]
            if on_tick is not None:
                on_tick(now_s - begin_s[0], robots)
    return [_driven(np.array(row), begin) for row, begin in zip(rows, begin_s, strict=True)]


def _driven(rows: Floats, begin_s: float) -> Driven:
    return Driven(
        times_s=rows[:, 0] - begin_s,
        places_m=rows[:, 1:3],
        headings_rad=rows[:, 3],
        turns=rows[:, 4].astype(np.int64),
        began_s=begin_s,
    )


def robots_of(desk: Desk, faults: Faults) -> list[Create2]:
    """The robots, put down where their plan begins."""
    mission = desk.plan.mission
    blocking = shapely.union_all([o.shape for o in mission.obstacles if o.blocks_motion])
    walls = mission.area.difference(blocking).boundary
    robots = []
    for number, plan_drive in enumerate(desk.drives):
        x, y = plan_drive.legs[0].start_m
        own = replace(faults, seed=faults.seed * 1000 + number)
        robots.append(Create2(x_m=x, y_m=y, heading_rad=plan_drive.legs[0].heading_rad, walls=walls, faults=own))
    for robot in robots:
        robot.others = [other for other in robots if other is not robot]
    return robots


def _move_all(robots: list[Create2], sent: list[tuple[int, int, int]]) -> None:
    """One tick: everybody moves from one byte that anybody gets to the next."""
    at_us = 0
    for byte_us, number, byte in [*sent, (TICK_US, -1, 0)]:
        if byte_us > at_us:
            for robot in robots:
                robot.advance((byte_us - at_us) / 1e6)
            at_us = byte_us
        if number >= 0:
            robots[number].receive(byte)


def off_plan_m(desk: Desk, number: int, driven: Driven) -> tuple[Floats, Floats]:
    """When legs begin on the plan's clock, as far as it was driven, and how far from the planned places the robot is.

    The first leg's beginning is left out: there it was put down.
    """
    starts_s, places_m = leg_starts(desk.drives[number], float(driven.times_s[-1]))
    ticks = np.searchsorted(driven.times_s, starts_s)
    return starts_s, np.linalg.norm(driven.places_m[ticks] - places_m, axis=1)


def leg_starts(plan_drive: Drive, until_s: float) -> tuple[Floats, Floats]:
    """Times (n,) and places (n, 2) at which a robot's legs begin, after the first, before ``until_s``."""
    legs, loop_from = plan_drive.legs, plan_drive.loop_from
    times, places, number, rounds_s = [], [], 0, 0.0
    while True:
        begins_s = legs[number].next_s + rounds_s
        number += 1
        if number == len(legs):
            if loop_from is None:
                break
            number, rounds_s = loop_from, rounds_s + plan_drive.loop_s
        if begins_s >= until_s:
            break
        times.append(begins_s)
        places.append(legs[number].start_m)
    return np.array(times), np.array(places).reshape(-1, 2)
