"""The turn radius: polygons round circles in closed form, corners, straight rows of legs, and seams."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, box
from tests.seeds import seeds

from rota.check.motion import motion_violations
from rota.check.report import Violation
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Fleet, Mission
from rota.model.plan import Charge, Plan, Trajectory

Floats = NDArray[np.float64]
RADIUS_M = 5.0


def violations(xy: object, *, loop_from: int = 0, radius_m: float = RADIUS_M) -> list[Violation]:
    """What is wrong with a robot that drives these points at 1 m/s, and loops from one of them on."""
    points = np.array(xy, dtype=np.float64)
    times = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    fleet = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=1), turn_radius_m=radius_m)
    mission = Mission(name="m", area=MultiPolygon([box(-100, -100, 100, 100)]), fleet=fleet, period_s=1)
    trajectory = Trajectory(robot="a", times_s=times, positions_m=points, loop_start_s=float(times[loop_from]))
    return motion_violations(Plan(mission=mission, trajectories=(trajectory,)))


def circle(corners: int, *, touching: float) -> Floats:
    """A closed polygon whose sides touch a circle of this radius; with its first corner again at the end."""
    angles = np.arange(corners + 1) * (2 * math.pi / corners)
    ring = touching / math.cos(math.pi / corners) * np.column_stack([np.cos(angles), np.sin(angles)])
    ring[-1] = ring[0]
    return ring


@pytest.mark.parametrize("corners", [32, 45, 200])
def test_polygons_round_a_circle_leave_room_for_just_that_circle(corners: int) -> None:
    assert violations(circle(corners, touching=RADIUS_M)) == []
    found = violations(circle(corners, touching=0.99 * RADIUS_M))
    assert {v.kind for v in found} == {"turn radius"}
    assert len(found) == 20
    assert found[0].value == pytest.approx(0.99 * RADIUS_M)
    assert (found[0].limit, found[0].unit, found[0].who) == (RADIUS_M, "m", "a")


def test_corners_that_leave_the_arc_too_far_are_too_sharp_however_wide() -> None:
    assert {v.value for v in violations(circle(31, touching=50))} == {0.0}
    assert violations(circle(31, touching=50), radius_m=0) == []


def test_a_leg_may_be_cut_into_pieces_and_a_round_begin_anywhere() -> None:
    ring = circle(32, touching=RADIUS_M)
    cut = np.vstack([ring[:1], (3 * ring[0] + ring[1]) / 4, (ring[0] + ring[1]) / 2, ring[1:]])
    assert violations(cut) == []
    assert violations(np.vstack([cut[2:-1], cut[:3]])) == []  # begun in the middle of a leg
    tight = circle(32, touching=0.9 * RADIUS_M)
    begun = np.vstack([(tight[0] + tight[1]) / 2, tight[1:], (tight[0] + tight[1]) / 2])
    assert {round(v.value, 9) for v in violations(begun)} == {4.5}


def test_the_seam_of_a_loop_is_a_corner() -> None:
    drop = np.vstack([[20.0, 0.0], circle(32, touching=RADIUS_M)[4:-4], [20.0, 0.0]])
    found = violations(drop)
    assert (20.0, 0.0) in {v.place_m for v in found}


def test_an_approach_must_run_into_its_loop() -> None:
    ring = circle(32, touching=RADIUS_M)
    along = ring[0] - (ring[1] - ring[0]) * 10
    assert violations(np.vstack([along, ring]), loop_from=1) == []
    found = violations(np.vstack([[30.0, 0.0], ring]), loop_from=1)
    assert found[0].place_m == pytest.approx((ring[0, 0], 0))
    assert found[0].value == 0


def test_many_turns_below_rounding_add_up() -> None:
    # a turn on the spot in 100,000 legs too short to tell their directions exactly
    angles = np.linspace(0, math.pi / 2, 100_000)
    spot = np.cumsum(1e-8 * np.column_stack([np.cos(angles), np.sin(angles)]), axis=0)
    found = violations(np.vstack([[-50.0, 0.0], [0.0, 0.0], spot, spot[-1] + [0, 50.0]]), loop_from=len(spot) + 2)
    assert {v.kind for v in found} == {"turn radius"}


def test_turns_below_rounding_add_up_past_corners_that_are_none() -> None:
    """1.2 nm steps whose turns rounding hides, between longer ones that bend by next to nothing: 29 degrees in 1 cm."""
    steps_m = np.tile([1.2e-9] * 12 + [5e-6, 5e-6], 1_000)
    turns = np.tile([5e-4 / 12] * 12 + [0.0, 1e-7], 1_000)
    curve = np.cumsum(steps_m[:, None] * np.column_stack([np.cos(turns.cumsum()), np.sin(turns.cumsum())]), axis=0)
    end = curve[-1] + 9 * np.array([math.cos(turns.sum()), math.sin(turns.sum())])
    xy = 90 + np.vstack([[-10.0, 0.0], [0.0, 0.0], curve, end])
    assert {one.kind for one in violations(xy, loop_from=len(xy) - 1)} == {"turn radius"}


@pytest.mark.parametrize("seed", seeds(20, at_once=5))
def test_places_beside_a_line_take_no_room_from_corners(seed: int) -> None:
    """Legs hardly longer than they must be, with places within 1e-6 m beside them: arcs that touch them follow all."""
    rng = np.random.default_rng(seed)
    turns = rng.uniform(-0.19, 0.19, 12)
    half_m = np.concatenate([[1.0], RADIUS_M * np.tan(np.abs(turns) / 2), [1.0]])
    angle = np.concatenate([[0.0], turns.cumsum()])
    along = np.column_stack([np.cos(angle), np.sin(angle)])
    lengths_m = (half_m[:-1] + half_m[1:]) * (1 + 1e-3)
    corners = np.vstack([[0.0, 0.0], np.cumsum(lengths_m[:, None] * along, axis=0)])
    rows = [corners[:1]]
    for k, length_m in enumerate(lengths_m):
        shares = np.sort(rng.uniform(0, 1, rng.integers(0, 4)))[:, None]
        aside = rng.uniform(-1e-7, 1e-7, (len(shares), 1)) * np.array([-along[k, 1], along[k, 0]])
        rows += [corners[k] + shares * length_m * along[k] + aside, corners[k + 1 : k + 2]]
    told = np.vstack(rows)
    assert violations(told, loop_from=len(told) - 1) == []
    # the curve itself, in steps: how it bends, and how far it is from the legs that are told
    driven = sampled(corners, turns, along)
    steps = np.diff(driven, axis=0)
    bends = np.abs(np.diff(np.unwrap(np.arctan2(*steps.T[::-1]))))
    apart_m = np.hypot(*steps.T)
    assert (bends <= 1.001 * (apart_m[1:] + apart_m[:-1]) / 2 / RADIUS_M + 1e-6).all()
    assert shapely.distance(shapely.LineString(told), shapely.points(driven)).max() <= RADIUS_M / 200 + 1e-6


def sampled(corners: Floats, turns: Floats, along: Floats) -> Floats:
    """Places on the curve of lines and arcs that touch the legs at these corners."""
    places = [corners[:1]]
    for corner, turn, before in zip(corners[1:-1], turns, along, strict=False):
        begin = corner - RADIUS_M * math.tan(abs(turn) / 2) * before
        swept = np.linspace(0, turn, 40)[:, None]
        side = np.array([-before[1], before[0]])
        places.append(begin + RADIUS_M * (np.sin(np.abs(swept)) * before + (1 - np.cos(swept)) * np.sign(turn) * side))
    return np.vstack([*places, corners[-1:]])


@pytest.mark.parametrize(("at_m", "tight"), [(0.3, False), (0.3, True)])
def test_a_bend_that_is_hardly_any_takes_no_room_before_a_turn(at_m: float, tight: bool) -> None:
    """A turn of 0.19 rad takes 0.48 m of the leg before; 2e-7 rad 0.3 m before it are 6e-8 m off, 0.02 rad 6 mm."""
    bend = 0.02 if tight else 2e-7
    xy = [[-50.0, 0.0], [-at_m, 0.0], [0.0, at_m * bend], [50 * math.cos(0.19), 50 * math.sin(0.19)]]
    assert {one.kind for one in violations(xy, loop_from=3)} == ({"turn radius"} if tight else set())


def test_robots_that_stay_or_never_turn_are_fine() -> None:
    assert violations([[0, 0]]) == []
    assert violations([[0, 0], [10, 0], [20, 0]], loop_from=2) == []


@pytest.mark.parametrize(("charged_at", "places_m"), [((0, 1), []), ((0,), [(0.0, 0.0)]), ((1,), [(20.0, 0.0)])])
@pytest.mark.parametrize("stays_s", [10.0, 1.0])
def test_on_a_charger_a_robot_is_turned(
    charged_at: tuple[int, ...], places_m: list[tuple[float, float]], stays_s: float
) -> None:
    """To and fro, with a stay at either end: where that is on a charger, the seam included, it goes back as it came."""
    assert turned(charged_at, stays_s) == [("turn radius", place_m) for place_m in places_m]


@pytest.mark.parametrize("stays_s", [1e-9, 1e-3, 0.9])
def test_who_only_touches_a_charger_is_not_turned(stays_s: float) -> None:
    """Half a turn takes 7.9 s as it drives; a small robot's, of 4 cm, 0.06 s."""
    assert turned((0, 1), stays_s) == [("turn radius", (0.0, 0.0)), ("turn radius", (20.0, 0.0))]
    assert len(turned((0, 1), stays_s, radius_m=0.04)) == (0 if stays_s > 0.06 else 2)


def turned(charged_at: tuple[int, ...], stays_s: float, *, radius_m: float = RADIUS_M) -> list[tuple[str, object]]:
    """What is wrong with a robot that goes to and fro between two chargers, and charges where it is told to."""
    mission = Mission(
        name="m", area=MultiPolygon([box(-100, -100, 100, 100)]), period_s=1,
        fleet=Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=1), turn_radius_m=radius_m,
                    battery=BatteryLimits(endurance_s=500, recharge_s=1)),
        chargers=(Charger(name="b", at=(20, 0), places=1), Charger(name="a", at=(0, 0), places=1)),
    )  # fmt: skip
    times_s = np.array([0.0, 20, 20 + stays_s, 40 + stays_s, 40 + 2 * stays_s])
    stays = tuple(Charge(charger=name, from_s=times_s[k], until_s=times_s[k + 1]) for name, k in (("b", 1), ("a", 3)))
    trajectory = Trajectory(
        robot="a", times_s=times_s, positions_m=np.array([[0.0, 0], [20, 0], [20, 0], [0, 0], [0, 0]]),
        charges=tuple(stays[k] for k in charged_at),
    )  # fmt: skip
    found = motion_violations(Plan(mission=mission, trajectories=(trajectory,)))
    return sorted((one.kind, one.place_m) for one in found)


@pytest.mark.parametrize("far_m", [100.0, 5e6, 9e6])
def test_a_step_that_rounding_made_hides_no_turn_however_far_away(far_m: float) -> None:
    """A corner of 90 degrees with a step of two last places in it, as at the northings of UTM."""
    mission = Mission(
        name="m", area=MultiPolygon([box(far_m - 99, far_m - 99, far_m + 99, far_m + 99)]), period_s=1,
        fleet=Fleet(speed_m_s=9, sensor=DiscSensor(radius_m=1), turn_rate_rad_s=1.0),
    )  # fmt: skip
    step_m = 2 * np.spacing(far_m)
    xy = np.array([[-50.0, 0.0], [0.0, 0.0], [step_m, step_m], [step_m, 50.0]]) + far_m
    for pause_s, kinds in ((1e-3, {"turn"}), (1.6, set())):
        times_s = np.array([0.0, 10.0, 10.0 + pause_s, 20.0])
        way = Trajectory(robot="a", times_s=times_s, positions_m=xy, loop_start_s=20.0)
        assert {one.kind for one in motion_violations(Plan(mission=mission, trajectories=(way,)))} == kinds
