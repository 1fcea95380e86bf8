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
    """Values (n,) at 0, 1, 2, ... of what the panel's horizontal axis counts."""

    label: str
    values: Floats
    colour: str
    style: LineStyle = "solid"


class Level(NamedTuple):
    """A horizontal line at a value that the curves are compared with."""

    label: str
    value: float
    colour: str


@dataclass(frozen=True, kw_only=True)
class CurvePanel:
    """Curves under a title, each ending in its last value. ``logarithmic``: the vertical axis. ``note``: see MapPanel.

    wide: it takes the whole row.
    """

    title: str
    curves: tuple[Curve, ...]
    across: str
    up: str
    note: str = ""
    levels: tuple[Level, ...] = ()
    logarithmic: bool = False
    wide: bool = False

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
            ax.plot(curve.values, color=curve.colour, linestyle=curve.style, linewidth=1.3, drawstyle="steps-post")
            ax.plot(len(curve.values) - 1, curve.values[-1], ".", color=curve.colour, markersize=5, clip_on=False)
        for level in self.levels:
            ax.axhline(level.value, color=level.colour, linewidth=1.0, linestyle=DASHED)
        if self.logarithmic:
            ax.set_yscale("log")
            ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0), numticks=16))
            ax.yaxis.set_minor_locator(NullLocator())
        else:
            ax.yaxis.set_major_locator(MaxNLocator(nbins=6, steps=[1, 2, 2.5, 5, 10]))
        ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.10g}"))
        ax.xaxis.set_major_locator(MaxNLocator(nbins=5, integer=True, steps=[1, 2, 2.5, 5, 10]))
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
        ax.set_xlim(0, max(1, max(len(curve.values) for curve in self.curves) - 1))
        ax.set_xlabel(self.across, fontsize=FONT_PT, labelpad=1.5)
        ax.set_ylabel(self.up, fontsize=FONT_PT, labelpad=1.5)
        ax.tick_params(labelsize=FONT_PT, length=2.5, pad=2)
        ax.grid(color=FAINT, linewidth=0.5)
        ax.set_axisbelow(True)
        ax.spines[["top", "right"]].set_visible(False)


DASHED: LineStyle = (0.0, (5.0, 2.0))
