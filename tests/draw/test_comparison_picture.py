"""Plans side by side: panels of one size, what stands over them, and a panel without a plan."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rota.draw.comparison_picture import NO_PLAN, Panel, comparison_figure, draw_comparison
from rota.errors import RotaError
from rota.model.plan import Plan


def panel(title: str, plan: Plan | None, *, met: bool = True) -> Panel:
    return Panel(title=title, caption=f"about {title}", plan=plan, met=met)


def test_panels_are_alike_and_stand_row_by_row(yard: Plan) -> None:
    fig = comparison_figure(yard.mission, [panel(name, yard) for name in ("a", "b", "c", "d")])
    boxes = [ax.get_window_extent() for ax in fig.axes]
    assert len(boxes) == 4
    assert np.ptp([box.width for box in boxes]) < 1e-6
    places = [(round(box.x0), round(box.y0)) for box in boxes]
    assert places == sorted(places, key=lambda place: (-place[1], place[0]))
    assert all(ax.get_xlim() == fig.axes[0].get_xlim() for ax in fig.axes)
    assert [text.get_text() for text in fig.texts][:3] == ["yard", "a", "about a"]
    frame = fig.get_window_extent()
    assert all(frame.x0 <= box.x0 and box.x1 <= frame.x1 and frame.y0 <= box.y0 and box.y1 <= frame.y1 for box in boxes)


def test_a_wide_map_is_stacked(strip: Plan) -> None:
    fig = comparison_figure(strip.mission, [panel("a", strip), panel("b", strip)])
    one, other = (ax.get_window_extent() for ax in fig.axes)
    assert one.x0 == pytest.approx(other.x0)
    assert one.y0 > other.y1


def test_a_method_without_a_plan_has_a_panel_that_says_so(yard: Plan) -> None:
    fig = comparison_figure(yard.mission, [panel("a", yard), panel("b", None, met=False)])
    assert NO_PLAN in [text.get_text() for text in fig.axes[1].texts]
    colours = {text.get_text(): text.get_color() for text in fig.texts}
    assert colours["about b"] != colours["about a"]


def test_same_plans_same_bytes(yard: Plan, tmp_path: Path) -> None:
    for name in ("one.svg", "other.svg"):
        draw_comparison(yard.mission, [panel("a", yard), panel("b", None, met=False)], tmp_path / name)
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "other.svg").read_bytes()


def test_nothing_to_draw_and_unknown_formats_are_refused(yard: Plan, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="none is given"):
        comparison_figure(yard.mission, [])
    with pytest.raises(RotaError, match=r"\.bmp.*is no format for a picture"):
        draw_comparison(yard.mission, [panel("a", yard)], tmp_path / "a.bmp")
