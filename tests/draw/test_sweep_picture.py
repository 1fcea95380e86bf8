"""Pictures of sweeps: each mean, interval and bound where it belongs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from matplotlib.axes import Axes
from PIL import Image

from rota.draw import draw_sweep
from rota.draw.sweep_picture import field_figure, numeric_fields, summary_figure
from rota.sweep.summary import Mean, Summary


def summary(speed: float, robots: float | None, *, method: str = "tours", **means: Mean) -> Summary:
    known = {} if robots is None else {"robots": Mean(mean=robots, half_width=0.5, count=3), **means}
    settings = {"fleet.speed_m_s": speed, "patrol.method": method}
    return Summary(
        mission="yard", planner="patrol", effort="quick", settings=settings, cells=3, met=3 if known else 0, bound=2,
        means=known, outcomes={"met": 3} if known else {"no plan": 2, "crashed": 1},
    )  # fmt: skip


LENGTH = Mean(mean=120.0, half_width=None, count=1)
FOUND = [
    summary(2, 4.0, length_m=LENGTH),
    summary(4, 3.0, length_m=LENGTH),
    summary(8, None),
    summary(4, 5.0, method="sun2019"),
]


def whiskers(panel: Axes) -> list[tuple[float, float, float]]:
    """Of each whisker along x the place, its lower and its upper end."""
    bars = [bar for collection in panel.collections for bar in collection.get_segments()]  # type: ignore[attr-defined]
    return [(float(bar[0][1]), float(bar[0][0]), float(bar[1][0])) for bar in bars]


def test_rows_have_their_means_intervals_and_bounds() -> None:
    figure = summary_figure(FOUND)
    robots, length = figure.axes
    assert next(label.get_text() for label in robots.get_yticklabels()) == (
        "yard, patrol, quick, fleet.speed_m_s 2, patrol.method tours"
    )
    assert sorted(whiskers(robots)) == [(0.0, 3.5, 4.5), (1.0, 2.5, 3.5), (3.0, 4.5, 5.5)]
    bounds = next(line for line in robots.lines if line.get_label() == "proved bound")
    assert list(bounds.get_xdata()) == [2, 2, 2, 2]
    assert [text.get_text() for text in robots.texts] == ["no plan: no plan, crashed"]
    assert length.get_xlabel() == "length of all loops, m"
    assert whiskers(length) == []  # means of single plans


def test_a_line_for_each_combination_of_all_else() -> None:
    assert numeric_fields(FOUND) == ["fleet.speed_m_s"]
    assert numeric_fields(FOUND[2:]) == []
    figure = field_figure(FOUND, "fleet.speed_m_s")
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["yard, patrol, quick, patrol.method tours", "yard, patrol, quick, patrol.method sun2019"]
    lines: list[Any] = [
        line for line in figure.axes[0].lines if len(line.get_xdata()) == 2 and line.get_marker() == "o"
    ]
    assert list(lines[0].get_ydata()) == [4.0, 3.0]
    assert list(lines[0].get_xdata()) == pytest.approx([2, 4], abs=0.1)


def test_files_are_written(tmp_path: Path) -> None:
    assert draw_sweep(FOUND, tmp_path) == ["summary.png", "by-fleet.speed_m_s.png"]
    for name in ("summary.png", "by-fleet.speed_m_s.png"):
        with Image.open(tmp_path / name) as picture:
            assert picture.getextrema()[0][0] < 100  # something is drawn on the white
