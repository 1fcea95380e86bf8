"""DJI's waylines: the template as djikmz reads it, the executable file as lxml does, beside what DJI documents."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from djikmz.model import KML, Waypoint
from lxml import etree
from pyproj import Geod
from tests.driven_with_mass import reach
from tests.files.two_robots import ORIGIN, two_robots, with_heights
from tests.files.with_mass import CORNERS, ONCE, with_mass

from rota.errors import PlanError, RotaError
from rota.files import dji_waylines
from rota.files.dji_waylines import WaylineSettings, write_dji_waylines
from rota.model.mission import GeoPoint
from rota.model.plan import Plan, Trajectory

GEOD = Geod(ellps="WGS84")
NAMES = {"k": "http://www.opengis.net/kml/2.2", "w": "http://www.dji.com/wpmz/1.0.2"}
STOP, PASS = "toPointAndStopWithDiscontinuityCurvature", "coordinateTurn"


def kmz_documents(path: Path) -> tuple[bytes, bytes]:
    with zipfile.ZipFile(io.BytesIO(path.read_bytes())) as archive:
        assert archive.testzip() is None
        assert archive.namelist() == ["wpmz/template.kml", "wpmz/waylines.wpml"]
        return archive.read("wpmz/template.kml"), archive.read("wpmz/waylines.wpml")


def read_by_djikmz(template: bytes) -> KML:
    # djikmz calls gimbalPitchMode, which DJI asks for, by another name, and stops at the right one
    known = template.replace(b"<wpml:gimbalPitchMode>manual</wpml:gimbalPitchMode>\n", b"")
    assert len(known) < len(template)
    kml = KML.from_xml(known.decode())
    assert isinstance(kml, KML)
    return kml


def hover_s(waypoint: Waypoint) -> float:
    return sum(action.hover_time for action in waypoint.action_group.actions) if waypoint.action_group else 0


def metres(lon: float, lat: float) -> tuple[float, float]:
    azimuth, _, distance = GEOD.inv(ORIGIN.lon, ORIGIN.lat, lon, lat)
    return distance * np.sin(np.radians(azimuth)), distance * np.cos(np.radians(azimuth))


def test_djikmz_reads_whole_rounds_with_speeds_and_waits(tmp_path: Path) -> None:
    plan = two_robots()
    looping, staying = write_dji_waylines(plan, tmp_path / "dji", WaylineSettings(duration_s=200, drone="M30T"))
    kml = read_by_djikmz(kmz_documents(looping)[0])
    assert kml.mission_config.drone_info.drone_model == "M30T"
    assert kml.mission_config.finish_action == "goHome"
    read = kml.waypoints
    assert [waypoint.waypoint_id for waypoint in read] == list(range(len(read)))
    # 4 s to the loop, then 61.5 s a round: three end within 200 s
    places = [(-20, 0), (0, 0), *[(100, 1 / 3), (100, 50), (0, 50), (0, 0)] * 3]
    np.testing.assert_allclose([metres(w.longitude, w.latitude) for w in read], places, atol=1e-3)
    assert {waypoint.height for waypoint in read} == {25}
    assert [hover_s(waypoint) for waypoint in read] == [0, 0, *[1, 0, 0, 0] * 3]
    # the third of a second that is left of the wait makes the leg before it slower
    round_m_s = [np.hypot(100, 1 / 3) / (20 + 1 / 3), (50 - 1 / 3) / (35.5 - 76 / 3), 5, 50 / 10.0004]
    expected = [5, *round_m_s * 3, round_m_s[-1]]
    assert [waypoint.speed for waypoint in read] == pytest.approx(expected, rel=1e-12)
    modes = [waypoint.turn_param.waypoint_turn_mode for waypoint in read]
    assert modes == [STOP, PASS, *[STOP, PASS, PASS, PASS] * 2, STOP, PASS, PASS, STOP]
    there = read_by_djikmz(kmz_documents(staying)[0])
    assert there.mission_config.finish_action == "noAction"
    stays = [metres(waypoint.longitude, waypoint.latitude) for waypoint in there.waypoints]
    np.testing.assert_allclose(stays, [(200, 200), (200, 90)], atol=1e-3)


# what DJI's pages "waylines.wpml" and "Common elements" ask of each element, by the path to it
DOCUMENTED: dict[str, Callable[[str], bool]] = {
    "w:missionConfig/w:flyToWaylineMode": {"safely", "pointToPoint"}.__contains__,
    "w:missionConfig/w:finishAction": {"goHome", "noAction", "autoLand", "gotoFirstWaypoint"}.__contains__,
    "w:missionConfig/w:exitOnRCLost": {"goContinue", "executeLostAction"}.__contains__,
    "w:missionConfig/w:executeRCLostAction": {"goBack", "landing", "hover"}.__contains__,
    "w:missionConfig/w:takeOffSecurityHeight": lambda text: 2 <= float(text) <= 1500,
    "w:missionConfig/w:globalTransitionalSpeed": lambda text: 0 < float(text) <= 15,
    "w:missionConfig/w:droneInfo/w:droneEnumValue": lambda text: int(text) == 77,
    "w:missionConfig/w:droneInfo/w:droneSubEnumValue": lambda text: int(text) == 0,
    "k:Folder/w:templateId": lambda text: 0 <= int(text) <= 65535,
    "k:Folder/w:waylineId": lambda text: 0 <= int(text) <= 65535,
    "k:Folder/w:autoFlightSpeed": lambda text: 0 < float(text) <= 15,
    "k:Folder/w:executeHeightMode": {"relativeToStartPoint"}.__contains__,
}
OF_WAYPOINTS: dict[str, Callable[[str], bool]] = {
    "k:Point/k:coordinates": lambda text: all(abs(float(number)) <= 180 for number in text.split(",")),
    "w:index": lambda text: 0 <= int(text) <= 65535,
    "w:executeHeight": lambda text: float(text) == 25,
    "w:waypointSpeed": lambda text: 0 < float(text) <= 15,
    "w:waypointHeadingParam/w:waypointHeadingMode": {"followWayline"}.__contains__,
    "w:waypointHeadingParam/w:waypointHeadingPathMode": {"followBadArc"}.__contains__,
    "w:waypointTurnParam/w:waypointTurnMode": {STOP, PASS}.__contains__,
}
OF_WAITS: dict[str, Callable[[str], bool]] = {
    "w:actionGroupId": lambda text: 0 <= int(text) <= 65535,
    "w:actionGroupStartIndex": lambda text: 0 <= int(text) <= 65535,
    "w:actionGroupEndIndex": lambda text: 0 <= int(text) <= 65535,
    "w:actionGroupMode": {"sequence"}.__contains__,
    "w:actionTrigger/w:actionTriggerType": {"reachPoint"}.__contains__,
    "w:action/w:actionId": lambda text: int(text) == 0,
    "w:action/w:actionActuatorFunc": {"hover"}.__contains__,
    "w:action/w:actionActuatorFuncParam/w:hoverTime": lambda text: int(text) > 0,
}


def one(element: etree._Element, path: str) -> str:
    (found,) = element.findall(path, NAMES)
    assert found.text is not None
    return found.text


def test_the_executable_file_has_what_dji_documents(tmp_path: Path) -> None:
    path, _ = write_dji_waylines(two_robots(), tmp_path / "dji", WaylineSettings(duration_s=200))
    template, waylines = (etree.fromstring(text) for text in kmz_documents(path))
    (document,) = waylines.findall("k:Document", NAMES)
    for name, allows in DOCUMENTED.items():
        assert allows(one(document, name)), name
    placemarks = document.findall("k:Folder/k:Placemark", NAMES)
    assert [int(one(placemark, "w:index")) for placemark in placemarks] == list(range(14))
    groups = []
    for placemark in placemarks:
        for name, allows in OF_WAYPOINTS.items():
            assert allows(one(placemark, name)), name
        turns = placemark.findall("w:waypointTurnParam/w:waypointTurnDampingDist", NAMES)
        passes = one(placemark, "w:waypointTurnParam/w:waypointTurnMode") == PASS
        assert [0 < float(turn.text or "") <= 0.2 for turn in turns] == [True] * passes
        for group in placemark.findall("w:actionGroup", NAMES):
            groups.append(int(one(group, "w:actionGroupId")))
            for name, allows in OF_WAITS.items():
                assert allows(one(group, name)), name
            assert {one(group, f"w:actionGroup{end}Index") for end in ("Start", "End")} == {one(placemark, "w:index")}
    assert groups == [0, 1, 2]
    # both documents hold the same waypoints
    for name in ("k:Point/k:coordinates", "w:waypointSpeed", "w:waypointTurnParam/w:waypointTurnMode"):
        shown = [one(placemark, name) for placemark in template.findall("k:Document/k:Folder/k:Placemark", NAMES)]
        assert shown == [one(placemark, name) for placemark in placemarks]


def test_turns_fit_between_points_that_lie_close_to_each_other(tmp_path: Path) -> None:
    dense = Trajectory(
        robot="a", times_s=np.arange(9.0), positions_m=[[0.3 * x, 0] for x in (0, 1, 2, 3, 4, 3, 2, 1, 0)]
    )
    plan = two_robots(robots=("a", "b"))
    (path,) = write_dji_waylines(replace(plan, trajectories=(dense,)), tmp_path / "dji", WaylineSettings(duration_s=1))
    document = etree.fromstring(kmz_documents(path)[1])
    turns = document.findall(".//w:waypointTurnDampingDist", NAMES)
    assert [float(turn.text or "") for turn in turns] == pytest.approx([0.12] * 7)


def test_heights_of_their_own_are_flown_and_one_place_makes_two_waypoints(tmp_path: Path) -> None:
    plan = with_heights()
    climbing, _ = write_dji_waylines(plan, tmp_path / "dji", WaylineSettings(duration_s=1))
    read = read_by_djikmz(kmz_documents(climbing)[0]).waypoints
    assert [waypoint.height for waypoint in read] == [30, 40.125, 30]
    hover = Trajectory(robot="a", times_s=[0.0], positions_m=[[5, 5]])
    (path,) = write_dji_waylines(replace(two_robots(robots=("a", "b")), trajectories=(hover,)), tmp_path / "hover")
    assert [waypoint.height for waypoint in read_by_djikmz(kmz_documents(path)[0]).waypoints] == [26, 25]


def test_a_robot_that_is_as_fast_as_dji_flies_is_so_whatever_rounding_makes_of_its_times(tmp_path: Path) -> None:
    fast = Trajectory(robot="a", times_s=[0, 10, 20 - 2e-12], positions_m=[[0, 0], [150, 0], [0, 0]])
    assert 150 / (fast.times_s[2] - fast.times_s[1]) > 15
    plan = replace(two_robots(robots=("a", "b")), trajectories=(fast,))
    (path,) = write_dji_waylines(plan, tmp_path / "dji", WaylineSettings(duration_s=1))
    read = read_by_djikmz(kmz_documents(path)[0]).waypoints
    assert {waypoint.speed for waypoint in read} == {15.0}


def refused(plan: Plan, folder: Path, match: str) -> None:
    with pytest.raises(PlanError, match=match):
        write_dji_waylines(plan, folder)
    assert not folder.exists()


def test_what_dji_cannot_fly_is_refused_before_anything_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "dji"
    plan = two_robots(robots=("a", "b"))
    refused(two_robots(origin=None), folder, "without an origin .* which DJI WPML needs; give --origin LAT,LON")
    with pytest.raises(RotaError, match=r"--set\.drone: \"Mavic\" is not allowed; M300, .* or M4T is needed"):
        WaylineSettings(drone="Mavic")  # type: ignore[arg-type]
    fast = Trajectory(robot="b", times_s=[0, 10, 20], positions_m=[[0, 0], [151, 0], [0, 0]])
    refused(
        replace(plan, trajectories=(plan.trajectories[0], fast)),
        folder,
        "robot b: a leg at 15.1 m/s; DJI waylines take at most 15 m/s: plan with a lower fleet.speed_m_s",
    )
    high = replace(plan, mission=replace(plan.mission, fleet=replace(plan.mission.fleet, altitude_m=1501)))
    refused(high, folder, "robot a: a place 1501 m over the take-off point; DJI waylines take at most 1500 m")
    monkeypatch.setattr(dji_waylines, "MOST_WAYPOINTS", 5)
    refused(plan, folder, "robot a: its approach and one round have 6 waypoints; a DJI wayline has at most 5")


def test_more_rounds_than_a_wayline_holds_are_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dji_waylines, "MOST_WAYPOINTS", 13)
    path, _ = write_dji_waylines(
        two_robots(origin=GeoPoint(lat=0, lon=0)), tmp_path / "dji", WaylineSettings(duration_s=1e6)
    )
    assert len(read_by_djikmz(kmz_documents(path)[0]).waypoints) == 2 + 2 * 4


def test_the_same_plan_gives_the_same_bytes(tmp_path: Path) -> None:
    paths = [write_dji_waylines(two_robots(), tmp_path / name) for name in ("one", "two")]
    assert [path.read_bytes() for path in paths[0]] == [path.read_bytes() for path in paths[1]]
    with pytest.raises(PlanError, match="another robot's file"):
        write_dji_waylines(two_robots(robots=("A", "a")), tmp_path / "three")


def test_planned_corners_are_cut_from_where_their_curves_begin(tmp_path: Path) -> None:
    path, _ = write_dji_waylines(with_mass(), tmp_path / "dji", WaylineSettings(duration_s=150))
    waylines = etree.fromstring(kmz_documents(path)[1])
    turns = waylines.iterfind(".//w:waypointTurnDampingDist", NAMES)
    found = [turn_m for turn_m in (float(turn.text or "") for turn in turns) if turn_m > 0.2]
    # past (100, 20) at 4 m/s and (90, 80) at 3 m/s, and on the way to the loop at 4 m/s
    ways = [(CORNERS[0:3], 4.0), (CORNERS[1:4], 3.0), (ONCE, 4.0)]
    steps = [([step / np.linalg.norm(step) for step in np.diff(way, axis=0)], speed) for way, speed in ways]
    first, second, before = (reach(*u, speed, 2.5) for u, speed in steps)
    assert found[:3] == pytest.approx([before, first, second], rel=1e-6)
    assert found[3:] == pytest.approx([first, second] * ((len(found) - 3) // 2), rel=1e-6)
