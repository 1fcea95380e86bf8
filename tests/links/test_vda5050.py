"""The VDA 5050 link over a real broker, with vehicles that check every message by the official schemas."""

from __future__ import annotations

import asyncio
import json
import math
import random
import subprocess
import tracemalloc
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from aiomqtt import Client
from tests.links.agv import Agv, Ways, broker, driving, told_at
from tests.links.fleets import dropped, loop_of, plan_of, routes_of, staying

from rota.errors import LinkError, PlanError, RotaError
from rota.links.link_settings import make_link
from rota.links.sending import routes_for, send_all, start_all
from rota.links.vda5050_broker import end_task
from rota.model.plan import Plan

LOOP = [(60.0, 0.0), (60.0, 20.0), (0.0, 20.0), (0.0, 0.0)]


@pytest.fixture(autouse=True)
def hopping(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody waits for the clock because of being early: these vehicles hop from node to node."""
    monkeypatch.setattr("rota.links.vda5050_pace.EARLY_S", math.inf)


@pytest.fixture(scope="module")
def port(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    with broker(tmp_path_factory.mktemp("broker")) as number:
        yield number


def one() -> Plan:
    return plan_of(loop_of("a", 0.0))


def two() -> Plan:
    return plan_of(loop_of("a", 0.0), staying("b"))


def with_link(port: int, plan: Plan, agvs: list[Agv], what: Callable[[Any], Awaitable[Any]], **own: Any) -> Any:
    """What comes of doing something with a link to the vehicles."""
    # these vehicles hop from node to node without waiting, which only those may that are told to wait
    given = {"port": port, "answer_s": 10, "released": 3, "announced": 2, "wait_action": "wait:duration", **own}

    async def run() -> Any:
        async with driving(port, *agvs):
            link = make_link("vda5050", plan, [f"{key}={value}" for key, value in given.items()])
            try:
                await link.open()
                return await what(link)
            finally:
                await link.close()

    return asyncio.run(run())


async def until(is_so: Callable[[], bool], within_s: float = 20) -> None:
    async with asyncio.timeout(within_s):
        while not is_so():
            await asyncio.sleep(0.01)


async def send_and_start(link: Any, plan: Plan) -> None:
    await send_all(link, routes_for(plan, link))
    await start_all(link, routes_of(plan))


def test_orders_wait_for_the_start_and_then_go_on_for_ever(port: int) -> None:
    plan, agvs = two(), [Agv("a"), Agv("b")]

    async def fly(link: Any) -> None:
        await send_all(link, routes_for(plan, link))
        assert [agv.paused for agv in agvs] == [True, True]
        assert [len(agv.passed) for agv in agvs] == [1, 1]
        await start_all(link, routes_of(plan))
        await until(lambda: len(agvs[0].passed) > 30)
        report = link.latest("a")
        assert report.mode == "running"
        assert report.battery == pytest.approx(0.7)
        assert report.position_m[:2] in [(-10.0, 0.0), *LOOP]
        assert not link.rejections

    with_link(port, plan, agvs, fly)
    assert agvs[0].passed[:2] == [(-10.0, 0.0), (0.0, 0.0)]
    for k, place in enumerate(agvs[0].passed[2:]):
        assert place == LOOP[k % 4]
    assert agvs[1].passed == [(0.0, 60.0), (20.0, 60.0)]
    assert len(agvs[0].taken) > 10
    waits = [status for ident, status in agvs[0].actions.items() if ":" in ident]
    assert waits.count("FINISHED") >= 7  # the wait at the second corner, every round


def test_pausing_stops_it_and_home_is_over_planned_legs(port: int) -> None:
    plan, agv = one(), Agv("a")

    async def fly(link: Any) -> int:
        await send_and_start(link, plan)
        await until(lambda: len(agv.passed) > 8)
        await link.pause("a")
        count = len(agv.passed)
        await asyncio.sleep(0.1)
        assert len(agv.passed) == count
        assert link.latest("a").mode == "paused"
        await link.come_home("a")
        await until(lambda: agv.place == (-10.0, 0.0))
        return count

    count = with_link(port, plan, [agv], fly)
    driven = (count - 2) % 4  # stops of its round, after the start and the loop's beginning
    ahead = LOOP[driven:] if driven else []
    assert without_repeats(agv.passed[count:]) == without_repeats(
        [agv.passed[count - 1], *ahead, (0.0, 0.0), (-10.0, 0.0)]
    )


def without_repeats(places: list[tuple[float, float]]) -> list[tuple[float, float]]:
    return [place for k, place in enumerate(places) if k == 0 or place != places[k - 1]]


@pytest.mark.parametrize(
    ("ways", "message"),
    [
        (Ways(refuses=True), "robot b: the order: orderError"),
        (Ways(keeps=0), "robot b: read back, its route is another one: it holds 0 nodes of 1; it holds 0 edges of 1"),
        (Ways(cannot_pause=True), "robot b: startPause: the vehicle failed to"),
    ],
    ids=["refuses", "keeps a part", "cannot pause"],
)
def test_no_vehicle_keeps_an_order_where_one_fails(port: int, ways: Ways, message: str) -> None:
    plan, agvs = two(), [Agv("a"), Agv("b", ways)]
    with pytest.raises(LinkError) as caught:
        with_link(port, plan, agvs, lambda link: send_all(link, routes_for(plan, link)))
    assert str(caught.value).splitlines() == [message, "no robot holds a route: all were cleared"]
    assert [(agv.nodes, agv.paused) for agv in agvs] == [([], False)] * 2
    assert agvs[0].passed == [(-10.0, 0.0)]


@pytest.mark.parametrize(
    ("ways", "message"),
    [
        (Ways(deaf=True), "robot b: being heard: not done within 0.5 s"),
        (Ways(map_id="hall"), r"robot b: it is on the map 'hall'; 'map' is needed \(--set map_id=\)"),
        (Ways(automatic=False), "robot b: it is not in the operating mode AUTOMATIC and takes no orders"),
    ],
)
def test_vehicles_that_cannot_drive_the_plan_are_told_first(port: int, ways: Ways, message: str) -> None:
    agvs = [Agv("a"), Agv("b", ways)]
    with pytest.raises(LinkError, match=message):
        with_link(port, two(), agvs, lambda link: send_all(link, routes_of(two())), wait_s=0.5)
    assert agvs[0].taken == []


def test_a_vehicle_that_dies_on_its_way_is_told_with_what_the_broker_knows(port: int) -> None:
    agv = Agv("a", Ways(dies_at=5))

    async def fly(link: Any) -> None:
        await send_and_start(link, one())
        await until(lambda: agv.dead)
        await link.pause("a")

    with pytest.raises(LinkError, match=r"robot a: startPause: not done within 0\.5 s"):
        with_link(port, one(), [agv], fly, answer_s=0.5)


def test_messages_of_others_malformed_ones_and_those_from_the_future_are_dropped(port: int) -> None:
    agv, stranger = Agv("a"), Agv("z")

    async def listen(link: Any) -> None:
        async with Client("127.0.0.1", port) as client:
            before, known = link.latest("a"), dropped(link)
            good = agv.state()
            bad = [
                (stranger.topic("state"), json.dumps(stranger.state())),
                (agv.topic("state"), b"\xff\xfe"),
                (agv.topic("state"), "[" * 100_000),
                (agv.topic("state"), json.dumps(told_at(agv, 3600))),
                (agv.topic("state"), json.dumps(told_at(agv, -3600))),
                (agv.topic("state"), json.dumps({**good, "agvPosition": {**good["agvPosition"], "x": float("nan")}})),
                (agv.topic("state"), json.dumps({**good, "agvPosition": {**good["agvPosition"], "x": 1e8}})),
                (agv.topic("state"), json.dumps({**good, "lastNodeSequenceId": -1})),
                (agv.topic("state"), json.dumps({**good, "errors": [{"errorType": 3}]})),
                (agv.topic("state"), b"x" * (1 << 21)),
                (agv.topic("connection"), json.dumps({"connectionState": "MAYBE"})),
            ]
            for topic, payload in bad:
                await client.publish(topic, payload)
            await until(lambda: dropped(link) >= known + len(bad))
            assert dropped(link) == known + len(bad)
            assert link.latest("a") == before
            agv.place = (5.0, 5.0)
            await client.publish(agv.topic("state"), json.dumps(agv.state()))
            await until(lambda: link.latest("a") != before)
            assert link.latest("a").position_m[:2] == (5.0, 5.0)

    with_link(port, one(), [agv], listen)


def test_vehicles_of_another_manufacturer_are_named(port: int) -> None:
    agv = Agv("a")

    async def run() -> None:
        async with Client("127.0.0.1", port) as client:
            await client.publish("uagv/v2/acme/x7/connection", json.dumps(agv.connection("ONLINE")), qos=1, retain=True)
            link = make_link("vda5050", one(), [f"port={port}", "wait_s=0.3"])
            with pytest.raises(LinkError, match=r"robot a: being heard: .*; rota/a is needed, .* knows of acme/x7"):
                await link.open()
            await link.close()
            await client.publish("uagv/v2/acme/x7/connection", b"", qos=1, retain=True)

    asyncio.run(run())


def test_an_order_update_that_was_lost_comes_again(port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rota.links.vda5050_vehicle.ASK_AGAIN_S", 0.03)
    agv = Agv("a", Ways(loses=2))

    async def fly(link: Any) -> None:
        await send_and_start(link, one())
        await until(lambda: len(agv.passed) > 20)

    with_link(port, one(), [agv], fly, released=8, announced=2)
    assert [order.endswith(":2") for order in agv.taken].count(True) >= 2


@pytest.mark.slow  # counts memory over many messages
def test_a_hundred_thousand_malformed_messages_leave_nothing_behind() -> None:
    agv, rng = Agv("a"), random.Random(1)
    good = json.dumps(agv.state()).encode()
    junk = []
    for _ in range(1000):
        at, count = rng.randrange(len(good)), rng.randrange(1, 20)
        junk.append(good[:at] + rng.randbytes(count) + good[at + count :])

    async def take() -> int:
        link: Any = make_link("vda5050", one())
        link._clock.begin()
        for k in range(100):
            if k == 90:
                tracemalloc.start()
            for payload in junk:
                await link._take(agv.topic("state"), payload)
        kept = tracemalloc.get_traced_memory()[0]
        tracemalloc.stop()
        assert kept < 100_000
        return dropped(link)

    assert asyncio.run(take()) > 95_000


def test_a_broker_that_nobody_runs_or_that_refuses_is_named(tmp_path: Path) -> None:
    async def nothing(_link: Any) -> None:
        raise AssertionError("it was opened")

    def opened(number: int, **own: Any) -> None:
        async def run() -> None:
            link = make_link("vda5050", one(), [f"port={number}", *(f"{key}={value}" for key, value in own.items())])
            try:
                await link.open()
            finally:
                await link.close()

        asyncio.run(run())

    passwords, mine, wrong = tmp_path / "passwords", tmp_path / "mine", tmp_path / "wrong"
    subprocess.run(["mosquitto_passwd", "-b", "-c", passwords, "rota", "secret"], check=True)
    passwords.chmod(0o644)
    mine.write_text("secret\n")
    wrong.write_text("guess\n")
    with broker(tmp_path, "allow_anonymous false", f"password_file {passwords}") as number:
        for own in ({}, {"username": "rota", "password_file": wrong}):
            with pytest.raises(
                LinkError, match=f"the broker 127.0.0.1:{number} cannot be used: .*[Nn]ot authori[sz]ed"
            ):
                opened(number, **own)
        with pytest.raises(LinkError, match=r"robot a: being heard: not done within 0\.2 s"):
            opened(number, username="rota", password_file=mine, wait_s=0.2)
    with pytest.raises(LinkError, match=f"the broker 127.0.0.1:{number} cannot be used: .*refused"):
        opened(number)


def test_tls_is_spoken_with_a_broker_that_can_prove_itself(tmp_path: Path) -> None:
    key, certificate = tmp_path / "key.pem", tmp_path / "certificate.pem"
    made = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost"]
    made += ["-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", certificate]
    subprocess.run(made, check=True, capture_output=True)
    key.chmod(0o644)

    async def open_with(*given: str) -> None:
        link = make_link("vda5050", one(), [f"port={number}", "tls=true", "wait_s=0.2", *given])
        try:
            await link.open()
        finally:
            await link.close()

    with broker(tmp_path, f"certfile {certificate}", f"keyfile {key}") as number:
        with pytest.raises(LinkError, match=r"robot a: being heard: not done within 0\.2 s"):
            asyncio.run(open_with(f"ca_file={certificate}"))
        with pytest.raises(LinkError, match=r"cannot be used: .*certificate"):
            asyncio.run(open_with())


def test_a_broker_that_goes_away_and_comes_back_is_found_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rota.links.vda5050_broker.RETRY_S", 0.05)
    monkeypatch.setattr("rota.links.vda5050_vehicle.ASK_AGAIN_S", 0.05)
    plan, agv = one(), Agv("a")

    async def run() -> None:
        with broker(tmp_path) as number:
            link = make_link(
                "vda5050", plan, [f"port={number}", "released=2", "announced=1", "wait_action=wait:duration"]
            )
            async with driving(number, agv):
                await link.open()
                await send_and_start(link, plan)
                await until(lambda: len(agv.passed) > 5)
        try:
            await until(lambda: f"the broker 127.0.0.1:{number} is lost" in link.trouble)
            with pytest.raises(LinkError, match=r"the broker .* is lost"):
                await link.pause("a")
            before, passed = link.latest("a"), len(agv.passed)
            with broker(tmp_path, port=number):
                async with driving(number, agv):
                    await until(lambda: link.trouble == "")
                    # it drives on to the end of what it has, and gets more, also where an update was lost
                    await until(lambda: len(agv.passed) > passed + 8)
                    assert link.latest("a").time_s > before.time_s
                    await link.pause("a")
                await link.close()
        finally:
            await link.close()

    asyncio.run(run())


def test_a_task_that_swallows_cancellations_is_ended() -> None:
    async def run() -> int:
        swallowed = 0

        async def stubborn() -> None:
            nonlocal swallowed
            while swallowed < 2:
                try:
                    await asyncio.sleep(60)
                except asyncio.CancelledError:
                    swallowed += 1

        task = asyncio.create_task(stubborn())
        await asyncio.sleep(0)
        await asyncio.wait_for(end_task(task), 10)
        return swallowed

    assert asyncio.run(run()) == 2


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("ca_file=x.pem", "vda5050.ca_file: is for tls only"),
        ("password_file=x", "vda5050.password_file: is for a username only"),
        ("released=0", r"vda5050\.released: 0 is not allowed; it must be at least 1"),
        ("start_time=noon", r"vda5050\.start_time: 'noon' is not allowed; a date and time in ISO 8601"),
    ],
)
def test_bad_settings_are_refused(given: str, message: str) -> None:
    with pytest.raises(RotaError, match=message):
        make_link("vda5050", one(), [given])


def test_names_that_topics_cannot_hold_are_refused() -> None:
    with pytest.raises(PlanError, match="serial number 'a/b'"):
        make_link("vda5050", plan_of(loop_of("a/b", 0.0)))


def test_files_that_are_not_there_are_named(port: int) -> None:
    for given, message in (
        (["username=me", "password_file=/nowhere"], r"vda5050\.password_file: /nowhere: cannot be read"),
        (["tls=true", "ca_file=/nowhere"], r"vda5050\.ca_file: /nowhere: cannot be used"),
    ):
        link = make_link("vda5050", one(), [f"port={port}", *given])
        with pytest.raises(RotaError, match=message):
            asyncio.run(link.open())
