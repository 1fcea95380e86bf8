"""Extra figure 12: robots whose turns are inexact, which the paper leaves to future work."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rota.draw.palette import ROUTE_COLOURS
from rota.planners.bounce.inexact_turns import Estimate
from rota_studies.alam2020 import maps, paper
from rota_studies.alam2020.claims import angles_verdict
from rota_studies.alam2020.inexact import (
    ALL_ANGLES_DEG,
    COVER_STEPS,
    CURVE_POINTS,
    ERRORS,
    EXACT,
    SHOWN,
    SHOWN_ANGLE_DEG,
    TEAMS,
    Room,
    Seen,
)
from rota_studies.alam2020.panels import chances_panel
from rota_studies.alam2020.runs import Runs
from rota_studies.panels.curve_panel import Curve, CurvePanel
from rota_studies.panels.study_picture import Panel
from rota_studies.section import Picture, Section
from rota_studies.tables import Table, joined

Floats = NDArray[np.float64]


def figure_12_section(runs: Runs) -> Section:
    """What errors of turning do to robots in the room of Figure 7."""
    room = Room.of_figure_7()
    steps = runs.settings.error_steps
    seen = {(angle, told): room.seen(runs, angle, told) for angle in ALL_ANGLES_DEG for told in ERRORS}
    teams = {team: room.cover_steps(runs, team) for team in TEAMS}
    mean = {key: chances.mean for key, chances in seen.items()}
    least = {key: chances.least for key, chances in seen.items()}
    return Section(
        figure=12,
        extra=True,
        heading="robots that turn inexactly",
        pictures=(
            Picture(
                "alam2020-figure-12.png",
                "Chances that each cell of a room is seen by an exact and an inexact robot, and their mean by step",
                _panels(room, seen, steps),
            ),
        ),
        caption=f"The room of Figure 7; a disc of radius {maps.ROOM_BODY_M:g} m in the continuous plane, from the "
        "centre of any cell with any of 8 headings. A step is the time of a mean move, or of a turn. (a) and (b): "
        f"chance in percent that a disc's centre was in a cell within {steps} steps. (c): its mean over all cells; "
        "dashed without errors, drawn through with each turn off by up to 10°, uniformly.",
        paper="Section 6 leaves “a bounded uncertainty for both rotation and translation” and “a probabilistic "
        "variant of our method” to the future; no numbers. Of exact robots: “135° and 45° angles provide better "
        "coverage” than 90° and 180° (Section 6).",
        ours=_ours(mean, least, runs.settings.walks),
        tables=(_angles_table(mean, least, steps), _cover_table(teams)),
        verdicts=(angles_verdict(seen, EXACT, SHOWN),),
    )  # fmt: skip


def _ours(mean: dict[tuple[float, str], Estimate], least: dict[tuple[float, str], Estimate], runs: int) -> str:
    """The text on our runs: the chances by angle, exact and with errors."""
    exact, inexact = mean[SHOWN_ANGLE_DEG, EXACT], mean[SHOWN_ANGLE_DEG, SHOWN]
    by_angle = {angle: mean[angle, EXACT].value for angle in (45.0, 90.0, 135.0, 180.0)}
    holds = min(by_angle[135.0], by_angle[45.0]) > max(by_angle[90.0], by_angle[180.0])
    order = ", ".join(f"{angle:g}° {100 * value:.1f}%" for angle, value in by_angle.items())
    return (
        f"{runs:,} runs of each angle and error; nothing is rounded to headings. Errors help to cover: by "
        f"{SHOWN_ANGLE_DEG:g}° a robot sees a cell with a mean chance of {_percent(exact)} when exact and "
        f"{_percent(inexact)} with turns {SHOWN}, since it does not stay on a limit cycle for ever. "
        f"{_best(mean, 'By the mean over all cells')} {_best(least, 'By the cell least likely seen')} The paper's "
        f"claim on angles {'holds' if holds else 'does not hold'} here for exact robots: {order}."
    )


def _percent(estimate: Estimate) -> str:
    """A share with its error as text, in percent with one decimal."""
    return f"{100 * estimate.value:.1f} ± {100 * estimate.error:.1f}%"


def _best(shares: dict[tuple[float, str], Estimate], by: str) -> str:
    """The angles from the best to the worst with the shown error; the runs may not tell the best ones apart."""
    order = sorted(ALL_ANGLES_DEG, key=lambda angle: -shares[angle, SHOWN].value)
    top = shares[order[0], SHOWN]
    highest = {angle: shares[angle, SHOWN].value + shares[angle, SHOWN].error for angle in order}
    equal = [angle for angle in order if highest[angle] >= top.value - top.error]
    told = ", ".join(f"{angle:g}° {100 * shares[angle, SHOWN].value:.1f}%" for angle in order)
    more = f"; the runs cannot tell {joined([f'{angle:g}°' for angle in equal])} apart" if len(equal) > 1 else ""
    return f"{by} with turns {SHOWN}, from the best angle: {told}{more}."


def _panels(room: Room, seen: dict[tuple[float, str], Seen], steps: int) -> tuple[Panel, ...]:
    """Maps of the chance of each cell, exact and with errors, and its mean over the steps."""
    panels: list[Panel] = []
    for letter, told in zip("ab", (EXACT, SHOWN), strict=True):
        chances = seen[SHOWN_ANGLE_DEG, told].cells
        note = f"mean {chances.mean():.1%}, least {chances.min():.1%}"
        title = f"({letter}) {SHOWN_ANGLE_DEG:g}°, turns {told}: seen, %"
        panels.append(chances_panel(title, room.mission, room.cells, chances, note))
    at = np.linspace(0, steps, CURVE_POINTS)
    curves = tuple(
        Curve(
            f"{angle:g}°, {told}", 100 * seen[angle, told].curve,
            ROUTE_COLOURS[k], "solid" if told == SHOWN else (0.0, (4.0, 2.0)), at=at, marked=False,
        )
        for k, angle in enumerate((*paper.ANGLES_DEG, 180.0))
        for told in (EXACT, SHOWN)
    )  # fmt: skip
    title = "(c) Mean chance that a cell was seen"
    return (*panels, CurvePanel(title=title, curves=curves, across="steps", up="%", wide=True))


def _angles_table(
    mean: dict[tuple[float, str], Estimate], least: dict[tuple[float, str], Estimate], steps: int
) -> Table:
    """The chances by angle and error: the mean of all cells, and the cell least likely seen."""
    rows = [
        (f"{angle:g}°", *(_pair(mean[angle, told], least[angle, told]) for told in ERRORS)) for angle in ALL_ANGLES_DEG
    ]
    widest = (max(estimate.error for estimate in of.values()) for of in (mean, least))
    errors = " and ".join(f"{100 * error:.1f}" for error in widest)
    return Table(
        title=f"Chance that a cell was seen after {steps} steps, %: mean of all cells / the least of any "
        f"(95 % intervals: at most ± {errors})",
        head=("bouncing angle", *(told if told == EXACT else f"turns {told}" for told in ERRORS)),
        rows=tuple(rows),
    )


def _pair(mean: Estimate, least: Estimate) -> str:
    """Two shares as text, in percent."""
    return f"{100 * mean.value:.1f} / {100 * least.value:.1f}"


def _cover_table(teams: dict[int, Floats]) -> Table:
    """Steps until all cells were seen, by the size of the team, in tenths of the runs."""
    rows = []
    for team, steps in teams.items():
        quantiles = [steps[min(int(share * len(steps)), len(steps) - 1)] for share in (0.1, 0.5, 0.9)]
        told = [f"{value:,.0f}" if math.isfinite(value) else f"> {COVER_STEPS:,}" for value in quantiles]
        rows.append((str(team), *told, f"{np.isfinite(steps).mean():.1%}"))
    return Table(
        title=f"Steps until all cells were seen, by {SHOWN_ANGLE_DEG:g}° with turns {SHOWN}: of each ten runs the "
        "fastest, the middle and the slowest",
        head=("robots", "a tenth of the runs", "half", "nine tenths", f"covered in {COVER_STEPS:,}"),
        rows=tuple(rows),
    )
