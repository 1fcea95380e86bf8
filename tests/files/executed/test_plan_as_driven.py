"""What formats make of plans, beside the plans themselves and what the vehicles' sources say of rounding."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest
from pyproj import Geod
from shapely import box
from tests.files.two_robots import two_robots, with_heights
from tests.files.with_mass import CORNERS, with_mass

from rota.check.motion import motion_violations
from rota.check.routes import commensurable_classes
from rota.errors import PlanError
from rota.exports import FORMATS
from rota.files.executed.mavlink import exactly, read_items, read_qgroundcontrol, read_waypoints
from rota.files.executed.plan_as_driven import DRIVEN, plan_as_driven
from rota.files.mission_items import Item
from rota.files.plan_table import csv_text
from rota.model.mission import Robot
from rota.model.plan import Floats, Plan, Trajectory

PLAN = two_robots(robots=("a", "b"))
# metres that places may be off by their digits, and seconds that times may be
DIGITS = {
    "csv": (0, 0),
    "geojson": (2e-8, 1e-9),
    "kml": (2e-8, 2e-9),
    "gpx": (2e-8, 2e-9),
    "qgroundcontrol": (8e-3, 4e-3),
    "qgroundcontrol-px4": (8e-3, 4e-3),
    "waypoints": (8e-3, 4e-3),
    "dji-wpml": (2e-8, 1e-8),
    "nav2": (0, 1e-9),
    "vda5050": (0, 1e-9),
    "rosbag2": (0, 1e-9),
    "rosbag2-sqlite3": (0, 1e-9),
    "rosbag1": (0, 1e-9),
}
WHOLE_WAITS = ("qgroundcontrol", "waypoints", "dji-wpml")


def place_at(trajectory: Trajectory, time_s: float) -> Floats:
    start, duration = trajectory.loop_start_s, trajectory.loop_duration_s
    if time_s > start:
        time_s = start + (time_s - start) % duration if duration else start
    return np.array([np.interp(time_s, trajectory.times_s, column) for column in trajectory.positions_m.T])


def test_every_format_is_judged_but_the_one_that_judges_itself() -> None:
    # programs that only react do not drive the plan at all
    assert set(FORMATS) - set(DRIVEN) == {"create2-sketch", "create2-reactive"}
    assert set(DIGITS) == set(DRIVEN) <= set(FORMATS)


@pytest.mark.parametrize("name", DIGITS)
def test_robots_are_where_they_were_to_be_but_for_digits(name: str) -> None:
    off_m, off_s = DIGITS[name]
    made = plan_as_driven(PLAN, name)
    assert made.mission == PLAN.mission
    for planned, driven in zip(PLAN, made, strict=True):
        assert driven.robot == planned.robot
        assert abs(driven.loop_duration_s - planned.loop_duration_s) <= off_s
        # at the instants at which it leaves a place, since whole seconds of waits come late
        leaving = planned.times_s[np.append(np.diff(planned.times_s) > 0, False)]
        if name in WHOLE_WAITS:
            leaving = leaving[np.abs(leaving - 24) > 1e-9]
        for time_s in leaving.tolist():
            np.testing.assert_allclose(
                place_at(driven, time_s), place_at(planned, time_s), atol=off_m + 8 * off_s + 1e-9
            )


def test_a_table_gives_the_very_numbers() -> None:
    assert plan_as_driven(PLAN, "csv").trajectories == PLAN.trajectories
    assert plan_as_driven(with_heights(), "csv").trajectories == with_heights().trajectories


@pytest.mark.parametrize("name", [name for name in DIGITS if name != "vda5050"])
def test_heights_are_driven(name: str) -> None:
    plan = with_heights()
    made = plan_as_driven(plan, name)
    assert [trajectory.positions_m.shape[1] for trajectory in made] == [3, 2]
    # an autopilot takes off to the fleet's altitude and climbs from there
    climbing = made.trajectories[0]
    after_s = climbing.times_s[np.abs(climbing.positions_m[:, 2] - 30) < 0.02][0]
    for time_s in (0, 10, 20, 35):
        driven, planned = place_at(climbing, after_s + time_s), place_at(plan.trajectories[0], time_s)
        np.testing.assert_allclose(driven, planned, atol=0.02)


@pytest.mark.parametrize("name", ["nav2", "dji-wpml", "kml"])
def test_an_approach_begins_at_the_height_of_its_first_position(name: str) -> None:
    plan = with_heights()
    rising = Trajectory(
        robot="a", times_s=[0, 5, 15, 25], positions_m=[[0, 0, 32], [0, 10, 30], [50, 0, 40], [0, 10, 30]],
        loop_start_s=5,
    )  # fmt: skip
    (made, _) = plan_as_driven(replace(plan, trajectories=(rising, plan.trajectories[1])), name)
    np.testing.assert_allclose(made.positions_m[:4], rising.positions_m, atol=2e-8)
    np.testing.assert_allclose(made.times_s[:4], rising.times_s, atol=1e-8)


@pytest.mark.parametrize("name", ["geojson", "kml", "gpx", "dji-wpml"])
def test_files_of_degrees_keep_what_touches_and_what_shares_a_period(name: str) -> None:
    plan = replace(PLAN, mission=replace(PLAN.mission, area=box(0, 0, 200, 100), obstacles=(), zones=(), period_s=35))
    rounds = (1, 2, 3)  # 9.5, 19 and 28.5 s long, at full speed along the border
    robots = tuple(Robot(name=f"r{k}", speed_m_s=8, sensor=PLAN.mission.fleet.sensor) for k in rounds)
    fleet = replace(PLAN.mission.fleet, robots=robots)
    loops = tuple(
        Trajectory(robot=f"r{k}", times_s=[0, 4.75 * k, 9.5 * k], positions_m=[[0, 0], [38 * k, 0], [0, 0]])
        for k in rounds
    )
    touching = Plan(mission=replace(plan.mission, fleet=fleet), trajectories=loops)
    made = plan_as_driven(touching, name)
    assert motion_violations(made) == []
    assert len(set(commensurable_classes([trajectory.loop_duration_s for trajectory in made])[0].tolist())) == 1


def mission(*items: tuple[int, list[float | None]]) -> list[Item]:
    return [Item(command, 3, params) for command, params in items]


# x = y = 0 is the origin; the second place is 1e-3 degrees north of it
HERE, THERE = (-33.8567844, 151.2152967), (-33.8557844, 151.2152967)
NORTH_M = Geod(ellps="WGS84").inv(*HERE[::-1], *THERE[::-1])[2]


def to_and_fro(hold_s: float, speed_m_s: float = 5.0) -> list[Item]:
    return mission(
        (22, [0, 0, 0, None, *HERE, 25]),
        (16, [0, 0, 0, None, *HERE, 25]),
        (178, [1, speed_m_s, -1, 0, 0, 0, 0]),
        (16, [hold_s, 0, 0, None, *THERE, 25]),
        (178, [1, 4, -1, 0, 0, 0, 0]),
        (177, [2, -1, 0, 0, 0, 0, 0]),
    )


def flown(items: list[Item], autopilot: str) -> Trajectory:
    first = PLAN.trajectories[0]
    return exactly(first, read_items(PLAN, first, items, autopilot))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("autopilot", "hold_s", "kept_s"),
    [("ardupilot", 1.5, 1), ("px4", 1.5, 1.5), ("ardupilot", 1e5, 65535), ("px4", 1e5, 1e5)],
)
def test_autopilots_keep_waits_as_their_sources_say(autopilot: str, hold_s: float, kept_s: float) -> None:
    made = flown(to_and_fro(hold_s), autopilot)
    assert made.loop_duration_s == pytest.approx(NORTH_M / 5 + kept_s + NORTH_M / 4, abs=1e-3)


def test_the_file_is_judged_and_not_what_was_meant() -> None:
    # the first leg of the first round is flown at the vehicle's own speed, since nothing else was told by then
    made = flown(to_and_fro(0, speed_m_s=100), "px4")
    assert made.loop_duration_s == pytest.approx(NORTH_M / 8 + NORTH_M / 4, abs=1e-3)
    np.testing.assert_allclose(place_at(made, NORTH_M / 8), [0, NORTH_M], atol=0.02)
    with pytest.raises(PlanError, match="robot a: command 20 is none that a route is made of"):
        flown(mission((22, [0, 0, 0, None, *HERE, 25]), (20, [0] * 7)), "px4")


def test_ardupilot_takes_what_is_left_of_a_wait_from_the_leg_before() -> None:
    looping = plan_as_driven(PLAN, "waypoints").trajectories[0]
    # it comes to the second corner a third of a second late, waits a whole second, and leaves in time
    at_corner = looping.times_s[np.abs(looping.positions_m[:, 0] - 100) < 0.02][:2]
    np.testing.assert_allclose(at_corner, [24 + 1 / 3, 76 / 3], atol=4e-3)


def test_a_robot_that_is_told_to_be_faster_than_it_can_comes_late() -> None:
    fast = Trajectory(
        robot="a", times_s=[0, 0.3334, 0.6668], positions_m=[[0, 0], [8 / 3 + 4e-4, 0], [0, 0]], loop_start_s=0
    )
    robots = (Robot(name="a", speed_m_s=8 + 2e-3, sensor=PLAN.mission.fleet.sensor),)
    fleet = replace(PLAN.mission.fleet, robots=robots)
    plan = Plan(mission=replace(PLAN.mission, fleet=fleet), trajectories=(fast,))
    (made,) = plan_as_driven(plan, "kml")
    legs_m = np.linalg.norm(np.diff(made.positions_m, axis=0), axis=1)
    assert (legs_m / np.diff(made.times_s) <= (8 + 2e-3) * (1 + 1e-9)).all()
    assert made.times_s[1] > 0.333


CLOCKED = ("csv", "geojson", "kml", "gpx", "rosbag2", "rosbag2-sqlite3", "rosbag1")
STOP_BY_STOP = ("qgroundcontrol", "qgroundcontrol-px4", "waypoints", "dji-wpml", "nav2", "vda5050")


def test_formats_with_mass_are_these() -> None:
    assert {*CLOCKED, *STOP_BY_STOP} == set(DRIVEN)


@pytest.mark.parametrize("name", CLOCKED)
def test_files_with_a_clock_speed_up_and_brake_within_five_centimetres(name: str) -> None:
    plan = with_mass()
    made = plan_as_driven(plan, name)
    assert made.mission.fleet == plan.mission.fleet.changing_speed_at_once()
    driven, planned = made.trajectories[0], plan.trajectories[0]
    assert driven.loop_start_s == pytest.approx(planned.loop_start_s, abs=1e-8)
    assert driven.loop_duration_s == pytest.approx(planned.loop_duration_s, abs=1e-8)
    moments = np.linspace(0, 300, 5000)
    off_m = np.linalg.norm(driven.at(moments) - planned.at(moments), axis=1)
    assert off_m.max() < (1e-9 if name == "csv" else 0.05 + 1e-6)


@pytest.mark.parametrize("name", STOP_BY_STOP)
def test_files_of_stops_hold_the_corners_and_the_top_speeds(name: str) -> None:
    plan = with_mass()
    driven = plan_as_driven(plan, name).trajectories[0]
    k = driven.loop_index
    found = driven.positions_m[k + 1 :]
    found = found[np.append(True, (np.diff(found, axis=0) != 0).any(axis=1))]
    first = int(np.linalg.norm(found, axis=1).argmin())
    np.testing.assert_allclose(np.roll(found, -first, axis=0), CORNERS, atol=1e-2 + 1e-6)
    # wherever it stops it is there when it was to be there, but for whole seconds of waits
    planned = plan.trajectories[0]
    assert driven.loop_duration_s == pytest.approx(planned.loop_duration_s, abs=1e-2)
    for corner in (CORNERS[0], CORNERS[3]):
        there = np.linalg.norm(driven.positions_m - corner, axis=1) < 2e-2
        assert np.linalg.norm(planned.at(driven.times_s[there]) - corner, axis=1).max() < 2e-2


def test_files_of_stops_tell_the_greatest_speeds() -> None:
    plan = with_mass()
    folded = [read_waypoints(plan, plan.trajectories[0]), read_qgroundcontrol(plan, plan.trajectories[0], "px4")]
    for told_stops in folded:
        assert [stop.speed_m_s for stop in told_stops.every_round] == pytest.approx([8, 8, 8, 8])


def test_a_table_gives_speeds_and_accelerations() -> None:
    plan = with_mass()
    rows = list(csv.DictReader(io.StringIO(csv_text(plan))))
    moving = [row for row in rows if row["robot"] == "a"]
    given = plan.trajectories[0].accelerations_m_s2
    assert given is not None
    assert [float(row["acceleration_m_s2"]) for row in moving[:-1]] == given.tolist()
    speeds = [float(row["speed_m_s"]) for row in moving]
    assert max(speeds) == pytest.approx(8)
    assert [speeds[0], speeds[-1]] == pytest.approx([0, 0], abs=1e-9)
    legs = np.diff([float(row["t_s"]) for row in moving])
    places = np.array([[float(row["x_m"]), float(row["y_m"])] for row in moving])
    lengths = np.linalg.norm(np.diff(places, axis=0), axis=1)
    np.testing.assert_allclose(speeds[:-1] * legs + given * legs**2 / 2, lengths, atol=1e-9)
    assert {row["acceleration_m_s2"] for row in rows if row["robot"] == "b"} == {"0.0"}
    assert "speed_m_s" not in csv_text(PLAN)
