# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops that straighten the outline of pixels: from which stop to which the border may run straight.

path: (n, 2) exact corners of a closed ring, in pixels. stops: (s,) positions on it, counted in edges. Stops are
numbered, and numbers go on beyond the ring's end.
"""

from __future__ import annotations

from math import ceil, floor

import numpy as np

from rota.compiled.kernel import kernel


@kernel
def _point(path, stops, stop):
    """x and y of the stop of this number."""
    position = stops[stop % len(stops)]
    edge = int(position)
    after = edge + 1 if edge + 1 < len(path) else 0
    x, y, along = path[edge, 0], path[edge, 1], position - edge
    return x + along * (path[after, 0] - x), y + along * (path[after, 1] - y)


@kernel
def _corners_between(path, stops, first, last):
    """The number of the first exact corner strictly between two stops, and one past the last."""
    start = stops[first % len(stops)] + len(path) * (first // len(stops))
    end = stops[last % len(stops)] + len(path) * (last // len(stops))
    return floor(start) + 1, ceil(end)


@kernel
def _fits(path, stops, first, last, most):
    """Whether no exact corner between two stops is farther than ``most`` pixels from the straight line."""
    (x, y), (end_x, end_y) = _point(path, stops, first), _point(path, stops, last)
    dx, dy = end_x - x, end_y - y
    squared = dx * dx + dy * dy
    if squared == 0:
        return False
    begin, end = _corners_between(path, stops, first, last)
    for k in range(begin, end):
        cx, cy = path[k % len(path), 0] - x, path[k % len(path), 1] - y
        share = min(max((cx * dx + cy * dy) / squared, 0.0), 1.0)
        off_x, off_y = cx - share * dx, cy - share * dy
        if not off_x * off_x + off_y * off_y <= most * most:
            return False
    return True


@kernel
def _farthest(path, stops, at, limit, most):
    """The farthest stop that is reached straight from one, none beyond ``limit``."""
    reached, ahead = at + 1, 2
    # doubling, then halving, finds it in few trials; what lies within reach is nearly always a run without gaps
    while at + ahead <= limit and _fits(path, stops, at, at + ahead, most):
        reached, ahead = at + ahead, 2 * ahead
    low, high = reached, min(at + ahead, limit + 1)
    while high - low > 1:
        middle = (low + high) // 2
        if _fits(path, stops, at, middle, most):
            low = middle
        else:
            high = middle
    return low


@kernel
def chosen_turns(path, stops, most):
    """The numbers of the stops at which the border turns, each the farthest that is reached straight from the last.

    A corner of long walls is the first: it is sure to be one of the result.
    """
    count, first, fewest = len(stops), 0, len(path) + 1
    for k in range(count):
        between = 0
        if stops[k] % 1.0 != 0.0:
            begin, end = _corners_between(path, stops, k - 1, k + 1)
            between = max(end - begin, 0)
        if between < fewest:
            first, fewest = k, between
    turns, found, at = np.empty(count, np.int64), 0, first
    while at < first + count:
        turns[found] = at
        found += 1
        at = _farthest(path, stops, at, first + count, most)
    return turns[:found].copy()
