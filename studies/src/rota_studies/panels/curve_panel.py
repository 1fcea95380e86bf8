"""How a search went, as curves: a cost or a length against iterations; one panel of a study's picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator
from numpy.typing import NDArray

from rota.draw.mission_picture import FONT_PT
from rota.draw.palette import LineStyle

Floats = NDArray[np.float64]

FAINT = "#D9D9D9"


class Curve(NamedTuple):
    """Values (n,) at 0, 1, 2, ... of what the panel's horizontal axis counts, or at ``at`` (n,), increasing.

    band: (2, n), lowest and highest values round it, shaded. marked: whether values at places have marks. Values that
    are not finite are left out.
    """

    label: str
    values: Floats
    colour: str
    style: LineStyle = "solid"
    at: Floats | None = None
    band: Floats | None = None
    width_pt: float = 1.3
    marked: bool = True

    @property
    def places(self) -> Floats:
        """(n,): where on the horizontal axis the values are."""
        return np.arange(len(self.values), dtype=np.float64) if self.at is None else self.at


class Level(NamedTuple):
    """A horizontal line at a value that the curves are compared with."""

    label: str
    value: float
    colour: str


@dataclass(frozen=True, kw_only=True)
class CurvePanel:
    """Curves under a title, each ending in its last value. ``logarithmic``: the vertical axis. ``note``: see MapPanel.

    logarithmic_across: the horizontal one, for curves whose places are given and above 0; any other begins at
    ``first_across``. wide: it takes the whole row.
    """

    title: str
    curves: tuple[Curve, ...]
    across: str
    up: str
    note: str = ""
    levels: tuple[Level, ...] = ()
    logarithmic: bool = False
    logarithmic_across: bool = False
    wide: bool = False
    first_across: float = 0.0

    @property
    def entries(self) -> list[Artist]:
        """What the legend tells of it; nothing where there is one curve alone."""
        lines: list[Artist] = [
            Line2D([], [], color=curve.colour, linestyle=curve.style, label=curve.label) for curve in self.curves
        ]
        lines += [
            Line2D([], [], color=one.colour, linewidth=1.0, linestyle=DASHED, label=one.label) for one in self.levels
        ]
        return lines if len(lines) > 1 else []

    def draw(self, ax: Axes) -> None:
        """Draw it on ``ax``."""
        for curve in self.curves:
            counted = curve.at is None
            if curve.band is not None:
                ax.fill_between(curve.places, *curve.band, color=curve.colour, alpha=0.16, linewidth=0)
            ax.plot(
                curve.places, curve.values, color=curve.colour, linestyle=curve.style, linewidth=curve.width_pt,
                drawstyle="steps-post" if counted else "default", markersize=5,
                marker="." if curve.marked and not counted else "",
            )  # fmt: skip
            ax.plot(curve.places[-1], curve.values[-1], ".", color=curve.colour, markersize=5, clip_on=False)
        for level in self.levels:
            ax.axhline(level.value, color=level.colour, linewidth=1.0, linestyle=DASHED)
        if self.logarithmic:
            ax.set_yscale("log")
            ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0), numticks=16))
            ax.yaxis.set_minor_locator(NullLocator())
        else:
            ax.yaxis.set_major_locator(MaxNLocator(nbins=6, steps=[1, 2, 2.5, 5, 10]))
        ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.10g}"))
        if self.logarithmic_across:
            ax.set_xscale("log")
            ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=16))
            ax.xaxis.set_minor_locator(NullLocator())
        else:
            ax.xaxis.set_major_locator(MaxNLocator(nbins=5, integer=True, steps=[1, 2, 2.5, 5, 10]))
            ax.set_xlim(
                self.first_across, max(self.first_across + 1, max(float(curve.places[-1]) for curve in self.curves))
            )
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
        ax.set_xlabel(self.across, fontsize=FONT_PT, labelpad=1.5)
        ax.set_ylabel(self.up, fontsize=FONT_PT, labelpad=1.5)
        ax.tick_params(labelsize=FONT_PT, length=2.5, pad=2)
        ax.grid(color=FAINT, linewidth=0.5)
        ax.set_axisbelow(True)
        ax.spines[["top", "right"]].set_visible(False)


DASHED: LineStyle = (0.0, (5.0, 2.0))
