"""Means with Student's intervals, against a table of his, and what is said of combinations without plans."""

from __future__ import annotations

import csv
import io
from typing import Any

import pytest

from rota.sweep.summary import mean_of, summaries, summary_csv, summary_table


@pytest.mark.parametrize(
    ("values", "mean", "half_width"),
    [
        # t(0.975) of a printed table: 12.706 of 1 degree of freedom, 4.303 of 2, 2.262 of 9
        ([1.0, 3.0], 2.0, 12.706),
        ([1.0, 2.0, 3.0], 2.0, 4.303 / 3**0.5),
        ([4.0] * 5 + [6.0] * 5, 5.0, 2.262 * (10 / 9) ** 0.5 / 10**0.5),
        ([7.0, 7.0], 7.0, 0.0),
    ],
)
def test_intervals_are_students(values: list[float], mean: float, half_width: float) -> None:
    found = mean_of(values)
    assert (found.mean, found.count) == (mean, len(values))
    assert found.half_width == pytest.approx(half_width, abs=5e-4)


def test_a_single_value_has_no_interval() -> None:
    assert mean_of([3.5]).half_width is None


def row(seed: int, speed: float, outcome: str = "met", **values: Any) -> dict[str, Any]:
    return {
        "mission": "yard", "mission_file": "yard.yaml", "planner": "patrol", "effort": "quick", "seed": seed,
        "settings": {"fleet.speed_m_s": speed}, "outcome": outcome, "met": outcome == "met", **values,
    }  # fmt: skip


def test_what_met_its_demand_counts_and_the_rest_is_counted() -> None:
    measured = {"lower_bound_robots": 2, "length_m": 1200.0}
    rows = [
        row(0, 2, robots=3, cpu_s=1.0, **measured),
        row(1, 2, robots=5, cpu_s=2.0, **measured),
        row(2, 2, "no plan", robots=1, cpu_s=90.0),
        row(0, 4, "refused", reason="too fast"),
    ]
    two, four = summaries(rows)
    assert (two.cells, two.met, two.bound, two.means["robots"].mean) == (3, 2, 2, 4.0)
    assert two.outcomes == {"met": 2, "no plan": 1}
    assert (four.met, four.bound, dict(four.means)) == (0, None, {})
    head, first, second = (line.split("  ") for line in summary_table([two, four]).splitlines())
    assert [cell.strip() for cell in head if cell] == [
        "mission", "planner", "effort", "fleet.speed_m_s", "met", "bound", "robots", "loops m", "CPU s",
    ]  # fmt: skip
    assert [cell.strip() for cell in first if cell][4:] == [
        "2 of 3", "2", "4.00 ± 12.71", "1,200 ± 0", "1.5 ± 6.4",
    ]  # fmt: skip
    assert [cell.strip() for cell in second if cell][4:] == ["0 of 1", "-", "-", "-", "-"]
    told = list(csv.DictReader(io.StringIO(summary_csv([two, four]))))
    assert [each["no plan"] for each in told] == ["1", "0"]
    assert float(told[0]["robots_half_width"]) == pytest.approx(12.706, abs=5e-4)
    assert told[1]["robots_mean"] == ""
