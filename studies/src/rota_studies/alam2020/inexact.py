"""Robots whose turns are inexact: what chance each cell has to be seen by them, by bouncing angle and error."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.errors import MissionError
from rota.geometry.free_space import free_ground
from rota.model.mission import Mission
from rota.planners.bounce.cells import Cells, make_cells
from rota.planners.bounce.inexact_turns import (
    Crew,
    Estimate,
    InexactRuns,
    TurningError,
    estimate,
    make_crew,
    run_crew,
)
from rota_studies.alam2020 import maps
from rota_studies.alam2020.runs import Runs
from rota_studies.records import what

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
BATCHES = 10  # of the runs of each angle and error, whose spread verdicts rest on


@dataclass(frozen=True, kw_only=True)
class Seen:
    """The chances that cells were seen. mean: of all cells, least: of the cell least likely seen.

    batches: (b,) the mean of all cells by batches of runs, whose starts are the same for every angle and error. cells:
    (n,) the chance of each. curve: (CURVE_POINTS,) the mean by step, evenly spread.
    """

    mean: Estimate
    least: Estimate
    batches: Floats
    cells: Floats
    curve: Floats


@dataclass(frozen=True, kw_only=True)
class Room:
    """The room of Figure 7 and its cells, and how long a step takes."""

    mission: Mission
    cells: Cells
    step_s: float

    @classmethod
    def of_figure_7(cls) -> Room:
        """One robot's."""
        mission = maps.room(maps.ROOM_10, 1, SHOWN_ANGLE_DEG)
        step_s = STEP_CELLS * maps.ROOM_CELL_M / maps.SPEED_M_S
        return cls(mission=mission, cells=make_cells(mission), step_s=step_s)

    def seen(self, runs: Runs, angle_deg: float, told: str) -> Seen:
        """The chances by an angle and an error, by its name in ERRORS."""
        steps, walks = runs.settings.error_steps, runs.settings.walks

        def make() -> Seen:
            """The chances as walks at random have them, all at once and in batches."""
            runs.now(f"figure 12: {angle_deg:g}°, turns {told}")
            found = self._run(runs, angle_deg, ERRORS[told], steps)
            after_s = steps * self.step_s
            each, cells = (found.entered_s <= after_s).mean(axis=1), found.entered_shares(after_s)
            seldom_entered = found.entered_s[:, int(cells.argmin())] <= after_s
            return Seen(
                mean=found.mean_seen(after_s),
                least=estimate(seldom_entered.astype(np.float64)),
                batches=np.array([batch.mean() for batch in np.array_split(each, BATCHES)]),
                cells=cells,
                curve=np.array([
                    found.mean_seen(step * self.step_s).value for step in np.linspace(0, steps, CURVE_POINTS)
                ]),
            )  # fmt: skip

        run = self._told(runs, angle_deg, told) | {"steps": steps, "walks": walks}
        return runs.records.get(Seen, run, make)

    def cover_steps(self, runs: Runs, team: int) -> Floats:
        """(r,) steps until a team has seen all cells, ascending, with the shown angle and error; inf: it never has."""

        def make() -> Floats:
            runs.now(f"figure 12: teams of {team}")
            found = self._run(runs, SHOWN_ANGLE_DEG, ERRORS[SHOWN], COVER_STEPS, team=team, share=COVER_SHARE)
            return np.sort(found.cover_times_s()) / self.step_s

        run = self._told(runs, SHOWN_ANGLE_DEG, SHOWN) | {"steps": COVER_STEPS, "team": team}
        run["walks"] = int(COVER_SHARE * runs.settings.walks)
        return runs.records.get(NDArray[np.float64], run, make)

    def _told(self, runs: Runs, angle_deg: float, told: str) -> dict[str, object]:
        return {"what": "inexact turns", **what(self.mission), "angle": angle_deg, "error": told, "seed": runs.seed}

    def _run(
        self, runs: Runs, angle_deg: float, error: TurningError, steps: int, *, team: int = 1, share: float = 1.0
    ) -> InexactRuns:
        """As many runs as the settings have, or a share of them, from anywhere, by discs in the plane."""
        crew = make_crew(
            free_ground(self.mission), [maps.ROOM_BODY_M] * team, [math.radians(angle_deg)] * team,
            speed_m_s=maps.SPEED_M_S, turn_s=self.step_s,
        )  # fmt: skip
        starts = starts_anywhere(crew, self.cells, int(share * runs.settings.walks), runs.seed)
        return run_crew(crew, error, starts, duration_s=steps * self.step_s, seed=runs.seed, cells=self.cells)


def starts_anywhere(crew: Crew, cells: Cells, runs: int, seed: int) -> Floats:
    """(runs, m, 3) random starts: centres of cells, bodies apart, any of the cells' headings.

    Raises MissionError where no room is found for so many bodies.
    """
    rng = np.random.default_rng(seed)
    m = len(crew.bounces_rad)
    starts = np.empty((runs, m, 3))
    starts[:, :, 2] = rng.integers(0, cells.headings, (runs, m)) * (2 * math.pi / cells.headings)
    waiting = np.arange(runs)
    for _ in range(1000):
        starts[waiting, :, :2] = cells.centres_m[rng.integers(0, cells.count, (len(waiting), m))]
        places = starts[waiting, :, :2]
        gaps = np.hypot(*np.moveaxis(places[:, :, None] - places[:, None], -1, 0))
        waiting = waiting[((gaps < crew.apart_m) & ~np.eye(m, dtype=bool)).any(axis=(1, 2))]
        if not len(waiting):
            return starts
    raise MissionError(f"no room was found for {m} bodies on {cells.count} cells; give fewer robots")
