"""Figure 21: a thousand robots among obstacles."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from rota.draw.panels.curve_panel import Curve, CurvePanel
from rota.draw.panels.map_panel import MapPanel
from rota.draw.panels.study_picture import study_picture
from rota.geometry.free_space import free_ground
from rota.mission import Mission
from rota.papers.chen2018 import maps, paper
from rota.papers.chen2018.panels import COLOURS, coverage_panel, ways_panel
from rota.papers.chen2018.runs import (
    AT_A_TIME,
    EXACT,
    FILTERED,
    FORCES,
    SAMPLED,
    SETTLE,
    VORONOI,
    Controller,
    Job,
    Outcome,
    Runs,
    covered_in,
)
from rota.papers.chen2018.small_figures import plus_minus
from rota.papers.section import Picture, Section, Verdict
from rota.papers.tables import Table, joined
from rota.planners.swarm.planner import make_swarm
from rota.planners.swarm.rollout import Beginning
from rota.planners.swarm.starts import place_starts

CONTROLLERS = (SAMPLED, EXACT, FILTERED, VORONOI, FORCES, SETTLE)
PLACED = (EXACT, VORONOI, FORCES, SETTLE)
SEEDS = 2  # of each place of the start box
MOMENTS = (500, 1000, 2000, 3000)
JAMMED = 0.6  # of the ground: less than that is in range of robots that hardly move


def figure_21_section(runs: Runs) -> Section:
    """Figure 21: the large case."""
    mission = maps.large(runs.settings.large_robots)
    steps = runs.settings.large_steps
    jobs = [Job(mission, controller, runs.seed, steps) for controller in CONTROLLERS]
    by_controller = dict(zip((controller.name for controller in CONTROLLERS), runs.all(jobs), strict=True))
    shown = by_controller[EXACT.name]
    places, ends = by_start(runs)
    least_m = float(shown.history.body_gap_m.min()) + 2 * paper.BODY_M
    stuck = float(shown.history.way_m[-1])
    return Section(
        figure=21,
        heading="a thousand robots",
        pictures=(
            Picture(
                "chen2018-figure-21.png",
                "A thousand robots in a corner box, and what they cover in the end by four controllers",
                study_picture(_panels(mission, by_controller, steps)),
            ),
        ),
        caption="Figure 21, from a box in the corner, which is our choice, as are the four obstacles: the paper's "
        "picture "
        "shows both, its text tells neither. Pictures and the first table: one seed. Disc by disc at most about "
        "95.5 % can "
        "be covered without obstacles.",
        paper=f"The algorithm is converged at {paper.STEPS_FIGURE_21:,} (“t”, which must be steps) and has "
        "collision-free "
        "interaction and excellent scalability.",
        ours=("By our reading RD all but jams: it covers " if shown.coverage < JAMMED else "RD covers ")
        + f"{shown.coverage:.1%} "
        + (f"at rest after {shown.steps:,} steps" if shown.at_rest else f"after {shown.steps:,} steps, not at rest")
        + f", with ways of {stuck:,.0f} m on average; V-based {by_controller[VORONOI.name].coverage:.1%}, VFA "
        f"{by_controller[FORCES.name].coverage:.1%}, settle {by_controller[SETTLE.name].coverage:.1%}. Inside the box "
        "a robot is surrounded by its 4 nearest from the start: its set is empty, Algorithm 2 gives it velocity 0, and "
        "it stays until those outside have gone; (b) shows that only the outer robots move. It is no standstill: it "
        "creeps on, "
        f"{_creeping(runs)} (the same seed, from the corner). The start box decides how far it comes by step "
        f"{steps:,} (last table). "
        + ("By RD no two bodies touch" if least_m >= 2 * paper.BODY_M else "By RD bodies touch")
        + f": the least distance of middles is {least_m:.3f} m. What else the "
        "paper's program did with empty sets is not told.",
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
        Curve(name, 100 * by_controller[name].history.coverage, COLOURS[name])
        for name in (SAMPLED.name, EXACT.name, VORONOI.name, FORCES.name, SETTLE.name)
    ]
    panels.append(CurvePanel(title="(g) Coverage rate", curves=tuple(curves), across="step k", up="%", wide=True))
    return panels


def _table(by_controller: dict[str, Outcome]) -> Table:
    """What each controller comes to by which step."""
    rows, robots = [], len(by_controller[EXACT.name].places_m[0])
    for name, outcome in by_controller.items():
        at = (f"{100 * outcome.history.coverage[min(step, outcome.steps)]:.1f}" for step in MOMENTS)
        least = float(outcome.history.body_gap_m.min()) + 2 * paper.BODY_M
        rest = f"{outcome.steps:,}" if outcome.at_rest else "not by then"
        rows.append(
            (name, rest, *at, f"{100 * outcome.coverage:.2f}", f"{least:.3f}", f"{outcome.history.way_m[-1]:,.0f}")
        )
    return Table(
        title=f"{robots:,} robots, one seed: at rest at step, coverage %, least distance of middles, way",
        head=("controller", "at rest", *(f"k = {step:,}" for step in MOMENTS), "end", "least m", "way m"),
        rows=(("**the paper**", f"{paper.STEPS_FIGURE_21:,}", *["not printed"] * 5, "above 1", "not printed"), *rows),
        words=(0,),
    )


def by_start(runs: Runs) -> tuple[Table, dict[str, list[float]]]:
    """Coverage at the last step by the place of the start box, two seeds each; and RD's by the place."""
    steps = runs.settings.large_steps
    seeds = [runs.seed + k for k in range(SEEDS)]
    jobs = [(start, controller, seed) for start in maps.LARGE_STARTS_M for controller in PLACED for seed in seeds]
    with ThreadPoolExecutor(AT_A_TIME) as pool:
        ends = dict(
            zip(jobs, pool.map(lambda job: _ends(runs, job[0], job[1], job[2], (steps,))[0], jobs), strict=True)
        )
    rows = tuple(
        (
            controller.name,
            *(
                plus_minus([ends[start, controller, runs.seed + k] for k in range(SEEDS)], ".1f")
                for start in maps.LARGE_STARTS_M
            ),
        )
        for controller in PLACED
    )
    table = Table(
        title=f"Coverage % at k = {steps:,} by the place of the start box, {SEEDS} seeds",
        head=("controller", *(f"{start}" for start in maps.LARGE_STARTS_M)),
        rows=rows,
    )
    return table, {start: [ends[start, EXACT, runs.seed + k] for k in range(SEEDS)] for start in maps.LARGE_STARTS_M}


def _ends(
    runs: Runs, start: maps.LargeStart, controller: Controller, seed: int, moments: tuple[int, ...]
) -> list[float]:
    """Percent covered at some steps, rising, of a run that is not observed in between."""
    runs.stop_if_asked()
    runs.tell(f"1,000 robots, {start}: {controller.name}, seed {seed}, to step {moments[-1]:,}")
    mission = replace(maps.large(runs.settings.large_robots, start), planning=controller.settings)
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
    return percents


def _creeping(runs: Runs) -> str:
    """How RD goes on after the steps of the paper, in words."""
    moments = (runs.settings.long_steps // 2, runs.settings.long_steps)
    values = _ends(runs, "corner", EXACT, runs.seed, moments)
    return joined([f"to {value:.1f} % at {step:,}" for value, step in zip(values, moments, strict=True)])


def _verdict(ends: dict[str, list[float]], settled: Outcome, steps: int) -> Verdict:
    """Section 5.2: a thousand robots converge, with excellent scalability."""
    told = joined([f"{np.mean(values):.1f} % from the {start}" for start, values in ends.items()])
    better = settled.at_rest and settled.steps <= paper.STEPS_FIGURE_21
    return Verdict(
        f"1,000 UAVs converge within {paper.STEPS_FIGURE_21:,} steps", "5.2, Figure 21",
        "bettered" if better else "does not hold",
        f"RD by our reading is not at rest by then: {told} covered. settle "
        + (f"is at rest after {settled.steps:,}" if settled.at_rest else f"is not at rest after {steps:,} either")
        + f" and covers {settled.coverage:.1%}. What the paper did with empty sets is not told.",
    )  # fmt: skip
