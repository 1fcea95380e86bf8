"""`rota fly` in one shell and `rota watch` in another, with robots on ROS 2 that drive what they were sent."""

from __future__ import annotations

import asyncio
import os
from pathlib import Path
from typing import Any

import pytest
from tests.command.shells import interrupted, line_with, replayed, shell, watch_for_a_while
from tests.links.fleets import loop_of, plan_of, staying
from tests.links.ros2_robots import ScriptedRobot, on_air

from rota.files.plan_file import write_plan
from rota.ros2.node import CHOSEN_BY, stay_on_loopback

pytestmark = pytest.mark.ros


def test_robots_are_sent_off_in_one_shell_and_watched_in_another(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("rclpy")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    for name in CHOSEN_BY:
        monkeypatch.setenv(name, "")
    stay_on_loopback()
    plan = plan_of(loop_of("robot-1", 0.0), staying("b"))
    write_plan(plan, tmp_path / "quay.rota.json")
    words = ("quay.rota.json", "--link", "ros2", "--set", "wait_s=30")

    async def fly_and_watch() -> tuple[list[Any], str]:
        async with shell(tmp_path, "fly", *words, "--start", "--yes") as fly:
            assert "Started: 2 robots at 20" in await line_with(fly, "Started")
            command = await line_with(fly, "rota watch")
            told = await watch_for_a_while(tmp_path, plan, command)
            code, said = await interrupted(fly)
            assert code == 130
            assert said.count("robot b: nobody listens on /b/schedule; it is not kept in phase meanwhile") == 1
            assert "robots go on with their routes" in said
            return told

    first, second = (
        ScriptedRobot("robot_1", (-10.0, 0.0, 25.0), drives=True, top_m_s=8.0),
        ScriptedRobot("b", (0.0, 60.0, 25.0), drives=True),
    )
    with on_air(first, second):
        robots, printed = asyncio.run(fly_and_watch())
    assert first.schedules > 1
    assert [robot.orders for robot in (first, second)] == [["clear_route", "start"]] * 2
    for robot in robots:
        assert robot["mode"] == "running"
        assert robot["away_m"] < 0.01
        assert abs(robot["lag_s"]) < 2.0
    assert replayed(tmp_path, "quay.rota.json") == 0
    assert capsys.readouterr().out == printed
