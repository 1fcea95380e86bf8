"""Figures 10 and 11: two robots that watch two regions for ever, and how many periodic groups there are."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.bounce.planner_settings import BounceSettings, Purpose
from rota_studies.alam2020 import maps, paper
from rota_studies.alam2020.claims import apart_verdict, driven_verdict, groups_verdict
from rota_studies.alam2020.panels import headings_panel, ways_panel
from rota_studies.alam2020.runs import Runs, Watching
from rota_studies.alam2020.watched import (
    REGION_CELLS,
    ROBOTS,
    GroupCounts,
    ShownGroup,
    counted_groups,
    counted_regions,
    group_to_show,
)
from rota_studies.panels.study_picture import Panel
from rota_studies.section import Picture, Section
from rota_studies.tables import NOTHING, Table, counted

OTHER_ANGLE_DEG = 135.0
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
    counts = {angle: counted_groups(runs, place.mission(angle)) for angle in paper.ANGLES_DEG}
    spread = counted_regions(runs, place.mission(angle_deg))
    ours = counts[angle_deg]
    same = [
        told
        for told, number in (("as printed", ours.printed), ("told apart", ours.apart), ("unordered", ours.unordered))
        if number == said
    ]
    plans = _plans(runs, place.mission)
    told = f"Ours has {ours.apart:,} told apart, {ours.unordered:,} without names, {ours.printed:,} as printed"
    verdicts = [groups_verdict(place.figure, told, spread), apart_verdict(shown[angle_deg], place.figure)]
    if place.figure == 11:
        drives = [plan.driven for plan in plans.values() if plan is not None]
        verdicts.append(driven_verdict(drives, "5.2, Figure 11d-f"))
    return Section(
        figure=place.figure,
        heading=f"two robots watch two regions of {place.where}",
        pictures=(
            Picture(
                f"alam2020-figure-{place.figure}.png",
                "Arrows in the cells of two robots that watch two regions for ever, and their ways",
                tuple(panels),
            ),
        ),
        caption=f"Figure {place.figure}, with regions of ours, on a map chosen because cycles cross on it by the "
        "paper's angle (few maps have that); it was not looked for by its count of groups. (a) and (b) by the paper's "
        f"angle, (c) and (d) by {OTHER_ANGLE_DEG:g}°: of the groups on two limit cycles that share cells, if there are "
        "any, the one that enters most; of these the one with the shortest worst gap. Robots begin in the circles, on "
        "their cycles, and never leave them.",
        paper=f"r = {said} periodic groups of two robots by {angle_deg:g}° (Section 5.2). Map, regions, and whether "
        "robots are told apart, are not printed.",
        ours=f"By {angle_deg:g}° one robot has {counted(ours.cycles, 'limit cycle')} of {ours.states:,} states "
        f"together; {ours.apart:,} groups watch both regions with robots told apart, {ours.unordered:,} without names, "
        f"and Algorithm 2 in the order of its cells keeps {ours.printed:,}. "
        + (f"The paper's number is ours {' and '.join(same)}, by chance. " if same else "")
        + f"With {len(spread):,} pairs of random regions of {REGION_CELLS} x {REGION_CELLS} cells on the same map the "
        f"number told apart goes from {min(spread):,} to {max(spread):,} (median {int(np.median(spread)):,}): {said} "
        + ("lies within. " if min(spread) <= said <= max(spread) else "lies outside. ")
        + "A count alone cannot be compared without the map.",
        tables=(_groups_table(place, counts), purposes_table(plans)),
        verdicts=tuple(verdicts),
    )


def _shown(runs: Runs, place: _Place, angle_deg: float) -> tuple[list[Panel], dict[float, ShownGroup]]:
    """A group by the paper's angle and one by another: their panels, and what is known of them by angle."""
    panels: list[Panel] = []
    shown: dict[float, ShownGroup] = {}
    for letters, angle in zip((("a", "b"), ("c", "d")), (angle_deg, OTHER_ANGLE_DEG), strict=True):
        first_letter, second_letter = letters
        mission = place.mission(angle)
        group = shown[angle] = group_to_show(runs, mission)
        plan = Plan(mission=mission, trajectories=group.ways)
        panels.append(headings_panel(f"({first_letter}) {angle:g}°: cells and headings", plan, group.told))
        panels.append(ways_panel(f"({second_letter}) {angle:g}°: ways", plan, group.told, named_zones=True))
    return panels, shown


def _groups_table(place: _Place, counts: dict[float, GroupCounts]) -> Table:
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


def _plans(runs: Runs, mission_by_angle: Callable[[float], Mission]) -> dict[tuple[float, str], Watching | None]:
    """What ``rota plan`` finds for each angle and purpose; None: no plan."""
    found: dict[tuple[float, str], Watching | None] = {}
    for angle in paper.ANGLES_DEG:
        mission = mission_by_angle(angle)
        for purpose, told in PURPOSES.items():
            asked = replace(mission, planning=replace(BounceSettings.of(mission), purpose=purpose))
            found[angle, told] = runs.watching(asked)
    return found


def purposes_table(plans: dict[tuple[float, str], Watching | None]) -> Table:
    """The plans as their check sees them, and what a Create 2 needs to drive them."""
    rows = []
    for (angle, told), plan in plans.items():
        if plan is None:
            rows.append((f"{angle:g}°", told, "none", *[""] * 5))
            continue
        rows.append(
            (
                f"{angle:g}°", told, plan.verdict, *(f"{gap_s:.0f}" for gap_s in plan.gaps_s), str(plan.violations),
                "any time" if math.isinf(plan.clocks_s) else f"{plan.clocks_s:.2g}",
                NOTHING if plan.driven is None else f"{plan.driven.slowing:.2f}",
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
