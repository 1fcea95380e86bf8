"""The periodic group that a mission's robots follow: free to begin anywhere, or from given starts."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rota.errors import MissionError
from rota.model.mission import Mission, Robot
from rota.planners.bounce.arrays import Flags, Ints
from rota.planners.bounce.bounce_map import joint_states, single_map
from rota.planners.bounce.cells import Cells
from rota.planners.bounce.cycle_kernels import SettlingRoom, steps_to_cycles
from rota.planners.bounce.enumeration import JointGroups, enumerate_groups, groups_as_printed, nodes_of
from rota.planners.bounce.group_search import Searched, best_group
from rota.planners.bounce.kernels import Team
from rota.planners.bounce.limit_cycles import LimitCycles, zone_cells
from rota.planners.bounce.monitoring import Watch, canonical
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.bounce.rattles import rattling_nodes
from rota.planners.bounce.starts import start_cells, start_headings

MOST_HEADINGS = 4096  # joint headings that are tried from given starts
MOST_SETTLING = 20_000  # steps in which robots are to come to their cycles
MOST_ENUMERATED = 20_000_000  # joint states up to which basins are exact; beyond, they are sampled
MOST_JUDGED = 20_000  # groups of Algorithm 2; of more, it is not told how many watch all zones
SAMPLES, SAMPLED_STEPS = 2000, 2000  # random starts, and the steps in which they are to come to cycles


@dataclass(frozen=True, kw_only=True, eq=False)
class Choice:
    """The chosen group, None where there is none, and what is known of it.

    proved: for the purpose, no group asked for is better; without a chosen group, there is none. unproved: why that is
    not known, in words, where it was asked for. told: a sentence about the groups, or None.
    """

    chosen: Chosen | None
    proved: bool
    unproved: str | None = None
    told: str | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Chosen:
    """Periodic states of the robots when all are on their cycles, and the way there: (steps, m) states before."""

    cycles: LimitCycles
    nodes: tuple[int, ...]
    transient: Ints
    ratio: float


def choose_group(
    watch: Watch,
    team: Team,
    mission: Mission,
    robots: tuple[Robot, ...],
    cells: Cells,
    *,
    seed: int,
    should_stop: Callable[[], bool],
) -> Choice:
    """The best group for the mission's purpose among the groups that its method gives.

    Raises MissionError when only some robots have starts, and when the method's joint map does not fit in memory;
    NoPlanFound where the search is to stop before that is gone through.
    """
    settings = BounceSettings.of(mission)
    at = start_cells(cells, robots)
    rattling = rattling_nodes(watch.cycles, cells, max(robot.body_radius_m for robot in robots))
    if any(cell is not None for cell in at):
        start_cells_given = [cell for cell in at if cell is not None]
        if len(start_cells_given) < len(at):
            missing = robots[at.index(None)].name
            raise MissionError(
                f"robot {missing}: start: is missing; give a start to every robot that monitors, or none"
            )
        return _from_starts(watch, team, mission, start_cells_given, rattling, seed)
    if settings.start_headings_deg is not None:
        raise MissionError(
            "bounce.start_headings_deg: robots that monitor need starts beside their headings, or neither"
        )
    if settings.method == "as_printed":
        return _of_printed(watch, team, mission, cells, should_stop)
    if settings.purpose == "basin":
        return _largest_basin(watch, team, mission, cells, rattling, seed)
    if settings.purpose == "worst_gap":
        outcome = best_group(watch, should_stop=should_stop)
    else:
        outcome = _meeting_periods(watch, rattling, should_stop)
    chosen = None if outcome.group is None else begin_there(watch, outcome.group.nodes, outcome.group.ratio)
    return Choice(chosen=chosen, proved=outcome.proved, unproved=outcome.unproved)


def _meeting_periods(watch: Watch, rattling: Flags, should_stop: Callable[[], bool]) -> Searched:
    """A group that meets all periods, the one that goes first (``_goes_first``) of those soon found; else the best.

    rattling: (p,) periodic states on rattles. A group without any is looked for where the first group has some, then
    one in which robots take them last.
    """
    found = best_group(watch, enough=1.0, should_stop=should_stop)
    if found.group is None or not rattling[list(found.group.nodes)].any():
        return found
    first = found.group.ratio, int(rattling[list(found.group.nodes)].sum())
    for allowed, last in ((~rattling, None), (None, rattling)):
        other = best_group(watch, enough=1.0, should_stop=should_stop, allowed=allowed, last=last)
        if other.group is None:
            continue
        if _goes_first((other.group.ratio, int(rattling[list(other.group.nodes)].sum())), first, "periods"):
            return other
    return found


def _goes_first(new: tuple[float, int], old: tuple[float, int], purpose: str) -> bool:
    """Whether a group goes before another one, both by their worst ratio and how many of their robots rattle.

    The one with the smaller ratio does, for ``worst_gap`` or where the old one misses a period. Otherwise one without
    rattles does, or one with fewer whose ratio is no larger: where some robot rattles in any case, longer gaps bought
    no plan that keeps more with inexact turns.
    """
    (ratio, rattles), (old_ratio, old_rattles) = new, old
    if purpose == "worst_gap" or old_ratio > 1:
        return ratio < old_ratio
    return ratio <= 1 and rattles < old_rattles and (rattles == 0 or ratio <= old_ratio)


def _of_printed(watch: Watch, team: Team, mission: Mission, cells: Cells, should_stop: Callable[[], bool]) -> Choice:
    """The best of the groups that Algorithm 2 keeps as it is printed, and how many these are."""
    settings, zones = BounceSettings.of(mission), [zone for zone in mission.zones if zone.period_s is not None]
    kept, listed = groups_as_printed(team, zone_cells(cells, zones), cells.headings, should_stop)
    order = np.argsort(-listed.basin, kind="stable") if settings.purpose == "basin" else range(len(listed.basin))
    chosen = _best_of(_groups_that_may_begin(watch, listed, order), settings.purpose)
    whole = kept == len(listed.basin)
    unproved = None if whole else f"only the first {len(listed.basin):,} of its groups were looked at"
    return Choice(chosen=chosen, proved=whole, unproved=unproved, told=_sentence_of_printed(watch, kept, listed))


def _sentence_of_printed(watch: Watch, kept: int, listed: JointGroups) -> str:
    """The paper's r, P and Q: groups, their periodic states, and the transient ones taken with them."""
    groups = f"Algorithm 2 as printed keeps {kept:,} periodic group" + "s" * (kept != 1)
    if kept > len(listed.basin):
        return f"{groups} (r)."
    periodic, all_states = int(listed.length.sum()), int(listed.basin.sum())
    counts = f"{groups} (r), of {periodic:,} joint states (P), and {all_states - periodic:,} transient ones (Q)"
    if kept > MOST_JUDGED:
        return f"{counts}."
    nodes = (nodes_of(watch.cycles, states) for states in listed.states)
    watching = sum(all(watch.visiting(each, z) for z in range(watch.sees.shape[1])) for each in nodes)
    if watching == kept:
        return f"{counts}; all visit every zone for ever."
    return f"{counts}; {watching:,} of them visit every zone for ever, the others on their way only."


def begin_there(watch: Watch, nodes: tuple[int, ...], ratio: float) -> Chosen:
    """A group whose robots begin on their cycles."""
    return Chosen(cycles=watch.cycles, nodes=nodes, transient=np.empty((0, len(nodes)), np.int32), ratio=ratio)


def _groups_that_may_begin(watch: Watch, listed: JointGroups, order: Iterable[int]) -> Iterator[Chosen]:
    """The listed groups in this order, those whose robots may go together."""
    for k in order:
        nodes = nodes_of(watch.cycles, listed.states[k])
        if _may_go_together(watch.cycles, nodes):
            yield begin_there(watch, nodes, watch.ratio(nodes))


def _may_go_together(cycles: LimitCycles, nodes: tuple[int, ...]) -> bool:
    """Whether each two nodes are compatible, with clocks that drift; joint maps know nothing of clocks."""
    return all(cycles.compatible[p, q] for p, q in itertools.combinations(nodes, 2))


def _best_of(groups: Iterator[Chosen], purpose: str, rattling: Flags | None = None) -> Chosen | None:
    """The group that goes first (``_goes_first``), the search ending with the first that cannot be bettered.

    rattling: (p,) periodic states on rattles; None: no robot counts as being on one.
    """
    best: tuple[Chosen, int] | None = None
    for group in groups:
        rattles = 0 if rattling is None else int(rattling[list(group.nodes)].sum())
        if best is None or _goes_first((group.ratio, rattles), (best[0].ratio, best[1]), purpose):
            best = group, rattles
        if purpose != "worst_gap" and best[0].ratio <= 1 and best[1] == 0:
            break
    return best[0] if best is not None and math.isfinite(best[0].ratio) else None


# ---------------------------------------------------------------- the start that is easiest to hit


def _largest_basin(watch: Watch, team: Team, mission: Mission, cells: Cells, rattling: Flags, seed: int) -> Choice:
    """The group with the largest basin among those that meet all periods, exactly or by random starts.

    Where none meets all periods, the group with the smallest worst ratio. One without robots on rattles goes before.
    """
    m, s, contact_free = len(team.bumped), len(team.x), BounceSettings.of(mission).contact_free
    if joint_states(s, m) <= MOST_ENUMERATED:
        zones = [zone for zone in mission.zones if zone.period_s is not None]
        listed = enumerate_groups(team, zone_cells(cells, zones), cells.headings, contact_free=contact_free)
        order = np.argsort(-listed.basin, kind="stable")
        return Choice(chosen=_best_of(_groups_that_may_begin(watch, listed, order), "basin", rattling), proved=True)
    hits = sampled_basins(watch, team, free=contact_free == "trajectory", seed=seed)
    sampled = (begin_there(watch, nodes, watch.ratio(nodes)) for nodes, _ in hits)
    unproved = f"only {SAMPLES:,} random starts were tried"
    return Choice(chosen=_best_of(sampled, "basin", rattling), proved=False, unproved=unproved)


def sampled_basins(
    watch: Watch, team: Team, *, free: bool, seed: int, samples: int = SAMPLES
) -> list[tuple[tuple[int, ...], int]]:
    """Groups that random joint states come to, and how many of ``samples`` came to each, most first.

    free: only without contact. The joint states are drawn evenly. A state with two robots in one cell comes to no
    group, nor does one that takes more than SAMPLED_STEPS.
    """
    rng = np.random.default_rng(seed)
    m, s = len(team.bumped), len(team.x)
    hits: Counter[tuple[int, ...]] = Counter()
    for start in rng.integers(0, s, (samples, m)):
        if len({(int(team.x[a]), int(team.y[a])) for a in start}) == m:
            way = _settle(watch.cycles, team, start.tolist(), free, SAMPLED_STEPS)
            if way is not None:
                hits[canonical(watch.cycles, nodes_of(watch.cycles, way[-1]))] += 1
    return sorted(hits.items(), key=lambda entry: (-entry[1], entry[0]))


# ---------------------------------------------------------------- from given starts


def ways_from_starts(
    watch: Watch,
    team: Team,
    at: Sequence[int],
    settings: BounceSettings,
    seed: int,
    facings: list[int] | None = None,
) -> Iterator[Chosen]:
    """Ways from cells to cycles without contact on which each zone is visited, for joint headings as they are tried.

    facings: the headings at the starts; None: as the robots like.
    """
    headings = settings.headings
    for facing in _headings(facings, headings, len(at), seed):
        states = [cell * headings + h for cell, h in zip(at, facing, strict=True)]
        way = _settle(watch.cycles, team, states, settings.contact_free == "trajectory")
        if way is None:
            continue
        nodes = nodes_of(watch.cycles, way[-1])
        ratio = watch.ratio(nodes)
        if math.isfinite(ratio):
            yield Chosen(cycles=watch.cycles, nodes=nodes, transient=way[:-1], ratio=ratio)


def _from_starts(watch: Watch, team: Team, mission: Mission, at: list[int], rattling: Flags, seed: int) -> Choice:
    """The best way from the given cells (and headings, if these are given too) to cycles without contact."""
    settings, headings_given = BounceSettings.of(mission), start_headings(mission, len(at))
    ways = ways_from_starts(watch, team, at, settings, seed, headings_given)
    best = _best_of(ways, settings.purpose, rattling)
    facings = settings.headings ** len(at)
    if headings_given is None and facings > MOST_HEADINGS:
        unproved = f"{MOST_HEADINGS:,} of {facings:,} ways to face at the starts were tried"
        return Choice(chosen=best, proved=False, unproved=unproved)
    return Choice(chosen=best, proved=True)


def out_of_reach(watch: Watch, team: Team, at: Sequence[int], mission: Mission, cells: Cells) -> Flags:
    """(z,) zones that no robot, left alone, enters on the limit cycles that it comes to from its cell in ``at``."""
    cycles, headings_given = watch.cycles, start_headings(mission, len(at))
    out = np.ones(watch.sees.shape[1], np.bool_)
    for robot, cell in enumerate(at):
        facing = np.arange(cells.headings) if headings_given is None else np.array([headings_given[robot]])
        states, successor = cell * cells.headings + facing, single_map(team, robot)
        node_of = cycles.node_of[cycles.kind_of_robot[robot]]
        while (node_of[states] < 0).any():  # every state comes to a cycle
            states = successor[states]
        for cycle in np.unique(cycles.cycle[node_of[states]]):
            out &= ~watch.sees[cycles.start[cycle] : cycles.start[cycle] + cycles.length[cycle]].any(axis=0)
    return out


def _headings(given: list[int] | None, headings: int, robots: int, seed: int) -> Iterator[Sequence[int]]:
    """Joint headings to try: the given ones, all, or random ones where all are too many."""
    if given is not None:
        yield given
    elif headings**robots <= MOST_HEADINGS:
        yield from itertools.product(range(headings), repeat=robots)
    else:
        yield from np.random.default_rng(seed).integers(0, headings, (MOST_HEADINGS, robots)).tolist()


def _settle(cycles: LimitCycles, team: Team, states: list[int], free: bool, most: int = MOST_SETTLING) -> Ints | None:
    """(steps + 1, m) states until all robots are on cycles without contact; None when they never are."""
    m = len(states)
    log = np.empty((most, m), np.int32)
    kinds, at = np.array(cycles.kind_of_robot, np.int32), np.array(states, np.int32)
    room = SettlingRoom(np.empty(m, np.int32), np.empty(m, np.int8), log)
    steps = steps_to_cycles(team, kinds, cycles.node_of, cycles.compatible, at, room, free)
    return log[: steps + 1].copy() if steps >= 0 else None
