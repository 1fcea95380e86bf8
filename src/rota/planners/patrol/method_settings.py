"""The settings of the methods that have stages of their own; ``efforts`` holds their values."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class FixedTeamSettings:
    """The smallest worst ratio of gap to period that a fixed number of robots reaches.

    screened: at most this many allocations are annealed for each of these multiples, half of them nested.
    tries: multiples of the periods that are tried.
    nearness: the search ends once a multiple that passed is at most this factor above one that failed.
    new_allocations: whether new tours are tried too once some have passed.
    growth: while none has passed, the next multiple tried is larger by this factor.
    passed_weight: the next multiple lies this share of the way, of logarithms, from one that failed to one that passed.
    least: smaller multiples are not tried.
    """

    screened: int
    tries: int
    nearness: float
    new_allocations: bool
    growth: float = 1.25
    passed_weight: float = 0.65
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
    many_enough: the same as ``enough`` for many robots, or of what perfect lanes take: below, no search spares one.
    large_from: ground of a larger area, in squares of the reach, is large.
    most_area: of a district that is searched by itself, in squares of the reach.
    most_robots: of such a district, by the bound.
    margin: reaches round a district in which its robots may go.
    built_up_corner: ground of at most so many squares of the reach for each corner is built-up, and planned in pieces.
    piece_area: of a piece of built-up ground, in squares of the reach.
    piece_hot, piece_cold: its heat at the beginning and at the end, as shares of the reach.
    piece_coverage_weight: multiple of the usual weight of seeing.
    searches_built_up: whether districts of built-up ground are searched as small ground is, once there are pieces.
    """

    enough: float
    piece_moves: int
    many_robots: int = 24
    many_enough: float = 1.15
    large_from: float = 4_000.0
    most_area: float = 8_000.0
    most_robots: int = 10
    margin: float = 4.0
    built_up_corner: float = 100.0
    piece_area: float = 1_500.0
    piece_hot: float = 0.25
    piece_cold: float = 1e-3
    piece_coverage_weight: float = 20.0
    searches_built_up: bool = False
