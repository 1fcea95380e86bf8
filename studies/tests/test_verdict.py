"""The rules of verdicts, against p-values worked by hand and scipy's binomial test."""

from __future__ import annotations

import pytest
from scipy.stats import binomtest

from rota_studies.verdict import LEAST_SEEDS, RULE, always, compared, mostly, sign_test, spread


@pytest.mark.parametrize(("wins", "losses"), [(8, 0), (5, 3), (9, 1), (0, 7), (4, 4), (27, 3)])
def test_the_sign_test_is_scipys(wins: int, losses: int) -> None:
    assert sign_test(wins, losses) == pytest.approx(binomtest(wins, wins + losses).pvalue)


def test_the_sign_test_by_hand() -> None:
    assert sign_test(8, 0) == 2 / 2**8
    assert sign_test(0, 0) == 1


def test_sensors_saved_by_the_letter_cannot_be_told() -> None:
    # the numbers of the letter of Algorithm 1 with seeds 0 to 7, with the rules and without
    with_rules, without = (104, 107, 106, 108, 109, 107, 101, 107), (110, 105, 109, 111, 105, 106, 107, 108)
    found = compared([b - a for a, b in zip(with_rules, without, strict=True)])
    assert found.outcome == "cannot be told"
    assert found.told == "+1.5 ± 1.3 (mean gain ± standard error), so in 5 of 8 seeds, p = 0.73"


def test_the_better_way_holds_and_the_worse_one_does_not() -> None:
    assert compared([1] * LEAST_SEEDS).outcome == "holds"
    assert compared([-1] * LEAST_SEEDS).outcome == "does not hold"
    assert compared([-1] * LEAST_SEEDS, ours=True).outcome == "not reproduced"
    assert compared([1] * (LEAST_SEEDS - 1)).outcome == "cannot be told"  # p = 0.016, of too few seeds
    assert compared([1] * 7 + [-1]).outcome == "cannot be told"  # p = 0.07
    assert compared([1] * 7 + [0]).outcome == "holds"  # a tie is left out
    assert compared([]).outcome == "cannot be told"


def test_mostly_is_the_same_test_on_what_runs_do() -> None:
    assert mostly([True] * 9 + [False]).outcome == "holds"
    assert mostly([True] * 9 + [False]).told == "9 of 10 runs, p = 0.021"
    assert mostly([True] * 8 + [False] * 2).outcome == "cannot be told"
    assert mostly([False] * 10).outcome == "does not hold"
    assert mostly([False] * 10, ours=True).outcome == "not reproduced"


def test_always_is_refuted_by_one() -> None:
    assert always([True] * LEAST_SEEDS).outcome == "holds"
    assert always([True] * (LEAST_SEEDS - 1)).outcome == "cannot be told"
    assert always([True] * 30 + [False]).outcome == "does not hold"
    assert always([False], ours=True).outcome == "not reproduced"


def test_the_rule_tells_the_numbers_that_are_used() -> None:
    assert f"fewer than {LEAST_SEEDS} seeds" in RULE
    assert "p ≤ 0.05" in RULE
    assert "**not reproduced**" in RULE


def test_a_spread_is_mean_deviation_and_range() -> None:
    assert spread([1, 2, 3], ".1f") == "2.0 ± 1.0 (1.0 to 3.0)"
    assert (spread([4]), spread([])) == ("4", "–")
