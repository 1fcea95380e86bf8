"""Figures 9 and 11: how far the mean of random velocities is from the centroid, and how often it finds no velocity."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rota.draw.palette import ROUTE_COLOURS
from rota.geometry.free_space import free_ground
from rota.model.mission import Mission
from rota.planners.swarm.planner import make_swarm, run_mission
from rota.planners.swarm.sorted_robots import Beginning
from rota_studies.chen2018 import maps, paper
from rota_studies.chen2018.runs import EXACT, SAMPLED, Runs, places_at_steps, what
from rota_studies.chen2018.velocity_set import VelocitySet
from rota_studies.panels.curve_panel import Curve, CurvePanel
from rota_studies.section import Picture, Section
from rota_studies.tables import Table
from rota_studies.verdict import Verdict, always, mostly, spread

Floats = NDArray[np.float64]

COUNTS = (10, 20, 50, 100, 200, 500, 1000, 2000, 5000)
TRIES = 400
SNAPSHOTS = 60  # of a run, evenly spread
MOVES_M_S = 1e-6  # a robot that is slower by the exact centroid has no set worth looking for
IN_A_RUN = "in a run"
NEAR, FEW = 0.05, 0.02  # shares of the top speed and of sets, below which an error is near to zero


def shapes() -> dict[str, VelocitySet]:
    """Figure 8's three shapes, of our own sizes: a quarter of the disc, a triangle in it, and an irregular set."""
    tilted = [(math.cos(angle), math.sin(angle), bound) for angle, bound in ((0.4, 0.3), (2.6, -0.2), (4.4, 0.9))]
    thirds = [(math.cos(angle), math.sin(angle), 0.25) for angle in (0.3, 0.3 + math.tau / 3, 0.3 + 2 * math.tau / 3)]
    return {
        "sector": VelocitySet(np.array([(-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)]), paper.SPEED_M_S),
        "triangle": VelocitySet(np.array(thirds), paper.SPEED_M_S),
        "irregular": VelocitySet(np.array(tilted), paper.SPEED_M_S),
    }


class Sampled(NamedTuple):
    """What random velocities come to, for each of ``COUNTS``, (c,): mean distance to the centroid, m/s, and misses.

    A miss is a try, or a decision, without a mean; misses are shares.
    """

    errors: Floats
    misses: Floats


def errors_and_misses(velocities: VelocitySet, seed: int) -> Sampled:
    """For each of ``COUNTS``: mean distance to the centroid, and the share of tries without a mean."""
    centroid = velocities.centroid()
    errors, misses = np.full(len(COUNTS), np.nan), np.zeros(len(COUNTS))
    for k, count in enumerate(COUNTS):
        means = velocities.sampled_centroids(count, tries=TRIES, seed=seed)
        is_mean = ~np.isnan(means[:, 0])
        misses[k] = 1 - is_mean.mean()
        if is_mean.any() and centroid is not None:
            errors[k] = np.hypot(*(means[is_mean] - centroid).T).mean()
    return Sampled(errors, misses)


def of_shapes(runs: Runs) -> dict[str, Sampled]:
    """The same of the three shapes, by their names."""
    return {
        name: runs.records.get(
            Sampled,
            {"what": "random velocities", "shape": name, "tries": TRIES, "seed": runs.seed},
            lambda velocities=velocities: errors_and_misses(velocities, runs.seed),  # type: ignore[misc]
        )
        for name, velocities in shapes().items()
    }


def in_runs(runs: Runs) -> list[Sampled]:
    """The same over the decisions of runs by the exact centroid, one for each seed: each is made once more."""
    mission = replace(maps.small("between"), planning=replace(EXACT.settings, most_steps=runs.settings.steps))

    def make(seed: int) -> Sampled:
        runs.now(f"deciding again by random velocities, seed {seed}")
        run = run_mission(mission, seed=seed)
        places = places_at_steps(mission, run, np.arange(run.steps + 1))
        both = [_decided_again(mission, places, count, seed) for count in COUNTS]
        errors = [away.mean() if len(away) else np.nan for away, _ in both]
        return Sampled(np.array(errors), np.array([missed for _, missed in both]))

    return [
        runs.records.get(
            Sampled,
            {"what": "random velocities in a run", **what(mission), "seed": seed},
            lambda seed=seed: make(seed),  # type: ignore[misc]
        )
        for seed in runs.some(runs.settings.claim_seeds)
    ]


def _decided_again(mission: Mission, places_m: Floats, samples: int, seed: int) -> tuple[Floats, float]:
    """Distances (d,) in m/s of velocities by samples from those by the exact centroid, and the share without a mean."""
    by_samples = replace(mission, planning=replace(SAMPLED.settings, samples=samples))
    ground = free_ground(mission)
    away, missed, decisions = [], 0, 0
    steps = len(places_m) - 1
    for step in np.linspace(1, steps - 1, min(SNAPSHOTS, steps - 1)).astype(int):
        before, places, after = (places_m[k] for k in (step - 1, step, step + 1))
        beginning = Beginning(places, velocities_m_s=(places - before) / paper.STEP_S)
        swarm = make_swarm(by_samples, ground, beginning, seed=seed + int(step))
        swarm.step()
        exact, sampled = (after - places) / paper.STEP_S, swarm.velocities_m_s
        moves = np.hypot(*exact.T) > MOVES_M_S
        idle = moves & ~sampled.any(axis=1)
        decisions, missed = decisions + int(moves.sum()), missed + int(idle.sum())
        away.append(np.hypot(*(sampled - exact)[moves & ~idle].T))
    return np.concatenate(away), missed / max(decisions, 1)


def _rows(runs: Runs, column: Literal["errors", "misses"]) -> tuple[dict[str, Floats], Floats]:
    """Errors or misses for the three shapes and for the decisions of runs, mean; and of each run, (seeds, c)."""
    each = np.array([getattr(one, column) for one in in_runs(runs)])
    return {name: getattr(one, column) for name, one in of_shapes(runs).items()} | {IN_A_RUN: each.mean(axis=0)}, each


def _curves(rows: dict[str, Floats], scale: float = 1.0) -> tuple[Curve, ...]:
    """A curve over COUNTS for each row, (c,) values, times a scale."""
    at = np.array(COUNTS, dtype=np.float64)
    return tuple(Curve(name, values * scale, ROUTE_COLOURS[k], at=at) for k, (name, values) in enumerate(rows.items()))


def _table(title: str, rows: dict[str, Floats], form: Callable[[float], str]) -> Table:
    """A table with a line for each of COUNTS and a column for each row."""
    return Table(
        title=title,
        head=("random velocities", *rows),
        rows=tuple(
            (f"{count:,}", *(form(float(values[k])) for values in rows.values())) for k, count in enumerate(COUNTS)
        ),
    )


def figure_9_section(runs: Runs) -> Section:
    """Figure 9: the error of the mean of random velocities."""
    rows, each = _rows(runs, "errors")
    k = COUNTS.index(paper.SAMPLES)
    panel = CurvePanel(
        title="Error of the generated velocity", note=f"robots go up to {paper.SPEED_M_S:g} m/s", curves=_curves(rows),
        across="random velocities", up="mean distance to the centroid, m/s", logarithmic=True, logarithmic_across=True,
        wide=True,
    )  # fmt: skip
    shaped = max(float(values[k]) for name, values in rows.items() if name != IN_A_RUN)
    near = always([error < NEAR * paper.SPEED_M_S for error in each[:, k]])
    shown = "The error falls with the root of the number of random velocities"
    return Section(
        figure=9,
        heading="the error of the generated velocity",
        pictures=(Picture("chen2018-figure-9.png", shown, (panel,)),),
        caption="Figure 9. The shapes are those of Figure 8, in our sizes, 400 tries each. “In a run”: decisions of "
        f"{len(each)} runs as in Figure 12, each made once more by random velocities; means of the runs.",
        paper="The error decreases with the number of random points and is “very close to zero with a large number” "
        "(Section 4.4.1); no values are told.",
        ours=f"Holds: the error falls with the root of the number, to at most {shaped:.3f} m/s at "
        f"{paper.SAMPLES:,} for the shapes and {rows[IN_A_RUN][k]:.3f} m/s in a run. It is not small enough to come to "
        f"rest: {rows[IN_A_RUN][k] * paper.STEP_S:.4f} m a step, where the stop rule asks for {paper.STOP_M:.5f} m.",
        tables=(_table("Mean distance to the centroid, m/s", rows, lambda value: f"{value:.4f}"),),
        verdicts=(
            Verdict(
                "The error of the generated velocity is very close to zero with many random points", "4.4.1, Figure 9",
                near.outcome,
                f"Less than {NEAR:.0%} of the top speed at {paper.SAMPLES:,} in {near.told}: {shaped:.3f} m/s at most "
                f"for the shapes, {spread(each[:, k], '.3f')} in runs, of {paper.SPEED_M_S:g}. It is too much for the "
                f"stop rule: {rows[IN_A_RUN][k] * paper.STEP_S:.4f} m a step, allowed {paper.STOP_M:.5f} m.",
            ),
        ),
    )  # fmt: skip


def figure_11_section(runs: Runs) -> Section:
    """Figure 11: how often a set that is not empty seems so."""
    rows, each = _rows(runs, "misses")
    panel = CurvePanel(
        title="Sets taken for empty that are not", note="share of the decisions", curves=_curves(rows, 100.0),
        across="random velocities", up="%", logarithmic_across=True, wide=True,
    )  # fmt: skip
    enough, all_of_it = (float(rows[IN_A_RUN][COUNTS.index(n)]) for n in (paper.SAMPLES_ENOUGH, paper.SAMPLES))
    shaped = max(float(values[COUNTS.index(paper.SAMPLES_ENOUGH)]) for name, values in rows.items() if name != IN_A_RUN)
    k = COUNTS.index(paper.SAMPLES_ENOUGH)
    few = mostly([share < FEW for share in each[:, k]])
    shown = "The share of misjudged sets, by the number of random velocities"
    return Section(
        figure=11,
        heading="sets misjudged as empty",
        pictures=(Picture("chen2018-figure-11.png", shown, (panel,)),),
        caption="Figure 11. As Figure 9. A set with the share p of the square round the speed disc is missed with the "
        "probability (1 − p)ᴺ.",
        paper=f"The error “nearly reaches zero after {paper.SAMPLES_ENOUGH} random points” (Section 4.4.2).",
        ours=f"Holds for the shapes of Figure 8: {shaped:.1%} at {paper.SAMPLES_ENOUGH}. In a run it does not: "
        f"{enough:.1%} of the decisions at {paper.SAMPLES_ENOUGH} and {all_of_it:.1%} at {paper.SAMPLES:,} find no "
        "velocity where the exact set has one. When robots are nearly in place, their neighbours leave them slivers.",
        tables=(_table("Share of sets taken for empty that are not", rows, lambda value: f"{value:.2%}"),),
        verdicts=(
            Verdict(
                f"Hardly any set is misjudged as empty after {paper.SAMPLES_ENOUGH} points", "4.4.2, Figure 11",
                few.outcome,
                f"Less than {FEW:.0%} in {few.told}. It holds for shapes as in Figure 8 ({shaped:.1%} at most); of the "
                f"sets that a run meets {spread(100 * each[:, k], '.1f')} % are misjudged, and {all_of_it:.1%} at "
                f"{paper.SAMPLES:,}.",
            ),
        ),
    )  # fmt: skip
