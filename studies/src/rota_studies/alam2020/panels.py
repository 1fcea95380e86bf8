"""What the runs came to, as panels of maps and heat maps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rota.draw.palette import route_style
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.bounce.cells import Cells
from rota.planners.bounce.planner_settings import BounceSettings
from rota_studies.panels.cells_panel import HeadingsPanel, HeatPanel
from rota_studies.panels.map_panel import Dots, MapPanel, Strokes

Floats = NDArray[np.float64]

HEADING = 0.42  # cells: half the length of the stroke that tells a robot's heading
START_PT = 5.0


def headings_panel(title: str, plan: Plan, note: str = "") -> HeadingsPanel:
    """The cells of a plan's robots and the ways they face there."""
    return HeadingsPanel(title=title, note=note, mission=plan.mission, plan=plan)


def ways_panel(title: str, plan: Plan, note: str = "", *, named_zones: bool = False) -> MapPanel:
    """The ways of a plan's robots, a little beside each other, and their starts."""
    apart_m = 0.06 * BounceSettings.of(plan.mission).cell_m
    shifts = (np.arange(len(plan.trajectories)) - (len(plan.trajectories) - 1) / 2) * apart_m
    strokes, dots = [], []
    for k, trajectory in enumerate(plan):
        colour, _ = route_style(k)
        places = trajectory.positions_m[:, :2] + shifts[k]
        strokes.append(Strokes(trajectory.robot, (places,), colour, width_pt=0.9))
        dots.append(Dots(f"start of {trajectory.robot}", places[:1], colour, size_pt=START_PT))
    return MapPanel(
        title=title, note=note, mission=plan.mission, strokes=tuple(strokes), dots=tuple(dots), named_zones=named_zones,
        brief_zones=True,
    )  # fmt: skip


def starts_panel(title: str, plan: Plan, note: str = "") -> MapPanel:
    """Where the robots of a plan begin and how they face."""
    places = np.array([trajectory.positions_m[0, :2] for trajectory in plan])
    facing = np.array([0.0 if trajectory.headings_rad is None else trajectory.headings_rad[0] for trajectory in plan])
    ahead = HEADING * BounceSettings.of(plan.mission).cell_m * np.column_stack([np.cos(facing), np.sin(facing)])
    strokes = Strokes("heading", tuple(np.array([a, a + way]) for a, way in zip(places, ahead, strict=True)), "#222222")
    dots = Dots("start", places, route_style(0)[0], size_pt=START_PT)
    return MapPanel(title=title, note=note, mission=plan.mission, strokes=(strokes,), dots=(dots,))


def entries_panel(title: str, mission: Mission, entries: NDArray[np.int64], note: str = "") -> HeatPanel:
    """How often each cell, (rows, columns), is entered."""
    values = np.where(entries > 0, entries, np.nan)
    return HeatPanel(
        title=title, note=note, mission=mission, values=values, cell_m=BounceSettings.of(mission).cell_m,
        top=float(np.nanmax(values)), numbered=True,
    )  # fmt: skip


def chances_panel(title: str, mission: Mission, cells: Cells, chances: Floats, note: str = "") -> HeatPanel:
    """A chance (n,) of each of the cells, in percent."""
    values = np.full((int(cells.row.max()) + 1, int(cells.column.max()) + 1), np.nan)
    values[cells.row, cells.column] = 100 * chances
    return HeatPanel(
        title=title, note=note, mission=mission, values=values, cell_m=cells.cell_m, top=100.0, numbered=True
    )
