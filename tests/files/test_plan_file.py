"""Plan files: bit for bit round trips, the published schema, and clear refusals."""

from __future__ import annotations

import copy
import dataclasses
import json
import struct
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import shapely
from hypothesis import given, settings, strategies as st
from shapely import MultiPolygon, Polygon, box

from rota.errors import PlanError, RotaError
from rota.files import plan_schema as fields
from rota.files.plan_file import plan_from_json, plan_from_text, plan_text, plan_to_json, read_plan, write_plan
from rota.model.mission import (
    DiscSensor,
    Fleet,
    GeoPoint,
    Mission,
    Obstacle,
    Robot,
    SquareSensor,
    StartBox,
    StartPoints,
    Zone,
)
from rota.model.motion_limits import AT_ONCE, MOTION_FIELDS, MotionLimits
from rota.model.plan import Plan, Trajectory
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.swarm.planner_settings import SwarmSettings


def harbour() -> Plan:
    """A plan that uses every field of the format."""
    sensor = SquareSensor(side_m=0.1 + 0.2)
    robots = (
        Robot(name="Zoë", speed_m_s=1 / 3, sensor=sensor, body_radius_m=0.2, turn_rate_rad_s=0.7, start=(1.5, -0.0)),
        Robot(name="b", speed_m_s=2, sensor=DiscSensor(radius_m=5)),
    )
    holed = Polygon(
        [(0, -5), (90, -5), (90, 90), (0, 90)], [[(10, 10), (20, 10), (20, 20)], [(40, 40), (50, 40), (45, 50)]]
    )
    mission = Mission(
        name="harbour",
        area=MultiPolygon([holed, box(100, 0, 110, 10)]),
        obstacles=(
            Obstacle(shape=box(30, 60, 35, 70)),
            Obstacle(shape=box(60, 60, 65, 70), blocks="sight"),
            Obstacle(shape=box(60, 75, 65, 80), blocks="motion", asks="nothing"),
        ),
        zones=(
            Zone(name="gate", shape=box(1, 1, 5, 5), period_s=7.3),
            Zone(name="tank", shape=box(3, 3, 8, 8), period_s=None, demand="visit"),
        ),
        period_s=40,
        origin=GeoPoint(lat=53.5413871, lon=-9.9836),
        unseeable="refuse",
        fleet=Fleet(
            speed_m_s=2,
            sensor=sensor,
            robots=robots,
            body_radius_m=0.1,
            turn_rate_rad_s=1,
            altitude_m=25,
            start=StartBox(low_m=(70, 0.1), high_m=(80, 0.7)),
            motion=MotionLimits(acceleration_m_s2=1 / 3, jerk_m_s3=0.7, climb_m_s=2, descend_m_s=0.1),
        ),
        planning=PatrolSettings(effort="high", period_margin=0.1, range_margin_m=0.05),
    )
    first = Trajectory(
        robot="Zoë",
        times_s=[0, 0.1, 0.1 + 0.2, 5],
        positions_m=[[1.5, -0.0], [2, 3], [1e-310, 1e5 / 3], [2, 3]],
        headings_rad=[0.0, -0.0, np.pi, 1e-17],
        accelerations_m_s2=[1 / 3, -0.0, 0.1 + 0.2],
        loop_start_s=0.1,
    )
    second = Trajectory(robot="b", times_s=[0.0], positions_m=[[4.0, 4.0]])
    return Plan(mission=mission, trajectories=(first, second), seed=2**70, lower_bound_robots=2)


def bits(values: Any) -> bytes:
    return np.asarray(values, dtype=np.float64).tobytes()


def plan_bits(plan: Plan) -> list[bytes | None]:
    shapes = [plan.mission.area, *(o.shape for o in plan.mission.obstacles), *(z.shape for z in plan.mission.zones)]
    found: list[bytes | None] = [bits(shapely.get_coordinates(shape)) for shape in shapes]
    for t in plan.trajectories:
        found += [bits(t.times_s), bits(t.positions_m), bits([t.loop_start_s])]
        found.append(None if t.headings_rad is None else bits(t.headings_rad))
        found.append(None if t.accelerations_m_s2 is None else bits(t.accelerations_m_s2))
    return found


def test_every_field_survives_the_round_trip(tmp_path: Path) -> None:
    plan = harbour()
    path = tmp_path / "harbour.rota.json"
    write_plan(plan, path)
    again = read_plan(path)
    assert again == plan
    assert plan_bits(again) == plan_bits(plan)
    assert [p.interiors[0].coords[:] for p in again.mission.area.geoms if p.interiors] == [
        [(10, 10), (20, 10), (20, 20), (10, 10)]
    ]
    assert struct.pack("d", again.mission.fleet.robots[0].start[1]) == struct.pack("d", -0.0)  # type: ignore[index]
    write_plan(again, tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == path.read_bytes()


finite = st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(min_value=5e-324, max_value=1e10)
length = st.floats(min_value=5e-324, max_value=1e8)
even = st.floats(min_value=1e-323, max_value=1e8)  # half of it is more than 0
coordinate = st.floats(min_value=-1e7, max_value=1e7)


@st.composite
def trajectories(draw: st.DrawFn, robot: str, area: Polygon, width: int) -> Trajectory:
    times = sorted(draw(st.sets(positive, min_size=0, max_size=8)))
    n, (x0, y0, x1, y1) = len(times) + 1, area.bounds
    axes = [st.floats(x0 - 1e6, x1 + 1e6), st.floats(y0 - 1e6, y1 + 1e6), st.floats(-1e6, 1e6)][:width]
    positions = draw(st.lists(st.tuples(*axes), min_size=n, max_size=n))
    loop = draw(st.integers(0, n - 1))
    if times and times[-1] - [0.0, *times][loop] < 1e-6:
        loop = n - 1
    positions[-1] = positions[loop]
    headings = draw(st.none() | st.lists(finite, min_size=n, max_size=n))
    zero = draw(st.sampled_from([0.0, -0.0]))
    lengths_m = np.sqrt((np.diff(np.array(positions), axis=0) ** 2).sum(axis=1))
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        most = np.nan_to_num(2 * lengths_m / np.diff([0.0, *times]) ** 2, nan=0.0, posinf=0.0)
    shares = draw(st.none() | st.lists(st.floats(-1, 1), min_size=n - 1, max_size=n - 1))
    return Trajectory(
        robot=robot,
        times_s=[zero, *times],
        positions_m=positions,
        headings_rad=headings,
        accelerations_m_s2=None if shares is None else most * shares,
        loop_start_s=[zero, *times][loop],
    )


@st.composite
def rectangles(draw: st.DrawFn) -> Polygon:
    x, y = draw(coordinate), draw(coordinate)
    right, top = draw(st.floats(min_value=1e-3, max_value=5e7)), draw(st.floats(min_value=1e-3, max_value=5e7))
    shape = Polygon([(x, y), (x + right, y), (x + right, y + top), (x, y + top)])
    return shape if shape.is_valid and shape.area > 0 else box(-0.0, -0.0, 1, 1)


def one_line(longest: int) -> st.SearchStrategy[str]:
    """Names as missions allow them."""
    letters = st.characters(
        exclude_categories=("Cc", "Cs", "Zl", "Zp"),
        exclude_characters="\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069",
    )
    return st.text(letters, min_size=1, max_size=longest)


motion = st.builds(
    MotionLimits,
    vehicle=st.none() | one_line(9),
    acceleration_m_s2=positive,
    corner_acceleration_m_s2=st.none() | positive,
    jerk_m_s3=st.none() | positive,
    climb_m_s=st.none() | positive,
    descend_m_s=st.none() | positive,
    wind_m_s=st.just(0.0) | positive,
)


@st.composite
def plans(draw: st.DrawFn) -> Plan:
    names = draw(st.lists(one_line(5), min_size=1, max_size=3, unique=True))
    flying = draw(st.booleans())
    sensor = draw(st.builds(DiscSensor, radius_m=length) | st.builds(SquareSensor, side_m=even))
    sensor = DiscSensor(radius_m=1 / 3, half_angle_deg=30) if flying else sensor
    motions = st.just(AT_ONCE) | motion
    robots = tuple(
        Robot(name=name, speed_m_s=draw(positive), sensor=sensor, motion=AT_ONCE if flying else draw(motions))
        for name in names
    )
    area = draw(rectangles())
    swarm = SwarmSettings(controller="reciprocal", altitudes_m=(0.1, 0.7))
    mission = Mission(
        name=draw(one_line(9)),
        area=area,
        obstacles=tuple(Obstacle(shape=draw(rectangles()), blocks="motion") for _ in range(draw(st.integers(0, 2)))),
        zones=(Zone(name="all", shape=area, period_s=None if flying else draw(positive | st.none())),),
        period_s=None if flying else draw(positive),
        origin=draw(st.none() | st.builds(GeoPoint, lat=st.floats(-90, 90), lon=st.floats(-180, 180))),
        fleet=Fleet(
            speed_m_s=draw(positive),
            sensor=sensor,
            robots=robots if flying else draw(st.sampled_from([None, robots])),
            motion=AT_ONCE if flying else draw(motions),
        ),
        planning=swarm if flying else PatrolSettings(),
    )
    bound = draw(st.none() | st.integers(0, 9))
    paths = tuple(draw(trajectories(name, area, 3 if flying else 2)) for name in names)
    return Plan(mission=mission, trajectories=paths, seed=draw(st.integers()), lower_bound_robots=bound)


SCHEMA = jsonschema.Draft202012Validator(fields.plan_schema())


@settings(max_examples=80, deadline=None, derandomize=True)
@given(plans())
def test_any_plan_survives_bit_for_bit_and_fits_the_schema(plan: Plan) -> None:
    text = plan_text(plan)
    again = plan_from_text(text, "plan.json")
    assert again == plan
    assert plan_bits(again) == plan_bits(plan)
    assert json.loads(text) == plan_to_json(plan)
    SCHEMA.validate(json.loads(text))


def test_schema_is_valid_and_refuses_what_reading_refuses() -> None:
    jsonschema.Draft202012Validator.check_schema(fields.plan_schema())
    document = plan_to_json(harbour())
    SCHEMA.validate(document)
    document["mission"]["fleet"]["speed"] = 3
    with pytest.raises(jsonschema.ValidationError, match="speed"):
        SCHEMA.validate(document)


def test_what_a_mission_does_not_limit_is_not_written() -> None:
    plan = harbour()
    told = plan_to_json(plan)
    assert told["mission"]["fleet"]["jerk_m_s3"] == 0.7
    assert told["robots"][0]["accelerations_m_s2"] == [1 / 3, -0.0, 0.1 + 0.2]
    assert "accelerations_m_s2" not in told["robots"][1]
    free = plan.mission.fleet.changing_speed_at_once()
    as_before = plan_to_json(dataclasses.replace(plan, mission=dataclasses.replace(plan.mission, fleet=free)))
    assert not set(MOTION_FIELDS) & set(as_before["mission"]["fleet"])
    assert not any(set(MOTION_FIELDS) & set(robot) for robot in as_before["mission"]["fleet"]["robots"])


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ([0.0], r"robots\[0\].accelerations_m_s2: 1 entries; 3 are needed, one per leg"),
        ([0.0, 0.0, 1e9], r"robots\[0\]: .*accelerations_m_s2\[2\] = 1e\+09; on this leg at most .* m/s2"),
        ([0.0, "fast", 0.0], r'robots\[0\].accelerations_m_s2\[1\]: "fast" is not allowed; a number is needed'),
    ],
)
def test_accelerations_that_no_leg_has_are_refused_with_their_place(values: list[Any], words: str) -> None:
    document = plan_to_json(harbour())
    document["robots"][0]["accelerations_m_s2"] = values
    with pytest.raises(PlanError, match=words):
        plan_from_json(document)


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("acceleration_m_s2", 0, r"mission.fleet.acceleration_m_s2: .*greater than 0"),
        ("corner_m", -1, r"mission.fleet.corner_m: -1 is not allowed; it must be at least 0"),
        ("wind_m_s", "strong", r"mission.fleet.wind_m_s: .*number"),
        ("corner_m", 1, r"mission.fleet: .*corner_m: 1(.0)? is not allowed; must be 0 where turn_rate_rad_s is given"),
        ("top_airspeed_m_s", 1, r"mission.fleet: .*speed_m_s: 2(.0)? is not allowed; must be at most 1"),
        ("corner", 1, r"mission.fleet.corner: unknown key; did you mean 'corner_m'\?"),
    ],
)
def test_limits_of_motion_that_cannot_be_are_refused(field: str, value: Any, words: str) -> None:
    document = plan_to_json(harbour())
    del document["mission_sha256"]
    document["mission"]["fleet"][field] = value
    with pytest.raises(PlanError, match=words):
        plan_from_json(document)


def test_a_bounce_plan_keeps_its_angles_and_a_turn_is_a_leg_without_length() -> None:
    settings = BounceSettings(cell_m=0.5, task="cover", bouncing_angles_deg=(135, 90), start_headings_deg=(45,))
    robots = tuple(Robot(name=name, speed_m_s=0.2, sensor=DiscSensor(radius_m=1)) for name in "ab")
    mission = Mission(
        name="hall",
        area=MultiPolygon([box(0, 0, 5, 5)]),
        fleet=Fleet(speed_m_s=0.2, sensor=DiscSensor(radius_m=1), robots=robots),
        planning=settings,
    )
    turns = Trajectory(
        robot="a",
        times_s=np.array([0.0, 4.0, 8.0]),
        positions_m=np.array([[0.25, 0.25], [0.75, 0.75], [0.75, 0.75]]),
        headings_rad=np.radians([45.0, 45.0, 180.0]),
        loop_start_s=8.0,
    )
    plan = Plan(mission=mission, trajectories=(turns,))
    document = plan_to_json(plan)
    SCHEMA.validate(document)
    assert document["mission"]["bounce"]["bouncing_angles_deg"] == [135.0, 90.0]
    assert plan_from_text(plan_text(plan), "plan.json") == plan
    document["mission"]["bounce"]["bouncing_angles_deg"] = [100.0]
    with pytest.raises(PlanError, match=r"bouncing_angles_deg\[0\]: 100 .* 45 degrees"):
        plan_from_json(document)


def test_points_to_start_from_travel_with_the_plan_and_plans_of_before_have_no_starts() -> None:
    plan = harbour()
    points = StartPoints(points_m=((1.5, 0.1 + 0.2), (80, -4)))
    fewest = dataclasses.replace(plan.mission.fleet, robots=None, start=points)
    plan = Plan(mission=dataclasses.replace(plan.mission, fleet=fewest), trajectories=plan.trajectories)
    document = plan_to_json(plan)
    SCHEMA.validate(document)
    assert plan_from_json(document) == plan
    document["mission"]["fleet"]["start"]["box"] = [[0, 0], [1, 1]]
    with pytest.raises(PlanError, match="exactly one of box and points"):
        plan_from_json(document)
    del document["mission"]["fleet"]["start"], document["mission"]["patrol"]["period_margin"]
    del document["mission"]["patrol"]["range_margin_m"], document["mission_sha256"]
    old = plan_from_json(document).mission
    assert old.fleet.start is None
    assert (PatrolSettings.of(old).period_margin, PatrolSettings.of(old).range_margin_m) == (0, 0)


def test_the_reason_of_the_bound_travels_with_the_plan_and_may_be_absent() -> None:
    told = dataclasses.replace(harbour(), lower_bound_reason="2 places are too far apart")
    document = plan_to_json(told)
    assert document["lower_bound_reason"] == "2 places are too far apart"
    SCHEMA.validate(document)
    assert plan_from_json(document) == told
    # plans of before have none, and stay as they were
    document = plan_to_json(harbour())
    assert "lower_bound_reason" not in document
    assert plan_from_json(document).lower_bound_reason is None
    assert "lower_bound_reason" not in fields.plan_schema()["required"]
    with pytest.raises(PlanError, match="lower_bound_reason"):
        plan_from_json({**document, "lower_bound_reason": 3})


def test_the_mark_of_an_unmet_demand_is_written_and_not_believed() -> None:
    document = plan_to_json(harbour(), meets_demand=False)
    assert document["meets_demand"] is False
    SCHEMA.validate(document)
    assert plan_from_json(document) == harbour()
    assert "meets_demand" not in plan_to_json(harbour())


def test_one_line_per_trajectory() -> None:
    lines = plan_text(harbour()).splitlines()
    assert sum('"times_s"' in line for line in lines) == 2
    assert len(lines) < 30


def set_at(document: Any, place: str, value: Any) -> Any:
    """A copy of the document with the value (or, for ..., nothing) at a place like mission.zones.0.name."""
    changed = copy.deepcopy(document)
    *way, last = [int(part) if part.isdigit() else part for part in place.split(".")]
    holder = changed
    for part in way:
        holder = holder[part]
    if value is ...:
        del holder[last]
    else:
        holder[last] = value
    return changed


CROSSED = [[[[0, 0], [1, 1], [0, 1], [1, 0]]]]


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        ("rota_plan", 2, r"rota_plan: version 2 is not known; this Rota reads version 1"),
        ("rota_plan", ..., r'there is no "rota_plan"'),
        ("rota_plan", True, r"version True is not known"),
        ("seed", 1.5, r"^seed: 1\.5 is not allowed; a whole number is needed"),
        ("lower_bound_robots", -1, r"^lower_bound_robots: -1 is not allowed; it must be at least 0"),
        ("robots", {}, r"^robots: .*list"),
        ("mission_sha256", "abc", r"^mission_sha256: abc\.\.\. is not that of the mission"),
        ("mission.zones", ..., r"^mission\.zones: is missing"),
        ("mission.perod_s", 4, r"^mission\.perod_s: unknown key; did you mean 'period_s'\?"),
        ("mission.period_s", "40", r'^mission\.period_s: "40" is not allowed; a number is needed; remove the quotes'),
        ("mission.period_s", 0, r"^mission\.period_s: 0 is not allowed; it must be greater than 0"),
        ("mission.period_s", float("inf"), r"^mission\.period_s: .*finite"),
        ("mission.period_s", True, r"^mission\.period_s: .*number"),
        ("mission.period_s", 10**400, r"^mission\.period_s: 10+ \.\.\. is not allowed; a finite number is needed"),
        ("mission.area", [], r"^mission\.area: \[\] is not allowed; it must not be empty"),
        ("mission.area", CROSSED, r"^mission\.area: an invalid shape"),
        ("mission.area.0.0", [[0, 0], [1, 1]], r"^mission\.area\[0\]\[0\]: .*at least 3"),
        ("mission.area.0.0.2", [1], r"^mission\.area\[0\]\[0\]\[2\]: \[1\] is too short; 2 numbers are needed"),
        ("mission.obstacles.1.shape", CROSSED, r"^mission\.obstacles\[1\]\.shape: an invalid shape"),
        (
            "mission.obstacles.0.blocks",
            "light",
            r'^mission\.obstacles\[0\]\.blocks: "light" is not allowed; both, motion or sight is',
        ),
        (
            "mission.obstacles.2.asks",
            "something",
            r'^mission\.obstacles\[2\]\.asks: "something" is not allowed; all or nothing is',
        ),
        ("mission.zones.1.shape", [[[[500, 500], [501, 500], [501, 501]]]], r"zone tank: .*outside the area"),
        ("mission.zones.1.name", "gate", r"^mission: zones: 'gate' .*unique"),
        ("mission.origin.lat", 91, r"^mission\.origin\.lat: 91 is not allowed; it must be at most 90"),
        ("mission.fleet.robots", 3, r"^mission\.fleet\.robots: 3 is not allowed; fewest or a list is needed"),
        (
            "mission.fleet.robots.0.speed_m_s",
            -1,
            r"^mission\.fleet\.robots\[0\]\.speed_m_s: -1 is not allowed; it must be greater than 0",
        ),
        ("mission.fleet.robots.0.name", "b", r"^mission\.fleet: .*'b'.*unique"),
        (
            "mission.fleet.sensor.shape",
            "cube",
            r'^mission\.fleet\.sensor\.shape: "cube" is not allowed; disc or square is needed',
        ),
        ("mission.fleet.sensor.side_m", ..., r"^mission\.fleet\.sensor\.side_m: is missing; a square sensor"),
        ("mission.planner", "swerm", r"^mission\.planner: .* patrol, swarm or bounce is needed"),
        ("mission.patrol.effort", "low", r'^mission\.patrol\.effort: "low" is not allowed; quick, normal or high'),
        ("robots.0.name", "nobody", r"^robots: robot 'nobody' is not in the fleet"),
        ("robots.1.name", "Zoë", r"^robots: robot Zoë has more than one trajectory"),
        ("robots.0.times_s", [0, 1, 0.5, 5], r"^robots\[0\]: .*times_s\[2\] = 0\.5 does not come after 1\.0"),
        ("robots.0.times_s", [0, 1], r"^robots\[0\]\.positions_m: 4 entries; 2 are needed"),
        ("robots.0.positions_m.1", [1, 2, 3], r"^robots\[0\]\.positions_m: \[x, y\] and \[x, y, z\] mixed"),
        ("robots.1.positions_m.0", [4, 4, 0], r"^robots: robot b: positions_m\[0\] has 3 numbers; 2 are needed"),
        (
            "robots.0.positions_m.2",
            [1e9, 0],
            r"^robots\[0\]\.positions_m\[2\]\[0\]: 1000000000 is not allowed; it must be at most 100000000",
        ),
        ("robots.0.positions_m.2", [0, 2e6], r"^robots: robot Zoë: positions_m\[2\] = .*at most 1e\+06 m away"),
        ("robots.0.times_s.3", 1e308, r"^robots\[0\]\.times_s\[3\]: 1e\+308 is not allowed; it must be at most 1e\+10"),
        ("robots.0.times_s", [0, 0.1, 0.1 + 1e-8, 0.1 + 1e-7], r"^robots\[0\]: .*loops take 1e-06 s or more"),
        (
            "mission.area.0.0.2",
            [1e40, 90],
            r"^mission\.area\[0\]\[0\]\[2\]\[0\]: 1e\+40 is not allowed; it must be at most 100000000",
        ),
        (
            "mission.fleet.sensor.side_m",
            1e155,
            r"^mission\.fleet\.sensor\.side_m: 1e\+155 is not allowed; it must be at most 100000000",
        ),
        ("mission.zones.0.name", "\ud800", r"^mission\.zones\[0\]: zone\.name: .*lone surrogates"),
        ("robots.0.positions_m.3", [9, 9], r"^robots\[0\]: .*the loop does not close"),
        ("robots.0.headings_rad", [0.0], r"^robots\[0\]\.headings_rad: 1 entries; 4 are needed"),
        ("robots.0.loop_start_s", 0.2, r"^robots\[0\]: .*loop_start_s = 0\.2 is none of the times"),
    ],
)
def test_a_bad_field_is_named(place: str, value: Any, message: str) -> None:
    with pytest.raises(PlanError, match=message):
        plan_from_json(set_at(plan_to_json(harbour()), place, value))


def test_a_mission_that_was_changed_after_planning_is_refused() -> None:
    document = plan_to_json(harbour())
    changed = set_at(document, "mission.period_s", 1e6)
    with pytest.raises(PlanError, match=r"^mission_sha256: .* was changed after the plan was made"):
        plan_from_json(changed)
    assert plan_from_json(set_at(changed, "mission_sha256", ...)).mission.period_s == 1e6  # as a file may come without
    # other programs order keys otherwise and write whole numbers without a point
    rewritten = json.dumps(document, sort_keys=True, indent=1).replace(".0,", ",")
    assert plan_from_text(rewritten, "f") == harbour()


def test_all_faults_are_told_at_once_with_the_file(tmp_path: Path) -> None:
    document = set_at(set_at(plan_to_json(harbour()), "seed", "x"), "mission.period_s", -3)
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(document))
    with pytest.raises(PlanError) as caught:
        read_plan(path)
    lines = str(caught.value).splitlines()
    assert len(lines) == 2
    assert lines[0].startswith(f"{path}: seed: ")
    assert lines[1].startswith(f"{path}: mission.period_s: ")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"", r"^f:1:1: not JSON: Expecting value"),
        (plan_text(harbour()).encode()[:160], r"^f:4:24: not JSON"),
        (b'{"rota_plan": 1, "seed": NaN}', r"^f: NaN is no number"),
        (b'{"rota_plan": 1, "seed": -Infinity}', r"^f: -Infinity is no number"),
        (b'{"rota_plan": "\xff"}', r"^f: byte 15 is not UTF-8"),
        (b"[" * 100_000, r"^f: brackets nested too deeply"),
        (b'{"seed": ' + b"1" * 9000 + b"}", r"^f: .*digits"),
        (b"[]", r'^f: not a plan file: there is no "rota_plan"'),
        (b"null", r"^f: not a plan file"),
    ],
)
def test_broken_text_is_refused_with_its_position(text: bytes, message: str) -> None:
    with pytest.raises(PlanError, match=message):
        plan_from_text(text, "f")


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match=r"none\.json: no such file; a plan file \('rota plan' writes one\) is needed"):
        read_plan(tmp_path / "none.json")
    with pytest.raises(PlanError, match=r"is a folder; a plan file .* is needed"):
        read_plan(tmp_path)


def test_what_cannot_be_written_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    path.write_text("old")
    with pytest.raises(RotaError, match="there is no folder"):
        write_plan(harbour(), tmp_path / "missing" / "plan.json")
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["plan.json"]


def test_entrances_and_rally_points_travel_with_the_plan_and_plans_without_say_nothing_of_them() -> None:
    plan, places = harbour(), ((1.5, 0.1 + 0.2), (80.0, 1.0))
    assert not {"entrances", "rally_points"} & plan_to_json(plan)["mission"]["fleet"].keys()
    fleet = dataclasses.replace(plan.mission.fleet, entrances=places, rally_points=places[:1])
    entered = dataclasses.replace(plan, mission=dataclasses.replace(plan.mission, fleet=fleet))
    assert plan_from_text(plan_text(entered), "plan.json") == entered
