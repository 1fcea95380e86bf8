"""Figures 6 to 9: joint trajectories that cover, by Algorithm 1 as printed and by turns that pay."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rota.draw.palette import ROUTE_COLOURS
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.bounce.planner_settings import BounceMethod
from rota_studies.alam2020 import maps, paper
from rota_studies.alam2020.claims import (
    driven_verdict,
    fewer_steps_verdict,
    figure_6_verdicts,
    floor_verdict,
    large_room_verdict,
    more_robots_verdict,
    reasons_verdict,
)
from rota_studies.alam2020.panels import entries_panel, headings_panel, starts_panel, ways_panel
from rota_studies.alam2020.runs import METHODS, CoverRuns, Runs
from rota_studies.panels.curve_panel import Curve, CurvePanel
from rota_studies.panels.study_picture import Panel
from rota_studies.section import Picture, Section
from rota_studies.tables import NOTHING, Table, counted, joined

COLOURS = dict(zip(METHODS, (ROUTE_COLOURS[0], ROUTE_COLOURS[3]), strict=True))
TOLD = dict(zip(METHODS, ("as printed", "improved"), strict=True))


def plus_minus(values: Sequence[float] | np.typing.NDArray[np.int64]) -> str:
    """Mean and standard deviation of whole numbers; only the mean of one value, a dash for none."""
    if not len(values):
        return NOTHING
    mean = f"{float(np.mean(values)):,.0f}"
    return mean if len(values) < 2 else f"{mean} ± {float(np.std(values, ddof=1)):,.0f}"


def least_to_most(values: Sequence[float] | np.typing.NDArray[np.int64]) -> str:
    """The range of whole numbers; a dash for none."""
    return f"{int(min(values)):,} to {int(max(values)):,}" if len(values) else NOTHING


def _row(runs: CoverRuns) -> tuple[str, ...]:
    """Complete runs, steps, and what robots meet with on the way, on average."""
    return (
        f"{runs.complete.sum()} of {len(runs.seeds)}", plus_minus(runs.steps), least_to_most(runs.steps),
        f"{runs.contacts.mean():,.1f}", f"{runs.jumps.mean():,.1f}",
    )  # fmt: skip


HEAD = ("complete", "steps", "least to most", "steps with contacts", "turns by the clock")


def figure_6_section(runs: Runs) -> Section:
    """Figure 6: two robots cover a laboratory, in their configuration space and in the workspace."""
    mission = maps.lab(maps.LAB_1, 2, paper.COVER_ANGLE_DEG)
    by_method = {method: runs.cover(mission, method) for method in METHODS}
    printed, improved = (by_method[method] for method in METHODS)
    panels: list[Panel] = []
    for letters, method in zip((("a", "b"), ("c", "d")), METHODS, strict=True):
        cover_runs = by_method[method]
        plan = _drawn(runs, mission, method, cover_runs.shortest)
        contacts = int(cover_runs.contacts[cover_runs.shortest])
        note = f"{cover_runs.steps[cover_runs.shortest]:,} steps, {counted(contacts, 'contact')}"
        panels.append(headings_panel(f"({letters[0]}) {TOLD[method].capitalize()}: cells and headings", plan, note))
        panels.append(ways_panel(f"({letters[1]}) {TOLD[method].capitalize()}: ways", plan, note))
    table = Table(
        title=f"Two robots cover the laboratory, {len(improved.seeds)} random starts, mean ± deviation",
        head=("Algorithm 1", *HEAD),
        rows=(
            ("**the paper**", "1 of 1", "not printed", "", f"{paper.CONTACTS_FIGURE_6} contact", "not printed"),
            *((TOLD[method], *_row(cover_runs)) for method, cover_runs in by_method.items()),
        ),
    )
    few = [int((cover_runs.contacts <= paper.CONTACTS_FIGURE_6).sum()) for cover_runs in (printed, improved)]
    return Section(
        figure=6,
        heading="two robots cover a laboratory",
        pictures=(
            Picture(
                "alam2020-figure-6.png",
                "Arrows in the cells of two robots that cover a laboratory, and their ways, by both methods",
                tuple(panels),
            ),
        ),
        caption="Figure 6b and 6c, on a laboratory of ours: 4 m by 3 m, cells of 0.25 m, robots as wide as a Create 2. "
        "Grey: where a robot's centre cannot be. Of each method the shortest of the runs; circles are starts, and both "
        "ways are drawn a little apart.",
        paper="One joint trajectory of two robots by 135° that covers the laboratory, with one contact of both robots "
        "(Section 5.1). Neither the map nor the number of steps is printed.",
        ours=f"As printed, all cells are covered from {printed.complete.sum()} of {len(printed.seeds)} starts, after "
        f"{plus_minus(printed.steps)} steps; improved, from {improved.complete.sum()}, after "
        f"{plus_minus(improved.steps)}. Runs with no more than one step of contact, as the paper's: {few[0]} as "
        f"printed, {few[1]} improved.",
        tables=(table,),
        verdicts=(
            *figure_6_verdicts({method: each.complete.tolist() for method, each in by_method.items()}, few),
            driven_verdict([one for method in METHODS for one in runs.driven(mission, method)], "5.1, Figure 6d-f"),
            floor_verdict({TOLD[method]: runs.floor_passed(mission, method) for method in METHODS}),
        ),
    )


def _drawn(runs: Runs, mission: Mission, method: BounceMethod, run: int, *, ways: bool = True) -> Plan:
    """A run, from 0, as a plan to be drawn; ``ways``: or only its starts."""
    return Plan(mission=mission, trajectories=runs.drawn(mission, method, runs.starts[run], ways=ways).ways)


@dataclass(frozen=True, kw_only=True)
class _Grid:
    """A map of the paper's comparisons: its figure, size in words and in cells, typed layout."""

    figure: int
    cells: int
    text: str

    @property
    def size(self) -> str:
        return f"{self.cells} x {self.cells}"


def figure_7_section(runs: Runs) -> Section:
    """Figure 7: steps to cover by number of robots on 10 x 10 cells."""
    return _by_robots(runs, _Grid(figure=7, cells=10, text=maps.ROOM_10))


def figure_8_section(runs: Runs) -> Section:
    """Figure 8: steps to cover by number of robots on 15 x 15 cells."""
    return _by_robots(runs, _Grid(figure=8, cells=15, text=maps.ROOM_15))


SAID = {
    7: "The number of steps decreases with the number of robots (Figure 7b is a plot; no values are printed).",
    8: "More robots need not take fewer steps: five take more than four (Figure 8b is a plot; no values are printed).",
}


def _by_robots(runs: Runs, grid: _Grid) -> Section:
    """The figure of the steps that teams of each size take on one grid."""
    rooms = {robots: maps.room(grid.text, robots, paper.COVER_ANGLE_DEG) for robots in paper.TEAMS}
    by_team = {(method, robots): runs.cover(rooms[robots], method) for robots in paper.TEAMS for method in METHODS}
    starts = _drawn(runs, rooms[paper.TEAMS[0]], "as_printed", 0, ways=False)
    panels: list[Panel] = [starts_panel("(a) The map, and two starts", starts), _curves(by_team)]
    others = _other_layouts(runs, grid)
    other_means = [[float(team.steps.mean()) for team in teams] for teams in others]
    rows = [(str(robots), TOLD[method], *_row(by_team[method, robots])) for robots in paper.TEAMS for method in METHODS]
    printed = [by_team["as_printed", robots] for robots in paper.TEAMS]
    count = runs.settings.starts
    table = Table(
        title=f"Steps to cover {grid.size} cells by 135°, {count} random starts, mean ± deviation",
        head=("robots", "Algorithm 1", *HEAD),
        rows=(("2 to 5", "**the paper**", "all", *["not printed"] * 4), *rows),
        words=(0, 1),
    )
    means = {method: [float(by_team[method, robots].steps.mean()) for robots in paper.TEAMS] for method in METHODS}
    complete = sum(int(team_runs.complete.sum()) for team_runs in by_team.values())
    five_slower = sum(layout[-1] > layout[-2] for layout in other_means)
    larger_slower = sum(any(b > a for a, b in itertools.pairwise(layout)) for layout in other_means)
    return Section(
        figure=grid.figure,
        heading=f"steps to cover {grid.size} cells",
        pictures=(
            Picture(
                f"alam2020-figure-{grid.figure}.png",
                f"A room of {grid.size} cells, and the steps to cover it by number of robots and by method",
                tuple(panels),
            ),
        ),
        caption=f"Figure {grid.figure}. The layout is ours. Lines are means, bands go from least to most; logarithmic.",
        paper=SAID[grid.figure],
        ours=f"{complete} of {len(by_team) * count} runs cover all cells. Mean steps for "
        f"{joined([str(robots) for robots in paper.TEAMS])} robots: {_slashed(means['as_printed'])} as printed, "
        f"{_slashed(means['improved'])} improved. "
        + _trend(means["as_printed"], "As printed")
        + " "
        + _trend(means["improved"], "improved")
        + f". Layouts matter: on {five_slower} of {len(others)} random ones with as many blocked cells five robots "
        f"take longer than four as printed, and on {larger_slower} some team takes longer than a smaller one.",
        tables=(table, _layouts_table(grid, others, printed, runs.settings.layout_steps)),
        verdicts=(
            (fewer_steps_verdict(printed, others),)
            if grid.figure == 7
            else (more_robots_verdict(printed, others), reasons_verdict(printed, others))
        ),
    )  # fmt: skip


def _other_layouts(runs: Runs, grid: _Grid) -> list[list[CoverRuns]]:
    """Runs as printed by number of robots, for each of some random layouts with as many blocked cells."""
    by_layout = []
    blocked = grid.text.count("#")
    for layout in range(runs.settings.layouts):
        text = maps.random_room(grid.cells, grid.cells, blocked, np.random.default_rng([runs.seed, layout]))
        missions = (
            maps.room(text, robots, paper.COVER_ANGLE_DEG, most_steps=runs.settings.layout_steps)
            for robots in paper.TEAMS
        )
        by_layout.append([runs.cover(mission, "as_printed") for mission in missions])
    return by_layout


def _layouts_table(grid: _Grid, others: list[list[CoverRuns]], shown: list[CoverRuns], most_steps: int) -> Table:
    """Mean steps by team on random layouts beside the layout shown: least, median and most."""
    by_robots = np.array([[team_runs.steps.mean() for team_runs in teams] for teams in others]).T
    rows = [("the layout above", *(f"{team_runs.steps.mean():,.0f}" for team_runs in shown))]
    for told, choose in (("least", np.min), ("median", np.median), ("most", np.max)):
        rows.append((f"random layouts, {told}", *(f"{choose(means):,.0f}" for means in by_robots)))
    complete = np.array([[team_runs.complete.sum() for team_runs in teams] for teams in others]).sum(axis=0)
    count = sum(len(teams[0].seeds) for teams in others)
    rows.append((f"runs that cover all in {most_steps:,} steps", *(f"{number} of {count}" for number in complete)))
    return Table(
        title=f"Algorithm 1 as printed on {len(others)} random layouts of {grid.size} cells: mean steps of each, runs "
        f"cut at {most_steps:,}",
        head=("layout", *(f"{robots} robots" for robots in paper.TEAMS)),
        rows=tuple(rows),
    )


def _slashed(values: Sequence[float]) -> str:
    """Numbers as text with slashes between them."""
    return " / ".join(f"{value:,.0f}" for value in values)


def _trend(means: Sequence[float], who: str) -> str:
    """Whether the mean falls with every robot."""
    rises = [m for m, before, after in zip(paper.TEAMS[1:], means[:-1], means[1:], strict=True) if after >= before]
    if not rises:
        return f"{who} it falls with every robot" + (";" if who[0].isupper() else " too")
    return f"{who} it rises from {rises[0] - 1} to {rises[0]} robots" + (";" if who[0].isupper() else "")


def _curves(by_team: dict[tuple[BounceMethod, int], CoverRuns]) -> CurvePanel:
    """Mean steps over the size of the team, by method, with the least and the most as a band."""
    at = np.array(paper.TEAMS, float)
    curves = []
    for method in METHODS:
        steps = [by_team[method, robots].steps for robots in paper.TEAMS]
        band = np.array([[values.min() for values in steps], [values.max() for values in steps]], float)
        mean = np.array([values.mean() for values in steps])
        curves.append(Curve(TOLD[method], mean, COLOURS[method], at=at, band=band))
    return CurvePanel(
        title="(b) Steps to cover all cells",
        curves=tuple(curves),
        across="robots",
        up="steps",
        logarithmic=True,
        first_across=float(paper.TEAMS[0]),
    )


def figure_9_section(runs: Runs) -> Section:
    """Figure 9: ten robots on 20 x 12 cells, and how often they enter each."""
    mission = maps.room(maps.ROOM_20, paper.ROBOTS_FIGURE_9, paper.COVER_ANGLE_DEG)
    by_method = {method: runs.cover(mission, method) for method in METHODS}
    printed, improved = (by_method[method] for method in METHODS)
    until = {method: each.until[each.until >= 0] for method, each in by_method.items()}
    panels: list[Panel] = [
        starts_panel("(a) Random starts of ten robots", _drawn(runs, mission, "as_printed", 0, ways=False))
    ]
    for letter, method in zip("bc", METHODS, strict=True):
        method_runs = by_method[method]
        note = f"{method_runs.share[0]:.1%} of {method_runs.cells} free cells after {method_runs.steps[0]:,} steps"
        entries = runs.drawn(mission, method, runs.starts[0], ways=False).entries
        panels.append(entries_panel(f"({letter}) Times entered, {TOLD[method]}", mission, entries, note))
    rows = [
        (TOLD[method], f"{len(until[method])} of {len(each.seeds)}", plus_minus(until[method]), *_row(each))
        for method, each in by_method.items()
    ]
    early = float(np.mean(until["as_printed"])) if len(until["as_printed"]) else np.inf
    reached = f"{paper.COVERED_FIGURE_9:.0%}"
    table = Table(
        title=f"Ten robots on 20 x 12 cells by 135°, {len(printed.seeds)} random starts, mean ± deviation",
        head=("Algorithm 1", f"runs to {reached}", f"steps to {reached}", "complete", "steps to all", *HEAD[2:]),
        rows=(("**the paper**", "1 of 1", "not printed", "0 of 1", *["not printed"] * 4), *rows),
    )
    return Section(
        figure=9,
        heading="ten robots in a larger room",
        pictures=(
            Picture(
                "alam2020-figure-9.png",
                "Ten robots in a room of 20 x 12 cells, and heat maps of how often they enter each by both methods",
                tuple(panels),
                columns=1,
            ),
        ),
        caption="Figure 9, on a layout of ours. The first start of the table's runs; dark cells are entered seldom.",
        paper=f"Ten robots from a random start cover {reached} (Figure 9b); how many steps that takes is not printed.",
        ours=f"As printed, {printed.complete.sum()} of {len(printed.seeds)} starts lead to full coverage: {reached} "
        f"after {plus_minus(until['as_printed'])} steps, everything after {plus_minus(printed.steps)}. "
        + ("Most of the time goes into the last cells. " if 2 * early < float(printed.steps.mean()) else "")
        + f"Improved: {plus_minus(until['improved'])} and {plus_minus(improved.steps)} ({improved.complete.sum()} of "
        f"{len(improved.seeds)} complete).",
        tables=(table,),
        verdicts=(large_room_verdict(by_method),),
    )
