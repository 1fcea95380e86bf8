"""The MAVLink link by MAVSDK, against autopilots on loopback that do and do not do as they should."""

from __future__ import annotations

import asyncio
import random
import socket
import time
from collections.abc import Awaitable, Callable
from contextlib import aclosing
from dataclasses import replace
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mav
from shapely import Polygon
from tests.links.autopilot import FENCE, MISSION, RALLY, Autopilot, Script, flying
from tests.links.fleets import dropped, loop_of, plan_of, routes_of, staying, three

from rota.errors import LinkError, PlanError, RotaError
from rota.files.geodesy import Projection
from rota.files.mission_items import mission_items
from rota.files.rings import circle_ring
from rota.links.flights import Flights
from rota.links.link import Order, Report
from rota.links.link_settings import make_link
from rota.links.mavlink_address import addresses
from rota.links.sending import first_reports, routes_for, send_all, start_all
from rota.model.mission import Obstacle
from rota.model.plan import Plan, Trajectory

pytestmark = pytest.mark.mavsdk
ARDUPILOT = mav.MAV_AUTOPILOT_ARDUPILOTMEGA
TAKEOFF, SPEED, WAYPOINT, LOITER, JUMP = 22, 178, 16, 17, 177
COMMANDS = {"arm": mav.MAV_CMD_COMPONENT_ARM_DISARM, "start": mav.MAV_CMD_MISSION_START}


def with_link(plan: Plan, vehicles: list[Autopilot], what: Callable[[Any], Awaitable[Any]], *given: str) -> Any:
    """What comes of doing something with a link to the vehicles."""
    own = {"wait_s": "20", "answer_s": "15"} | dict(text.split("=", 1) for text in given)
    ports = "+".join(f"udpin://127.0.0.1:{vehicle.port}" for vehicle in vehicles)

    async def run() -> Any:
        link = make_link("mavlink", plan, [f"address={ports}", *(f"{key}={value}" for key, value in own.items())])
        try:
            await link.open()
            return await what(link)
        finally:
            await link.close()

    return asyncio.run(run())


def sending(plan: Plan) -> Callable[[Any], Awaitable[None]]:
    return lambda link: send_all(link, routes_for(plan, link))


def held(vehicle: Autopilot, kind: int = MISSION) -> list[int]:
    return [item.command for item in vehicle.items[kind]]


def test_missions_and_fences_are_sent_read_back_and_found_equal() -> None:
    plan = three()
    with flying(Script(), Script(firmware=ARDUPILOT, delay_s=0.02), Script(drop=9)) as vehicles:
        with_link(plan, vehicles, sending(plan))
        px4, ardupilot, lossy = vehicles
        assert held(px4) == [TAKEOFF, SPEED, WAYPOINT, SPEED, WAYPOINT, WAYPOINT, WAYPOINT, JUMP]
        assert held(ardupilot)[0] == WAYPOINT  # home
        assert held(ardupilot)[1:] == held(px4)
        assert held(lossy) == [TAKEOFF, SPEED, LOITER]
        jump, counted = px4.items[MISSION][-1], ardupilot.items[MISSION][-1]
        assert (jump.param1, jump.param2) == (2, 65535)
        assert (counted.param1, counted.param2) == (3, -1)
        assert held(px4)[int(jump.param1)] == held(ardupilot)[int(counted.param1)] == WAYPOINT
        expected = mission_items(plan, plan.trajectories[0], Projection(plan.mission.origin), autopilot="px4")
        for item, wanted in zip(px4.items[MISSION], expected, strict=True):
            assert (item.x, item.y) == tuple(round(value * 1e7) for value in wanted.params[4:6])
            assert item.z == wanted.params[6]
        corners = [(item.command, item.param1) for item in px4.items[FENCE]]
        inside, outside = mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, mav.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION
        assert corners == [(inside, 4)] * 4 + [(outside, 4)] * 4


def test_circles_are_one_item_of_a_fence_and_too_many_corners_are_refused_before_they_are_sent() -> None:
    plan = plan_of(loop_of("a", 0.0))
    masts = tuple(Obstacle(shape=Polygon(circle_ring((x, 200), 12)), blocks="motion") for x in (200, 300))
    plan = replace(plan, mission=replace(plan.mission, obstacles=masts))
    with flying(Script(firmware=ARDUPILOT)) as vehicles:
        with_link(plan, vehicles, sending(plan))
        circles = [item for item in vehicles[0].items[FENCE] if item.command == mav.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION]
        assert held(vehicles[0], FENCE)[-2:] == [mav.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION] * 2
        assert [item.param1 for item in circles] == pytest.approx([12.0145] * 2, abs=1e-3)
    dented = [Polygon(circle_ring((x, 200), 12) + [[k % 2, 0] for k in range(64)]) for x in (200, 300)]
    ragged = tuple(Obstacle(shape=shape, blocks="motion") for shape in dented)
    plan = replace(plan, mission=replace(plan.mission, obstacles=ragged))
    with flying(Script(firmware=ARDUPILOT)) as vehicles:
        with pytest.raises(LinkError, match="robot a: its fence has 132 points; an ArduCopter holds at most 70: draw"):
            with_link(plan, vehicles, sending(plan))
        assert held(vehicles[0]) == [WAYPOINT]  # home, which clearing leaves
    with flying(Script()) as vehicles:  # PX4 takes them
        with_link(plan, vehicles, sending(plan))
        assert len(held(vehicles[0], FENCE)) == 132


def test_rally_points_are_held_told_of_counted_and_taken_away() -> None:
    plan = plan_of(loop_of("a", 0.0))

    def to(*rally_points: tuple[float, float]) -> Plan:
        fleet = replace(plan.mission.fleet, rally_points=rally_points)
        return replace(plan, mission=replace(plan.mission, fleet=fleet))

    async def send_and_ask(link: Any) -> tuple[str, ...]:
        await sending(two)(link)
        return await link.by_itself("a")  # type: ignore[no-any-return]

    two, eleven = to((100.0, 50.0), (-20.0, 0.0)), to(*((10.0 * k, 0.0) for k in range(11)))
    with flying(Script(firmware=ARDUPILOT)) as vehicles:
        vehicles[0].params.update({"FS_GCS_ENABLE": 1.0, "RTL_ALT": 2000.0, "RALLY_LIMIT_KM": 0.5})
        told = with_link(two, vehicles, send_and_ask)
        assert told[0].endswith(
            "straight, at 20 m or higher, to the nearest of its 2 rally points within 500 m, or else home"
        )
        # ArduCopter::failsafe_gcs_check counts the heartbeats of one ground station alone
        vehicles[0].params["SYSID_MYGCS"] = 255.0
        told = with_link(two, vehicles, send_and_ask)
        assert told[0] == (
            "if this link is lost, it flies its mission on: FS_GCS_ENABLE 1 heeds ground station 255 alone"
            " (SYSID_MYGCS), this is 245 (--set system_id=)"
        )
        assert vehicles[0].heard_from == {245}
        assert "it returns to launch" in with_link(two, vehicles, send_and_ask, "system_id=255")[0]
        assert vehicles[0].heard_from == {245, 255}
        points = vehicles[0].items[RALLY]
        lon, lat = Projection(plan.mission.origin).to_degrees([100.0, -20.0], [50.0, 0.0])
        assert [(point.x, point.y) for point in points] == [
            (round(north * 1e7), round(east * 1e7)) for north, east in zip(lat, lon, strict=True)
        ]
        assert {(point.command, point.frame, point.z) for point in points} == {(mav.MAV_CMD_NAV_RALLY_POINT, 3, 25.0)}
        with pytest.raises(
            LinkError, match=r"robot a: there are 11 rally points \(fleet.rally_points\); an ArduCopter"
        ):
            with_link(eleven, vehicles, sending(eleven))
        assert held(vehicles[0], RALLY) == []
        with_link(two, vehicles, sending(two))
        with_link(plan, vehicles, sending(plan))  # without any of its own
        assert held(vehicles[0], RALLY) == []


def test_a_mission_that_no_ardupilot_holds_is_refused_before_it_is_sent() -> None:
    stop = [[x, y] for x in range(0, 700) for y in (0, 1)]
    winding = Trajectory(robot="a", times_s=range(len(stop) + 1), positions_m=[*stop, stop[0]])
    fast = plan_of(loop_of("a", 0.0))
    plan = Plan(mission=fast.mission, trajectories=(winding,))
    with flying(Script(firmware=ARDUPILOT)) as vehicles:
        with pytest.raises(LinkError, match=r"its mission has \d{4} items; an ArduCopter holds at most 1306, or 650"):
            with_link(plan, vehicles, sending(plan))
        assert held(vehicles[0]) == [WAYPOINT]


def test_ardupilot_holds_what_it_can_keep_of_a_mission() -> None:
    plan = plan_of(staying("a"), loop_of("b", 0.0))
    fleet = replace(plan.mission.fleet, altitude_m=30.123)
    plan = replace(plan, mission=replace(plan.mission, fleet=fleet))
    with flying(Script(firmware=ARDUPILOT), Script(firmware=ARDUPILOT)) as vehicles:
        with_link(plan, vehicles, sending(plan))
        assert held(vehicles[0]) == [WAYPOINT, TAKEOFF, SPEED, LOITER]
        assert {round(item.z, 3) for item in vehicles[1].items[MISSION] if item.command == WAYPOINT} == {0, 30.12}


def test_vehicles_start_hold_and_return_and_say_where_they_are() -> None:
    plan = plan_of(*three().trajectories[:2])

    async def fly(link: Any) -> list[Report]:
        await send_all(link, routes_of(plan))
        await first_reports(link, link.robots)
        await start_all(link, routes_of(plan))
        await link.pause("a")
        await link.come_home("a")
        async with aclosing(link.reports()) as reports, asyncio.timeout(20):
            async for _ in reports:
                latest = [link.latest(robot) for robot in link.robots]
                if latest[0].mode == "returning" and latest[1].battery is not None:  # which an ArduPilot tells if asked
                    break
        return latest

    far = Script(firmware=ARDUPILOT, position=(481000000, 115013430, 30000))
    with flying(Script(), far) as vehicles:
        first, second = with_link(plan, vehicles, fly)
        assert [COMMANDS["arm"] in vehicle.commands for vehicle in vehicles] == [True, True]
        assert [COMMANDS["start"] in vehicle.commands for vehicle in vehicles] == [False, True]
        main_modes = [(mode >> 16 & 255, mode >> 24) for mode in vehicles[0].modes]
        assert [mode for k, mode in enumerate(main_modes) if mode not in main_modes[:k]] == [(4, 4), (4, 3), (4, 5)]
    assert first.position_m == pytest.approx((0, 0, 25), abs=0.02)
    assert second.position_m == pytest.approx((100.0, 0, 30), abs=0.2)  # 1.343e-3 degrees at 48.1 degrees north
    assert (first.battery, second.battery) == (pytest.approx(0.8), pytest.approx(0.8))


@pytest.mark.parametrize(
    ("script", "message"),
    [
        (Script(rejects_item=2), r"robot b: the mission: invalid argument"),
        (Script(silent_after_item=2), r"robot b: the mission: (no answer within 2 s|it has fallen silent)"),
        (Script(keeps_items=3), r"robot b: .*"),
        (
            Script(alters_item=2),
            r"robot b: read back, its route is another one: item 2: waypoint: it holds .* was sent",
        ),
    ],
    ids=["refuses", "falls silent half way", "keeps half", "keeps another"],
)
def test_no_vehicle_keeps_a_mission_where_one_fails(script: Script, message: str) -> None:
    plan = plan_of(*three().trajectories[:2])
    with flying(Script(), script) as vehicles:
        with pytest.raises(LinkError, match=message) as caught:
            with_link(plan, vehicles, sending(plan), f"answer_s={2 if script.silent_after_item else 15}")
        assert held(vehicles[0]) == held(vehicles[0], FENCE) == []
        if script.silent_after_item is None:
            assert held(vehicles[1]) == []
            assert str(caught.value).endswith("no robot holds a route: all were cleared")
        else:
            assert held(vehicles[1]) != []
            assert "robot b: clearing the mission: " in str(caught.value)
            assert "it may still hold its route or a part of it" in str(caught.value)


def test_vehicles_gather_in_the_air_start_together_are_kept_in_phase_and_land() -> None:
    plan = plan_of(*three().trajectories[:2])
    told: list[str] = []

    async def fly(link: Any) -> list[float]:
        routes = routes_of(plan)
        flights = Flights(link, plan.mission, told.append)
        await send_all(link, routes)
        await first_reports(link, link.robots)
        await flights.gather(routes)
        places = [link.latest(robot).position_m for robot in link.robots]
        await start_all(link, routes)
        began_s = link.time_s
        async with asyncio.timeout(20):
            while link.latest("a").mode != "running" or vehicles[0].flight.number != 5:
                await asyncio.sleep(0.05)
            await asyncio.sleep(1.0)  # until it has said so
        await link.keep(Order(robot="a", late_s=4.0, behind_s=0.0, rate=1.0))
        await link.keep(Order(robot="b", late_s=-1.2, behind_s=0.0, rate=1.0))
        assert vehicles[1].paused is False
        assert mav.MAV_CMD_DO_PAUSE_CONTINUE in vehicles[1].commands
        await flights.bring_home()
        return [began_s, *(value for place in places for value in place)]

    pad = [Script(firmware=ARDUPILOT, flies=True, position=(481000000, 115000000 + k * 100, 0)) for k in (0, 1)]
    with flying(*pad) as vehicles:
        began_s, *places = with_link(plan, vehicles, fly)
        assert abs(began_s) < 1.0
        assert places == pytest.approx([-10, 0, 25, 190, 0, 25], abs=0.05)
        # on the way to its place, to the loop, on the leg at 4 m/s with 4 s to make up in 10, on the way home
        assert vehicles[0].speeds_m_s == pytest.approx([8.0, 5.0, 5.6, 8.0, 8.0], abs=0.01)
        assert [vehicle.in_air for vehicle in vehicles] == [False, False]
        assert mav.MAV_CMD_NAV_LAND in vehicles[1].commands
    assert told[0] == "climbing: a, b"
    assert told[-2:] == ["landing: a", "landing: b"]


def test_a_copter_goes_on_after_a_pause_with_the_waypoint_that_it_was_on_its_way_to() -> None:
    plan = plan_of(three().trajectories[0])

    async def fly(link: Any) -> list[int]:
        routes, seen = routes_of(plan), []
        await send_all(link, routes)
        await first_reports(link, link.robots)
        later = [item.seq for item in vehicles[0].items[MISSION] if item.command == WAYPOINT][3]
        await Flights(link, plan.mission, lambda _: None).gather(routes)
        await start_all(link, routes)
        async with asyncio.timeout(20):
            while link.latest("a").mode != "running":
                await asyncio.sleep(0.05)
            vehicles[0].flight.number = later  # it has come so far
            await asyncio.sleep(0.5)  # until it has said so
        await link.pause("a")
        vehicles[0].flight.number = 3  # as where MIS_RESTART lets it begin anew
        await link.start("a")
        seen += [later, vehicles[0].flight.number]
        # who leaves the mission begins it anew
        await link.pause("a")
        await link.go("a", [(-10.0, 0.0, 25.0)])
        await link.start("a")
        return [*seen, vehicles[0].flight.number]

    with flying(Script(firmware=ARDUPILOT, flies=True, position=(481000000, 115000000, 0))) as vehicles:
        later, goes_on, anew = with_link(plan, vehicles, fly)
        assert goes_on == later
        assert anew < later
        speeds = {item.seq: item.param2 for item in vehicles[0].items[MISSION] if item.command == SPEED}
        assert vehicles[0].speeds_m_s[2] == pytest.approx(speeds[max(seq for seq in speeds if seq < later)])


def test_a_vehicle_that_does_not_start_brings_the_others_home() -> None:
    plan = plan_of(*three().trajectories[:2])

    async def fly(link: Any) -> None:
        await send_all(link, routes_of(plan))
        await start_all(link, routes_of(plan))

    with flying(Script(), Script(denies=frozenset({COMMANDS["arm"]}))) as vehicles:
        with pytest.raises(LinkError, match=r"robot b: arming: command denied\ncalled home: a"):
            with_link(plan, vehicles, fly)
        assert vehicles[0].modes[-1] >> 24 == 5


def test_vehicles_of_another_type_and_silent_ones_are_told_at_once() -> None:
    plan = plan_of(*three().trajectories[:2])
    boat = Script(kind=mav.MAV_TYPE_FIXED_WING)
    with flying(Script(), boat) as vehicles:
        with pytest.raises(LinkError, match=r"robot b: the vehicle on .* is a fixed_wing; a multicopter is needed"):
            with_link(plan, vehicles, sending(plan))
        assert held(vehicles[0]) == []
        vehicles[1].silent = True
        began = time.monotonic()
        with pytest.raises(LinkError, match=r"robot b: no vehicle was heard on udpin://127\.0\.0\.1:\d+ within 0\.5 s"):
            with_link(plan, vehicles, sending(plan), "wait_s=0.5")
        assert time.monotonic() - began < 10


def test_an_address_that_somebody_else_has_is_named() -> None:
    plan = plan_of(three().trajectories[0])
    with flying(Script()) as vehicles, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", vehicles[0].port))
        with pytest.raises(LinkError, match=r"robot a: udpin://127\.0\.0\.1:\d+ cannot be used: bind error"):
            with_link(plan, vehicles, sending(plan))


def test_noise_places_that_are_none_and_batteries_that_nobody_knows() -> None:
    plan = plan_of(*three().trajectories[:2])

    async def listen(link: Any) -> tuple[Any, Any, int]:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            for _ in range(5000):
                out.sendto(rng.randbytes(100), ("127.0.0.1", vehicles[0].port))
        await first_reports(link, ["a"])
        while not link.rejections:
            await asyncio.sleep(0.05)
        return link.latest("a"), link.latest("b"), dropped(link)

    rng = random.Random(0)
    nowhere = Script(position=(2_000_000_000, 115000000, 0))
    with flying(Script(battery_percent=-1), nowhere) as vehicles:
        first, second, rejected = with_link(plan, vehicles, listen)
    assert first.battery is None
    assert second is None
    assert rejected > 0


def test_a_plan_without_an_origin_has_no_place_for_vehicles() -> None:
    with pytest.raises(PlanError, match="without an origin it has no place on the globe, which MAVLink needs"):
        make_link("mavlink", plan_of(three().trajectories[0], origin=None))


@pytest.mark.parametrize(
    ("text", "count", "expected"),
    [
        ("udpin://127.0.0.1:14540", 3, [f"udpin://127.0.0.1:{port}" for port in (14540, 14541, 14542)]),
        ("serial:///dev/ttyUSB0:57600", 1, ["serial:///dev/ttyUSB0:57600"]),
        ("tcpout://10.0.0.1:5760+udpin://127.0.0.1:1", 2, ["tcpout://10.0.0.1:5760", "udpin://127.0.0.1:1"]),
    ],
)
def test_addresses_are_given_one_by_one_or_counted_up(text: str, count: int, expected: list[str]) -> None:
    assert addresses(text, count) == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("udpin://127.0.0.1:65534", "with 3 ports from there on"),
        ("serial:///dev/ttyUSB0", "is not allowed for 3 robots"),
        ("a+b", "2 addresses are given; 3 are needed"),
        ("a+b+a", "every robot needs an address of its own"),
        ("a++b", "an address is empty"),
    ],
)
def test_other_addresses_are_refused(text: str, message: str) -> None:
    with pytest.raises(RotaError, match=f"mavlink.address: .*{message}"):
        addresses(text, 3)
