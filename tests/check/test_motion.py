"""Motion spoiled on purpose: just under and just over each tolerance, found at the right place and time."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shapely import MultiPolygon, Polygon, box

from rota.check.motion import motion_violations, row_ahead, segment_distances
from rota.check.report import Violation
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle
from rota.model.plan import Plan, Trajectory

BLOCK = box(4, 4, 6, 6)


def violations(
    xy: object,
    *,
    speed: float = 1.0,
    times: object = None,
    body: float = 0.0,
    turn: float | None = None,
    loop_start: float | None = None,
    headings: object = None,
    area: Polygon | None = None,
    blocks: str = "both",
) -> list[Violation]:
    """What is wrong with one robot in a 10 m square with a block in its middle."""
    points = np.array(xy, dtype=float)
    length = np.hypot(*np.diff(points, axis=0).T)
    t = np.concatenate([[0], np.cumsum(np.maximum(length, 1e-3))]) if times is None else np.array(times, dtype=float)
    closed = len(points) > 1 and (points[0] == points[-1]).all()
    start = loop_start if loop_start is not None else 0.0 if closed else float(t[-1])
    mission = Mission(
        name="m",
        area=MultiPolygon([area or box(0, 0, 10, 10)]),
        obstacles=(Obstacle(shape=BLOCK, blocks=blocks),),
        fleet=Fleet(speed_m_s=speed, sensor=DiscSensor(radius_m=1.0), body_radius_m=body, turn_rate_rad_s=turn),
        period_s=1.0,
    )
    trajectory = Trajectory(robot="a", times_s=t, positions_m=points, loop_start_s=start, headings_rad=headings)
    return motion_violations(Plan(mission=mission, trajectories=(trajectory,)))


def test_legs_along_borders_and_through_corners_are_fine_without_a_body() -> None:
    assert violations([(0, 0), (10, 0), (10, 10), (0, 10), (0, 0)]) == []
    assert violations([(0, 4), (10, 4), (10, 6), (0, 6), (0, 4)]) == []
    assert violations([(3, 5), (5, 3), (7, 5), (5, 7), (3, 5)]) == []
    assert violations([(4, 4), (4, 6), (6, 6), (6, 4), (4, 4)]) == []


@pytest.mark.parametrize("body", [0.0, 0.3])
@pytest.mark.parametrize(("deep", "wrong"), [(0.9e-6, False), (1.1e-6, True), (0.05, True)])
def test_depth_into_an_obstacle_and_out_of_the_area(body: float, deep: float, wrong: bool) -> None:
    y = 4 - body + deep
    found = violations([(1, 3), (3, y), (7, y), (8, 3)], body=body, speed=10)
    assert [v.kind for v in found] == (["obstacle"] if wrong else [])
    y = body - deep
    found += violations([(1, 3), (1, y), (9, y), (9, 3)], body=body, speed=10)
    kinds = {v.kind for v in found}
    assert kinds == ({"obstacle", "outside area"} if wrong else set())
    for v in found:
        assert v.value == pytest.approx(deep, abs=1e-9)
        assert v.limit == 1e-6
        assert v.who == "a"


def test_obstacles_that_block_only_sight_are_driven_through() -> None:
    assert violations([(1, 5), (9, 5)], blocks="sight") == []
    (found,) = violations([(1, 5), (9, 5)], blocks="motion")
    assert found.kind == "obstacle"


def test_leg_through_a_block_is_found_at_its_deepest_with_the_time() -> None:
    (found,) = violations([(0, 4.5), (10, 4.5)], times=[0, 20])
    assert found.value == pytest.approx(0.5)
    assert found.place_m is not None
    assert 4.5 <= found.place_m[0] <= 5.5
    assert found.time_s == pytest.approx(2 * found.place_m[0])
    (found,) = violations([(0.2, 4.5), (9.8, 4.5)], times=[0, 20], body=0.2)
    assert found.value == pytest.approx(0.7)


def test_corner_cut_by_a_diagonal() -> None:
    offset = 2.4e-6  # inside, the leg is nowhere farther than half of it from both sides
    (found,) = violations([(3 + offset, 5), (5 + offset, 3)])
    assert found.place_m == pytest.approx((4, 4), abs=1e-4)
    assert found.value == pytest.approx(1.2e-6, rel=1e-3)
    assert violations([(3 + 1.8e-6, 5), (5 + 1.8e-6, 3)]) == []


def test_standing_inside_a_block_or_outside_of_everything() -> None:
    (found,) = violations([(5, 5)])
    assert (found.kind, found.value, found.time_s) == ("obstacle", pytest.approx(1.0), 0.0)
    (found,) = violations([(13, 5)], body=0.5)
    assert (found.kind, found.value) == ("outside area", pytest.approx(3.5))
    assert violations([(0.5, 0.5)], body=0.5) == []


def test_reflex_corner_of_the_area_is_kept_at_the_body_radius() -> None:
    ell = box(0, 0, 10, 10).difference(box(5, 5, 10, 10)).difference(BLOCK)
    # past the reflex corner (4, 4) of this area at distance 1
    x = 4 - 1 / math.sqrt(2)
    assert violations([(x, x)], body=1.0, area=ell) == []
    (one, two) = violations([(x + 1e-5, x + 1e-5)], body=1.0, area=ell)
    assert {one.kind, two.kind} == {"obstacle", "outside area"}
    assert one.value == pytest.approx(1e-5 * math.sqrt(2), rel=1e-3)


@pytest.mark.parametrize(("factor", "wrong"), [(1 + 0.9e-9, False), (1 + 1e-7, True), (1.5, True)])
def test_speed(factor: float, wrong: bool) -> None:
    found = violations([(1, 1), (3, 1), (3, 1 + 2 * factor)], times=[0, 2, 4])
    assert [v.kind for v in found] == (["speed"] if wrong else [])
    if wrong:
        assert found[0].place_m == (3.0, 1.0)
        assert found[0].time_s == 2.0
        assert found[0].value == pytest.approx(factor)


@pytest.mark.parametrize(("speed", "wrong"), [(9.9, False), (28.0, True)])
def test_what_single_legs_may_be_too_fast_does_not_add_up(speed: float, wrong: bool) -> None:
    # float64 holds times near 9e9 s to 1.9e-6 s, so that a leg of 0.9e-6 s may seem to take no time
    began_s, tick_s = 9e9, float(np.spacing(9e9))
    times = began_s + tick_s * np.arange(401)
    x = 1 + speed * tick_s * np.minimum(np.arange(401), 400 - np.arange(401))
    found = violations([(1, 1), *((at, 1.0) for at in x)], times=[0, *times], speed=10.0, loop_start=float(times[-1]))
    assert [v.kind for v in found] == (["speed"] if wrong else [])
    if wrong:
        assert found[0].value == pytest.approx(speed, rel=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_rows_ahead_of_the_speed_are_those_of_brute_force(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(200):
        ahead_m, allowed_m = rng.normal(-0.3, 1, 12), rng.uniform(1, 4, 12)
        ahead_m[rng.random(12) < 0.1] = -1e12  # a long wait
        ends = [m for m in range(12) if any(ahead_m[k : m + 1].sum() > allowed_m[m] for k in range(m + 1))]
        (row,) = row_ahead(ahead_m, allowed_m) or [None]
        assert (row is None) == (not ends)
        if row is not None:
            assert row[1] == ends[0] + 1
            assert ahead_m[row[0] : row[1]].sum() > allowed_m[ends[0]]


QUARTER = math.pi / 2


@pytest.mark.parametrize(("pause", "wrong"), [(QUARTER * (1 - 1e-10), False), (QUARTER - 1e-6, True), (0.1, True)])
def test_turn_at_a_corner(pause: float, wrong: bool) -> None:
    found = violations([(1, 1), (3, 1), (3, 1), (3, 3)], times=[0, 2, 2 + pause, 4 + pause], turn=1.0)
    assert [v.kind for v in found] == (["turn"] if wrong else [])
    if wrong:
        assert found[0].place_m == (3.0, 1.0)
        assert (found[0].time_s, found[0].unit) == (2.0, "s")
        assert found[0].value == pytest.approx(pause)
        assert found[0].limit == pytest.approx(QUARTER)


def test_straight_on_needs_no_pause_and_a_corner_without_one_is_found() -> None:
    assert violations([(1, 1), (2, 1), (2.5, 1), (3, 1)], turn=0.1) == []
    (found,) = violations([(1, 1), (2, 1), (3, 2)], turn=0.1)
    assert found.limit == pytest.approx(math.pi / 4 / 0.1)
    assert violations([(1, 1), (2, 1), (3, 2)]) == []


@pytest.mark.parametrize("enough", [True, False])
def test_turn_at_the_seam_joins_the_pauses_at_both_ends_of_the_loop(enough: bool) -> None:
    q = QUARTER
    seam = 0.5 * q if enough else 0.4 * q
    xy = [(1, 1), (1, 1), (3, 1), (3, 1), (3, 3), (3, 3), (1, 3), (1, 3), (1, 1), (1, 1)]
    times = np.cumsum([0, 0.5 * q, 2, q, 2, q, 2, q, 2, seam])
    found = violations(xy, times=times, turn=1.0)
    assert [v.kind for v in found] == ([] if enough else ["turn"])
    if not enough:
        assert found[0].place_m == (1.0, 1.0)
        assert found[0].value == pytest.approx(0.9 * q)


@pytest.mark.parametrize(("far_m", "step_m", "by"), [(100.0, 2e-9, 8e-5), (5e6, 1e-4, 6e-5)])
@pytest.mark.parametrize(("waits", "kinds"), [(0.99, ["turn"]), (1.0, [])])
def test_turns_that_rounding_hides_add_up(
    far_m: float, step_m: float, by: float, waits: float, kinds: list[str]
) -> None:
    """A quarter turn within 0.1 mm by steps that turn by less than rounding might, or in 3 m at UTM's northings."""
    angles = np.arange(0, QUARTER, by)
    spot = np.cumsum(step_m * np.column_stack([np.cos(angles), np.sin(angles)]), axis=0)
    corners = far_m + np.vstack([[-2.0, 0.0], [0.0, 0.0], spot, spot[-1] + [0, 2.0]])
    lasts_s = np.column_stack([np.hypot(*np.diff(corners, axis=0).T) + 1e-7, np.full(len(corners) - 1, waits * by)])
    times = np.append(0.0, np.cumsum(lasts_s.ravel()))[:-1]
    here = box(far_m - 9, far_m - 9, far_m + 9, far_m + 9)
    found = violations(np.repeat(corners, 2, axis=0)[1:-1], times=times, turn=1.0, area=here)
    assert [v.kind for v in found] == kinds


def test_back_and_forth_needs_half_a_turn_at_both_ends() -> None:
    xy, times = [(1, 1), (3, 1), (3, 1), (1, 1), (1, 1)], np.cumsum([0, 2, math.pi, 2, math.pi])
    assert violations(xy, times=times, turn=1.0) == []
    assert len(violations(xy, times=np.cumsum([0, 2, 3.1, 2, 3.1]), turn=1.0)) == 2


def test_headings_turn_no_faster_than_the_rate() -> None:
    xy, times = [(1, 1), (2, 1), (3, 1)], [0, 1, 2]
    assert violations(xy, times=times, turn=0.5, headings=[0, 0.5, 0.2]) == []
    (found,) = violations(xy, times=times, turn=0.5, headings=[0, 0.5, 0.5 + 2 * math.pi + 0.6])
    assert (found.kind, found.unit, found.time_s) == ("turn", "rad/s", 1.0)
    assert found.value == pytest.approx(0.6)


def test_segment_distances_match_shapely() -> None:
    import shapely

    rng = np.random.default_rng(3)
    a, b = rng.uniform(0, 1, (500, 4)), rng.uniform(0, 1, (500, 4))
    a[:50, 2:] = a[:50, :2]
    b[25:75, 2:] = b[25:75, :2]
    distance, along = segment_distances(a, b)
    lines = [shapely.linestrings(s.reshape(-1, 2, 2)) for s in (a, b)]
    np.testing.assert_allclose(distance, shapely.distance(*lines), atol=1e-12)
    nearest = a[:, :2] + along[:, None] * (a[:, 2:] - a[:, :2])
    np.testing.assert_allclose(shapely.distance(shapely.points(nearest), lines[1]), distance, atol=1e-12)
