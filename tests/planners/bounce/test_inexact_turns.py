"""Discs that turn inexactly: beside a simulation of another kind, by equal small steps of time, and by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from shapely import MultiPolygon, box

from rota.errors import MissionError
from rota.planners.bounce.cells import Cells, cells_of
from rota.planners.bounce.inexact_turns import (
    Crew,
    TurningError,
    estimate,
    make_crew,
    run_crew,
)
from rota_studies.alam2020.inexact import starts_anywhere

Floats = NDArray[np.float64]

WIDE, HIGH, BODY_M, SPEED_M_S, TURN_S = 4.0, 3.0, 0.2, 0.5, 1.0
BLOCK = (1.5, 1.0, 2.5, 2.0)
ROOM = MultiPolygon([box(0, 0, WIDE, HIGH).difference(box(*BLOCK))])
STEP_S = 0.008


def room_cells() -> Cells:
    return cells_of(ROOM, (0, 0, WIDE, HIGH), cell_m=0.5, body_radius_m=BODY_M)


def crew_of(robots: int, angle_deg: float) -> Crew:
    return make_crew(ROOM, [BODY_M] * robots, [math.radians(angle_deg)] * robots, speed_m_s=SPEED_M_S, turn_s=TURN_S)


def clear(places: Floats) -> NDArray[np.bool_]:
    """Whether a body fits at each place (..., 2): away from four walls, and from a box by its nearest point."""
    x, y = places[..., 0], places[..., 1]
    walls = (x >= BODY_M) & (x <= WIDE - BODY_M) & (y >= BODY_M) & (y <= HIGH - BODY_M)
    near_x, near_y = np.clip(x, BLOCK[0], BLOCK[2]), np.clip(y, BLOCK[1], BLOCK[3])
    return walls & ((x - near_x) ** 2 + (y - near_y) ** 2 >= BODY_M**2)


def stepped(starts: Floats, angle: float, error: float, duration_s: float, seed: int) -> list[set[tuple[int, int]]]:
    """The half-metre squares that teams enter, moved by small equal steps: one that is in the way is a turn instead."""
    rng = np.random.default_rng(seed)
    places, headings = starts[..., :2].copy(), starts[..., 2].copy()
    runs, m = headings.shape
    busy_s = np.zeros((runs, m))
    entered = np.zeros((runs, round(WIDE / 0.5), round(HIGH / 0.5)), np.bool_)
    number = np.arange(runs)
    for _ in range(round(duration_s / STEP_S)):
        ways = SPEED_M_S * STEP_S * np.stack([np.cos(headings), np.sin(headings)], axis=-1)
        moving = busy_s <= 1e-9
        ahead = places + ways * moving[..., None]
        stopped = moving & ~clear(ahead)
        for i in range(m):
            for j in range(i):
                before = np.linalg.norm(places[:, i] - places[:, j], axis=1)
                after = np.linalg.norm(ahead[:, i] - ahead[:, j], axis=1)
                touch = (after < 2 * BODY_M) & (after < before)
                stopped[:, i] |= touch & moving[:, i]
                stopped[:, j] |= touch & moving[:, j]
        places = np.where((moving & ~stopped)[..., None], ahead, places)
        headings = np.where(stopped, headings + angle + rng.uniform(-error, error, (runs, m)), headings)
        busy_s = np.where(stopped, TURN_S, busy_s - STEP_S)
        for i in range(m):
            entered[number, (places[:, i, 0] / 0.5).astype(int), (places[:, i, 1] / 0.5).astype(int)] = True
    return [{(int(c), int(r)) for c, r in np.argwhere(one)} for one in entered]


@pytest.mark.slow  # thousands of runs in small steps of time
@pytest.mark.parametrize(
    ("robots", "angle_deg", "error_deg", "runs"), [(1, 135, 10, 2500), (1, 90, 5, 2500), (2, 135, 8, 4000)]
)
def test_as_much_is_seen_as_by_small_steps_of_time(robots: int, angle_deg: float, error_deg: float, runs: int) -> None:
    """Within a point of each other, in the mean over all cells, and within noise in each cell."""
    cells, crew, duration_s = room_cells(), crew_of(robots, angle_deg), 13.0
    starts = starts_anywhere(crew, cells, runs, seed=1)
    found = run_crew(crew, TurningError(angle_rad=math.radians(error_deg)), starts,
                     duration_s=duration_s, seed=2, cells=cells)  # fmt: skip
    squares = stepped(starts, math.radians(angle_deg), math.radians(error_deg), duration_s, 3)
    there = [(int(c), int(r)) for c, r in zip(cells.column, cells.row, strict=True)]
    shares = np.array([[cell in one for cell in there] for one in squares]).mean(axis=0)
    mean = found.mean_seen(duration_s)
    assert mean.error < 0.01
    assert mean.value == pytest.approx(shares.mean(), abs=0.01)
    assert np.abs(found.entered_shares(duration_s) - shares).max() < 5 * math.sqrt(0.5 / runs)


def test_without_errors_a_way_is_that_of_exact_bounces() -> None:
    """From (0.5, 0.5) eastwards by 90 degrees: round along the walls, at 0.2 m from them, entering outer cells only."""
    cells, crew = room_cells(), crew_of(1, 90)
    starts = np.array([[[0.75, 0.25, 0.0]]])
    found = run_crew(crew, TurningError(), starts, duration_s=60.0, seed=0, cells=cells)
    entered = found.entered_s[0]
    outer = (cells.column == 0) | (cells.column == 7) | (cells.row == 0) | (cells.row == 5)
    assert np.isfinite(entered[outer]).all()
    assert np.isinf(entered[~outer]).all()
    at = {(int(c), int(r)): float(t) for c, r, t in zip(cells.column, cells.row, entered, strict=True)}
    assert at[1, 0] == 0.0
    assert at[2, 0] == pytest.approx(0.5)  # 0.25 m at 0.5 m/s
    assert at[7, 1] == pytest.approx((3.8 - 0.75) / 0.5 + TURN_S + 0.25 / 0.5)
    assert found.cover_times_s()[0] == math.inf


def test_zones_are_watched_by_who_comes_back_in_time() -> None:
    """A round of 2 x (3.6 - 0.05 + 2.6 - 0.05) m and four turns, which visits one corner's zone once."""
    crew = crew_of(1, 90)
    starts = np.array([[[0.75, 0.2, 0.0]]])
    round_s = 2 * (3.6 + 2.6) / 0.5 + 4 * TURN_S
    zone = MultiPolygon([box(3.0, 0.0, 3.5, 0.5)])
    inside_s = 0.5 / 0.5
    for period_s, expected in ((round_s, 1.0), (10.0, (10.0 + inside_s) / round_s)):
        found = run_crew(crew, TurningError(), starts, duration_s=period_s + 50 * round_s, seed=0,
                         zones=[(zone, period_s), (MultiPolygon([box(1.6, 1.1, 1.7, 1.2)]), period_s)])  # fmt: skip
        watched, never = found.watched_shares()
        assert watched.value == pytest.approx(expected, abs=2e-3)
        assert never.value == 0.0


def test_two_who_meet_head_on_turn_round_both() -> None:
    """By half a turn in a corridor: they meet in the middle, go back to the walls, and meet again."""
    corridor = MultiPolygon([box(0, 0, 10, 1)])
    crew = make_crew(corridor, [0.3, 0.3], [math.pi, math.pi], speed_m_s=1.0, turn_s=0.5)
    cells = cells_of(corridor, (0, 0, 10, 1), cell_m=1.0, body_radius_m=0.3)
    starts = np.array([[[0.5, 0.5, 0.0], [9.5, 0.5, math.pi]]])
    found = run_crew(crew, TurningError(), starts, duration_s=100.0, seed=0, cells=cells)
    # centres come 0.6 m apart: each goes from 0.5 to 4.7 m, and the other from 9.5 to 5.3
    assert np.sort(found.entered_s[0])[-1] == pytest.approx(3.5)
    zone = MultiPolygon([box(0, 0, 0.45, 1)])
    visits = run_crew(crew, TurningError(), starts, duration_s=1000.0, seed=0, zones=[(zone, 1.0)])
    round_s = 2 * (4.7 - 0.3) + 2 * 0.5  # the wall holds the centre at 0.3 m
    inside_s = 2 * 0.15 + 0.5
    assert visits.watched[0, 0] == pytest.approx((inside_s + 1.0) / round_s, abs=0.01)


def test_the_same_seed_the_same_runs_in_whatever_parts() -> None:
    cells, crew = room_cells(), crew_of(2, 135)
    starts = starts_anywhere(crew, cells, 600, seed=4)
    error = TurningError(angle_rad=0.1, shape="gaussian")
    whole = run_crew(crew, error, starts, duration_s=20.0, seed=5, cells=cells)
    again = run_crew(crew, error, starts, duration_s=20.0, seed=5, cells=cells)
    other = run_crew(crew, error, starts, duration_s=20.0, seed=6, cells=cells)
    np.testing.assert_array_equal(whole.entered_s, again.entered_s)
    assert (whole.entered_s != other.entered_s).any()
    # what a run was by some time does not depend on how long it lasts
    longer = run_crew(crew, error, starts, duration_s=30.0, seed=5, cells=cells)
    np.testing.assert_array_equal(whole.entered_s <= 19.0, longer.entered_s <= 19.0)


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    rng = np.random.default_rng(0)
    hit = [abs((one := estimate(rng.binomial(1, 0.3, 400).astype(float))).value - 0.3) <= one.error for _ in range(400)]
    assert 0.92 < np.mean(hit) < 0.98
    assert estimate(np.array([1.0])).error == math.inf


def test_what_cannot_be_simulated_is_refused() -> None:
    with pytest.raises(MissionError, match="turn_s: 0 is not allowed"):
        make_crew(ROOM, [0.2], [1.0], speed_m_s=1.0, turn_s=0)
    with pytest.raises(MissionError, match="speed_m_s"):
        make_crew(ROOM, [0.2], [1.0], speed_m_s=math.inf, turn_s=1)
    with pytest.raises(MissionError, match="angle_rad: 4 is not allowed"):
        TurningError(angle_rad=4)
    with pytest.raises(MissionError, match="shape: 'round' is not allowed"):
        TurningError(shape="round")  # type: ignore[arg-type]
    with pytest.raises(MissionError, match="no room was found for 40 bodies"):
        starts_anywhere(crew_of(40, 90), room_cells(), 2, seed=0)
