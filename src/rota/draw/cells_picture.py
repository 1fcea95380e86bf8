"""A plan of bouncing robots on its cells: the ways they face there, and how often each cell is entered.

After Alam & Bobadilla 2020, Figures 6b and 10a (arrows) and 9b (heat map).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from shapely import union_all

from rota.cells.entered_cells import faced_cells
from rota.draw.entered_cells import draw_entries, entries_bar, entries_title
from rota.draw.legends import BAR, axes_at, legend_height, place_legend
from rota.draw.mission_picture import draw_mission, mission_legend, outline, plain, points_per_metre
from rota.draw.palette import OUTSIDE, route_style
from rota.draw.picture_file import new_figure, write_picture
from rota.draw.routes import routes_of
from rota.draw.zone_labels import draw_zone_labels
from rota.errors import PlanError
from rota.model.plan import Plan
from rota.model.polygons import polygons_of

MAP_WIDTH, MARGIN, HEADER, AXIS, GAP = 4.6, 0.15, 0.6, 0.4, 0.85  # inches
ARROW = 0.36  # cells
LEAST_ARROW_PT = 5.0  # an arrow drawn shorter than that is a speck
APART = 0.12  # cells, between the arrows of robots that face the same way in one cell


def draw_headings(plan: Plan, ax: Axes) -> None:
    """Arrows from the cells where robots are along the ways they face, on the ground that a body's centre may enter.

    The start of each robot is a circle. Ground within the widest body's radius of a border is grey.
    """
    mission = plan.mission
    draw_mission(mission, ax)
    radius_m = max(robot.body_radius_m for robot in mission.fleet.unlike_robots)
    walls = union_all([obstacle.shape for obstacle in mission.obstacles if obstacle.blocks_motion])
    ground = mission.area.difference(walls)
    rim = ground.difference(ground.buffer(-radius_m))
    outside = polygons_of(rim)
    if not outside.is_empty:
        ax.add_patch(PathPatch(outline(outside), facecolor=OUTSIDE, edgecolor="none", zorder=1.5))
    cell_m, corner = mission.bouncing.cell_m, np.array(mission.grid_corner_m)
    # where cells are small, one state in so many is drawn, so much longer, on the robots' ways
    every = max(1, math.ceil(LEAST_ARROW_PT / (ARROW * cell_m * points_per_metre(ax))))
    apart_m = every * cell_m * min(APART, ARROW / max(len(plan.trajectories) - 1, 1))
    for k, trajectory in enumerate(plan):
        faced = faced_cells(mission, trajectory)
        states = np.column_stack([faced.cells, np.round(faced.headings_rad % math.tau, 9)])
        _, first = np.unique(states, axis=0, return_index=True)
        states = states[np.sort(first)[::every]]
        if every > 1:
            ax.plot(*trajectory.positions_m[:, :2].T, color=route_style(k)[0], linewidth=0.4, alpha=0.6, zorder=3)
        centres = corner + (states[:, :2] + 0.5) * cell_m
        beside_m = apart_m * (k - (len(plan.trajectories) - 1) / 2)
        centres += beside_m * np.column_stack([-np.sin(states[:, 2]), np.cos(states[:, 2])])
        along = every * ARROW * cell_m * np.column_stack([np.cos(states[:, 2]), np.sin(states[:, 2])])
        colour, _ = route_style(k)
        ax.quiver(*centres.T, *along.T, color=colour, angles="xy", scale_units="xy", scale=1, width=0.004, zorder=4)
        ax.plot(*trajectory.positions_m[0, :2], "o", color=colour, markersize=7, fillstyle="none", zorder=5)


def cells_figure(plan: Plan) -> Figure:
    """Both panels side by side; TypeError for a plan of another planner."""
    mission = plan.mission
    x0, y0, x1, y1 = mission.area.bounds
    high = min(MAP_WIDTH * (y1 - y0) / (x1 - x0), 7.5)
    wide = high * (x1 - x0) / (y1 - y0)
    robots = [Line2D([], [], color=route_style(k)[0], marker="o", fillstyle="none", label=plain(t.robot))
              for k, t in enumerate(plan)]  # fmt: skip
    handles = [*robots, *mission_legend(mission)]
    below = AXIS + max(legend_height(handles, wide), BAR + AXIS)
    width, height = 2 * (wide + GAP), HEADER + high + below + MARGIN
    fig = new_figure(width, height)
    x, y = GAP * 0.7, below + MARGIN
    fig.text(x / width, 1 - MARGIN / height, plain(mission.name), fontsize=12, fontweight="bold", va="top")
    left = axes_at(fig, x, y, wide, high)
    draw_headings(plan, left)
    draw_zone_labels(mission, left, routes_of(plan))
    left.set_title("Cells and the ways that robots face there", fontsize=9, loc="left", pad=4)
    place_legend(fig, handles, x, y - AXIS, wide)
    right = axes_at(fig, x + wide + GAP, y, wide, high)
    image = draw_entries(plan, right)
    right.set_title(entries_title(plan), fontsize=9, loc="left", pad=4)
    entries_bar(fig, image, x + wide + GAP, y - AXIS - BAR, wide)
    return fig


def draw_cells(plan: Plan, path: str | Path) -> None:
    """Draw a plan of bouncing robots on its cells to ``path`` as PNG, SVG or PDF, by its suffix.

    The file appears whole or not at all, and the same plan gives the same bytes. Raises RotaError for another suffix, a
    folder that cannot be written to, and PlanError for a plan of another planner.
    """
    rules = plan.mission.planning.bouncing
    if rules is None:
        raise PlanError(f"a plan of {plan.mission.planning.planner} has no cells to draw; one of bounce is needed")
    if rules.cell_m == 0:
        raise PlanError("a plan of robots that bounce without a grid (bounce.cells: none) has no cells to draw")
    write_picture(path, lambda: cells_figure(plan))
