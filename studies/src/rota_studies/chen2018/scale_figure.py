"""Figure 20 and Table 3: the published controller beside the baselines and ours, by the number of robots."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rota_studies.chen2018 import maps
from rota_studies.chen2018.compared_figures import claimed
from rota_studies.chen2018.decision_times import decision_times, times_verdict, told_times
from rota_studies.chen2018.panels import COLOURS
from rota_studies.chen2018.runs import COMPARED, EXACT, FORCES, VORONOI, Job, Runs, StudySettings
from rota_studies.chen2018.small_figures import SHOWN
from rota_studies.panels.curve_panel import Curve, CurvePanel
from rota_studies.section import Picture, Section
from rota_studies.tables import Table, joined, plus_minus
from rota_studies.verdict import Outcome, Verdict, compared


def figure_20_section(runs: Runs) -> Section:
    """Figure 20 and Table 3: steps by the number of robots, and the time of a decision."""
    settings = runs.settings
    rows, curves, settled, resting = _by_scale(runs)
    means = {key: float(np.mean(steps)) for key, steps in settled.items()}
    panel = CurvePanel(
        title="Steps until the coverage stays within half a point of its last value", curves=curves,
        across="robots", up="steps", logarithmic=True, logarithmic_across=True, wide=True,
    )  # fmt: skip
    largest = settings.scales[-1]
    fastest = min((controller.name for controller in COMPARED[:3]), key=lambda name: means[name, largest])
    table = Table(
        title=f"Steps until coverage is within half a point / until rest, mean of {settings.scale_seeds} seeds",
        head=("controller", *(f"{scale} robots" for scale in settings.scales)),
        rows=rows,
    )
    times, measured = decision_times(runs)
    return Section(
        figure=20,
        heading="convergence by the number of robots, and Table 3",
        pictures=(
            Picture(
                "chen2018-figure-20.png",
                "Steps until the coverage has settled, by the number of robots, for four controllers",
                (panel,),
            ),
        ),
        caption="Figure 20. Area and start box grow with the robots, as dense as in Table 2; the paper does not tell "
        f"how. At most {settings.scale_steps:,} steps, where curves end for what has not settled by then, which is "
        "what was cut off before its coverage had stayed for a quarter of the run. Rest alone would say nothing of "
        "methods that creep or tremble around a good place for long.",
        paper="RD is more scalable than the other two (Section 5.1); no values are told.",
        ours=claimed(
            fastest == EXACT.name,
            f"with {largest} robots the coverage of RD settles first of the three",
            f"with {largest} robots the coverage of {fastest} settles first of the three, "
            f"{_after(means[fastest, largest], settings.scale_steps)}, that of RD "
            f"{_after(means[EXACT.name, largest], settings.scale_steps)}",
        )
        + " By the stop rule alone, all seeds rest by "
        + joined([f"{name} with {up_to}" for name, up_to in resting.items()])
        + ". RD slows down with the number because robots inside wait for those outside (Figure 21). "
        + told_times(measured),
        tables=(table, times),
        verdicts=(_scale_verdict(settled, settings), times_verdict(measured)),
    )


def _by_scale(
    runs: Runs,
) -> tuple[tuple[tuple[str, ...], ...], tuple[Curve, ...], dict[tuple[str, int], list[float]], dict[str, str]]:
    """By controller: its row, its curve, when it settled by the number of robots, and the numbers that all rest."""
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
            steps = [run.settled for run in outcomes]
            settled[controller.name, scale] = steps
            rested = [run.steps for run in outcomes if run.at_rest]
            all_rest = len(rested) == len(outcomes)
            rested_with += [str(scale)] if all_rest else []
            rest = plus_minus(rested, ",.0f") if all_rest else f"{len(rested)} of {len(outcomes)} rest"
            cells.append(f"{_settled_cell(steps, settings.scale_steps)} / {rest}")
        rows.append((controller.name, *cells))
        resting[controller.name] = f"{joined(rested_with)} robots" if rested_with else "no number of robots"
        values = np.array(
            [min(np.mean(settled[controller.name, scale]), settings.scale_steps) for scale in settings.scales]
        )
        curves.append(Curve(controller.name, values, COLOURS[controller.name], at=at))
    return tuple(rows), tuple(curves), settled, resting


def _settled_cell(steps: Sequence[float], most: int) -> str:
    """Mean and deviation of the steps until coverage has settled, and how many runs had not settled if any."""
    unsettled = sum(not np.isfinite(step) for step in steps)
    return f"> {most:,} ({unsettled} of {len(steps)})" if unsettled else plus_minus(steps, ",.0f")


def _after(step: float, most: int) -> str:
    """After how many steps a run settles, in words."""
    return f"after {step:,.0f} steps" if np.isfinite(step) else f"not within {most:,} steps in every run"


def _scale_verdict(settled: dict[tuple[str, int], list[float]], settings: StudySettings) -> Verdict:
    """Whether RD's coverage settles first with every number of robots; what has not settled counts as cut off."""
    most, judged = settings.scale_steps, {}
    for scale in settings.scales:
        own, *others = (np.minimum(settled[one.name, scale], most) for one in (EXACT, VORONOI, FORCES))
        judged[scale] = compared(np.min(others, axis=0) - own, ours=True, form=",.0f", unit=" steps")
    outcomes = [one.outcome for one in judged.values()]
    failed = [outcome for outcome in outcomes if outcome == "not reproduced"]
    outcome: Outcome = "holds" if set(outcomes) == {"holds"} else failed[0] if failed else "cannot be told"
    told = "; ".join(f"{scale} robots {one.told}" for scale, one in judged.items())
    return Verdict(
        "RD converges faster and is more scalable", "5.1, Figure 20", outcome,
        f"Steps by which its coverage settles before the better of both: {told}. How the paper's baselines were made "
        "is not told.",
    )  # fmt: skip
