"""The VDA 5050 link with vehicles that others wrote: Siemens' library as it is published, over a real broker."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from tests.links.agv import broker
from tests.links.fast_time import FastTime
from tests.links.foreign_agvs import NAMES, ROUND_S, Shift, plan, require_node, start_m, with_foreign
from tests.relieved import FLIGHT_S, TURN_S, relieved

from rota.errors import LinkError
from rota.links.sending import routes_for, send_all
from rota.live.driving import Driving
from rota.live.keeping import Keeping, Slack
from rota.live.notices import Notice, NoticeKind
from rota.live.ready import make_ready
from rota.live.watch import Watch

pytestmark = pytest.mark.node


@pytest.fixture(scope="module")
def port(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    require_node()
    with broker(tmp_path_factory.mktemp("broker")) as number:
        yield number


@pytest.mark.slow  # four rounds of 28 s, five times as fast as the clock
@pytest.mark.parametrize(
    # a wait is told some stops ahead, so that it cannot be as exact as a release
    ("given", "most_late_s"),
    [("wait_action=", 1.0), ("wait_action=noop:duration", 1.5)],
    ids=["release", "noop"],
)
def test_three_keep_their_phase_for_four_rounds_while_one_dies(
    port: int, given: str, most_late_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_ready()
    clock = FastTime(rate=5.0)
    clock.let_links_have_it(monkeypatch)

    async def drive(shift: Shift) -> None:
        driving = Driving(
            shift.link, Watch(plan()), Keeping(plan(), {}), None, lambda notice: shift.told.append(notice.text)
        )
        await shift.start(clock)
        await driving.drive(until_s=2.5 * ROUND_S, should_stop=lambda: False)
        assert shift.told == []
        assert shift.link.trouble == ""
        shift.agvs["c"].kill()
        await driving.drive(until_s=4.2 * ROUND_S, should_stop=lambda: False)
        assert shift.link.trouble == "robot c: the broker says that it is CONNECTIONBROKEN"

    shift = with_foreign(port, clock, drive, given)
    assert [len(shift.late_s(name)) for name in NAMES] == [4, 4, 2]
    for name in NAMES:
        assert max(map(abs, shift.late_s(name))) < most_late_s
    assert shift.errors == []
    assert [text.split(":")[0] for text in shift.told] == ["c is lost"]


@pytest.mark.slow  # four rounds of 28 s, five times as fast as the clock
def test_they_make_up_what_a_lost_broker_has_cost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    require_node()
    make_ready()
    clock = FastTime(rate=5.0)
    clock.let_links_have_it(monkeypatch)

    async def drive(shift: Shift) -> None:
        driving = Driving(shift.link, Watch(plan()), Keeping(plan(), {}), None, lambda notice: None)
        await shift.start(clock)
        await driving.drive(until_s=1.3 * ROUND_S, should_stop=lambda: False)
        brokers.pop().close()
        await asyncio.sleep(15.0)
        assert "is lost" in shift.link.trouble
        brokers.append(started())
        await driving.drive(until_s=4.2 * ROUND_S, should_stop=lambda: False)
        assert shift.link.trouble == ""

    def started() -> ExitStack:
        stack = ExitStack()
        ports.append(stack.enter_context(broker(tmp_path, port=ports[0] if ports else None)))
        return stack

    ports: list[int] = []
    brokers = [started()]
    try:
        shift = with_foreign(ports[0], clock, drive)
    finally:
        for stack in brokers:
            stack.close()
    for name in NAMES:
        late_s = shift.late_s(name)
        # 17 s after the broker was back; a round of 28 s leaves 10 s and more
        assert max(late_s) > 10
        assert abs(late_s[-1]) < 1.0
    assert shift.errors == []


@pytest.mark.slow  # four rounds of 28 s, five times as fast as the clock
def test_all_wait_for_one_that_cannot_keep_up_and_it_is_told(port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    make_ready()
    clock = FastTime(rate=5.0)
    clock.let_links_have_it(monkeypatch)
    keeping = Keeping(plan(), {"lane": Slack(gap_s=50.0, period_s=60.0)})

    async def drive(shift: Shift) -> None:
        driving = Driving(shift.link, Watch(plan()), keeping, None, lambda notice: shift.told.append(notice.text))
        await shift.start(clock)
        await driving.drive(until_s=6 * ROUND_S, should_stop=lambda: False)

    # 24 m in 24 s and 4 s of waits: at 0.6 m/s it takes 40 s and more
    shift = with_foreign(port, clock, drive, slow_m_s={"b": 0.6})
    told = [text for text in shift.told if "cannot keep up" in text]
    assert told[0].startswith("b cannot keep up: ")
    assert "all go on at 0." in told[0]
    assert "lane is seen every" in told[0]
    late_s = {name: shift.late_s(name) for name in NAMES}
    assert late_s["b"][2] > 30
    for name in "ac":
        # without waiting they would be 40 s ahead of it by then
        assert late_s["b"][2] - late_s[name][2] < 20


@pytest.mark.slow  # 450 s, fifteen times as fast as the clock
def test_flights_are_orders_and_a_robot_holds_its_post_until_its_relief_has_charged(
    port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """robot-2 comes to its charger with a battery too low for its next flight, and is let go once it has charged."""
    make_ready()
    of, clock = relieved(2), FastTime(rate=15.0)
    clock.let_links_have_it(monkeypatch)
    told: list[Notice] = []

    async def drive(shift: Shift) -> None:
        driving = Driving(shift.link, Watch(of), Keeping(of, {}), None, told.append)
        await shift.start(clock)
        await driving.drive(until_s=450.0, should_stop=lambda: False)
        assert shift.link.trouble == ""

    shift = with_foreign(port, clock, drive, of=of, batteries={"robot-2": 20.0})
    assert shift.errors == []

    def time_of(kind: NoticeKind, robot: str) -> float:
        return next(notice.time_s for notice in told if (notice.kind, notice.about) == (kind, robot))

    late_s, comes_s = time_of("relief late", "robot-2"), time_of("relief comes", "robot-2")
    assert late_s == pytest.approx(TURN_S, abs=8)
    # a flight and the reserve take 220 s of 400, but for a hundredth; 20 percent are there, and 720 s fill it; vehicles
    # tell their batteries every 30 s
    assert comes_s - FLIGHT_S + TURN_S == pytest.approx((220 / 400 - 0.01 - 0.2) * 720, abs=45)
    assert time_of("takes off", "robot-2") == pytest.approx(comes_s, abs=10)
    # robot-1 stands between its last two corners until then, and is as much later on its charger
    assert time_of("lands", "robot-1") - FLIGHT_S == pytest.approx(comes_s - late_s, abs=12)
    assert time_of("takes off", "robot-1") - 2 * TURN_S == pytest.approx(comes_s - late_s, abs=15)
    # each flight is an order of its own, whose nodes are counted anew
    flown = [sequence for sequence, _ in shift.agvs["robot-1"].passed]
    assert flown[: flown.index(20) + 2] == [*range(0, 22, 2), 0]


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
        await shift.start(clock)
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
