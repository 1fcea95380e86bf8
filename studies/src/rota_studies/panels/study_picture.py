"""A study's picture: panels with maps and curves in rows, as wide as a page's column, each with its legend below."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from rota.draw.house_style import house_style
from rota.draw.legends import axes_at, legend_height, place_legend
from rota.draw.mission_picture import plain
from rota.draw.palette import GROUND, OBSTACLE, OUTSIDE, OVER_PERIOD, ROUTE_COLOURS, ZONE_EDGE, ZONE_TINTS
from rota.draw.picture_file import UNDATED
from rota_studies.panels.cells_panel import HEAT, HeatPanel
from rota_studies.panels.curve_panel import CurvePanel
from rota_studies.panels.map_panel import MapPanel
from rota_studies.panels.relief_panel import ReliefPanel

Panel = MapPanel | CurvePanel | ReliefPanel
PictureForm = Literal["png", "svg", "pdf"]

# inches
WIDTH, MARGIN, GAP, Y_AXIS, X_AXIS, TITLE, NOTE, CURVE_HEIGHT = 6.1, 0.06, 0.16, 0.5, 0.4, 0.24, 0.17, 2.1
CURVE_INSET = (0.2, 0.38)  # its numbers need more room: to the left, and with the last one's right half together
LEGEND_BEYOND = 0.5  # by how much it may be wider than the axes
TITLE_PT, NOTE_PT = 9.0, 7.5
DPI = 132  # some 800 pixels wide: a page with all pictures of a study stays small
ON_GROUND, ON_ZONES = (0.08, 0.16, 0.3, 0.5, 0.75, 1.0), (0.15, 0.4)  # shares of an ink in a blend


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


def _slope(panel: MapPanel | ReliefPanel) -> float:
    """Height over width of the map with its rim."""
    if isinstance(panel, ReliefPanel):
        return panel.slope
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
        high = max([wide * _slope(one) for one in group if not isinstance(one, CurvePanel)], default=CURVE_HEIGHT)
        head = TITLE + (NOTE if any(panel.note for panel in group) else 0.0)
        foot = X_AXIS + max(legend_height(panel.entries, wide + LEGEND_BEYOND) for panel in group)
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
            ax = axes_at(fig, left + inset, y, row.width - narrower, row.high)
            panel.draw(ax)
            _keep_labels_inside(fig, ax)
            title_at, note_at = ((y + row.high + 0.06 + up) / height for up in (row.head - TITLE, 0.0))
            fig.text(left / width, title_at, plain(panel.title, 90), fontsize=TITLE_PT, fontweight="bold", va="bottom")
            fig.text(left / width, note_at, plain(panel.note, 90), fontsize=NOTE_PT, color="#444444", va="bottom")
            place_legend(fig, panel.entries, left - 0.1, y - X_AXIS, row.width + LEGEND_BEYOND)
        top -= row.height + GAP
    return fig


def _keep_labels_inside(fig: Figure, ax: Axes) -> None:
    """Move numbers below the axes to the left that would stick out of the picture on the right."""
    for label in ax.get_xticklabels():
        if label.get_window_extent().x1 > fig.bbox.x1:
            label.set_horizontalalignment("right")


def study_picture(
    panels: Sequence[Panel], *, columns: int = 2, width: float = WIDTH, form: PictureForm = "png"
) -> bytes:
    """The picture as the bytes of a file; a PNG is small, of few colours. The same panels give the same bytes."""
    drawn = io.BytesIO()
    with house_style():
        fig = study_figure(panels, columns=columns, width=width)
        fig.savefig(drawn, format=form, dpi=DPI, metadata=UNDATED.get(f".{form}"))
    if form != "png":
        return drawn.getvalue()
    drawn.seek(0)
    small = io.BytesIO()
    with Image.open(drawn) as picture:
        heat = HEAT if any(isinstance(panel, HeatPanel) for panel in panels) else ()
        _in_house_colours(picture.convert("RGB"), heat).save(small, format="PNG", optimize=True)
    return small.getvalue()


def _in_house_colours(picture: Image.Image, more: Sequence[str] = ()) -> Image.Image:
    """The picture with every colour replaced by the nearest of the house's palette and ``more``."""
    pixels = np.asarray(picture, dtype=np.int64)
    packed, places = np.unique(pixels @ (65536, 256, 1), return_inverse=True)
    found = np.column_stack([packed >> 16, packed >> 8 & 255, packed & 255])
    palette = _house_palette(more)
    away = np.array([((found - colour) ** 2).sum(axis=1) for colour in palette])
    indexed = Image.fromarray(away.argmin(axis=0).astype(np.uint8)[places].reshape(pixels.shape[:2]), mode="P")
    indexed.putpalette(palette.ravel().tolist())
    return indexed


def _house_palette(more: Sequence[str]) -> NDArray[np.int64]:
    """Colours (n, 3), n at most 256: greys, and those of lines and marks with their blends into ground and zones.

    A palette chosen from the picture would give up the colours of small marks, by which they are told apart.
    """
    greys = [(level, level, level) for level in range(0, 256, 17)]
    grounds = [to_rgb(tint) for tint in (GROUND, *ZONE_TINTS)]
    inks = [to_rgb(ink) for ink in (*ROUTE_COLOURS, OVER_PERIOD, ZONE_EDGE)]
    shades = [(ground, ground, 0.0) for ground in (*grounds, to_rgb(OUTSIDE), to_rgb(OBSTACLE))]
    shades += [(grounds[0], ink, share) for ink in inks for share in ON_GROUND]
    shades += [(ground, ink, share) for ground in grounds[1:] for ink in inks for share in ON_ZONES]
    blends = [tuple(round(255 * (a + share * (b - a))) for a, b in zip(*pair, strict=True)) for *pair, share in shades]
    blends += [tuple(round(255 * level) for level in to_rgb(colour)) for colour in more]
    return np.array(list(dict.fromkeys([*greys, *blends])), dtype=np.int64)
