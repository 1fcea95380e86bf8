"""Which rounds are driven as one, and by how many robots each, where other robots drove them before."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rota.model.arrays import Floats
from rota.planners.patrol.handover.rounds import Round


@dataclass(frozen=True)
class Share:
    """Rounds, by their numbers, that so many robots drive as one."""

    rounds: tuple[int, ...]
    robots: int


Sharing = tuple[Share, ...]


def sharings(
    rounds: Sequence[Round],
    names: Sequence[str],
    between_m: Floats,
    speed_m_s: float,
    most: int,
    importance: Sequence[float] = (),
) -> list[Sharing]:
    """How robots of these names may share the rounds, at most so many: the one expected to be late least comes first.

    Where each robot comes round as often as before, or more often, a round is as good as it was. Of as good ones that
    comes first in which fewer robots change. importance: of each round; then more important rounds are to be late
    least first, and rounds that are less important than others may be left to nobody.
    """
    matters = list(importance) or [0.0] * len(rounds)
    levels = sorted(set(matters), reverse=True)
    ranked: list[tuple[tuple[float, ...], Sharing]] = []
    for least in levels:
        kept = [k for k, own in enumerate(matters) if own >= least]
        team = _Team([rounds[k] for k in kept], names, between_m[np.ix_(kept, kept)], speed_m_s)
        for sharing, loads, changed in team.sharings():
            named = tuple(Share(tuple(kept[k] for k in share.rounds), share.robots) for share in sharing)
            worst = [
                max((load for share, load in zip(named, loads, strict=True) if _matters(share, matters) == level),
                    default=1.0 if level >= least else np.inf)
                for level in levels
            ]  # fmt: skip
            ranked.append(((*(max(load, 1.0) for load in worst), changed), named))
    ranked.sort(key=lambda one: one[0])
    return list(dict.fromkeys(sharing for _, sharing in ranked))[:most]


def _matters(share: Share, matters: Sequence[float]) -> float:
    """The importance of a share: of its most important round."""
    return max(matters[k] for k in share.rounds)


@dataclass(frozen=True, kw_only=False, eq=False)
class _Team:
    """Robots, by their names, that are to share all of some rounds, which lie so far from each other."""

    rounds: Sequence[Round]
    names: Sequence[str]
    between_m: Floats
    speed_m_s: float

    def sharings(self) -> Iterator[tuple[Sharing, list[float], float]]:
        """Ways to share them, how many times as rarely as before each share is driven, and how much changes."""
        rounds, names = self.rounds, self.names
        for parts in _partitions(rounds, len(names), self.between_m):
            durations_s = [_duration_s(part, rounds, self.between_m, self.speed_m_s) for part in parts]
            before = [[len(rounds[k].ahead_s) for k in part] for part in parts]
            # how many times as rarely as before each of the rounds is driven with one robot
            loads = [
                max(duration_s * count / max(rounds[k].duration_s, 1e-9) for k, count in zip(part, counts, strict=True))
                for part, counts, duration_s in zip(parts, before, durations_s, strict=True)
            ]
            here = [sum(name in rounds[k].ahead_s for k in part for name in names) for part in parts]
            for counts in _counts(loads, here, len(names)):
                moved = sum(max(0, count - own) for count, own in zip(counts, here, strict=True))
                joined = sum(len(part) - 1 for part in parts)
                sharing = tuple(Share(part, count) for part, count in zip(parts, counts, strict=True))
                yield sharing, [load / count for load, count in zip(loads, counts, strict=True)], moved + joined


def _counts(loads: Sequence[float], here: Sequence[int], robots: int) -> Iterator[list[int]]:
    """Robots for each of the parts: as they are there, and so that the greatest load is least."""
    least = [1] * len(loads)
    for _ in range(robots - len(loads)):
        k = max(range(len(loads)), key=lambda k: (loads[k] / least[k], -k))
        least[k] += 1
    yield least
    as_here = [max(1, own) for own in here]
    spare = robots - sum(as_here)
    while spare > 0:
        k = max(range(len(loads)), key=lambda k: (loads[k] / as_here[k], -k))
        as_here[k] += 1
        spare -= 1
    while spare < 0 and max(as_here) > 1:
        k = min((k for k in range(len(loads)) if as_here[k] > 1), key=lambda k: (loads[k] / (as_here[k] - 1), k))
        as_here[k] -= 1
        spare += 1
    if spare == 0:
        yield as_here


def _duration_s(part: Sequence[int], rounds: Sequence[Round], between_m: Floats, speed_m_s: float) -> float:
    """About how long a round of all these takes: each of them, and the ways to the nearest one and back."""
    inside, ways_m = [part[0]], 0.0
    for k in part[1:]:
        ways_m += 2 * min(float(between_m[k, other]) for other in inside)
        inside.append(k)
    return sum(rounds[k].duration_s for k in part) + ways_m / speed_m_s


def _partitions(rounds: Sequence[Round], robots: int, between_m: Floats) -> Iterator[list[tuple[int, ...]]]:
    """Ways to join rounds to at most so many; of very many rounds one way for each number, the nearest joined first."""
    numbers = list(range(len(rounds)))
    reachable = np.isfinite(between_m)
    if len(rounds) <= 7:  # every way to join them is looked at
        for parts in _set_partitions(numbers):
            if len(parts) <= robots and all(reachable[np.ix_(part, part)].all() for part in parts):
                yield parts
        return
    parts = [(k,) for k in numbers]
    while len(parts) > 1:
        if len(parts) <= robots:
            yield list(parts)
        costs = {
            (i, j): sum(rounds[k].duration_s for k in (*parts[i], *parts[j]))
            for i in range(len(parts))
            for j in range(i)
            if reachable[np.ix_(parts[i], parts[j])].all()
        }
        if not costs:
            return
        i, j = min(costs, key=lambda pair: (costs[pair], pair))
        parts = [part for k, part in enumerate(parts) if k not in (i, j)] + [(*parts[j], *parts[i])]
    if len(parts) <= robots:
        yield parts


def _set_partitions(numbers: list[int]) -> Iterator[list[tuple[int, ...]]]:
    """Every way to put numbers into parts."""
    if not numbers:
        yield []
        return
    first, rest = numbers[0], numbers[1:]
    for parts in _set_partitions(rest):
        yield [(first,), *parts]
        for k in range(len(parts)):
            yield [*parts[:k], (first, *parts[k]), *parts[k + 1 :]]
