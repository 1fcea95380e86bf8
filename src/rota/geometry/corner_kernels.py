# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops of the visibility graph: which corners see each other, and lengths of paths over them.

Corners are rows x, y, then the border corners before and after, (c, 6) metres, with the space on the left.
"""

from __future__ import annotations

from heapq import heappop, heappush
from math import hypot, inf
from typing import Any, NamedTuple

import numpy as np

from rota.compiled.kernel import allocation_free, kernel
from rota.geometry.bundle_kernels import SECTORS, segment_is_free_too
from rota.geometry.kernels import TOUCH_M


class KnownLinks(NamedTuple):
    """What is known of links from a space that was the same but for what lies in some boxes.

    is_old: (c,) the corners that were there. Those linked to corner k are items[start[k] : start[k + 1]]. boxes_m:
    (b, 4) x0, y0, x1, y1 in metres: a line between old corners that meets none of them is free where it was.
    """

    is_old: Any
    start: Any
    items: Any
    boxes_m: Any


@allocation_free
def _meets_box(ax, ay, bx, by, boxes):
    """Whether the line from a to b meets any of the boxes (b, 4), or comes near a corner of one."""
    low_x, high_x, low_y, high_y = min(ax, bx), max(ax, bx), min(ay, by), max(ay, by)
    for n in range(len(boxes)):
        x0, y0, x1, y1 = boxes[n]
        if high_x < x0 or low_x > x1 or high_y < y0 or low_y > y1:
            continue
        dx, dy = bx - ax, by - ay
        middle = dx * (0.5 * (y0 + y1) - ay) - dy * (0.5 * (x0 + x1) - ax)
        if abs(middle) <= 0.5 * (abs(dx) * (y1 - y0) + abs(dy) * (x1 - x0)):
            return True
    return False


@allocation_free
def _may_link(k, corners, sides, may):
    """Fill ``may`` (c,) for all corners after the k-th: whether the line between them is a tangent at both.

    corners: (c, 6), and their sides. One step after the other without a branch, so that several are taken at once.
    """
    x, y, before_x, before_y, after_x, after_y = sides
    px, py = corners[k, 0], corners[k, 1]
    bx, by, ax, ay = before_x[k], before_y[k], after_x[k], after_y[k]
    for m in range(k + 1, len(corners)):
        dx, dy = x[m] - px, y[m] - py
        before, after = dx * before_y[m] - dy * before_x[m], dx * after_y[m] - dy * after_x[m]
        own_before, own_after = dx * by - dy * bx, dx * ay - dy * ax
        slack2 = TOUCH_M * TOUCH_M * (dx * dx + dy * dy)
        there = (before * after >= 0) | (before * before <= slack2) | (after * after <= slack2)
        here = (own_before * own_after >= 0) | (own_before * own_before <= slack2) | (own_after * own_after <= slack2)
        may[m] = there & here


@kernel
def bitangents_of(first, last, corners, corner_part, grid, known):
    """Pairs (p, 2) of the corners first to last, and a later one each of the same part, linked by a free bitangent."""
    pairs = np.empty((1024, 2), np.int32)
    count = 0
    sides = _sides_of(corners)
    linked_to, may = np.full(len(corners), -1, np.int64), np.zeros(len(corners), np.bool_)
    bars = np.empty(SECTORS, np.int64)
    for k in range(first, last):
        one = corners[k]
        bars[:] = -1
        for m in known.items[known.start[k] : known.start[k + 1]]:
            linked_to[m] = k
        _may_link(k, corners, sides, may)
        for m in range(k + 1, len(corners)):
            if not may[m] or corner_part[k] != corner_part[m]:
                continue
            ax, ay, bx, by = one[0], one[1], corners[m, 0], corners[m, 1]
            if known.is_old[k] and known.is_old[m] and not _meets_box(ax, ay, bx, by, known.boxes_m):
                linked = linked_to[m] == k
            else:
                linked = segment_is_free_too(ax, ay, bx, by, grid, bars)
            if linked:
                if count == len(pairs):
                    pairs = np.concatenate((pairs, np.empty_like(pairs)))
                pairs[count, 0], pairs[count, 1] = k, m
                count += 1
    return pairs[:count].copy()


@allocation_free
def _may_bend(px, py, sides, may):
    """Fill ``may`` (c,): whether a shortest path straight from the point may bend at the corners with these sides.

    Its line is a tangent there. One step after the other without a branch, so that several are taken at once.
    """
    x, y, before_x, before_y, after_x, after_y = sides
    for m in range(len(may)):
        dx, dy = x[m] - px, y[m] - py
        before, after = dx * before_y[m] - dy * before_x[m], dx * after_y[m] - dy * after_x[m]
        slack2 = TOUCH_M * TOUCH_M * (dx * dx + dy * dy)
        may[m] = (before * after >= 0) | (before * before <= slack2) | (after * after <= slack2)


@kernel
def _sides_of(corners):
    """(6, c) x and y of the corners (c, 6), of the way to the border corner before, and of that to the one after."""
    sides = np.empty((6, len(corners)))
    for k in range(len(corners)):
        for side in range(6):
            sides[side, k] = corners[k, side] - (corners[k, side % 2] if side > 1 else 0.0)
    return sides


@kernel
def tangents(points, part, corners, corner_part, grid):
    """(n, c) bool: the corners of its own part that each point sees along a tangent."""
    linked = np.empty((len(points), len(corners)), np.bool_)
    sides, bars = _sides_of(corners), np.empty(SECTORS, np.int64)
    for k in range(len(points)):
        px, py = points[k]
        bars[:] = -1
        _may_bend(px, py, sides, linked[k])
        for m in range(len(corners)):
            if linked[k, m]:
                seen = part[k] == corner_part[m]
                linked[k, m] = seen and segment_is_free_too(px, py, sides[0, m], sides[1, m], grid, bars)
    return linked


@allocation_free
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


@kernel
def path_lengths(a, b, corners, between, grid, symmetric):
    """(n, m) lengths of shortest paths from ends a to ends b, inf between different parts.

    between: (c, c) lengths between the corners. symmetric: a and b are the same.
    """
    path_m = np.full((len(a.points), len(b.points)), inf)
    lengths, bars = np.empty(len(corners)), np.empty(SECTORS, np.int64)
    for k in range(len(a.points)):
        ax, ay = a.points[k]
        known = False
        bars[:] = -1
        for m in range(k if symmetric else 0, len(b.points)):
            if a.part[k] < 0 or a.part[k] != b.part[m]:
                continue
            bx, by = b.points[m]
            best = inf
            if segment_is_free_too(ax, ay, bx, by, grid, bars):
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


@kernel
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
    lengths, bars = np.empty(len(corners)), np.empty(SECTORS, np.int64)
    for k in range(first, last):
        ax, ay = a.points[k]
        bars[:] = -1
        found = path_m[k - first]
        some = False
        for m in range(k if symmetric else 0, len(b.points)):
            wanted[m] = False
            if a.part[k] < 0 or a.part[k] != b.part[m]:
                continue
            bx, by = b.points[m]
            if hypot(bx - ax, by - ay) > most_m:
                continue
            if segment_is_free_too(ax, ay, bx, by, grid, bars):
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


@kernel
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
