"""Joint maps of bouncing robots, their cycles and basins: against scipy for two robots, and all of three robots'."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from benchmarks.bounce_maps import LESS_EIGHT, OPEN, cells_on
from benchmarks.row import Options, Row
from benchmarks.shell import python
from rota.compiled.kernel import allocation_free, always_inline
from rota.planners.bounce.bounce_map import (
    NOWHERE,
    Decomposition,
    cycles_and_basins,
    joint_map,
    make_team,
)
from rota.planners.bounce.kernels import Team, step_team
from rota.planners.bounce.map_kernels import Stays, any_too_near

Ints = NDArray[np.int32]
Longs = NDArray[np.int64]
Words = NDArray[np.uint32]

REPEATS = 9
LEAST_RATIO, MOST_S, MOST_BYTES = 5.0, 90.0, 4.5e9
THREE = "from benchmarks.bounce_joint_maps import three_robots; three_robots()"


def bounce_map(options: Options) -> Iterator[Row]:
    """Processor times: two robots in one run with scipy, three in a process of their own for its memory."""
    yield two_robots()
    run = python("-c", THREE)
    name, asked = (
        "bounce, 3 robots, 10 x 10 open, 512 million joint states as 85 million unordered sets",
        "< 90 s, < 4.5 GB",
    )
    if run.code != 0:
        yield Row(name, asked, run.failure(), False)
        return
    reached = run.cpu_s < MOST_S and run.peak_bytes < MOST_BYTES
    yield Row(name, asked, f"{run.out.strip()}; {run.cpu_s:.1f} s in all, peak {run.peak_bytes / 1e9:.2f} GB", reached)


def two_robots() -> Row:
    """Successor map, cycles and basins of two robots that are told apart; scipy is given the successors."""
    team = make_team(cells_on(LESS_EIGHT), [3, 3])
    successor = joint_map(team)
    cycles_and_basins(successor.copy())  # compiles
    ours, theirs = [], []
    for _ in range(REPEATS):
        ours.append(cpu_s(lambda: cycles_and_basins(joint_map(team))))
        theirs.append(cpu_s(lambda: by_scipy(successor)))
    mine, their = statistics.median(ours), statistics.median(theirs)
    measured = f"{their / mine:.1f} x ({mine * 1e3:.1f} ms, scipy {their * 1e3:.0f} ms without the successor map)"
    name = f"bounce, 2 robots, {len(successor):,} joint states: successor map, cycles and basins, against scipy"
    return Row(name, f"> {LEAST_RATIO:.0f} x", measured, their / mine > LEAST_RATIO)


def by_scipy(successor: NDArray[np.uint32]) -> tuple[int, int]:
    """Basins are the weak components of the map's graph, cycles its strong ones of more than one state, or a loop."""
    real = np.flatnonzero(successor != NOWHERE)
    shape = (len(successor), len(successor))
    graph = csr_matrix((np.ones(len(real), np.int8), (real, successor[real].astype(np.int32))), shape=shape)
    basins, _ = connected_components(graph, connection="weak")
    strong, _ = connected_components(graph, connection="strong")
    return int(basins), int(strong)


def three_robots() -> None:
    """All of three equal robots on an open grid, taken as unordered; prints what that gives for ordered ones."""
    team = make_team(cells_on(OPEN), [3, 3, 3])
    began_s = time.process_time()
    found = cycles_and_basins(map_of_sets(team))
    counts, _, basins = tell_apart(team, found)
    taken_s = time.process_time() - began_s
    states, cycles = int((counts * basins).sum()), int(counts.sum())
    print(f"{taken_s:.1f} s for {cycles:,} cycles with basins of {states:,} states together")


def cpu_s(work: Callable[[], object]) -> float:
    """Processor seconds of a call."""
    began_s = time.process_time()
    work()
    return time.process_time() - began_s


def tell_apart(team: Team, decomposition: Decomposition) -> tuple[Longs, Longs, Longs]:
    """Cycles of robots that are told apart, from the decomposition of the unordered map.

    Going once round a cycle of sets may exchange robots; r rounds bring each back to its own state. Over a cycle of
    sets lie m! / r cycles of the ordered map, each r times as long and with r times its basin. Returns their number,
    length and basin, (c,) each. The unordered map has about m! times fewer states.
    """
    m, s = len(team.bumped), len(team.x)
    cycles = np.ascontiguousarray(np.column_stack([decomposition.first, decomposition.length]))
    states, after, begin = (np.empty(m, np.int32) for _ in range(3))
    rounds = np.empty(len(cycles), np.int64)
    rounds_to_order(team, binomials(s, m), cycles, states, after, np.empty(m, np.int8), begin, rounds)
    return math.factorial(m) // rounds, decomposition.length * rounds, decomposition.basin * rounds


@allocation_free
def rounds_to_order(
    team: Team, choose: Longs, cycles: Longs, states: Ints, after: Ints, stays: Stays, begin: Ints, rounds: Longs
) -> None:
    """How many times round its cycle a set of states must go until every robot is back in its own state.

    cycles: (c, 2), rank of a state and length of each. rounds: (c,), written. The others: (m,) scratch.
    """
    m = len(states)
    for c in range(len(cycles)):
        rank = cycles[c, 0]
        for i in range(m - 1, -1, -1):
            low, high = i, len(choose) - 1  # the largest state of which no more than rank sets are below
            while high - low > 1:
                middle = (low + high) // 2
                if choose[middle, i + 1] <= rank:
                    low = middle
                else:
                    high = middle
            states[i] = low
            rank -= choose[low, i + 1]
        for i in range(m):
            begin[i] = states[i]
        turns = 0
        while True:
            for _ in range(cycles[c, 1]):
                step_team(team, states, stays, after)
                for i in range(m):
                    states[i] = after[i]
            turns += 1
            same = True
            for i in range(m):
                same = same and states[i] == begin[i]
            if same:
                break
        rounds[c] = turns


def map_of_sets(team: Team) -> Words:
    """Successors of all sets of states of equal robots that are not told apart, (choose(s, m),) uint32."""
    m, s = len(team.bumped), len(team.x)
    successor = np.empty(math.comb(s, m), np.uint32)
    states, after, stays = np.zeros(m, np.int32), np.empty(m, np.int32), np.empty(m, np.int8)
    set_successors(team, binomials(s, m), states, after, stays, successor)
    return successor


def binomials(states: int, robots: int) -> Longs:
    """(states + 1, robots + 1) binomial coefficients."""
    table = np.zeros((states + 1, robots + 1), np.int64)
    table[:, 0] = 1
    for k in range(1, robots + 1):
        table[1:, k] = np.cumsum(table[:-1, k - 1])
    return table


@always_inline
def rank_of(states: Ints, choose: Longs) -> int:
    """The rank of a set of states, which are sorted in place. choose: (s + 1, m + 1) binomial coefficients."""
    for i in range(1, len(states)):
        value, k = states[i], i
        while k > 0 and states[k - 1] > value:
            states[k] = states[k - 1]
            k -= 1
        states[k] = value
    rank = 0
    for i in range(len(states)):
        rank += choose[states[i], i + 1]
    return rank


@allocation_free
def set_successors(team: Team, choose: Longs, states: Ints, after: Ints, stays: Stays, successor: Words) -> None:
    """The successor of every set of states of m equal robots, by rank: (choose(s, m),) uint32."""
    m = len(states)
    for i in range(m):
        states[i] = i
    for rank in range(len(successor)):
        if any_too_near(team, states):
            successor[rank] = NOWHERE
        else:
            step_team(team, states, stays, after)
            successor[rank] = rank_of(after, choose)
        # the next set in the order of ranks
        i = 0
        while i + 1 < m and states[i] + 1 == states[i + 1]:
            states[i] = i
            i += 1
        states[i] += 1
