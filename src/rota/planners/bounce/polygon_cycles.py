"""Limit cycles of the bounce map in the plane: where robots end up, how stable it is, and from how many starts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely

from rota.errors import MissionError
from rota.planners.bounce.polygon import BounceRule, Floats, Ints, Rim, require_room
from rota.planners.bounce.polygon_kernels import SETTLED, STUCK, follow, settle

Stability = Literal["attracting", "neutral", "repelling"]
_SAME_SLOPE = 1e-7


@dataclass(frozen=True, kw_only=True, eq=False)
class PolygonCycle:
    """A closed way of bouncing; of a neutral family, the member found first.

    arcs_m, headings_rad (p,): the contacts and the headings on leaving them; positions_m (p, 2) the centres there.
    ``multiplier``: derivative of the return map along the rim, by which a small displacement grows in every round, with
    headings held. ``share`` of the starts that come to it (or to its family), +- ``share_error`` (one standard error).
    """

    arcs_m: Floats
    headings_rad: Floats
    positions_m: Floats
    length_m: float
    multiplier: float
    share: float
    share_error: float

    @property
    def period(self) -> int:
        """Contacts in one round."""
        return len(self.arcs_m)

    @property
    def stability(self) -> Stability:
        """What becomes of a small displacement along the rim: it fades, stays or grows."""
        size = abs(self.multiplier)
        if abs(size - 1) <= _SAME_SLOPE:
            return "neutral"
        return "attracting" if size < 1 else "repelling"


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
    """The cycles that discs come to from places (n, 2) with headings (n,), stability from the return map's derivative.

    After ``bounces`` contacts a disc that comes back within ``longest`` more to where it was, to a ten-millionth of a
    metre, is on a cycle; Newton's steps then find it to rounding. Cycles are told apart by the walls they touch in
    turn and by the headings between ("turn"), so that a neutral family counts as one cycle; with "turn", every first
    heading has cycles of its own, but for those that turning by the bouncing angle leads to.
    Raises MissionError for no starts, or one at which the disc does not fit.
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
    settle(
        rim.elements, rim.kinds, rim.body_radius_m, rule.number, rule.angle_rad, rule.turns_to_whole,
        places[:, 0].copy(), places[:, 1].copy(), first, turned, bounces, longest, floats, ints, marks,
    )  # fmt: skip
    settled = np.flatnonzero(ints[:, 0] == SETTLED)
    kinds = np.rint(first[settled] * 1e8).astype(np.int64) if rule.bounce == "turn" else np.zeros_like(settled)
    _, chosen, inverse, counts = np.unique(
        np.column_stack([marks[settled].view(np.int64), kinds]),
        axis=0, return_index=True, return_inverse=True, return_counts=True,
    )  # fmt: skip
    cycles = [
        _cycle(rim, rule, float(first[k]), ints[k], floats[k], int(count) / n, n)
        for k, count in zip(settled[chosen], counts, strict=True)
    ]
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
    """Headings (n,) as first headings and numbers of turns: headings that differ by whole turns share the first one."""
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
    out = np.empty((int(ints[3]), 6))
    follow(
        rim.elements, rim.kinds, rim.body_radius_m, rule.number, rule.angle_rad, rule.turns_to_whole,
        first_heading, int(ints[1]), float(floats[0]), int(ints[2]), out,
    )  # fmt: skip
    element, s_m = out[:, 0].astype(np.int64), out[:, 1]
    return PolygonCycle(
        arcs_m=rim.arcs_m(element, s_m),
        headings_rad=out[:, 3] % (2 * math.pi),
        positions_m=rim.places_m(element, s_m),
        length_m=float(floats[1]),
        multiplier=float(floats[2]),
        share=share,
        share_error=math.sqrt(share * (1 - share) / starts),
    )
