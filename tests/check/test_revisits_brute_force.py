"""Worst gaps of random plans against brute force: sampled times, sight by shapely."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Point, Polygon, box
from tests.check.accelerated import all_accelerated
from tests.seeds import seeds

from rota.check import check_plan, revisits
from rota.check.pieces import convex_pieces, point_pieces
from rota.check.revisits import piece_gaps, sights_of, worst_gaps_s
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, SquareSensor
from rota.model.plan import Plan, Trajectory

STEP_S = 0.02


def random_plan(rng: np.random.Generator, *, robots: int, obstacles: int) -> Plan:
    shapes = []
    for _ in range(obstacles):
        centre, size = rng.uniform(1, 9, 2), rng.uniform(0.3, 1.5)
        ring = [(size * math.cos(a), size * math.sin(a)) for a in np.sort(rng.uniform(0, 2 * math.pi, 5))]
        shapes.append(shapely.affinity.translate(Polygon(ring), *centre))
    durations = rng.choice([6.0, 9.0, 12.0, 18.0], robots)
    fleet, trajectories = [], []
    for k in range(robots):
        disc, square = DiscSensor(radius_m=rng.uniform(2, 4)), SquareSensor(side_m=rng.uniform(3, 7))
        sensor = disc if rng.random() < 0.6 else square
        fleet.append(Robot(name=f"r{k}", speed_m_s=100.0, sensor=sensor))
        n, lead = int(rng.integers(3, 7)), int(rng.integers(0, 3))
        xy = rng.uniform(0, 10, (lead + n, 2))
        if rng.random() < 0.3:
            xy[-1] = xy[-2]
        xy = np.vstack([xy, xy[lead : lead + 1]])
        times = np.concatenate([np.arange(lead), lead + np.linspace(0, durations[k], n + 1)])
        trajectories.append(Trajectory(robot=f"r{k}", times_s=times, positions_m=xy, loop_start_s=float(lead)))
    mission = Mission(
        name="random",
        area=MultiPolygon([box(0, 0, 10, 10)]),
        obstacles=tuple(Obstacle(shape=s, blocks="sight") for s in shapes),
        fleet=Fleet(speed_m_s=100.0, sensor=DiscSensor(radius_m=1.0), robots=tuple(fleet)),
        period_s=1.0,
    )
    return Plan(mission=mission, trajectories=tuple(trajectories))


@pytest.mark.parametrize("bent", [False, True])
@pytest.mark.parametrize("seed", seeds(6, at_once=2))
def test_first_sights_match_sampled_times(seed: int, bent: bool) -> None:
    rng = np.random.default_rng(300 + seed)
    plan = random_plan(rng, robots=2, obstacles=0)
    plan = all_accelerated(plan, rng) if bent else plan
    points = rng.uniform(0, 10, (60, 2))
    times = np.arange(0, max(t.times_s[-1] for t in plan), 1e-3)
    firsts = np.full(len(points), np.inf)
    for trajectory in plan:
        sensor = plan.mission.fleet.robot(trajectory.robot).sensor
        away = np.abs(points[:, None] - trajectory.at(times)[None])
        if isinstance(sensor, DiscSensor):
            near = np.hypot(away[..., 0], away[..., 1]) <= sensor.radius_m
        else:
            near = away.max(axis=2) <= sensor.side_m / 2
        firsts = np.where(near.any(axis=1), np.minimum(firsts, times[near.argmax(axis=1)]), firsts)
    found = piece_gaps(sights_of(plan, (0, 0, 10, 10)), point_pieces(points), np.zeros(60)).firsts_s
    assert (found <= firsts + 1e-6).all()  # samples may miss a sight
    assert np.mean(np.isclose(found, firsts, atol=1.1e-3) | (np.isinf(found) & np.isinf(firsts))) >= 0.95


def sampled_gaps_s(plan: Plan, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Longest run of sampled times without sight, over one common period after the last loop start, wrapped round."""
    period = math.lcm(*(round(t.loop_duration_s) for t in plan))
    begin = max(t.loop_start_s for t in plan)
    times = begin + np.arange(0, period, STEP_S)
    hidden = shapely.union_all([o.shape for o in plan.mission.obstacles if o.blocks_sight]).buffer(-1e-6)
    shapely.prepare(hidden)
    seen = np.zeros((len(points), len(times)), bool)
    for trajectory in plan:
        sensor = plan.mission.fleet.robot(trajectory.robot).sensor
        xy = trajectory.at(times)
        away = np.abs(points[:, None] - xy[None])
        if isinstance(sensor, DiscSensor):
            near = np.hypot(away[..., 0], away[..., 1]) <= sensor.radius_m
        else:
            near = away.max(axis=2) <= sensor.side_m / 2
        p, k = np.nonzero(near)
        lines = shapely.linestrings(np.stack([points[p], xy[k]], axis=1))
        clear = ~shapely.intersects(hidden, lines)
        seen[p[clear], k[clear]] = True
    gaps = np.full(len(points), np.inf)
    for i, row in enumerate(seen):
        on = np.flatnonzero(row)
        if len(on):
            gaps[i] = np.diff(np.append(on, on[0] + len(times))).max() * STEP_S
    return gaps


@pytest.mark.parametrize("bent", [False, True])
@pytest.mark.parametrize("seed", seeds(12, at_once=4))
def test_point_gaps_match_sampled_times(seed: int, bent: bool) -> None:
    rng = np.random.default_rng(seed)
    plan = random_plan(rng, robots=int(rng.integers(1, 4)), obstacles=int(rng.integers(0, 5)))
    plan = all_accelerated(plan, rng) if bent else plan
    points = rng.uniform(0, 10, (60, 2))
    exact, sampled = worst_gaps_s(plan, points), sampled_gaps_s(plan, points)
    hidden = shapely.union_all([o.shape for o in plan.mission.obstacles])
    inside = np.array([hidden.contains(Point(p)) for p in points])
    assert np.isinf(exact[inside]).all()
    # a sight shorter than the sampling step may be missed by the samples, so those are only ever longer
    assert (exact <= sampled + 1e-6).all()
    close = np.isclose(exact, sampled, atol=2.5 * STEP_S) | (np.isinf(exact) & np.isinf(sampled))
    assert close.mean() >= 0.95


@pytest.mark.parametrize("bent", [False, True])
@pytest.mark.parametrize("seed", seeds(12, at_once=4))
def test_a_piece_is_never_judged_better_than_any_of_its_points(seed: int, bent: bool) -> None:
    rng = np.random.default_rng(100 + seed)
    plan = random_plan(rng, robots=int(rng.integers(1, 4)), obstacles=int(rng.integers(1, 6)))
    plan = all_accelerated(plan, rng) if bent else plan
    ground = plan.mission.area.difference(shapely.union_all([o.shape for o in plan.mission.obstacles]))
    pieces = convex_pieces(ground, 0.4, 1e-9)
    upper = piece_gaps(sights_of(plan, ground.bounds), pieces, np.zeros(len(pieces))).gaps_s
    assert np.isfinite(upper).any()
    weights = rng.dirichlet(np.ones(4), (5, len(pieces)))
    for weight in weights:
        first = pieces.offsets[:-1]
        counts = np.diff(pieces.offsets)
        points = sum(weight[:, [k]] * pieces.corners_m[first + np.minimum(k, counts - 1)] for k in range(4))
        points = 1e-6 * pieces.centres_m() + (1 - 1e-6) * points
        assert (worst_gaps_s(plan, points) <= upper + 1e-6).all()


@pytest.mark.parametrize("seed", seeds(16, at_once=4))
def test_verdict_agrees_with_many_points(seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    plan = random_plan(rng, robots=int(rng.integers(2, 4)), obstacles=int(rng.integers(0, 4)))
    ground = plan.mission.area.difference(shapely.union_all([o.shape for o in plan.mission.obstacles]))
    held = Trajectory(robot="r0", times_s=[0.0], positions_m=[rng.uniform(2, 8, 2)])
    wide = tuple(
        dataclasses.replace(r, sensor=DiscSensor(radius_m=rng.uniform(6, 12))) for r in plan.mission.fleet.robots
    )
    mission = dataclasses.replace(plan.mission, fleet=dataclasses.replace(plan.mission.fleet, robots=wide))
    trajectories = (held, *plan.trajectories[1:]) if seed % 2 else plan.trajectories
    plan = dataclasses.replace(plan, mission=mission, trajectories=trajectories)
    plan = all_accelerated(plan, rng) if seed % 4 > 1 else plan
    points = rng.uniform(0, 10, (40_000, 2))
    points = points[shapely.contains_xy(ground, *points.T)]
    gaps = worst_gaps_s(plan, points)
    worst = float(gaps.max()) if np.isfinite(gaps).all() else float(np.quantile(gaps[np.isfinite(gaps)], 0.9))
    for period, ok in ((worst * 1.05 + 0.1, np.isfinite(gaps).all()), (worst * 0.9, False)):
        if period <= 0:
            continue
        report = check_plan(
            dataclasses.replace(plan, mission=dataclasses.replace(mission, period_s=period)), finest_m=0.02
        )
        (d,) = report.demands
        assert d.area_m2 == pytest.approx(ground.area)
        if d.outcome == "met":
            assert gaps.max() <= period
            assert gaps.max() <= d.worst_gap_s + 1e-9
        if (gaps > period * 1.001).any():
            assert d.outcome == "violated"
            place = next(v.place_m for v in report.violations if v.kind == "gap")
            assert worst_gaps_s(plan, np.array([place]))[0] > period
            shown = report.shown_unmet_m[:: 1 + len(report.shown_unmet_m) // 300]
            assert len(shown)
            assert (worst_gaps_s(plan, shown) > period).all()
            # every point that was found bad by itself lies on a piece that was not shown met: near an unmet point
            bad = points[gaps > period * 1.001][:300]
            away = np.hypot(*(bad[:, None] - report.unmet_points_m[None]).transpose(2, 0, 1)).min(axis=1)
            assert away.max() < 1.6
        if ok:
            assert d.outcome == "met" or d.undecided_cells < 50


@pytest.mark.parametrize("seed", range(4))
def test_robots_that_share_ways_are_judged_as_if_no_leg_were_shared(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(200 + seed)
    plan = random_plan(rng, robots=2, obstacles=3)
    loops = [dataclasses.replace(each, robot=f"{each.robot}-{k}") for each in plan for k in range(3)]
    robots = [dataclasses.replace(plan.mission.fleet.robot(each.robot[:-2]), name=each.robot) for each in loops]
    fleet = dataclasses.replace(plan.mission.fleet, robots=tuple(robots))
    crowd = Plan(mission=dataclasses.replace(plan.mission, fleet=fleet), trajectories=tuple(loops))
    shared = check_plan(crowd)
    monkeypatch.setattr(revisits, "_ways_of", lambda legs, robots, sensors: (np.arange(len(legs)),) * 2)
    alone = check_plan(crowd)
    assert shared.demands == alone.demands
    assert shared.violations == alone.violations
    assert np.array_equal(shared.unmet_points_m, alone.unmet_points_m)
