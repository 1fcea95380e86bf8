"""`rota fly` and `rota watch` beside each other at a broker, and Ctrl-C at bad moments."""

from __future__ import annotations

import asyncio
import os
import pty
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.command.shells import interrupted, line_with, replayed, shell, watch_for_a_while
from tests.links.agv import Agv, Ways, broker, driving
from tests.links.fleets import loop_of, plan_of, staying

from rota.files.plan_file import write_plan

# processes that start, and seconds of real driving
pytestmark = pytest.mark.slow
PLAN = plan_of(loop_of("a", 0.0), staying("b"))


@pytest.fixture
def words(tmp_path: Path) -> Iterator[list[str]]:
    """What `rota fly` needs to reach vehicles at a broker."""
    write_plan(PLAN, tmp_path / "quay.rota.json")
    with broker(tmp_path) as port:
        yield ["quay.rota.json", "--link", "vda5050", "--set", f"port={port}"]


def port_of(words: list[str]) -> int:
    return int(words[-1].removeprefix("port="))


def test_vehicles_are_led_by_one_shell_and_watched_by_another(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    agvs = [Agv("a", Ways(real=True), place=(-10.0, 0.0)), Agv("b", Ways(real=True), place=(0.0, 60.0))]

    async def fly_and_watch() -> tuple[list[Any], str]:
        async with driving(port_of(words), *agvs), shell(tmp_path, "fly", *words, "--start", "--yes") as fly:
            command = await line_with(fly, "rota watch")
            taken = [list(agv.taken) for agv in agvs]
            told = await watch_for_a_while(tmp_path, PLAN, command)
            # the watch has sent no orders, and has not stopped anybody
            assert [agv.taken[: len(taken[k])] for k, agv in enumerate(agvs)] == taken
            assert len({order.split(":")[0] for agv in agvs for order in agv.taken}) == 2
            assert not agvs[0].paused
            code, said = await interrupted(fly)
            assert code == 130
            assert "robots get nothing more from here on" in said
            return told

    robots, printed = asyncio.run(fly_and_watch())
    for robot in robots:
        assert robot["away_m"] < 0.01
        assert abs(robot["lag_s"]) < 1.0
    assert replayed(tmp_path, "quay.rota.json") == 0
    assert capsys.readouterr().out == printed


@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM], ids=["Ctrl-C", "SIGTERM"])
def test_an_interrupt_while_routes_are_sent_leaves_nobody_with_one(
    by: signal.Signals, words: list[str], tmp_path: Path
) -> None:
    agvs = [Agv("a"), Agv("b", Ways(loses=0))]

    async def fly() -> None:
        async with driving(port_of(words), *agvs), shell(tmp_path, "fly", *words, "--start", "--yes") as flying:
            while not (agvs[0].nodes and agvs[1].taken):  # the second one has lost its order
                await asyncio.sleep(0.01)
            assert [agv.paused for agv in agvs] == [True, True]
            code, told = await interrupted(flying, by)
            assert code == (143 if by == signal.SIGTERM else 130)
            assert "no robot holds a route: all were cleared" in told
        assert [agv.nodes for agv in agvs] == [[], []]

    asyncio.run(fly())


def test_an_interrupt_at_the_question_starts_nobody(words: list[str], tmp_path: Path) -> None:
    agvs = [Agv("a"), Agv("b")]

    async def fly() -> None:
        above, below = pty.openpty()
        try:
            asking = shell(tmp_path, "fly", *words, "--start", stdin=below)
            async with driving(port_of(words), *agvs), asking as flying:
                await line_with(flying, "2 routes sent")
                code, told = await interrupted(flying)
                assert code == 130
                assert "nothing was started; the robots hold their routes" in told
            assert [agv.paused and bool(agv.nodes) for agv in agvs] == [True, True]
            assert [len(agv.passed) for agv in agvs] == [1, 1]
        finally:
            os.close(above)
            os.close(below)

    asyncio.run(fly())
