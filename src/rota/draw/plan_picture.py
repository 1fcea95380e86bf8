"""A plan as one picture: the routes on the mission, and the worst revisit gap of every place beside them."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import overload

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from rota.draw.charging_chart import charging_chart
from rota.draw.deployment_maps import is_deployment, range_half, turns_half, ways_half
from rota.draw.entered_cells import entries_half
from rota.draw.gap_map import GapMap, draw_gap_map, gap_legend, gap_map
from rota.draw.house_style import house_style
from rota.draw.legends import BAR, scale_bar
from rota.draw.mission_picture import asked_everywhere, draw_mission, mission_legend, period_text
from rota.draw.picture_file import write_picture
from rota.draw.route_lines import draw_route_lines, route_legend
from rota.draw.routes import routes_of
from rota.draw.two_maps import Half, two_maps
from rota.draw.zone_labels import draw_zone_labels
from rota.model.plan import Plan
from rota.planning.plan_summary import cost_in_words
from rota.routes.flights import takes_turns

TURNS_TITLE = "Loops that robots take turns at, lettered where these come to them"
BAR_TEXT = 0.42  # inches


def _header(plan: Plan) -> str:
    """Robots, bound and the period outside zones."""
    count = len(plan.trajectories)
    words = [f"{count} robot{'' if count == 1 else 's'}"]
    if plan.mission.fleet.kinds:
        words.append(cost_in_words(plan))
    elif plan.lower_bound_robots is not None:
        words.append(f"lower bound {plan.lower_bound_robots}")
    mission = plan.mission
    if (rules := mission.planning.bouncing) is not None:
        asked = "cover the area once" if rules.covers else "visit every zone for ever"
        return " · ".join([*words, asked, f"cells of {rules.cell_m:.6g} m" if rules.cell_m else "without a grid"])
    if is_deployment(plan):
        return " · ".join([*words, "nothing asked of the ground"])
    where = "outside zones" if mission.zones else "whole area"
    if (told := asked_everywhere(mission)) is not None:
        words.append(f"{len(mission.zones)} zones, each {told}")
    words.append(f"{where} {'nothing asked' if mission.period_s is None else 'every ' + period_text(mission.period_s)}")
    return " · ".join(words)


def _colour_bar(fig: Figure, image: AxesImage, x: float, y: float, width: float) -> None:
    bar = scale_bar(fig, image, (x, y, width), "worst gap / period", extend="max", extendfrac=0.06)
    bar.set_ticks([0, 0.25, 0.5, 0.75, 1.0], labels=["0", "0.25", "0.5", "0.75", "1.0 = limit"])


def draw_routes(plan: Plan, ax: Axes) -> None:
    """The mission and the plan's loops on ``ax`` in metres, every zone labelled with its period."""
    draw_mission(plan.mission, ax)
    draw_route_lines(plan, ax)
    draw_zone_labels(plan.mission, ax, routes_of(plan))


def draw_gaps(plan: Plan, ax: Axes, gaps: GapMap | None = None) -> AxesImage:
    """The worst revisit gap over the period as a map on ``ax``; returns the image, for a colour bar.

    ``gaps``: the numbers, when they are at hand; otherwise they are computed.
    """
    area = draw_mission(plan.mission, ax, fill=False)
    return draw_gap_map(gap_map(plan) if gaps is None else gaps, ax, area)


def plan_figure(plan: Plan, cells: int = 200_000) -> Figure:
    """The picture as a matplotlib figure: routes on the left (or top), worst gaps over about ``cells`` cells beside.

    Of robots that hold, with nothing asked of the ground, it shows their ways and what they have in range in the end;
    of bouncing ones on cells their ways or loops and how often they enter each cell. Of robots that charge it has a
    chart of their flights and batteries below.
    """
    rules = plan.mission.planning.bouncing
    bounced = rules is not None and rules.cell_m > 0
    if bounced and is_deployment(plan):
        return two_maps(plan.mission, _header(plan), ways_half(plan), entries_half(plan))
    below = charging_chart(plan) if takes_turns(plan) else None
    if is_deployment(plan):
        ways = turns_half(plan) if takes_turns(plan) else ways_half(plan)
        return two_maps(plan.mission, _header(plan), ways, range_half(plan), below)
    routes = Half(
        title=TURNS_TITLE if takes_turns(plan) else "Routes, numbered where each robot's loop starts",
        draw=lambda ax: draw_routes(plan, ax),
        legend=[*route_legend(plan), *mission_legend(plan.mission)],
    )
    if bounced:
        return two_maps(plan.mission, _header(plan), routes, entries_half(plan))
    gaps = gap_map(plan, cells)
    images: list[AxesImage] = []
    unseen = Half(
        title="Longest time unseen, in periods of the place",
        draw=lambda ax: images.append(draw_gaps(plan, ax, gaps)),
        legend=gap_legend(gaps),
        scale_in=BAR + BAR_TEXT,
        scale=lambda fig, x, y, width: _colour_bar(fig, images[0], x, y - BAR, width),
    )
    return two_maps(plan.mission, _header(plan), routes, unseen, below)


@overload
def draw_plan(plan: Plan, path: str | FilePath) -> None: ...
@overload
def draw_plan(plan: Plan, path: None = None, *, ax: Axes) -> Axes: ...
@overload
def draw_plan(plan: Plan) -> Figure: ...
def draw_plan(plan: Plan, path: str | FilePath | None = None, *, ax: Axes | None = None) -> Figure | Axes | None:
    """Draw a plan: to ``path`` as PNG, SVG or PDF by its suffix, its routes on ``ax``, or else as a figure to show.

    A file appears whole or not at all, and the same plan gives the same bytes. The map of gaps beside the routes is
    sampled at cell centres: it illustrates, the check decides; ``draw_gaps`` draws it on axes. Returns what was drawn
    on, nothing for a file. Raises TypeError for both a path and axes, RotaError for another suffix or a folder that
    cannot be written to.
    """
    if ax is not None:
        if path is not None:
            raise TypeError("draw_plan: give a path or ax, not both")
        draw_routes(plan, ax)
        return ax
    if path is None:
        with house_style():
            return plan_figure(plan)
    write_picture(path, lambda: plan_figure(plan))
    return None
