"""How often bouncing robots enter each cell of their grid, as a heat map.

After Alam & Bobadilla 2020, Figure 9b.
"""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from rota.cells.entered_cells import entries_of_cells
from rota.draw.legends import BAR, scale_bar
from rota.draw.mission_picture import draw_mission, frame, mission_legend
from rota.draw.two_maps import Half
from rota.draw.zone_labels import draw_zone_labels
from rota.model.plan import Plan

BAR_TEXT = 0.3  # inches
MOST_LINEAR = 20  # entries of a cell, up to which colours are even steps; beyond, even factors
TICKS = 5


def draw_entries(plan: Plan, ax: Axes) -> AxesImage:
    """How often each cell is entered, as a heat map; returns the image, for a colour bar."""
    draw_mission(plan.mission, ax, fill=False)
    entries = entries_of_cells(plan)
    x0, y0 = plan.mission.grid_corner_m
    rows, columns = entries.shape
    cell_m = plan.mission.bouncing.cell_m
    extent = (x0, x0 + columns * cell_m, y0, y0 + rows * cell_m)
    shown, most = np.ma.masked_equal(entries, 0), int(entries.max())
    norm = Normalize(0, most) if most <= MOST_LINEAR else LogNorm(1, most)
    image = ax.imshow(shown, origin="lower", extent=extent, cmap=colormaps["viridis"], norm=norm, zorder=1.2)
    frame(plan.mission, ax)  # which the image has changed
    draw_zone_labels(plan.mission, ax, [])
    return image


def entries_bar(fig: Figure, image: AxesImage, x: float, y: float, width: float) -> None:
    """The scale of a heat map of whole numbers, its lower left corner at (x, y) inches."""
    most = int(image.get_array().max())  # type: ignore[union-attr]
    ticks = sorted({round(value) for value in np.linspace(min(1, most), most, TICKS)})
    if most > MOST_LINEAR:
        ticks = [value * 10**k for k in range(6) for value in (1, 2, 5) if value * 10**k <= most]
    bar = scale_bar(fig, image, (x, y, width))
    bar.set_ticks(ticks, labels=[f"{value:,}" for value in ticks])
    bar.ax.minorticks_off()


def entries_title(plan: Plan) -> str:
    """What the heat map shows."""
    count = int((entries_of_cells(plan) > 0).sum())
    return f"Times entered, starts included; {count:,} cells"


def entries_half(plan: Plan) -> Half:
    """The heat map as one half of a plan's picture."""
    images: list[AxesImage] = []
    return Half(
        title=entries_title(plan),
        draw=lambda ax: images.append(draw_entries(plan, ax)),
        legend=mission_legend(plan.mission),
        scale_in=BAR + BAR_TEXT,
        scale=lambda fig, x, y, width: entries_bar(fig, images[0], x, y - BAR, width),
    )
