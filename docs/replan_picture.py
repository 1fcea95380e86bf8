"""Draw a plan that takes over: ``python -m docs.replan_picture`` writes docs/replan.png and prints what the check says.

A robot of examples/harbour.yaml is lost, and a new one comes in from elsewhere. On the left all ways of the first
seconds after that, on the right how late each place is at most since.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import shapely
from matplotlib.figure import Figure

from rota import Plan, make_plan, read_mission, replan
from rota.check.demands import demands_of
from rota.check.late_samples import sights_across
from rota.check.revisits import late_points
from rota.draw.house_style import house_style
from rota.draw.mission_picture import draw_mission
from rota.draw.palette import route_style

MISSION = Path(__file__).parents[1] / "examples" / "harbour.yaml"
PICTURE = Path(__file__).with_name("replan.png")
AT_S, LOST, NEW, PLACE = 437.0, "robot-4", "robot-6", (-150.0, -60.0)
FIRST_S, SPACING_M = 40.0, 2.5


def draw(before: Plan, after: Plan) -> Figure:
    """The ways of the first seconds, and how late places are."""
    figure = Figure(figsize=(10.5, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    draw_mission(after.mission, left)
    left.plot(*before[LOST].at(AT_S)[:2], "x", color="black", markersize=9, markeredgewidth=2, zorder=6)
    left.annotate(f"{LOST} lost", before[LOST].at(AT_S)[:2], xytext=(6, 6), textcoords="offset points", zorder=6)
    for k, line in enumerate(after):
        colour, _ = route_style(k)
        loop = line.positions_m[line.loop_index :]
        left.plot(*loop.T[:2], color=colour, linewidth=0.6, alpha=0.5, zorder=3)
        left.plot(*line.at(np.linspace(0, FIRST_S, 400)).T[:2], color=colour, linewidth=2.4, zorder=4)
        left.plot(*line.positions_m[0, :2], "o", color=colour, markersize=7, zorder=5)
        left.annotate(line.robot, line.positions_m[0, :2], xytext=(6, -10), textcoords="offset points", zorder=6)
    left.set_title(f"the first {FIRST_S:g} s after the change")
    draw_mission(after.mission, right, fill=False)
    places_m, late_s = late_places(after)
    shown = right.scatter(*places_m.T, c=late_s, s=5, marker="s", cmap="magma_r", vmin=0, zorder=1.2, linewidths=0)
    figure.colorbar(shown, ax=right, label="late at most, s", shrink=0.8)
    right.set_title("how late each place is since")
    return figure


def late_places(plan: Plan) -> tuple[np.ndarray, np.ndarray]:
    """Places (n, 2) of a lattice, and by how much each is late at most since the plan took over."""
    assert plan.seam is not None
    sights = sights_across(plan, plan.seam)
    assert sights is not None
    x0, y0, x1, y1 = plan.mission.area.bounds
    lattice = np.stack(np.meshgrid(np.arange(x0, x1, SPACING_M), np.arange(y0, y1, SPACING_M)), axis=-1).reshape(-1, 2)
    every_place, every_late = [], []
    for demand in demands_of(plan.mission):
        own = lattice[shapely.contains_xy(demand.region, *lattice.T)]
        gaps_s = late_points(sights, own, demand.period_s)[0]
        every_place.append(own)
        every_late.append(np.maximum(0.0, gaps_s - demand.period_s))
    return np.vstack(every_place), np.concatenate(every_late)


if __name__ == "__main__":
    plan = make_plan(read_mission(MISSION).mission.with_effort("quick"), seed=0)
    found = replan(plan, at_s=AT_S, lost=[LOST], joined={NEW: PLACE}, time_limit_s=30)
    with house_style():
        draw(plan, found.plan).savefig(PICTURE, dpi=110)
    assert found.report.lateness is not None
    print("\n".join(found.report.lateness.lines()))
