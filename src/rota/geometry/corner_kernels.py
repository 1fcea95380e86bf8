# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops of the visibility graph: which corners see each other, and lengths of paths over them.

Corners are rows x, y, then the border corners before and after, (c, 6) metres, with the space on the left.
"""

from __future__ import annotations

from heapq import heappop, heappush
from math import hypot, inf
from typing import Any, NamedTuple

import numpy as np

from rota.compiled.kernel import kernel
from rota.geometry.kernels import TOUCH_M, segment_is_free


@kernel
def _can_bend(px, py, corner):
    """Whether a shortest path straight from the point may bend at the corner (6,): its line is a tangent there."""
    dx, dy = corner[0] - px, corner[1] - py
    before = dx * (corner[3] - corner[1]) - dy * (corner[2] - corner[0])
    after = dx * (corner[5] - corner[1]) - dy * (corner[4] - corner[0])
    if before * after >= 0:
        return True
    slack2 = TOUCH_M * TOUCH_M * (dx * dx + dy * dy)
    return before * before <= slack2 or after * after <= slack2


@kernel
def bitangents(corners, corner_part, grid):
    """(c, c) bool: corners of one part that see each other along a line that is a tangent at both."""
    c = len(corners)
    linked = np.zeros((c, c), np.bool_)
    for k in range(c):
        one = corners[k]
        for m in range(k):
            other = corners[m]
            if corner_part[k] != corner_part[m] or not _can_bend(one[0], one[1], other):
                continue
            if _can_bend(other[0], other[1], one) and segment_is_free(one[0], one[1], other[0], other[1], grid):
                linked[k, m] = linked[m, k] = True
    return linked


@kernel(nogil=True)
def bitangents_of(some, asked, corners, corner_part, grid):
    """Pairs (p, 2) that ``bitangents`` links, of corners ``some`` (k,) and others; of two that are asked, once.

    asked: (c,) flags of all corners that are asked for, here or in another call.
    """
    pairs = np.empty((1024, 2), np.int32)
    count = 0
    for k in some:
        one = corners[k]
        for m in range(len(corners)):
            other = corners[m]
            if (asked[m] and m <= k) or corner_part[k] != corner_part[m] or not _can_bend(one[0], one[1], other):
                continue
            if _can_bend(other[0], other[1], one) and segment_is_free(one[0], one[1], other[0], other[1], grid):
                if count == len(pairs):
                    pairs = np.concatenate((pairs, np.empty_like(pairs)))
                pairs[count, 0], pairs[count, 1] = k, m
                count += 1
    return pairs[:count].copy()


@kernel(nogil=True)
def tangents(points, part, corners, corner_part, grid):
    """(n, c) bool: the corners of its own part that each point sees along a tangent."""
    linked = np.zeros((len(points), len(corners)), np.bool_)
    for k in range(len(points)):
        px, py = points[k]
        for m in range(len(corners)):
            if part[k] == corner_part[m] and _can_bend(px, py, corners[m]):
                linked[k, m] = segment_is_free(px, py, corners[m, 0], corners[m, 1], grid)
    return linked


@kernel
def _lengths_to_corners(px, py, linked, corners, between, lengths):
    """Fill lengths (c,) with those of the shortest paths from the point, by way of its links, to each corner."""
    lengths[:] = inf
    for m in linked:
        first = hypot(corners[m, 0] - px, corners[m, 1] - py)
        for n in range(len(lengths)):
            lengths[n] = min(lengths[n], first + between[m, n])


class Ends(NamedTuple):
    """Points (n, 2), the part (n,) each lies in, and the corners linked to point k: items[start[k] : start[k + 1]].

    A point in part -1 is outside and reaches nothing.
    """

    points: Any
    part: Any
    start: Any
    items: Any


@kernel(nogil=True)
def path_lengths(a, b, corners, between, grid, symmetric):
    """(n, m) lengths of shortest paths from ends a to ends b, inf between different parts.

    between: (c, c) lengths between the corners. symmetric: a and b are the same.
    """
    path_m = np.full((len(a.points), len(b.points)), inf)
    lengths = np.empty(len(corners))
    for k in range(len(a.points)):
        ax, ay = a.points[k]
        known = False
        for m in range(k if symmetric else 0, len(b.points)):
            if a.part[k] < 0 or a.part[k] != b.part[m]:
                continue
            bx, by = b.points[m]
            best = inf
            if segment_is_free(ax, ay, bx, by, grid):
                best = hypot(bx - ax, by - ay)
            else:
                if not known:
                    _lengths_to_corners(ax, ay, a.items[a.start[k] : a.start[k + 1]], corners, between, lengths)
                    known = True
                for n in b.items[b.start[m] : b.start[m + 1]]:
                    best = min(best, lengths[n] + hypot(corners[n, 0] - bx, corners[n, 1] - by))
            path_m[k, m] = best
            if symmetric:
                path_m[m, k] = best
    return path_m


class Goals(NamedTuple):
    """Points (n, 2), which of them (n,) are wanted, and those that see corner k: ends[begin[k] : begin[k + 1]]."""

    points: Any
    wanted: Any
    begin: Any
    ends: Any


@kernel(nogil=True)
def searched_lengths(rows, a, b, corners, links, grid, symmetric, most_m):
    """Some rows (first, last) of the lengths of shortest paths from ends a to ends b, as ``path_lengths`` gives them.

    links: the corners linked to each, as starts (c + 1,), items, and lengths in metres. From each point they are
    searched (Dijkstra 1959) until no way on can be shorter than those found, or than ``most_m``: what is longer is inf,
    or the length of some way.
    """
    first, last = rows
    path_m = np.full((last - first, len(b.points)), inf)
    order = np.argsort(b.items, kind="mergesort")
    corner_of = b.items[order]
    end_of = np.empty(len(order), np.int64)
    for m in range(len(b.points)):
        end_of[b.start[m] : b.start[m + 1]] = m
    end_of = end_of[order]
    begin = np.searchsorted(corner_of, np.arange(len(corners) + 1))
    wanted = np.zeros(len(b.points), np.bool_)
    lengths = np.empty(len(corners))
    for k in range(first, last):
        ax, ay = a.points[k]
        found = path_m[k - first]
        some = False
        for m in range(k if symmetric else 0, len(b.points)):
            wanted[m] = False
            if a.part[k] < 0 or a.part[k] != b.part[m]:
                continue
            bx, by = b.points[m]
            if hypot(bx - ax, by - ay) > most_m:
                continue
            if segment_is_free(ax, ay, bx, by, grid):
                found[m] = hypot(bx - ax, by - ay)
            else:
                wanted[m] = some = True
        if some:
            from_a = a.items[a.start[k] : a.start[k + 1]]
            _search(a.points[k], from_a, Goals(b.points, wanted, begin, end_of), corners, links, lengths, found, most_m)
        wanted[:] = False
    return path_m


@kernel
def _search(a, from_a, goals, corners, links, lengths, found, most_m):
    """Fill in the lengths found (n,) from point a (2,), which sees corners from_a, to the goals that are wanted.

    lengths: room for those to the corners (c,). most_m: longer ways are not looked for.
    """
    ax, ay = a
    start, items, metres = links
    lengths[:] = inf
    heap = [(inf, np.int64(-1))]
    for n in from_a:
        lengths[n] = hypot(corners[n, 0] - ax, corners[n, 1] - ay)
        heappush(heap, (lengths[n], np.int64(n)))
    longest = most_m  # of the ways to all that are wanted
    due = 0  # pops until the longest is known anew: to know it takes a look at them all
    while True:
        length, n = heappop(heap)
        if n < 0 or length >= longest:
            return
        if length > lengths[n]:
            continue
        for m in goals.ends[goals.begin[n] : goals.begin[n + 1]]:
            if goals.wanted[m]:
                last = hypot(corners[n, 0] - goals.points[m, 0], corners[n, 1] - goals.points[m, 1])
                found[m] = min(found[m], length + last)
        due -= 1
        if due < 0:
            longest = 0.0
            for m in range(len(found)):
                if goals.wanted[m]:
                    longest = max(longest, found[m])
            longest = min(longest, most_m)
            due = len(found) // 8
        for at in range(start[n], start[n + 1]):
            on, way = items[at], length + metres[at]
            if way < lengths[on]:
                lengths[on] = way
                heappush(heap, (way, np.int64(on)))


@kernel(nogil=True)
def corner_chain(a, from_a, b, from_b, corners, start, items):
    """Corners on the shortest path from point a (2,) to point b (2,) that bends; none where there is no such path.

    from_a, from_b: the corners that a and b see along tangents. start, items: the corners linked to each, by rows. Of
    the corners in reach that with the least sum of the way so far and the straight rest goes on first (Hart, Nilsson
    and Raphael 1968), so that few are looked at when the points are near each other.
    """
    ax, ay = a
    bx, by = b
    count = len(corners)
    lengths, before = np.full(count, inf), np.full(count, -1, np.int64)
    ends_here = np.zeros(count, np.bool_)
    ends_here[from_b] = True
    done = np.zeros(count, np.bool_)
    heap = [(inf, np.int64(-1))]
    for k in from_a:
        lengths[k] = hypot(corners[k, 0] - ax, corners[k, 1] - ay)
        heappush(heap, (lengths[k] + hypot(corners[k, 0] - bx, corners[k, 1] - by), np.int64(k)))
    best, last = inf, np.int64(-1)
    while True:
        estimate, k = heappop(heap)
        if k < 0 or estimate >= best:
            break
        if done[k]:
            continue
        done[k] = True
        if ends_here[k]:
            best, last = estimate, k
            continue
        for n in range(start[k], start[k + 1]):
            m = items[n]
            length = lengths[k] + hypot(corners[m, 0] - corners[k, 0], corners[m, 1] - corners[k, 1])
            if length < lengths[m]:
                lengths[m], before[m] = length, k
                heappush(heap, (length + hypot(corners[m, 0] - bx, corners[m, 1] - by), np.int64(m)))
    chain = np.empty(count, np.int64)
    at = count
    while last >= 0:
        at -= 1
        chain[at] = last
        last = before[last]
    return chain[at:].copy()
