"""How often bouncing robots enter each cell of their grid, as numbers and as a heat map.

After Alam & Bobadilla 2020, Figure 9b.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from numpy.typing import NDArray

from rota.draw.legends import LEGEND_PT, axes_at
from rota.draw.mission_picture import draw_mission, frame, mission_legend
from rota.draw.two_maps import Half
from rota.draw.zone_labels import draw_zone_labels
from rota.mission import Mission
from rota.plan import Plan, Trajectory

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BAR, BAR_TEXT = 0.13, 0.3  # inches
MOST_LINEAR = 20  # entries of a cell, up to which colours are even steps; beyond, even factors
TICKS = 5


class FacedCells(NamedTuple):
    """Where a robot is after each step, (n, 2) cells from the grid's lower left corner, and the ways it faces, (n,).

    entered: (n,) whether it came there in this step, or began there.
    """

    cells: Ints
    headings_rad: Floats
    entered: NDArray[np.bool_]


def faced_cells(mission: Mission, trajectory: Trajectory) -> FacedCells:
    """The cells and headings of a bouncing robot, step by step; a longer wait counts as one step."""
    corner, cell_m = np.array(mission.grid_corner_m), mission.bouncing.cell_m
    at = np.floor((trajectory.positions_m[:, :2] - corner) / cell_m).astype(np.int64)
    assert trajectory.headings_rad is not None
    cells, headings, entered = [at[0]], [float(trajectory.headings_rad[0])], [True]
    for leg, move in enumerate(np.diff(at, axis=0)):
        steps = math.gcd(int(move[0]), int(move[1]))
        cells += [at[leg] + move * k // steps for k in range(1, steps + 1)] or [at[leg]]
        headings += [float(trajectory.headings_rad[leg + 1])] * max(steps, 1)
        entered += [steps > 0] * max(steps, 1)
    return FacedCells(np.array(cells), np.array(headings), np.array(entered))


def entries_of_cells(plan: Plan) -> Ints:
    """(rows, columns) how often robots enter each cell on their trajectories, starts included, loops once."""
    (x0, y0), (_, _, x1, y1) = plan.mission.grid_corner_m, plan.mission.area.bounds
    cell_m = plan.mission.bouncing.cell_m
    columns, rows = (max(1, math.ceil(size / cell_m - 1e-9)) for size in (x1 - x0, y1 - y0))
    found = np.zeros((rows, columns), np.int64)
    for trajectory in plan:
        faced = faced_cells(plan.mission, trajectory)
        np.add.at(found, (faced.cells[faced.entered, 1], faced.cells[faced.entered, 0]), 1)
    return found


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
    bar = fig.colorbar(image, cax=axes_at(fig, x, y, width, BAR), orientation="horizontal")
    bar.set_ticks(ticks, labels=[f"{value:,}" for value in ticks])
    bar.ax.minorticks_off()
    bar.ax.tick_params(labelsize=LEGEND_PT, length=2.5, pad=2)
    bar.outline.set_linewidth(0.5)


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
