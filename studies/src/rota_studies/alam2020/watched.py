"""What two robots that watch two regions can do: how many periodic groups there are, and one of them to show."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota.planners.bounce.cells import make_cells
from rota.planners.bounce.chosen_group import begin_there
from rota.planners.bounce.enumeration import enumerate_groups, groups_as_printed
from rota.planners.bounce.group_count import count_groups
from rota.planners.bounce.inexact_plan import Kept, with_errors
from rota.planners.bounce.limit_cycles import cycles_see, zone_cells
from rota.planners.bounce.monitoring import Watch
from rota.planners.bounce.planner import Bouncing, bouncing_robots, monitoring_plan, watch_of
from rota.planners.bounce.planner_settings import BounceSettings
from rota_studies.alam2020 import maps
from rota_studies.alam2020.listed_groups import groups
from rota_studies.alam2020.runs import Runs, Watching, watching
from rota_studies.records import drawn_ways, what

ROBOTS = 2
REGION_CELLS = 2  # along each side of a random region
WATCH_ERROR_DEG = 1.0


@dataclass(frozen=True, kw_only=True)
class GroupCounts:
    """Periodic groups of two robots. cycles: of one robot, on so many ``states`` together.

    printed: those that Algorithm 2 keeps; apart, unordered: all that watch both regions, robots told apart and not;
    anywhere: told apart, whatever they watch. From so large a share of all joint states robots come to one: with
    contacts on the way (``basin``), and without any (``free_basin``).
    """

    cycles: int
    states: int
    printed: int
    apart: int
    unordered: int
    anywhere: int
    basin: float
    free_basin: float


@dataclass(frozen=True, kw_only=True)
class ShownGroup:
    """A group that is drawn: its robots' ways, words for it, what the check says, and what inexact turns leave."""

    ways: tuple[Trajectory, ...]
    told: str
    plan: Watching
    kept: tuple[Kept, ...]


def counted_groups(runs: Runs, mission: Mission) -> GroupCounts:
    """The periodic groups of a mission's two robots, counted in every way."""
    runs.now(f"counting groups: {mission.name}")
    return runs.records.get(GroupCounts, {"what": "groups", **what(mission)}, lambda: group_counts(mission))


def counted_regions(runs: Runs, mission: Mission) -> list[int]:
    """How many groups watch pairs of random regions."""
    pairs = runs.settings.region_pairs
    return runs.records.get(
        list[int],
        {"what": "groups of random regions", **what(mission), "pairs": pairs, "seed": runs.seed},
        lambda: random_region_counts(mission, pairs, runs.seed),
    )


def group_to_show(runs: Runs, mission: Mission) -> ShownGroup:
    """A group of the mission's robots, to be drawn."""

    def make() -> ShownGroup:
        runs.now(f"a group to show: {mission.name}")
        plan, told = shown_group(mission, runs.seed)
        asked = replace(BounceSettings.of(mission), turning_error_deg=WATCH_ERROR_DEG)
        kept = with_errors(replace(plan, mission=replace(plan.mission, planning=asked))).kept
        return ShownGroup(ways=drawn_ways(plan), told=told, plan=watching(plan), kept=kept)

    return runs.records.get(ShownGroup, {"what": "group shown", **what(mission), "seed": runs.seed}, make)


def shown_group(mission: Mission, seed: int) -> tuple[Plan, str]:
    """A group as a plan, and words for it: among the groups whose robots cross, the one that enters most cells."""
    bouncing, watch = _watch(mission)
    cycles = watch.cycles
    best = max(
        groups(watch, unordered=True), key=lambda nodes: (*_entered(bouncing, watch, nodes), -watch.ratio(nodes))
    )
    plan = monitoring_plan(bouncing, begin_there(watch, best, watch.ratio(best)), seed)
    lengths = " and ".join(str(int(cycles.length[cycles.cycle[node]])) for node in best)
    return plan, f"cycles of {lengths} steps, worst gap {watch.ratio(best) * maps.PERIOD_S:.0f} s"


def _watch(mission: Mission) -> tuple[Bouncing, Watch]:
    """The mission's robots on its cells, and what their limit cycles see."""
    bouncing = bouncing_robots(mission, make_cells(mission))
    return bouncing, watch_of(bouncing)


def _entered(bouncing: Bouncing, watch: Watch, nodes: tuple[int, ...]) -> tuple[bool, int]:
    """Whether robots on different cycles enter the same cells, and how many cells all enter together."""
    cycles = watch.cycles
    each = [
        np.unique(cycles.state[cycles.cycle == cycle] // bouncing.cells.headings)
        for cycle in np.unique(cycles.cycle[list(nodes)])
    ]
    together = np.unique(np.concatenate(each))
    return sum(map(len, each)) > len(together), len(together)


def group_counts(mission: Mission) -> GroupCounts:
    """The periodic groups of a mission's two robots, counted in every way."""
    bouncing, watch = _watch(mission)
    headings = bouncing.cells.headings
    inside = zone_cells(bouncing.cells, mission.zones)
    joint = float(bouncing.cells.states) ** ROBOTS
    listed = {
        free: enumerate_groups(bouncing.team, inside, headings, contact_free=free) for free in ("cycle", "trajectory")
    }
    return GroupCounts(
        cycles=len(watch.cycles.length),
        states=len(watch.cycles.state),
        printed=groups_as_printed(bouncing.team, inside, headings)[0],
        apart=count_groups(watch.cycles, watch.sees),
        unordered=sum(1 for _ in groups(watch, unordered=True)),
        anywhere=count_groups(watch.cycles, watch.sees[:, :0]),
        basin=float(listed["cycle"].basin.sum()) / joint,
        free_basin=float(listed["trajectory"].basin.sum()) / joint,
    )


def random_region_counts(mission: Mission, pairs: int, seed: int) -> list[int]:
    """How many groups, robots told apart, watch pairs of random square regions; (pairs,)."""
    bouncing, watch = _watch(mission)
    cells, rng = bouncing.cells, np.random.default_rng(seed)
    counts = []
    for _ in range(pairs):
        inside = np.zeros((2, cells.count), np.bool_)
        for region in inside:
            corner = int(rng.integers(cells.count))
            across, up = cells.column - cells.column[corner], cells.row - cells.row[corner]
            region[:] = (across >= 0) & (across < REGION_CELLS) & (up >= 0) & (up < REGION_CELLS)
        counts.append(count_groups(watch.cycles, cycles_see(watch.cycles, inside, cells.headings)))
    return counts
