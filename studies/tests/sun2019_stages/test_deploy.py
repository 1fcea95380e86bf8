"""Deployments of whole missions: the paper's figures, and ground of every kind."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Point, Polygon, box

from rota.errors import MissionError, NoPlanFound
from rota.files.mission_file import read_mission
from rota.geometry.free_space import demanded_regions
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, SquareSensor, Zone
from rota_studies.sun2019_stages.algorithms import SensorCover
from rota_studies.sun2019_stages.deploy import Deployment, deploy_sensors

EXAMPLES = Path(__file__).parents[3] / "examples"
GREEDY, EXACT = SensorCover(method="greedy"), SensorCover(method="exact")


def mission(**fields: object) -> Mission:
    given: dict = {
        "name": "test",
        "area": MultiPolygon([box(0, 0, 40, 40)]),
        "period_s": 60.0,
        "fleet": Fleet(speed_m_s=2.0, sensor=DiscSensor(radius_m=4.0)),
    }
    return Mission(**(given | fields))


def obstacle(shape: Polygon, blocks: str = "both") -> Obstacle:
    return Obstacle(shape=MultiPolygon([shape]), blocks=blocks)


def zone(name: str, shape: Polygon, period_s: float | None, demand: str = "every_point") -> Zone:
    return Zone(name=name, shape=MultiPolygon([shape]), period_s=period_s, demand=demand)


@cache
def figure(number: int) -> Mission:
    return read_mission(EXAMPLES / f"sun2019-fig{number}.yaml").mission


def sensors(deployment: Deployment) -> list[int]:
    return [len(zone.positions_m) for zone in deployment.zones]


def unseen_m2(asked: Mission, deployment: Deployment, among: list[str]) -> float:
    """Ground of the zones within no sensor's radius, or hidden from all of them by obstacles: shapely alone."""
    hidden = shapely.union_all([item.shape for item in asked.obstacles if item.blocks_sight]).buffer(-1e-6)
    lost = 0.0
    for part, region in zip(deployment.zones, sorted(demanded_regions(asked), key=lambda r: r.period_s), strict=True):
        if part.name not in among:
            continue
        # polygons of 256 corners about the discs
        outer_m = deployment.virtual_radius_m / np.cos(np.pi / 256)
        discs = [Point(p).buffer(outer_m, quad_segs=64) for p in part.positions_m]
        lost += region.shape.difference(shapely.union_all(discs)).area
        for c, shape in enumerate(part.cells.shapes):
            corners = shapely.get_coordinates(shape)
            views = [
                all(not shapely.LineString([p, corner]).intersects(hidden) for corner in corners)
                for p in part.positions_m
                if np.hypot(*(corners - p).T).max() <= deployment.virtual_radius_m + 1e-6
            ]
            lost += 0.0 if any(views) or part.times_seen[c] == 0 else shape.area
    return lost


# ---------------------------------------------------------------- the paper's maps


def test_greedy_cover_of_figure_13_as_calibrated() -> None:
    # 50 x 50 cells of 2.4 m, r_v = 10 m: 10/18/89 by another program; ties may fall otherwise
    found = deploy_sensors(figure(13), replace(GREEDY, border_cells="centre"))
    assert sensors(found) == pytest.approx([10, 18, 89], abs=2)
    assert [zone.name for zone in found.zones] == ["zone-1", "zone-2", "area"]
    assert sum(len(zone.cells) for zone in found.zones) == 195 + 361 + 1658
    assert found.virtual_radius_m == 10.0


def test_the_whole_ground_of_figure_13_is_seen_by_its_own_zone_s_sensors() -> None:
    asked = figure(13)
    found = deploy_sensors(asked, GREEDY)
    assert unseen_m2(asked, found, ["zone-1", "zone-2", "area"]) == pytest.approx(0.0, abs=1e-6)
    regions = sorted(demanded_regions(asked), key=lambda region: region.period_s)
    for part, region in zip(found.zones, regions, strict=True):
        assert shapely.intersects_xy(region.shape, *part.positions_m.T).all()
        assert (part.times_seen > 0).all()
    assert (
        found.periods_s.tolist() == [8.0] * sensors(found)[0] + [20.0] * sensors(found)[1] + [40.0] * sensors(found)[2]
    )


def test_exact_cover_of_figure_13_s_small_zones() -> None:
    asked = replace(figure(13), period_s=None)
    found = deploy_sensors(asked, replace(EXACT, border_cells="centre"))
    assert sensors(found)[0] == 8
    assert sensors(found)[1] <= 15
    assert [[cover.least for cover in zone.covers] for zone in found.zones] == [[8], [pytest.approx(14, abs=1)]]
    assert [cover.least for zone in deploy_sensors(asked, GREEDY).zones for cover in zone.covers] == [None, None]


def test_greedy_cover_of_figure_16_with_a_hexagon_and_a_circle() -> None:
    asked = figure(16)
    found = deploy_sensors(asked, GREEDY)
    assert sensors(found)[0] <= 9
    assert sensors(found)[1] <= 6
    assert unseen_m2(asked, found, ["zone-1", "zone-2", "area"]) == pytest.approx(0.0, abs=1e-6)


# ---------------------------------------------------------------- any mission


@pytest.mark.parametrize("algorithm", [GREEDY, EXACT], ids=["greedy", "exact"])
def test_covers_see_all_of_ground_with_holes_parts_and_circles(algorithm: SensorCover) -> None:
    ring = box(0, 0, 40, 40).difference(box(16, 16, 24, 24))
    asked = mission(
        area=MultiPolygon([ring, box(45, 5, 60, 15)]),
        obstacles=(obstacle(Point(8, 30).buffer(4)), obstacle(box(30, 3, 33, 20))),
        zones=(zone("round", Point(28, 30).buffer(7), 10.0),),
    )
    found = deploy_sensors(asked, algorithm, seed=5)
    assert unseen_m2(asked, found, ["round", "area"]) == pytest.approx(0.0, abs=1e-6)
    assert all((part.times_seen > 0).all() for part in found.zones)
    standing = asked.area.difference(shapely.union_all([item.shape for item in asked.obstacles])).buffer(1e-9)
    assert shapely.intersects_xy(standing, *found.positions_m.T).all()
    assert found.zone_of.tolist() == [0] * sensors(found)[0] + [1] * sensors(found)[1]


def test_zones_come_by_their_periods_and_the_smallest_rules_where_they_overlap() -> None:
    asked = mission(
        zones=(
            zone("slow", box(5, 5, 25, 25), 30.0),
            zone("quick", box(15, 15, 35, 35), 5.0),
            zone("none", box(0, 36, 9, 40), None),
        )
    )
    found = deploy_sensors(asked, GREEDY)
    assert [(part.name, part.period_s) for part in found.zones] == [("quick", 5.0), ("slow", 30.0), ("area", 60.0)]
    ground_m2 = [shapely.area(part.cells.shapes).sum() for part in found.zones]
    assert ground_m2 == pytest.approx([400, 400 - 100, 1600 - 700 - 36])


def test_a_covered_zone_hides_what_lies_behind_it() -> None:
    # a strip of 4 m, crossed by a quick zone of 1 m: its far side takes sensors of its own
    area = MultiPolygon([box(0, 0, 13, 4)])
    plain = deploy_sensors(mission(area=area), EXACT)
    crossed = deploy_sensors(mission(area=area, zones=(zone("quick", box(6, 0, 7, 4), 5.0),)), EXACT)
    assert sensors(plain) == [1]
    assert sensors(crossed) == [1, 2]


def test_ground_closed_to_robots_is_seen_from_its_shore() -> None:
    pond = Point(20, 20).buffer(5)
    asked = mission(obstacles=(obstacle(pond, "motion"),), zones=(zone("pond", pond, 10.0),))
    found = deploy_sensors(asked, GREEDY)
    assert unseen_m2(asked, found, ["pond", "area"]) == pytest.approx(0.0, abs=1e-6)
    assert not shapely.contains_xy(pond.buffer(-1e-9), *found.positions_m.T).any()


def test_a_closed_room_is_told_and_costs_nothing() -> None:
    walls = box(5, 5, 15, 15).difference(box(6, 6, 14, 14))
    asked = mission(
        obstacles=(obstacle(walls), obstacle(box(6, 6, 14, 14), "motion")), period_s=60.0
    )  # nobody can get in, and nobody sees in
    found = deploy_sensors(asked, GREEDY)
    lost = shapely.area(found.zones[0].cells.shapes[found.zones[0].times_seen == 0]).sum()
    assert lost == pytest.approx(64.0)
    assert unseen_m2(asked, found, []) == 0.0


def test_cells_round_corners_are_quartered_until_they_are_seen() -> None:
    # a wall of 0.2 m that ends in the middle of a cell: no place sees both of its sides
    asked = mission(obstacles=(obstacle(box(8.9, 0, 9.1, 21)),))
    found = deploy_sensors(asked, replace(GREEDY, cell_m=2.0))
    small = shapely.area(found.zones[0].cells.shapes).min()
    assert small < 1.0
    assert (found.zones[0].times_seen > 0).all()


def test_a_zone_to_visit_takes_one_sensor_inside_and_hides_nothing() -> None:
    spot = box(18, 18, 22, 22)
    asked = mission(zones=(zone("post", spot, 20.0, "visit"),))
    found = deploy_sensors(asked, GREEDY)
    assert sensors(found)[0] == 1
    assert spot.covers(Point(found.positions_m[0]))
    closed = mission(zones=(zone("post", spot, 20.0, "visit"),), obstacles=(obstacle(box(17, 17, 23, 23)),))
    with pytest.raises(NoPlanFound, match=r"no robot can be inside zone post, at \(20\.00, 20\.00\)"):
        deploy_sensors(closed, GREEDY)


def test_wide_bodies_keep_sensors_off_the_walls() -> None:
    fleet = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=4.0), body_radius_m=1.0)
    found = deploy_sensors(mission(fleet=fleet), GREEDY)
    assert found.positions_m.min() >= 1.0
    assert found.positions_m.max() <= 39.0
    assert (found.zones[0].times_seen > 0).all()
    with pytest.raises(NoPlanFound, match="body of radius 30"):
        deploy_sensors(mission(fleet=replace(fleet, body_radius_m=30.0)), GREEDY)


def test_square_sensors_are_refused() -> None:
    fleet = Fleet(speed_m_s=1.0, sensor=SquareSensor(side_m=6.0))
    with pytest.raises(MissionError, match=r"fleet\.sensor: a square of side 6 m is not allowed; .* disc"):
        deploy_sensors(mission(fleet=fleet))
