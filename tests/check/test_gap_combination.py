"""Sights of several robots joined: pairs by gcd and classes against the explicit hyperperiod."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from rota.check import gap_kernels
from rota.check.arrays import Loops, SeenTimes
from rota.check.routes import commensurable_classes

Floats = NDArray[np.float64]


def random_sights(rng: np.random.Generator, period: int) -> Floats:
    """Disjoint ascending sights (n, 2) within one turn."""
    n = int(rng.integers(1, 4))
    return np.sort(rng.uniform(0, period, 2 * n)).reshape(n, 2)


def explicit_gap(sights: list[Floats], periods: list[int]) -> float:
    """Worst gap by writing out the hyperperiod and a turn before and after it."""
    common = math.lcm(*periods)
    every = []
    for own, period in zip(sights, periods, strict=True):
        for turn, (start, end) in itertools.product(range(-1, 2 * common // period + 1), own):
            every.append((start + turn * period, end + turn * period))
    worst, covered = 0.0, -math.inf
    for start, end in sorted(every):
        if 0 <= start <= common:
            worst = max(worst, start - covered)
        covered = max(covered, end)
    return worst


def team_gap(sights: list[Floats], periods: list[float], limit_s: float = 0.0) -> tuple[float, float, bool]:
    classes, parts, units = commensurable_classes(periods)
    flat = np.vstack(sights)
    bounds = np.concatenate([[0], np.cumsum([len(s) for s in sights])]).astype(np.int64)
    robots = np.arange(len(sights), dtype=np.int64)
    times = SeenTimes(np.ascontiguousarray(flat[:, 0]), np.ascontiguousarray(flat[:, 1]), bounds, robots)
    gap, when, exact = gap_kernels.team_gap(times, len(sights), Loops(classes, parts, units, 0.0), limit_s)
    return float(gap), float(when), bool(exact)


@pytest.mark.parametrize("seed", range(30))
def test_teams_match_the_explicit_hyperperiod(seed: int) -> None:
    rng = np.random.default_rng(seed)
    periods = [int(p) for p in rng.choice([6, 8, 9, 10, 12, 15], int(rng.integers(1, 4)))]
    sights = [random_sights(rng, p) for p in periods]
    gap, when, exact = team_gap(sights, [float(p) for p in periods])
    assert exact
    assert gap == pytest.approx(explicit_gap(sights, periods), abs=1e-9)
    for own, period in zip(sights, periods, strict=True):
        # nobody sees inside of the gap that was named
        middle = (when + gap / 2) % period
        assert not ((own[:, 0] < middle) & (middle < own[:, 1])).any()


@pytest.mark.parametrize("seed", range(30))
def test_pairs_by_gcd_match_the_explicit_hyperperiod(seed: int) -> None:
    rng = np.random.default_rng(seed)
    periods = [int(p) for p in rng.choice([6, 8, 9, 10, 12, 15], 2)]
    sights = [random_sights(rng, p) for p in periods]
    flat = np.vstack(sights)
    n = len(sights[0])
    bounds = np.array([0, n, len(flat)])
    times = SeenTimes(np.ascontiguousarray(flat[:, 0]), np.ascontiguousarray(flat[:, 1]), bounds, np.arange(2))
    gap = gap_kernels.pair_gap(times, 0, 1, float(periods[0]), float(periods[1]), float(math.gcd(*periods)))
    assert gap == pytest.approx(explicit_gap(sights, periods), abs=1e-9)


def test_long_common_period_falls_back_to_a_bound_no_better_than_the_truth() -> None:
    rng = np.random.default_rng(5)
    periods = [61 * 59, 60 * 61, 60 * 59]  # ratios 59/60, 60/61, ...: the common period is 60 * 61 * 59 units
    sights = [np.array([[10.0 * k, 10.0 * k + 3000]]) for k in range(3)]
    truth, _, exact = team_gap(sights, [float(p) for p in periods])
    assert exact
    assert truth == pytest.approx(explicit_gap(sights, periods), abs=1e-6)
    many = [np.stack([k := np.sort(rng.uniform(0, p, 700)), k + 1e-3], axis=1) for p in periods]
    bound, _, exact = team_gap(many, [float(p) for p in periods])
    assert not exact
    assert bound >= explicit_gap(many, periods) - 1e-6
    assert bound <= min(team_gap([own], [float(p)])[0] for own, p in zip(many, periods, strict=True))


def test_independent_loops_are_as_bad_as_the_better_of_them() -> None:
    sights = [np.array([[0.0, 4.0]]), np.array([[0.0, 1.0], [5.0, 6.0]])]
    gap, when, exact = team_gap(sights, [10.0, math.pi * 3])
    assert exact
    assert gap == pytest.approx(4.0)
    assert math.isnan(when)
