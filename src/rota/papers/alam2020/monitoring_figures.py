"""Figures 10 and 11: two robots that watch two regions for ever, and how many periodic groups there are."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rota.draw.panels.study_picture import Panel, study_picture
from rota.errors import NoPlanFound, PlanError
from rota.files.create2_legs import drives_of
from rota.make_plan import PlanSearch, search_plan
from rota.mission import Mission
from rota.papers.alam2020 import maps, paper
from rota.papers.alam2020.claims import apart_verdict, driven_verdict, groups_verdict
from rota.papers.alam2020.panels import headings_panel, ways_panel
from rota.papers.alam2020.runs import Runs
from rota.papers.section import Picture, Section
from rota.papers.tables import NOTHING, Table, counted
from rota.plan import Plan
from rota.planners.bounce.cells import make_cells
from rota.planners.bounce.chosen_group import begin_there
from rota.planners.bounce.enumeration import enumerate_groups, printed
from rota.planners.bounce.group_count import count_groups
from rota.planners.bounce.limit_cycles import seen_by_cycles, zone_cells
from rota.planners.bounce.monitoring import Watch, groups
from rota.planners.bounce.planner import Bouncing, bouncing_robots, monitoring_plan, watch_of
from rota.planners.bounce.planner_settings import BounceSettings, Purpose

ROBOTS = 2
OTHER_ANGLE_DEG = 135.0
REGION_CELLS = 2  # along each side of a random region
PURPOSES: dict[Purpose, str] = {
    "periods": "periods met",
    "worst_gap": "shortest worst gap",
    "basin": "largest basin",
}


@dataclass(frozen=True, kw_only=True)
class _Place:
    """Where robots monitor: its figure, words for it, and its mission by bouncing angle."""

    figure: int
    where: str
    mission: Callable[[float], Mission]


@dataclass(frozen=True, kw_only=True)
class _Counts:
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


def figure_10_section(runs: Runs) -> Section:
    """Figure 10: two robots by 45° that watch two regions of a room."""

    def mission(angle_deg: float) -> Mission:
        return maps.watching(maps.room(maps.ROOM_BAYS, ROBOTS, angle_deg), maps.ROOM_REGIONS)

    return _monitoring(runs, _Place(figure=10, where="a room of 10 x 10 cells", mission=mission))


def figure_11_section(runs: Runs) -> Section:
    """Figure 11: two robots by 90° that watch two regions of a laboratory."""

    def mission(angle_deg: float) -> Mission:
        return maps.watching(maps.lab(maps.LAB_2, ROBOTS, angle_deg), maps.LAB_REGIONS)

    return _monitoring(runs, _Place(figure=11, where="a second laboratory", mission=mission))


def _monitoring(runs: Runs, place: _Place) -> Section:
    """The section of a place: groups shown, counted on our map and on random regions, and what the paper says."""
    angle_deg, said = paper.GROUPS[place.figure]
    panels, shown = _shown(runs, place, angle_deg)
    counts = {}
    for angle in paper.ANGLES_DEG:
        runs.now(f"figure {place.figure}: counting groups by {angle:g}°")
        counts[angle] = group_counts(place.mission(angle))
    runs.now(f"figure {place.figure}: random regions")
    spread = random_region_counts(place.mission(angle_deg), runs.settings.region_pairs, runs.seed)
    ours = counts[angle_deg]
    same = [
        told
        for told, number in (("as printed", ours.printed), ("told apart", ours.apart), ("unordered", ours.unordered))
        if number == said
    ]
    plans = _plans(runs, place.mission)
    runs.now(f"figure {place.figure}: clocks and turns of the group shown")
    told = f"Ours has {ours.apart:,} told apart, {ours.unordered:,} without names, {ours.printed:,} as printed"
    verdicts = [groups_verdict(place.figure, told, spread), apart_verdict(shown[angle_deg], place.figure)]
    if place.figure == 11:
        by_purpose = {f"{angle:g} {told}": search.plan for (angle, told), search in plans.items() if search is not None}
        verdicts.append(driven_verdict(by_purpose, "5.2, Figure 11d-f"))
    return Section(
        figure=place.figure,
        heading=f"two robots watch two regions of {place.where}",
        pictures=(
            Picture(
                f"alam2020-figure-{place.figure}.png",
                "Arrows in the cells of two robots that watch two regions for ever, and their ways",
                study_picture(panels),
            ),
        ),
        caption=f"Figure {place.figure}, with regions of ours, on a map chosen because cycles cross on it by the "
        "paper's angle (few maps have that); it was not looked for by its count of groups. (a) and (b) by the paper's "
        "angle, (c) and "
        f"(d) by {OTHER_ANGLE_DEG:g}°: of the groups on two limit cycles that share cells, if there are any, "
        "the one that enters most; of these the one with the shortest worst gap. Robots begin in the circles, "
        "on their cycles, and never leave them.",
        paper=f"r = {said} periodic groups of two robots by {angle_deg:g}° (Section 5.2). Map, regions, and whether "
        "robots are told apart, are not printed.",
        ours=f"By {angle_deg:g}° one robot has {counted(ours.cycles, 'limit cycle')} of {ours.states:,} states "
        f"together; {ours.apart:,} groups watch both regions with robots told apart, {ours.unordered:,} without "
        f"names, and Algorithm 2 in the order of its cells keeps {ours.printed:,}. "
        + (f"The paper's number is ours {' and '.join(same)}, by chance. " if same else "")
        + f"With {len(spread):,} pairs of random regions of {REGION_CELLS} x {REGION_CELLS} cells on the same map the "
        f"number told apart goes from {min(spread):,} to {max(spread):,} (median {int(np.median(spread)):,}): {said} "
        + ("lies within. " if min(spread) <= said <= max(spread) else "lies outside. ")
        + "A count alone cannot be compared without the map.",
        tables=(_groups_table(place, counts), purposes_table(plans)),
        verdicts=tuple(verdicts),
    )


def _shown(runs: Runs, place: _Place, angle_deg: float) -> tuple[list[Panel], dict[float, Plan]]:
    """A group by the paper's angle and one by another: their panels, and their plans by angle."""
    panels: list[Panel] = []
    shown: dict[float, Plan] = {}
    for letters, angle in zip((("a", "b"), ("c", "d")), (angle_deg, OTHER_ANGLE_DEG), strict=True):
        first_letter, second_letter = letters
        runs.now(f"figure {place.figure}: groups by {angle:g}°")
        plan, note = shown_group(place.mission(angle), runs.seed)
        shown[angle] = plan
        panels.append(headings_panel(f"({first_letter}) {angle:g}°: cells and headings", plan, note))
        panels.append(ways_panel(f"({second_letter}) {angle:g}°: ways", plan, note, named_zones=True))
    return panels, shown


def _groups_table(place: _Place, counts: dict[float, _Counts]) -> Table:
    """How many periodic groups there are, in each way of counting, by bouncing angle."""
    angle_deg, said = paper.GROUPS[place.figure]
    rows = [
        (
            f"{angle:g}°", f"{said}" if angle == angle_deg else "", f"{count.printed:,}", f"{count.apart:,}",
            f"{count.unordered:,}", f"{count.anywhere:,}", f"{count.cycles:,} ({count.states:,})", f"{count.basin:.1%}",
            f"{count.free_basin:.1%}",
        )
        for angle, count in counts.items()
    ]  # fmt: skip
    return Table(
        title=f"Periodic groups of two robots that watch A and B, {place.where}",
        head=(
            "angle", "the paper, r", "Algorithm 2 as printed", "all, robots told apart", "all, unordered",
            "without regions, told apart", "cycles of one robot (states)", "joint states that come to one",
            "without contact on the way",
        ),
        rows=tuple(rows),
    )  # fmt: skip


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


def group_counts(mission: Mission) -> _Counts:
    """The periodic groups of a mission's two robots, counted in every way."""
    bouncing, watch = _watch(mission)
    headings = bouncing.cells.headings
    inside = zone_cells(bouncing.cells, mission.zones)
    joint = float(bouncing.cells.states) ** ROBOTS
    listed = {
        free: enumerate_groups(bouncing.team, inside, headings, contact_free=free) for free in ("cycle", "trajectory")
    }
    return _Counts(
        cycles=len(watch.cycles.length),
        states=len(watch.cycles.state),
        printed=printed(bouncing.team, inside, headings)[0],
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
        counts.append(count_groups(watch.cycles, seen_by_cycles(watch.cycles, inside, cells.headings)))
    return counts


def _plans(runs: Runs, mission_by_angle: Callable[[float], Mission]) -> dict[tuple[float, str], PlanSearch | None]:
    """What ``rota plan`` finds for each angle and purpose; None: no plan."""
    searches: dict[tuple[float, str], PlanSearch | None] = {}
    for angle in paper.ANGLES_DEG:
        mission = mission_by_angle(angle)
        for purpose, told in PURPOSES.items():
            runs.now(f"plans that watch by {angle:g}°: {told}")
            asked = replace(mission, planning=replace(BounceSettings.of(mission), purpose=purpose))
            try:
                searches[angle, told] = search_plan(asked, seed=runs.seed)
            except NoPlanFound:
                searches[angle, told] = None
    return searches


def purposes_table(plans: dict[tuple[float, str], PlanSearch | None]) -> Table:
    """The plans as their check sees them, and what a Create 2 needs to drive them."""
    rows = []
    for (angle, told), search in plans.items():
        if search is None:
            rows.append((f"{angle:g}°", told, "none", *[""] * 5))
            continue
        report = search.report
        gaps = (f"{demand.worst_gap_s:.0f}" for demand in report.demands)
        margin_s = math.inf if report.clock_margin_s is None else report.clock_margin_s
        rows.append(
            (
                f"{angle:g}°", told, report.verdict, *gaps, str(len(report.violations)),
                "any time" if math.isinf(margin_s) else f"{margin_s:.2g}", _slowing(search.plan),
            )
        )  # fmt: skip
    return Table(
        title=f"Plans found and checked: worst gap between visits, s, for a period of {maps.PERIOD_S:g} s",
        head=(
            "angle", "purpose", "verdict", "A", "B", "violations", "clocks may differ, s",
            "driven by a Create 2, times slower",
        ),
        rows=tuple(rows),
        words=(0, 1, 2),
    )  # fmt: skip


def _slowing(plan: Plan) -> str:
    """How much slower than planned Create 2 robots drive the plan, as text; a dash where they cannot drive it."""
    try:
        return f"{drives_of(plan)[0].slowing:.2f}"
    except PlanError:
        return NOTHING
