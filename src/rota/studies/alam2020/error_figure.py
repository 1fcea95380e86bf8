"""Extra figure 12: robots whose turns and moves are inexact, which the paper leaves to future work."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rota.draw.curve_panel import Curve, CurvePanel
from rota.draw.palette import ROUTE_COLOURS
from rota.draw.study_picture import Panel, study_picture
from rota.mission import Mission
from rota.planners.bounce.cells import Cells, make_cells
from rota.planners.bounce.rotation_error import (
    AngleOutcome,
    CycleHold,
    MotionError,
    anywhere,
    compare_angles,
    hold_of_cycles,
    motion_chain,
    sample_walks,
    seen_chances,
)
from rota.studies.alam2020 import maps, paper
from rota.studies.alam2020.panels import chances_panel
from rota.studies.alam2020.runs import Runs
from rota.studies.section import Picture, Section
from rota.studies.tables import NOTHING, Table, joined

Floats = NDArray[np.float64]

EXACT = MotionError()
SHOWN = MotionError(angle_rad=math.radians(10))
ERRORS = {
    "turns ± 5°": MotionError(angle_rad=math.radians(5)),
    "turns ± 10°": SHOWN,
    "turns ± 20°": MotionError(angle_rad=math.radians(20)),
    "turns ± 10°, moves ± 5 %": MotionError(angle_rad=math.radians(10), step=0.05),
    "turns 10° Gaussian": MotionError(angle_rad=math.radians(10), shape="gaussian"),
}
SHOWN_ANGLE_DEG = 135.0
LISTED_CYCLES = 3
MOST_STEPS = 1  # for bounds of cover times, which the page does not tell


def figure_12_section(runs: Runs) -> Section:
    """What errors of rotation and translation do to one robot in the room of Figure 7."""
    mission = maps.room(maps.ROOM_10, 1, SHOWN_ANGLE_DEG)
    cells = make_cells(mission)
    steps = runs.settings.error_steps
    seen: dict[tuple[float, bool], Floats] = {}
    for angle in paper.ANGLES_DEG:
        for inexact, error in ((False, EXACT), (True, SHOWN)):
            runs.now(f"figure 12: chances by {angle:g}°")
            seen[angle, inexact] = seen_chances(motion_chain(cells, _turn(cells, angle), error), anywhere(cells), steps)
    outcomes = {}
    for told, error in ERRORS.items():
        runs.now(f"figure 12: all angles, {told}")
        outcomes[told] = compare_angles(cells, error, steps, most_steps=MOST_STEPS)
    runs.now("figure 12: walks")
    gap = _simulated_gap(cells, seen[SHOWN_ANGLE_DEG, True], runs)
    holds = {angle: hold_of_cycles(motion_chain(cells, _turn(cells, angle), SHOWN)) for angle in paper.ANGLES_DEG}
    by_mean = {told: max(found, key=lambda one: one.mean_chance) for told, found in outcomes.items()}
    by_least = {told: found[0] for told, found in outcomes.items()}
    exact_best = max(next(iter(outcomes.values())), key=lambda one: one.exact_mean)
    return Section(
        figure=12,
        extra=True,
        heading="one robot that turns inexactly",
        pictures=(
            Picture(
                "alam2020-figure-12.png",
                "Chances that each cell of a room is seen by an exact and an inexact robot, and their mean by step",
                study_picture(_panels(mission, cells, seen, steps)),
            ),
        ),
        caption=f"The room of Figure 7; a start in any cell with any heading. (a) and (b): chance in percent that a "
        f"cell was entered after {steps} steps. (c): its mean over all cells; dashed without errors, drawn through "
        "with turns uniform within 10° of the bouncing angle.",
        paper="Section 6 leaves “a bounded uncertainty for both rotation and translation” and “a probabilistic "
        "variant of our method” to the future; no numbers.",
        found=f"The bounce map as a Markov chain. Errors help to cover: by {SHOWN_ANGLE_DEG:g}° a robot sees a cell "
        f"with a mean chance of {seen[SHOWN_ANGLE_DEG, False][-1].mean():.1%} when exact and "
        f"{seen[SHOWN_ANGLE_DEG, True][-1].mean():.1%} with turns ± 10°, since it does not stay on a limit cycle for "
        f"ever. The exact robot sees most by {_degrees(exact_best)}; with errors the most robust angle by the mean is "
        + _best(by_mean)
        + ", by the cell least likely seen "
        + _best(by_least)
        + f". {runs.settings.walks:,} simulated robots come within {gap:.1%} of the chain's chance in every cell at "
        "every step.",
        tables=(_angles_table(outcomes, steps), _holds_table(holds)),
    )  # fmt: skip


def _turn(cells: Cells, angle_deg: float) -> int:
    return round(angle_deg * cells.headings / 360)


def _degrees(outcome: AngleOutcome) -> str:
    return f"{math.degrees(outcome.angle_rad):.0f}°"


def _best(found: dict[str, AngleOutcome]) -> str:
    """The best angle of each error, in words; one alone when it is the same for all."""
    angles: dict[str, list[str]] = {}
    for told, one in found.items():
        angles.setdefault(_degrees(one), []).append(told)
    if len(angles) == 1:
        return f"{next(iter(angles))} for all of the table's errors"
    return joined([f"{angle} ({'; '.join(told)})" for angle, told in angles.items()])


def _simulated_gap(cells: Cells, chances: Floats, runs: Runs) -> float:
    """The largest difference between the chain's chances and shares of simulated walks, over cells and steps."""
    chain = motion_chain(cells, _turn(cells, SHOWN_ANGLE_DEG), SHOWN)
    shares, _ = sample_walks(chain, anywhere(cells), walks=runs.settings.walks, steps=len(chances) - 1, seed=runs.seed)
    return float(np.abs(shares - chances).max())


def _panels(mission: Mission, cells: Cells, seen: dict[tuple[float, bool], Floats], steps: int) -> list[Panel]:
    panels: list[Panel] = []
    for letter, inexact, told in (("a", False, "exact"), ("b", True, "turns ± 10°")):
        chances = seen[SHOWN_ANGLE_DEG, inexact][-1]
        note = f"mean {chances.mean():.1%}, least {chances.min():.1%}"
        panels.append(chances_panel(f"({letter}) {SHOWN_ANGLE_DEG:g}°, {told}: seen, %", mission, cells, chances, note))
    curves = tuple(
        Curve(
            f"{angle:g}°, {'± 10°' if inexact else 'exact'}", 100 * seen[angle, inexact].mean(axis=1),
            ROUTE_COLOURS[k], "solid" if inexact else (0.0, (4.0, 2.0)), marked=False,
        )
        for k, angle in enumerate(paper.ANGLES_DEG)
        for inexact in (False, True)
    )  # fmt: skip
    panels.append(
        CurvePanel(title="(c) Mean chance that a cell was seen", curves=curves, across="steps", up="%", wide=True)
    )
    return panels


def _angles_table(outcomes: dict[str, tuple[AngleOutcome, ...]], steps: int) -> Table:
    angles = sorted({one.angle_rad for one in next(iter(outcomes.values()))})
    rows = []
    for angle in angles:
        of = {told: next(one for one in found if one.angle_rad == angle) for told, found in outcomes.items()}
        exact = next(iter(of.values()))
        rows.append(
            (
                f"{math.degrees(angle):.0f}°", _pair(exact.exact_mean, exact.exact_least),
                *(_pair(one.mean_chance, one.least_chance) for one in of.values()),
            )
        )  # fmt: skip
    return Table(
        title=f"Chance that a cell was seen after {steps} steps, %: mean of all cells / the least of any",
        head=("bouncing angle", "exact", *outcomes),
        rows=tuple(rows),
    )


def _pair(mean: float, least: float) -> str:
    return f"{100 * mean:.1f} / {100 * least:.1f}"


def _holds_table(holds: dict[float, tuple[CycleHold, ...]]) -> Table:
    rows = []
    for angle, found in holds.items():
        for number, hold in enumerate(found[:LISTED_CYCLES], start=1):
            lasts = f"{hold.basin_steps:,.0f}" if math.isfinite(hold.basin_steps) else "for ever"
            rows.append(
                (
                    f"{angle:g}°", f"{number} of {len(found)}", f"{hold.steps:,}", f"{hold.basin:,}",
                    f"{hold.leave_chance:.1%}", lasts,
                )
            )  # fmt: skip
    return Table(
        title="Limit cycles with the largest basins, turns ± 10°: how well they hold an inexact robot",
        head=("angle", "cycle", "steps", "basin, states", "strays in a round", "steps until in another basin"),
        rows=tuple(rows) or ((NOTHING,) * 6,),
        words=(0, 1),
    )
