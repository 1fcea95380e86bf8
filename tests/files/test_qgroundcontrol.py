"""QGroundControl plans: item by item, and as MAVSDK's own importer reads them."""

from __future__ import annotations

import json
import math
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyproj import Geod
from shapely import MultiPolygon, Polygon, box

from rota.errors import PlanError, RotaError
from rota.files.qgroundcontrol import trajectory_to_qgroundcontrol, write_qgroundcontrol
from rota.files.rings import circle_ring
from rota.model.mission import DiscSensor, Fleet, GeoPoint, Mission, Obstacle, Robot, Zone
from rota.model.plan import Plan, Trajectory
from rota.planners.swarm.planner_settings import SwarmSettings

ORIGIN = GeoPoint(lat=-33.8567844, lon=151.2152967)
GEOD = Geod(ellps="WGS84")
TAKEOFF, SPEED, WAYPOINT, LOITER, JUMP = 22, 178, 16, 17, 177


def plan_of(*trajectories: Trajectory, origin: GeoPoint | None = ORIGIN, area: MultiPolygon | None = None) -> Plan:
    robots = tuple(Robot(name=t.robot, speed_m_s=8, sensor=DiscSensor(radius_m=40)) for t in trajectories)
    mission = Mission(
        name="quay",
        area=area or MultiPolygon([box(-300, -300, 300, 300)]),
        obstacles=(
            Obstacle(shape=box(150, 150, 160, 160), blocks="motion"),
            Obstacle(shape=box(-160, 150, -150, 160), blocks="sight"),
        ),
        zones=(Zone(name="gate", shape=box(0, 0, 50, 50), period_s=60),),
        origin=origin,
        fleet=Fleet(speed_m_s=8, sensor=DiscSensor(radius_m=40), robots=robots, altitude_m=25),
    )
    return Plan(mission=mission, trajectories=trajectories)


def square_loop(robot: str = "a") -> Trajectory:
    """20 m to the loop, 100 m x 50 m at 5 m/s with a pause of 1.5 s at its second corner."""
    return Trajectory(
        robot=robot,
        times_s=[0, 4, 24, 25.5, 35.5, 55.5, 65.5],
        positions_m=[[-20, 0], [0, 0], [100, 0], [100, 0], [100, 50], [0, 50], [0, 0]],
        loop_start_s=4,
    )


def items_of(plan: Plan, **options: Any) -> list[dict[str, Any]]:
    document = trajectory_to_qgroundcontrol(plan, plan.trajectories[0], **options)
    items: list[dict[str, Any]] = document["mission"]["items"]
    return items


def commands(items: list[dict[str, Any]]) -> list[int]:
    return [item["command"] for item in items]


def metres(item: dict[str, Any]) -> tuple[float, float]:
    """Local metres of an item's place, by geodesics instead of by the projection."""
    azimuth, _, distance = GEOD.inv(ORIGIN.lon, ORIGIN.lat, item["params"][5], item["params"][4])
    return distance * math.sin(math.radians(azimuth)), distance * math.cos(math.radians(azimuth))


def test_a_patrol_takes_off_flies_its_loop_and_jumps_back_for_ever() -> None:
    items = items_of(plan_of(square_loop()), autopilot="px4")
    assert commands(items) == [TAKEOFF, SPEED, WAYPOINT, WAYPOINT, WAYPOINT, WAYPOINT, JUMP]
    assert [item["doJumpId"] for item in items] == [1, 2, 3, 4, 5, 6, 7]
    assert all(len(item["params"]) == 7 and item["autoContinue"] and item["type"] == "SimpleItem" for item in items)
    places = [metres(item) for item in items if item["command"] in (TAKEOFF, WAYPOINT)]
    np.testing.assert_allclose(places, [(-20, 0), (0, 0), (100, 0), (100, 50), (0, 50)], atol=1e-3)
    assert [item["params"][6] for item in items if item["command"] in (TAKEOFF, WAYPOINT)] == [25] * 5
    assert [item["frame"] for item in items] == [3, 2, 3, 3, 3, 3, 2]
    assert items[1]["params"] == [1, 5, -1, 0, 0, 0, 0]
    assert [item["params"][0] for item in items[2:6]] == [0, 1.5, 0, 0]
    assert items[6]["params"] == [3, 65535, 0, 0, 0, 0, 0]


def test_ardupilot_waits_whole_seconds_and_flies_the_leg_before_slower() -> None:
    items = items_of(plan_of(square_loop()))
    assert [item["params"][0] for item in items if item["command"] == WAYPOINT] == [0, 1, 0, 0]
    # half a second of the wait at the second corner goes to the 20 s of the leg before
    speed, legs = math.nan, []
    for item in items:
        speed = item["params"][1] if item["command"] == SPEED else speed
        legs += [speed] if item["command"] == WAYPOINT else []
    assert legs == pytest.approx([5, 100 / 20.5, 5, 5])
    assert items[-1]["params"][:2] == [3, -1]


def test_the_document_is_what_qgroundcontrol_asks_for() -> None:
    plan = plan_of(square_loop(), square_loop("b"))
    document = trajectory_to_qgroundcontrol(plan, plan.trajectories[0])
    assert document["fileType"] == "Plan"
    assert document["version"] == 1
    assert document["rallyPoints"] == {"version": 2, "points": []}
    mission = document["mission"]
    assert {"version", "firmwareType", "vehicleType", "plannedHomePosition", "items", "cruiseSpeed"} <= set(mission)
    assert (mission["version"], mission["firmwareType"], mission["vehicleType"]) == (2, 3, 2)
    assert mission["hoverSpeed"] == 5
    assert mission["plannedHomePosition"] == [*mission["items"][0]["params"][4:6], 0]
    assert "phases between vehicles are the operator's to keep" in document["description"]
    assert "its loop starts 4.0 s after the start and takes 61.5 s" in document["description"]
    assert "together with b" in document["description"]


def test_px4_counts_its_jumps() -> None:
    plan = plan_of(square_loop())
    assert items_of(plan, autopilot="px4")[-1]["params"][:2] == [3, 65535]
    document = trajectory_to_qgroundcontrol(plan, plan.trajectories[0], autopilot="px4")
    assert document["mission"]["firmwareType"] == 12


def test_a_robot_that_stays_loiters_without_end() -> None:
    fly_and_stay = Trajectory(robot="a", times_s=[0, 4], positions_m=[[0, 0], [12, 0]], loop_start_s=4)
    items = items_of(plan_of(fly_and_stay))
    assert commands(items) == [TAKEOFF, SPEED, LOITER]
    assert items[1]["params"][1] == 3
    assert metres(items[2]) == pytest.approx((12, 0), abs=1e-3)
    hover = Trajectory(robot="a", times_s=[0.0], positions_m=[[5, 5]])
    assert commands(items_of(plan_of(hover))) == [TAKEOFF, LOITER]
    waiting = Trajectory(robot="a", times_s=[0.0, 9.0], positions_m=[[5, 5], [5, 5]])
    assert commands(items_of(plan_of(waiting))) == [TAKEOFF, LOITER]


def test_a_delayed_start_waits_before_the_loop_and_only_once() -> None:
    delayed = Trajectory(
        robot="a", times_s=[0, 7, 17, 27], positions_m=[[0, 0], [0, 0], [50, 0], [0, 0]], loop_start_s=7
    )
    items = items_of(plan_of(delayed))
    assert commands(items) == [TAKEOFF, WAYPOINT, SPEED, WAYPOINT, WAYPOINT, JUMP]
    assert [item["params"][0] for item in items if item["command"] == WAYPOINT] == [7, 0, 0]
    assert items[-1]["params"][0] == 4


def test_pauses_at_both_ends_of_the_loop_are_kept() -> None:
    paused = Trajectory(robot="a", times_s=[0, 2, 12, 22, 25], positions_m=[[0, 0], [0, 0], [50, 0], [0, 0], [0, 0]])
    items = items_of(plan_of(paused))
    assert commands(items) == [TAKEOFF, SPEED, WAYPOINT, WAYPOINT, WAYPOINT, JUMP]
    assert [item["params"][0] for item in items if item["command"] == WAYPOINT] == [2, 0, 3]
    assert items[-1]["params"][0] == 3


def test_each_leg_is_flown_at_its_own_speed_in_every_round() -> None:
    # out at 2 m/s, back at 8 m/s; simulated as an autopilot flies the items
    uneven = Trajectory(robot="a", times_s=[0, 20, 30, 35], positions_m=[[0, 0], [40, 0], [40, 80], [0, 0]])
    items = items_of(plan_of(uneven))
    speed, at, flown = math.nan, 0, []
    for _ in range(40):
        item = items[at]
        if item["command"] == SPEED:
            speed = item["params"][1]
        if item["command"] == WAYPOINT:
            flown.append((tuple(round(v) for v in metres(item)), speed))
        at = item["params"][0] - 1 if item["command"] == JUMP else at + 1
    back = math.hypot(40, 80) / 5
    expected = [((40, 0), 2.0), ((40, 80), 8.0), ((0, 0), pytest.approx(back))]
    assert flown[1:10] == expected * 3


def test_heights_of_their_own_are_flown() -> None:
    climbing = Trajectory(robot="a", times_s=[0, 10, 20], positions_m=[[0, 0, 30], [50, 0, 40], [0, 0, 30]])
    flat = plan_of(square_loop())
    swarm = SwarmSettings(controller="reciprocal", altitudes_m=(20, 50))
    flying = replace(flat.mission, zones=(), planning=swarm)
    plan = Plan(mission=flying, trajectories=(climbing,))
    heights = [item["params"][6] for item in items_of(plan) if item["command"] in (TAKEOFF, WAYPOINT)]
    assert heights == [25, 30, 40]


def test_the_fence_is_the_area_less_what_blocks_motion() -> None:
    hole = [(-100, -100), (-90, -100), (-90, -90), (-100, -90)]
    border = [(-300, -300), (300, -300), (300, 300), (-300, 300)]
    area = MultiPolygon([Polygon(border, [hole]), box(400, 0, 410, 10)])
    plan = plan_of(square_loop(), area=area)
    fence = trajectory_to_qgroundcontrol(plan, plan.trajectories[0])["geoFence"]
    assert fence["version"] == 2
    assert [polygon["inclusion"] for polygon in fence["polygons"]] == [True, False, False]
    assert [len(polygon["polygon"]) for polygon in fence["polygons"]] == [4, 4, 4]
    corner = fence["polygons"][0]["polygon"][0]
    _, _, distance = GEOD.inv(ORIGIN.lon, ORIGIN.lat, corner[1], corner[0])
    assert distance == pytest.approx(math.hypot(300, 300), abs=1e-3)


def test_what_was_drawn_as_a_circle_is_one_circle_of_the_fence() -> None:
    ring = circle_ring((200, 150), 12)
    dented = ring.copy()
    dented[7] += 0.01
    mast, bush = Obstacle(shape=Polygon(ring), blocks="motion"), Obstacle(shape=Polygon(dented + 40), blocks="motion")
    plan = plan_of(square_loop())
    plan = replace(plan, mission=replace(plan.mission, obstacles=(mast, bush)))
    fence = trajectory_to_qgroundcontrol(plan, plan.trajectories[0])["geoFence"]
    assert [len(polygon["polygon"]) for polygon in fence["polygons"]] == [4, 64]
    (circle,) = fence["circles"]
    assert circle["inclusion"] is False
    # it contains the polygon that stands for the circle, and not much more
    assert 12 < circle["circle"]["radius"] == pytest.approx(12 / math.cos(math.pi / 64))
    lat, lon = circle["circle"]["center"]
    _, _, distance = GEOD.inv(ORIGIN.lon, ORIGIN.lat, lon, lat)
    assert distance == pytest.approx(math.hypot(200, 150), abs=1e-3)


@pytest.mark.parametrize(("side_m", "fenced"), [(102.9, False), (103.1, True)])
def test_no_fence_closer_to_the_route_than_a_satellite_fix(side_m: float, fenced: bool) -> None:
    area = MultiPolygon([box(-50, -50, side_m, 100)])
    plan = plan_of(square_loop(), area=area)
    document = trajectory_to_qgroundcontrol(plan, plan.trajectories[0])
    assert bool(document["geoFence"]["polygons"]) is fenced
    assert ("No fence" in document["description"]) is not fenced


def test_without_an_origin_there_is_no_plan(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match=r"without an origin .* add origin: \{lat: \.\.\., lon: \.\.\.\}"):
        write_qgroundcontrol(plan_of(square_loop(), origin=None), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_names_make_file_names(tmp_path: Path) -> None:
    paths = write_qgroundcontrol(plan_of(square_loop("../quay 1"), square_loop("Zoë")), tmp_path / "out")
    assert [path.relative_to(tmp_path).as_posix() for path in paths] == ["out/_quay_1.plan", "out/Zoë.plan"]
    with pytest.raises(PlanError, match="robot q 1: another robot's file"):
        write_qgroundcontrol(plan_of(square_loop("Q/1"), square_loop("q 1")), tmp_path / "out")
    with pytest.raises(RotaError, match="is a file"):
        write_qgroundcontrol(plan_of(square_loop()), paths[0])


@contextmanager
def vehicle_heard_by_mavsdk(autopilot: int) -> Iterator[Any]:
    """MAVSDK's raw-mission plugin, connected on loopback to something that beats like an autopilot."""
    from mavsdk import ComponentType, Configuration, ConnectionResult, Mavsdk
    from mavsdk.plugins.mission_raw import MissionRaw
    from pymavlink.dialects.v20 import common

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    link = common.MAVLink(None, srcSystem=1, srcComponent=1)
    done = threading.Event()

    def beat() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            while not done.wait(0.1):
                beat = link.heartbeat_encode(common.MAV_TYPE_QUADROTOR, autopilot, 0, 0, common.MAV_STATE_ACTIVE, 3)
                out.sendto(beat.pack(link), ("127.0.0.1", port))

    heart = threading.Thread(target=beat, daemon=True)
    mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    try:
        assert mavsdk.add_any_connection(f"udpin://127.0.0.1:{port}") == ConnectionResult.SUCCESS
        heart.start()
        system = mavsdk.first_autopilot(30.0)
        assert system is not None, "MAVSDK heard no heartbeat within 30 s"
        plugin = MissionRaw(system)
        yield plugin
        plugin.destroy()
    finally:
        done.set()
        if heart.is_alive():
            heart.join(timeout=10)
        mavsdk.destroy()


def as_float32(value: float | None) -> float:
    return math.nan if value is None else float(np.float32(value))


@pytest.mark.mavsdk
@pytest.mark.parametrize(("autopilot", "firmware"), [("ardupilot", 3), ("px4", 12)])
def test_mavsdk_imports_the_same_items(autopilot: Any, firmware: int, tmp_path: Path) -> None:
    staying = Trajectory(robot="b", times_s=[0, 30], positions_m=[[200, 200], [200, 90]], loop_start_s=30)
    delayed = Trajectory(
        robot="c",
        times_s=[0, 7, 17, 27.25, 30],
        positions_m=[[0, 0], [0, 0], [50, 0.123456], [0, 0], [0, 0]],
        loop_start_s=7,
    )
    plan = plan_of(square_loop(), staying, delayed)
    mast = Obstacle(shape=Polygon(circle_ring((-200, 150), 12)), blocks="motion")
    plan = replace(plan, mission=replace(plan.mission, obstacles=(*plan.mission.obstacles, mast)))
    paths = write_qgroundcontrol(plan, tmp_path / "out", autopilot=autopilot)
    with vehicle_heard_by_mavsdk(firmware) as mavsdk:
        for path in paths:
            document = json.loads(path.read_text())
            imported = mavsdk.import_qgroundcontrol_mission(str(path))
            # ArduPilot's item 0 is home, which is why a jump to doJumpId n is a jump to item n there
            home = imported.mission_items[:1] if autopilot == "ardupilot" else []
            assert [(i.seq, i.command) for i in home] == [(0, WAYPOINT)] * len(home)
            compare_items(document["mission"]["items"], imported.mission_items[len(home) :], len(home))
            corners = [corner for polygon in document["geoFence"]["polygons"] for corner in polygon["polygon"]]
            (circle,) = (each["circle"] for each in document["geoFence"]["circles"])
            assert [(i.x, i.y) for i in imported.geofence_items] == [
                (round(lat * 1e7), round(lon * 1e7)) for lat, lon in [*corners, circle["center"]]
            ]
            assert imported.geofence_items[-1].command == 5004
            assert imported.geofence_items[-1].param1 == as_float32(circle["radius"])


def compare_items(written: list[dict[str, Any]], read: list[Any], first: int) -> None:
    assert len(read) == len(written)
    for number, (ours, theirs) in enumerate(zip(written, read, strict=True), start=first):
        params = ours["params"]
        assert theirs.seq == number
        assert (theirs.command, theirs.frame) == (ours["command"], ours["frame"])
        assert theirs.autocontinue == 1
        assert theirs.mission_type == 0
        found = [theirs.param1, theirs.param2, theirs.param3, theirs.param4]
        np.testing.assert_array_equal(found, [as_float32(value) for value in params[:4]])
        assert (theirs.x, theirs.y) == (round(params[4] * 1e7), round(params[5] * 1e7))
        assert theirs.z == as_float32(params[6])


def test_a_name_that_no_file_can_have_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    plan = plan_of(square_loop("a"), square_loop("b" * 260))
    with pytest.raises(RotaError, match=r"^bbb.*\.\.\.: a file name of 265 bytes; at most 255 are allowed$"):
        write_qgroundcontrol(plan, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    longest = plan_of(square_loop("\u00e4" * 125))
    assert [path.exists() for path in write_qgroundcontrol(longest, tmp_path / "out")] == [True]
