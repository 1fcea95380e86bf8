"""What links make of noise: 100,000 messages that are none, to a vehicle of VDA 5050 and to one of MAVLink."""

from __future__ import annotations

import asyncio
import json
import math
import random
import time
import tracemalloc
from collections.abc import Awaitable, Callable, Iterator
from datetime import UTC, datetime
from types import SimpleNamespace
from typing import Any

from shapely import box

from benchmarks.row import Options, Row
from rota.files.timed_places import instant_text
from rota.links.link_settings import make_link
from rota.links.mavlink_vehicle import MavlinkVehicle
from rota.model.mission import DiscSensor, Fleet, GeoPoint, Mission, Robot, Zone
from rota.model.plan import Plan, Trajectory

MESSAGES, KINDS = 100_000, 1000
MOST_KEPT_KB = 100.0
SHARE_TRACED = 10  # of all messages, one in so many: memory is looked at for the last ones


def link_noise(options: Options) -> Iterator[Row]:
    """Messages go to where the links take them from their libraries; memory is that of Python's own allocations."""
    rng = random.Random(0)
    for name, fed in (("VDA 5050", _vda5050(rng)), ("MAVLink", _mavlink(rng))):
        link, take, junk = fed
        seconds, kept_kb = asyncio.run(_fed(take, junk))
        dropped = sum(rejected.messages for rejected in link.rejections.values())
        measured = f"{dropped:,} dropped, {kept_kb:.1f} kB more at the end, {seconds * 1e6 / MESSAGES:.0f} us each"
        reached = dropped == MESSAGES and kept_kb < MOST_KEPT_KB
        asked = f"all dropped, no crash, less than {MOST_KEPT_KB:g} kB kept"
        yield Row(f"{MESSAGES:,} malformed messages to a {name} link", asked, measured, reached)


async def _fed(take: Callable[[Any], Awaitable[None]], junk: list[Any]) -> tuple[float, float]:
    """CPU seconds that all messages take, and kB that the last tenth of them leave behind."""
    rounds = MESSAGES // len(junk)
    begin = time.process_time()
    for _ in range(rounds - rounds // SHARE_TRACED):
        for message in junk:
            await take(message)
    spent_s = (time.process_time() - begin) * SHARE_TRACED / (SHARE_TRACED - 1)
    tracemalloc.start()
    for _ in range(rounds // SHARE_TRACED):
        for message in junk:
            await take(message)
    kept = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    return spent_s, kept / 1e3


def _vda5050(rng: random.Random) -> tuple[Any, Callable[[Any], Awaitable[None]], list[Any]]:
    """States with bytes, values or whole fields that do not belong there."""
    link: Any = make_link("vda5050", _plan())
    link._clock.begin()
    good = {
        "serialNumber": "a", "version": "2.1.0", "timestamp": instant_text(datetime.now(UTC)), "orderId": "",
        "orderUpdateId": 0, "lastNodeSequenceId": 0, "nodeStates": [], "edgeStates": [], "errors": [],
        "actionStates": [], "operatingMode": "AUTOMATIC", "batteryState": {"batteryCharge": 70.0},
        "agvPosition": {"x": 1.0, "y": 2.0, "mapId": "map", "positionInitialized": True},
    }  # fmt: skip
    text = json.dumps(good).encode()
    others: list[Any] = [None, [], -1, 1e300, "x" * 1000, {"x": math.nan}, True]
    junk: list[Any] = []
    for k in range(KINDS):
        if k % 3 == 0:
            at = rng.randrange(len(text) - 20)
            junk.append(text[:at] + b'"' + rng.randbytes(10))
        elif k % 3 == 1:
            name = rng.choice([key for key in good if key != "orderId"])
            junk.append(json.dumps({**good, name: {"wrong": rng.choice(others)}}).encode())
        else:
            name = rng.choice([key for key in good if key != "agvPosition"])
            junk.append(json.dumps({key: value for key, value in good.items() if key != name}).encode())

    async def take(payload: Any) -> None:
        await link._take("uagv/v2/rota/a/state", payload)

    return link, take, junk


def _mavlink(rng: random.Random) -> tuple[Any, Callable[[Any], Awaitable[None]], list[Any]]:
    """Positions that are no numbers, on no globe, far away or below the ground."""
    link: Any = make_link("mavlink", _plan())
    link._clock.begin()
    vehicle = MavlinkVehicle(robot="a", system=SimpleNamespace(), autopilot="px4", answer_s=1.0)  # type: ignore[arg-type]
    wrong = [math.nan, math.inf, -math.inf, 1e9, -1e9, 90.5 * 4]
    junk = []
    for _ in range(KINDS):
        place = {"latitude_deg": 48.1, "longitude_deg": 11.5, "relative_altitude_m": 10.0}
        for name in rng.sample(sorted(place), rng.randrange(1, 4)):
            place[name] = rng.choice(wrong if name != "relative_altitude_m" else [math.nan, math.inf, 1e9])
        junk.append(SimpleNamespace(**place))

    async def take(position: Any) -> None:
        link._take(vehicle, position)

    return link, take, junk


def _plan() -> Plan:
    sensor = DiscSensor(radius_m=5.0)
    mission = Mission(
        name="noise",
        area=box(0, 0, 20, 20),
        zones=(Zone(name="gate", shape=box(0, 0, 5, 5), period_s=60.0),),
        origin=GeoPoint(lat=48.1, lon=11.5),
        fleet=Fleet(
            speed_m_s=1.0, sensor=sensor, altitude_m=10.0, robots=(Robot(name="a", speed_m_s=1.0, sensor=sensor),)
        ),
    )
    way = Trajectory(robot="a", times_s=[0, 10, 20], positions_m=[[1, 1], [11, 1], [1, 1]])
    return Plan(mission=mission, trajectories=(way,))
