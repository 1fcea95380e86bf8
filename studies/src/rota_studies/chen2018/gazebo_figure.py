"""Figure 23 (Section 5.3): sixteen robots with square sensors, which the paper ran in ROS and Gazebo."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rota_studies.chen2018 import maps, paper
from rota_studies.chen2018.panels import coverage_panel
from rota_studies.chen2018.runs import EXACT, FILTERED, FORCES, SAMPLED, SETTLE, VORONOI, Outcome, Runs
from rota_studies.chen2018.small_figures import coverage_cell, rest_cells
from rota_studies.section import Picture, Section
from rota_studies.tables import NOTHING, Table, plus_minus
from rota_studies.verdict import Verdict, mostly

CONTROLLERS = (SAMPLED, EXACT, FILTERED, VORONOI, FORCES, SETTLE)
SHOWS = "Sixteen squares that spread over a square"
LATEST = 1.5  # times the paper's seconds, by when robots count as at rest
SHOWN_S = (0.0, 2.0, paper.GAZEBO_REST_S)
MOST = paper.GAZEBO_ROBOTS * paper.GAZEBO_SENSOR_M**2 / paper.GAZEBO_SIDE_M**2


def figure_23_section(runs: Runs) -> Section:
    """Figure 23: the run of Section 5.3."""
    mission = maps.gazebo()
    seeds = runs.settings.claim_seeds
    by_controller = {controller.name: runs.seeds(mission, controller, seeds) for controller in CONTROLLERS}
    shown = runs(mission, EXACT)
    steps = [round(time_s / paper.STEP_S) for time_s in SHOWN_S]
    panels = [
        coverage_panel(f"({letter}) RD, t = {time_s:g} s", mission, shown, step)
        for letter, time_s, step in zip("abc", SHOWN_S, steps, strict=True)
    ]
    rows = [
        (name, *rest_cells(outcomes), plus_minus(_covered_at(outcomes, steps[-1]), ".1f"), coverage_cell(outcomes))
        for name, outcomes in by_controller.items()
    ]
    table = Table(
        title=f"16 robots, square sensors, {len(by_controller[EXACT.name])} seeds, at most {runs.settings.steps:,} "
        f"steps of {paper.STEP_S:g} s",
        head=("controller", "at rest", "steps", "least to most", f"covered % at {paper.GAZEBO_REST_S:g} s",
              "covered % in the end"),
        rows=(("**the paper**", "1 of 1", f"{paper.GAZEBO_REST_S / paper.STEP_S:.0f}", "", "not "
        "printed", NOTHING), *rows),
    )  # fmt: skip
    return Section(
        figure=23,
        heading="Section 5.3, sixteen robots with square sensors",
        pictures=(Picture("chen2018-figure-23.png", SHOWS, tuple(panels), columns=3),),
        caption="Figure 23, at the paper's three moments. Start box (40 m, in the middle), body and time step are "
        "ours. The planner spreads the discs within the squares; squares are what is measured.",
        paper="In ROS and Gazebo 16 UAVs at up to 20 m/s reach “steady state” and “their maximum coverage” at 10 s; no "
        "values are told, nor where they start, nor the step.",
        ours=f"{_told(by_controller[EXACT.name])} At most {MOST:.1%} can be covered. With a step of 0.25 s a robot "
        "goes up to 5 m in one, a third of its sensor's reach, so that neighbours overshoot each other. Robots here "
        "decide all at once in one process; those of Figure 22 do not.",
        tables=(table,),
        verdicts=(_verdict(by_controller[EXACT.name]),),
    )  # fmt: skip


def _covered_at(outcomes: Sequence[Outcome], step: int) -> list[float]:
    """Percent covered at a step, run by run."""
    return [100 * float(run.covered[run.row(step)]) for run in outcomes]


def _told(outcomes: Sequence[Outcome]) -> str:
    """How many runs come to rest, when, and what they cover, in words."""
    rested = [run.steps * paper.STEP_S for run in outcomes if run.at_rest]
    covered = np.mean([run.coverage for run in outcomes])
    when = f", after {plus_minus(rested, '.0f')} s" if rested else ""
    return f"RD comes to rest in {len(rested)} of {len(outcomes)} runs{when}, and covers {covered:.1%} in the end."


def _verdict(outcomes: Sequence[Outcome]) -> Verdict:
    """The verdict on the time at which 16 robots are at rest."""
    within = mostly(
        [run.at_rest and run.steps * paper.STEP_S <= LATEST * paper.GAZEBO_REST_S for run in outcomes], ours=True
    )
    return Verdict(
        "16 UAVs are at rest after 10 s, with the most coverage they can have", "5.3, Figure 23", within.outcome,
        f"At rest within {LATEST * paper.GAZEBO_REST_S:g} s in {within.told}. {_told(outcomes)} Start, step and the "
        "aircraft's dynamics are not told.",
    )  # fmt: skip
