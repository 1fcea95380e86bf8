"""What the compiled loops of the check are given: plain arrays, joined as named tuples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

TRANSIENT, LOOP, HOLD = 0, 1, 2  # legs before a loop, in its first turn, and of a robot that stays for ever


class Grid(NamedTuple):
    """Square cells over all places that are asked: (x0_m, y0_m) is the lower left corner, ``cell_m`` a cell's side.

    The cell in column i and row j has the number i * rows + j.
    """

    x0_m: float
    y0_m: float
    cell_m: float
    columns: int
    rows: int


class Binned(NamedTuple):
    """Segments (n, 4) x0, y0, x1, y1 in metres, and which of them matter to the cells of a grid.

    Those of cell c are items[offsets[c] : offsets[c + 1]], ascending; offsets: (columns * rows + 1,).
    """

    segments_m: Floats
    offsets: Ints
    items: Ints


WALL, STANDING = -1, -2  # what a side of a triangle is that no other triangle lies beyond


class Triangles(NamedTuple):
    """Ground as t triangles that share sides: all that is neither in an obstacle to sight nor where bodies stand.

    corners_m: (v, 2). triangles: (t, 3) indices of corners, against the clock. beyond: (t, 3) the triangle beyond the
    side from each corner to the next; WALL, or STANDING where bodies stand beyond it. Those near cell c of the grid are
    items[offsets[c] : offsets[c + 1]].
    """

    corners_m: Floats
    triangles: Ints
    beyond: Ints
    grid: Grid
    offsets: Ints
    items: Ints


class Ways(NamedTuple):
    """The w ways that robots go: legs of the same two ends, in the same direction, with the same sensor are one way.

    reaches_m: (w,) radii, or half sides where squares (w,) is set; ``widest_m`` is the largest. Robots that share a
    tour go the same ways, and see the same from there.
    """

    near: Binned
    reaches_m: Floats
    squares: Flags
    widest_m: float


class Legs(NamedTuple):
    """The legs (m,) of all robots, robot by robot and in the order of time; see ``Routes``.

    times_s: (m, 2) when a leg begins and ends. robots: (m,) index of the robot. kinds: (m,) before the loop, in its
    first turn, or a robot that stays for ever. way_of: (m,) which of the ways each goes. bends: (m,) of each leg.
    """

    near: Binned
    times_s: Floats
    bends: Floats
    robots: Ints
    kinds: Ints
    ways: Ways
    way_of: Ints


class Loops(NamedTuple):
    """The loops of k robots; see ``commensurable_classes``.

    classes: (k,) loops with one number share a period. parts: (k,) durations in units of the class. units_s: (classes,)
    seconds. from_s: the time from which on gaps count.
    """

    classes: Ints
    parts: Ints
    units_s: Floats
    from_s: float


class Team(NamedTuple):
    """What k robots see with, and their loops: reaches_m (k,) radii, or half sides where squares (k,) is set."""

    reaches_m: Floats
    squares: Flags
    loops: Loops


class Scene(NamedTuple):
    """What pieces are seen from, and what hides them: the legs of a team, and walls, in the cells of a grid."""

    grid: Grid
    legs: Legs
    team: Team
    walls: Binned


class SeenTimes(NamedTuple):
    """When n robots see a place in the first turn of their loops: intervals, robot by robot, ascending and disjoint.

    The i-th robot, which is robots[i] of the team, sees it from starts_s[p] to ends_s[p] for all p in
    bounds[i] .. bounds[i + 1] - 1. Arrays may be longer than that.
    """

    starts_s: Floats
    ends_s: Floats
    bounds: Ints
    robots: Ints


class Parts(NamedTuple):
    """Room for parts of a leg, from starts[p] to ends[p], as shares of it in 0..1."""

    starts: Floats
    ends: Floats


class Views(NamedTuple):
    """From which parts of its ways one piece is seen: room that serves one piece after the other.

    Way w sees the piece of turn seen_in[w] from shares.starts[p] to shares.ends[p] for the counts[w] numbers p from
    firsts[w] on; what it saw of others says nothing. one: room for the parts of a single way.
    """

    seen_in: Ints
    firsts: Ints
    counts: Ints
    shares: Parts
    one: Parts


class Shadows(NamedTuple):
    """What walls hide of one convex piece: the positions from which a wall cuts it, one row for each wall.

    sides: (n, 9) three half-planes nx, ny, c (n.p > c) whose intersection is the shadow; only where ``hides`` has said
    so. boxes: (n, 4) x0, y0, x1, y1 round the wall. ends: (n, 4) its ends. walls: (n,) its index. known: (n,) what is
    known of it. number: of the walls; -1: a wall cuts the piece itself, so that it is never seen whole. box: (4,) x0,
    y0, x1, y1 round the piece.
    """

    sides: Floats
    boxes: Floats
    ends: Floats
    walls: Ints
    known: Ints
    number: int
    box: Floats
