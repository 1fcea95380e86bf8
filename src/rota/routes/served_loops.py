"""The loops that robots serve in turns, read from their flights: each loop once, and the ways to it and back.

A plan says when robots charge, and not what for. Of a flight that serves whole rounds, the way back is the way out
driven back; of one that serves a part of a round, its way back is the way out of the robot that relieves it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rota.model.plan import Floats
from rota.routes.flights import Flight

SAME_M = 1e-6
STANDS = 0.5  # of a flight, in the middle of it: the robot serves a place, and no loop


@dataclass(frozen=True, kw_only=True, eq=False)
class ServedLoop:
    """A loop that robots take turns at. line_m: (n, 2), closed; one point where they stand there.

    round_s: what a round takes; 0 where they stand. handovers_m: (k, 2), where they come to it. robots: their names.
    """

    line_m: Floats
    round_s: float
    handovers_m: Floats
    robots: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Service:
    """The loops that flights serve. serves: (flights,) which loop; ways_m: the ways to loops and back, each once.

    spans_s: (flights, 2), seconds after taking off at which each comes to its loop and leaves it.
    """

    loops: tuple[ServedLoop, ...]
    serves: tuple[int, ...]
    spans_s: Floats
    ways_m: tuple[Floats, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Turn:
    """What a flight drives between its ways: times_s (k,) and line_m (k, 2)."""

    times_s: Floats
    line_m: Floats

    @property
    def closes(self) -> bool:
        return _same(self.line_m[0], self.line_m[-1])


def service_of(flights: Sequence[Flight]) -> Service:
    """The loops that the flights of a plan serve, in the order in which robots of the plan come to them."""
    kinds, kind_of = _kinds(flights)
    cuts = [_cut(kind, kinds) for kind in kinds]
    turns = [
        _Turn(times_s=kind.times_s[a : b + 1], line_m=_flat(kind)[a : b + 1])
        for kind, (a, b) in zip(kinds, cuts, strict=True)
    ]
    rounds: list[tuple[list[int], Floats, float]] = []  # kinds of flights, line, seconds of a round
    for members in _chains(turns):
        line_m, round_s = _one_round([turns[k] for k in members])
        alike = next((each for each in rounds if _same_loop(each[1], line_m)), None)
        if alike is None:
            rounds.append((members, line_m, round_s))
        else:
            alike[0].extend(members)
    loop_of = {kind: number for number, (members, _, _) in enumerate(rounds) for kind in members}
    serves = tuple(loop_of[kind] for kind in kind_of)
    loops = tuple(
        ServedLoop(
            line_m=line_m,
            round_s=round_s,
            handovers_m=_distinct([turns[k].line_m[0] for k in members]),
            robots=tuple(dict.fromkeys(f.robot for f, at in zip(flights, serves, strict=True) if at == number)),
        )
        for number, (members, line_m, round_s) in enumerate(rounds)
    )
    spans_s = np.array([kinds[kind].times_s[list(cuts[kind])] for kind in kind_of]).reshape(-1, 2)
    return Service(loops=loops, serves=serves, spans_s=spans_s, ways_m=_ways(kinds, cuts))


def loop_letter(number: int) -> str:
    """What the loop of a number from 0 on is called: A to Z, then AA and so on."""
    head, last = divmod(number, 26)
    return (loop_letter(head - 1) if head else "") + chr(ord("A") + last)


def _flat(flight: Flight) -> Floats:
    return flight.positions_m[:, :2]


def _same(one: Floats, other: Floats) -> bool:
    return one.shape == other.shape and bool(np.abs(one - other).max(initial=0.0) < SAME_M)


def _kinds(flights: Sequence[Flight]) -> tuple[list[Flight], list[int]]:
    """The flights that differ in more than when they begin, and of which of these kinds each is."""
    kinds: list[Flight] = []
    kind_of = []
    for flight in flights:
        for k, kind in enumerate(kinds):
            if abs(kind.lasts_s - flight.lasts_s) < SAME_M * max(1.0, kind.lasts_s) and _goes_along(flight, kind):
                # points on straight legs are not in all of them
                kinds[k] = max(kind, flight, key=lambda each: len(each.times_s))
                kind_of.append(k)
                break
        else:
            kind_of.append(len(kinds))
            kinds.append(flight)
    return kinds, kind_of


def _goes_along(one: Flight, other: Flight) -> bool:
    """Whether one is where the other is at the times of both."""
    times_s = np.union1d(one.times_s, other.times_s)
    off = [
        np.interp(times_s, one.times_s, _flat(one)[:, axis]) - np.interp(times_s, other.times_s, _flat(other)[:, axis])
        for axis in (0, 1)
    ]
    return bool(np.abs(off).max() < 10 * SAME_M * max(1.0, float(np.abs(_flat(one)).max())))


def _cut(kind: Flight, kinds: Sequence[Flight]) -> tuple[int, int]:
    """The indices of a flight's points at which its way out ends and its way back begins."""
    line_m = _flat(kind)
    last = len(line_m) - 1
    out = max(_shared_points(line_m, _flat(other)[::-1]) for other in kinds)
    back = max(_shared_points(line_m[::-1], _flat(other)) for other in kinds)
    begins, ends = max(out, 1) - 1, last - (max(back, 1) - 1)
    if begins < ends:
        return begins, ends
    # there and back the same way: what stands in the middle is served, or all but the first leg
    middle = last // 2
    stays_s = float(kind.times_s[last - middle] - kind.times_s[middle])
    if last - middle > middle and stays_s > STANDS * kind.lasts_s:
        return middle, last - middle
    return (1, last - 1) if last >= 4 else (0, last)


def _shared_points(one: Floats, other: Floats) -> int:
    """How many points two lines have in common from their beginnings on."""
    count = min(len(one), len(other))
    differs = np.abs(one[:count] - other[:count]).max(axis=1) >= SAME_M
    return int(np.argmax(differs)) if differs.any() else count


def _chains(turns: Sequence[_Turn]) -> list[list[int]]:
    """Turns that make up rounds: each that closes by itself, and parts that go on where others end."""
    chains = [[k] for k, turn in enumerate(turns) if turn.closes]
    parts = [k for k, turn in enumerate(turns) if not turn.closes]
    while parts:
        chain = [parts.pop(0)]
        while not _same(turns[chain[0]].line_m[0], end_m := turns[chain[-1]].line_m[-1]):
            after = next((k for k in parts if _same(turns[k].line_m[0], end_m)), None)
            if after is None:
                break
            parts.remove(after)
            chain.append(after)
        chains.append(chain)
    return sorted(chains)


def _one_round(turns: Sequence[_Turn]) -> tuple[Floats, float]:
    """The line (n, 2) of one round of a turn, or of turns that make one up, and its seconds."""
    line_m = np.vstack([turns[0].line_m[:1], *(turn.line_m[1:] for turn in turns)])
    lasts_s = float(sum(turn.times_s[-1] - turn.times_s[0] for turn in turns))
    if np.abs(line_m - line_m[0]).max() < SAME_M:
        return line_m[:1], 0.0
    legs = len(line_m) - 1
    for count in range(legs, 1, -1):
        k = legs // count
        if legs % count == 0 and _same(line_m[k:], line_m[:-k]):
            return line_m[: k + 1], lasts_s / count
    return line_m, lasts_s


def _same_loop(one: Floats, other: Floats) -> bool:
    """Whether two closed lines are the same loop the same way round, wherever it begins."""
    if len(one) == 1 or len(other) == 1:
        return _same(one, other)
    ring, its = corners(one), corners(other)
    return same_ring(ring, its) if len(ring) else _same(one, other)


def corners(loop_m: Floats) -> Floats:
    """The corners (n, 2) of a closed polyline (first point again at the end), without waits and points on a leg."""
    ring: Floats = loop_m[:-1]
    steps = np.roll(ring, -1, axis=0) - ring
    ring = ring[np.hypot(*steps.T) > SAME_M]
    if len(ring) < 3:
        return ring
    ahead, behind = np.roll(ring, -1, axis=0) - ring, ring - np.roll(ring, 1, axis=0)
    cross = behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0]
    straight = (np.abs(cross) <= SAME_M * np.hypot(*ahead.T)) & ((behind * ahead).sum(axis=1) > 0)
    kept: Floats = ring[~straight]
    return kept


def same_ring(one: Floats, other: Floats) -> bool:
    """Whether two rings of corners are equal up to the corner they begin with."""
    if len(one) != len(other) or not len(one):
        return False
    for shift in np.flatnonzero(np.abs(other - one[0]).max(axis=1) < SAME_M):
        if np.abs(np.roll(other, -int(shift), axis=0) - one).max() < SAME_M:
            return True
    return False


def _distinct(places_m: Sequence[Floats]) -> Floats:
    kept: list[Floats] = []
    for place_m in places_m:
        if not any(_same(place_m, other) for other in kept):
            kept.append(place_m)
    return np.array(kept).reshape(-1, 2)


def _ways(kinds: Sequence[Flight], cuts: Sequence[tuple[int, int]]) -> tuple[Floats, ...]:
    """The ways (n, 2) between chargers and loops, whichever way they are driven, each once."""
    found: list[Floats] = []
    for kind, (begins, ends) in zip(kinds, cuts, strict=True):
        for line_m in (_flat(kind)[: begins + 1], _flat(kind)[ends:][::-1]):
            if len(line_m) > 1 and not any(_same(line_m, other) for other in found):
                found.append(line_m)
    return tuple(found)
