"""Lists of waypoints as pymavlink's own loader reads them, item by item beside QGroundControl's plan."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pymavlink import mavwp
from tests.files.two_robots import two_robots, with_heights

from rota.errors import PlanError, RotaError
from rota.files import mission_items
from rota.files.executed.plan_as_driven import plan_as_driven
from rota.files.plan_file import write_plan
from rota.files.qgroundcontrol import write_qgroundcontrol
from rota.files.waypoint_list import write_waypoint_lists
from rota.model.plan import Plan, Trajectory

WAYPOINT, JUMP = 16, 177


@pytest.mark.parametrize("plan", [two_robots(), with_heights()], ids=["flat", "with heights"])
def test_pymavlink_reads_the_items_of_the_plan(plan: Plan, tmp_path: Path) -> None:
    lists = write_waypoint_lists(plan, tmp_path / "lists")
    plans = write_qgroundcontrol(plan, tmp_path / "plans")
    assert [path.suffix for path in lists] == [".waypoints"] * 2
    assert [path.stem for path in lists] == [path.stem for path in plans]
    for path, beside in zip(lists, plans, strict=True):
        loader = mavwp.MAVWPLoader()
        items = json.loads(beside.read_text())["mission"]["items"]
        assert loader.load(str(path)) == len(items) + 1
        home = loader.wp(0)
        assert (home.seq, home.current, home.frame, home.command) == (0, 1, 0, 16)
        assert [home.x, home.y, home.z] == [*items[0]["params"][4:6], 0]
        for number, item in enumerate(items, start=1):
            read = loader.wp(number)
            assert (read.seq, read.current, read.autocontinue) == (item["doJumpId"], 0, 1)
            assert (read.command, read.frame) == (item["command"], item["frame"])
            found = [read.param1, read.param2, read.param3, read.param4, read.x, read.y, read.z]
            assert found == [0 if value is None else value for value in item["params"]]


def test_the_jump_leads_to_the_sequence_number_where_the_loop_begins(tmp_path: Path) -> None:
    path, _ = write_waypoint_lists(two_robots(), tmp_path / "lists")
    loader = mavwp.MAVWPLoader()
    loader.load(str(path))
    jump = loader.wp(loader.count() - 1)
    assert (jump.command, jump.param2) == (JUMP, -1)
    target = loader.wp(int(jump.param1))
    # x = y = 0 is the origin
    np.testing.assert_allclose([target.x, target.y], [-33.8567844, 151.2152967], atol=1e-9)


def test_a_file_that_cannot_be_made_leaves_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(PlanError, match=r"without an origin .* which a list of waypoints needs; give --origin LAT,LON"):
        write_waypoint_lists(two_robots(origin=None), tmp_path / "lists")
    plan = two_robots()
    # the robot that stays has few items and comes first
    plan = replace(plan, trajectories=plan.trajectories[::-1])
    monkeypatch.setattr(mission_items, "MOST_ITEMS", 5)
    with pytest.raises(PlanError, match=r"robot <Zoë>.*: its route makes \d+ mission items; MAVLink counts at most 5"):
        write_waypoint_lists(plan, tmp_path / "lists")
    assert not (tmp_path / "lists").exists()


def test_what_ardupilot_cannot_keep_is_split_or_refused(tmp_path: Path) -> None:
    plan = two_robots(robots=("a", "b"))
    waiting = Trajectory(
        robot="a", times_s=[0, 10, 140_010, 140_020, 140_030], positions_m=[[0, 0], [10, 0], [10, 0], [20, 0], [0, 0]]
    )
    path, _ = write_waypoint_lists(replace(plan, trajectories=(waiting, plan.trajectories[1])), tmp_path / "lists")
    loader = mavwp.MAVWPLoader()
    loader.load(str(path))
    items = [loader.wp(number) for number in range(loader.count())]
    waits = [item for item in items if item.command == WAYPOINT and item.param1 > 0]
    # 16 bits each
    assert [item.param1 for item in waits] == [65_535, 65_535, 140_000 - 2 * 65_535]
    assert len({(item.x, item.y, item.z) for item in waits}) == 1
    (driven,) = plan_as_driven(replace(plan, trajectories=(waiting,)), "waypoints")
    assert driven.loop_duration_s == pytest.approx(140_030, abs=0.01)
    fleet = replace(plan.mission.fleet, altitude_m=83_001)
    with pytest.raises(PlanError, match=r"robot a: a place 83001 m over .*; ArduPilot keeps at most 83000 m"):
        write_waypoint_lists(replace(plan, mission=replace(plan.mission, fleet=fleet)), tmp_path / "high")
    assert not (tmp_path / "high").exists()


def test_a_plan_that_lies_where_a_robot_s_file_would_is_kept(tmp_path: Path) -> None:
    plan = two_robots(robots=("a", "b"))
    write_plan(plan, tmp_path / "b.plan")
    before = (tmp_path / "b.plan").read_bytes()
    with pytest.raises(RotaError, match=r"b\.plan: is a plan of Rota and is not overwritten; name another folder"):
        write_qgroundcontrol(plan, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["b.plan"]
    assert (tmp_path / "b.plan").read_bytes() == before
    # what was exported before is replaced
    write_waypoint_lists(plan, tmp_path)
    write_waypoint_lists(plan, tmp_path)
