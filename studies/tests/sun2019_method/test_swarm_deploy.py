"""Whole missions deployed by the paper's swarms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from benchmarks.missions import EXAMPLES
from benchmarks.sun_tables import TABLE_2
from shapely import MultiPolygon, Point, Polygon, box

from rota.files.mission_file import read_mission
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota_studies.sun2019_method.deploy import DeploySettings, history_of
from rota_studies.sun2019_stages.deploy import Deployment, deploy_sensors

SHORT = replace(TABLE_2, iterations=15, particles=10, sensors_max=None)
FIELD = Mission(
    name="test",
    area=MultiPolygon([box(0, 0, 40, 40)]),
    period_s=60.0,
    fleet=Fleet(speed_m_s=2.0, sensor=DiscSensor(radius_m=4.0)),
)


def zone(name: str, shape: Polygon, period_s: float) -> Zone:
    return Zone(name=name, shape=MultiPolygon([shape]), period_s=period_s)


def sensors(deployment: Deployment) -> list[int]:
    return [len(zone.positions_m) for zone in deployment.zones]


def all_is_seen(deployment: Deployment) -> bool:
    """Every cell is seen, and all its corners are within r_v of a sensor: shapely alone."""
    for part in deployment.zones:
        for shape in part.cells.shapes:
            far_m = [np.hypot(*(shapely.get_coordinates(shape) - place).T).max() for place in part.positions_m]
            if min(far_m) > deployment.virtual_radius_m + 1e-6:
                return False
    return all((part.times_seen > 0).all() for part in deployment.zones)


def test_swarms_on_figure_13_s_small_zones_need_no_more_than_the_paper() -> None:
    asked = replace(read_mission(EXAMPLES / "sun2019-fig13.yaml").mission, period_s=None)
    found = deploy_sensors(asked, replace(TABLE_2, sensors_max=40), seed=1)
    assert sensors(found)[0] <= 10
    assert sensors(found)[1] <= 15
    history = history_of(found)
    assert history is not None
    assert history.completed == 0
    assert history.sensors[-1] == sum(sensors(found))
    assert all_is_seen(found)


def test_swarms_see_all_of_ground_with_holes_parts_and_circles() -> None:
    ring = box(0, 0, 40, 40).difference(box(16, 16, 24, 24))
    asked = replace(
        FIELD,
        area=MultiPolygon([ring, box(45, 5, 60, 15)]),
        obstacles=tuple(
            Obstacle(shape=MultiPolygon([shape])) for shape in (Point(8, 30).buffer(4), box(30, 3, 33, 20))
        ),
        zones=(zone("round", Point(28, 30).buffer(7), 10.0),),
    )
    found = deploy_sensors(asked, SHORT, seed=5)
    assert all_is_seen(found)
    standing = asked.area.difference(shapely.union_all([item.shape for item in asked.obstacles])).buffer(1e-9)
    assert shapely.intersects_xy(standing, *found.positions_m.T).all()
    assert found.zone_of.tolist() == [0] * sensors(found)[0] + [1] * sensors(found)[1]


def test_ground_closed_to_robots_is_seen_from_its_shore() -> None:
    pond = Point(20, 20).buffer(5)
    closed = Obstacle(shape=MultiPolygon([pond]), blocks="motion")
    found = deploy_sensors(replace(FIELD, obstacles=(closed,), zones=(zone("pond", pond, 10.0),)), SHORT)
    assert (found.zones[0].times_seen > 0).all()


def test_too_few_sensors_are_completed_and_the_history_says_so() -> None:
    found = deploy_sensors(FIELD, replace(SHORT, sensors_max=3))
    history = history_of(found)
    assert history is not None
    assert history.sensors.max() <= 3
    assert history.completed > 0
    assert len(found.positions_m) == history.sensors[-1] + history.completed
    assert (found.zones[0].times_seen > 0).all()


def test_set_covers_have_no_history_and_are_those_of_the_product() -> None:
    for method in ("greedy", "exact"):
        found = deploy_sensors(FIELD, DeploySettings(method=method))
        assert history_of(found) is None
        assert all_is_seen(found)


def test_seeds_decide_and_cores_do_not(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = replace(FIELD, zones=(zone("quick", box(5, 5, 20, 20), 5.0),))
    found = []
    for seed, cores in ((3, 1), (3, 2), (4, 2)):
        monkeypatch.setattr("os.cpu_count", lambda cores=cores: cores)
        found.append(deploy_sensors(asked, SHORT, seed=seed))
    first, again, other = found
    assert first.positions_m.tolist() == again.positions_m.tolist()
    assert first.positions_m.tolist() != other.positions_m.tolist()
    history = history_of(first)
    assert history is not None
    parts = [cover.history.cost for one in first.zones for cover in one.covers]
    assert history.cost.tolist() == sum(parts).tolist()
