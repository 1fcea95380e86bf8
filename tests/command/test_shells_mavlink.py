"""`rota fly` in one shell and `rota watch` in another, with autopilots that fly what they were sent."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mav
from tests.command.shells import line_with, replayed, shell, watch_for_a_while
from tests.links.autopilot import Script, flying
from tests.links.fleets import loop_of, plan_of

from rota.files.geodesy import Projection
from rota.files.plan_file import write_plan

# seconds of real flight, in two processes
pytestmark = [pytest.mark.mavsdk, pytest.mark.slow]


def test_vehicles_are_sent_off_in_one_shell_and_watched_in_another(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = plan_of(loop_of("a", 0.0), loop_of("b", 200.0))
    write_plan(plan, tmp_path / "quay.rota.json")
    assert plan.mission.origin is not None
    projection, scripts = Projection(plan.mission.origin), []
    for way, firmware in zip(plan, (mav.MAV_AUTOPILOT_PX4, mav.MAV_AUTOPILOT_ARDUPILOTMEGA), strict=True):
        (lon,), (lat,) = projection.to_degrees(*([value] for value in way.positions_m[0, :2]))
        scripts.append(Script(firmware=firmware, flies=True, position=(round(lat * 1e7), round(lon * 1e7), 0)))

    async def fly_and_watch(address: str) -> tuple[list[Any], str]:
        words = ("quay.rota.json", "--link", "mavlink", "--set", f"address={address}")
        async with shell(tmp_path, "fly", *words, "--start", "--yes", "--hands-off") as fly:
            assert "Started: 2 robots at 20" in await line_with(fly, "Started")
            command = await line_with(fly, "rota watch")
            assert await fly.wait() == 0
        assert command.startswith(f"rota watch quay.rota.json --link mavlink --set address={address} --set start_time=")
        return await watch_for_a_while(tmp_path, plan, command)

    with flying(*scripts) as vehicles:
        address = "+".join(f"udpin://127.0.0.1:{vehicle.port}" for vehicle in vehicles)
        robots, printed = asyncio.run(fly_and_watch(address))
    for robot in robots:
        assert robot["mode"] == "running"
        assert robot["away_m"] < 1.0
        assert abs(robot["lag_s"]) < 3.0
    assert replayed(tmp_path, "quay.rota.json") == 0
    assert capsys.readouterr().out == printed
