"""The settings of the methods that have stages of their own; ``efforts`` holds their values."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class FixedTeamSettings:
    """The smallest worst ratio of gap to period that a fixed number of robots reaches.

    screened: at most this many allocations are annealed for each of these multiples, half of them nested.
    tries: multiples of the periods that are tried.
    nearness: the search ends once a multiple that passed is at most this factor above one that failed.
    least: smaller multiples are not tried.
    """

    screened: int
    tries: int
    nearness: float
    least: float = 1e-3


@dataclass(frozen=True, kw_only=True)
class SweepingSettings:
    """The traditional methods.

    tries: proposals that are repaired and judged.
    groupings: at most this many ways to group the period classes are tried.
    angles: directions of lanes, the most promising, for which routes are laid.
    reserves: shares of the budgets kept for the repair, the next one where the one before was too little.
    """

    tries: int
    angles: int
    groupings: int = 8
    reserves: tuple[float, ...] = (0.0, 0.02, 0.05, 0.1, 0.2)


@dataclass(frozen=True, kw_only=True)
class DistrictSettings:
    """Large ground, which is planned in districts.

    enough: lanes are kept if their robots are at most this multiple of the fewest there can be.
    piece_moves: of the annealing of a piece, for each reach of ideal loop, the ground over the swath.
    many_robots: ground for so many robots at least, by the bound, is large.
    large_from: ground of a larger area, in squares of the reach, is large.
    most_area: of a district that is searched by itself, in squares of the reach.
    built_up_corner: ground of at most so many squares of the reach for each corner is built-up, and planned in pieces.
    piece_area: of a piece of built-up ground, in squares of the reach.
    """

    enough: float
    piece_moves: int
    many_robots: int = 24
    large_from: float = 4_000.0
    most_area: float = 8_000.0
    built_up_corner: float = 100.0
    piece_area: float = 1_500.0
