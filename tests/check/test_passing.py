"""Pieces of which robots see each point as they pass, against the points themselves and a closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, box

from rota.check import check_plan, revisits
from rota.check.pieces import Pieces, point_pieces
from rota.check.revisits import passing_gaps, piece_gaps, sights_of
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, Zone
from rota.model.plan import Plan, Trajectory


def behind_a_slit(*, turns_m: float, robots: int = 1) -> Plan:
    """A pocket whose floor y = 5 is seen from the left through a slit, from x = 2 at no more than y = 5 itself.

    The robots drive up and down x = 2 from y = 3 to where they turn, one after the other, 25 s a robot.
    """
    pocket = shapely.union_all([box(6, 5, 7, 6), box(5, 4.5, 6, 7)])  # the slit runs from (5, 5) to (6, 5)
    solid = shapely.difference(box(5, 0, 8, 8), pocket)
    upper = box(4.5, 5, 5.5, 7)
    obstacle = Obstacle(shape=shapely.union_all([solid, upper]), blocks="both")
    mission = Mission(
        name="pocket",
        area=MultiPolygon([box(0, 0, 8, 8)]),
        obstacles=(obstacle,),
        zones=(Zone(name="pocket", shape=MultiPolygon([box(6.1, 5, 6.3, 5.2)]), period_s=50.0),),
        fleet=Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=9.0)),
    )
    rounds_s = 25.0 * robots
    late_s = 25.0 * np.arange(robots)
    trajectories = []
    for k in range(robots):
        corners = np.array([[2.0, 3.0], [2.0, turns_m], [2.0, 3.0]])
        up_s = turns_m - 3.0
        times = np.array([0.0, up_s, rounds_s])
        shift = late_s[k]
        times = np.concatenate([[0.0], shift + times]) if shift > 0 else times
        places = np.vstack([corners[:1], corners]) if shift > 0 else corners
        trajectories.append(
            Trajectory(robot=f"robot-{k + 1}", times_s=times, positions_m=places, loop_start_s=float(shift))
        )
    return Plan(mission=mission, trajectories=tuple(trajectories))


def floor_pieces(plan: Plan, height_m: float) -> Pieces:
    """Squares in a row on the pocket's floor."""
    x = 6.1 + height_m * np.arange(8)
    corners = [[(a, 5), (a + height_m, 5), (a + height_m, 5 + height_m), (a, 5 + height_m)] for a in x]
    return Pieces(offsets=4 * np.arange(9, dtype=np.int64), corners_m=np.array(corners, dtype=float).reshape(-1, 2))


@pytest.mark.parametrize("height_m", [0.1, 1e-3, 1e-5])
def test_the_floor_of_a_pocket_is_seen_whole_by_nobody_and_each_point_by_who_passes_the_slit(height_m: float) -> None:
    plan = behind_a_slit(turns_m=5.5)
    sights = sights_of(plan, plan.mission.area.bounds)
    pieces = floor_pieces(plan, height_m)
    limits = np.full(8, 50.0)
    assert np.isinf(piece_gaps(sights, pieces, limits).gaps_s).all()
    assert passing_gaps(sights, pieces, limits).gaps_s == pytest.approx(np.full(8, 25.0), abs=1e-6)


def test_who_turns_short_of_the_slit_does_not_see_what_touches_its_line() -> None:
    plan = behind_a_slit(turns_m=4.99)
    sights = sights_of(plan, plan.mission.area.bounds)
    assert np.isinf(passing_gaps(sights, floor_pieces(plan, 1e-3), np.full(8, 50.0)).gaps_s).all()


def test_robots_that_follow_each_other_count_together() -> None:
    plan = behind_a_slit(turns_m=5.5, robots=3)
    sights = sights_of(plan, plan.mission.area.bounds)
    gaps = passing_gaps(sights, floor_pieces(plan, 1e-3), np.full(8, 50.0))
    assert gaps.gaps_s == pytest.approx(np.full(8, 25.0), abs=1e-6)
    assert passing_gaps(sights, floor_pieces(plan, 1e-3), np.full(8, 20.0)).gaps_s.min() > 24.9


def test_threads_that_share_the_pieces_find_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = behind_a_slit(turns_m=5.5, robots=3)
    sights = sights_of(plan, plan.mission.area.bounds)
    pieces, limits = floor_pieces(plan, 1e-3), np.linspace(20.0, 50.0, 8)
    alone = [of(sights, pieces, limits) for of in (passing_gaps, piece_gaps)]
    monkeypatch.setattr(revisits, "MOST_ALONE", 1)
    monkeypatch.setattr("os.cpu_count", lambda: 3)
    for before, of in zip(alone, (passing_gaps, piece_gaps), strict=True):
        together = of(sights, pieces, limits)
        assert together.gaps_s.tolist() == before.gaps_s.tolist()
        assert together.firsts_s.tolist() == before.firsts_s.tolist()
        assert together.exact.tolist() == before.exact.tolist()


def slit_scene(rng: np.random.Generator) -> tuple[Plan, list[np.ndarray]]:
    """A slit from a corner at (0, 0) to one up to 1.5 m to the left, turned by chance, blocks strewn about; squares.

    The squares lie right of the slit and touch its line from above, in the frame that is not turned: seen whole by
    nobody. A robot drives to and fro across the line, left of the slit.
    """
    slit_m, turn = rng.uniform(0.2, 1.5), rng.uniform(0, 360)

    def turned(shape: shapely.Geometry) -> shapely.Geometry:
        return shapely.affinity.rotate(shape, turn, origin=(0, 0))

    upper = shapely.Polygon([(-slit_m, 0), (-slit_m - 0.3, 1.5), (-slit_m + 0.1, 1.5)])
    lower = shapely.Polygon([(0, 0), (3, -rng.uniform(0, 0.3)), (3, -1), (0, -1)])
    blocks = [
        shapely.Point(rng.uniform([-4, -2], [3, 2])).buffer(rng.uniform(0.02, 0.3), quad_segs=2) for _ in range(5)
    ]
    shapes = [turned(shape) for shape in (upper, lower, *blocks)]
    ends = np.array([(rng.uniform(-4, -2), -rng.uniform(0.1, 2)), (rng.uniform(-4, -2), rng.uniform(0.1, 2))])
    ends = shapely.get_coordinates(turned(shapely.LineString(ends)))
    mission = Mission(
        name="slit",
        area=MultiPolygon([box(-9, -9, 9, 9)]),
        obstacles=tuple(Obstacle(shape=shape, blocks="sight") for shape in shapes),
        fleet=Fleet(speed_m_s=9.0, sensor=DiscSensor(radius_m=rng.uniform(3, 9))),
        period_s=20.0,
    )
    route = Trajectory(robot="robot-1", times_s=np.array([0.0, 5.0, 10.0]), positions_m=ends[[0, 1, 0]])
    squares = []
    hidden = shapely.union_all(shapes).buffer(-1e-9)
    for _ in range(60):
        x, size_m = rng.uniform(0.05, 2.5), 10 ** rng.uniform(-3, -0.3)
        ring = shapely.get_coordinates(turned(box(x, 0, x + size_m, size_m)))[:4]
        if not shapely.intersects(hidden, shapely.Polygon(ring)):
            squares.append(ring)
    return Plan(mission=mission, trajectories=(route,)), squares


def test_robots_with_other_sensors_do_not_count_together() -> None:
    """They may see a point from another place of the leg, at another moment of it: each counts by itself."""
    plan = behind_a_slit(turns_m=5.5, robots=2)
    fleet = plan.mission.fleet
    robots = tuple(Robot(name=f"robot-{k + 1}", speed_m_s=1.0, sensor=DiscSensor(radius_m=9.0 - k)) for k in range(2))
    plan = replace(plan, mission=replace(plan.mission, fleet=replace(fleet, robots=robots)))
    sights = sights_of(plan, plan.mission.area.bounds)
    gaps = passing_gaps(sights, floor_pieces(plan, 1e-3), np.full(8, 50.0))
    assert gaps.gaps_s == pytest.approx(np.full(8, 50.0), abs=1e-6)


@pytest.mark.parametrize(("bends", "gap_s"), [((1.0, 1.0), 25.0), ((1.0, 0.9), 50.0), ((-1.0, 0.0), 50.0)])
def test_followers_count_together_if_they_speed_up_alike(bends: tuple[float, float], gap_s: float) -> None:
    plan = behind_a_slit(turns_m=5.5, robots=2)
    ways = []
    for way, bend in zip(plan, bends, strict=True):
        lengths = np.hypot(*np.diff(way.positions_m, axis=0).T)
        ways.append(replace(way, accelerations_m_s2=2 * bend * lengths / np.diff(way.times_s) ** 2))
    plan = replace(plan, trajectories=tuple(ways))
    gaps = passing_gaps(sights_of(plan, plan.mission.area.bounds), floor_pieces(plan, 1e-3), np.full(8, 30.0))
    assert gaps.gaps_s == pytest.approx(np.full(8, gap_s), abs=1e-6)


def test_no_point_of_a_piece_seen_in_passing_waits_longer_than_is_told() -> None:
    """Each square is asked at 60 places inside and near its corners, a little off the line where sight is a moment."""
    passed = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        plan, squares = slit_scene(rng)
        sights = sights_of(plan, plan.mission.area.bounds)
        pieces = Pieces(offsets=4 * np.arange(len(squares) + 1, dtype=np.int64), corners_m=np.vstack(squares))
        limits = np.full(len(squares), 20.0)
        gaps = passing_gaps(sights, pieces, limits).gaps_s
        passed += np.count_nonzero(np.isfinite(gaps) & np.isinf(piece_gaps(sights, pieces, limits).gaps_s))
        for k in np.flatnonzero(np.isfinite(gaps)):
            weights = 0.999 * np.vstack([rng.dirichlet(np.full(4, 0.4), 60), np.eye(4)]) + 0.00025
            points = piece_gaps(sights, point_pieces(weights @ squares[k]), np.full(64, 20.0)).gaps_s
            assert (points <= gaps[k] + 1e-6).all(), (seed, squares[k], gaps[k], points)
    assert passed > 300, passed


def test_a_plan_that_only_ever_sees_a_pocket_in_passing_meets_the_demand() -> None:
    """Cut as finely as one likes, no piece on the pocket's floor is seen whole."""
    report = check_plan(behind_a_slit(turns_m=5.5))
    assert report.verdict == "met"
    assert report.demands[0].worst_gap_s == pytest.approx(25.0, abs=1e-6)
    assert report.demands[0].excluded_area_m2 == 0
    assert check_plan(behind_a_slit(turns_m=4.99)).verdict == "violated"
