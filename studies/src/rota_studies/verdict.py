"""Verdicts on a paper's claims: each a function of stored runs, by rules that every page states."""

from __future__ import annotations

from collections.abc import Sequence
from math import comb
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Outcome = Literal["holds", "bettered", "does not hold", "not reproduced", "cannot be told"]

Values = Sequence[float] | NDArray[Any]

LEAST_SEEDS = 8
LEVEL = 0.05

RULE = (
    f"**How claims are judged.** A verdict is a function of the stored runs. *Compared*: two ways run with the same "
    f"seeds, and one is better where an exact sign test on the pairs has p ≤ {LEVEL:g} (of 8 seeds all 8, of 10 at "
    "least 9); ties are left out. *Mostly*: the same test on whether a run does what is claimed. *Always*: one run "
    f"against it is enough. With fewer than {LEAST_SEEDS} seeds that a verdict needs, or a larger p, it **cannot be "
    "told**. A claim that fails here by something that the paper leaves open and we had to choose is **not "
    "reproduced**; it **does not hold** only where no choice of ours can be the reason. **Bettered**: a plan that the "
    "check passes does better than the paper's algorithms do on the same map."
)


class Verdict(NamedTuple):
    """What became of a claim of the paper: where it stands there, how it came out here, and why."""

    claim: str
    place: str
    outcome: Outcome
    why: str


class Judged(NamedTuple):
    """An outcome, and the numbers that it rests on, in words."""

    outcome: Outcome
    told: str


def sign_test(wins: int, losses: int) -> float:
    """The exact two-sided p of a sign test: as uneven a split by tosses of a fair coin. 1 where there is none."""
    n = wins + losses
    tail = sum(comb(n, k) for k in range(min(wins, losses) + 1)) / 2**n
    return float(min(1.0, 2 * tail))


def compared(gains: Values, *, ours: bool = False, form: str = ".1f", unit: str = "") -> Judged:
    """Whether one way is better than another, from gains seed by seed: positive where the claim has it.

    ours: whether the claim may fail by a choice of ours.
    """
    values = np.asarray(gains, dtype=np.float64)
    wins, losses = int((values > 0).sum()), int((values < 0).sum())
    p = sign_test(wins, losses)
    error = f" ± {format(float(values.std(ddof=1) / len(values) ** 0.5), form)}" if len(values) > 1 else ""
    mean = format(float(values.mean()), f"+{form}") if len(values) else "none"
    told = f"{mean}{error}{unit} (mean gain ± standard error), so in {wins} of {len(values)} seeds, p = {p:.2g}"
    return Judged(_outcome(wins, losses, len(values), ours), told)


def mostly(does: Sequence[bool], *, ours: bool = False) -> Judged:
    """Whether runs, one for each seed, mostly do what is claimed."""
    wins, losses = sum(map(bool, does)), sum(not one for one in does)
    return Judged(
        _outcome(wins, losses, len(does), ours), f"{wins} of {len(does)} runs, p = {sign_test(wins, losses):.2g}"
    )


def always(does: Sequence[bool], *, ours: bool = False) -> Judged:
    """Whether every run does what is claimed; a claim of all is refuted by one."""
    kept = sum(map(bool, does))
    told = f"{kept} of {len(does)} runs"
    if kept < len(does):
        return Judged(_fails(ours), told)
    return Judged("holds" if len(does) >= LEAST_SEEDS else "cannot be told", told)


def _outcome(wins: int, losses: int, seeds: int, ours: bool) -> Outcome:
    """By the sign test."""
    if seeds < LEAST_SEEDS or sign_test(wins, losses) > LEVEL:
        return "cannot be told"
    return "holds" if wins > losses else _fails(ours)


def _fails(ours: bool) -> Outcome:
    return "not reproduced" if ours else "does not hold"


def spread(values: Values, form: str = ",.0f") -> str:
    """Mean ± standard deviation, and from least to most: ``106.1 ± 2.4 (101 to 109)``; the value alone of one."""
    numbers = np.asarray(values, dtype=np.float64)
    if not len(numbers):
        return "–"
    mean = format(float(numbers.mean()), form)
    if len(numbers) < 2:
        return mean
    least, most = (format(float(one), form) for one in (numbers.min(), numbers.max()))
    return f"{mean} ± {format(float(numbers.std(ddof=1)), form)} ({least} to {most})"
