"""Sketches as text, and for real: compiled, run in simavr, with a model of the robot on their serial port."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmarks.create2.desk import Desk, Driven, drive, off_plan_m, set_up
from benchmarks.create2.plans import TypedMap, bounced_plan
from benchmarks.create2.robot import Create2, Faults
from benchmarks.create2.uno import build_sketch, flash_bytes, missing_tools
from shapely import LineString, Point, union_all

from rota.errors import PlanError, RotaError
from rota.files import create2_sketch
from rota.files.create2_legs import drives_of
from rota.files.create2_sketch import sketch_texts, write_create2_sketches
from rota.files.mission_file import read_mission
from rota.model.plan import Plan
from rota.planning.make_plan import make_plan

HALL = TypedMap(rows=(".....", ".....", "..#..", "....."), cell_m=0.5)
CLOSET = """
rota: 1
name: closet
area:
  text: |
    .....
    .#...
    .....
  cell_m: 0.5
zones: [{name: shelf, period_s: 200, demand: visit, ring: [[0, 0], [0.5, 0], [0.5, 0.5], [0, 0.5]]}]
fleet:
  robots: 1
  speed_m_s: 0.2
  sensor: {shape: disc, radius_m: 0.25}
  body_radius_m: 0.17
planner: bounce
bounce: {task: monitor, bouncing_angles_deg: [135]}
"""
ROOM = TypedMap(rows=("....", "....", "...."), cell_m=0.5)
CORRIDOR = TypedMap(rows=("......",), cell_m=0.5)
needs_tools = pytest.mark.skipif(
    bool(missing_tools()), reason=f"apt install gcc gcc-avr avr-libc arduino-core-avr libsimavr-dev: {missing_tools()}"
)


def hall_plan() -> Plan:
    """One robot: a way in of 9 legs, then 8 for ever, at 135 degrees."""
    return bounced_plan(HALL, ((0, 1, 0),), turn=3, speed_m_s=0.22)


def corridor_plan() -> Plan:
    """Two robots that meet in the middle, turn round, turn at the walls, and meet again."""
    return bounced_plan(CORRIDOR, ((0, 0, 0), (5, 0, 4)), turn=4, speed_m_s=0.15, headings=4)


def test_the_sketch_tells_where_to_begin_and_what_to_do() -> None:
    (text,) = sketch_texts(bounced_plan(HALL, ((0, 0, 0),), turn=2, speed_m_s=0.2, headings=4))
    assert "// robot-1: bouncing on a desk" in text
    assert "x = 0.250 m, y = 0.250 m, facing 0 degrees" in text
    # all legs drive 0.2 m/s, back off 80 mm and turn by 90 degrees; the first bumps after 2.08 m
    assert "const Kind KINDS[] PROGMEM = {\n  { 200,  80,   900, 1 },  // 0\n};" in text
    assert "{   0,  10400,  12500 },  // 0: from (0.25, 0.25) 2.00 m towards 0" in text
    assert "4 legs; those from 0 on for ever, 45.0 s a round" in text
    assert "const uint32_t LOOP_MS = 45000;" in text
    assert "const uint16_t LOOP_REST = 0;" in text
    assert "@" not in text
    assert max(map(len, text.splitlines())) <= 120


def test_each_robot_has_a_folder_as_the_arduino_ide_wants_it(tmp_path: Path) -> None:
    paths = write_create2_sketches(corridor_plan(), tmp_path / "out")
    assert [str(path.relative_to(tmp_path)) for path in paths] == [
        "out/robot-1/robot-1.ino", "out/robot-2/robot-2.ino",
    ]  # fmt: skip
    assert "robot-2; all must begin at the same moment" in paths[0].read_text()


def test_names_become_harmless(tmp_path: Path) -> None:
    plan = corridor_plan()
    named = tuple(
        replace(robot, name=name)
        for robot, name in zip(plan.mission.fleet.robots or (), ("../a b\\", "x\\int main"), strict=True)
    )
    trajectories = tuple(replace(t, robot=r.name) for t, r in zip(plan.trajectories, named, strict=True))
    mission = replace(plan.mission, fleet=replace(plan.mission.fleet, robots=named))
    paths = write_create2_sketches(replace(plan, mission=mission, trajectories=trajectories), tmp_path)
    assert [path.name for path in paths] == ["a_b.ino", "x_int_main.ino"]
    first_lines = [path.read_text().splitlines()[:2] for path in paths]
    assert first_lines == [["// ../a b_: bouncing on a desk", "//"], ["// x_int main: bouncing on a desk", "//"]]


def test_names_that_give_one_file_are_refused(tmp_path: Path) -> None:
    plan = corridor_plan()
    named = tuple(
        replace(robot, name=name) for robot, name in zip(plan.mission.fleet.robots or (), ("a b", "A?b"), strict=True)
    )
    trajectories = tuple(replace(t, robot=r.name) for t, r in zip(plan.trajectories, named, strict=True))
    mission = replace(plan.mission, fleet=replace(plan.mission.fleet, robots=named))
    with pytest.raises(PlanError, match=r"robot A\?b: another robot's file is called A_b.ino"):
        write_create2_sketches(replace(plan, mission=mission, trajectories=trajectories), tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_a_folder_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    with pytest.raises(RotaError, match="taken"):
        write_create2_sketches(corridor_plan(), tmp_path / "taken")


def test_a_way_too_long_for_an_uno_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(create2_sketch, "MOST_BYTES", 150)
    with pytest.raises(
        PlanError, match=r"its way has 17 legs, which take 1\d\d bytes; an Arduino Uno has room for 150"
    ):
        sketch_texts(hall_plan())


def test_rounds_of_all_robots_keep_together_to_a_millionth_of_a_millisecond() -> None:
    """A round of 14 steps of 0.5 m at 0.23 m/s is 30434.7826... ms: what is left over adds up."""
    (text,) = sketch_texts(bounced_plan(ROOM, ((0, 0, 0),), turn=2, speed_m_s=0.23, headings=4))
    (drive_of,) = drives_of(bounced_plan(ROOM, ((0, 0, 0),), turn=2, speed_m_s=0.23, headings=4))
    loop_ms, rest = (int(text.split(f"{name} = ")[1].split(";")[0]) for name in ("LOOP_MS", "LOOP_REST"))
    assert loop_ms + rest / 65536 == pytest.approx(drive_of.loop_s * 1e3, abs=1e-5)
    lasts_ms = [int(line.split(",")[2].split("}")[0]) for line in text.splitlines() if " m towards " in line]
    assert sum(lasts_ms) == loop_ms


# ---------------------------------------------------------------- for real


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> Desk:
    return set_up(hall_plan(), tmp_path_factory.mktemp("hall"))


@needs_tools
def test_the_way_driven_is_the_way_planned(hall: Desk) -> None:
    """Eight legs, straight and diagonal: at every turn the robot is within 5 mm of the planned place, and on time."""
    (driven,) = drive(hall, 62.0)
    starts_s, off_m = off_plan_m(hall, 0, driven)
    assert len(starts_s) == 8
    assert off_m.max() < 0.005
    legs = hall.drives[0].legs[1 : len(starts_s) + 1]
    headings = driven.headings_rad[np.searchsorted(driven.times_s, starts_s)]
    off_rad = [math.remainder(h - leg.heading_rad, math.tau) for h, leg in zip(headings, legs, strict=False)]
    assert np.abs(off_rad).max() < math.radians(0.5)
    assert driven.turns[-1] == len(starts_s)


@pytest.mark.slow  # simulates two chips
@needs_tools
def test_robots_that_meet_as_planned_go_on_as_planned(tmp_path: Path) -> None:
    desk = set_up(corridor_plan(), tmp_path)
    for number, driven in enumerate(drive(desk, 25.0)):
        starts_s, off_m = off_plan_m(desk, number, driven)
        assert len(starts_s) == 2  # each other, then the wall
        assert off_m.max() < 0.01


@needs_tools
def test_a_plan_of_the_planner_is_driven_as_planned(tmp_path: Path) -> None:
    """Waits, contacts and turns as the planner makes them, not as this file does."""
    mission = tmp_path / "closet.yaml"
    mission.write_text(CLOSET)
    desk = set_up(make_plan(read_mission(mission).mission), tmp_path)
    (driven,) = drive(desk, 50.0)
    starts_s, off_m = off_plan_m(desk, 0, driven)
    assert len(starts_s) >= 2
    assert off_m.max() < 0.005


@needs_tools
def test_late_bumps_and_inexact_turns_lead_astray(hall: Desk) -> None:
    """They must show: a model in which nothing goes wrong would prove nothing."""
    (driven,) = drive(hall, 36.0, Faults(late_bump_s=0.1, turn_error=0.05, slides=True, seed=1))
    off_m = off_plan_m(hall, 0, driven)[1]
    assert off_m.max() > 0.02
    assert driven.turns[-1] >= 3  # but it bounces on, until it is lost


def still_after(driven: Driven, time_s: float) -> bool:
    """Whether the robot stands for good from then on, on the plan's clock."""
    after = driven.places_m[driven.times_s > time_s]
    return len(after) > 1 and bool((after == after[0]).all())


@needs_tools
def test_an_open_door_leaves_it_lost_and_it_stops(hall: Desk) -> None:
    """Without walls nothing ends a leg: 0.1 m and a twentieth of the way beyond the bump it stops for good."""
    leg = hall.drives[0].legs[0]

    def walls_gone(_: float, robots: list[Create2]) -> None:
        robots[0].walls = LineString([(90, 90), (91, 90)])

    (driven,) = drive(hall, 30.0, on_tick=walls_gone)
    gone_m = float(np.linalg.norm(driven.places_m[-1] - driven.places_m[0]))
    due_m = leg.length_m + leg.ahead_m
    assert due_m < gone_m < due_m * 1.05 + 0.1 + 0.02
    assert still_after(driven, 25.0)


@needs_tools
def test_a_post_in_the_way_leaves_it_lost_and_it_stops(hall: Desk) -> None:
    """It stands halfway along the first leg: the bump comes a metre early."""
    leg = hall.drives[0].legs[0]
    ahead = np.array([math.cos(leg.heading_rad), math.sin(leg.heading_rad)])

    def post(_: float, robots: list[Create2]) -> None:
        middle = leg.start_m + ahead * (leg.length_m / 2 + 0.17)
        walls = union_all([robots[0].walls, Point(middle).buffer(0.01).exterior])
        if robots[0].ticks <= 1:
            robots[0].walls = walls

    (driven,) = drive(hall, 20.0, on_tick=post)
    assert np.linalg.norm(driven.places_m[-1] - driven.places_m[0]) < leg.length_m / 2
    assert driven.turns[-1] == 0
    assert still_after(driven, 15.0)


@needs_tools
@pytest.mark.parametrize("what", ["clean", "overcurrent"])
def test_its_button_and_wheels_that_are_stuck_stop_it_for_good(hall: Desk, what: str) -> None:
    def on_tick(time_s: float, robots: list[Create2]) -> None:
        setattr(robots[0], what, 1.0 < time_s < 2.0)

    (driven,) = drive(hall, 4.0, on_tick=on_tick)
    assert still_after(driven, 1.7)
    assert not still_after(driven, 0.5)


@needs_tools
def test_an_overcurrent_for_a_moment_stops_nothing(hall: Desk) -> None:
    def on_tick(time_s: float, robots: list[Create2]) -> None:
        robots[0].overcurrent = 1.0 < time_s < 1.3

    assert not still_after(drive(hall, 4.0, on_tick=on_tick)[0], 2.0)


@pytest.mark.slow  # simulates the chip for long
@needs_tools
def test_a_robot_that_missed_the_start_does_not_begin_with_a_later_pulse(hall: Desk, tmp_path: Path) -> None:
    """It hears the second pulse of the start alone, or one that sets clocks: neither is a start."""
    desk = with_signal(hall, 5000, tmp_path)

    def late(time_s: float) -> bool:
        return 6.6 <= time_s < 6.66 or (time_s >= 11.0 and (time_s - 11.0) % 5.0 < 0.06)

    with pytest.raises(RuntimeError, match="a robot has not begun to move"):
        drive(desk, 6.0, signal=late)


def with_signal(desk: Desk, every_ms: int, folder: Path) -> Desk:
    """The same sketches, waiting for the common pulse, which sets their clocks every so many milliseconds."""
    firmware = []
    for number, known in enumerate(desk.firmware):
        text = known.with_suffix(".ino").read_text().replace("WAIT_FOR_SIGNAL = false", "WAIT_FOR_SIGNAL = true")
        text = text.replace("SIGNAL_EVERY_MS = 0", f"SIGNAL_EVERY_MS = {every_ms}")
        own = folder / str(number)
        own.mkdir()
        firmware.append(compile_text(text, own))
    return replace(desk, firmware=tuple(firmware))


@needs_tools
@pytest.mark.slow  # hours of two simulated clocks
def test_clocks_that_drift_are_set_by_a_common_pulse(tmp_path: Path) -> None:
    """One clock 3 % fast, one 3 % slow: 0.8 s apart when the second leg begins, unless a pulse every 5 s sets them.

    So slow a plan leaves time to wait for the clock at the end of each leg.
    """
    hall = set_up(bounced_plan(CORRIDOR, ((3, 0, 0),), turn=4, speed_m_s=0.15, headings=4), tmp_path)

    def apart_s(every_ms: int) -> tuple[float, float]:
        folder = tmp_path / f"every-{every_ms}"
        folder.mkdir()
        desk = with_signal(hall, every_ms, folder)

        def pulse(time_s: float) -> bool:
            return 6.6 <= time_s < 6.66 or (time_s >= 6.0 and (time_s - 6.0) % 5.0 < 0.06)

        fast, slow = (drive(desk, 15.0, rates=(rate,), signal=pulse)[0] for rate in (1.03, 0.97))
        second_legs = []
        for one in (fast, slow):
            moves = np.linalg.norm(np.diff(one.places_m, axis=0), axis=1) > 0
            second_legs.append(one.began_s + float(one.times_s[2:][moves[1:] & ~moves[:-1]][-1]))
        return abs(fast.began_s - slow.began_s), abs(second_legs[0] - second_legs[1])

    start_apart_s, set_apart_s = apart_s(5000)
    assert start_apart_s < 0.25  # 3 s of either clock after the pulse
    _, loose_apart_s = apart_s(0)
    assert set_apart_s < 0.4
    assert loose_apart_s > set_apart_s + 0.3


@needs_tools
def test_the_plan_begins_at_a_time_after_switching_on(hall: Desk) -> None:
    """Not after the robot's first answer, for which it is asked once a second."""
    assert drive(hall, 1.0)[0].began_s == pytest.approx(10.0, abs=0.05)


@needs_tools
@pytest.mark.parametrize("danger", ["cliff", "dropped"])
@pytest.mark.parametrize("full_mode", [False, True])
def test_a_cliff_or_a_lifted_wheel_stops_it_for_good(hall: Desk, tmp_path: Path, danger: str, full_mode: bool) -> None:
    desk = hall
    if full_mode:
        sketch = hall.firmware[0].with_suffix(".ino")
        text = sketch.read_text().replace("FULL_MODE = false", "FULL_MODE = true")
        desk = replace(hall, firmware=(compile_text(text, tmp_path),))
    modes = set()

    def on_tick(time_s: float, robots: list[Create2]) -> None:
        modes.add(robots[0].mode)
        setattr(robots[0], danger, 1.0 < time_s < 1.5)  # in the middle of its first way

    (driven,) = drive(desk, 2.0, on_tick=on_tick)
    moving = np.linalg.norm(np.diff(driven.places_m, axis=0), axis=1) > 0
    assert ("full" if full_mode else "safe") in modes
    assert moving[driven.times_s[1:] < 1.0].any()
    assert not moving[driven.times_s[1:] > 1.0 + 0.1].any()


def compile_text(text: str, folder: Path) -> Path:
    sketch = folder / "changed.ino"
    sketch.write_text(text)
    return build_sketch(sketch)


@needs_tools
def test_the_longest_way_fits_into_an_uno(tmp_path: Path, hall: Desk) -> None:
    """32,256 bytes are free beside the boot loader."""
    row = "  { 0, 123456, 1234567 },\n"
    text = hall.firmware[0].with_suffix(".ino").read_text()
    begin = text.index("const Leg LEGS[] PROGMEM = {\n") + len("const Leg LEGS[] PROGMEM = {\n")
    rows = row * (create2_sketch.MOST_BYTES // create2_sketch.LEG_BYTES)
    longest = text[:begin] + rows + text[text.index("};\nconst uint16_t LEG_COUNT") :]
    assert 30_000 < flash_bytes(compile_text(longest, tmp_path)) < 32_256
    assert create2_sketch.MOST_BYTES // create2_sketch.LEG_BYTES > 3_000
