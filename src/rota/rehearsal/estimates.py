"""Means and shares over runs, each with a 95 % confidence interval."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from typing import NamedTuple

LEVEL = 0.95


class Estimate(NamedTuple):
    """A mean or a share over runs; low and high: its confidence interval, None where a single run says nothing."""

    mean: float
    low: float | None
    high: float | None


def mean_over_runs(values: Sequence[float], least: float = -math.inf, most: float = math.inf) -> Estimate:
    """The mean of one value for each run, with Student's interval cut to what the mean can be."""
    mean = statistics.fmean(values)
    if len(values) < 2:
        return Estimate(mean, None, None)
    from scipy.special import stdtrit

    spread = float(stdtrit(len(values) - 1, 0.5 + LEVEL / 2))
    half = spread * statistics.stdev(values) / math.sqrt(len(values))
    return Estimate(mean, max(least, mean - half), min(most, mean + half))


def share_of_runs(count: int, runs: int) -> Estimate:
    """The share of runs in which something was so, with Wilson's interval, which says something of 0 and of all."""
    share = count / runs
    if runs < 2:
        return Estimate(share, None, None)
    z = statistics.NormalDist().inv_cdf(0.5 + LEVEL / 2)
    middle = (share + z * z / (2 * runs)) / (1 + z * z / runs)
    half = z / (1 + z * z / runs) * math.sqrt(share * (1 - share) / runs + z * z / (4 * runs * runs))
    return Estimate(share, max(0.0, middle - half), min(1.0, middle + half))
