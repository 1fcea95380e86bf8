"""A study's picture: panels with maps and curves in rows, as wide as a page's column, each with its legend below."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from rota.draw.curve_panel import CurvePanel
from rota.draw.house_style import house_style
from rota.draw.legends import axes_at, legend_height, place_legend
from rota.draw.map_panel import MapPanel
from rota.draw.mission_picture import plain
from rota.draw.plan_picture import DPI

Panel = MapPanel | CurvePanel

# inches
WIDTH, MARGIN, GAP, Y_AXIS, X_AXIS, TITLE, NOTE, CURVE_HEIGHT = 6.1, 0.06, 0.16, 0.5, 0.4, 0.24, 0.17, 2.1
CURVE_INSET = (0.2, 0.38)  # its numbers need more room: to the left, and with the last one's right half together
TITLE_PT, NOTE_PT = 9.0, 7.5


@dataclass(frozen=True, kw_only=True)
class _Row:
    """Panels side by side, and sizes in inches: of a panel's axes, and what stands above and below them."""

    panels: tuple[Panel, ...]
    width: float
    high: float
    head: float
    foot: float

    @property
    def height(self) -> float:
        return self.head + self.high + self.foot


def _slope(panel: MapPanel) -> float:
    """Height over width of the map with its rim."""
    left, bottom, right, top = panel.mission.area.bounds
    pad_m = 0.05 * ((right - left) * (top - bottom)) ** 0.5
    return float((top - bottom + pad_m) / (right - left + pad_m))


def _rows(panels: Sequence[Panel], columns: int, width: float) -> list[_Row]:
    """The panels in rows of ``columns``; a wide one has a row to itself."""
    groups: list[list[Panel]] = []
    for panel in panels:
        alone = isinstance(panel, CurvePanel) and panel.wide
        if alone or not groups or len(groups[-1]) == columns:
            groups.append([panel])
        else:
            groups[-1].append(panel)
    rows = []
    for group in groups:
        share = 1 if isinstance(group[0], CurvePanel) and group[0].wide else columns
        wide = (width - 2 * MARGIN - (share - 1) * GAP) / share - Y_AXIS
        high = max([wide * _slope(one) for one in group if isinstance(one, MapPanel)], default=CURVE_HEIGHT)
        head = TITLE + (NOTE if any(panel.note for panel in group) else 0.0)
        foot = X_AXIS + max(legend_height(panel.entries, wide + 0.3) for panel in group)
        rows.append(_Row(panels=tuple(group), width=wide, high=high, head=head, foot=foot))
    return rows


def study_figure(panels: Sequence[Panel], *, columns: int = 2, width: float = WIDTH) -> Figure:
    """The picture as a matplotlib figure ``width`` inches wide, panels row by row in the order given."""
    rows = _rows(panels, columns, width)
    height = sum(row.height for row in rows) + (len(rows) - 1) * GAP + 2 * MARGIN
    fig = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(fig)
    top = height - MARGIN
    for row in rows:
        for k, panel in enumerate(row.panels):
            left, y = MARGIN + Y_AXIS + k * (row.width + Y_AXIS + GAP), top - row.head - row.high
            inset, narrower = CURVE_INSET if isinstance(panel, CurvePanel) else (0.0, 0.0)
            panel.draw(axes_at(fig, left + inset, y, row.width - narrower, row.high))
            title_at, note_at = ((y + row.high + 0.06 + up) / height for up in (row.head - TITLE, 0.0))
            fig.text(left / width, title_at, plain(panel.title, 90), fontsize=TITLE_PT, fontweight="bold", va="bottom")
            fig.text(left / width, note_at, plain(panel.note, 90), fontsize=NOTE_PT, color="#444444", va="bottom")
            place_legend(fig, panel.entries, left - 0.1, y - X_AXIS, row.width + 0.3)
        top -= row.height + GAP
    return fig


def study_picture(panels: Sequence[Panel], *, columns: int = 2, width: float = WIDTH) -> bytes:
    """The picture as the bytes of a PNG file of 256 colours at most; the same panels give the same bytes."""
    with house_style():
        fig = study_figure(panels, columns=columns, width=width)
        drawn = io.BytesIO()
        fig.savefig(drawn, format="png", dpi=DPI)
    drawn.seek(0)
    small = io.BytesIO()
    with Image.open(drawn) as picture:
        picture.convert("RGB").quantize(256, method=Image.Quantize.MEDIANCUT).save(small, format="PNG", optimize=True)
    return small.getvalue()
