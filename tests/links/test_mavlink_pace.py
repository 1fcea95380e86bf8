"""A vehicle on its mission: where and when it begins, and what it is told when it is late or early."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from tests.links.fleets import ORIGIN, loop_of

from rota.errors import LinkError
from rota.files.geodesy import Projection
from rota.files.mission_items import DO_CHANGE_SPEED
from rota.links.mavlink_items import wire_items
from rota.links.mavlink_pace import DO_PAUSE_CONTINUE, MissionPace
from rota.routes.route import RouteStop, route_of

ITEMS = wire_items(route_of(loop_of("a", 0.0), 25.0), Projection(ORIGIN), "ardupilot")


class Vehicle:
    """On its way to an item; it writes down what it is told."""

    mode, autopilot, item = "running", "ardupilot", 0

    def __init__(self) -> None:
        self.told: list[int] = []

    async def command(self, _: str, number: int, __: Any) -> None:
        self.told.append(number)


def told(item: int, late_s: float, least_m_s: float = 8.0) -> list[int]:
    vehicle: Any = Vehicle()
    pace = MissionPace(vehicle, ITEMS, RouteStop(place_m=(0, 0, 25), speed_m_s=5.0), 8.0)
    vehicle.item = pace.first + item
    asyncio.run(pace.keep(late_s, 1.0, least_m_s))
    return vehicle.told  # type: ignore[no-any-return]


def test_one_that_is_late_is_told_to_hurry_on_every_leg_and_one_that_is_early_is_paused() -> None:
    assert [told(leg, 1.5) for leg in range(5)] == [[DO_CHANGE_SPEED]] * 5
    assert told(0, 0.2) == []
    assert told(0, -0.5) == []
    assert told(0, -0.61) == [DO_PAUSE_CONTINUE] * 2
    assert told(0, -0.61, least_m_s=1.0) == []  # not just before a sharp corner, where it would lose much more


def test_a_pause_that_is_refused_where_a_waypoint_is_reached_is_tried_again_before_it_is_an_error() -> None:
    class Refuses(Vehicle):
        refuses = True

        async def command(self, what: str, number: int, params: Any) -> None:
            await super().command(what, number, params)
            if self.refuses:
                raise LinkError("refused with result 4")

    vehicle: Any = Refuses()
    pace = MissionPace(vehicle, ITEMS, RouteStop(place_m=(0, 0, 25), speed_m_s=5.0), 8.0)
    vehicle.item = pace.first
    asyncio.run(pace.keep(-0.65, 1.0))
    vehicle.refuses = False
    asyncio.run(pace.keep(-0.65, 1.0))
    assert vehicle.told == [DO_PAUSE_CONTINUE] * 3  # refused; stands and goes on
    vehicle.refuses = True
    asyncio.run(pace.keep(-0.65, 1.0))
    with pytest.raises(LinkError, match="refused with result 4"):
        asyncio.run(pace.keep(-0.65, 1.0))


def test_one_whose_route_begins_with_a_wait_begins_with_the_leg_after_it() -> None:
    vehicle: Any = Vehicle()
    goes = MissionPace(vehicle, ITEMS, RouteStop(place_m=(0, 0, 25), speed_m_s=5.0), 8.0)
    waits = MissionPace(vehicle, ITEMS, RouteStop(place_m=(0, 0, 25), speed_m_s=None, hold_s=2.4), 8.0)
    assert (goes.waits_s, waits.waits_s) == (0.0, 2.4)
    later = MissionPace(vehicle, ITEMS, RouteStop(place_m=(0, 0, 25), speed_m_s=None, hold_s=2.4), 8.0, 0.5)
    assert (later.waits_s, later.first) == (2.9, waits.first)
    assert goes.first is not None
    assert waits.first is not None
    assert waits.first == next(item.seq for item in ITEMS if item.command == 16 and item.seq > goes.first)
