"""Robots that turn inexactly, simulated in the plane: what they cover, and what they still watch.

Alam and Bobadilla 2020, Section 6, name a bounded uncertainty of rotation as future work. Here discs drive straight in
the continuous plane, with walls and corners as they are, and turn at each contact by the bouncing angle and an error
of its own. Nothing is rounded: an error of a tenth of a degree counts as such.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Literal

import numpy as np
from shapely import MultiPolygon

from rota.errors import MissionError
from rota.model.arrays import Floats
from rota.planners.bounce.cells import Cells
from rota.planners.bounce.inexact_kernels import BOUNDED, GAUSSIAN, Crew as DrivingCrew, Lattice, Zones, run_inexact
from rota.planners.bounce.polygon import Rim, make_rim

ErrorShape = Literal["bounded", "gaussian"]

CHUNK = 250  # runs of one thread at a time
CONFIDENT = 1.96  # standard errors on either side: 95 %


@dataclass(frozen=True, kw_only=True)
class TurningError:
    """How inexact each turn is: off by up to ``angle_rad`` either way ("bounded"), or by that deviation ("gaussian").

    Bounded errors are uniform. Errors of different turns are independent.
    """

    angle_rad: float = 0.0
    shape: ErrorShape = "bounded"

    def __post_init__(self) -> None:
        if self.shape not in ("bounded", "gaussian"):
            raise MissionError(f"shape: {self.shape!r} is not allowed; bounded or gaussian")
        if not (math.isfinite(self.angle_rad) and 0 <= self.angle_rad <= math.pi):
            raise MissionError(f"angle_rad: {self.angle_rad!r} is not allowed; must lie in 0..{math.pi:.6g}")


@dataclass(frozen=True, kw_only=True, eq=False)
class Crew:
    """Discs that bounce: m of them, equally wide as far as walls are concerned.

    bounces_rad (m,): bouncing angles; apart_m (m, m): distance of centres at which two bodies touch. All drive
    ``speed_m_s``, and a turn takes ``turn_s`` whatever its angle, above 0.
    """

    rim: Rim
    bounces_rad: Floats
    apart_m: Floats
    speed_m_s: float
    turn_s: float


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A mean of independent runs; the true one lies within ``error`` of it with 95 % confidence."""

    value: float
    error: float


@dataclass(frozen=True, kw_only=True, eq=False)
class InexactRuns:
    """What r runs came to. entered_s: (r, n) when each cell was first entered by any centre, inf: never.

    watched: (r, z) share of the time, after each zone's first period, in which it had been visited within its period.
    met_s: (r,) when two bodies first touched, inf: not while it lasted.
    """

    duration_s: float
    entered_s: Floats
    watched: Floats
    met_s: Floats

    def entered_shares(self, after_s: float) -> Floats:
        """(n,) share of the runs in which each cell had been entered by then."""
        return np.asarray((self.entered_s <= after_s).mean(axis=0))

    def mean_seen(self, after_s: float) -> Estimate:
        """The share of all cells that a run has entered by then."""
        return estimate((self.entered_s <= after_s).mean(axis=1))

    def cover_times_s(self) -> Floats:
        """(r,) when each run had entered all cells, inf: not while it lasted."""
        return np.asarray(self.entered_s.max(axis=1))

    def contact_quantiles_s(self, shares: Sequence[float]) -> tuple[float, ...]:
        """By when two bodies had first touched in each of these shares of the runs; inf: in fewer while they lasted."""
        ordered = np.sort(self.met_s)
        return tuple(float(ordered[max(math.ceil(share * len(ordered)) - 1, 0)]) for share in shares)

    def watched_shares(self) -> tuple[Estimate, ...]:
        """For each zone the share of the time in which it had been visited within its period."""
        return tuple(estimate(self.watched[:, z]) for z in range(self.watched.shape[1]))


def estimate(values: Floats) -> Estimate:
    """The mean of independent values (r,); the error is infinite for a single one."""
    error = CONFIDENT * float(values.std(ddof=1)) / math.sqrt(len(values)) if len(values) > 1 else math.inf
    return Estimate(value=float(values.mean()), error=error)


def make_crew(
    ground: MultiPolygon,
    body_radii_m: Sequence[float],
    bounces_rad: Sequence[float],
    *,
    speed_m_s: float,
    turn_s: float,
) -> Crew:
    """A crew on ``ground`` (area minus obstacles), one radius and one bouncing angle per robot.

    The widest body counts at walls for all. Raises MissionError for a body that fits nowhere, and for a turn that takes
    no time: a disc in a corner would turn for ever at once.
    """
    if not (math.isfinite(turn_s) and turn_s > 0):
        raise MissionError(f"turn_s: {turn_s!r} is not allowed; must be a finite number greater than 0")
    if not (math.isfinite(speed_m_s) and speed_m_s > 0):
        raise MissionError(f"speed_m_s: {speed_m_s!r} is not allowed; must be a finite number greater than 0")
    radii = np.array(body_radii_m, dtype=np.float64)
    return Crew(
        rim=make_rim(ground, float(radii.max())),
        bounces_rad=np.array(bounces_rad, dtype=np.float64),
        apart_m=radii[:, None] + radii,
        speed_m_s=speed_m_s,
        turn_s=turn_s,
    )


def run_crew(
    crew: Crew,
    error: TurningError,
    starts: Floats,
    *,
    duration_s: float,
    seed: int,
    cells: Cells | None = None,
    zones: Sequence[tuple[MultiPolygon, float]] = (),
) -> InexactRuns:
    """One run for each row of ``starts`` (r, m, 3): x and y in metres, heading in radians.

    cells: those whose first entry is noted. zones: shapes, and their periods in seconds. The same seed gives the same
    runs, on however many threads.
    """
    runs = len(starts)
    seeds = np.random.default_rng(seed).integers(0, 2**64, runs, dtype=np.uint64)
    lattice = _lattice(cells)
    sides = [_sides(shape) for shape, _ in zones]
    first = np.concatenate([[0], np.cumsum([len(own) for own in sides])]).astype(np.int64)
    all_sides = np.ascontiguousarray(np.concatenate([np.empty((0, 4)), *sides]))
    periods_s = np.array([period_s for _, period_s in zones], dtype=np.float64)
    entered_s = np.empty((runs, 0 if cells is None else cells.count))
    watched_s, met_s = np.empty((runs, len(zones))), np.empty(runs)
    starts = np.ascontiguousarray(starts, dtype=np.float64)

    shape = BOUNDED if error.shape == "bounded" else GAUSSIAN
    driving = DrivingCrew(crew.apart_m, crew.bounces_rad, crew.speed_m_s, crew.turn_s, error.angle_rad, shape)
    watched_zones = Zones(all_sides, first, periods_s)

    def part(k: int) -> None:
        """Simulate one chunk of the runs, from the k-th on."""
        chosen = slice(k, k + CHUNK)
        results = entered_s[chosen], watched_s[chosen], met_s[chosen]
        run_inexact(
            crew.rim.compiled,
            driving,
            float(duration_s),
            starts[chosen],
            seeds[chosen],
            lattice,
            watched_zones,
            results,
        )

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(part, range(0, runs, CHUNK)))
    lasting_s = np.maximum(duration_s - periods_s, 1e-9)
    return InexactRuns(duration_s=duration_s, entered_s=entered_s, watched=watched_s / lasting_s, met_s=met_s)


def _lattice(cells: Cells | None) -> Lattice:
    """The cells as compiled loops read them; without any where there are none."""
    if cells is None:
        return Lattice(0.0, 0.0, 1.0, np.full((1, 1), -1, np.int64))
    number = np.full((int(cells.row.max()) + 1, int(cells.column.max()) + 1), -1, np.int64)
    number[cells.row, cells.column] = np.arange(cells.count)
    return Lattice(float(cells.corner_m[0]), float(cells.corner_m[1]), cells.cell_m, number)


def _sides(shape: MultiPolygon) -> Floats:
    """(k, 4) sides of all rings."""
    rings = [np.asarray(ring.coords)[:, :2] for part in shape.geoms for ring in (part.exterior, *part.interiors)]
    return np.concatenate([np.hstack([points[:-1], points[1:]]) for points in rings])
