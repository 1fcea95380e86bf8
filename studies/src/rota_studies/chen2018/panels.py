"""What the runs came to, as panels of maps and curves."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from rota.draw.palette import COVERED, OVER_PERIOD, ROUTE_COLOURS
from rota.model.mission import Mission
from rota.planners.swarm.sensing import sensors_of, squares_of
from rota_studies.chen2018 import paper
from rota_studies.chen2018.runs import (
    EXACT,
    FILTERED,
    FORCES,
    SAMPLED,
    SETTLE,
    VORONOI,
    Controller,
    Outcome,
    covered_in,
    kept_steps,
)
from rota_studies.panels.curve_panel import Curve, CurvePanel, Level
from rota_studies.panels.map_panel import Dots, MapPanel, Strokes

Floats = NDArray[np.float64]

INK, GREY = "#222222", "#8A8A8A"
COLOURS = {
    EXACT.name: ROUTE_COLOURS[0],
    SAMPLED.name: ROUTE_COLOURS[5],
    FILTERED.name: ROUTE_COLOURS[7],
    VORONOI.name: ROUTE_COLOURS[1],
    FORCES.name: ROUTE_COLOURS[2],
    SETTLE.name: ROUTE_COLOURS[3],
}
SHADE = 0.3


def coverage_panel(title: str, mission: Mission, outcome: Outcome, step: int) -> MapPanel:
    """Robots and what they have in range at a step, or in the end."""
    step = min(step, outcome.steps)
    places = outcome.drawn.places_at(step)
    share = covered_in(mission, places)
    dots = Dots("robot", places, COVERED, size_pt=_size(outcome), shade=SHADE)
    dots = dots._replace(reach_m=float(sensors_of(mission)[0]), square=bool(squares_of(mission)[0]))
    return MapPanel(title=title, note=f"k = {step:,}: {share:.1%} covered", mission=mission, dots=(dots,))


def ways_panel(
    title: str, mission: Mission, outcome: Outcome, step: int, colour: str = ROUTE_COLOURS[0], named: int | None = None
) -> MapPanel:
    """The ways of all robots up to a step, or to the end; that of the ``named``-th robot (from 1) stands out."""
    step, drawn = min(step, outcome.steps), outcome.drawn
    places = drawn.places_m[drawn.at <= step]
    ways = [places[:, k] for k in range(places.shape[1])]
    width = 0.25 if len(ways) > 100 else 0.7
    strokes = [Strokes("way", tuple(ways), colour, width_pt=width)]
    if named is not None:
        strokes.append(Strokes(f"way of robot {named}", (ways[named - 1],), OVER_PERIOD, width_pt=1.8))
    size = _size(outcome)
    dots = (
        Dots("start", places[0], INK, "s", size, filled=False),
        Dots("end", places[-1], INK, "o", size),
    )
    way_m = float(outcome.way_m[outcome.row(step)])
    return MapPanel(
        title=title, note=f"k = 0 to {step:,}: {way_m:,.0f} m on average", mission=mission, strokes=tuple(strokes),
        dots=dots if len(ways) <= 100 else (),
    )  # fmt: skip


def _size(outcome: Outcome) -> float:
    """The size of a dot in points: smaller for many robots."""
    return 2.6 if outcome.drawn.places_m.shape[1] <= 100 else 0.9


def distance_panel(title: str, outcome: Outcome) -> CurvePanel:
    """The least distance between the middles of two robots by step, and the least that is no contact."""
    curve = Curve("least distance", outcome.drawn.gaps_m, COVERED, width_pt=1.8)
    critical = Level("bodies touch, 1 m", 2 * paper.BODY_M, OVER_PERIOD)
    least = float(curve.values.min())
    return CurvePanel(
        title=title, note=f"least of all: {least:.3f} m", curves=(curve,), levels=(critical,), across="step k",
        up="m", wide=True,
    )  # fmt: skip


def mean_curves(
    outcomes: Sequence[tuple[Controller, list[Outcome]]], steps: int, value: Callable[[Floats], Floats]
) -> tuple[Curve, ...]:
    """The mean over seeds of a value of the coverage by step, with least and most; a run at rest keeps its last."""
    curves = []
    for controller, runs in outcomes:
        at = kept_steps(steps)
        covered = [run.covered[np.minimum(np.searchsorted(run.at, at), len(run.at) - 1)] for run in runs]
        rows = value(np.array(covered))
        band = np.array([rows.min(axis=0), rows.max(axis=0)])
        curve = Curve(controller.name, rows.mean(axis=0), COLOURS[controller.name], at=at.astype(np.float64), band=band)
        curves.append(curve._replace(marked=False))
    return tuple(curves)
