"""Whole verdicts: met, violated, not proven; zones, what nobody can see, spoiled plans, the report's forms."""

from __future__ import annotations

import dataclasses
import json
import math

import jsonschema
import numpy as np
import pytest
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon, box

from rota.check import (
    Report,
    check_plan,
    met_text,
    refine,
    report_schema,
    report_table,
    report_to_json,
    tiled_ground,
)
from rota.check.revisits import worst_gaps_s
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, SquareSensor, Zone
from rota.model.plan import Plan, Trajectory


def strip_tour(width: float, height: float, gap: float, margin: float) -> NDArray[np.float64]:
    """Up and down lanes ``gap`` apart at most, back along the lower border."""
    xs = np.linspace(margin, width - margin, 2 * math.ceil((width - 2 * margin) / gap / 2 + 0.5))
    xy = []
    for k, x in enumerate(xs):
        ends = [(x, margin), (x, height - margin)]
        xy += ends if k % 2 == 0 else ends[::-1]
    return np.array([*xy, xy[0]])


def route(xy: object, speed: float, robot: str = "robot-1", start: float = 0.0) -> Trajectory:
    points = np.array(xy, dtype=float)
    times = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T)) / speed])
    first = round(start * (len(points) - 1))
    points = np.vstack([points[first:-1], points[: first + 1]])
    steps = np.diff(times)
    times = np.concatenate([[0], np.cumsum(np.concatenate([steps[first:], steps[:first]]))])
    return Trajectory(robot=robot, times_s=times, positions_m=points)


def field(**changes: object) -> Mission:
    base = Mission(
        name="field",
        area=MultiPolygon([box(0, 0, 60, 60)]),
        fleet=Fleet(speed_m_s=10.0, sensor=DiscSensor(radius_m=5.0)),
        period_s=45.0,
    )
    return dataclasses.replace(base, **changes)


TOUR = strip_tour(60, 60, 8.0, 3.0)


def test_tour_that_sees_all_is_met_with_a_tight_bracket() -> None:
    trajectory = route(TOUR, 10.0)
    period = trajectory.loop_duration_s
    report = check_plan(Plan(mission=field(period_s=period), trajectories=(trajectory,), lower_bound_robots=1))
    assert report.verdict == "met"
    assert report.violations == ()
    (d,) = report.demands
    assert (d.name, d.outcome, d.undecided_cells) == ("area", "met", 0)
    assert d.area_m2 == pytest.approx(3600)
    sampled = worst_gaps_s(
        Plan(mission=field(), trajectories=(trajectory,)), np.random.default_rng(0).uniform(0, 60, (20000, 2))
    )
    assert d.worst_gap_at_least_s <= d.worst_gap_s <= period
    assert sampled.max() <= d.worst_gap_s
    assert d.worst_gap_at_least_s > 0.97 * d.worst_gap_s
    assert report.first_coverage_s is not None
    assert 0.8 * period < report.first_coverage_s <= period
    assert len(report.unmet_points_m) == 0


@pytest.mark.parametrize(("factor", "verdict"), [(1.004, "met"), (0.999, "violated"), (0.5, "violated")])
def test_period_just_under_and_just_over_the_worst_gap(factor: float, verdict: str) -> None:
    trajectory = route(TOUR, 10.0)
    plan = Plan(mission=field(), trajectories=(trajectory,))
    points = np.random.default_rng(1).uniform(0, 60, (100_000, 2))
    worst = worst_gaps_s(plan, points).max()
    report = check_plan(dataclasses.replace(plan, mission=field(period_s=worst * factor)))
    assert report.verdict == verdict
    if verdict == "violated":
        (v,) = report.violations
        assert v.kind == "gap"
        assert v.place_m is not None
        assert v.value == pytest.approx(worst_gaps_s(plan, np.array([v.place_m]))[0])
        assert v.value > worst * factor
        assert v.time_s is not None
        # nobody sees the place from then on for that long
        inside = v.time_s + np.linspace(1e-6, v.value - 1e-6, 500)
        at = [
            np.interp(inside % trajectory.times_s[-1], trajectory.times_s, trajectory.positions_m[:, k]) for k in (0, 1)
        ]
        assert (np.hypot(at[0] - v.place_m[0], at[1] - v.place_m[1]) > 5.0 - 1e-6).all()


def test_hole_between_two_lanes_is_found_with_its_area() -> None:
    # lanes 12 m apart leave 2 m unseen between their swaths, over 40 m and the bulges at the ends
    ring = [(10, 10), (10, 50), (22, 50), (22, 10), (10, 10)]
    m = field(area=MultiPolygon([box(10, 20, 22, 40)]), period_s=20.0)
    report = check_plan(Plan(mission=m, trajectories=(route(ring, 10.0),)))
    (d,) = report.demands
    assert report.verdict == "violated"
    assert d.worst_gap_s == d.worst_gap_at_least_s == math.inf
    assert d.unseen_area_m2 == pytest.approx(2 * 20, rel=0.05)
    gap = next(v for v in report.violations if v.kind == "gap")
    assert gap.place_m is not None
    assert 15 <= gap.place_m[0] <= 17
    assert gap.value == math.inf
    assert gap.time_s is None
    assert ((report.unmet_points_m[:, 0] >= 14.3) & (report.unmet_points_m[:, 0] <= 17.7)).all()
    lattice = np.stack(np.meshgrid(np.arange(15.1, 17, 0.2), np.arange(20.5, 40, 0.5)), axis=-1).reshape(-1, 2)
    away = np.hypot(*(lattice[:, None] - report.unmet_points_m[None]).transpose(2, 0, 1)).min(axis=1)
    assert away.max() < 0.65  # the unmet points lie all over it
    assert report.first_coverage_s is None


def test_each_point_is_seen_twice_but_never_a_piece_across_two_swaths() -> None:
    # square swaths that just meet: no piece across the seam is ever seen whole, yet each of its points is
    m = field(area=MultiPolygon([box(0, 0, 8, 7.3)]), fleet=Fleet(speed_m_s=1.0, sensor=SquareSensor(side_m=4.0)))
    ring = [(2, 2), (6, 2), (6, 5.3), (2, 5.3), (2, 2)]
    period = 14.6
    report = check_plan(Plan(mission=dataclasses.replace(m, period_s=period), trajectories=(route(ring, 1.0),)))
    assert report.verdict == "met"
    held = [
        Trajectory(robot=n, times_s=[0.0], positions_m=[p])
        for n, p in [("a", (math.pi / 2, 2)), ("b", (math.pi / 2 + 4, 2))]
    ]
    seam = field(
        area=MultiPolygon([box(0, 0, 7.5, 4)]),
        fleet=Fleet(speed_m_s=1.0, sensor=SquareSensor(side_m=4.0)),
        period_s=1.0,
    )
    report = check_plan(Plan(mission=seam, trajectories=tuple(held)))
    assert report.verdict in ("met", "not proven")
    assert all(v.kind != "gap" for v in report.violations)


def test_no_trajectories_see_nothing() -> None:
    report = check_plan(Plan(mission=field(), trajectories=()))
    (d,) = report.demands
    assert (report.verdict, report.robots, report.first_coverage_s) == ("violated", 0, None)
    assert d.unseen_area_m2 == pytest.approx(3600)
    assert d.worst_gap_at_least_s == math.inf
    assert len(report.unmet_points_m) > 1000


def test_smallest_period_rules_where_zones_overlap() -> None:
    zones = (
        Zone(name="slow", shape=MultiPolygon([box(0, 0, 30, 30)]), period_s=100.0),
        Zone(name="fast", shape=MultiPolygon([box(20, 20, 40, 40)]), period_s=20.0),
        Zone(name="none", shape=MultiPolygon([box(25, 0, 70, 25)]), period_s=None),
        Zone(name="goal", shape=MultiPolygon([box(50, 50, 70, 70)]), period_s=70.0, demand="visit"),
    )
    trajectory = route(TOUR, 10.0)
    report = check_plan(Plan(mission=field(zones=zones, period_s=80.0), trajectories=(trajectory,)))
    by_name = {d.name: d for d in report.demands}
    assert list(by_name) == ["slow", "fast", "goal", "area"]
    assert by_name["slow"].area_m2 == pytest.approx(900 - 100)
    assert by_name["fast"].area_m2 == pytest.approx(400)
    # none takes 35 x 25 from the area's period, less what slow and fast take of it; goal takes 100
    union = box(0, 0, 30, 30).union(box(20, 20, 40, 40)).union(box(25, 0, 60, 25)).union(box(50, 50, 60, 60))
    assert by_name["area"].area_m2 == pytest.approx(3600 - union.area)
    assert {name: d.outcome for name, d in by_name.items()} == {
        "slow": "met", "fast": "violated",
        "goal": "met", "area": "met",
    }  # fmt: skip
    assert set(report.unmet_demand.tolist()) == {1}


def test_visit_wants_a_robot_inside() -> None:
    ring = [(5, 5), (55, 5), (55, 55), (5, 55), (5, 5)]
    near = Zone(name="tank", shape=MultiPolygon([box(20, 6, 30, 12)]), period_s=20.0, demand="visit")
    touched = dataclasses.replace(near, shape=MultiPolygon([box(20, 5, 30, 12)]))
    m = field(period_s=None, zones=(near,))
    report = check_plan(Plan(mission=m, trajectories=(route(ring, 10.0),)))
    (d,) = report.demands
    assert (d.outcome, d.worst_gap_s, report.first_coverage_s) == ("violated", math.inf, None)
    assert report.unmet_points_m.shape == (1, 2)
    assert box(20, 6, 30, 12).contains(
        MultiPolygon([box(*report.unmet_points_m[0] - 1e-9, *report.unmet_points_m[0] + 1e-9)])
    )
    report = check_plan(Plan(mission=field(period_s=None, zones=(touched,)), trajectories=(route(ring, 10.0),)))
    (d,) = report.demands
    assert (d.outcome, d.worst_gap_s) == ("met", pytest.approx(19.0))
    assert report.first_coverage_s == pytest.approx(1.5)


def corner_room(body: float, unseeable: str = "exclude", side: float = 20.0) -> Mission:
    """A room of 20 m with a slot 0.4 m wide, too narrow for a body of 0.5 m and bent so that its end is hidden."""
    slot = box(side, 5, side + 2, 5.4).union(box(side + 1.6, 5.4, side + 2, 7))
    outside = box(-5, -5, side + 5, side + 5).difference(box(0, 0, side, side).union(slot))
    return Mission(
        name="room",
        area=MultiPolygon([box(0, 0, side, side).union(slot)]),
        obstacles=(Obstacle(shape=outside),),
        fleet=Fleet(speed_m_s=10.0, sensor=DiscSensor(radius_m=9.0), body_radius_m=body),
        period_s=30.0,
        unseeable=unseeable,
    )


ROOM_TOUR = [(6, 6), (14, 6), (17, 4.875), (19.5, 4.875), (19.5, 5.2), (14, 14), (6, 14), (6, 6)]


def test_end_of_a_bent_slot_is_excluded_with_place_and_area() -> None:
    report = check_plan(Plan(mission=corner_room(0.5), trajectories=(route(ROOM_TOUR, 10.0),)))
    (d,) = report.demands
    assert report.verdict == "met"
    # the bend is seen up to the line from the slot's lower mouth corner over its inner corner (21.6, 5.4)
    rise = 0.4 / 1.6 * 0.4
    unseen = 0.4 * 1.6 - 0.4 * rise / 2
    assert d.excluded_area_m2 == pytest.approx(unseen, abs=0.03)
    assert d.excluded_area_m2 >= unseen - 1e-3
    ((x, y, area),) = d.excluded_places
    assert 21.6 <= x <= 22
    assert 5.4 <= y <= 7
    assert area == pytest.approx(d.excluded_area_m2)
    assert "nobody can see" in report_table(report)


def test_what_nobody_can_see_is_refused_when_asked_or_when_it_is_much() -> None:
    report = check_plan(Plan(mission=corner_room(0.5, "refuse"), trajectories=(route(ROOM_TOUR, 10.0),)))
    assert report.verdict == "violated"
    (v,) = report.violations
    assert (v.kind, v.limit, v.unit) == ("unseeable", 0.0, "m2")
    tower = field(
        obstacles=(Obstacle(shape=MultiPolygon([box(10, 10, 40, 40)]), blocks="motion"),),
        fleet=Fleet(speed_m_s=10.0, sensor=DiscSensor(radius_m=4.0)),
    )
    report = check_plan(Plan(mission=tower, trajectories=()))
    (v,) = [v for v in report.violations if v.kind == "unseeable"]
    assert v.value == pytest.approx(22 * 22, rel=0.02)
    assert v.limit == pytest.approx(0.05 * 3600)


def test_body_that_fits_must_see_the_slot() -> None:
    report = check_plan(Plan(mission=corner_room(0.1), trajectories=(route(ROOM_TOUR, 10.0),)))
    assert report.verdict == "violated"
    assert report.demands[0].excluded_area_m2 == 0
    assert report.demands[0].unseen_area_m2 > 0.4
    assert (report.unmet_points_m[:, 0] > 20).all()


def test_hedge_in_the_way_is_not_demanded_but_hides() -> None:
    hedge = Obstacle(shape=MultiPolygon([box(28, 10, 30, 50)]), blocks="sight")
    m = field(obstacles=(hedge,), fleet=Fleet(speed_m_s=10.0, sensor=DiscSensor(radius_m=80.0)))
    left = Trajectory(robot="robot-1", times_s=[0.0], positions_m=[(10.0, 30.0)])
    report = check_plan(Plan(mission=m, trajectories=(left,)))
    (d,) = report.demands
    assert d.area_m2 == pytest.approx(3600 - 80)
    # shadow: from (10, 30) over (28, 10) and (28, 50): wider than the field at its right border
    slope = 20 / 18
    reach = 30 / slope + 10  # where the sight line leaves the field
    shadow = Polygon([(30, 10), (28, 10), (reach, 0), (60, 0), (60, 60), (reach, 60), (28, 50), (30, 50)])
    assert d.unseen_area_m2 == pytest.approx(shadow.area, rel=0.02)
    others = [(50.0, 30.0), (29.0, 2.0), (29.0, 58.0)]
    more = tuple(Trajectory(robot=f"r{k}", times_s=[0.0], positions_m=[p]) for k, p in enumerate(others))
    assert check_plan(Plan(mission=m, trajectories=(left, *more))).verdict == "met"


def test_spoiled_plans_are_all_found_at_once() -> None:
    robots = tuple(
        Robot(name=n, speed_m_s=10.0, sensor=DiscSensor(radius_m=80.0), body_radius_m=0.5, start=s)
        for n, s in [("a", (5.0, 5.0)), ("b", None), ("c", None)]
    )
    m = field(
        fleet=Fleet(speed_m_s=10.0, sensor=DiscSensor(radius_m=80.0), robots=robots),
        obstacles=(Obstacle(shape=MultiPolygon([box(30, 30, 32, 32)]), blocks="motion"),),
    )
    one = route([(5.5, 5), (55, 5), (5.5, 5)], 10.0, "a")
    two = route([(20, 5.4), (31, 35), (31, 25), (20, 5.4)], 30.0, "b")
    report = check_plan(Plan(mission=m, trajectories=(one, two)))
    assert [d.outcome for d in report.demands] == ["met"]
    assert report.verdict == "violated"
    found = {v.kind: v for v in report.violations}
    assert set(found) == {"start", "no trajectory", "obstacle", "speed", "bodies touch"}
    assert found["no trajectory"].who == "c"
    assert found["start"].value == pytest.approx(0.5)
    assert found["obstacle"].value == pytest.approx(1.5, abs=1e-3)
    assert found["speed"].value == pytest.approx(30)
    assert found["bodies touch"].limit == 1.0


def example_reports() -> list[Report]:
    good = check_plan(Plan(mission=field(period_s=1e3), trajectories=(route(TOUR, 10.0),), lower_bound_robots=1))
    bad = check_plan(Plan(mission=field(), trajectories=()))
    room = check_plan(Plan(mission=corner_room(0.5), trajectories=(route(ROOM_TOUR, 10.0),)))
    return [good, bad, room]


def test_json_fits_the_published_schema_and_table_names_every_demand() -> None:
    schema = report_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    for report in example_reports():
        values = json.loads(json.dumps(report_to_json(report), allow_nan=False))
        jsonschema.validate(values, schema)
        assert values["rota_report"] == 1
        assert values["verdict"] == report.verdict
        assert len(values["unmet_points_m"]) <= 100
        assert values["unmet_points"] == len(report.unmet_points_m)
        (demand,) = report.demands
        ratios = [values["worst_ratio_at_least"], values["worst_ratio"]]
        gaps_s = [demand.worst_gap_at_least_s, demand.worst_gap_s]
        assert ratios == [gap_s / demand.period_s if math.isfinite(gap_s) else None for gap_s in gaps_s]
        table = report_table(report)
        assert f"verdict: {report.verdict}" in table
        assert all(d.name in table for d in report.demands)
        assert all(v.text() in table for v in report.violations)


def test_same_plan_same_report() -> None:
    one, two = (check_plan(Plan(mission=corner_room(0.1), trajectories=(route(ROOM_TOUR, 10.0),))) for _ in range(2))
    assert report_to_json(one) == report_to_json(two)
    np.testing.assert_array_equal(one.unmet_points_m, two.unmet_points_m)


@pytest.mark.parametrize(("off_m", "met"), [(0.0, True), (0.0005, True), (0.03, False)])
def test_a_no_fly_zone_is_seen_into_from_its_border(off_m: float, met: bool) -> None:
    # 9 m wide, 4 m reach: 1 m x 1 m in the middle nobody sees, and all but a hair of the rest needs the very border
    closed = box(4, 4, 13, 13)
    fleet = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=4.0))
    ground = Mission(
        name="closed",
        area=MultiPolygon([box(0.5, 0.5, 16.5, 16.5)]),
        obstacles=(Obstacle(shape=MultiPolygon([closed]), blocks="motion"),),
        period_s=100.0,
        fleet=fleet,
    )
    low, high = 4 - off_m, 13 + off_m
    # out to the corners of the area in between
    ring = [(low, low), (1, 1), (low, low), (high, low), (16, 1), (high, low), (high, high), (16, 16), (high, high)]
    ring += [(low, high), (1, 16), (low, high), (low, low)]
    report = check_plan(Plan(mission=ground, trajectories=(route(ring, 1.0),)))
    assert (report.verdict == "met") == met
    if met:
        # rounded outwards by about a centimetre, never inwards
        assert 1.0 <= report.demands[0].excluded_area_m2 <= 1.0 + 4 * 0.015 + 1e-3
    else:
        assert len(report.unmet_points_m)
        assert np.abs(report.unmet_points_m - 8.5).max() == pytest.approx(0.53, abs=0.25)  # coarse pieces


def test_a_place_said_to_be_violated_is_among_the_unmet() -> None:
    report = check_plan(Plan(mission=field(), trajectories=(route([(5, 5), (50, 5), (5, 5)], 10.0),)))
    (gap,) = [violation for violation in report.violations if violation.kind == "gap"]
    assert gap.place_m is not None
    assert np.hypot(*(report.unmet_points_m - gap.place_m).T).min() == 0


@pytest.mark.parametrize("period", [0.999, 1.001])
def test_pieces_judged_in_parts_come_to_the_same_verdict(period: float, monkeypatch: pytest.MonkeyPatch) -> None:
    trajectory = route(TOUR, 10.0)
    pillar = Obstacle(shape=MultiPolygon([box(29, 29, 31, 30)]))
    zone = Zone(name="gate", shape=MultiPolygon([box(10, 10, 50, 20)]), period_s=trajectory.loop_duration_s)
    mission = field(period_s=period * trajectory.loop_duration_s, obstacles=(pillar,), zones=(zone,))
    plan = Plan(mission=mission, trajectories=(trajectory,), lower_bound_robots=1)
    whole = check_plan(plan)
    monkeypatch.setattr(refine, "MOST_TOGETHER", 700)  # of 2,400 and more
    parts = check_plan(plan)
    assert parts.verdict == whole.verdict
    assert [(v.kind, v.who, v.value) for v in parts.violations] == [(v.kind, v.who, v.value) for v in whole.violations]
    for one, other in zip(parts.demands, whole.demands, strict=True):
        assert one.outcome == other.outcome
        assert one.worst_gap_at_least_s == other.worst_gap_at_least_s
        assert one.unseen_area_m2 == pytest.approx(other.unseen_area_m2)
        if one.outcome == "met":
            assert (one.worst_gap_s, one.undecided_cells) == (other.worst_gap_s, other.undecided_cells)


def test_of_many_pieces_finer_ones_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = Plan(mission=field(), trajectories=(route([(3, 30), (57, 30), (3, 30)], 10.0),))

    def widest_doubt_m() -> float:
        """By how much the unmet piece nearest to the robot's lane lies within what is seen from there."""
        unmet_m = check_plan(plan).unmet_points_m
        along = unmet_m[(unmet_m[:, 0] > 10) & (unmet_m[:, 0] < 50)]
        return float(5 - np.abs(along[:, 1] - 30).min())

    coarse_m = widest_doubt_m()
    monkeypatch.setattr(tiled_ground, "MANY_PIECES", 0)
    assert widest_doubt_m() < coarse_m / 2


def test_ground_that_is_all_sliver_was_not_looked_at() -> None:
    # a robot on it sees all of it, but nothing of it is wider than the check's tolerance
    sliver = field(area=MultiPolygon([box(0, 0, 3e-9, 1e-9)]))
    stands = Trajectory(robot="a", times_s=[0.0], positions_m=[(1e-9, 0)])
    report = check_plan(Plan(mission=sliver, trajectories=(stands,)))
    assert report.verdict == "not proven"
    assert report.demands[0].undecided_cells == 1


def test_ground_that_nobody_can_see_is_not_held_against_a_zone_beside_it() -> None:
    # the bodies see down to y = 0.2: the zone b of 3 mm begins there, all of it can be seen, and nobody goes there
    robot = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=0.3), body_radius_m=0.5)
    zones = (
        Zone(name="a", shape=box(1, 0.8, 1.4, 1.2), period_s=20),
        Zone(name="b", shape=box(55, 0.2, 56, 0.203), period_s=1),
    )
    asked = field(area=MultiPolygon([box(0, 0, 60, 2)]), zones=zones, period_s=None, fleet=robot)
    stands = Trajectory(robot="a", times_s=[0.0], positions_m=[(1.2, 1.0)])
    for mission in (asked, dataclasses.replace(asked, period_s=1000.0)):
        report = check_plan(Plan(mission=mission, trajectories=(stands,)))
        outcomes = {d.name: (d.outcome, d.excluded_area_m2) for d in report.demands}
        assert outcomes["a"] == ("met", 0)
        assert outcomes["b"] == ("violated", 0)
    # what lies lower is seen by nobody, and left out
    low = dataclasses.replace(asked, zones=(zones[0], Zone(name="c", shape=box(55, 0.1, 56, 0.19), period_s=1)))
    report = check_plan(Plan(mission=low, trajectories=(stands,)))
    assert report.demands[1].excluded_area_m2 == pytest.approx(0.09)


@pytest.mark.parametrize(("wide_m", "verdict"), [(2e-5, "met"), (0.5, "not proven")])
def test_a_spot_on_the_edge_of_two_views_is_met_where_its_middles_are(wide_m: float, verdict: str) -> None:
    # one robot sees all to the right of x = 5, the other all to the left: no piece across that line is seen by one
    walls = (box(4, 2, 5, 2.2), box(5, 7.8, 6, 8))
    zone = Zone(name="spot", shape=MultiPolygon([box(5 - wide_m / 3, 5, 5 + wide_m / 2, 5 + wide_m)]), period_s=1.0)
    mission = field(
        area=MultiPolygon([box(0, 0, 10, 10)]),
        obstacles=tuple(Obstacle(shape=MultiPolygon([wall]), blocks="sight") for wall in walls),
        fleet=Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=9.0)),
        zones=(zone,),
        period_s=None,
    )
    stay = [Trajectory(robot=n, times_s=[0.0], positions_m=[p]) for n, p in [("a", (5.0, 0.5)), ("b", (5.0, 9.5))]]
    assert check_plan(Plan(mission=mission, trajectories=tuple(stay))).verdict == verdict


def late(wait_s: float) -> Trajectory:
    """The tour, begun after a wait."""
    tour = route(TOUR, 10.0)
    times_s = np.concatenate([[0], wait_s + tour.times_s])
    return Trajectory(
        robot="robot-1", times_s=times_s, positions_m=np.vstack([tour.positions_m[:1], tour.positions_m]),
        loop_start_s=wait_s,
    )  # fmt: skip


def test_met_says_from_when_on() -> None:
    at_once = check_plan(Plan(mission=field(period_s=60.0), trajectories=(route(TOUR, 10.0),)))
    assert (at_once.verdict, at_once.holds_from_s) == ("met", 0.0)
    assert met_text(at_once) == "met, every demand, for ever."
    assert report_table(at_once).startswith("verdict: met\n")
    report = check_plan(Plan(mission=field(period_s=60.0), trajectories=(late(1e9),)))
    assert (report.verdict, report.holds_from_s) == ("met", 1e9)
    assert met_text(report) == "met, every demand, for ever from t = 1000000000 s on."
    assert report_table(report).startswith("verdict: met from t = 1000000000 s on\n")
    assert report_to_json(report)["holds_from_s"] == 1e9
    violated = check_plan(Plan(mission=field(period_s=5.0), trajectories=(late(1e9),)))
    assert report_table(violated).startswith("verdict: violated\n")


@pytest.mark.parametrize(("within_s", "late_by_s"), [(99.0, 1.0), (100.0, 0.0), (None, 0.0)])
def test_a_mission_may_bound_when_demands_hold(within_s: float | None, late_by_s: float) -> None:
    mission = field(period_s=60.0, holds_within_s=within_s)
    report = check_plan(Plan(mission=mission, trajectories=(late(100.0),)))
    told = [(v.kind, v.who, v.value - v.limit) for v in report.violations]
    assert told == ([("holds too late", "robot-1", late_by_s)] if late_by_s else [])
    assert report.verdict == ("violated" if late_by_s else "met")


def test_headings_that_nobody_judges_are_named() -> None:
    tour = route(TOUR, 10.0)
    faced = dataclasses.replace(tour, headings_rad=np.zeros(len(tour.times_s)))
    assert check_plan(Plan(mission=field(), trajectories=(tour,))).not_judged == ()
    report = check_plan(Plan(mission=field(), trajectories=(faced,)))
    assert report.not_judged == ("headings: they are judged of robots that bounce",)


def test_a_corner_that_is_never_seen_is_no_area_of_zero() -> None:
    reach = math.hypot(30, 30) * (1 - 1e-7)  # all of the square but its corners
    mission = field(fleet=Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=reach)))
    stays = Trajectory(robot="robot-1", times_s=[0.0], positions_m=[[30.0, 30.0]])
    report = check_plan(Plan(mission=mission, trajectories=(stays,)))
    assert report.verdict == "violated"
    assert "> 0" in report_table(report).splitlines()[4]


def test_what_is_raised_on_the_way_ends_the_check_without_a_verdict() -> None:
    def stopped() -> None:
        raise TimeoutError

    plan = Plan(mission=field(), trajectories=(route(TOUR, 10.0),))
    with pytest.raises(TimeoutError):
        check_plan(plan, on_the_way=stopped)
