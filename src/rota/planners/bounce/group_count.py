"""How many periodic groups a team has that watch all zones without contact: exact, without a joint map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.model.arrays import Flags, Ints
from rota.planners.bounce.clique_kernels import Graph, Room, count_sets
from rota.planners.bounce.limit_cycles import LimitCycles

UNBOUNDED = 1 << 62
GRAPH_WORK, CALL_WORK = 100, 1000  # pairs of nodes, and words of conflicts, that are a unit of work
TABLE = 1 << 14  # sets that the count remembers
PRIMES = (2147483647, 2147483629, 2147483587, 2147483579, 2147483563, 2147483549, 2147483543, 2147483497)


class TooMany(Exception):  # noqa: N818 (an outcome: the caller goes on without the count)
    """The count takes more work than was allowed."""


@dataclass
class Work:
    """Units of work that a count may still take, of about a microsecond each."""

    left: int = UNBOUNDED

    def spend(self, units: int) -> None:
        """Spend units of work; raises TooMany when fewer are left."""
        self.left -= units
        if self.left < 0:
            raise TooMany


def count_groups(cycles: LimitCycles, sees: Flags, *, most_work: int = UNBOUNDED) -> int:
    """The number of periodic groups of the team, robots told apart, whose robots together enter every zone.

    sees: (p, z) whether periodic states lie in zones. A group is a class of joint periodic states under time; it has as
    many states as the least common multiple of its cycles' lengths. So states are counted for each such multiple: teams
    on cycles whose lengths divide it, less those of smaller multiples. Zones are counted by inclusion and exclusion.

    Raises TooMany when that takes more than ``most_work`` units, see ``Work``, or more digits than the primes hold.
    """
    wanted = np.bincount(cycles.kind_of_robot)
    seen = np.array([sees[cycles.cycle == c].any(axis=0) for c in range(len(cycles.length))]).reshape(
        len(cycles.length), -1
    )
    work = Work(most_work)
    groups = 0
    exact: dict[int, int] = {}
    known: dict[bytes, int] = {}
    for period in _common_periods(cycles.length.tolist(), int(wanted.sum()), work):
        states = 0
        work.spend(len(exact) // 10)
        for mask, sign in _signed_choices(period % cycles.length == 0, seen, work).items():
            if mask not in known:
                known[mask] = _joint_states(cycles, np.frombuffer(mask, np.bool_), wanted, work)
            states += sign * known[mask]
        states -= sum(number for smaller, number in exact.items() if period % smaller == 0)
        exact[period] = states
        groups += states // period
    return groups


def _signed_choices(divides: Flags, seen: Flags, work: Work) -> dict[bytes, int]:
    """Choices (c,) of cycles that stay away from some zones, as bytes, and the sign with which each counts.

    By inclusion and exclusion a choice has the sign of the number of zones left out. Equal choices are added up.
    """
    signs = {divides.tobytes(): 1}
    for away in ~seen.T:
        for mask, sign in list(signs.items()):
            less = (np.frombuffer(mask, np.bool_) & away).tobytes()
            signs[less] = signs.get(less, 0) - sign
        signs = {mask: sign for mask, sign in signs.items() if sign != 0 and any(mask)}
        work.spend(2 * len(signs))
    return signs


def _common_periods(lengths: list[int], robots: int, work: Work) -> list[int]:
    """Least common multiples of at most ``robots`` of the lengths, rising."""
    periods = {1}
    for _ in range(min(robots, len(set(lengths)))):
        work.spend(len(periods) * len(set(lengths)) // 4)
        periods |= {math.lcm(period, length) for period in periods for length in set(lengths)}
    return sorted(periods)


def _joint_states(cycles: LimitCycles, allowed: Flags, wanted: Ints, work: Work) -> int:
    """Joint periodic states without contact ever, robots told apart, on the cycles (c,) that are allowed."""
    nodes = np.flatnonzero(allowed[cycles.cycle])
    if len(nodes) == 0 or (np.bincount(cycles.kind[nodes], minlength=len(wanted)) == 0).any():
        return 0
    sets = count_independent(~cycles.compatible[np.ix_(nodes, nodes)], cycles.kind[nodes], wanted, work)
    return sets * math.prod(math.factorial(int(number)) for number in wanted)


def count_independent(
    conflict: Flags, kind: NDArray[np.int32], wanted: Sequence[int] | Ints, work: Work | None = None
) -> int:
    """Sets of nodes without a conflict, with ``wanted`` ones of each kind. conflict: (v, v), the diagonal set.

    Raises TooMany when that takes more work than is left, or more digits than there are primes for.
    """
    work = work or Work()
    work.spend(len(kind) ** 2 // GRAPH_WORK)
    limits = [int(number) for number in wanted]
    useful = np.array(limits)[kind] > 0
    if not useful.all():
        conflict, kind = conflict[np.ix_(useful, useful)], kind[useful]
    graph, words = _graph(conflict, kind, limits)
    bound = math.prod(math.comb(int((kind == k).sum()), number) for k, number in enumerate(limits))
    moduli = [2**64, *PRIMES[: max(0, math.ceil((bound.bit_length() - 63) / 30))]]
    if math.prod(moduli) <= bound:
        raise TooMany(f"up to {bound} sets are more than can be counted")
    robots = sum(limits)
    remainders = [_count_modulo(graph, words, robots, prime % 2**64, work) for prime in moduli]
    value, modulus = 0, 1
    for remainder, divisor in zip(remainders, moduli, strict=True):
        # the next value that also leaves this remainder
        value += modulus * ((remainder - value) * pow(modulus, -1, divisor) % divisor)
        modulus *= divisor
    return value


def _graph(conflict: Flags, kind: NDArray[np.int32], limits: list[int]) -> tuple[Graph, int]:
    """The conflicts as bits, nodes of a kind with the same conflicts taken as one."""
    features = np.column_stack([conflict, kind[:, None] == np.arange(len(limits))])
    packed = np.packbits(features, axis=1)
    rows = packed.view(np.dtype((np.void, packed.shape[1]))).ravel()  # compared whole, not byte by byte
    _, first, weight = np.unique(rows, return_index=True, return_counts=True)
    count = len(first)
    words = (count + 63) // 64
    bits = np.zeros((count, 64 * words), np.bool_)
    bits[:, :count] = conflict[np.ix_(first, first)]
    stride = np.cumprod([1, *(limit + 1 for limit in limits[:-1])])
    size = math.prod(limit + 1 for limit in limits)
    powers = np.array([np.arange(size) // s % (limit + 1) for s, limit in zip(stride, limits, strict=True)])
    within = (powers[:, :, None] + powers[:, None, :] <= np.array(limits)[:, None, None]).all(axis=0)
    total = np.where(within, np.add.outer(np.arange(size), np.arange(size)), -1)
    graph = Graph(
        conflict=np.packbits(bits, axis=1, bitorder="little").view(np.uint64),
        weight=weight.astype(np.uint64),
        kind=kind[first].astype(np.int32),
        stride=stride.astype(np.int32),
        total=total.astype(np.int32),
    )
    return graph, words


def _count_modulo(graph: Graph, words: int, robots: int, prime: int, work: Work) -> int:
    """The count modulo a prime, or modulo 2 ** 64 for 0."""
    count, size, depth = len(graph.weight), len(graph.total), 2 * len(graph.weight) + 4
    each = 1 + count * words // CALL_WORK
    most_calls = work.left // each
    room = Room(
        sets=np.zeros((depth, words), np.uint64),
        scratch=np.zeros((depth, size), np.uint64),
        polynomials=np.zeros((2, depth, size), np.uint64),
        known=np.zeros((TABLE, words), np.uint64),
        known_for=np.zeros(TABLE, np.int32),
        worth=np.zeros((TABLE, size), np.uint64),
        calls=np.array([most_calls], np.int64),
    )
    all_nodes = np.zeros(64 * words, np.bool_)
    all_nodes[:count] = True
    room.sets[0] = np.packbits(all_nodes, bitorder="little").view(np.uint64)
    count_sets(graph, room, 0, robots, np.uint64(prime))
    work.spend((most_calls - int(room.calls[0])) * each)
    return int(room.polynomials[0, 0, size - 1])
