"""The third stage: a frame cut into segments, each with a closed route for one robot (Section 4.4, Eqs. 20 to 26).

A robot goes round its segment at the distance r_s: twice the segment and once round its ends, 2 x length + 2 pi r_s.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rota.model.arrays import Ints
from rota.planners.patrol.methods.sun2019.sensors import Frame
from rota.planners.patrol.tolerances import BISECTIONS, TIE


class Partition(NamedTuple):
    """Segments of a frame in its order: the sensors (k,) of each, and the largest share of its period any takes."""

    segments: list[Ints]
    share: float


class Cutting:
    """The ways to cut a frame for robots of a speed and a range."""

    def __init__(self, frame: Frame, periods_s: tuple[float, ...], speed_m_s: float, radius_m: float) -> None:
        n = len(frame.legs_m)
        self._n = n
        self._along_m = np.concatenate([[0.0], np.cumsum(np.tile(frame.legs_m, 2))])
        self._period_s: list[float] = np.tile(np.array(periods_s)[frame.period_class], 2).tolist()
        self._speed_m_s, self._around_m = speed_m_s, 2 * math.pi * radius_m

    def share(self, first: int, count: int) -> float:
        """Of the shortest period of so many sensors from ``first`` on, what one robot's route round them takes."""
        segment_m = self._along_m[first + count - 1] - self._along_m[first]
        time_s = (2 * float(segment_m) + self._around_m) / self._speed_m_s
        return time_s / float(min(self._period_s[first : first + count]))

    def best(self, segments: int | None = None) -> Partition:
        """So many segments at most, or as few as keep their periods, with the smallest largest share of a period."""
        n = self._n
        alone = max(self.share(k, 1) for k in range(n))
        if segments is None:
            segments = len(self._cut(max(1.0, alone)))
        whole = max(self.share(k, n) for k in range(n))
        low, high = alone, max(whole, alone) * (1 + TIE)
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            low, high = (low, middle) if len(self._cut(middle)) <= segments else (middle, high)
        firsts = self._cut(high)
        counts = [(b - a - 1) % n + 1 for a, b in zip(firsts, [*firsts[1:], firsts[0]], strict=True)]
        largest = max(self.share(a, count) for a, count in zip(firsts, counts, strict=True))
        return Partition([(a + np.arange(count)) % n for a, count in zip(firsts, counts, strict=True)], largest)

    def _cut(self, share: float) -> list[int]:
        """The first sensors of the fewest segments that each take so much of their period at most, or are alone."""
        n, longest, count = self._n, list[int](), 1
        for first in range(n):  # a segment that ends no sooner than the one before it
            count = max(1, count - 1)
            while count < n and self.share(first, count + 1) <= share:
                count += 1
            longest.append(count)
        if longest[0] == n:
            return [0]
        best: list[int] | None = None
        for begin in range(longest[0] + 1):  # some segment begins there
            firsts, at = list[int](), begin
            while at < begin + n:
                firsts.append(at % n)
                at += longest[at % n]
            best = firsts if best is None or len(firsts) < len(best) else best
        assert best is not None
        return best
