"""Figures 17 to 20 and Table 3: the published controller beside the baselines and ours."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rota.draw.curve_panel import Curve, CurvePanel, Level
from rota.draw.map_panel import MapPanel
from rota.draw.palette import OVER_PERIOD
from rota.draw.study_picture import study_picture
from rota.mission import Mission
from rota.planners.swarm.asked import free_ground, make_swarm
from rota.planners.swarm.metrics import covered_share
from rota.planners.swarm.starts import place_starts
from rota.studies.chen2018 import maps, paper
from rota.studies.chen2018.panels import COLOURS, coverage_panel, mean_curves, ways_panel
from rota.studies.chen2018.runs import COMPARED, EXACT, FORCES, SAMPLED, SETTLE, VORONOI, Controller, Job, Outcome, Runs
from rota.studies.chen2018.small_figures import SHOWN, coverage_cell, plus_minus
from rota.studies.section import Picture, Section
from rota.studies.tables import NOTHING, Table, joined

Floats = NDArray[np.float64]

MOMENTS = (50, 100, 200, 300, paper.STEPS_FIGURE_12)
CURVE_STEPS = 1000
MOST_PERCENT = 25 * np.pi * 25**2 / 250**2 * 100
WITH_SAMPLED = (SAMPLED, *COMPARED)


def figure_17_section(runs: Runs) -> Section:
    """Figure 17: what the baselines cover at the step at which the paper's controller rests."""
    mission, step = maps.small(SHOWN), paper.STEPS_FIGURE_12
    panels: list[MapPanel] = []
    for letters, controller in zip(("abc", "def", "ghi"), (VORONOI, FORCES, SETTLE), strict=True):
        outcome = runs(mission, controller)
        panels += [
            coverage_panel(f"({letters[0]}) {controller.name}", mission, outcome, 0),
            ways_panel(f"({letters[1]}) {controller.name}: ways", mission, outcome, step, COLOURS[controller.name]),
            coverage_panel(f"({letters[2]}) {controller.name}", mission, outcome, step),
        ]
    at = {one.name: _coverage_at(runs.seeds(mission, one), step) for one in COMPARED}
    told = {EXACT.name: "most", SETTLE.name: NOTHING}
    for one in (VORONOI, FORCES):
        at[f"{one.name}, 4 neighbours"] = coverage_by_four(mission, one, runs, step)
    better = [one.name for one in (VORONOI, FORCES) if np.mean(at[one.name]) > np.mean(at[EXACT.name])]
    table = Table(
        title=f"Coverage at k = {step}, %, {len(at[EXACT.name])} seeds",
        head=("controller", "paper", "covered %", "least", "most"),
        rows=tuple(
            (name, told.get(name, "less"), plus_minus(values, ".2f"), f"{min(values):.2f}", f"{max(values):.2f}")
            for name, values in at.items()
        ),
        words=(0, 1),
    )
    return Section(
        figure=17,
        heading="the methods it is compared with",
        pictures=(
            Picture(
                "chen2018-figure-17.png",
                "Starts, ways and coverage at step 574 of the Voronoi method, virtual forces and settle",
                study_picture(panels, columns=3),
            ),
        ),
        caption=f"Figure 17, (a) to (f) as in the paper, and (g) to (i) for settle, Rota's default, at k = {step} "
        "or at "
        "rest before. RD at the same start is in Figure 12.",
        paper=f"At k = {step} RD is superior in convergence speed and coverage to the V-based method and VFA, which "
        "can "
        "“be easily found visually” (Section 5.1); no values are told.",
        found=_claim(not better, "RD covers more", f"{joined(better)} cover more than RD")
        + " Both baselines are made as well as they can be here: over-relaxed steps, all neighbours in range, the last "
        "filter. That they heed all neighbours in range matters little: with “the same parameters as RD”, its 4 "
        "neighbours, they cover "
        + joined([f"{np.mean(at[f'{one.name}, 4 neighbours']):.1f} %" for one in (VORONOI, FORCES)])
        + ". How the paper's were made is not told.",
        tables=(table,),
    )


def _claim(holds: bool, yes: str, no: str) -> str:
    return f"Holds: {yes}." if holds else f"Does not hold here: {no}."


def coverage_by_four(mission: Mission, controller: Controller, runs: Runs, step: int) -> list[float]:
    """Percent covered at a step, seed by seed, by robots that heed their 4 nearest neighbours only."""
    mission = replace(mission, planning=controller.settings)
    ground = free_ground(mission)
    sensors = np.full(len(mission.fleet.robots or ()), paper.SENSOR_M)
    found = []
    for k in range(runs.settings.seeds):
        runs.stop_if_asked()
        starts = place_starts(mission, ground, seed=runs.seed + k, reserve_m=0.0)
        swarm = make_swarm(mission, ground, starts, seed=runs.seed + k)
        swarm.rule = swarm.rule._replace(neighbours=paper.NEIGHBOURS)
        for _ in range(min(step, runs.settings.steps)):
            swarm.step()
        found.append(100 * covered_share(swarm.places_m, sensors, ground))
    return found


def _coverage_at(outcomes: Sequence[Outcome], step: int) -> list[float]:
    """Percent covered at a step, or in the end where that comes before."""
    return [100 * float(run.history.coverage[min(step, run.steps)]) for run in outcomes]


def figure_18_section(runs: Runs) -> Section:
    """Figure 18: the ways by each method, and how smooth they are."""
    mission, step = maps.small(SHOWN), paper.STEPS_FIGURE_12
    panels, rows, turned = [], [], {}
    for letter, controller in zip("abcd", COMPARED, strict=True):
        shown = runs(mission, controller)
        panels.append(
            ways_panel(
                f"({letter}) {controller.name}", mission, shown, step, COLOURS[controller.name],
                paper.ROBOT_FIGURE_18,
            )
        )  # fmt: skip
    for controller in WITH_SAMPLED:
        outcomes = runs.seeds(mission, controller)
        ways = [float(run.history.way_m[min(step, run.steps)]) for run in outcomes]
        straight = [_straight_m(run, step) for run in outcomes]
        turned[controller] = [100 * float(run.history.reversals[1 : step + 1].sum()) / step for run in outcomes]
        detour = [way / line for way, line in zip(ways, straight, strict=True)]
        told = "smoothest" if controller in (EXACT, SAMPLED) else NOTHING if controller is SETTLE else "less smooth"
        rows.append(
            (controller.name, told, plus_minus(ways, ".0f"), plus_minus(detour, ".2f"),
             plus_minus(turned[controller], ".2f"))
        )  # fmt: skip
    means = {controller: float(np.mean(values)) for controller, values in turned.items()}
    table = Table(
        title=f"Ways up to k = {step}, {len(turned[EXACT])} seeds",
        head=("controller", "paper", "way m", "way / straight line", "velocity reversals %"),
        rows=tuple(rows),
        words=(0, 1),
    )
    holds = means[EXACT] < min(means[VORONOI], means[FORCES])
    return Section(
        figure=18,
        heading="ways and oscillation",
        pictures=(
            Picture(
                "chen2018-figure-18.png",
                "Ways of 25 robots by four controllers, one of them in red",
                study_picture(panels),
            ),
        ),
        caption=f"Figure 18, (a) to (c) as in the paper, with robot {paper.ROBOT_FIGURE_18} in red. Numbers are "
        "given to "
        "robots at random, so that it is not the robot of the paper. A reversal is a velocity at more than a right "
        "angle to the one before, counted of all robots in all steps; robots at rest turn no more.",
        paper="RD's trajectories are smoother and oscillate less than those of the V-based method and VFA.",
        found=_claim(
            holds,
            "RD turns back least",
            f"of RD's velocities {means[EXACT]:.2f} % are reversals, of the V-based method's {means[VORONOI]:.2f} "
            "%, of "
            f"VFA's {means[FORCES]:.2f} %",
        )
        + " RD's ways are the shortest, in part because robots stop where they cover less.",
        tables=(table,),
    )


def _straight_m(run: Outcome, step: int) -> float:
    """The mean distance of robots from their starts, at a step."""
    return float(np.hypot(*(run.places_at(step) - run.places_m[0]).T).mean())


def figure_19_section(runs: Runs) -> Section:
    """Figure 19: coverage and deadweight loss by step."""
    mission = maps.small(SHOWN)
    found = [(controller, runs.seeds(mission, controller)) for controller in COMPARED]
    most = Level(f"most possible, {MOST_PERCENT:.2f} %", MOST_PERCENT, OVER_PERIOD)
    panels = [
        CurvePanel(
            title="(a) Coverage rate", curves=mean_curves(found, "coverage", CURVE_STEPS), across="step k", up="%",
            levels=(most,), wide=True,
        ),
        CurvePanel(
            title="(b) Deadweight loss", curves=mean_curves(found, "deadweight_loss", CURVE_STEPS), across="step k",
            up="%", wide=True,
        ),
    ]  # fmt: skip
    rows, early = [], {}
    for controller, outcomes in found:
        early[controller] = [float(np.mean(_coverage_at(outcomes, step))) for step in MOMENTS]
        loss = [100 * (1 - run.coverage * 100 / MOST_PERCENT) for run in outcomes]
        told = "most" if controller is EXACT else NOTHING if controller is SETTLE else "less"
        cells = (f"{value:.1f}" for value in early[controller])
        rows.append((controller.name, told, *cells, coverage_cell(outcomes), plus_minus(loss, ".2f")))
    table = Table(
        title=f"Coverage %, mean of {len(found[0][1])} seeds, and deadweight loss % in the end",
        head=("controller", "paper", *(f"k = {step}" for step in MOMENTS), "end", "loss in the end"),
        rows=tuple(rows),
        words=(0, 1),
    )
    first = [step for k, step in enumerate(MOMENTS) if early[EXACT][k] > max(early[VORONOI][k], early[FORCES][k])]
    ahead = (
        f"at k = {', '.join(map(str, first))} RD is ahead of both" if first else "at none of these steps RD is ahead"
    )
    ends = {controller: float(np.mean([run.coverage for run in outcomes])) for controller, outcomes in found}
    return Section(
        figure=19,
        heading="coverage rate and deadweight loss",
        pictures=(
            Picture(
                "chen2018-figure-19.png",
                "Coverage and deadweight loss by step, mean and range of the seeds, for four controllers",
                study_picture(panels),
            ),
        ),
        caption="Figure 19: means over the seeds, and from the least to the most. Curves count pixels of 0.5 m, which "
        "reads 0.1 points high at most; ends in the table are exact. Deadweight loss is not defined in the paper; "
        "ours is "
        "1 − area covered / sum of the discs' areas.",
        paper="RD has a higher coverage rate and less deadweight loss than the other two “at the same time”; no values "
        "are told.",
        found=_claim(
            ends[EXACT] > max(ends[VORONOI], ends[FORCES]),
            "RD covers most",
            f"in the end RD covers {ends[EXACT]:.1%}, the V-based method {ends[VORONOI]:.1%}, VFA "
            f"{ends[FORCES]:.1%} and "
            f"settle {ends[SETTLE]:.1%}; {ahead}",
        )
        + " What RD does not cover lies in gaps that no robot is drawn to: with 4 neighbours a robot heeds "
        "half-planes, not areas, and rests as soon as they surround it.",
        tables=(table,),
    )


def figure_20_section(runs: Runs) -> Section:
    """Figure 20 and Table 3: steps by the number of robots, and the time of a decision."""
    settings = runs.settings
    jobs = {
        (controller.name, scale): [
            Job(maps.square(scale, SHOWN), controller, runs.seed + k, settings.scale_steps)
            for k in range(settings.scale_seeds)
        ]
        for scale in reversed(settings.scales)
        for controller in COMPARED
    }
    runs.all([job for several in jobs.values() for job in several])  # two at a time, the longest first
    curves, rows, settled, resting = [], [], {}, {}
    at = np.array(settings.scales, dtype=np.float64)
    for controller in COMPARED:
        cells, rested_with = [], []
        for scale in settings.scales:
            outcomes = runs.all(jobs[controller.name, scale])
            settled[controller.name, scale] = float(np.mean([run.history.settled_step() for run in outcomes]))
            rested = [run.steps for run in outcomes if run.at_rest]
            all_rest = len(rested) == len(outcomes)
            rested_with += [str(scale)] if all_rest else []
            rest = f"{np.mean(rested):,.0f}" if all_rest else f"{len(rested)} of {len(outcomes)} rest"
            cells.append(f"{settled[controller.name, scale]:,.0f} / {rest}")
        rows.append((controller.name, *cells))
        resting[controller.name] = f"{joined(rested_with)} robots" if rested_with else "no number of robots"
        values = np.array([settled[controller.name, scale] for scale in settings.scales])
        curves.append(Curve(controller.name, values, COLOURS[controller.name], at=at))
    panel = CurvePanel(
        title="Steps until the coverage stays within half a point of its last value", curves=tuple(curves),
        across="robots", up="steps", logarithmic=True, logarithmic_across=True, wide=True,
    )  # fmt: skip
    largest = settings.scales[-1]
    fastest = min((one.name for one in COMPARED[:3]), key=lambda name: settled[name, largest])
    table = Table(
        title=f"Steps until coverage is within half a point / until rest, mean of {settings.scale_seeds} seeds",
        head=("controller", *(f"{scale} robots" for scale in settings.scales)),
        rows=tuple(rows),
    )
    times, means = decision_times(runs)
    return Section(
        figure=20,
        heading="convergence by the number of robots, and Table 3",
        pictures=(
            Picture(
                "chen2018-figure-20.png",
                "Steps until the coverage has settled, by the number of robots, for four controllers",
                study_picture([panel]),
            ),
        ),
        caption="Figure 20. Area and start box grow with the robots, as dense as in Table 2; the paper does not "
        "tell how. "
        f"At most {settings.scale_steps:,} steps. Rest alone would say nothing of methods that "
        "creep or tremble around a good place for long.",
        paper="RD is more scalable than the other two (Section 5.1); no values are told.",
        found=_claim(
            fastest == EXACT.name,
            f"with {largest} robots the coverage of RD settles first of the three",
            f"with {largest} robots the coverage of {fastest} settles first of the three, after "
            f"{settled[fastest, largest]:,.0f} steps, that of RD after {settled[EXACT.name, largest]:,.0f}",
        )
        + " By the stop rule alone, all seeds rest by "
        + joined([f"{name} with {up_to}" for name, up_to in resting.items()])
        + ". RD slows down with the number because robots inside wait for those outside (Figure 21). "
        + _told_times(means),
        tables=(table, times),
    )


def _told_times(means: dict[str, float]) -> str:
    """What Table 3 shows, in words; means: microseconds of a decision by each controller."""
    exact, sampled = means[EXACT.name], means[SAMPLED.name]
    paper_rd = paper.TABLE_3_MS["RD"][-1]
    ratios = [
        f"{one.name} takes {means[one.name] / exact:.1f} times as long (in the paper "
        f"{paper.TABLE_3_MS[one.name][-1] / paper_rd:.1f} times)"
        for one in (VORONOI, FORCES)
    ]
    others = [means[one.name] for one in (VORONOI, FORCES)]
    place = "slower than both" if sampled > max(others) else "faster than both" if sampled < min(others) else "between"
    return (
        f"Table 3: by the exact centroid RD decides in {exact:.2f} µs; {joined(ratios)}. By 1,000 random "
        "velocities, as "
        f"printed, it takes {sampled:.1f} µs, which is {place}. That all are so much faster than in the paper is a "
        "matter of programs, not of machines: a range-limited Voronoi cell needs its neighbours only, not a Voronoi "
        "diagram of all."
    )


def decision_times(runs: Runs) -> tuple[Table, dict[str, float]]:
    """Table 3, and each controller's mean time of a decision in microseconds. It is measured."""
    cases: tuple[Mission, ...] = (maps.small(SHOWN), maps.with_obstacle(SHOWN), maps.small("corner"))
    rows, means = [], {}
    for controller in WITH_SAMPLED:
        runs.tell(f"timing {controller.name}")
        runs.stop_if_asked()
        taken = [decision_us(mission, controller, runs.seed, runs.settings.timed_steps) for mission in cases]
        means[controller.name] = float(np.mean(taken))
        name = "RD" if controller is SAMPLED else controller.name
        told = paper.TABLE_3_MS.get(name, ()) if controller is not EXACT else ()
        cells = [f"{value:.3f}" for value in told] or [NOTHING] * 4
        rows.append((controller.name, *cells, *(f"{value:.2f}" for value in taken), f"{means[controller.name]:.2f}"))
    table = Table(
        title="Table 3: time of one robot's decision, 25 robots. The paper: milliseconds, eight cores; here: "
        "microseconds of processor time, one thread",
        head=("controller", *(f"paper, case {k}, ms" for k in (1, 2, 3)), "paper, mean, ms",
              "no obstacle, µs", "obstacle, µs", "corner, µs", "mean, µs"),
        rows=tuple(rows),
    )  # fmt: skip
    return table, means


def decision_us(mission: Mission, controller: Controller, seed: int, steps: int) -> float:
    """Processor time for one robot and step in microseconds: neighbours, decision, filter, motion; least of three."""
    mission = replace(mission, planning=controller.settings)
    ground = free_ground(mission)
    starts = place_starts(mission, ground, seed=seed, reserve_m=0.0)
    least_s = np.inf
    for _ in range(3):
        swarm = make_swarm(mission, ground, starts, seed=seed)
        began_s = time.thread_time()
        for _ in range(steps):
            swarm.step()
        least_s = min(least_s, time.thread_time() - began_s)
    return float(least_s / steps / len(swarm) * 1e6)
