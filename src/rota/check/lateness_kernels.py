# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops of the check of a plan that takes over from another one: how late places are on the way."""

from __future__ import annotations

import numpy as np

from rota.check.kernels import first_room, first_views, nothing_seen, shrunk, times_of_sights, views_of
from rota.check.piece_kernels import middle_of
from rota.check.tiling_kernels import cell_of
from rota.compiled.kernel import kernel


@kernel
def late_between(starts, ends, period_s, moments):
    """The longest gap that ends after a moment, when it begins, seconds late after that moment, and the last late one.

    starts, ends: of sights, in any order. moments: from when on sights are known, the moment, the beginning of the
    loops and the end. Who is not seen in the loops is never seen again: inf. The last late moment is -inf where nothing
    is late after the moment.
    """
    from_s, after_s, loops_s, to_s = moments
    covered, worst, when, late, last = from_s, 0.0, after_s, 0.0, -np.inf
    order = np.argsort(starts)
    for i in range(len(order) + 1):
        begin = min(starts[order[i]], to_s) if i < len(order) else to_s
        if begin > after_s and begin > covered:
            if begin - covered > worst:
                worst, when = begin - covered, covered
            over = begin - max(covered + period_s, after_s)
            if over > 0:
                late += over
                last = begin
        if i < len(order) and begin < to_s:
            covered = max(covered, ends[order[i]])
    if covered < loops_s:
        return np.inf, covered, np.inf, np.inf
    return worst, when, late, last


@kernel
def late_gaps(offsets, corners, periods_s, slack_m, scene, old, moments):
    """``late_between`` for each piece: upper bounds for its points, exact for a single point.

    scene, old: ``Scene`` of what is driven after the moment and of what was driven before, each leg once. moments: as
    ``late_between`` takes them. The rest is as ``worst_gaps`` takes it. Returns what that does, then (n,) seconds late
    and the last late moment.
    """
    n_pieces = len(offsets) - 1
    gaps, begins, firsts, exact = nothing_seen(n_pieces)
    late, last = np.full(n_pieces, np.inf), np.full(n_pieces, np.inf)
    times, views = first_room(len(scene.team.reaches_m)), first_views(len(scene.legs.ways.reaches_m))
    olds, old_views = first_room(len(old.team.reaches_m)), first_views(len(old.legs.ways.reaches_m))
    for k in range(n_pieces):
        piece = shrunk(corners, offsets[k], offsets[k + 1], slack_m)
        x, y = middle_of(piece)
        cell = cell_of(x, y, scene.grid)
        views = views_of(np.int64(k), piece, cell, scene.legs.ways, scene.walls, slack_m, views)
        times, n, firsts[k], _always = times_of_sights(np.int64(k), cell, scene.legs, views, times)
        cell = cell_of(x, y, old.grid)
        old_views = views_of(np.int64(k), piece, cell, old.legs.ways, old.walls, slack_m, old_views)
        olds, m, _first, _always = times_of_sights(np.int64(k), cell, old.legs, old_views, olds)
        starts = np.append(times.starts_s[: times.bounds[n]], olds.starts_s[: olds.bounds[m]])
        ends = np.append(times.ends_s[: times.bounds[n]], olds.ends_s[: olds.bounds[m]])
        gaps[k], begins[k], late[k], last[k] = late_between(starts, ends, periods_s[k], moments)
    return gaps, begins, firsts, exact, late, last
