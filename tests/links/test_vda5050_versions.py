"""Vehicles of each version of VDA 5050, how they wait, and what they say that is not as it should be."""

from __future__ import annotations

import asyncio
import json
import math
import random
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from aiomqtt import Client
from tests.links.agv import Agv, Ways, broker, driving
from tests.links.fast_time import FastTime
from tests.links.fleets import dropped, loop_of, plan_of, routes_of
from tests.links.test_vda5050 import until

from rota.errors import LinkError, RotaError
from rota.files.vda5050_versions import VERSION_2_1
from rota.links.link_settings import make_link
from rota.links.sending import routes_for, send_all, start_all
from rota.model.plan import Plan

HOLD_M, HOLD_S = (60.0, 0.0), (17.0, 20.0)  # where the loop waits, and from when to when by plan
TRIGGERED = {
    "protocolFeatures": {
        "mobileRobotActions": [
            {"actionType": "waitForTrigger", "actionScopes": ["NODE"]},
            {"actionType": "trigger", "actionScopes": ["INSTANT"]},
        ]
    }
}


def lingers(kind: str = "FLOAT", scope: str = "NODE", name: str = "noop", key: str = "duration") -> dict[str, Any]:
    action = {"actionType": name, "actionScopes": [scope], "actionParameters": [{"key": key, "valueDataType": kind}]}
    return {"protocolFeatures": {"agvActions": [action]}}


@pytest.fixture(autouse=True)
def hopping(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody waits for the clock because of being early: these vehicles hop from node to node."""
    monkeypatch.setattr("rota.links.vda5050_pace.EARLY_S", math.inf)


@pytest.fixture(scope="module")
def port(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    with broker(tmp_path_factory.mktemp("broker")) as number:
        yield number


def plan() -> Plan:
    return plan_of(loop_of("a", 0.0))


def with_agv(port: int, agv: Agv, what: Callable[[Any], Awaitable[Any]], *given: str, rate: float = 1.0) -> Any:
    """What comes of doing something with a link to one vehicle."""

    async def run() -> Any:
        async with driving(port, agv):
            link = make_link("vda5050", plan(), [f"port={port}", *given])
            try:
                await link.open()
                return await what(link)
            finally:
                await link.close()

    return FastTime(rate=rate).run(run())


async def send_and_start(link: Any) -> None:
    await send_all(link, routes_for(plan(), link))
    await start_all(link, routes_of(plan()))


@pytest.mark.parametrize("version", ["2.0.0", "2.0", "2.1.0", "3.0.0"])
def test_each_vehicle_is_spoken_to_in_its_version(port: int, version: str) -> None:
    agv = Agv("a", Ways(version=version))

    async def fly(link: Any) -> None:
        await send_and_start(link)
        await until(lambda: len(agv.passed) > 12)
        assert link.latest("a").mode == "running"
        assert link.latest("a").battery == pytest.approx(0.7)
        await link.pause("a")
        assert link.latest("a").mode == "paused"
        await link.come_home("a")
        await until(lambda: agv.place == (-10.0, 0.0))
        assert not link.rejections
        assert link.trouble == ""

    with_agv(port, agv, fly, "wait_action=wait:duration")
    assert agv.errors == []


@pytest.mark.parametrize("version", ["1.1.0", "4.0.0", "2.x"])
def test_a_version_that_is_not_spoken_is_told(tmp_path: Path, version: str) -> None:
    agv = Agv("a", Ways(version=version))

    async def run(port: int) -> None:
        async with Client("127.0.0.1", port) as client:
            await client.publish(agv.topic("connection"), json.dumps(agv.connection("ONLINE")), qos=1, retain=True)
            link = make_link("vda5050", plan(), [f"port={port}", "wait_s=2"])
            with pytest.raises(LinkError, match=f"robot a: it speaks VDA 5050 {version}; 2.0, 2.1 and 3.0 are spoken"):
                await link.open()
            await link.close()

    with broker(tmp_path) as port:
        asyncio.run(run(port))


@pytest.mark.parametrize("order", [1, -1])
def test_a_vehicle_is_found_whatever_the_broker_has_kept_of_older_versions(tmp_path: Path, order: int) -> None:
    old, agv = Agv("a", Ways(version="2.1.0")), Agv("a", Ways(version="3.0.0"))

    async def run(port: int) -> None:
        async with Client("127.0.0.1", port) as client:
            for before in [old, Agv("a", Ways(version="1.1.0"))][::order]:
                await client.publish(
                    before.topic("connection"), json.dumps(before.connection("ONLINE")), 1, retain=True
                )
        async with driving(port, agv):
            link = make_link("vda5050", plan(), [f"port={port}"])
            try:
                await link.open()
                await send_and_start(link)
            finally:
                await link.close()

    with broker(tmp_path) as port:
        asyncio.run(run(port))
    assert agv.errors == []


def test_a_refusal_of_the_version_is_told_in_the_vehicle_s_words(port: int) -> None:
    agv = Agv("a", Ways(version="2.0.1"))

    async def pause_as_another(link: Any) -> None:
        vehicle = link._vehicles["a"]
        vehicle.hear_version = lambda *_, **__: vehicle.identity.protocol
        vehicle.identity = replace(vehicle.identity, protocol=VERSION_2_1)
        await link.pause("a")

    with pytest.raises(LinkError, match=r"robot a: startPause: validationError: 2\.1\.0 is not 2\.0\.1"):
        with_agv(port, agv, pause_as_another)


@pytest.mark.parametrize(
    ("ways", "given", "actions"),
    [
        (Ways(factsheet=lingers()), (), [("noop", "duration", 3.0)]),
        (Ways(factsheet=lingers("INTEGER", name="Wait", key="time")), (), [("Wait", "time", 3)]),
        (Ways(version="3.0.0", factsheet=TRIGGERED), (), [("waitForTrigger", "triggerType", ["FLEET_CONTROL"])]),
        (Ways(factsheet=lingers()), ("wait_action=linger:for_s",), [("linger", "for_s", 3.0)]),
        (Ways(factsheet=lingers()), ("wait_action=release",), []),
        (Ways(factsheet=lingers("STRING")), (), []),
        (Ways(factsheet=lingers(scope="INSTANT")), (), []),
        (Ways(factsheet=lingers(name="charge")), (), []),
        (Ways(factsheet={}), (), []),
        (Ways(), (), []),
    ],
    ids=["noop", "whole seconds", "trigger", "given", "release", "text", "instant", "another", "empty", "none"],
)
def test_vehicles_wait_as_their_factsheet_or_a_setting_says(
    port: int, ways: Ways, given: tuple[str, ...], actions: list[tuple[str, str, Any]]
) -> None:
    agv = Agv("a", ways)

    async def fly(link: Any) -> None:
        await send_and_start(link)
        await until(lambda: agv.place == HOLD_M)
        # without an action, what is released ends where it is to wait
        assert bool(agv.nodes and agv.nodes[0]["released"]) == bool(actions)

    with_agv(port, agv, fly, *given)
    found = [(action["actionType"], *action["actionParameters"][0].values()) for action in agv.told[:1]]
    assert [each[:2] for each in found] == [each[:2] for each in actions]
    for (_, _, value), (_, _, planned) in zip(found, actions, strict=True):
        # one that is early by then waits for longer
        assert type(value) is type(planned)
        assert value >= planned


@pytest.mark.parametrize("factsheet", [None, TRIGGERED], ids=["release", "trigger"])
def test_a_wait_ends_when_it_is_time_to_go_on(
    port: int, factsheet: dict[str, Any] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = FastTime(rate=10.0)
    clock.let_links_have_it(monkeypatch)
    agv = Agv("a", Ways(version="3.0.0", factsheet=factsheet))  # it hops to where it is to wait at once
    left_s: list[float] = []

    async def fly(link: Any) -> None:
        await send_and_start(link)
        await until(lambda: agv.place == HOLD_M)
        assert link.latest("a").mode == "running"
        await until(lambda: agv.place != HOLD_M, 40)
        left_s.append(link.time_s)

    with_agv(port, agv, fly, rate=10.0)
    assert left_s[0] == pytest.approx(HOLD_S[1], abs=1.0)


def test_an_update_that_is_refused_is_told_while_it_is(port: int) -> None:
    agv = Agv("a", Ways(refuses_update=2))

    async def fly(link: Any) -> None:
        await send_and_start(link)
        await until(lambda: link.trouble != "")
        assert link.trouble == "robot a: it reports orderUpdateError: too far"
        agv.ways, agv.errors = Ways(), []
        await until(lambda: link.trouble == "")

    with_agv(port, agv, fly, "wait_action=wait:duration", rate=4.0)


def test_a_vehicle_that_has_forgotten_its_order_is_told(port: int) -> None:
    agv = Agv("a")

    async def fly(link: Any) -> None:
        await send_and_start(link)
        await until(lambda: len(agv.passed) > 5)
        assert link.trouble == ""
        agv.ways = Ways(deaf=True)
        agv.order, agv.nodes, agv.edges = None, [], []
        await asyncio.sleep(0.2)  # what it has said before is on its way
        async with Client("127.0.0.1", port) as client:
            await client.publish(agv.topic("state"), json.dumps(agv.state()))
            await until(lambda: link.trouble != "")
        assert link.trouble.startswith("robot a: it does not have its order any more")

    with_agv(port, agv, fly, "wait_action=wait:duration")


def test_a_vehicle_that_is_lost_and_one_that_fails_are_told(port: int) -> None:
    agv = Agv("a", Ways(version="3.0.0"))

    async def listen(link: Any) -> None:
        async with Client("127.0.0.1", port) as client:
            for state, told in (
                ("CONNECTION_BROKEN", "robot a: the broker says that it is CONNECTION_BROKEN"),
                ("ONLINE", ""),
            ):
                await client.publish(agv.topic("connection"), json.dumps(agv.connection(state)), qos=1, retain=True)
                await until(lambda told=told: link.trouble == told)  # type: ignore[misc]
            agv.errors = [{"errorType": "laserError", "errorLevel": "CRITICAL", "errorReferences": []}]
            await client.publish(agv.topic("state"), json.dumps(agv.state()))
            await until(lambda: link.trouble == "robot a: it reports laserError")
            assert link.latest("a").mode == "failed"
            await client.publish(agv.topic("connection"), b"", qos=1, retain=True)

    with_agv(port, agv, listen)


def test_places_between_states_are_taken_from_visualizations(port: int) -> None:
    agv = Agv("a")

    async def listen(link: Any) -> None:
        async with Client("127.0.0.1", port) as client:
            place = agv.state()["agvPosition"]
            await client.publish(
                agv.topic("visualization"), json.dumps({**agv.head(), "agvPosition": {**place, "x": 7.0}})
            )
            await until(lambda: link.latest("a").position_m[0] == 7.0)
            known = dropped(link)
            unknown = {**place, "positionInitialized": False}
            for message in (agv.head(), {**agv.head(), "agvPosition": unknown}, {**agv.head(), "agvPosition": 3}):
                await client.publish(agv.topic("visualization"), json.dumps(message))
            await until(lambda: dropped(link) == known + 1)
            assert link.latest("a").position_m[0] == 7.0

    with_agv(port, agv, listen)


def test_noise_in_factsheets_visualizations_and_versions_is_dropped() -> None:
    rng = random.Random(3)
    agvs = [Agv("a"), Agv("a", Ways(version="3.0.0"))]

    def noise() -> Iterator[tuple[str, bytes]]:
        for agv in agvs:
            sheet = {**agv.head(), **(TRIGGERED if agv.is_3 else lingers())}
            for name, message in (("factsheet", sheet), ("visualization", agv.state()), ("state", agv.state())):
                good = json.dumps(message).encode()
                for _ in range(500):
                    at = rng.randrange(len(good))
                    yield (
                        agv.topic(name),
                        good[:at] + rng.randbytes(rng.randrange(1, 9)) + good[at + rng.randrange(9) :],
                    )
            for version in ("", "2", "3.", "2.1.0.0", "3.0.0 ", "x" * 10_000, None, 3, [], {}):
                yield agv.topic("state"), json.dumps({**agv.state(), "version": version}).encode()
            for listed in ("x", [3], [{"actionType": 3}], [{}], {"a": 1}, None):
                read = {**agv.head(), "protocolFeatures": {"agvActions": listed}}
                yield agv.topic("factsheet"), json.dumps(read).encode()

    async def take() -> None:
        link: Any = make_link("vda5050", plan())
        link._clock.begin()
        for topic, payload in noise():
            await link._take(topic, payload)
        assert dropped(link) > 2000
        vehicle = link._vehicles["a"]
        assert len(vehicle.versions) <= 5
        assert all(len(version) < 300 for version in vehicle.versions.values())
        assert vehicle.trouble == ""

    asyncio.run(take())


@pytest.mark.parametrize("given", ["wait_action=:x", "wait_action=wait:", "wait_action=a b:c", "wait_action=a:b:c"])
def test_actions_that_are_none_are_refused(given: str) -> None:
    with pytest.raises(RotaError, match=r"vda5050\.wait_action: .* is not allowed; NAME:PARAMETER is needed"):
        make_link("vda5050", plan(), [given])
