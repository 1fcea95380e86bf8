"""What a sweep came to, as pictures: means with confidence intervals, of all combinations and along each field."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rota.draw.mission_picture import plain
from rota.draw.palette import OVER_PERIOD, route_style
from rota.draw.picture_file import write_picture
from rota.sweep.summary import Summary, measures_of, show_value

TITLES = {
    "robots": "robots", "length_m": "length of all loops, m", "coverage": "share covered", "cpu_s": "CPU time, s",
}  # fmt: skip
INTERVAL = "mean over the seeds that met their demand, and Student's 95 % interval"
MOST_ROWS = 120
ROW_IN, HEAD_IN, PANEL_IN = 0.22, 0.9, 2.6  # inches
LABEL_MARKS_IN = 0.075  # inches for each letter of a label
LOGARITHMIC_FROM = 30.0  # greatest over least value


def draw_sweep(found: Sequence[Summary], folder: Path) -> list[str]:
    """Write summary.png, and by-FIELD.png for each field that is set to several numbers; returns the files' names.

    Each file appears whole or not at all. Raises RotaError where one cannot be written.
    """
    written = ["summary.png"]
    write_picture(folder / written[0], lambda: summary_figure(found))
    for field in numeric_fields(found):
        written.append(f"by-{''.join(mark if mark.isalnum() or mark in '._-' else '-' for mark in field)}.png")
        write_picture(folder / written[-1], partial(field_figure, found, field))
    return written


def numeric_fields(found: Sequence[Summary]) -> list[str]:
    """The fields that combinations with plans set to two different numbers or more."""
    values: dict[str, set[float]] = {}
    for each in found:
        for field, value in each.settings.items():
            if each.means and isinstance(value, int | float) and not isinstance(value, bool):
                values.setdefault(field, set()).add(float(value))
    return [field for field, numbers in values.items() if len(numbers) > 1]


def summary_figure(found: Sequence[Summary]) -> Figure:
    """A row for each combination, the first ``MOST_ROWS`` of them: robots with their bound, length and CPU time."""
    rows = list(found[:MOST_ROWS])
    labels = [plain(each.label, 80) for each in rows]
    measures = measures_of(found) or ["robots"]
    left_in = 0.3 + LABEL_MARKS_IN * max(len(label) for label in labels)
    size = (left_in + len(measures) * PANEL_IN + 0.2, HEAD_IN + 0.25 + ROW_IN * (len(rows) + 1))
    figure = Figure(figsize=size, layout="constrained", facecolor="white")
    places = range(len(rows))
    panels = figure.subplots(1, len(measures), sharey=True, squeeze=False)[0]
    for panel, measure in zip(panels, measures, strict=True):
        for place, each in zip(places, rows, strict=True):
            _whisker(panel, place, each, measure)
        if measure == "robots":
            bounds = [(each.bound, place) for place, each in zip(places, rows, strict=True) if each.bound is not None]
            if bounds:
                panel.plot(*zip(*bounds, strict=True), "|", color="#444444", markersize=11, label="proved bound")
                panel.legend(loc="lower left", bbox_to_anchor=(0, 1), fontsize=7, frameon=False, borderpad=0)
        _scale(panel, [each.means[measure].mean for each in rows if measure in each.means], measure, axis="x")
        panel.set_xlabel(TITLES[measure])
        panel.grid(axis="x", color="#DDDDDD", linewidth=0.6)
        panel.set_axisbelow(True)
        panel.set(yticks=list(places), yticklabels=labels, ylim=(len(rows) - 0.4, -0.6))
    more = "" if len(rows) == len(found) else f"; the first {len(rows)} of {len(found)} combinations"
    figure.suptitle(INTERVAL + more, fontsize=8, x=0.01, ha="left")
    return figure


def _whisker(panel: Axes, place: int, each: Summary, measure: str) -> None:
    """The mean of one combination and its interval; words where it has none."""
    mean = each.means.get(measure)
    if mean is None:
        if measure == "robots":
            panel.text(
                0.02, place, f"no plan: {', '.join(each.outcomes)}", color=OVER_PERIOD, fontsize=7, va="center",
                transform=panel.get_yaxis_transform(),
            )  # fmt: skip
        return
    colour, _ = route_style(0)
    panel.errorbar(mean.mean, place, xerr=mean.half_width, fmt="o", color=colour, markersize=4, capsize=2.5)


def field_figure(found: Sequence[Summary], field: str) -> Figure:
    """The measures along one field, a line for each combination of all else."""
    lines: dict[str, list[Summary]] = {}
    for each in found:
        if each.means and isinstance(each.settings.get(field), int | float):
            others = {path: value for path, value in each.settings.items() if path != field}
            named = [
                each.mission,
                each.planner,
                each.effort or "",
                *(f"{p} {show_value(v)}" for p, v in others.items()),
            ]
            lines.setdefault(", ".join(filter(None, named)), []).append(each)
    numbers = [each.settings[field] for line in lines.values() for each in line]
    apart = 0.012 * (max(numbers) - min(numbers))  # so that whiskers of several lines can be told apart
    high = 3.4 + 0.17 * math.ceil(len(lines) / 2)
    measures = measures_of([each for line in lines.values() for each in line])
    figure = Figure(figsize=(3.4 * len(measures), high), layout="constrained", facecolor="white")
    for panel, measure in zip(figure.subplots(1, len(measures)), measures, strict=True):
        for k, (label, unordered) in enumerate(lines.items()):
            line = sorted((each for each in unordered if measure in each.means), key=lambda each: each.settings[field])
            colour, style = route_style(k)
            means = [each.means[measure] for each in line]
            half_widths = [mean.half_width or 0.0 for mean in means]
            panel.errorbar(
                [each.settings[field] + (k - len(lines) / 2 + 0.5) * apart for each in line],
                [mean.mean for mean in means], yerr=half_widths, color=colour, linestyle=style, marker="o",
                markersize=3.5, capsize=2.5, label=plain(label, 70),
            )  # fmt: skip
        _scale(
            panel,
            [each.means[measure].mean for line in lines.values() for each in line if measure in each.means],
            measure,
            axis="y",
        )
        panel.set(xlabel=field, ylabel=TITLES[measure])
        panel.grid(color="#DDDDDD", linewidth=0.6)
        panel.set_axisbelow(True)
    handles, labels = panel.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower left", ncols=2, fontsize=7, frameon=False)
    figure.suptitle(INTERVAL, fontsize=8, x=0.01, ha="left")
    return figure


def _scale(panel: Axes, values: Sequence[float], measure: str, *, axis: str) -> None:
    """Whole robots, and a logarithmic scale where values differ much."""
    positive = [value for value in values if value > 0]
    if len(positive) == len(values) > 0 and max(positive) / min(positive) > LOGARITHMIC_FROM:
        panel.set(**{f"{axis}scale": "log"})
        return
    if measure == "robots":
        (panel.xaxis if axis == "x" else panel.yaxis).set_major_locator(MaxNLocator(integer=True))
    if values:
        panel.set(**{f"{axis}lim": (0, None)})
