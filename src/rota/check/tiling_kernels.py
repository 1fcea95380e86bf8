# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""Compiled loops over the pieces of the tiling and over the grid that finds what is near a piece.

No loop of the check can leave an array, whatever numbers a plan holds. A cell of the grid is found by ``cell_along``
alone, which clamps before it makes an integer; ``rasterise`` counts entries in the same way in which it writes them
afterwards; what is written per piece, wall or leg has room for the most that there can be, told where it is made.
"""

from __future__ import annotations

import math

import numpy as np

from rota.check.arrays import Binned
from rota.check.piece_kernels import box_of, middle_of
from rota.check.tolerances import STILL_M
from rota.compiled.kernel import allocation_free, kernel


@allocation_free
def cell_along(offset_m, size_m, count):
    """The cell of a grid along one axis, 0 to count - 1; the nearest for an offset outside, the first for nan."""
    cells = offset_m / size_m
    if not cells >= 1.0:
        return 0
    # no float beyond the grid becomes an integer, which would be any number
    return count - 1 if cells >= count else int(cells)


@allocation_free
def cell_of(x, y, grid):
    """Number of the cell of a ``Grid`` that holds a place; for places outside the nearest cell."""
    column = cell_along(x - grid.x0_m, grid.cell_m, grid.columns)
    return column * grid.rows + cell_along(y - grid.y0_m, grid.cell_m, grid.rows)


@kernel
def in_cell(binned, cell):
    """(n,) indices of the segments that matter to a cell."""
    return binned.items[binned.offsets[cell] : binned.offsets[cell + 1]]


@allocation_free
def _cells_between(low_m, high_m, size_m, count):
    """The first and last cell that an interval along one axis meets; last is before first where it meets none."""
    if not (high_m >= 0.0 and low_m < size_m * count):
        return 0, -1
    return cell_along(low_m, size_m, count), cell_along(high_m, size_m, count)


@kernel
def rasterise(segments, margin_m, grid):
    """Sort segments (n, 4) into the cells of a ``Grid`` that they come within ``margin_m`` of, or a little more."""
    nx, ny = grid.columns, grid.rows
    offsets = np.zeros(nx * ny + 1, np.int64)
    index = np.empty(0, np.int64)
    for fill in range(2):
        if fill == 1:
            for c in range(nx * ny):
                offsets[c + 1] += offsets[c]
            index = np.empty(offsets[nx * ny], np.int64)
            cursor = offsets[:-1].copy()
        for k in range(len(segments)):
            x0, y0, x1, y1 = segments[k, 0], segments[k, 1], segments[k, 2], segments[k, 3]
            left, right = min(x0, x1) - margin_m - grid.x0_m, max(x0, x1) + margin_m - grid.x0_m
            first, last = _cells_between(left, right, grid.cell_m, nx)
            for i in range(first, last + 1):
                lo, hi = 0.0, 1.0
                if abs(x1 - x0) > STILL_M:
                    ua = (grid.x0_m + i * grid.cell_m - margin_m - x0) / (x1 - x0)
                    ub = (grid.x0_m + (i + 1) * grid.cell_m + margin_m - x0) / (x1 - x0)
                    lo = min(1.0, max(0.0, min(ua, ub)))
                    hi = max(0.0, min(1.0, max(ua, ub)))
                ya, yb = y0 + lo * (y1 - y0), y0 + hi * (y1 - y0)
                bottom, top = min(ya, yb) - margin_m - grid.y0_m, max(ya, yb) + margin_m - grid.y0_m
                low, high = _cells_between(bottom, top, grid.cell_m, ny)
                for j in range(low, high + 1):
                    if fill == 0:
                        offsets[i * ny + j + 1] += 1
                    else:
                        index[cursor[i * ny + j]] = k
                        cursor[i * ny + j] += 1
    return Binned(segments, offsets, index)


@allocation_free
def _rows_of_triangle(corners_m, triangle, left_m, right_m, margin_m, grid):
    """The first and last row of a grid that a triangle comes within a margin of, between two lines along y."""
    low, high = math.inf, -math.inf
    for k in range(3):
        ax, ay = corners_m[triangle[k], 0], corners_m[triangle[k], 1]
        bx, by = corners_m[triangle[(k + 1) % 3], 0], corners_m[triangle[(k + 1) % 3], 1]
        if max(ax, bx) < left_m or min(ax, bx) > right_m:
            continue
        u, v = 0.0, 1.0
        if ax != bx:
            u, v = (left_m - ax) / (bx - ax), (right_m - ax) / (bx - ax)
            u, v = min(1.0, max(0.0, min(u, v))), max(0.0, min(1.0, max(u, v)))
        ya, yb = ay + u * (by - ay), ay + v * (by - ay)
        low, high = min(low, ya, yb), max(high, ya, yb)
    low, high = low - margin_m - grid.y0_m, high + margin_m - grid.y0_m
    return cell_along(low, grid.cell_m, grid.rows), cell_along(high, grid.cell_m, grid.rows)


@kernel
def sort_into_cells(corners_m, triangles, grid, margin_m):
    """Offsets and items by cell of a grid: which triangles (t, 3), indices of corners (v, 2), come near it."""
    offsets = np.zeros(grid.columns * grid.rows + 1, np.int64)
    items = np.empty(0, np.int64)
    for fill in range(2):
        if fill == 1:
            for c in range(grid.columns * grid.rows):
                offsets[c + 1] += offsets[c]
            items = np.empty(offsets[-1], np.int64)
            cursor = offsets[:-1].copy()
        for t in range(len(triangles)):
            x0, x1, x2 = corners_m[triangles[t, 0], 0], corners_m[triangles[t, 1], 0], corners_m[triangles[t, 2], 0]
            first = cell_along(min(x0, x1, x2) - margin_m - grid.x0_m, grid.cell_m, grid.columns)
            last = cell_along(max(x0, x1, x2) + margin_m - grid.x0_m, grid.cell_m, grid.columns)
            for i in range(first, last + 1):
                left_m = grid.x0_m + i * grid.cell_m - margin_m
                right_m = left_m + grid.cell_m + 2 * margin_m
                low, high = _rows_of_triangle(corners_m, triangles[t], left_m, right_m, margin_m, grid)
                for j in range(low, high + 1):
                    cell = i * grid.rows + j
                    if fill == 0:
                        offsets[cell + 1] += 1
                    else:
                        items[cursor[cell]] = t
                        cursor[cell] += 1
    return offsets, items


@kernel
def swath_cuts(offsets, corners, grid, ways, margin_m):
    """For each piece a line (n, 3) nx, ny, c: n.p = c, along the edge of what a way sees; nan where there is none.

    offsets (n + 1,), corners (c, 2): the pieces. Of several edges the nearest to the piece's middle counts. At least
    ``margin_m`` of the piece must lie on either side.
    """
    cuts = np.full((len(offsets) - 1, 3), np.nan)
    for k in range(len(cuts)):
        piece = corners[offsets[k] : offsets[k + 1]]
        mx, my = middle_of(piece)
        best = math.inf
        for w in in_cell(ways.near, cell_of(mx, my, grid)):
            leg = ways.near.segments_m[w]
            dx, dy = leg[2] - leg[0], leg[3] - leg[1]
            length = math.hypot(dx, dy)
            if length < STILL_M:
                continue
            nx, ny = -dy / length, dx / length
            reach = ways.reaches_m[w] * (abs(nx) + abs(ny) if ways.squares[w] else 1.0)
            along = ((mx - leg[0]) * dx + (my - leg[1]) * dy) / length
            if along < -reach or along > length + reach:
                continue
            side = nx * (mx - leg[0]) + ny * (my - leg[1])
            if abs(abs(side) - reach) > reach / 2:
                continue
            low, high, front, back = math.inf, -math.inf, math.inf, -math.inf
            for p in range(len(piece)):
                px, py = piece[p, 0] - leg[0], piece[p, 1] - leg[1]
                low, high = min(low, nx * px + ny * py), max(high, nx * px + ny * py)
                front, back = min(front, ny * px - nx * py), max(back, ny * px - nx * py)
            # at its very edge a disc sees one point at a time: cut where its chord is twice as long as the piece
            edge = reach if ways.squares[w] else math.sqrt(max(0.0, reach**2 - (back - front) ** 2))
            edge = edge if side > 0 else -edge
            if abs(side - edge) >= best:
                continue
            if low < edge - margin_m and high > edge + margin_m:
                best = abs(side - edge)
                cuts[k, 0], cuts[k, 1] = nx, ny
                cuts[k, 2] = edge + nx * leg[0] + ny * leg[1]
    return cuts


@kernel
def halve(offsets, corners, cuts, narrowest_m):
    """Cut each convex piece in two along its line, or across the longer side of its box where the line is nan.

    offsets (n + 1,), corners (c, 2): the pieces. cuts: (n, 3) nx, ny, c. Returns offsets and corners of the parts, and
    the index of each part's piece. Slivers are dropped.
    """
    n = len(offsets) - 1
    # of c corners z lie on the line and x sides cross it, x <= c - z: both parts have c + z + 2 x <= 3 c corners
    most = 3 * len(corners)
    new_offsets = np.zeros(2 * n + 1, np.int64)
    new_corners = np.empty((most, 2))
    parent = np.empty(2 * n, np.int64)
    count, top = 0, 0
    for k in range(n):
        a, b = offsets[k], offsets[k + 1]
        nx, ny, c = cuts[k, 0], cuts[k, 1], cuts[k, 2]
        if math.isnan(c):
            x0, x1, y0, y1 = box_of(corners[a:b])
            wide = x1 - x0 >= y1 - y0
            nx, ny = (1.0, 0.0) if wide else (0.0, 1.0)
            c = 0.5 * (x0 + x1) if wide else 0.5 * (y0 + y1)
        for side in (-1.0, 1.0):
            start = top
            for i in range(a, b):
                j = i + 1 if i + 1 < b else a
                p = side * (nx * corners[i, 0] + ny * corners[i, 1] - c)
                q = side * (nx * corners[j, 0] + ny * corners[j, 1] - c)
                if p >= 0:
                    new_corners[top, 0], new_corners[top, 1] = corners[i, 0], corners[i, 1]
                    top += 1
                if (p > 0 and q < 0) or (p < 0 and q > 0):
                    for axis in range(2):
                        step = p / (p - q) * (corners[j, axis] - corners[i, axis])
                        new_corners[top, axis] = corners[i, axis] + step
                    top += 1
            if half_width(new_corners, np.int64(start), np.int64(top)) > narrowest_m:
                parent[count] = k
                count += 1
                new_offsets[count] = top
            else:
                top = start
    return new_offsets[: count + 1].copy(), new_corners[:top].copy(), parent[:count].copy()


@allocation_free
def half_width(corners, start, stop):
    """Distance in metres from the mean of corners[start:stop] to the nearest side; 0 for less than a triangle."""
    if stop - start < 3:
        return 0.0
    cx, cy = middle_of(corners[start:stop])
    nearest = math.inf
    for i in range(start, stop):
        j = i + 1 if i + 1 < stop else start
        dx, dy = corners[j, 0] - corners[i, 0], corners[j, 1] - corners[i, 1]
        length = math.hypot(dx, dy)
        if length > 0:
            nearest = min(nearest, abs(dx * (cy - corners[i, 1]) - dy * (cx - corners[i, 0])) / length)
    return nearest


@kernel
def half_widths(offsets, corners):
    """``half_width`` (n,) of each piece; offsets (n + 1,), corners (c, 2)."""
    widths_m = np.empty(len(offsets) - 1)
    for k in range(len(widths_m)):
        widths_m[k] = half_width(corners, offsets[k], offsets[k + 1])
    return widths_m
