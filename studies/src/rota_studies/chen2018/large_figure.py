"""Figure 21: a thousand robots among obstacles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rota.geometry.free_space import free_ground
from rota.model.mission import Mission
from rota.planners.swarm.planner import make_swarm
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.sorted_robots import Beginning
from rota.planners.swarm.starts import place_starts
from rota_studies import records
from rota_studies.chen2018 import maps, paper
from rota_studies.chen2018.panels import COLOURS, coverage_panel, ways_panel
from rota_studies.chen2018.runs import (
    EXACT,
    FILTERED,
    FORCES,
    SETTLE,
    VORONOI,
    Controller,
    Job,
    Outcome,
    Runs,
    covered_in,
    what,
)
from rota_studies.panels.curve_panel import Curve, CurvePanel
from rota_studies.panels.map_panel import MapPanel
from rota_studies.section import Picture, Section
from rota_studies.tables import Table, joined, plus_minus
from rota_studies.verdict import Verdict, mostly

CONTROLLERS = (EXACT, FILTERED, VORONOI, FORCES, SETTLE)
MOMENTS = (500, 1000, 2000, 3000)
JAMMED = 0.6  # of the ground: less than that is in range of robots that hardly move


def figure_21_section(runs: Runs) -> Section:
    """Figure 21: the large case."""
    mission = maps.large(runs.settings.large_robots)
    steps = runs.settings.large_steps
    jobs = [Job(mission, controller, runs.seed, steps, drawn=True) for controller in CONTROLLERS]
    by_controller = dict(zip((controller.name for controller in CONTROLLERS), runs.all(jobs), strict=True))
    shown = by_controller[EXACT.name]
    places, ends = by_start(runs)
    least_m = shown.least_m
    stuck = float(shown.way_m[-1])
    return Section(
        figure=21,
        heading="a thousand robots",
        pictures=(
            Picture(
                "chen2018-figure-21.png",
                "A thousand robots in a corner box, and what they cover in the end by four controllers",
                tuple(_panels(mission, by_controller, steps)),
            ),
        ),
        caption="Figure 21, from a box in the corner, which is our choice, as are the four obstacles: the paper's "
        "picture shows both, its text tells neither. Pictures and the first table: one seed. Disc by disc at most "
        "about 95.5 % can be covered without obstacles.",
        paper=f"The algorithm is converged at {paper.STEPS_FIGURE_21:,} (“t”, which must be steps) and has "
        "collision-free interaction and excellent scalability.",
        ours=("By our reading RD all but jams: it covers " if shown.coverage < JAMMED else "RD covers ")
        + f"{shown.coverage:.1%} "
        + (f"at rest after {shown.steps:,} steps" if shown.at_rest else f"after {shown.steps:,} steps, not at rest")
        + f", with ways of {stuck:,.0f} m on average; V-based {by_controller[VORONOI.name].coverage:.1%}, VFA "
        f"{by_controller[FORCES.name].coverage:.1%}, settle {by_controller[SETTLE.name].coverage:.1%}. Inside the box "
        "a robot is surrounded by its 4 nearest from the start: its set is empty, Algorithm 2 gives it velocity 0, and "
        "it stays until those outside have gone; (b) shows that only the outer robots move. It is no standstill: it "
        f"creeps on, {_creeping(runs)} (the same seed, from the corner). The start box decides how far it comes by "
        f"step {steps:,} (last table). "
        + ("By RD no two bodies touch" if least_m >= 2 * paper.BODY_M else "By RD bodies touch")
        + f": the least distance of middles is {least_m:.3f} m. What else the paper's program did with empty sets is "
        "not told.",
        tables=(_table(by_controller), places),
        verdicts=(_verdict(ends, by_controller[SETTLE.name], steps),),
    )


def _panels(mission: Mission, by_controller: dict[str, Outcome], steps: int) -> list[MapPanel | CurvePanel]:
    """The start, what each controller comes to, and how the coverage grows."""
    shown = by_controller[EXACT.name]
    panels: list[MapPanel | CurvePanel] = [
        coverage_panel("(a) Start", mission, shown, 0),
        ways_panel("(b) RD: ways", mission, shown, steps),
        coverage_panel("(c) RD: end", mission, shown, steps),
        coverage_panel("(d) V-based: end", mission, by_controller[VORONOI.name], steps),
        coverage_panel("(e) VFA: end", mission, by_controller[FORCES.name], steps),
        coverage_panel("(f) settle: end", mission, by_controller[SETTLE.name], steps),
    ]
    curves = [
        Curve(
            name, 100 * (one := by_controller[name]).covered, COLOURS[name], at=one.at.astype(np.float64), marked=False
        )
        for name in (EXACT.name, VORONOI.name, FORCES.name, SETTLE.name)
    ]
    panels.append(CurvePanel(title="(g) Coverage rate", curves=tuple(curves), across="step k", up="%", wide=True))
    return panels


def _table(by_controller: dict[str, Outcome]) -> Table:
    """What each controller comes to by which step."""
    rows, robots = [], len(by_controller[EXACT.name].drawn.places_m[0])
    for name, outcome in by_controller.items():
        at = (f"{100 * outcome.covered[outcome.row(step)]:.1f}" for step in MOMENTS)
        rest = f"{outcome.steps:,}" if outcome.at_rest else "not by then"
        rows.append(
            (name, rest, *at, f"{100 * outcome.coverage:.2f}", f"{outcome.least_m:.3f}", f"{outcome.way_m[-1]:,.0f}")
        )
    return Table(
        title=f"{robots:,} robots, one seed: at rest at step, coverage %, least distance of middles, way",
        head=("controller", "at rest", *(f"k = {step:,}" for step in MOMENTS), "end", "least m", "way m"),
        rows=(("**the paper**", f"{paper.STEPS_FIGURE_21:,}", *["not printed"] * 5, "above 1", "not printed"), *rows),
        words=(0,),
    )


class Ends(NamedTuple):
    """Percent covered at some steps, rising, and whether robots had come to rest by the last one."""

    percents: tuple[float, ...]
    at_rest: bool


def by_start(runs: Runs) -> tuple[Table, dict[maps.LargeStart, list[Ends]]]:
    """RD's coverage at the last step by the place of the start box, some seeds each, as a table and run by run."""
    steps, seeds = runs.settings.large_steps, runs.some(runs.settings.large_seeds)
    asked = [(start, EXACT, seed) for start in maps.LARGE_STARTS_M for seed in seeds]
    ends = dict(zip(asked, _ends(runs, asked, (steps,)), strict=True))
    found = {start: [ends[start, EXACT, seed] for seed in seeds] for start in maps.LARGE_STARTS_M}
    cells = (plus_minus([one.percents[-1] for one in many], ".1f") for many in found.values())
    rested = (f"{sum(one.at_rest for one in many)} of {len(many)}" for many in found.values())
    table = Table(
        title=f"RD at k = {steps:,} by the place of the start box, {len(seeds)} seeds each",
        head=("", *found),
        rows=(("covered %", *cells), ("at rest", *rested)),
    )
    return table, found


def _ends(runs: Runs, asked: Sequence[tuple[maps.LargeStart, Controller, int]], moments: tuple[int, ...]) -> list[Ends]:
    """What runs by start, controller and seed cover at some steps; they are not observed in between."""

    def make(mission: Mission, seed: int, doing: str) -> Ends:
        """One run to the last moment; where all rest before, the moments after are alike."""
        runs.now(doing)
        ground = free_ground(mission)
        starts = place_starts(mission, ground, seed=seed, reserve_m=0.0)
        swarm = make_swarm(mission, ground, Beginning(starts), seed=seed)
        percents, moved_m = [], np.inf
        for moment in moments:
            while swarm.steps < moment and moved_m > 0.0:
                moved_m = swarm.step()
                if swarm.steps % 100 == 0:
                    runs.stop_if_asked()
            percents.append(100 * covered_in(mission, swarm.places_m))
        return Ends(tuple(percents), bool(moved_m <= SwarmSettings.of(mission).stop_m))

    jobs = []
    for start, controller, seed in asked:
        mission = replace(maps.large(runs.settings.large_robots, start), planning=controller.settings)
        doing = f"1,000 robots, {start}: {controller.name}, seed {seed}, to step {moments[-1]:,}"
        jobs.append(
            records.Job(
                {"what": "ends", **what(mission, controller), "seed": seed, "moments": moments},
                lambda mission=mission, seed=seed, doing=doing: make(mission, seed, doing),  # type: ignore[misc]
            )
        )
    found: list[Ends] = runs.records.get_all(Ends, jobs)
    return found


def _creeping(runs: Runs) -> str:
    """How RD goes on after the steps of the paper, in words."""
    moments = (runs.settings.long_steps // 2, runs.settings.long_steps)
    (ends,) = _ends(runs, [("corner", EXACT, runs.seed)], moments)
    return joined([f"to {value:.1f} % at {step:,}" for value, step in zip(ends.percents, moments, strict=True)])


def _verdict(ends: dict[maps.LargeStart, list[Ends]], settled: Outcome, steps: int) -> Verdict:
    """Section 5.2: a thousand robots converge, with excellent scalability."""
    told = joined([
        f"{np.mean([one.percents[-1] for one in many]):.1f} % from the {start}" for start, many in ends.items()
    ])  # fmt: skip
    rest = mostly([one.at_rest for many in ends.values() for one in many], ours=True)
    return Verdict(
        f"1,000 UAVs converge within {paper.STEPS_FIGURE_21:,} steps", "5.2, Figure 21", rest.outcome,
        f"RD by our reading is at rest by then in {rest.told}, from three places of the start box: {told} covered. "
        "settle "
        + (f"is at rest after {settled.steps:,} steps" if settled.at_rest else f"is not at rest after {steps:,} either")
        + f" and covers {settled.coverage:.1%} (one run). What the paper did with empty sets is not told.",
    )  # fmt: skip
