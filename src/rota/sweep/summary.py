"""What a sweep came to: for each combination the mean over its seeds, with a 95 % confidence interval.

Intervals are Student's t: mean plus or minus t(0.975, n - 1) s / sqrt(n) over the n seeds whose plans meet their
demand, with s their standard deviation. They are meant for means of several seeds that differ by chance alone; with one
seed there is none.
"""

from __future__ import annotations

import csv
import io
import json
import math
import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rota.files.spreadsheet_cells import as_cells
from rota.model.columns import columns
from rota.sweep.planned_cells import Row

LEVEL = 0.95
# what the table and the pictures show: its name as the head of a column, and digits
MEASURES = {"robots": ("robots", 2), "length_m": ("loops m", 0), "coverage": ("covered", 3), "cpu_s": ("CPU s", 1)}


@dataclass(frozen=True, kw_only=True)
class Mean:
    """The mean of ``count`` values, and the half-width of its confidence interval; None for a single value."""

    mean: float
    half_width: float | None
    count: int


@dataclass(frozen=True, kw_only=True)
class Summary:
    """One combination: what it is, how many of its cells met their demand, and the means of those that did.

    settings: values by field path. bound: the highest number of robots proved to be needed; None where none is. means:
    by the names of ``MEASURES``, those that such plans have; none where no cell met its demand. CPU seconds are without
    the first plan of a process, which loads compiled loops, where there are others. outcomes: cells by their outcome.
    """

    mission: str
    planner: str
    effort: str | None
    settings: Mapping[str, Any]
    cells: int
    met: int
    bound: int | None
    means: Mapping[str, Mean]
    outcomes: Mapping[str, int]

    @property
    def label(self) -> str:
        """The combination in words."""
        named = [f"{path} {show_value(value)}" for path, value in self.settings.items()]
        return ", ".join([self.mission, self.planner, *([self.effort] if self.effort else []), *named])


def show_value(value: Any) -> str:
    """The value of a field as people write it."""
    return value if isinstance(value, str) else json.dumps(value)


def mean_of(values: Sequence[float]) -> Mean:
    """The mean of at least one value with Student's interval."""
    count = len(values)
    half_width = None
    if count > 1:
        from scipy.special import stdtrit

        spread = float(stdtrit(count - 1, 0.5 + LEVEL / 2))
        half_width = spread * statistics.stdev(values) / math.sqrt(count)
    return Mean(mean=statistics.fmean(values), half_width=half_width, count=count)


def summaries(rows: Sequence[Row]) -> list[Summary]:
    """A summary of each combination, in the order of the rows."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        place = [row["mission_file"], row["planner"], row["effort"], row["settings"]]
        groups.setdefault(json.dumps(place), []).append(row)
    return [_summary(group) for group in groups.values()]


def measures_of(found: Sequence[Summary]) -> list[str]:
    """Those of ``MEASURES`` that some combination has a mean of; swarms alone have a coverage."""
    return [name for name in MEASURES if any(name in each.means for each in found)]


def _values(met: Sequence[Row], name: str) -> list[float]:
    """The values of a measure; none where a row has no such value."""
    later = [row for row in met if row.get("planned_before") != 0]
    values = [row.get(name) for row in (later if name == "cpu_s" and later else met)]
    numbers = [float(value) for value in values if value is not None]
    return numbers if len(numbers) == len(values) else []


def _summary(rows: list[Row]) -> Summary:
    """What the runs of one mission and its settings came to."""
    met = [row for row in rows if row["met"]]
    bounds = [row["lower_bound_robots"] for row in rows if row.get("lower_bound_robots") is not None]
    first = rows[0]
    return Summary(
        mission=first["mission"] or first["mission_file"], planner=first["planner"], effort=first["effort"],
        settings=first["settings"], cells=len(rows), met=len(met), bound=max(bounds, default=None),
        means={name: mean_of(values) for name in MEASURES if (values := _values(met, name))},
        outcomes=dict(Counter(row["outcome"] for row in rows)),
    )  # fmt: skip


def summary_table(found: Sequence[Summary]) -> str:
    """The summaries as plain text, a row each: mean ± half-width of the interval."""
    fields = list(dict.fromkeys(path for summary in found for path in summary.settings))
    measures = measures_of(found)
    rows = [["mission", "planner", "effort", *fields, "met", "bound", *(MEASURES[name][0] for name in measures)]]
    for each in found:
        settings = [show_value(each.settings[path]) if path in each.settings else "-" for path in fields]
        bound = "-" if each.bound is None else str(each.bound)
        means = [_mean_in_words(each.means.get(name), MEASURES[name][1]) for name in measures]
        names = [each.mission, each.planner, each.effort or "-"]
        rows.append([*names, *settings, f"{each.met} of {each.cells}", bound, *means])
    return columns(rows, range(3 + len(fields)))


def _mean_in_words(mean: Mean | None, digits: int) -> str:
    if mean is None:
        return "-"
    told = f"{mean.mean:,.{digits}f}"
    return told if mean.half_width is None else f"{told} ± {mean.half_width:,.{digits}f}"


def summary_csv(found: Sequence[Summary]) -> str:
    """The summaries as CSV, with all digits; a column for each field that is set and for each outcome."""
    fields = list(dict.fromkeys(path for summary in found for path in summary.settings))
    outcomes = sorted({outcome for summary in found for outcome in summary.outcomes})
    parts = ("mean", "half_width", "count")
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    measures = measures_of(found)
    measured = [f"{name}_{part}" for name in measures for part in parts]
    writer.writerow(["mission", "planner", "effort", *fields, "cells", *outcomes, "lower_bound_robots", *measured])
    for each in found:
        settings = [show_value(each.settings[path]) if path in each.settings else None for path in fields]
        means = [each.means.get(name) for name in measures]
        values = [None if mean is None else getattr(mean, part) for mean in means for part in parts]
        counts = [each.outcomes.get(outcome, 0) for outcome in outcomes]
        names = as_cells([each.mission, each.planner, each.effort, *settings])
        writer.writerow([*names, each.cells, *counts, each.bound, *values])
    return stream.getvalue()
