"""Plans without a grid: closed ways by hand, ways followed by another simulation, and the check's verdict."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from shapely import MultiPolygon, Polygon, box

from rota.check import check_plan
from rota.check.clocks import clock_margin_s
from rota.draw import draw_cells
from rota.errors import MissionError, NoPlanFound, PlanError
from rota.files.create2_legs import drives_of
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.model.plan import Plan
from rota.planners.bounce.physics_sentences import errors_sentence
from rota.planners.bounce.plane_tracks import tracks_of
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.bounce.polygon import BounceRule, bounce_path, make_rim
from rota.planning.make_plan import search_plan
from rota.planning.planner import Answer, planner_of

SPEED_M_S, BODY_M = 0.4, 0.17
SLANTED = Polygon([(0, 0), (10, 0), (10, 6), (6, 10), (0, 10)])


def hall(robots: int | None, period_s: float = 120.0, angle_deg: float = 140.0, **settings: object) -> Mission:
    one = Fleet(
        speed_m_s=SPEED_M_S, sensor=DiscSensor(radius_m=1), body_radius_m=BODY_M, turn_rate_rad_s=1.5
    )  # fmt: skip
    listed = None if robots is None else tuple(one.equal_robot(f"robot-{k + 1}") for k in range(robots))
    zones = tuple(
        Zone(name=name, shape=MultiPolygon([box(*at)]), period_s=period_s, demand="visit")
        for name, at in {"west": (0, 2, 2, 4), "south": (5, 0, 8, 1.5)}.items()
    )
    options = {"cells": "none", "bouncing_angles_deg": (angle_deg,), **settings}
    return Mission(
        name="hall", area=MultiPolygon([SLANTED]), obstacles=(Obstacle(shape=box(2, 5, 4, 6)),), zones=zones,
        fleet=replace(one, robots=listed), planning=BounceSettings(**options),  # type: ignore[arg-type]
    )  # fmt: skip


@pytest.fixture(scope="module")
def answer() -> Answer:
    return search_plan(hall(2)).answer


@pytest.fixture(scope="module")
def pair(answer: Answer) -> Plan:
    return answer.plan


def test_two_robots_go_round_evenly_spaced(pair: Plan) -> None:
    report = check_plan(pair)
    assert report.verdict == "met"
    one, other = pair.trajectories
    assert one.loop_duration_s == pytest.approx(other.loop_duration_s, rel=1e-12)
    assert report.clock_margin_s is not None
    assert report.clock_margin_s > 1


def test_ways_are_those_of_exact_bounces(pair: Plan) -> None:
    """From the first place and heading on, contact by contact, by the map of polygons."""
    mission, one = pair.mission, pair.trajectories[0]
    ground = MultiPolygon([SLANTED.difference(box(2, 5, 4, 6))])
    assert one.headings_rad is not None
    heading = float(one.headings_rad[0]) % math.tau
    start = (float(one.positions_m[0, 0]), float(one.positions_m[0, 1]))
    contacts = one.positions_m[np.flatnonzero(np.diff(one.positions_m, axis=0).any(axis=1)) + 1]
    path = bounce_path(make_rim(ground, BODY_M), BounceRule(angle_rad=math.radians(140)), start, heading, len(contacts))
    np.testing.assert_allclose(path.positions_m[1:], contacts, atol=1e-6)
    drives = np.linalg.norm(np.diff(one.positions_m, axis=0), axis=1)
    np.testing.assert_allclose(drives[drives > 0] / np.diff(one.times_s)[drives > 0], SPEED_M_S)
    assert BounceSettings.of(mission).cells == "none"


def test_gaps_of_evenly_spaced_robots_are_the_checks(pair: Plan) -> None:
    zones = [zone for zone in pair.mission.zones if zone.period_s is not None]
    assert pair.mission.fleet.robots is not None
    tracks = tracks_of(pair.mission, pair.mission.fleet.robots[0], 140.0, zones, 0)
    mine = next(track for track in tracks if math.isclose(track.round_s, pair.trajectories[0].loop_duration_s))
    report = check_plan(pair)
    for z, demand in enumerate(report.demands):
        assert mine.gap_s(z, 2) == pytest.approx(demand.worst_gap_s, abs=1e-5)
    alone = replace(pair, trajectories=pair.trajectories[:1], mission=hall(1))
    for z, demand in enumerate(check_plan(alone).demands):
        assert mine.gap_s(z, 1) == pytest.approx(demand.worst_gap_s, abs=1e-5)
    assert mine.margin_s(2, 2 * BODY_M) == pytest.approx(clock_margin_s(pair), abs=1e-5)


def test_as_few_robots_as_meet_the_periods() -> None:
    found = search_plan(hall(None, period_s=250.0)).plan
    assert len(found.trajectories) == 1
    assert check_plan(found).verdict == "met"


def test_a_margin_that_no_spacing_has_is_refused(pair: Plan) -> None:
    margin_s = clock_margin_s(pair)
    assert margin_s is not None
    enough = search_plan(hall(2, clock_drift=0.005, clock_signal_s=0.9 * margin_s / 0.01))
    assert enough.report.verdict == "met"
    with pytest.raises(NoPlanFound, match="no team of 2 robots on attracting limit cycles keeps apart"):
        search_plan(hall(2, clock_drift=0.1, clock_signal_s=400.0))


@pytest.mark.slow  # looks at every angle
def test_zones_that_no_attracting_cycle_enters_are_named() -> None:
    with pytest.raises(MissionError, match="zones west, south: no attracting limit cycle of any robot enters them"):
        search_plan(hall(2, angle_deg=175.0))


def test_what_is_told_of_it(pair: Plan, answer: Answer) -> None:
    (fact,) = answer.facts
    assert "2 on a cycle of 18 contacts" in fact
    assert "along a wall" not in fact
    unstated = errors_sentence(pair)
    assert unstated is not None
    assert unstated.startswith("With turns off by up to 1 degree (the mission states no turning_error_deg), robots")
    off = replace(
        pair, mission=replace(pair.mission, planning=replace(BounceSettings.of(pair.mission), turning_error_deg=2.0))
    )
    text = errors_sentence(off)
    assert text is not None
    assert text.count("with exact turns 100.0 %") == 2
    shares = [float(part.split()[0]) for part in text.split("within its period ")[1:]]
    assert all(20 < share < 95 for share in shares)
    told = planner_of(off.mission).sentences(replace(answer, plan=off), check_plan(off))
    table, first, *others = [sentence for sentence in told if sentence]
    assert table.startswith("robot")
    assert first == fact
    assert len(others) == 3


def test_it_can_be_driven_and_has_no_cells_to_draw(pair: Plan, tmp_path: object) -> None:
    drives = drives_of(pair)
    assert all(leg.bumps for drive in drives for leg in drive.legs if leg.length_m > 0)
    with pytest.raises(PlanError, match="has no cells to draw"):
        draw_cells(pair, f"{tmp_path}/cells.png")


def test_a_cycle_that_leaves_walls_along_them_is_taken_where_no_other_serves_and_told() -> None:
    (fact,) = search_plan(hall(2, angle_deg=135.0)).facts
    assert "leaves contacts along a wall, where rounding alone may throw a robot off" in fact


def test_a_round_may_begin_at_a_contact_but_for_rounding() -> None:
    mission = hall(1)
    (robot,) = mission.fleet.robots or ()
    for track in tracks_of(mission, robot, 140.0, mission.zones, 0)[:2]:
        for k, time_s in [*enumerate(track.times_s[1:-1], start=1)][::3]:
            for late_s in (np.nextafter(time_s, 0), time_s, np.nextafter(time_s, np.inf)):
                begun = track.trajectory("robot-1", float(late_s))
                assert begun.loop_duration_s == pytest.approx(track.round_s, rel=1e-12)
                assert len(begun.times_s) == len(track.times_s)
                np.testing.assert_allclose(begun.positions_m[0], track.places_m[k], atol=1e-9)
                report = check_plan(Plan(mission=mission, trajectories=(begun,)))
                assert {v.kind for v in report.violations} <= {"gap"}
