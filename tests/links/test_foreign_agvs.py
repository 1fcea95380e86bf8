"""The VDA 5050 link with vehicles that others wrote: Siemens' library as it is published, over a real broker."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from shapely import box
from tests.links.agv import broker
from tests.links.fast_time import FastTime
from tests.links.fleets import plan_of
from tests.links.foreign_agvs import ForeignAgv, foreign, require_node

from rota.errors import LinkError
from rota.links.link_settings import make_link
from rota.links.sending import routes_for, send_all, start_all
from rota.live.driving import Driving
from rota.live.keeping import Keeping
from rota.live.ready import make_ready
from rota.live.watch import Watch
from rota.mission import Zone
from rota.plan import Plan, Trajectory

pytestmark = pytest.mark.node
ROUND_S, STOPS, TOP_M_S = 28.0, 4, 1.5
NAMES = "abc"


def start_m(robot: str) -> tuple[float, float]:
    return 12.0 * NAMES.index(robot), 0.0


def loop_of(robot: str) -> Trajectory:
    """8 m x 4 m at 1 m/s, with 2 s of waiting at two corners."""
    x, y = start_m(robot)
    places = [(x, y), (x + 8, y), (x + 8, y), (x + 8, y + 4), (x, y + 4), (x, y + 4), (x, y)]
    return Trajectory(robot=robot, times_s=[0, 8, 10, 14, 22, 24, 28], positions_m=places)


def plan() -> Plan:
    made = plan_of(*map(loop_of, NAMES))
    fleet = made.mission.fleet
    robots = tuple(replace(robot, speed_m_s=TOP_M_S) for robot in fleet.robots or ())
    lane = Zone(name="lane", shape=box(0, 0, 32, 4), period_s=60)
    fleet = replace(fleet, speed_m_s=TOP_M_S, robots=robots)
    return replace(made, mission=replace(made.mission, fleet=fleet, zones=(lane,)))


@pytest.fixture(scope="module")
def port(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    require_node()
    with broker(tmp_path_factory.mktemp("broker")) as number:
        yield number


@dataclass
class Shift:
    """A link to foreign vehicles, when they were started by their clocks, and what was told meanwhile."""

    link: Any
    agvs: dict[str, ForeignAgv]
    told: list[str]
    began_s: float = 0.0

    def late_s(self, robot: str) -> list[float]:
        """How late a vehicle was at the first stop of each round after the first, by its own clock."""
        passed = [(number // 2, unix_s) for number, unix_s in self.agvs[robot].passed]
        return [unix_s - self.began_s - n // STOPS * ROUND_S for n, unix_s in passed if n and n % STOPS == 0]


def with_foreign(
    port: int, clock: FastTime, what: Callable[[Shift], Awaitable[None]], *given: str, version: str = "2.0.0"
) -> Shift:
    """What comes of doing something with a link to three vehicles."""

    async def run() -> Shift:
        agvs = {name: ForeignAgv(name, start_m(name), TOP_M_S, version) for name in NAMES}
        async with foreign(port, list(agvs.values()), clock):
            link = make_link("vda5050", plan(), [f"port={port}", *given])
            shift = Shift(link, agvs, [])
            try:
                await link.open()
                await what(shift)
            finally:
                await link.close()
        return shift

    return clock.run(run())


async def send_and_start(shift: Shift, clock: FastTime) -> None:
    routes = routes_for(plan(), shift.link)
    await send_all(shift.link, routes)
    shift.began_s = clock.unix_s()
    await start_all(shift.link, routes)


@pytest.mark.slow  # four rounds of 28 s, five times as fast as the clock
@pytest.mark.parametrize("given", ["wait_action=", "wait_action=noop:duration"], ids=["release", "noop"])
def test_three_keep_their_phase_for_four_rounds_while_one_dies(
    port: int, given: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_ready()
    clock = FastTime(rate=5.0)
    clock.let_links_have_it(monkeypatch)

    async def drive(shift: Shift) -> None:
        driving = Driving(
            shift.link, Watch(plan()), Keeping(plan(), {}), None, lambda notice: shift.told.append(notice.text)
        )
        await send_and_start(shift, clock)
        await driving.drive(until_s=2.5 * ROUND_S, should_stop=lambda: False)
        assert shift.told == []
        assert shift.link.trouble == ""
        shift.agvs["c"].kill()
        await driving.drive(until_s=4.2 * ROUND_S, should_stop=lambda: False)
        assert shift.link.trouble == "robot c: the broker says that it is CONNECTIONBROKEN"

    shift = with_foreign(port, clock, drive, given)
    assert [len(shift.late_s(name)) for name in NAMES] == [4, 4, 2]
    for name in NAMES:
        assert max(map(abs, shift.late_s(name))) < 1.0
        assert shift.agvs[name].errors == []
    assert [text.split(":")[0] for text in shift.told] == ["c is lost"]


def test_a_vehicle_of_a_version_that_is_not_spoken_is_told_so(tmp_path: Path) -> None:
    require_node()

    async def nothing(_: Shift) -> None:
        raise AssertionError("it was opened")

    known = r"robot a: it speaks VDA 5050 1\.1\.0; 2\.0, 2\.1 and 3\.0 are spoken here"
    with broker(tmp_path) as port, pytest.raises(LinkError, match=known):
        with_foreign(port, FastTime(), nothing, version="1.1.0")


def test_an_action_that_vehicles_do_not_know_is_told_with_their_words(port: int) -> None:
    async def send(shift: Shift) -> None:
        await send_all(shift.link, routes_for(plan(), shift.link))

    known = "robot a: the order: orderError: order action is not executable: not supported"
    with pytest.raises(LinkError, match=known):
        with_foreign(port, FastTime(), send, "wait_action=linger:duration")


def test_vehicles_are_led_home_and_take_a_new_order_afterwards(port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = FastTime(rate=8.0)
    clock.let_links_have_it(monkeypatch)

    async def drive(shift: Shift) -> None:
        await send_and_start(shift, clock)
        await asyncio.sleep(16.0)
        for name in NAMES:
            await shift.link.pause(name)
            assert shift.link.latest(name).mode == "paused"
            await shift.link.come_home(name)
        await asyncio.sleep(26.0)
        for name in NAMES:
            assert shift.link.latest(name).position_m[:2] == start_m(name)
        await send_all(shift.link, routes_for(plan(), shift.link))

    with_foreign(port, clock, drive)
