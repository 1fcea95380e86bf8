"""Limit cycles of the bounce map in the plane: where robots end up, how stable it is, and from how many starts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely

from rota.errors import MissionError
from rota.model.arrays import Floats, Ints
from rota.planners.bounce.polygon import BounceRule, Rim, bounce_path, require_room
from rota.planners.bounce.polygon_kernels import (
    SETTLED,
    STUCK,
    WALL,
    CyclesReached,
    Discs,
    cycles_reached,
    follow,
    is_blocked,
)

Stability = Literal["attracting", "half-stable", "neutral", "repelling"]
_SAME_SLOPE = 1e-7
_CORNER_M = 1e-7  # a disc so near to a second wall or corner touches both
_ASIDE_M = 1e-5  # by which robots are displaced to see what becomes of it
_ROUNDS = (4, 12)  # after which it is looked how far off they are
_MEMBERS = 16  # of a neutral family that are looked at
_GRAZING_RAD = 1e-6  # by which a heading is put off to see whether the way out is free then
_SAME_SHARE = 0.01  # by which a distance that stays may differ


@dataclass(frozen=True, kw_only=True, eq=False)
class PolygonCycle:
    """A closed way of bouncing; of a neutral family, the member found first.

    arcs_m, headings_rad (p,): the contacts and the headings on leaving them; positions_m (p, 2) the centres there.
    ``multiplier``: derivative of the return map along the rim, by which a small displacement grows in every round, with
    headings held; where a contact is in a corner, the map has a kink and this is the slope of one side. ``stability``:
    what becomes of small displacements: all fade, all stay, some grow and none fades, or ("half-stable") some fade and
    others do not, as may be at a kink. ``share`` of the starts that come to it (or to its family), +- ``share_error``
    (one standard error). ``grazes``: some contact is left along a wall that is touched there, as an impact at 45
    degrees is after a turn by 135; a heading off by rounding may then be blocked, and a turn more ends the cycle.
    """

    arcs_m: Floats
    headings_rad: Floats
    positions_m: Floats
    length_m: float
    multiplier: float
    stability: Stability
    share: float
    share_error: float
    grazes: bool

    @property
    def holds(self) -> bool:
        """Whether it takes in small displacements, and rounding alone throws no robot off."""
        return self.stability == "attracting" and not self.grazes

    @property
    def period(self) -> int:
        """Contacts in one round."""
        return len(self.arcs_m)


@dataclass(frozen=True, kw_only=True, eq=False)
class LongRun:
    """What bouncing comes to: cycles, the one with most starts first; shares of starts that come to none, or stick.

    ``growth``: the mean growth, per bounce, of the logarithm of a small displacement, over starts that come to no cycle
    (NaN without any): above 0 they wander chaotically, at 0 they circle without ever closing. ``cycle_of`` (n,): the
    number of the cycle that each start comes to; -1: to none. ``lengths_m`` (n,): that cycle's length, of neutral
    families the member's own; 0 for what is stuck, NaN for what comes to no cycle.
    """

    cycles: tuple[PolygonCycle, ...]
    unsettled_share: float
    stuck_share: float
    growth: float
    cycle_of: Ints
    lengths_m: Floats


def random_starts(
    rim: Rim, count: int, seed: int, headings_rad: Sequence[float] | None = None
) -> tuple[Floats, Floats]:
    """Places (count, 2) in metres and headings (count,), uniform in where the disc fits; headings from those given."""
    rng = np.random.default_rng(seed)
    room = rim.free.buffer(-rim.body_radius_m, quad_segs=64)
    low_x, low_y, high_x, high_y = room.bounds
    shapely.prepare(room)
    places: list[Floats] = []
    while sum(map(len, places)) < count:
        tried = rng.uniform((low_x, low_y), (high_x, high_y), (2 * count, 2))
        places.append(tried[shapely.contains_xy(room, tried[:, 0], tried[:, 1])])
    if headings_rad is None:
        headings = rng.uniform(0, 2 * math.pi, count)
    else:
        headings = rng.choice(np.asarray(headings_rad, dtype=np.float64), count)
    return np.concatenate(places)[:count], headings


def limit_cycles(
    rim: Rim,
    rule: BounceRule,
    places_m: Floats,
    headings_rad: Floats,
    *,
    bounces: int = 2000,
    longest: int = 512,
) -> LongRun:
    """The cycles that discs come to from places (n, 2) with headings (n,); stability by the return map's derivative.

    A disc is on a cycle if after ``bounces`` contacts it comes back within ``longest`` more to where it was, to a
    ten-millionth of a metre. Newton's steps then find the cycle to rounding. Cycles are told apart by the walls they
    touch in turn, and for "turn" by the headings between, so that a neutral family counts as one cycle. With "turn"
    every first heading has cycles of its own, except those that turning by the bouncing angle leads to. Raises
    MissionError for no starts, and for a start at which the disc does not fit.
    """
    places = np.ascontiguousarray(places_m, dtype=np.float64).reshape(-1, 2)
    headings = np.ascontiguousarray(headings_rad, dtype=np.float64)
    if not len(places) or len(places) != len(headings):
        raise MissionError(f"starts: {len(places)} places and {len(headings)} headings; as many of both, at least one")
    require_room(rim, places)
    n = len(places)
    floats, ints = np.zeros((n, 4)), np.zeros((n, 4), dtype=np.int64)
    marks = np.zeros(n, dtype=np.uint64)
    first, turned = _first_headings(rule, headings)
    discs = Discs(places[:, 0].copy(), places[:, 1].copy(), first, turned)
    cycles_reached(rim.compiled, rule.compiled, discs, bounces, longest, CyclesReached(floats, ints, marks))
    settled = np.flatnonzero(ints[:, 0] == SETTLED)
    kinds = np.rint(first[settled] * 1e8).astype(np.int64) if rule.bounce == "turn" else np.zeros_like(settled)
    _, inverse, counts = np.unique(
        np.column_stack([marks[settled].view(np.int64), kinds]),
        axis=0, return_inverse=True, return_counts=True,
    )  # fmt: skip
    cycles = []
    for number, count in enumerate(counts):
        # of a neutral family a member away from corners, if one is among the first found
        for k in settled[inverse.ravel() == number][:_MEMBERS]:
            cycle = _cycle(rim, rule, float(first[k]), ints[k], floats[k], int(count) / n, n)
            if _of_slope(cycle.multiplier) != "neutral" or cycle.stability == "neutral":
                break
        cycles.append(cycle)
    order = sorted(range(len(cycles)), key=lambda c: (-cycles[c].share, cycles[c].period, cycles[c].length_m))
    place = np.empty(len(cycles), dtype=np.int64)
    place[order] = np.arange(len(cycles))
    cycle_of = np.full(n, -1, dtype=np.int64)
    cycle_of[settled] = place[inverse.ravel()]
    wandering = ~np.isin(ints[:, 0], (SETTLED, STUCK))
    return LongRun(
        cycles=tuple(cycles[c] for c in order),
        unsettled_share=float(wandering.mean()),
        stuck_share=float((ints[:, 0] == STUCK).mean()),
        growth=float(floats[wandering, 3].mean()) if wandering.any() else math.nan,
        cycle_of=cycle_of,
        lengths_m=np.where(wandering, np.nan, np.where(cycle_of >= 0, floats[:, 1], 0.0)),
    )


def _first_headings(rule: BounceRule, headings: Floats) -> tuple[Floats, Ints]:
    """First headings (n,) and numbers of turns (n,); headings that differ by whole turns share a first heading."""
    whole = rule.turns_to_whole
    if rule.bounce == "from_wall" or whole == 0:
        return headings, np.zeros(len(headings), dtype=np.int64)
    unit = 2 * math.pi / whole
    units = np.floor(headings / unit + 1e-9)
    step = round(rule.angle_rad / unit)  # without a common divisor with whole: it has an inverse
    return headings - units * unit, units.astype(np.int64) % whole * pow(step, -1, whole) % whole


def _cycle(
    rim: Rim, rule: BounceRule, first_heading: float, ints: Ints, floats: Floats, share: float, starts: int
) -> PolygonCycle:
    """The limit cycle that ``cycles_reached`` wrote for one start: ints (4,) and floats (4,)."""
    out = np.empty((int(ints[3]), 6))
    follow(rim.compiled, rule.compiled, first_heading, int(ints[1]), float(floats[0]), int(ints[2]), out)
    element, s_m = out[:, 0].astype(np.int64), out[:, 1]
    places_m, headings = rim.places_m(element, s_m), out[:, 3] % (2 * math.pi)
    in_corner = _touches(rim, places_m) > 1
    multiplier = float(floats[2])
    stability = _of_slope(multiplier)
    if in_corner.any():
        stability = _of_displaced(rim, rule, places_m, headings, np.flatnonzero(~in_corner))
    return PolygonCycle(
        arcs_m=rim.arcs_m(element, s_m),
        headings_rad=headings,
        positions_m=places_m,
        length_m=float(floats[1]),
        multiplier=multiplier,
        stability=stability,
        share=share,
        share_error=math.sqrt(share * (1 - share) / starts),
        grazes=rule.bounce == "turn" and _grazes(rim, places_m, headings),
    )


def _grazes(rim: Rim, places_m: Floats, headings: Floats) -> bool:
    """Whether a heading (p,), a little off on leaving its contact (p, 2), would be blocked there."""
    return any(
        is_blocked(rim.compiled, float(x), float(y), math.cos(heading + off), math.sin(heading + off))
        for (x, y), heading in zip(places_m, headings.tolist(), strict=True)
        for off in (-_GRAZING_RAD, _GRAZING_RAD)
    )


def _touches(rim: Rim, places_m: Floats) -> Ints:
    """(p,) how many walls and corners a disc at places (p, 2) touches."""
    rows, beside = rim.elements, places_m[:, None] - rim.elements[:, :2]
    along = (beside * rows[:, 2:4]).sum(axis=2)
    off_m = np.abs(beside[..., 1] * rows[:, 2] - beside[..., 0] * rows[:, 3] - rim.body_radius_m)
    walls = (off_m < _CORNER_M) & (along > -_CORNER_M) & (along < rows[:, 4] + _CORNER_M)
    arcs = np.abs(np.hypot(*beside.transpose(2, 0, 1)) - rim.body_radius_m) < _CORNER_M
    count: Ints = np.where(rim.kinds == WALL, walls, arcs).sum(axis=1)
    return count


def _of_slope(slope: float) -> Stability:
    """The stability of a cycle whose return map has a derivative."""
    if abs(abs(slope) - 1) <= _SAME_SLOPE:
        return "neutral"
    return "attracting" if abs(slope) < 1 else "repelling"


def _of_displaced(rim: Rim, rule: BounceRule, places_m: Floats, headings: Floats, marks: Ints) -> Stability:
    """The stability of a cycle by robots put beside the middle of each of its ways, to the left and to the right.

    places_m (p, 2), headings (p,): contacts, and headings on leaving them. marks: the contacts at which a robot's
    distance is measured; all, where none is given. A side on which the disc has no room is left out.
    """
    seen: set[str] = set()
    marks = marks if len(marks) else np.arange(len(places_m))
    for k, heading in enumerate(headings):
        middle = (places_m[k] + places_m[(k + 1) % len(places_m)]) / 2
        aside = _ASIDE_M * np.array([-math.sin(heading), math.cos(heading)])
        for start in (middle + aside, middle - aside):
            try:
                early, late = (_off_m(rim, rule, start, heading, places_m, headings, marks, n) for n in _ROUNDS)
            except MissionError:
                continue
            if late < _SAME_SHARE * _ASIDE_M or late < (1 - _SAME_SHARE) * early:
                seen.add("fades")
            else:
                seen.add("stays" if late < (1 + _SAME_SHARE) * early else "grows")
    if seen == {"fades"}:
        return "attracting"
    if "fades" in seen:
        return "half-stable"
    return "repelling" if "grows" in seen else "neutral"


def _off_m(
    rim: Rim,
    rule: BounceRule,
    start_m: Floats,
    heading: float,
    places_m: Floats,
    headings: Floats,
    marks: Ints,
    rounds: int,
) -> float:
    """The largest distance in metres of a robot from the marked contacts of a cycle in its last round; inf: lost."""
    bounces = 2 * len(places_m)  # in a round at most: in a corner it may touch both walls in turn
    path = bounce_path(rim, rule, (float(start_m[0]), float(start_m[1])), heading, rounds * bounces)
    contacts_m, left = path.positions_m[1:-1][-bounces:], path.headings_rad[1:][-bounces:]
    worst = 0.0
    for k in marks:
        same = np.abs((left - headings[k] + math.pi) % math.tau - math.pi) < 1e-6
        if not same.any():
            return math.inf
        worst = max(worst, float(np.hypot(*(contacts_m[same] - places_m[k]).T).min()))
    return worst
