"""The benchmark's random missions: what they are like, and that none is drawn that could not be planned."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import shapely
from benchmarks.charging import yard
from benchmarks.random_missions import described, is_fair, random_mission, sweeping
from shapely import MultiPolygon, box

from rota import make_plan
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, SquareSensor, Zone
from rota.planners.patrol.planner_settings import PatrolSettings

COURT = Mission(
    name="court",
    area=MultiPolygon([box(0, 0, 30, 20)]),
    obstacles=(Obstacle(shape=MultiPolygon([box(20, 10, 25, 15)])),),
    zones=(
        Zone(name="slow", shape=MultiPolygon([box(0, 0, 10, 10)]), period_s=50),
        Zone(name="urgent", shape=MultiPolygon([box(5, 5, 15, 15)]), period_s=10),
        Zone(name="hall", shape=MultiPolygon([box(15, 0, 20, 5)]), period_s=5, demand="visit"),
        Zone(name="lawn", shape=MultiPolygon([box(-5, 15, 10, 25)]), period_s=None),
    ),
    period_s=25,
    fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=3)),
)


@pytest.fixture(scope="module")
def missions() -> list[Mission]:
    return [random_mission(seed) for seed in range(200)]


def test_a_seed_is_a_mission(missions: list[Mission]) -> None:
    assert [random_mission(seed) for seed in (3, 0, 41)] == [missions[seed] for seed in (3, 0, 41)]
    assert len({mission.area.wkb for mission in missions}) == len(missions)
    assert [mission.name for mission in missions] == [f"random-{seed}" for seed in range(200)]
    assert {PatrolSettings.of(mission).effort for mission in missions} == {"quick"}
    # in whole centimetres, but free of any grid, which everything made of a shape would inherit
    for shape in (shape for mission in missions for shape in (mission.area, *(o.shape for o in mission.obstacles))):
        corners_cm = 100 * shapely.get_coordinates(shape)
        assert abs(corners_cm - corners_cm.round()).max() < 1e-9
        assert shapely.get_precision(shape) == 0


def test_every_kind_is_drawn_often_enough(missions: list[Mission]) -> None:
    def share(count: int) -> float:
        return count / len(missions)

    fleets = [mission.fleet for mission in missions]
    blocks = [{obstacle.blocks for obstacle in mission.obstacles} for mission in missions]
    zones = [zone for mission in missions for zone in mission.zones]
    assert share(sum(any(part.interiors for part in mission.area.geoms) for mission in missions)) > 0.05
    assert share(sum(mission.area.convex_hull.area > 1.001 * mission.area.area for mission in missions)) > 0.4
    assert share(sum(len(mission.area.geoms) == 2 for mission in missions)) > 0.02
    assert share(sum("both" in found for found in blocks)) > 0.3
    assert share(sum("motion" in found for found in blocks)) > 0.04
    assert share(sum("sight" in found for found in blocks)) > 0.04
    assert share(sum(fleet.body_radius_m > 0 for fleet in fleets)) > 0.25
    assert share(sum(fleet.turn_rate_rad_s is not None for fleet in fleets)) > 0.12
    assert share(sum(fleet.robots is not None for fleet in fleets)) > 0.05
    assert share(sum(isinstance(fleet.sensor, SquareSensor) for fleet in fleets)) > 0.12
    assert share(sum(bool(mission.zones) for mission in missions)) > 0.5
    assert sum(zone.demand == "visit" for zone in zones) / len(zones) > 0.1
    assert sum(zone.period_s is None for zone in zones) / len(zones) > 0.04


def test_every_mission_is_fair(missions: list[Mission]) -> None:
    assert all(is_fair(mission) for mission in missions)
    # a robot in the middle of nowhere else to stand still sees something: no mission is all walls
    for mission in missions:
        left, bottom, right, top = mission.area.bounds
        assert min(right - left, top - bottom) > 10
        assert max(right - left, top - bottom) < 85
        assert 0.1 < sweeping(mission) <= 6


def test_sweeping_is_area_over_period_with_the_shortest_period_first() -> None:
    urgent_m2, slow_m2, lawn_m2 = 100, 100 - 25, 10 * 5
    rest_m2 = 600 - urgent_m2 - slow_m2 - lawn_m2 - 25
    expected = (urgent_m2 / 10 + slow_m2 / 50 + rest_m2 / 25) / (2 * 3 * 2)
    assert sweeping(COURT) == pytest.approx(expected)
    square = replace(COURT, fleet=Fleet(speed_m_s=2, sensor=SquareSensor(side_m=12)))
    assert sweeping(square) == pytest.approx(expected / 2)


def test_what_no_planner_could_do_is_not_fair() -> None:
    assert is_fair(COURT)
    corridor = Obstacle(shape=MultiPolygon([box(14, 0.4, 15, 20)]))
    assert is_fair(replace(COURT, obstacles=(corridor,)))
    bodies = replace(COURT.fleet, body_radius_m=0.1)  # two of them need 0.6 m to pass each other, and there are 0.4
    assert is_fair(replace(COURT, fleet=bodies))
    assert not is_fair(replace(COURT, obstacles=(corridor,), fleet=bodies))
    short_sighted = replace(COURT, fleet=replace(COURT.fleet, body_radius_m=0.5, sensor=DiscSensor(radius_m=0.5)))
    assert not is_fair(short_sighted)  # corners stay out of range
    assert not is_fair(replace(COURT, period_s=2))  # far more robots than a small mission should need
    walled = Obstacle(shape=MultiPolygon([box(15, 0, 20, 5)]), blocks="motion")
    assert not is_fair(replace(COURT, obstacles=(walled,)))  # nobody can visit the hall


def test_a_mission_is_described_in_a_few_words() -> None:
    text = described(replace(COURT, fleet=replace(COURT.fleet, body_radius_m=0.1, turn_rate_rad_s=2.0)))
    assert text == (
        "600 m2, obstacle, every_point zone 50 s, every_point zone 10 s, visit zone 5 s, zone without period, disc,"
        " body 0.1 m, turning 2.0 rad/s"
    )
    assert math.isfinite(sweeping(COURT))


@pytest.mark.slow  # two searches at normal
def test_normal_takes_as_few_robots_as_quick() -> None:
    """In the yard loops of normal are longer once robots take turns; the others are shorter, but spare no robot."""
    assert len(make_plan(yard(0).with_effort("normal"))) == 2
    assert len(make_plan(random_mission(102).with_effort("normal"))) == 4


@pytest.mark.slow  # a whole search
def test_loops_of_robots_that_turn_on_the_spot_are_moved_by_linear_programs() -> None:
    """Detours alone take six robots there."""
    assert len(make_plan(random_mission(139))) == 5
