"""Legends and axes placed by inches, outside of what is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

LEGEND_PT = 7.5
LEGEND_ROW, BAR = 0.175, 0.13  # inches


def _columns(entries: Sequence[Artist], width: float) -> int:
    """How many legend columns of the longest entry fit in ``width`` inches."""
    longest = max((len(str(entry.get_label())) for entry in entries), default=0)
    return max(1, int(width / (0.45 + 0.0575 * longest * LEGEND_PT / 7.5)))


def legend_height(entries: Sequence[Artist], width: float) -> float:
    """How high in inches a legend of these entries is when it is at most ``width`` inches wide; 0 without any."""
    return -(-len(entries) // _columns(entries, width)) * LEGEND_ROW + 0.06 if entries else 0.0


def place_legend(fig: Figure, entries: Sequence[Artist], x: float, y: float, width: float) -> None:
    """A legend at most ``width`` inches wide whose upper left corner is at x, y inches; nothing without entries."""
    if entries:
        fig.legend(
            handles=list(entries),
            loc="upper left",
            bbox_to_anchor=(x / fig.get_figwidth(), y / fig.get_figheight()),
            ncols=_columns(entries, width),
            fontsize=LEGEND_PT,
            frameon=False,
            borderpad=0,
            borderaxespad=0,
            labelspacing=0.45,
            handlelength=2.4,
            handletextpad=0.6,
            columnspacing=1.4,
        )


def axes_at(fig: Figure, x: float, y: float, width: float, height: float) -> Axes:
    """Axes whose lower left corner is at x, y and whose size is width by height, all in inches."""
    wide, high = fig.get_size_inches()
    return fig.add_axes((x / wide, y / high, width / wide, height / high))


def scale_bar(
    fig: Figure, image: AxesImage, place_in: tuple[float, float, float], label: str = "", **how: Any
) -> Colorbar:
    """The scale of an image's colours, its lower left corner at x, y inches, so wide; how: as matplotlib takes it."""
    bar = fig.colorbar(image, cax=axes_at(fig, *place_in, BAR), orientation="horizontal", **how)
    bar.ax.tick_params(labelsize=LEGEND_PT, length=2.5, pad=2)
    bar.outline.set_linewidth(0.5)
    if label:
        bar.set_label(label, fontsize=LEGEND_PT, labelpad=1.5)
    return bar
