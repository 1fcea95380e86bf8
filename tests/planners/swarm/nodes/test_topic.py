"""Robots' processes whose messages go by a topic of ROS 2, on loopback."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time

import pytest
from tests.planners.swarm.nodes.air import mission_of

from rota.check import check_plan
from rota.planners.swarm.nodes.launch import run_swarm
from rota.planners.swarm.nodes.process import scene_for
from rota.planners.swarm.nodes.telling import SIZE
from rota.planners.swarm.nodes.topic import TopicPort
from rota.planning.robot_processes import Launch, ProcessSettings
from rota.ros2.node import CHOSEN_BY

pytestmark = pytest.mark.ros


@pytest.fixture(autouse=True)
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """A domain that no other program on this machine is likely to use, and loopback."""
    pytest.importorskip("rclpy")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    for name in CHOSEN_BY:
        monkeypatch.delenv(name, raising=False)


def test_robots_on_a_topic_spread_and_close_the_gap_of_one_that_is_killed() -> None:
    mission = mission_of(4, 40, (15, 25), sensor_m=9, speed_m_s=10)
    settings = ProcessSettings(seed=1, transport="ros2")
    ids: dict[int, int] = {}
    rows = []

    def measured(time_s: float, share: float, robots: int) -> None:
        rows.append((time_s, share, robots))
        if len(rows) == 4:
            os.kill(ids[2], signal.SIGKILL)

    launch = Launch(time_limit_s=8.2, started=ids.update, measured=measured)
    record = run_swarm(scene_for(mission, settings), settings, launch)
    assert not multiprocessing.active_children()
    assert [robot.end for robot in record.robots] == ["runs", "runs", "silent", "runs"]
    assert [robot.dropped for robot in record.robots] == [0, 0, 0, 0]
    assert [robots for _, _, robots in rows[:4]] == [4] * 4
    assert rows[-1][2] == 3
    spread, low, end = rows[3][1], min(share for _, share, _ in rows[4:]), rows[-1][1]
    assert spread > 1.5 * rows[0][1]
    assert low < 0.85 * spread  # one of four is gone
    left = {robot.robot for robot in record.robots if robot.end == "runs"}
    ways = [way for way in record.plan if way.robot in left]
    killed_s = next(robot.leaves_s for robot in record.plan.mission.fleet.robots or () if robot.leaves_s is not None)
    moved = [(way.times_s > killed_s + 0.5).any() for way in ways]
    assert any(moved), (rows, end)
    report = check_plan(record.plan)
    assert report.verdict == "met", report.violations


def test_long_messages_are_cut_and_others_arrive_as_they_were_sent() -> None:
    port = TopicPort("rota_test")
    sent = [bytes(range(SIZE)), bytes(10_000), b""]
    for datagram in sent:
        port.send(datagram)
    read, until = [], time.monotonic() + 30
    while len(read) < len(sent) and time.monotonic() < until:
        read += port.receive()
    port.close()
    assert read == [sent[0], bytes(SIZE + 1), b""]
