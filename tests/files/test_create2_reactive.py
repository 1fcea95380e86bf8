"""The program that turns at every bump, as text and in the simulator of the chip, beside a model of the robot."""

from __future__ import annotations

import itertools
import math
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from benchmarks.create2.plans import TypedMap, bounced_plan
from benchmarks.create2.robot import TICK_US, Create2
from benchmarks.create2.uno import Uno, build_sketch, missing_tools, simulator
from shapely import LinearRing, box

from rota.export_create2 import covering_time
from rota.exports import FORMATS
from rota.files.create2_reactive import program_texts, write_create2_programs
from rota.model.plan import Plan

ROOM = TypedMap(rows=("....", "....", "...."), cell_m=0.5)
needs_tools = pytest.mark.skipif(bool(missing_tools()), reason=f"missing: {missing_tools()}")


def room_plan() -> Plan:
    return bounced_plan(ROOM, ((0, 1, 0),), turn=3, speed_m_s=0.2)


def test_it_knows_an_angle_and_how_long_covering_takes() -> None:
    (text,) = program_texts(room_plan(), covers="all in a minute")
    assert "// Turns:   135 degrees at every bump" in text
    assert "// Covers:  all in a minute" in text
    assert "const int16_t ANGLE_TENTHS = 1350;" in text
    # a diagonal of 2.5 m at 0.2 m/s, and half as long again
    assert "const uint32_t LONGEST_MS = 18750;" in text
    assert "@" not in text
    assert "LEGS" not in text
    assert max(map(len, text.splitlines())) <= 120


def test_how_long_covering_takes_is_told_in_quantiles(tmp_path: Path) -> None:
    told = covering_time(room_plan())
    assert told is not None
    assert told.startswith("all 12 cells entered after ")
    assert "s in 10 / 50 / 90 % of 400 simulated runs, turns off by up to 1 degrees" in told
    times = told.split(" after ")[1].split(" s in")[0].replace("later than ", "").replace(",", "").split(" / ")
    assert sorted(map(float, times)) == list(map(float, times))
    export = FORMATS["create2-reactive"]
    assert export.folder is not None
    (path,) = export.folder(room_plan(), str(tmp_path / "out"))
    assert f"// Covers:  {told}" in path.read_text()


def run(plan: Plan, folder: Path, seconds: float, opens_s: float = math.inf) -> np.ndarray:  # type: ignore[type-arg]
    """(n, 3) x, y, heading of the robot at each tick; after opens_s the walls are gone."""
    (sketch,) = write_create2_programs(plan, folder / "sketches", covers="")
    robot = Create2(x_m=0.25, y_m=0.75, heading_rad=0.0, walls=LinearRing(box(0, 0, 2, 1.5).exterior.coords))
    rows, frame = [], b""
    with closing(Uno(simulator(), build_sketch(sketch))) as uno:
        for tick in range(int(seconds * 1e6 / TICK_US)):
            if tick * TICK_US / 1e6 > opens_s:
                robot.walls = LinearRing(box(-90, -90, 90, 90).exterior.coords)
            at_us = 0
            for byte in uno.run(TICK_US, frame):
                robot.advance((byte.at_us - at_us) / 1e6)
                at_us = byte.at_us
                robot.receive(byte.byte)
            robot.advance((TICK_US - at_us) / 1e6)
            frame = robot.frame()
            rows.append((robot.x_m, robot.y_m, robot.heading_rad))
    return np.array(rows)


@needs_tools
def test_it_turns_by_its_angle_at_every_bump(tmp_path: Path) -> None:
    """From the middle of the west end along the room: at the east wall to the north-west, then south."""
    rows = run(room_plan(), tmp_path, 32.0)
    turned = np.round(np.degrees(rows[:, 2])) % 360
    steady = [value for k, value in enumerate(turned[1:], 1) if value == turned[k - 1]]
    ways = [value for k, value in enumerate(steady) if k == 0 or value != steady[k - 1]]
    assert np.allclose([(later - now) % 360 for now, later in itertools.pairwise(ways)], 135, atol=1)
    assert len(ways) >= 3
    assert rows[:, 0].max() == pytest.approx(2 - 0.17, abs=1e-3)


@needs_tools
def test_it_stops_where_no_wall_comes(tmp_path: Path) -> None:
    rows = run(room_plan(), tmp_path, 34.0, opens_s=6.0)
    assert (rows[-60:] == rows[-1]).all()
    assert np.hypot(*(rows[-1, :2] - rows[0, :2])) < 18.75 * 0.2 + 0.05
