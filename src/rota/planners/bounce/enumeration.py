"""Periodic groups by enumeration of the joint map: Algorithm 2 as published, and exact basins on small maps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rota.planners.bounce.arrays import Flags, Ints, Longs
from rota.planners.bounce.bounce_map import cycles_and_basins, in_turn, joint_map, require_memory
from rota.planners.bounce.kernels import Team
from rota.planners.bounce.limit_cycles import LimitCycles
from rota.planners.bounce.map_kernels import printed_groups, touching_states

MOST_PRINTED = 1 << 20  # groups of Algorithm 2 that are kept to choose from; all are counted
BYTES_PRINTED = 7  # an enumeration of n states takes 4 n bytes for the map and 7 times as much in all


@dataclass(frozen=True, kw_only=True, eq=False)
class JointGroups:
    """Periodic groups without contact that watch all zones: states (g, m) of their robots, lengths and basins (g,)."""

    states: Ints
    length: Longs
    basin: Longs


def enumerate_groups(team: Team, inside: Flags, headings: int, *, contact_free: str) -> JointGroups:
    """All periodic groups of the joint map without contact, with exact basins; inside: (z, n) cells of the zones.

    With contact_free "cycle" a basin holds all joint states that come to the group, whatever contacts they have on the
    way. With "trajectory" it holds only those without contact. The groups are the same. Raises MissionError for maps
    beyond memory.
    """
    m, s = len(team.bumped), len(team.x)
    require_memory(s, m, copies=2)
    free = cycles_and_basins(joint_map(team, contact_free=True))
    basin = free.basin
    if contact_free == "cycle":
        whole_map = cycles_and_basins(joint_map(team))
        basin = whole_map.basin[whole_map.cycle[free.first]]
    states = unpack(free.first, s, m)
    kept = [k for k in range(len(states)) if _watches(team, inside, headings, states[k], int(free.length[k]))]
    return JointGroups(states=states[kept], length=free.length[kept], basin=basin[kept])


def groups_as_printed(
    team: Team, inside: Flags, headings: int, should_stop: Callable[[], bool] = lambda: False
) -> tuple[int, JointGroups]:
    """How many groups Algorithm 2 keeps as it is printed, and the first MOST_PRINTED of them.

    Joint states are taken in the order of their packed numbers. A state's trajectory is followed until it meets a state
    that was seen before. It is kept when it closes on itself, has no contact and enters all zones, each from its start
    on. Its states, transient ones included, then belong to the group. Otherwise no later trajectory begins at its
    states. So a group is lost when the first trajectory that leads to it has a contact: the result depends on the
    order. Raises NoPlanFound once ``should_stop``.
    """
    m, s = len(team.bumped), len(team.x)
    require_memory(s, m, copies=BYTES_PRINTED)
    successor = joint_map(team, should_stop=should_stop)
    count = len(successor)
    touch = np.zeros(count, np.uint8)
    states, after, stays = np.zeros(m, np.int32), np.empty(m, np.int32), np.empty(m, np.int8)
    for some in in_turn(count, should_stop):
        touching_states(team, states, after, stays, touch[some])
    bits = (inside.astype(np.uint64) << np.arange(len(inside), dtype=np.uint64)[:, None]).sum(axis=0, dtype=np.uint64)
    single = np.repeat(bits, headings)
    zones = single
    for _ in range(m - 1):
        zones = (single[:, None] | zones[None, :]).ravel()
    group, path = np.zeros(count, np.int32), np.empty(count, np.int64)
    groups = np.empty((MOST_PRINTED, 3), np.int64)
    all_zones = np.uint64((1 << len(inside)) - 1)
    progress = np.zeros(3, np.int64)
    for some in in_turn(count, should_stop):
        progress[1] = some.stop
        printed_groups(successor, touch, zones, all_zones, group, path, groups, progress)
    kept = int(progress[2])
    first, length, basin = groups[: min(kept, MOST_PRINTED)].T.copy()
    return kept, JointGroups(states=unpack(first, s, m), length=length, basin=basin)


def unpack(packed: Longs, states: int, robots: int) -> Ints:
    """(g, m) states of the robots of packed joint states (g,)."""
    return np.stack([packed // states**i % states for i in range(robots)], axis=1).astype(np.int32)


def nodes_of(cycles: LimitCycles, states: Ints) -> tuple[int, ...]:
    """The periodic states of robots in (m,) states, all of them periodic."""
    return tuple(int(cycles.node_of[kind, s]) for kind, s in zip(cycles.kind_of_robot, states, strict=True))


def _watches(team: Team, inside: Flags, headings: int, states: Ints, length: int) -> bool:
    """Whether robots without contact are in every zone at some time of a round."""
    seen = np.zeros(len(inside), np.bool_)
    at = states.copy()
    for _ in range(length):
        seen |= inside[:, at // headings].any(axis=1)
        if seen.all():
            return True
        at = np.array([team.moved[s] if team.moved[s] >= 0 else team.bumped[i, s] for i, s in enumerate(at)])
    return bool(seen.all())
