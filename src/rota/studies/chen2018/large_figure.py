"""Figure 21: a thousand robots among obstacles."""

from __future__ import annotations

from rota.draw.curve_panel import Curve, CurvePanel
from rota.draw.map_panel import MapPanel
from rota.draw.study_picture import study_picture
from rota.studies.chen2018 import maps, paper
from rota.studies.chen2018.panels import COLOURS, coverage_panel, ways_panel
from rota.studies.chen2018.runs import EXACT, FILTERED, FORCES, SAMPLED, SETTLE, VORONOI, Job, Runs
from rota.studies.section import Picture, Section
from rota.studies.tables import Table

CONTROLLERS = (SAMPLED, EXACT, FILTERED, VORONOI, FORCES, SETTLE)
MOMENTS = (500, 1000, 2000, 3000)
JAMMED = 0.6  # of the ground: less than that is in range of robots that hardly move


def figure_21_section(runs: Runs) -> Section:
    """Figure 21: the large case."""
    mission = maps.large(runs.settings.large_robots)
    steps = runs.settings.large_steps
    jobs = [Job(mission, controller, runs.seed, steps) for controller in CONTROLLERS]
    found = dict(zip((controller.name for controller in CONTROLLERS), runs.all(jobs), strict=True))
    shown = found[EXACT.name]
    panels: list[MapPanel | CurvePanel] = [
        coverage_panel("(a) Start", mission, shown, 0),
        ways_panel("(b) RD: ways", mission, shown, steps),
        coverage_panel("(c) RD: end", mission, shown, steps),
        coverage_panel("(d) V-based: end", mission, found[VORONOI.name], steps),
        coverage_panel("(e) VFA: end", mission, found[FORCES.name], steps),
        coverage_panel("(f) settle: end", mission, found[SETTLE.name], steps),
    ]
    curves = [
        Curve(name, 100 * found[name].history.coverage, COLOURS[name])
        for name in (SAMPLED.name, EXACT.name, VORONOI.name, FORCES.name, SETTLE.name)
    ]
    panels.append(CurvePanel(title="(g) Coverage rate", curves=tuple(curves), across="step k", up="%", wide=True))
    rows = []
    for name, outcome in found.items():
        at = (f"{100 * outcome.history.coverage[min(step, outcome.steps)]:.1f}" for step in MOMENTS)
        least = float(outcome.history.body_gap_m.min()) + 2 * paper.BODY_M
        rest = f"{outcome.steps:,}" if outcome.at_rest else "not by then"
        rows.append(
            (name, rest, *at, f"{100 * outcome.coverage:.2f}", f"{least:.3f}", f"{outcome.history.way_m[-1]:,.0f}")
        )
    table = Table(
        title=f"{len(shown.places_m[0]):,} robots, one seed: at rest at step, coverage %, least distance of "
        "middles, way",
        head=("controller", "at rest", *(f"k = {step:,}" for step in MOMENTS), "end", "least m", "way m"),
        rows=(("**the paper**", f"{paper.STEPS_FIGURE_21:,}", *["not printed"] * 5, "above 1", "not printed"), *rows),
        words=(0,),
    )
    least_m = float(shown.history.body_gap_m.min()) + 2 * paper.BODY_M
    stuck = float(shown.history.way_m[-1])
    return Section(
        figure=21,
        heading="a thousand robots",
        pictures=(
            Picture(
                "chen2018-figure-21.png",
                "A thousand robots in a corner box, and what they cover in the end by four controllers",
                study_picture(panels),
            ),
        ),
        caption="Figure 21, from a corner box as the paper's text has it; the four obstacles are ours. One seed, "
        "since a "
        "run takes long. Disc by disc at most about 95.5 % can be covered without obstacles.",
        paper=f"The algorithm is converged at {paper.STEPS_FIGURE_21:,} (“t”, which must be steps) and has "
        "collision-free "
        "interaction and excellent scalability.",
        found=("By our reading RD jams: it covers " if shown.coverage < JAMMED else "RD covers ")
        + f"{shown.coverage:.1%} "
        + (f"at rest after {shown.steps:,} steps" if shown.at_rest else f"after {shown.steps:,} steps, not at rest")
        + f", with ways of {stuck:,.0f} m on average; V-based {found[VORONOI.name].coverage:.1%}, VFA "
        f"{found[FORCES.name].coverage:.1%}, settle {found[SETTLE.name].coverage:.1%}. Inside the box a robot is "
        "surrounded by its 4 nearest from the start: its set is empty, Algorithm 2 gives it velocity 0, and it stays "
        "until those outside have gone; (b) shows that only the outer robots move. "
        + ("No two bodies touch" if least_m >= 2 * paper.BODY_M else "Bodies touch")
        + f": the least distance is {least_m:.3f} m. What else the "
        "paper's program did with empty sets is not told.",
        tables=(table,),
    )
