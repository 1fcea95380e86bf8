"""Cells of bouncing robots on a map, as panels of a study's picture: the ways robots face there, or a value of each."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import Normalize, to_hex
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from rota.draw.cells_picture import draw_headings
from rota.draw.mission_picture import draw_mission, mission_legend, plain
from rota.draw.palette import ink_on, route_style
from rota_studies.panels.map_panel import MapPanel

Floats = NDArray[np.float64]

LEVELS = 48
HEAT = tuple(to_hex(colour) for colour in colormaps["viridis"].resampled(LEVELS)(np.arange(LEVELS)))
"""The colours of values, lowest first."""
LEGEND_LEVELS = 5
NUMBER_PT = 5.5


@dataclass(frozen=True, kw_only=True)
class HeadingsPanel(MapPanel):
    """Arrows from the cells where a plan's robots are along the ways they face; each start is a circle."""

    @property
    def entries(self) -> list[Artist]:
        """What the legend tells of it."""
        assert self.plan is not None
        robots = [
            Line2D([], [], color=route_style(k)[0], marker="o", fillstyle="none", label=plain(one.robot))
            for k, one in enumerate(self.plan)
        ]
        return [*robots, *mission_legend(self.mission)]

    def draw(self, ax: Axes) -> None:
        """Draw it on ``ax``."""
        assert self.plan is not None
        draw_headings(self.plan, ax)


@dataclass(frozen=True, kw_only=True)
class HeatPanel(MapPanel):
    """A value of each cell of a grid from the area's lower left corner as a colour: (rows, columns), NaN for none.

    top: the value of the brightest colour; the darkest is 0. form: of the numbers in the legend and, with
    ``numbered``, in the cells.
    """

    values: Floats = field(default_factory=lambda: np.zeros((1, 1)))
    cell_m: float = 1.0
    top: float = 1.0
    form: str = ".0f"
    numbered: bool = False

    @property
    def entries(self) -> list[Artist]:
        """What the legend tells of it."""
        levels = np.linspace(0, self.top, LEGEND_LEVELS)
        # a level is told as it is rounded, and has the colour of what is told
        told = dict.fromkeys(format(level, self.form) for level in levels)
        found: list[Artist] = [Patch(facecolor=_colour(float(text) / self.top), label=text) for text in told]
        return [*found, *mission_legend(self.mission)]

    def draw(self, ax: Axes) -> None:
        """Draw it on ``ax``."""
        draw_mission(self.mission, ax, fill=False)
        limits = ax.axis()
        rows, columns = self.values.shape
        x0, y0, *_ = self.mission.area.bounds
        shares = Normalize(0, self.top)(self.values)
        for row in range(rows):
            for column in range(columns):
                value = self.values[row, column]
                if not np.isfinite(value):
                    continue
                x, y = x0 + column * self.cell_m, y0 + row * self.cell_m
                colour = _colour(float(shares[row, column]))
                ax.fill(
                    [x, x + self.cell_m, x + self.cell_m, x],
                    [y, y, y + self.cell_m, y + self.cell_m],
                    facecolor=colour, edgecolor="none", zorder=1.2,
                )  # fmt: skip
                if self.numbered:
                    ax.text(
                        x + self.cell_m / 2, y + self.cell_m / 2, format(value, self.form), ha="center", va="center",
                        fontsize=NUMBER_PT, color=ink_on(colour), zorder=4,
                    )  # fmt: skip
        ax.axis(limits)


def _colour(share: float) -> str:
    return HEAT[min(int(share * LEVELS), LEVELS - 1)]
