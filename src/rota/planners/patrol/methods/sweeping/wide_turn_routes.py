"""Pieces of way joined by the shortest arcs to one closed route, in an order that leaves out what lies too near."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rota.geometry.kernels import EdgeGrid
from rota.model.arrays import Floats, Ints
from rota.planners.patrol.driving.polylines import timeable
from rota.planners.patrol.tours.curve_kernels import BLOCKED_M, curve_corners, lengths_between
from rota.planners.patrol.tours.visiting_order import order_of_pairs


@dataclass(frozen=True, kw_only=True, eq=False)
class Route:
    """Pieces (k, 2) in the order and the direction in which they are driven, with a turn radius, within a space."""

    pieces: tuple[Floats, ...]
    radius_m: float
    space: EdgeGrid

    @cached_property
    def gaps(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Of the way from each piece to the next: its two ends (n, 2), (n, 2) and the headings there (n,), (n,)."""
        after = (*self.pieces[1:], self.pieces[0])
        ends_m, begins_m = np.array([piece[-1] for piece in self.pieces]), np.array([piece[0] for piece in after])
        out = ends_m - np.array([piece[-2] for piece in self.pieces])
        into = np.array([piece[1] for piece in after]) - begins_m
        return ends_m, begins_m, np.arctan2(out[:, 1], out[:, 0]), np.arctan2(into[:, 1], into[:, 0])

    @cached_property
    def _joins(self) -> tuple[Floats, Ints]:
        """Length and word (n,) of the way from each piece to the next."""
        ends_m, begins_m, out, into = self.gaps
        ways = [
            _ways(ends_m[[k]], out[[k]], begins_m[[k]], into[[k]], self.radius_m, self.space)
            for k in range(len(self.pieces))
        ]
        return np.array([found[0, 0] for found, _ in ways]), np.array([word[0, 0] for _, word in ways])

    @property
    def joins_m(self) -> Floats:
        """Metres (n,) from each piece to the next; BLOCKED_M more where no way is free."""
        return self._joins[0]

    @property
    def is_free(self) -> bool:
        """Whether all pieces are joined by ways that stay in the space."""
        return bool((self.joins_m < BLOCKED_M).all())

    @cached_property
    def vertices_m(self) -> Floats:
        """The closed polyline (n, 2) of the whole route."""
        ends_m, begins_m, out, into = self.gaps
        words, ways = self._joins[1], list[Floats]()
        for k, piece in enumerate(self.pieces):
            ends, headings = np.array([ends_m[k], begins_m[k]]), np.array([out[k], into[k]])
            ways += [piece, curve_corners(ends, headings, words[k : k + 1], self.radius_m)[1:-1]]
        return timeable(np.vstack(ways))

    def with_piece(self, after: int, piece: Floats) -> Route:
        """The route with one piece more, after the piece of this number."""
        return replace(self, pieces=(*self.pieces[: after + 1], piece, *self.pieces[after + 1 :]))


def short_route(pieces: list[Floats], radius_m: float, space: EdgeGrid) -> Route:
    """A short closed route along all pieces, each driven in either direction, joined by ways that stay in the space.

    A short tour over the pieces' ends, as ``routes.driving_order`` has it for lanes: the way from one end to another is
    as long as the way back, since robots that come back drive in the opposite headings. Lanes nearer to each other than
    two radii do not follow each other so: the loops between them are long, or leave the space.
    """
    if len(pieces) > 1:
        places = np.array([end for piece in pieces for end in (piece[0], piece[-1])])
        outwards = np.array([step for piece in pieces for step in (piece[0] - piece[1], piece[-1] - piece[-2])])
        headings = np.arctan2(outwards[:, 1], outwards[:, 0])
        apart = lengths_m(places, headings, places, headings + math.pi, radius_m, space)
        free = apart < BLOCKED_M
        far_m = 10 * float(apart[free].max(initial=0.0))  # a way into walls is dear, but no more than digits tell
        apart = np.where(free, apart, far_m + apart - BLOCKED_M)
        apart = np.maximum(apart, apart.T)
        pieces = [pieces[k][:: -1 if back else 1] for k, back in order_of_pairs(apart)]
    return Route(pieces=tuple(pieces), radius_m=radius_m, space=space)


def lengths_m(
    begins_m: Floats, headings: Floats, ends_m: Floats, end_headings: Floats, radius_m: float, space: EdgeGrid
) -> Floats:
    """Metres (n, m) of the shortest free ways from places (n, 2) and headings (n,) to others (m, 2), (m,).

    BLOCKED_M more where none is free.
    """
    return _ways(begins_m, headings, ends_m, end_headings, radius_m, space)[0]


def _ways(
    begins_m: Floats, headings: Floats, ends_m: Floats, end_headings: Floats, radius_m: float, space: EdgeGrid
) -> tuple[Floats, Ints]:
    """The lengths (n, m) in metres of the shortest free ways between poses, and their words."""
    shape = (len(begins_m), len(ends_m), 1, 1)
    found, words = np.zeros(shape), np.zeros(shape, dtype=np.int64)
    begins_m, ends_m = np.ascontiguousarray(begins_m), np.ascontiguousarray(ends_m)
    lengths_between(
        begins_m, ends_m, np.ascontiguousarray(headings)[:, None], np.ascontiguousarray(end_headings)[:, None],
        radius_m, space, found, words,
    )  # fmt: skip
    return found[:, :, 0, 0], words[:, :, 0, 0]
