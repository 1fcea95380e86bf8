"""Copters that charge on missions of their own: what they hold, when they leave, where they land."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mav
from tests.links.autopilot import MISSION, MISSION_MODES, PX4_HOLD, flying
from tests.links.fleets import routes_of
from tests.links.test_mavlink import held, with_link
from tests.links.test_mavlink_targets import COPTER, charging

from rota.links.flights import Flights
from rota.links.link import Dock, Order
from rota.links.sending import first_reports, routes_for, send_all, start_all
from rota.model.plan import Plan

pytestmark = pytest.mark.mavsdk
BESIDE = 114998657 + 403  # 3 m east of the pad's middle
ON_PAD = replace(COPTER, position=(481000000, BESIDE, 0))


def order(*, leaves: bool, plan_s: float, behind_s: float = 0.0) -> Order:
    return Order(robot="a", late_s=0.0, behind_s=behind_s, rate=1.0, dock=Dock(leaves=leaves, plan_s=plan_s))


def test_a_copter_gets_the_mission_of_its_next_flight_when_it_is_to_leave_and_lands_where_it_stood() -> None:
    """It is on its pad for 5 s, flies 20 m away and back in 10, and charges for 25."""
    plan, flown = charging(), list[int]()

    async def fly(link: Any) -> list[float]:
        vehicle = vehicles[0]
        assert link.relieves
        assert link.lead_s == 25 / 2.5 + 5 + 5
        await first_reports(link, link.robots)
        routes = routes_for(plan, link)
        await send_all(link, routes)
        await start_all(link, routes)
        await link.keep(order(leaves=False, plan_s=5.0))
        assert len(held(vehicle)) <= 1  # no mission, but home
        assert (mav.MAV_CMD_NAV_TAKEOFF in vehicle.commands, vehicle.in_air) == (False, False)
        behind_s = link.time_s + 2.0 - 5.0  # so much was waited for others: it leaves two seconds from now
        leaving = asyncio.create_task(link.keep(order(leaves=True, plan_s=5.0, behind_s=behind_s)))
        await asyncio.sleep(1.0)
        assert (vehicle.in_air, vehicle.flight.number) == (True, 0)  # it has climbed, and hovers
        await leaving
        left_s = link.time_s - behind_s
        await link.keep(order(leaves=True, plan_s=5.0, behind_s=behind_s))  # once is enough
        assert vehicle.commands.count(mav.MAV_CMD_NAV_TAKEOFF) == 1
        async with asyncio.timeout(20):
            while link.latest("a").mode != "running" or link.latest("a").position_m[0] < -8.0:
                await asyncio.sleep(0.05)
            await link.keep(Order(robot="a", late_s=-1.0, behind_s=behind_s, rate=0.0))  # it holds its post
            assert mav.MAV_CMD_DO_PAUSE_CONTINUE in vehicle.commands
            while vehicle.flight.number < len(vehicle.items[MISSION]) - 1 or link.latest("a").position_m[0] > -9.5:
                await asyncio.sleep(0.05)
        there_s = link.time_s - behind_s
        flown.extend(held(vehicle))
        await link.keep(order(leaves=False, plan_s=45.0))
        assert len(held(vehicle)) <= 1
        assert (vehicle.in_air, vehicle.commands[-1]) == (False, mav.MAV_CMD_NAV_LAND)
        return [left_s, there_s]

    with flying(ON_PAD) as vehicles:
        left_s, there_s = with_link(plan, vehicles, fly, "way=mission")
        assert (flown[1], flown[-1]) == (mav.MAV_CMD_NAV_TAKEOFF, mav.MAV_CMD_NAV_LAND)
        assert mav.MAV_CMD_DO_JUMP not in flown
        assert vehicles[0].flight.lon * 1e7 == pytest.approx(BESIDE, abs=5)  # where it stood, not in the middle
    assert left_s == pytest.approx(5.0, abs=0.7)
    assert there_s == pytest.approx(16.0, abs=2.5)


def under_way() -> Plan:
    """The same copter 5 s later: it has just left its pad when the plan begins."""
    plan = charging()
    (way,) = plan.trajectories
    times_s, places_m = [0.0, 5.0, 10.0, 40.0], way.positions_m[[1, 2, 3, 4]]
    charge = replace(way.charges[1], from_s=10.0, until_s=40.0)
    return replace(plan, trajectories=(replace(way, times_s=times_s, positions_m=places_m, charges=(charge,)),))


def test_who_is_under_way_when_the_plan_begins_holds_the_rest_of_that_flight() -> None:
    plan = under_way()

    async def fly(link: Any) -> None:
        await begin(link, plan)
        async with asyncio.timeout(20):
            while vehicles[0].flight.number < len(vehicles[0].items[MISSION]) - 1:
                await asyncio.sleep(0.05)

    with flying(ON_PAD) as vehicles:
        with_link(plan, vehicles, fly, "way=mission")
        assert held(vehicles[0])[-1] == mav.MAV_CMD_NAV_LAND


def test_a_px4_holds_its_post_in_hold_and_goes_on_to_the_same_waypoint() -> None:
    plan, px4 = charging(), replace(ON_PAD, firmware=mav.MAV_AUTOPILOT_PX4)

    async def fly(link: Any) -> None:
        vehicle = vehicles[0]
        vehicle.modes.append(PX4_HOLD)  # as one that was just switched on
        assert link.lead_s == 3 + 10 / 1.5 + 15 / 3 + 5 + 5
        await first_reports(link, link.robots)
        routes = routes_for(plan, link)
        await send_all(link, routes)
        await start_all(link, routes)
        await link.keep(order(leaves=False, plan_s=5.0))
        assert (held(vehicle), vehicle.in_air) == ([], False)
        await mode_of(link, "running")  # it does what its plan asks for
        behind_s = link.time_s + 1.0 - 5.0
        leaving = asyncio.create_task(link.keep(order(leaves=True, plan_s=5.0, behind_s=behind_s)))
        await asyncio.sleep(0.6)
        assert (vehicle.in_air, vehicle.flight.number, vehicle.modes[-1]) == (True, 0, PX4_HOLD)
        await leaving
        assert link.time_s - behind_s == pytest.approx(5.0, abs=0.5)
        assert held(vehicle)[vehicle.flight.number] == mav.MAV_CMD_NAV_WAYPOINT
        async with asyncio.timeout(20):
            while link.latest("a").position_m[0] < -5.0:
                await asyncio.sleep(0.05)
        here = Order(robot="a", late_s=0.0, behind_s=behind_s, rate=0.0)
        await link.keep(here)
        place_m, number = vehicle.flight.lon, vehicle.flight.number
        await asyncio.sleep(0.5)
        await link.keep(here)
        assert (vehicle.modes[-1], vehicle.flight.lon) == (PX4_HOLD, place_m)
        assert link.latest("a").mode == "running"  # as it was told
        told = len(vehicle.speeds_m_s)
        await link.keep(replace(here, rate=1.0))
        assert (vehicle.modes[-1], vehicle.flight.number) == (MISSION_MODES[0], number)
        assert vehicle.speeds_m_s[told:] == [4.0]
        async with asyncio.timeout(20):
            while vehicle.flight.number < len(vehicle.items[MISSION]) - 1 or link.latest("a").position_m[0] > -9.5:
                await asyncio.sleep(0.05)
        await link.keep(order(leaves=False, plan_s=45.0))
        assert (held(vehicle), vehicle.in_air, vehicle.commands[-1]) == ([], False, mav.MAV_CMD_NAV_LAND)

    with flying(px4) as vehicles:
        with_link(plan, vehicles, fly, "way=mission")
        assert vehicles[0].flight.lon * 1e7 == pytest.approx(BESIDE, abs=5)


def test_a_px4_that_somebody_else_has_stopped_is_let_be() -> None:
    plan = under_way()

    async def fly(link: Any) -> None:
        await begin(link, plan)
        await mode_of(link, "running")
        vehicles[0].modes.append(PX4_HOLD)  # by its remote control
        await mode_of(link, "paused")
        for rate in (0.0, 1.0):
            await link.keep(Order(robot="a", late_s=0.0, behind_s=0.0, rate=rate))
        assert vehicles[0].modes[-1] == PX4_HOLD

    with flying(replace(ON_PAD, firmware=mav.MAV_AUTOPILOT_PX4)) as vehicles:
        with_link(plan, vehicles, fly, "way=mission")
        assert vehicles[0].modes[-1] == PX4_HOLD


def test_a_px4_that_holds_its_post_goes_on_when_the_link_ends() -> None:
    plan = under_way()

    async def fly(link: Any) -> None:
        await begin(link, plan)
        await mode_of(link, "running")
        await link.keep(Order(robot="a", late_s=0.0, behind_s=0.0, rate=0.0))
        await asyncio.sleep(0.5)
        assert vehicles[0].modes[-1] == PX4_HOLD

    with flying(replace(ON_PAD, firmware=mav.MAV_AUTOPILOT_PX4)) as vehicles:
        with_link(plan, vehicles, fly, "way=mission")
        assert vehicles[0].modes[-1] == MISSION_MODES[0]


async def begin(link: Any, plan: Plan) -> None:
    """Send and start all as the command does."""
    routes = routes_for(plan, link)
    await send_all(link, routes)
    await first_reports(link, link.robots)
    await Flights(link, plan.mission, lambda _: None).gather(routes_of(plan))
    await start_all(link, routes)


async def mode_of(link: Any, mode: str) -> None:
    """Wait until the copter tells a mode."""
    async with asyncio.timeout(10):
        while link.latest("a").mode != mode:
            await asyncio.sleep(0.05)
