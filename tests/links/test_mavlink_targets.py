"""Copters driven by timed targets: where they are by them, what a lost link comes to, and what is told before."""

from __future__ import annotations

import asyncio
import math
import threading
import time
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mav
from tests.links.autopilot import Autopilot, Script, flying
from tests.links.fleets import loop_of, plan_of, routes_of
from tests.links.test_mavlink import with_link

from rota.errors import LinkError
from rota.files.geodesy import Projection
from rota.links.air_lead import LATER_S, AirLead, Drag, Gains
from rota.links.flights import Flights
from rota.links.link import Dock, Order, Report
from rota.links.link_settings import make_link
from rota.links.mavlink_targets import Target, TargetStream
from rota.links.rounded_track import RoundedTrack
from rota.links.sending import first_reports, routes_for, send_all, start_all
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger
from rota.model.plan import Charge, Plan, Trajectory, Waypoints

pytestmark = pytest.mark.mavsdk
COPTER = Script(firmware=mav.MAV_AUTOPILOT_ARDUPILOTMEGA, flies=True, position=(481000000, 114998657, 0))
PLAN = plan_of(loop_of("a", 0.0))


async def started(link: Any) -> None:
    await first_reports(link, link.robots)
    await send_all(link, routes_for(PLAN, link))
    await Flights(link, PLAN.mission, lambda _: None).gather(routes_of(PLAN))
    await start_all(link, routes_of(PLAN))


def test_targets_lead_along_the_rounded_way_and_a_copter_that_was_not_heard_goes_on_where_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(AirLead, "step", lambda *_: None)
    track = RoundedTrack(PLAN.trajectories[0], 3.0 / 1.3**2, 1.5)

    async def fly(link: Any) -> tuple[float, float]:
        await started(link)
        await asyncio.sleep(4.0)
        assert link.latest("a").mode == "running"
        phase_s = link._stream.target("a").phase_s
        vehicles[0].silent = vehicles[0].stands = True
        await asyncio.sleep(2.0)
        vehicles[0].silent = False
        await asyncio.sleep(0.5)
        vehicles[0].stands = False
        await asyncio.sleep(1.0)
        return phase_s, link._stream.target("a").phase_s

    with flying(COPTER) as vehicles:
        before_s, after_s = with_link(PLAN, vehicles, fly, "way=targets")
        assert len(vehicles[0].items[0]) <= 1  # no mission, but home
        told = list(vehicles[0].targets)
    assert 2.0 < before_s < 4.0  # it speeds up for some seconds, and loses time by that
    assert before_s < after_s < before_s + 3.0  # not 5.5 s on
    gaps_s = np.diff([at_s for at_s, _ in told])
    assert np.median(gaps_s) == pytest.approx(0.1, abs=0.02)
    assert gaps_s.max() > 0.8  # nothing is sent to a copter that is not heard
    for _, target in told[5::7]:
        place_m = np.array([target.y - 10, target.x])  # its origin is where its route begins, at (-10, 0)
        at_s = track.nearest_s(place_m, 0.0, 20.0, 0.01)
        here = track.at(at_s)
        assert math.dist(here.place_m, place_m) < 0.05
        pace = math.hypot(target.vx, target.vy) / np.linalg.norm(here.velocity_m_s)
        assert pace < 1.01
        assert target.z == pytest.approx(-25.0, abs=0.01)
        assert target.type_mask == 0b110000000000


def test_what_is_late_is_made_up_by_the_pace() -> None:
    async def fly(link: Any) -> list[float]:
        await started(link)
        await asyncio.sleep(3.0)
        target, paces = link._stream.target("a"), []
        for late_s in (1.0, -1.0):
            await link.keep(Order(robot="a", late_s=late_s, behind_s=0.0, rate=1.0))
            await asyncio.sleep(2.0)
            paces.append(target.pace)
        await link.pause("a")
        assert link._stream.target("a") is None
        return paces

    with flying(COPTER) as vehicles:
        assert with_link(PLAN, vehicles, fly, "way=targets", "acceleration_m_s2=6") == pytest.approx(
            [1.2, 0.8], abs=0.01
        )


def charging() -> Plan:
    """A copter that is on its pad for 5 s, flies 20 m away and back in 10, and charges for 25."""
    pad_m, far_m = [-10.0, 0.0], [10.0, 0.0]
    way = Trajectory(
        robot="a", times_s=[0, 5, 10, 15, 40], positions_m=[pad_m, pad_m, far_m, pad_m, pad_m],
        charges=(Charge(charger="pad", from_s=0, until_s=5), Charge(charger="pad", from_s=15, until_s=40)),
    )  # fmt: skip
    mission = plan_of(loop_of("a", 0.0)).mission
    battery = BatteryLimits(endurance_s=60.0, recharge_s=30.0)
    robots = tuple(replace(robot, battery=battery) for robot in mission.fleet.robots or ())
    fleet = replace(mission.fleet, robots=robots, battery=battery)
    chargers = (Charger(name="pad", at=(-10.0, 0.0)),)
    return Plan(mission=replace(mission, fleet=fleet, chargers=chargers), trajectories=(way,))


def test_a_copter_on_its_charger_takes_off_when_it_is_to_leave_and_lands_when_it_is_back() -> None:
    plan = charging()

    async def fly(link: Any) -> None:
        assert link.relieves
        assert link.lead_s == 25 / 2.5 + 5
        await first_reports(link, link.robots)
        routes = routes_for(plan, link)
        await send_all(link, routes)
        await start_all(link, routes)
        stays, leaves = (
            Order(robot="a", late_s=0.0, behind_s=0.0, rate=1.0, dock=Dock(leaves=told, plan_s=5.0))
            for told in (False, True)
        )
        await link.keep(stays)
        assert (mav.MAV_CMD_NAV_TAKEOFF in vehicles[0].commands, vehicles[0].targets) == (False, [])
        await link.keep(leaves)
        assert link.is_in_air("a")
        await link.keep(leaves)  # once is enough
        assert vehicles[0].commands.count(mav.MAV_CMD_NAV_TAKEOFF) == 1
        await asyncio.sleep(3.0)
        assert link._stream.target("a").phase_s == pytest.approx(7.0, abs=1.5)
        await link.keep(Order(robot="a", late_s=0.0, behind_s=0.0, rate=0.0))  # it holds its post
        await asyncio.sleep(3.2)
        held_s = link._stream.target("a").phase_s
        await asyncio.sleep(0.5)
        assert link._stream.target("a").phase_s == held_s
        await link.keep(stays)
        assert not link.is_in_air("a")
        assert link._stream.target("a") is None
        assert vehicles[0].commands[-1] == mav.MAV_CMD_NAV_LAND

    beside = 114998657 + 403  # 3 m east of the pad's middle
    with flying(replace(COPTER, position=(481000000, beside, 0))) as vehicles:
        with_link(plan, vehicles, fly)
        (_, first), (_, last) = vehicles[0].targets[0], vehicles[0].targets[-1]
        assert (first.y, first.z) == (pytest.approx(-3.0, abs=2.0), pytest.approx(-25.0, abs=0.1))  # it leads by some
        assert last.y > 1.0
        assert vehicles[0].flight.height_m == 0.0
        assert vehicles[0].flight.lon * 1e7 == pytest.approx(beside, abs=5)  # where it stood, not in the middle


def test_a_robot_that_is_driven_no_more_gets_no_target_that_was_under_way(monkeypatch: pytest.MonkeyPatch) -> None:
    under_way, sent = threading.Event(), []

    def step(_now_s: float) -> dict[str, float]:
        under_way.set()
        time.sleep(0.05)
        return {}

    monkeypatch.setattr("rota.links.mavlink_targets.send", lambda vehicle, _: sent.append(vehicle))
    stream, target = TargetStream(), SimpleNamespace(vehicle="copter", step=step)
    stream.give("a", target)  # type: ignore[arg-type]
    assert under_way.wait(10)
    assert stream.take("a") is target
    before = list(sent)
    time.sleep(0.3)
    stream.end()
    assert sent == before
    assert "copter" in sent


def test_what_a_copter_does_by_itself_and_lacks_is_told_from_its_parameters() -> None:
    has = {
        "FS_GCS_ENABLE": 1.0, "FS_GCS_TIMEOUT": 5.0, "RTL_ALT": 1500.0, "GUID_TIMEOUT": 3.0, "WPNAV_ACCEL": 250.0,
        "PSC_JERK_XY": 20.0, "FENCE_ENABLE": 1.0, "FENCE_ACTION": 4.0,
    }  # fmt: skip

    async def ask(link: Any) -> tuple[str, ...]:
        return await link.by_itself("a")  # type: ignore[no-any-return]

    def told(vehicles: list[Autopilot], *given: str) -> tuple[str, ...]:
        return with_link(PLAN, vehicles, ask, *given)  # type: ignore[no-any-return]

    with flying(COPTER) as vehicles:
        vehicles[0].params.update(has)
        assert told(vehicles, "way=targets") == (
            "if this link is lost, it stops after 3 s and hovers, and after 5 s it returns to launch (FS_GCS_ENABLE 1),"
            " straight, at 15 m or higher",
            "beyond its fence it brakes, or lands (FENCE_ACTION 4)",
            "for targets WPNAV_ACCEL is 250, 500 is needed; GUID_TIMEOUT is 3, 0.5 s is needed",
        )
        vehicles[0].params.update({"FS_OPTIONS": 2.0, "FENCE_ENABLE": 0.0})
        assert told(vehicles) == (
            "if this link is lost, it flies its mission on (FS_OPTIONS 2)",
            "it does not heed its fence (FENCE_ENABLE 0)",
        )


def test_targets_are_beside_the_way_by_what_the_air_asks_for() -> None:
    track = RoundedTrack(PLAN.trajectories[0], 3.0 / 1.3**2, 1.5)
    projection, heard = Projection(PLAN.mission.origin), Report(robot="a", time_s=0.0, position_m=(0.0, 0.0, 25.0))
    (lon, _), (lat, further) = projection.to_degrees([0.0, 0.0], [0.0, 1.0])
    (_, eastern), (_, _) = projection.to_degrees([0.0, 1.0], [0.0, 0.0])
    metres = 111318.84502145034  # of a degree, as ArduPilot counts
    counted = np.array([(eastern - lon) * metres * math.cos(math.radians(lat)), (further - lat) * metres])
    vehicle: Any = SimpleNamespace(heard_s=math.inf, home_height_m=475.0)
    target = Target(
        vehicle=vehicle, track=track, projection=projection, origin=(float(lat), float(lon), 475.0), height_m=25.0,
        ramp_m_s2=1.5, most=1.2, lead=AirLead(Gains(), Drag()), latest=lambda: heard, phase_s=6.0, pace=1.0, _at_s=0.0,
    )  # fmt: skip
    behind, most_m = AirLead(Gains(), Drag()), 0.0
    for k in range(1, 60):
        heard = replace(heard, position_m=(*track.at(target.phase_s).place_m.tolist(), 25.0))
        fields = target.step(0.1 * k)
        assert fields is not None
        here, then = track.at(6.0 + 0.1 * k), track.at(6.0 + 0.1 * k + LATER_S)
        behind.step(0.1, then.velocity_m_s, then.acceleration_m_s2 - here.acceleration_m_s2)
        for (north, east), (x, y) in (
            (("x", "y"), counted * (here.place_m + behind.off_m)),
            (("vx", "vy"), here.velocity_m_s + behind.velocity_m_s),
            (("afx", "afy"), here.acceleration_m_s2 + behind.acceleration_m_s2),
        ):
            assert (fields[east], fields[north]) == pytest.approx((x, y), abs=0.01)
        most_m = max(most_m, float(np.hypot(*behind.off_m)))
    assert most_m > 0.3


def test_targets_are_for_arducopters() -> None:
    with flying(Script()) as vehicles, pytest.raises(LinkError, match=r"robot a: its autopilot is PX4; way=targets is"):
        with_link(PLAN, vehicles, started, "way=targets")


def test_plans_with_accelerations_are_driven_by_targets_unless_it_is_said_otherwise() -> None:
    (way,) = PLAN.trajectories
    with_mass = replace(PLAN, trajectories=(replace(way, accelerations_m_s2=np.zeros(len(way.times_s) - 1)),))
    told = Waypoints(places_m=way.positions_m[[1, 2, 4]], times_s=[2, 17, 25, 45], speed_m_s=5.0)
    by_waypoints = replace(PLAN, trajectories=(replace(with_mass.trajectories[0], waypoints=told),))
    cases = [(PLAN, []), (PLAN, ["way=targets"]), (with_mass, []), (with_mass, ["way=mission"]), (by_waypoints, [])]
    by_targets = [make_link("mavlink", plan, given).drives_along for plan, given in cases]
    assert by_targets == [False, True, True, False, False]


def test_how_fast_corners_let_a_plan_be_driven_is_known_before() -> None:
    link = make_link("mavlink", PLAN, ["way=targets", "corner_m=0.5", "acceleration_m_s2=2"])
    change = 4 * math.sqrt(2)  # from 4 m/s to 4 m/s, at right angles; where the robot waits it stops
    assert link.most_pace("a") == pytest.approx(math.sqrt(2 / (change**2 / (8 * 0.5))), rel=1e-6)
