"""What the check works out of a mission alone, before there is a plan."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import MultiPolygon, box, unary_union

from rota.check import check_plan, get_ready, seeable, standing, tiled_ground
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.model.plan import Plan, Trajectory

COLUMNS = [box(x, y, x + 1, y + 1) for x in (4, 9, 14) for y in (4, 8)]


def forget() -> None:
    """Forget all ground that was made ready."""
    for cached in (tiled_ground._tiles, seeable._ground, standing._standing_areas):
        cached.cache_clear()


@pytest.fixture(autouse=True)
def _nothing_known() -> None:
    """No other test has made the same ground ready."""
    forget()


def hall() -> Plan:
    """One robot goes up and down the middle of a hall with columns, and misses what these hide."""
    mission = Mission(
        name="hall", area=MultiPolygon([box(0, 0, 20, 13)]), period_s=100,
        obstacles=(Obstacle(shape=unary_union(COLUMNS), blocks="both"),),
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=12), body_radius_m=0.3),
    )  # fmt: skip
    ways_m = [[1.0, 6.5], [19.0, 6.5], [1.0, 6.5]]
    return Plan(mission=mission, trajectories=(Trajectory(robot="robot-1", times_s=[0, 18, 36], positions_m=ways_m),))


def counted(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Told from now on what is worked out of the mission."""
    told: list[str] = []
    triangles, areas, pieces = seeable.triangles_of, standing.standing, tiled_ground.convex_pieces
    monkeypatch.setattr(seeable, "triangles_of", lambda *given: (told.append("triangles"), triangles(*given))[1])
    monkeypatch.setattr(standing, "standing", lambda *given: (told.append("standing area"), areas(*given))[1])
    monkeypatch.setattr(tiled_ground, "convex_pieces", lambda *given: (told.append("tiles"), pieces(*given))[1])
    return told


def test_the_check_of_ragged_ground_that_is_ready_has_nothing_of_the_mission_left_to_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(seeable, "RAGGED_CORNERS", 0)
    unprepared = check_plan(hall())
    assert unprepared.verdict == "violated"
    forget()
    told = counted(monkeypatch)
    get_ready(hall().mission)
    assert {*told} == {"triangles", "standing area", "tiles"}
    told.clear()
    report = check_plan(hall())
    assert told == []
    assert report.demands == unprepared.demands
    assert np.array_equal(report.unmet_points_m, unprepared.unmet_points_m)
    assert report.violations == unprepared.violations


def test_other_ground_is_not_made_ready(monkeypatch: pytest.MonkeyPatch) -> None:
    told = counted(monkeypatch)
    get_ready(hall().mission)
    assert told == []
