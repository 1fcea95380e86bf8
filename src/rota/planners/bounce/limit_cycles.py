"""Limit cycles of single robots on cells, and which of their states go together for ever without a contact."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from rota.errors import MissionError
from rota.model.mission import Zone
from rota.planners.bounce.arrays import Flags, Floats, Ints, Longs
from rota.planners.bounce.bounce_map import cycles_and_basins, make_team, single_map
from rota.planners.bounce.cells import Cells
from rota.planners.bounce.cycle_kernels import compare_cycles
from rota.planners.bounce.kernels import Team

MOST_PERIODIC = 12_000  # states on cycles; the table of pairs takes a byte for each two
MOST_LOOKED_AT = 10_000_000  # states of all bouncing angles, up to which it is told which of them would do


@dataclass(frozen=True, kw_only=True, eq=False)
class LimitCycles:
    """The periodic states of all kinds of robots, p of them on c cycles, cycle by cycle in the order of time.

    kind_of_robot: the kind of each robot of the team; equal robots have the same. (p,) int32: ``kind``, ``state``,
    ``cycle``, ``phase`` in steps. (c,) int64: ``start``, the number of a cycle's first periodic state, ``length`` in
    steps, ``basin``, the single robot's states that come to it. node_of: (kinds, states) int32, the periodic state of
    a robot's state, -1 for transient ones. compatible: (p, p), whether two robots in these states never meet.
    """

    kind_of_robot: tuple[int, ...]
    kind: Ints
    state: Ints
    cycle: Ints
    phase: Ints
    start: Longs
    length: Longs
    basin: Longs
    node_of: Ints
    compatible: Flags

    def later(self, node: int, steps: int) -> int:
        """The periodic state that a robot is in ``steps`` steps later."""
        cycle = self.cycle[node]
        return int(self.start[cycle] + (self.phase[node] + steps) % self.length[cycle])

    def common_period(self, nodes: Sequence[int]) -> int:
        """The steps after which robots in these periodic states are in them again."""
        return math.lcm(*(int(self.length[self.cycle[node]]) for node in nodes))


def limit_cycles(team: Team) -> LimitCycles:
    """The limit cycles of a team's robots, and which of their states are compatible.

    Whether two robots come in contact depends on the difference of their phases modulo the greatest common divisor of
    both lengths. So each pair of cycles is tried with that many differences. Raises MissionError for more than
    MOST_PERIODIC states.
    """
    first_like: list[int] = []
    kinds = []
    for i in range(len(team.bumped)):
        like = next((k for k, j in enumerate(first_like) if _equal(team, i, j)), len(first_like))
        if like == len(first_like):
            first_like.append(i)
        kinds.append(like)
    cycle_states, starts, lengths, basins, kind = [], [], [], [], []
    node_of = np.full((len(first_like), len(team.x)), -1, np.int32)
    count = 0
    for k, robot in enumerate(first_like):
        successor = single_map(team, robot)
        basin = cycles_and_basins(successor)
        for first, length, size in zip(basin.first, basin.length, basin.basin, strict=True):
            states = _round(successor, int(first), int(length))
            node_of[k, states] = np.arange(count, count + length)
            starts.append(count)
            count += int(length)
            cycle_states.append(states)
            lengths.append(int(length))
            basins.append(int(size))
            kind += [k] * int(length)
    if count > MOST_PERIODIC:
        raise MissionError(
            f"bounce.cell_m: {count} states of the robots are periodic and at most {MOST_PERIODIC} are possible; larger"
            " cells, or other bouncing angles, are needed"
        )
    state, length_of = np.concatenate(cycle_states), np.array(lengths, np.int64)
    start = np.array(starts, np.int64)
    cycle = np.repeat(np.arange(len(length_of), dtype=np.int32), length_of)
    apart2 = np.ascontiguousarray(_apart_of_kinds(team, kinds, first_like))
    compatible = np.empty((count, count), np.bool_)
    bad = np.empty(int(length_of.max()), np.bool_)
    compare_cycles(team, apart2, np.array(kind, np.int32), state, start, length_of, bad, compatible)
    return LimitCycles(
        kind_of_robot=tuple(kinds),
        kind=np.array(kind, np.int32),
        state=state,
        cycle=cycle,
        phase=(np.arange(count) - start[cycle]).astype(np.int32),
        start=start,
        length=length_of,
        basin=np.array(basins, np.int64),
        node_of=node_of,
        compatible=compatible,
    )


def _equal(team: Team, i: int, j: int) -> bool:
    """Whether two robots may change places: same turn at a bump, same width."""
    others = [k for k in range(len(team.bumped)) if k not in (i, j)]
    return bool((team.bumped[i] == team.bumped[j]).all() and (team.apart2[i, others] == team.apart2[j, others]).all())


def _apart_of_kinds(team: Team, kinds: list[int], first_like: list[int]) -> Floats:
    """(k, k) squared least distances of robots of two kinds, in cells."""
    apart2 = np.zeros((len(first_like),) * 2)
    for i, a in enumerate(kinds):
        for j, b in enumerate(kinds):
            if i != j:
                apart2[a, b] = team.apart2[i, j]
    return apart2


def _round(successor: Ints, first: int, length: int) -> Ints:
    """(length,) states of a cycle from its first one on."""
    states = np.empty(length, np.int32)
    state = first
    for k in range(length):
        states[k] = state
        state = int(successor[state])
    return states


def zone_cells(cells: Cells, zones: Sequence[Zone]) -> Flags:
    """(z, n) whether a robot at a cell's centre is in a zone. Raises MissionError for zones that hold no centre."""
    points = shapely.points(cells.centres_m)
    inside = np.array([shapely.covers(zone.shape, points) for zone in zones], np.bool_).reshape(-1, cells.count)
    empty = [zone.name for zone, held in zip(zones, inside, strict=True) if not held.any()]
    if empty:
        raise MissionError(
            f"zones {', '.join(empty)}: no cell in which a robot can stand has its centre there; larger zones or"
            " smaller cells (bounce.cell_m) are needed"
        )
    return inside


def cycles_see(cycles: LimitCycles, inside: Flags, headings: int) -> Flags:
    """(p, z) whether a robot in each periodic state is in each zone, given (z, n) cells of zones."""
    return np.ascontiguousarray(inside[:, cycles.state // headings].T)


def require_watchable(sees: Flags, names: Sequence[str], cells: Cells, inside: Flags) -> None:
    """Raise MissionError for zones that no robot's limit cycle ever enters; it names the bouncing angles that would do.

    sees: (p, z) as ``cycles_see``. inside: (z, n) cells of zones.
    """
    unwatched = [name for k, name in enumerate(names) if not sees[:, k].any()]
    if not unwatched:
        return
    never = f"zones {', '.join(unwatched)}: no limit cycle of any robot enters them, so no team can watch them"
    if cells.states * cells.headings > MOST_LOOKED_AT:
        raise MissionError(f"{never}; bounce.bouncing_angles_deg: any tries all angles")
    angles = [f"{360 * bounce / cells.headings:g}" for bounce in _bounces_into_all(cells, inside)]
    if not angles:
        raise MissionError(f"{never}; nor do those of any other bouncing angle: other headings or cells are needed")
    raise MissionError(f"{never}; cycles of robots that turn by one of {', '.join(angles)} degrees enter all zones")


def _bounces_into_all(cells: Cells, inside: Flags) -> Iterator[int]:
    """Heading steps by which a robot may turn so that its limit cycles together enter all zones."""
    for bounce in range(1, cells.headings):
        ever = single_map(make_team(cells, [bounce]))
        for _ in range(len(ever).bit_length()):
            ever = ever[ever]  # where robots are after twice as many steps: in the end on cycles only
        if inside[:, ever // cells.headings].any(axis=1).all():
            yield bounce
