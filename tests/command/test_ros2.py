"""`rota ros2` where it cannot play."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import pytest
from tests.files.two_robots import two_robots

from rota.command.cli import run
from rota.files.plan_file import write_plan
from rota.model.plan import Plan
from rota.ros2.node import CHOSEN_BY, stay_on_loopback


@pytest.fixture
def plan_path(tmp_path: Path) -> Path:
    write_plan(two_robots(robots=("a", "b")), tmp_path / "plan.json")
    return tmp_path / "plan.json"


@pytest.mark.parametrize(
    ("missing", "says"),
    [
        ("rclpy", "ROS 2 cannot be reached: .*rclpy.* Source a ROS 2 installation, or pip install ros-kilted-rclpy"),
        ("rosbags.interfaces", r"rota ros2 needs the rosbags library: pip install 'rota\[ros\]'"),
    ],
)
def test_what_is_missing_is_named(
    missing: str, says: str, plan_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in CHOSEN_BY:
        monkeypatch.setenv(name, "")
    monkeypatch.setitem(sys.modules, missing, None)
    assert run(["ros2", str(plan_path)]) == 2
    assert re.search(says, capsys.readouterr().err)


@pytest.mark.parametrize(
    "options", [["--speed", "0"], ["--speed", "nan"], ["--rate", "inf"], ["--until", "-1"], ["--until", "nan"]]
)
def test_numbers_out_of_range_are_refused(
    options: list[str], plan_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["ros2", str(plan_path), *options]) == 2
    assert capsys.readouterr().err.startswith(f"rota: error: {options[0]}: ")


def test_a_plan_without_robots_is_refused(plan_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_plan(Plan(mission=two_robots().mission, trajectories=()), plan_path)
    assert run(["ros2", str(plan_path)]) == 2
    assert "a plan without robots has nothing to play" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("distribution", "expected"),
    [
        ("", {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}),
        ("kilted", {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}),
        ("humble", {"ROS_LOCALHOST_ONLY": "1", "ROS_AUTOMATIC_DISCOVERY_RANGE": ""}),
    ],
)
def test_nodes_stay_on_loopback(distribution: str, expected: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    for name in CHOSEN_BY:
        monkeypatch.setenv(name, "")
    monkeypatch.setenv("ROS_DISTRO", distribution)
    stay_on_loopback()
    assert {name: os.environ[name] for name in expected} == expected
    profile = os.environ["FASTDDS_DEFAULT_PROFILES_FILE"]
    assert (distribution == "humble") == (profile == "")
    assert not profile or "<address>127.0.0.1</address>" in Path(profile).read_text()


def test_a_network_that_was_chosen_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in CHOSEN_BY:
        monkeypatch.setenv(name, "")
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    stay_on_loopback()
    assert [os.environ[name] for name in CHOSEN_BY] == ["SUBNET", "", "", "", ""]
