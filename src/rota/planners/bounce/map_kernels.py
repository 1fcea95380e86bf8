# mypy: disable-error-code="no-any-return"
"""Compiled loops over all states of a team: the successor map, and its cycles and basins, four bytes for each state."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rota.compiled.kernel import allocation_free, always_inline
from rota.planners.bounce.arrays import Ints, Longs
from rota.planners.bounce.kernels import Team, step_team, too_near, touching

Words = NDArray[np.uint32]
Stays = NDArray[np.int8]

LABEL = np.uint32(0x80000000)  # set: the entry is no successor any more but the number of a cycle
ON_PATH = np.uint32(0xFFFFFFFE)
NOWHERE = np.uint32(0xFFFFFFFF)  # two robots in one place: no state at all
MOST_STATES = 0x7FFFFFFE


@always_inline
def any_too_near(team: Team, states: Ints) -> bool:
    """Whether two of the robots cannot be in these states at once."""
    overlap = False
    for i in range(len(states)):
        for j in range(i):
            a, b = states[i], states[j]
            if too_near(team.x[a], team.y[a], team.x[b], team.y[b], team.apart2[j, i]):
                overlap = True
    return overlap


@allocation_free
def successors(team: Team, states: Ints, after: Ints, stays: Stays, successor: Words, free: bool) -> None:
    """Fill ``successor``, (n,) uint32, with the successors of n packed states of m robots, from ``states`` (m,) on.

    ``states``: left at the one after the last. after, stays: (m,) scratch. free: a contact leads NOWHERE, so that only
    ways without contact are left.
    """
    m, s = len(states), len(team.x)
    for code in range(len(successor)):
        if any_too_near(team, states):
            successor[code] = NOWHERE
        else:
            contacts = step_team(team, states, stays, after)
            packed = 0
            for i in range(m - 1, -1, -1):
                packed = packed * s + after[i]
            successor[code] = NOWHERE if free and contacts > 0 else np.uint32(packed)
        for i in range(m):
            states[i] += 1
            if states[i] < s:
                break
            states[i] = 0


@allocation_free
def pair_successors(team: Team, successor: Words, free: bool) -> None:
    """The same for two robots."""
    s, apart2 = len(team.x), team.apart2[0, 1]
    for b in range(s):
        bx, by, bu, bv = team.x[b], team.y[b], team.to_x[b], team.to_y[b]
        turned = team.bumped[1, b]
        alone = team.moved[b] if team.moved[b] >= 0 else turned
        for a in range(s):
            ax, ay = team.x[a], team.y[a]
            if too_near(ax, ay, bx, by, apart2):
                successor[b * s + a] = NOWHERE
            elif touching((ax, ay, team.to_x[a], team.to_y[a]), (bx, by, bu, bv), apart2):
                successor[b * s + a] = NOWHERE if free else np.uint32(turned * s + team.bumped[0, a])
            else:
                successor[b * s + a] = alone * s + (team.moved[a] if team.moved[a] >= 0 else team.bumped[0, a])


@allocation_free
def decompose(successor: Words, path: Words, progress: Longs, cycles: Longs) -> int:
    """Replace successors by LABEL + the number of the cycle that each state comes to; NOWHERE stays.

    path: scratch for the states of one walk. progress: (3,) the next state to start from, how many states are on the
    path, how many cycles are known. cycles: (c, 3), written: a cycle's first state, its length, and the states of its
    basin, those of the cycle included. Returns 0 when done, 1 when ``path`` is too short and 2 when ``cycles`` is: call
    again with a longer array that begins with what is in it. Each state is read and written twice.
    """
    start, depth, known = np.uint64(progress[0]), np.uint64(progress[1]), np.uint64(progress[2])
    count, room, one = np.uint64(len(successor)), np.uint64(len(path)), np.uint64(1)
    # indices are unsigned: a signed one would be tested for being negative at every access
    while start < count or depth > 0:
        if depth == 0:
            if successor[start] & LABEL:
                start += one
                continue
            path[0] = np.uint32(start)
            depth = one
        at = np.uint64(path[depth - one])
        following = successor[at]
        while not following & LABEL:
            if depth == room:
                progress[0], progress[1], progress[2] = start, depth, known
                return 1
            successor[at] = ON_PATH
            path[depth] = following
            depth += one
            at = np.uint64(following)
            following = successor[at]
        # the last state of the path is labelled or on the path already, and is there once too often
        if following == ON_PATH:
            if known == np.uint64(len(cycles)):
                progress[0], progress[1], progress[2] = start, depth, known
                return 2
            first = depth - one - one
            while path[first] != at:
                first -= one
            cycles[known, 0], cycles[known, 1], cycles[known, 2] = at, depth - one - first, 0
            following = LABEL | np.uint32(known)
            known += one
        if following != NOWHERE:
            cycles[np.uint64(following & ~LABEL), 2] += depth - one
        for k in range(depth - one):
            successor[np.uint64(path[k])] = following
        depth = np.uint64(0)
        start += one
    progress[0], progress[1], progress[2] = start, depth, known
    return 0


@allocation_free
def printed_groups(
    successor: Words,
    touch: NDArray[np.uint8],
    zones: NDArray[np.uint64],
    all_zones: np.uint64,
    group: Ints,
    path: Longs,
    groups: Longs,
    progress: Longs,
) -> None:
    """Algorithm 2 as it is printed, for the next of the packed states in their order.

    touch: (n,) whether a state's step has a contact. zones: (n,) bits of the zones in which its robots are. all_zones:
    all bits. group: (n,) zeros, written: the group of each state, -1 for none. path: (n,) scratch. groups: (most, 3),
    written: the first state, the cycle length and the number of states of as many groups as fit. progress: (3,) the
    next state, the one to end before, and how many groups are kept so far.
    """
    kept = progress[2]
    for start in range(progress[0], progress[1]):
        if group[start] != 0 or successor[start] == NOWHERE:
            continue
        at, depth, contact, seen = np.int64(start), 0, False, np.uint64(0)
        while group[at] == 0:
            group[at] = -1
            path[depth] = at
            depth += 1
            contact = contact or touch[at] != 0
            seen |= zones[at]
            at = np.int64(successor[at])
        if group[at] != -1 or contact or seen != all_zones:
            continue
        first = depth - 1
        while first >= 0 and path[first] != at:
            first -= 1
        if first < 0:  # it ran into a trajectory that was not kept
            continue
        if kept < len(groups):
            groups[kept, 0], groups[kept, 1], groups[kept, 2] = at, depth - first, depth
        kept += 1
        for k in range(depth):
            group[path[k]] = kept
    progress[0], progress[2] = progress[1], kept


@allocation_free
def touching_states(team: Team, states: Ints, after: Ints, stays: Stays, touch: NDArray[np.uint8]) -> None:
    """Fill ``touch``, (n,): whether steps of packed states have a contact; the others as for ``successors``."""
    m, s = len(states), len(team.x)
    for code in range(len(touch)):
        touch[code] = 0 if any_too_near(team, states) else min(step_team(team, states, stays, after), 1)
        for i in range(m):
            states[i] += 1
            if states[i] < s:
                break
            states[i] = 0


@allocation_free
def strip_labels(labels: Any) -> None:
    """Turn LABEL + number into the number; NOWHERE becomes -1 when read as int32."""
    for k in range(len(labels)):
        if labels[k] != NOWHERE:
            labels[k] &= ~LABEL
