# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops of the revisit check of a recording, which begins and ends: the worst gap within its time."""

from __future__ import annotations

import numpy as np

from rota.check.kernels import first_room, first_views, nothing_seen, shrunk, times_of_sights, views_of
from rota.check.piece_kernels import middle_of
from rota.check.tiling_kernels import cell_of
from rota.compiled.kernel import kernel


@kernel
def gap_within(times, n, from_s, to_s):
    """Worst gap in seconds of the n robots in ``times`` between two moments, and when it begins.

    The ends count as gaps do: from ``from_s`` to the first sight, and from the last one to ``to_s``. Sights before and
    after do not count. inf, nan: nothing is seen in that time.
    """
    starts, ends = times.starts_s[: times.bounds[n]], times.ends_s[: times.bounds[n]]
    covered, worst, when, seen = from_s, 0.0, from_s, False
    for i in np.argsort(starts):
        if ends[i] < from_s or starts[i] > to_s:
            continue
        seen = True
        if starts[i] - covered > worst:
            worst, when = starts[i] - covered, covered
        covered = max(covered, ends[i])
    if not seen:
        return np.inf, np.nan
    if to_s - covered > worst:
        worst, when = to_s - covered, covered
    return worst, when


@kernel
def gaps_within(offsets, corners, slack_m, grid, legs, team, walls, window_s):
    """Worst gap of each piece within a window (from, to): an upper bound for its points, exact for a single point.

    All other arguments, and what is returned, are those of ``worst_gaps``. Legs are taken as driven once, when they are
    timed.
    """
    n_pieces = len(offsets) - 1
    gaps, begins, firsts, exact = nothing_seen(n_pieces)
    times, views = first_room(len(team.reaches_m)), first_views(len(legs.ways.reaches_m))
    for k in range(n_pieces):
        piece = shrunk(corners, offsets[k], offsets[k + 1], slack_m)
        x, y = middle_of(piece)
        cell = cell_of(x, y, grid)
        views = views_of(np.int64(k), piece, cell, legs.ways, walls, slack_m, views)
        times, n, firsts[k], _always = times_of_sights(np.int64(k), cell, legs, views, times)
        if n:
            gaps[k], begins[k] = gap_within(times, np.int64(n), window_s[0], window_s[1])
    return gaps, begins, firsts, exact
