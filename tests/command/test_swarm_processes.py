"""`rota swarm-launch` and `rota swarm-node` from the outside."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from PIL import Image
from tests.planners.swarm.nodes.test_launch import free_ports

from rota.command.cli import run
from rota.files.plan_file import read_plan
from rota.ros2.node import CHOSEN_BY

MISSION = """\
rota: 1
name: three
area: [[0, 0], [40, 0], [40, 40], [0, 40]]
fleet:
  robots: 3
  speed_m_s: 10
  sensor: {shape: square, side_m: 12}
  body_radius_m: 0.5
  start: {box: [[15, 15], [25, 25]]}
planner: swarm
swarm: {time_step_s: 0.1}
"""


@pytest.fixture
def mission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    Path("three.yaml").write_text(MISSION)
    return "three.yaml"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="starting anew takes seconds for each process")
def test_a_launch_writes_what_was_done_and_says_how_it_went(mission: str, capsys: pytest.CaptureFixture[str]) -> None:
    Image.new("L", (8, 8), 51).save("level.png")
    hills = ["--height-map", "level.png", "--heights", "0,100"]
    files = ["-o", "done.rota.json", "--coverage", "done.csv", "--port", str(free_ports(4))]
    assert run(["swarm-launch", mission, "--robots", "1-2", "--time-limit", "1.2", *hills, *files]) == 0
    out, err = capsys.readouterr()
    assert "robot-1 is process" in err
    assert "warning: robot-3 was never heard: it is not in the plan" in err
    assert "    0 s   " in out
    assert "ms of processor time for decision and messages in the median" in out
    plan = read_plan("done.rota.json")
    assert [way.robot for way in plan] == ["robot-1", "robot-2"]
    assert all((way.positions_m[:, 2] == pytest.approx(20 + 30)) for way in plan)  # the altitude of fleets is 30 m
    head, *rows = Path("done.csv").read_text().splitlines()
    assert head == "time_s,coverage,robots"
    assert rows[0].startswith("0.0,0.")
    _, coverage, robots = rows[-1].split(",")  # on a busy machine one may be heard before the other
    assert (0.1 <= float(coverage) < 0.2, robots) == (True, "2")
    assert run(["check", "done.rota.json"]) == 0


# it starts an interpreter, which loads for seconds
@pytest.mark.slow
def test_a_node_ends_cleanly_on_ctrl_c(mission: str) -> None:
    command = [sys.executable, "-m", "rota", "swarm-node", mission, "--robot", "robot-2", "--port", str(free_ports(4))]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as node:
        assert node.stderr is not None
        killer = threading.Timer(120, node.kill)
        killer.start()
        line = node.stderr.readline()
        while "listens on port" not in line:
            assert line, "it ended before it listened"
            line = node.stderr.readline()
        node.send_signal(signal.SIGINT)
        _, err = node.communicate()
        killer.cancel()
    assert "leaving; Ctrl-C again ends at once" in err
    assert "Traceback" not in err
    assert node.returncode == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["swarm-node", "three.yaml", "--robot", "4"],
            "'4' is no robot of the mission; one of its names or",
        ),
        (["swarm-launch", "three.yaml", "--robots", "2-9"], "'9' is no robot of the mission"),
        (["swarm-launch", "three.yaml", "--rate", "1"], "rate: 1 Hz is not allowed"),
        (["swarm-launch", "three.yaml", "--rate", "1e9"], "rate: 1e+09 Hz is not allowed; 0.1 to 1000 Hz"),
        (["swarm-launch", "three.yaml", "--heights", "0,1"], "--heights: '0,1' is not allowed without --height-map"),
        (["swarm-launch", "three.yaml", "--hosts", "a,b"], "hosts: 2 is not allowed"),
        (["swarm-launch", "three.yaml", "--transport", "smoke"], "transport: 'smoke' is not allowed; udp or ros2"),
        (["swarm-node", "three.yaml", "--robot", "1", "--transport", "ros2", "--port", "5000"], "port, hosts: not all"),
        (["swarm-launch", "three.yaml", "--coverage", "a.txt"], "a.txt"),
        (["swarm-launch", "three.yaml", "-o", "three.yaml"], "three.yaml"),
        (["swarm-launch", "nowhere.yaml"], "nowhere.yaml: no such file"),
    ],
)
def test_what_is_wrong_is_said(
    mission: str, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments) == 2
    assert message in capsys.readouterr().err
    assert not Path("three.rota.json").exists()


@pytest.mark.parametrize("command", [["swarm-launch"], ["swarm-node", "--robot", "1"]])
def test_ros_2_that_is_missing_is_said(
    mission: str, command: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    for name in CHOSEN_BY:  # set by the command, and taken back after the test
        monkeypatch.setenv(name, "")
    assert run([*command, mission, "--transport", "ros2"]) == 2
    assert "ROS 2 cannot be reached" in capsys.readouterr().err
    assert not Path("three.rota.json").exists()
