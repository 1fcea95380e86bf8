"""Extra figure 12: robots whose turns are inexact, which the paper leaves to future work."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.draw.palette import ROUTE_COLOURS
from rota.draw.panels.curve_panel import Curve, CurvePanel
from rota.draw.panels.study_picture import Panel, study_picture
from rota.geometry.free_space import free_ground
from rota.mission import Mission
from rota.papers.alam2020 import maps, paper
from rota.papers.alam2020.claims import angles_verdict
from rota.papers.alam2020.panels import chances_panel
from rota.papers.alam2020.runs import Runs
from rota.papers.section import Picture, Section
from rota.papers.tables import Table, joined
from rota.planners.bounce.cells import Cells, make_cells
from rota.planners.bounce.inexact_turns import (
    Estimate,
    InexactRuns,
    TurningError,
    make_crew,
    run_crew,
    starts_anywhere,
)

Floats = NDArray[np.float64]

ALL_ANGLES_DEG = tuple(45.0 * turn for turn in range(1, 8))
EXACT, SHOWN = "exact", "± 10°"
ERRORS = {
    EXACT: TurningError(),
    "± 1°": TurningError(angle_rad=math.radians(1)),
    "± 5°": TurningError(angle_rad=math.radians(5)),
    SHOWN: TurningError(angle_rad=math.radians(10)),
    "± 20°": TurningError(angle_rad=math.radians(20)),
    "10° Gaussian": TurningError(angle_rad=math.radians(10), shape="gaussian"),
}
SHOWN_ANGLE_DEG = 135.0
TEAMS = (1, 2, 3, 5)
STEP_CELLS = (1 + math.sqrt(2)) / 2  # a step: the mean of a straight and a diagonal move, or a turn
COVER_STEPS, COVER_SHARE = 20_000, 0.2  # and the share of the runs that are followed so long
CURVE_POINTS = 61


@dataclass(frozen=True, kw_only=True)
class _Room:
    """The room and its cells, and how long a step takes."""

    mission: Mission
    cells: Cells
    step_s: float

    def run(
        self, runs: Runs, angle_deg: float, error: TurningError, steps: int, *, team: int = 1, share: float = 1.0
    ) -> InexactRuns:
        """As many runs as the settings have, or a share of them, from anywhere, by discs in the plane."""
        crew = make_crew(
            free_ground(self.mission), [maps.ROOM_BODY_M] * team, [math.radians(angle_deg)] * team,
            speed_m_s=maps.SPEED_M_S, turn_s=self.step_s,
        )  # fmt: skip
        starts = starts_anywhere(crew, self.cells, int(share * runs.settings.walks), runs.seed)
        return run_crew(crew, error, starts, duration_s=steps * self.step_s, seed=runs.seed, cells=self.cells)


def figure_12_section(runs: Runs) -> Section:
    """What errors of turning do to robots in the room of Figure 7."""
    mission = maps.room(maps.ROOM_10, 1, SHOWN_ANGLE_DEG)
    room = _Room(mission=mission, cells=make_cells(mission), step_s=STEP_CELLS * maps.ROOM_CELL_M / maps.SPEED_M_S)
    steps = runs.settings.error_steps
    simulated: dict[tuple[float, str], InexactRuns] = {}
    for angle in ALL_ANGLES_DEG:
        for told, error in ERRORS.items():
            runs.now(f"figure 12: {angle:g}°, turns {told}")
            simulated[angle, told] = room.run(runs, angle, error, steps)
    teams = {}
    for team in TEAMS:
        runs.now(f"figure 12: teams of {team}")
        teams[team] = room.run(runs, SHOWN_ANGLE_DEG, ERRORS[SHOWN], COVER_STEPS, team=team, share=COVER_SHARE)
    after_s = steps * room.step_s
    mean = {key: runs_of.mean_seen(after_s) for key, runs_of in simulated.items()}
    least = {key: runs_of.least_seen(after_s) for key, runs_of in simulated.items()}
    return Section(
        figure=12,
        extra=True,
        heading="robots that turn inexactly",
        pictures=(
            Picture(
                "alam2020-figure-12.png",
                "Chances that each cell of a room is seen by an exact and an inexact robot, and their mean by step",
                study_picture(_panels(room, simulated, steps)),
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
        tables=(_angles_table(mean, least, steps), _cover_table(teams, room.step_s)),
        verdicts=(angles_verdict(mean, EXACT, SHOWN),),
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


def _panels(room: _Room, simulated: dict[tuple[float, str], InexactRuns], steps: int) -> list[Panel]:
    """Maps of the chance of each cell, exact and with errors, and its mean over the steps."""
    panels: list[Panel] = []
    after_s = steps * room.step_s
    for letter, told in zip("ab", (EXACT, SHOWN), strict=True):
        chances = simulated[SHOWN_ANGLE_DEG, told].seen(after_s)
        note = f"mean {chances.mean():.1%}, least {chances.min():.1%}"
        title = f"({letter}) {SHOWN_ANGLE_DEG:g}°, turns {told}: seen, %"
        panels.append(chances_panel(title, room.mission, room.cells, chances, note))
    at = np.linspace(0, steps, CURVE_POINTS)
    curves = tuple(
        Curve(
            f"{angle:g}°, {told}",
            np.array([100 * simulated[angle, told].mean_seen(step * room.step_s).value for step in at]),
            ROUTE_COLOURS[k], "solid" if told == SHOWN else (0.0, (4.0, 2.0)), at=at, marked=False,
        )
        for k, angle in enumerate((*paper.ANGLES_DEG, 180.0))
        for told in (EXACT, SHOWN)
    )  # fmt: skip
    panels.append(
        CurvePanel(title="(c) Mean chance that a cell was seen", curves=curves, across="steps", up="%", wide=True)
    )
    return panels


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


def _cover_table(teams: dict[int, InexactRuns], step_s: float) -> Table:
    """Steps until all cells were seen, by the size of the team, in tenths of the runs."""
    rows = []
    for team, team_runs in teams.items():
        times = np.sort(team_runs.cover_times_s()) / step_s
        quantiles = [times[min(int(share * len(times)), len(times) - 1)] for share in (0.1, 0.5, 0.9)]
        told = [f"{value:,.0f}" if math.isfinite(value) else f"> {COVER_STEPS:,}" for value in quantiles]
        complete = np.isfinite(times).mean()
        rows.append((str(team), *told, f"{complete:.1%}"))
    return Table(
        title=f"Steps until all cells were seen, by {SHOWN_ANGLE_DEG:g}° with turns {SHOWN}: of each ten runs the "
        "fastest, the middle and the slowest",
        head=("robots", "a tenth of the runs", "half", "nine tenths", f"covered in {COVER_STEPS:,}"),
        rows=tuple(rows),
    )
