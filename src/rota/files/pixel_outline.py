"""Pixels to polygons along their edges, straightened by at most half a pixel."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from shapely import MultiPolygon, Polygon, STRtree, box, get_coordinates, linestrings, polygons, union_all
from shapely.geometry.polygon import orient

from rota.model.arrays import Flags, Floats
from rota.model.polygons import polygons_of

LARGEST_DEVIATION = 0.5  # pixels
SEAL = 0.1  # pixels: from where two unset pixels touch to the corners of what joins them


def exact_outline(pixels: Flags) -> MultiPolygon:
    """The union of the pixels that are set, without needless corners.

    pixels: (rows, columns); pixels[row, column] fills the unit square whose lower left corner is (column, row). Empty
    when no pixel is set.
    """
    padded = np.pad(pixels, ((0, 0), (1, 1))).astype(np.int8)
    steps = np.diff(padded, axis=1)
    rows, starts = np.nonzero(steps == 1)
    _, ends = np.nonzero(steps == -1)
    return polygons_of(union_all(box(starts, rows, ends, rows + 1)).simplify(0))


def sealed_outline(pixels: Flags) -> MultiPolygon:
    """The exact outline, with a square of a hundredth of a pixel taken out where unset pixels touch at a corner only.

    Without it one could look through between them, along a single line from every place.
    """
    outline = exact_outline(pixels)
    diagonal = pixels[:-1, :-1] & pixels[1:, 1:] & ~pixels[:-1, 1:] & ~pixels[1:, :-1]
    other = ~pixels[:-1, :-1] & ~pixels[1:, 1:] & pixels[:-1, 1:] & pixels[1:, :-1]
    rows, columns = np.nonzero(diagonal | other)
    if not len(rows):
        return outline
    around = SEAL * np.array([(-1.0, 0.0), (0.0, -1.0), (1.0, 0.0), (0.0, 1.0)])
    seals = polygons(np.column_stack([columns, rows])[:, None] + 1.0 + around)
    return polygons_of(outline.difference(MultiPolygon(list(seals))))


def straight_outline(pixels: Flags) -> MultiPolygon:
    """The outline of the pixels, sealed, with the stairs of slanted walls straightened.

    The new border runs through points of the sealed one, and neither is farther than half a pixel from the other
    (Hausdorff distance). Holes and parts stay as they are in number; the result is valid.
    """
    return MultiPolygon([_straighten(polygon) for polygon in sealed_outline(pixels).geoms])


@dataclass
class _Ring:
    """A closed path of exact corners, places on it where the new border may turn, and those where it does.

    path: (n, 2), the first point not repeated. stops: positions on the path, counted in edges: 3.5 is the middle of the
    fourth edge. turns: those of ``stops`` that are kept. restored: turns from which the exact path is followed.
    """

    path: Floats
    stops: Floats
    turns: list[int] = field(default_factory=list)
    restored: set[int] = field(default_factory=set)

    def point(self, stop: int) -> Floats:
        """Where the stop of this number lies."""
        position = self.stops[stop % len(self.stops)]
        edge = int(position)
        here, there = self.path[edge], self.path[(edge + 1) % len(self.path)]
        return np.asarray(here + (position - edge) * (there - here))

    def between(self, first: int, last: int) -> Floats:
        """(m, 2) exact corners strictly between two stops; ``last`` counts on beyond the ring's end."""
        count = len(self.stops)
        start = self.stops[first % count] + len(self.path) * (first // count)
        end = self.stops[last % count] + len(self.path) * (last // count)
        corners = np.arange(np.floor(start) + 1, np.ceil(end)).astype(np.int64)
        return self.path[corners % len(self.path)]

    def pieces(self) -> list[Floats]:
        """Each piece of the new border as its points, from one turn to the next, the latter included."""
        pieces = []
        for k, turn in enumerate(self.turns):
            after = self.turns[k + 1] if k + 1 < len(self.turns) else self.turns[0] + len(self.stops)
            ends = self.point(turn)[None], self.point(after)[None]
            inner = self.between(turn, after) if turn in self.restored else np.empty((0, 2))
            pieces.append(np.concatenate([ends[0], inner, ends[1]]))
        return pieces


def _straighten(polygon: Polygon) -> Polygon:
    """The polygon with stairs of pixels made straight, or itself where no valid one comes of it."""
    rings = [_ring(get_coordinates(ring)[:-1]) for ring in (polygon.exterior, *polygon.interiors)]
    for ring in rings:
        _choose_turns(ring)
    while True:
        pieces = [ring.pieces() for ring in rings]
        borders = [np.concatenate([piece[:-1] for piece in of_ring]) for of_ring in pieces]
        if all(len(border) >= 3 for border in borders):
            straight = Polygon(borders[0], borders[1:])
            if straight.is_valid:
                return orient(straight.simplify(0))
        # thin walls: both their sides moved, and met; the exact path is followed there instead
        if not _restore_meeting(rings, pieces):
            return polygon


def _ring(path: Floats) -> _Ring:
    """Stops are the middles of one-pixel steps (turning one way and back again), and all corners of no such step."""
    edges = np.roll(path, -1, axis=0) - path
    before = np.roll(edges, 1, axis=0)
    turn = np.sign(before[:, 0] * edges[:, 1] - before[:, 1] * edges[:, 0])
    is_step = (np.abs(edges).sum(axis=1) == 1) & (turn * np.roll(turn, -1) < 0)
    is_corner = ~is_step & ~np.roll(is_step, 1)
    stops = np.sort(np.concatenate([np.flatnonzero(is_corner).astype(np.float64), np.flatnonzero(is_step) + 0.5]))
    return _Ring(path, stops)


def _choose_turns(ring: _Ring) -> None:
    """From stop to stop, each time the farthest one that leaves no exact corner too far from the straight line."""
    from rota.files.outline_kernels import chosen_turns

    ring.turns = [int(turn) for turn in chosen_turns(np.ascontiguousarray(ring.path), ring.stops, LARGEST_DEVIATION)]
    if len(ring.turns) < 3:
        first = ring.turns[0]
        ring.turns = list(range(first, first + len(ring.stops)))


def _restore_meeting(rings: list[_Ring], pieces: list[list[Floats]]) -> bool:
    """Follow the exact path along pieces that meet others than their neighbours; False when there are none."""
    owners = [(ring, k) for ring, of_ring in zip(rings, pieces, strict=True) for k in range(len(of_ring))]
    lines = np.array([linestrings(piece) for of_ring in pieces for piece in of_ring])
    changed = False
    for one, other in STRtree(lines).query(lines, predicate="intersects").T:
        (ring, k), (other_ring, m) = owners[one], owners[other]
        apart = ring is not other_ring or (k - m) % len(ring.turns) not in (0, 1, len(ring.turns) - 1)
        if (apart or lines[one].crosses(lines[other])) and ring.turns[k] not in ring.restored:
            ring.restored.add(ring.turns[k])
            changed = True
    return changed
