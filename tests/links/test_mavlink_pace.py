"""A vehicle on its mission: where it begins, and what it is told where its firmware makes it late for a while."""

from __future__ import annotations

import asyncio
from typing import Any

import numpy as np
from tests.links.fleets import ORIGIN, loop_of

from rota.files.geodesy import Projection
from rota.files.mission_items import DO_CHANGE_SPEED
from rota.links.mavlink_items import wire_items
from rota.links.mavlink_pace import DO_PAUSE_CONTINUE, MissionPace
from rota.routes.route import RouteStop, route_of

ITEMS = wire_items(route_of(loop_of("a", 0.0), 25.0), Projection(ORIGIN), "ardupilot")
LAGS_S = np.array([0.0, 2.0, 0.5, -0.5, 0.0])


class Vehicle:
    """On its way to an item; it writes down what it is told."""

    mode, autopilot, item = "running", "ardupilot", 0

    def __init__(self) -> None:
        self.told: list[int] = []

    async def command(self, _: str, number: int, __: Any) -> None:
        self.told.append(number)


def told(item: int, late_s: float, lags_s: Any) -> list[int]:
    vehicle: Any = Vehicle()
    pace = MissionPace(vehicle, ITEMS, RouteStop(place_m=(0, 0, 25), speed_m_s=5.0), 8.0, lags_s)
    vehicle.item = pace.first + item
    asyncio.run(pace.keep(late_s, 1.0))
    return vehicle.told  # type: ignore[no-any-return]


def test_one_that_is_as_late_as_its_firmware_makes_it_is_left_alone() -> None:
    first = next(item.seq for item in ITEMS[1:] if item.command == 16)
    late = [number for number in range(first, first + 5) if told(number - first, 1.5, None) == [DO_CHANGE_SPEED]]
    assert len(late) == 5  # without that, it is told to hurry on every leg
    assert told(0, 1.5, LAGS_S) == []  # it is on the leg at whose end it is 2 s late
    assert told(0, 3.0, LAGS_S) == [DO_CHANGE_SPEED]
    assert told(0, -0.9, LAGS_S) == []
    assert told(0, -1.02, LAGS_S) == [DO_PAUSE_CONTINUE] * 2


def test_one_whose_route_begins_with_a_wait_begins_with_the_leg_after_it() -> None:
    vehicle: Any = Vehicle()
    goes = MissionPace(vehicle, ITEMS, RouteStop(place_m=(0, 0, 25), speed_m_s=5.0), 8.0)
    waits = MissionPace(vehicle, ITEMS, RouteStop(place_m=(0, 0, 25), speed_m_s=None, hold_s=2.4), 8.0)
    assert (goes.waits_s, waits.waits_s) == (0.0, 2.4)
    assert goes.first is not None
    assert waits.first is not None
    later = [item.seq for item in ITEMS if item.command == 16 and item.seq > goes.first]
    assert waits.first == later[0]
