"""A plan of bouncing robots on its cells: the ways they face there, and how often each cell is entered.

After Alam & Bobadilla 2020, Figures 6b and 10a (arrows) and 9b (heat map).
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray
from shapely import MultiPolygon, union_all

from rota.draw.house_style import house_style
from rota.draw.legends import LEGEND_PT, axes_at, legend_height, place_legend
from rota.draw.mission_picture import draw_mission, frame, outline, plain
from rota.draw.palette import OUTSIDE, route_style
from rota.draw.plan_picture import FORMATS, UNDATED
from rota.draw.two_maps import DPI
from rota.errors import PlanError
from rota.files.atomic_write import replaced_file, require_suffix
from rota.mission import BounceSettings, Mission
from rota.plan import Plan, Trajectory

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MAP_WIDTH, MARGIN, HEADER, AXIS, BAR, GAP = 4.6, 0.15, 0.6, 0.4, 0.13, 0.85  # inches
ARROW = 0.36  # cells
APART = 0.12  # cells, between the arrows of robots that face the same way in one cell


class FacedCells(NamedTuple):
    """Where a robot is after each step, (n, 2) cells from the area's lower left corner, and the ways it faces, (n,).

    entered: (n,) whether it came there in this step, or began there.
    """

    cells: Ints
    headings_rad: Floats
    entered: NDArray[np.bool_]


def faced_cells(mission: Mission, trajectory: Trajectory) -> FacedCells:
    """The cells and headings of a bouncing robot, step by step; a longer wait counts as one step."""
    corner, cell_m = np.array(mission.area.bounds[:2]), mission.bounce.cell_m
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
    x0, y0, x1, y1 = plan.mission.area.bounds
    cell_m = plan.mission.bounce.cell_m
    columns, rows = (max(1, math.ceil(size / cell_m - 1e-9)) for size in (x1 - x0, y1 - y0))
    found = np.zeros((rows, columns), np.int64)
    for trajectory in plan:
        faced = faced_cells(plan.mission, trajectory)
        np.add.at(found, (faced.cells[faced.entered, 1], faced.cells[faced.entered, 0]), 1)
    return found


def draw_headings(plan: Plan, ax: Axes) -> None:
    """Arrows from the cells where robots are along the ways they face, on the ground that a body's centre may enter.

    The start of each robot is a circle. Ground within the widest body's radius of a border is grey.
    """
    mission = plan.mission
    draw_mission(mission, ax)
    radius_m = max(robot.body_radius_m for robot in mission.fleet.robots or (mission.fleet.equal_robot("r"),))
    walls = union_all([obstacle.shape for obstacle in mission.obstacles if obstacle.blocks_motion])
    ground = mission.area.difference(walls)
    rim = ground.difference(ground.buffer(-radius_m))
    parts = [part for part in getattr(rim, "geoms", [rim]) if part.geom_type == "Polygon" and part.area > 0]
    if parts:
        ax.add_patch(PathPatch(outline(MultiPolygon(parts)), facecolor=OUTSIDE, edgecolor="none", zorder=1.5))
    cell_m, corner = mission.bounce.cell_m, np.array(mission.area.bounds[:2])
    apart_m = cell_m * min(APART, ARROW / max(len(plan.trajectories) - 1, 1))
    for k, trajectory in enumerate(plan):
        faced = faced_cells(mission, trajectory)
        states = np.unique(np.column_stack([faced.cells, np.round(faced.headings_rad % math.tau, 9)]), axis=0)
        centres = corner + (states[:, :2] + 0.5) * cell_m
        beside_m = apart_m * (k - (len(plan.trajectories) - 1) / 2)
        centres += beside_m * np.column_stack([-np.sin(states[:, 2]), np.cos(states[:, 2])])
        along = ARROW * cell_m * np.column_stack([np.cos(states[:, 2]), np.sin(states[:, 2])])
        colour, _ = route_style(k)
        ax.quiver(*centres.T, *along.T, color=colour, angles="xy", scale_units="xy", scale=1, width=0.004, zorder=4)
        ax.plot(*trajectory.positions_m[0, :2], "o", color=colour, markersize=7, fillstyle="none", zorder=5)


def draw_entries(plan: Plan, ax: Axes) -> AxesImage:
    """How often each cell is entered, as a heat map; returns the image, for a colour bar."""
    draw_mission(plan.mission, ax, fill=False)
    entries = entries_of_cells(plan)
    x0, y0, *_ = plan.mission.area.bounds
    rows, columns = entries.shape
    cell_m = plan.mission.bounce.cell_m
    extent = (x0, x0 + columns * cell_m, y0, y0 + rows * cell_m)
    shown = np.ma.masked_equal(entries, 0)
    image = ax.imshow(shown, origin="lower", extent=extent, cmap=colormaps["viridis"], vmin=0, zorder=1.2)
    frame(plan.mission, ax)  # which the image has changed
    return image


def cells_figure(plan: Plan) -> Figure:
    """Both panels side by side; TypeError for a plan of another planner."""
    mission = plan.mission
    x0, y0, x1, y1 = mission.area.bounds
    high = min(MAP_WIDTH * (y1 - y0) / (x1 - x0), 7.5)
    wide = high * (x1 - x0) / (y1 - y0)
    handles = [Line2D([], [], color=route_style(k)[0], marker="o", fillstyle="none", label=plain(t.robot))
               for k, t in enumerate(plan)]  # fmt: skip
    below = AXIS + max(legend_height(handles, wide), BAR + AXIS)
    width, height = 2 * (wide + GAP), HEADER + high + below + MARGIN
    entries = entries_of_cells(plan)
    fig = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(fig)
    x, y = GAP * 0.7, below + MARGIN
    fig.text(x / width, 1 - MARGIN / height, plain(mission.name), fontsize=12, fontweight="bold", va="top")
    left = axes_at(fig, x, y, wide, high)
    draw_headings(plan, left)
    left.set_title("Cells and the ways that robots face there", fontsize=9, loc="left", pad=4)
    place_legend(fig, handles, x, y - AXIS, wide)
    right = axes_at(fig, x + wide + GAP, y, wide, high)
    image = draw_entries(plan, right)
    right.set_title(f"Times entered; {int((entries > 0).sum())} cells", fontsize=9, loc="left", pad=4)
    place = axes_at(fig, x + wide + GAP, y - AXIS - BAR, wide, BAR)
    bar = fig.colorbar(image, cax=place, orientation="horizontal", ticks=MaxNLocator(integer=True))
    bar.ax.tick_params(labelsize=LEGEND_PT, length=2.5, pad=2)
    bar.outline.set_linewidth(0.5)
    return fig


def draw_cells(plan: Plan, path: str | Path) -> None:
    """Draw a plan of bouncing robots on its cells to ``path`` as PNG, SVG or PDF, by its suffix.

    The file appears whole or not at all, and the same plan gives the same bytes. Raises RotaError for another suffix, a
    folder that cannot be written to, and PlanError for a plan of another planner.
    """
    path = Path(path)
    suffix = require_suffix(path, FORMATS, "a picture")
    if not isinstance(plan.mission.planning, BounceSettings):
        raise PlanError(f"a plan of {plan.mission.planning.planner} has no cells to draw; one of bounce is needed")
    if plan.mission.bounce.cells == "none":
        raise PlanError(f"mission {plan.mission.name}: bounce.cells is none: there are no cells to draw")
    with house_style():
        fig = cells_figure(plan)
        with replaced_file(path) as partial:
            fig.savefig(partial, format=suffix[1:], dpi=DPI, metadata=UNDATED.get(suffix))
