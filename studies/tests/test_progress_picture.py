"""The anytime curve as a picture: what the lines and dots stand at."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rota.errors import RotaError
from rota.planning.progress import SearchState
from rota_studies.progress_curve import ProgressPoint, progress_curve
from rota_studies.progress_picture import draw_progress, progress_figure


def points() -> tuple[ProgressPoint, ...]:
    """Four robots that get better and are met after 3 s; then three that are not."""
    four = [
        SearchState(stage="searched", robots=4, unseen_share=0.1, late_share=0.0),
        SearchState(stage="searched", robots=4, unseen_share=0.01, late_share=0.2),
        SearchState(stage="checked", robots=4, unseen_share=0.002, late_share=0.0),
        SearchState(stage="checked", robots=4, unseen_share=0.0, late_share=0.0, met=True),
    ]
    three = SearchState(stage="searched", robots=3, unseen_share=0.05, late_share=0.0)
    return progress_curve((float(k), state) for k, state in enumerate([*four, three]))


def test_lines_and_dots_stand_where_the_numbers_are() -> None:
    fig = progress_figure(points(), title="yard", bound=2, search_s=5.0)
    above, below = fig.axes
    (best,) = above.lines
    assert best.get_xdata() == pytest.approx([0, 1, 2, 3, 4, 5])
    assert best.get_ydata() == pytest.approx([10, 10, 0.2, 0, 0, 0])
    dots = np.vstack([dots.get_offsets() for dots in above.collections if len(dots.get_offsets())])
    assert sorted(map(tuple, dots.tolist())) == [(0, 10), (1, 1), (2, 0.2), (3, 0), (4, 5)]
    by_label = {line.get_label(): line for line in below.lines}
    assert list(by_label) == ["tried", "best so far, not met", "best so far, met", "proved bound"]
    assert by_label["tried"].get_ydata() == pytest.approx([4, 4, 4, 4, 3])
    nan = np.nan
    met, unmet = by_label["best so far, met"], by_label["best so far, not met"]
    assert met.get_ydata() == pytest.approx([nan, nan, nan, 4, 4, 4], nan_ok=True)
    assert unmet.get_ydata() == pytest.approx([4, 4, 4, nan, nan, nan], nan_ok=True)
    assert set(by_label["proved bound"].get_ydata()) == {2}
    assert below.get_ylim() == pytest.approx((1.4, 4.6))


def test_the_legend_tells_robots_and_kinds_and_fits_the_picture() -> None:
    fig = progress_figure(points(), title="yard", bound=2, search_s=5.0)
    legend = fig.axes[0].get_legend()
    texts = [text.get_text() for text in legend.get_texts()]
    assert texts[:2] == ["4 robots", "3 robots"]
    assert texts[2:] == ["searching", "searching, some late", "check: not met", "check: met", "best so far"]
    frame = fig.get_window_extent()
    for ax in fig.axes:
        place = ax.get_legend().get_window_extent()
        assert frame.x0 <= place.x0
        assert place.x1 <= frame.x1
        assert frame.y0 <= place.y0
        assert place.y1 <= frame.y1


def test_a_search_that_told_nothing_is_drawn_too(tmp_path: Path) -> None:
    draw_progress((), tmp_path / "empty.png", title="yard", bound=None, search_s=0.0)
    assert (tmp_path / "empty.png").stat().st_size > 1000


def test_same_points_same_bytes_and_unknown_formats_are_refused(tmp_path: Path) -> None:
    for name in ("one.svg", "other.svg"):
        draw_progress(points(), tmp_path / name, title="yard", bound=2, search_s=5.0)
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "other.svg").read_bytes()
    with pytest.raises(RotaError, match=r"\.csv.*is no format for a picture"):
        draw_progress(points(), tmp_path / "a.csv", title="yard", bound=2, search_s=5.0)
