"""Figures 12 to 16: the published controller with 25 robots, without and with an obstacle, and what comes near."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rota.draw.palette import route_style
from rota.model.mission import Mission
from rota_studies.chen2018 import maps, paper
from rota_studies.chen2018.dense import TRIED, counted_contacts
from rota_studies.chen2018.panels import coverage_panel, distance_panel, ways_panel
from rota_studies.chen2018.runs import (
    CIRCLE_5,
    EXACT,
    FILTERED,
    FORCES,
    READINGS,
    SAMPLED,
    SETTLE,
    VORONOI,
    Controller,
    Outcome,
    Runs,
    obstacle_distances_m,
)
from rota_studies.chen2018.verdicts import convergence_verdicts
from rota_studies.panels.curve_panel import Curve, CurvePanel
from rota_studies.panels.map_panel import MapPanel
from rota_studies.section import Picture, Section
from rota_studies.tables import NOTHING, Table, plus_minus
from rota_studies.verdict import Verdict, always, mostly

Floats = NDArray[np.float64]

SHOWN: maps.Start = "between"
"""Where the runs of the pictures begin: the paper's steps of Figures 12 and 14 are both among ours from there."""


def rests(steps: Sequence[int]) -> str:
    """When runs rest, in words."""
    return f"rests after {plus_minus(steps, ',.0f')} steps" if steps else "comes to rest in no run"


def rest_cells(runs: Sequence[Outcome]) -> tuple[str, str, str]:
    """How many rest, their steps as mean and deviation, and from least to most; dashes where none does."""
    steps = _steps_at_rest(runs)
    rested = f"{len(steps)} of {len(runs)}"
    if not steps:
        return rested, NOTHING, NOTHING
    return rested, plus_minus(steps, ",.0f"), f"{min(steps):,} to {max(steps):,}"


def coverage_cell(runs: Sequence[Outcome]) -> str:
    """Exact coverage in the end, in percent."""
    return plus_minus([100 * run.coverage for run in runs], ".2f")


def _steps_at_rest(runs: Sequence[Outcome]) -> list[int]:
    """After how many steps each run rests that does."""
    return [run.steps for run in runs if run.at_rest]


def _is_among(printed: int, steps: Sequence[int]) -> bool:
    """Whether the paper's number lies between the least and the most of ours."""
    return bool(steps) and min(steps) <= printed <= max(steps)


def figure_12_section(runs: Runs) -> Section:
    """Figure 12: the small case without obstacles, by all readings of the published controller."""
    mission = maps.small(SHOWN)
    shown = runs(mission, EXACT)
    rows = []
    by_start: dict[tuple[str, str], list[Outcome]] = {}
    for start in maps.STARTS:
        for reading in READINGS:
            outcomes = by_start[start, reading.name] = runs.seeds(maps.small(start), reading)
            left = sum(run.lost > 0 for run in outcomes)
            rows.append((start, reading.name, *rest_cells(outcomes), coverage_cell(outcomes), str(left)))
    table = Table(
        title=f"Readings of the published controller: steps to rest and coverage, {len(outcomes)} seeds",
        head=("start box", "reading", "at rest", "steps", "least to most", "covered %", "runs that lose robots"),
        rows=(("not printed", "**the paper**", "1 of 1", f"{paper.STEPS_FIGURE_12}", "", "not printed", ""), *rows),
        words=(0, 1),
    )
    steps = {start: _steps_at_rest(by_start[start, EXACT.name]) for start in maps.STARTS}
    within = [start for start, taken in steps.items() if _is_among(paper.STEPS_FIGURE_12, taken)]
    covered = np.mean([run.coverage for run in by_start[SHOWN, EXACT.name]])
    return Section(
        figure=12,
        heading="25 robots without obstacles",
        pictures=_courses(
            12, "25 robots in a box, their ways, and their discs over the square in the end", mission, shown
        ),
        caption="Figure 12, by RD with the exact centroid from the box “between” centre and corner, 50 m to 100 m "
        "along both sides. Darker ground is covered by several robots.",
        paper=f"The algorithm is convergent at k = {paper.STEPS_FIGURE_12} (one run). Where the start box is, τ, and "
        "whether the set ends at the tangent or the circle are not told.",
        ours=f"From the box between centre and corner RD {rests(steps[SHOWN])}, and covers {covered:.1%} of at most "
        f"78.5 %. The paper's {paper.STEPS_FIGURE_12} is {_within(within)}. The place of the start box explains the "
        "number: the nearer to the corner, the longer. By 1,000 random velocities, as printed, runs hardly ever come "
        "to rest: their noise (Figure 9) moves robots by more than a thousand times what the stop rule allows, so that "
        "the paper must have found the centre, or the end, in another way. Without a filter the circle of t = τ lets "
        "robots through the walls of a corner.",
        tables=(_parameters(), table),
        verdicts=convergence_verdicts(by_start, _within(within)),
    )


def _within(starts: Sequence[str]) -> str:
    """From which starts our seeds take such a number of steps, in words."""
    if not starts:
        return "outside what our seeds take from any start"
    return f"among what our seeds take from the start {' and '.join(starts)}"


def _courses(figure: int, shows: str, mission: Mission, shown: Outcome) -> tuple[Picture]:
    """A run in three maps: its start, the ways of its robots, and its end."""
    panels: list[MapPanel] = [
        coverage_panel("(a) Start", mission, shown, 0),
        ways_panel("(b) Ways", mission, shown, shown.steps),
        coverage_panel("(c) End", mission, shown, shown.steps),
    ]
    return (Picture(f"chen2018-figure-{figure}.png", shows, tuple(panels), columns=3),)


def _distances(figure: int, shows: str, shown: Outcome) -> tuple[Picture]:
    """The least distance between two robots over a run's steps."""
    panel = distance_panel("Least distance between two robots", shown)
    return (Picture(f"chen2018-figure-{figure}.png", shows, (panel,)),)


def _least_m(runs: Sequence[Outcome]) -> float:
    """The least distance of two robots' middles in any of these runs, in metres."""
    return min(run.least_m for run in runs)


def _parameters() -> Table:
    """Table 2, and what it leaves open."""
    return Table(
        title="Table 2: parameters",
        head=("parameter", "paper", "here"),
        rows=(
            ("step", f"{paper.STEP_S:g} s", "the same"),
            ("stop rule ζ", f"{paper.STOP_M:.5f}", "no robot moves by more than 0.00001 m in a step"),
            ("area, start box", f"{paper.SIDE_M:g} m, {paper.START_SIDE_M:g} m", "the same; three places of the box"),
            ("robots", f"{paper.ROBOTS} and {paper.ROBOTS_LARGE:,}", "the same"),
            ("speed", f"{paper.SPEED_M_S:g} m/s", "the same"),
            ("body, sensor", f"{paper.BODY_M:g} m, {paper.SENSOR_M:g} m", "the same"),
            ("communication", f"{paper.COMMUNICATION_M:g} m", "not used by any equation"),
            ("neighbours of RD", f"{paper.NEIGHBOURS} within {paper.NEIGHBOUR_RANGE_M:g} m", "the same"),
            ("neighbours of V-based, VFA", "“the same parameters”", "all within 50 m; 4 in Figure 17"),
            ("τ", "1 and 2 s in Figure 2", "drops out (tangent); 1 and 5 s (circle)"),
            ("runs", "one", "seeds one after another, mean ± standard deviation"),
        ),
        words=(0, 1, 2),
    )


def figure_13_section(runs: Runs) -> Section:
    """Figure 13: the least distance between bodies, and the claim that they never touch."""
    shown = runs(maps.small(SHOWN), EXACT)
    rows, dense, touched = [], {}, {}
    for reading in READINGS:
        outcomes = [run for start in maps.STARTS for run in runs.seeds(maps.small(start), reading)]
        touching = sum(run.least_m < 2 * paper.BODY_M for run in outcomes)
        least = _least_m(outcomes)
        dense[reading.name] = counted_contacts(runs, reading)
        contacts, smallest = dense[reading.name]
        touched[reading.name] = touching
        runs_touching = f"{touching} of {len(outcomes)}"
        rows.append((reading.name, runs_touching, f"{least:.3f}", f"{contacts:,}", f"{smallest:.3f}"))
    table = Table(
        title="Contact: runs of Figure 12 from all three starts, and single steps from dense states in motion",
        head=("reading", "runs with contact", "least m", f"contacts in {TRIED:,} dense states", "least m"),
        rows=(("**the paper**", "none", "above 1", NOTHING, NOTHING), *rows),
    )
    apart = always(
        [run.least_m >= 2 * paper.BODY_M for start in maps.STARTS for run in runs.seeds(maps.small(start), EXACT)]
    )
    return Section(
        figure=13,
        heading="the least distance between robots",
        pictures=_distances(
            13, "The least distance between two robots never falls below the 1 m at which bodies touch", shown
        ),
        caption="Figure 13, for the run of Figure 12. Bodies touch at r_A + r_B = 1 m.",
        paper="Robots avoid collisions; Corollary 1 is said to prove it.",
        ours="Holds for runs that start at rest with the tangent, without any filter: no contact in any run. It does "
        f"not hold in general: from dense states in motion bodies touch in {dense[EXACT.name][0]:,} of {TRIED:,} "
        "single steps, since a fifth neighbour, and a robot whose own set is empty, are not reckoned with; and with "
        f"the circle at τ = 5 s they touch in {touched[CIRCLE_5.name]} runs as well. With the last filter there are "
        f"{dense[FILTERED.name][0]} contacts, and {_unchanged(runs)}. The text below Figure 14 has the condition the "
        "wrong way round: contact is a distance *smaller* than the sum of the radii.",
        tables=(table,),
        verdicts=(
            Verdict(
                "The swarm avoids collisions in its run", "5.1, Figure 13", apart.outcome,
                f"RD without a filter, from rest: no contact in {apart.told}.",
            ),
            Verdict(
                "Velocities of the sets are free of collisions (Corollary 1)", "3.3.1",
                "does not hold" if dense[EXACT.name][0] else "holds",
                f"From dense states in motion bodies touch in {dense[EXACT.name][0]:,} of {TRIED:,} steps: a fifth "
                f"neighbour and empty sets are left out. With Rota's last filter in {dense[FILTERED.name][0]}.",
            ),
        ),
    )  # fmt: skip


def _unchanged(runs: Runs) -> str:
    """Whether the filter changes any run of Figure 12, in words."""
    pairs = [
        pair
        for start in maps.STARTS
        for pair in zip(runs.seeds(maps.small(start), EXACT), runs.seeds(maps.small(start), FILTERED), strict=True)
    ]
    changed = sum(free.digest != safe.digest for free, safe in pairs)
    return f"it changes {changed} of the {len(pairs)} runs of Figure 12" if changed else "no run of Figure 12 changes"


AROUND: tuple[Controller, ...] = (SAMPLED, EXACT, FILTERED, VORONOI, FORCES, SETTLE)


def figure_14_section(runs: Runs) -> Section:
    """Figure 14: the small case with an obstacle."""
    mission = maps.with_obstacle(SHOWN)
    shown = runs(mission, EXACT)
    by_controller = {controller.name: runs.seeds(mission, controller) for controller in AROUND}
    rows = [(name, *rest_cells(outcomes), coverage_cell(outcomes)) for name, outcomes in by_controller.items()]
    table = Table(
        title=f"With an obstacle: steps to rest and coverage, {len(by_controller[EXACT.name])} seeds",
        head=("controller", "at rest", "steps", "least to most", "covered %"),
        rows=(("**the paper**", "1 of 1", f"{paper.STEPS_FIGURE_14:,}", "", "not printed"), *rows),
    )
    taken = _steps_at_rest(by_controller[EXACT.name])
    inside = _is_among(paper.STEPS_FIGURE_14, taken)
    rest = mostly([run.at_rest for run in by_controller[EXACT.name]], ours=True)
    return Section(
        figure=14,
        heading="25 robots and an obstacle",
        pictures=_courses(
            14, "25 robots in a box, their ways round a square obstacle, and their discs in the end", mission, shown
        ),
        caption="Figure 14, by RD from the box between centre and corner; that the obstacle of 10 m stands in the "
        "middle of the area is our choice.",
        paper=f"The algorithm is convergent at k = {paper.STEPS_FIGURE_14:,}; robots go round the obstacle.",
        ours=f"RD {rests(taken)}; the paper's {paper.STEPS_FIGURE_14:,} is {'among' if inside else 'outside'} ours. "
        "Robots go round the obstacle. A wall within sensor range takes away half of all velocities, so that robots "
        "near it wait for others: it costs RD steps and coverage, and the methods that push by overlaps hardly "
        "anything.",
        tables=(table,),
        verdicts=(
            Verdict(
                f"RD converges with an obstacle (k = {paper.STEPS_FIGURE_14:,})", "5.1, Figure 14", rest.outcome,
                f"At rest in {rest.told}, after {plus_minus(taken, ',.0f')} steps; the paper's "
                f"{paper.STEPS_FIGURE_14:,} is {'among' if inside else 'outside'} ours. Where the obstacle stands is "
                "not told.",
            ),
        ),
    )  # fmt: skip


def figure_15_section(runs: Runs) -> Section:
    """Figure 15: the least distance between bodies with the obstacle."""
    shown = runs(maps.with_obstacle(SHOWN), EXACT)
    outcomes = runs.seeds(maps.with_obstacle(SHOWN), EXACT)
    least = _least_m(outcomes)
    apart = always([run.least_m >= 2 * paper.BODY_M for run in outcomes])
    return Section(
        figure=15,
        heading="the least distance between robots, with the obstacle",
        pictures=_distances(15, "The least distance between two robots stays above 1 m", shown),
        caption="Figure 15, for the run of Figure 14.",
        paper="No two robots touch.",
        ours=f"Holds: {least:.3f} m is the least in {len(outcomes)} runs, where 1 m is contact.",
        verdicts=(
            Verdict(
                "No two robots touch with an obstacle", "5.1, Figure 15", apart.outcome,
                f"No contact in {apart.told}; {least:.3f} m between middles is the least.",
            ),
        ),
    )  # fmt: skip


def figure_16_section(runs: Runs) -> Section:
    """Figure 16: distances to the obstacle of the robots that have it in range."""
    mission = maps.with_obstacle(SHOWN)
    shown = runs(mission, EXACT)
    distances = obstacle_distances_m(mission, shown.drawn.places_m)
    near = [k for k in range(distances.shape[1]) if (distances[:, k] <= paper.SENSOR_M).any()]
    at = shown.drawn.at
    clear = [run.obstacle_m for run in runs.seeds(mission, EXACT)]
    untouched = always([distance_m >= paper.BODY_M for distance_m in clear])
    curves = []
    for line, k in enumerate(near):
        colour, style = route_style(line)
        values = np.where(distances[:, k] <= paper.SENSOR_M, distances[:, k], np.nan)
        curves.append(Curve(f"robot {k + 1}", values, colour, style, at=at.astype(np.float64), marked=False))
    panel = CurvePanel(
        title="Distance to the obstacle", note=f"least of all: {shown.obstacle_m:.2f} m", curves=tuple(curves),
        across="step k", up="m", wide=True,
    )  # fmt: skip
    told = ", ".join(str(k) for k in paper.ROBOTS_AT_OBSTACLE)
    return Section(
        figure=16,
        heading="the distance between robots and the obstacle",
        pictures=(
            Picture(
                "chen2018-figure-16.png",
                "Distances of robots to the obstacle while it is within 25 m",
                (panel,),
            ),
        ),
        caption="Figure 16, for the run of Figure 14: from a robot's middle to the obstacle, while that is in range. "
        "Bodies touch it at 0.5 m, far below.",
        paper=f"Only robots {told} have the obstacle in range, and none touches it.",
        ours=f"None touches it: {shown.obstacle_m:.2f} m is the least. {len(near)} robots have it in range at some "
        f"time, in the paper {len(paper.ROBOTS_AT_OBSTACLE)}. They keep near the border of their range: as soon as a "
        "wall is in it, all velocities towards it are ruled out.",
        verdicts=(
            Verdict(
                "No robot touches the obstacle", "5.1, Figure 16", untouched.outcome,
                f"None in {untouched.told}; the nearest of all keeps {min(clear):.2f} m away.",
            ),
        ),
    )  # fmt: skip
