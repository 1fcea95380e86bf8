"""The routes on an axes: one line per loop, arrowheads along it, and a numbered mark where each robot begins."""

from __future__ import annotations

import re

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from rota.draw.chargers import charger_entry, draw_chargers
from rota.draw.mission_picture import plain, points_per_metre
from rota.draw.palette import DOCKED, ink_on, route_style
from rota.draw.routes import Route, arrowheads, routes_of, service_in
from rota.model.arrays import Floats
from rota.model.plan import Plan
from rota.planning.plan_summary import round_off
from rota.routes.flights import has_flights, takes_turns

MARK_PT = 10.5
MARK_FONT_PT = 7.0
ARROW_IN = 0.085
LISTED_ROUTES = 60
APPROACH = (0, (4, 2))  # the dashes of the way from the start
WAY = "#333333"


def _numbers(robots: tuple[int, ...]) -> str:
    """Numbers from 1, runs joined: ``1``, ``1, 4`` or ``1–3``."""
    if len(robots) > 2 and robots[-1] - robots[0] == len(robots) - 1:
        return f"{robots[0] + 1}–{robots[-1] + 1}"
    return ", ".join(str(robot + 1) for robot in robots)


def route_label(plan: Plan, route: Route) -> str:
    """A loop's line in the legend: numbers and names of its robots, its length and time."""
    names = [plan.trajectories[k].robot for k in route.robots]
    # the marks show numbers; names that end with theirs need no second one
    ends = [re.search(r"\d*$", name) for name in names]
    numbered = [int(end[0] or 0) if end else 0 for end in ends] == [robot + 1 for robot in route.robots]
    if route.letter is not None:
        numbers = f"robot{'s' if len(names) > 1 else ''} {_numbers(route.robots)}"
        # with kinds several have the same number in their names
        robots = numbers if numbered and not plan.mission.fleet.kinds else plain(", ".join(names), 40)
        if not route.duration_s:
            return f"{route.letter}: a place, {robots} in turns"
        return f"{route.letter}: {round_off(route.length_m)} m, {round_off(route.duration_s)} s, {robots} in turns"
    shown = names if len(names) <= 2 else [names[0], "…", names[-1]]
    name = plain(", ".join(shown) if len(names) <= 2 else " ".join(shown), 28)
    who = name if numbered else f"{_numbers(route.robots)}  {name}"
    if not route.duration_s:
        return f"{who}: stays"
    return f"{who}: {round_off(route.length_m)} m, {round_off(route.duration_s)} s"


def _line_width_pt(plan: Plan, routes: tuple[Route, ...], scale: float) -> float:
    """Thin enough that lanes beside each other stay apart: a third of their mean spacing."""
    total_m = sum(route.length_m for route in routes)
    spacing_pt = plan.mission.area.area / total_m * scale if total_m > 0 else np.inf
    return float(np.clip(spacing_pt / 3, 0.55, 1.5))


def _draw_heads(ax: Axes, route: Route, colour: str, count: int, clear_m: float) -> None:
    """Draw arrowheads along a loop, clear of its numbered mark."""
    places_m, directions = arrowheads(route.loop_m, count, clear_m)
    if not len(places_m):
        return
    ax.quiver(
        *places_m.T,
        *(directions.T * ARROW_IN),
        units="inches",
        scale_units="inches",
        scale=1,
        pivot="mid",
        width=ARROW_IN / 4,
        headwidth=3.4,
        headlength=4,
        headaxislength=3.4,
        minlength=0,
        color=colour,
        edgecolor="white",
        linewidth=0.35,
        zorder=4.5,
    )


def _draw_approach(ax: Axes, plan: Plan, robot: int, colour: str) -> None:
    trajectory = plan.trajectories[robot]
    if trajectory.loop_index and not has_flights(trajectory):
        way_m = trajectory.positions_m[: trajectory.loop_index + 1, :2]
        ax.plot(*way_m.T, color=colour, linewidth=0.8, linestyle=APPROACH, zorder=3.8)
        ax.plot(*way_m[:1].T, color=colour, marker="s", markersize=3.5, markerfacecolor="white", zorder=3.9)


def _spread(places_m: Floats, scale: float, taken_m: Floats) -> Floats:
    """Offsets (n, 2) in points that keep marks at places (n, 2) from covering each other, and what is taken (k, 2)."""
    rings = [np.zeros((1, 2))]
    for ring in range(1, 7):
        turn = np.arange(6 * ring) * 2 * np.pi / (6 * ring)
        rings.append(ring * MARK_PT * 1.05 * np.column_stack([np.cos(turn), np.sin(turn)]))
    tried = np.concatenate(rings)
    marks: list[Floats] = list(taken_m * scale)
    for place_pt in places_m * scale:
        free = [o for o in tried if all(np.hypot(*(place_pt + o - mark)) >= MARK_PT for mark in marks)]
        marks.append(place_pt + (free[0] if free else 0.0))
    return np.array(marks[len(taken_m) :]).reshape(-1, 2) - places_m * scale


def _marks_of(plan: Plan, routes: tuple[Route, ...]) -> list[tuple[str, Floats, str]]:
    """The text, the place (2,) in metres and the colour of each mark: where loops start or robots take turns."""
    colours = robot_colours(plan)
    marks = [
        (str(k + 1), trajectory.positions_m[trajectory.loop_index, :2], colours[k])
        for k, trajectory in enumerate(plan)
        if not has_flights(trajectory)
    ]
    for k, route in enumerate(routes):
        if route.letter is not None:
            marks += [(route.letter, place_m, route_style(k)[0]) for place_m in route.starts_m]
    return marks


def _draw_marks(ax: Axes, marks: list[tuple[str, Floats, str]], taken_m: Floats) -> None:
    """Draw a mark where each loop starts; marks in one place are spread, and keep off places (k, 2) that are taken."""
    places_m = np.array([place_m for _, place_m, _ in marks]).reshape(-1, 2)
    for (text, place_m, colour), offset_pt in zip(marks, _spread(places_m, points_per_metre(ax), taken_m), strict=True):
        circle = {
            "boxstyle": f"circle,pad={0.18 if len(text) == 1 else 0.08}",
            "facecolor": colour,
            "edgecolor": "white",
        }
        ax.annotate(
            text,
            (float(place_m[0]), float(place_m[1])),
            xytext=tuple(offset_pt),
            textcoords="offset points",
            fontsize=MARK_FONT_PT,
            fontweight="bold",
            ha="center",
            va="center",
            color=ink_on(colour),
            bbox=circle | {"linewidth": 0.8},
            arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.8} if offset_pt.any() else None,
            zorder=7,
        )


def robot_colours(plan: Plan) -> list[str]:
    """The colour of each robot, in the order of the plan: that of its route, or of the first that it takes turns at."""
    colours = [""] * len(plan.trajectories)
    for k, route in enumerate(routes_of(plan)):
        for robot in route.robots:
            colours[robot] = colours[robot] or route_style(k)[0]
    return [colour or DOCKED for colour in colours]


def draw_route_lines(plan: Plan, ax: Axes) -> None:
    """Every loop of ``plan`` as a labelled line with arrowheads; a numbered mark where each robot's loop starts.

    Robots on the same loop share its line. The way to the loop is dashed, from a small square. Loops that robots take
    turns at have letters where these come to them, and the ways from chargers are dashed. ``ax`` has its limits
    and an equal aspect.
    """
    scale = points_per_metre(ax)
    routes = routes_of(plan)
    width_pt = _line_width_pt(plan, routes, scale)
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    spacing_m = 0.16 * float(np.hypot(right - left, top - bottom)) * (1 + len(routes) / 24)
    for k, route in enumerate(routes):
        colour, style = route_style(k)
        line = Line2D(*route.loop_m.T, color=colour, linestyle=style, linewidth=width_pt, zorder=4)
        line.set_label(route_label(plan, route))
        line.set_solid_joinstyle("round")
        # a pale edge shows which of two crossing lines goes on
        line.set_path_effects([withStroke(linewidth=width_pt + 0.9, foreground="white", alpha=0.7)])
        ax.add_line(line)
        _draw_heads(ax, route, colour, int(np.clip(route.length_m / spacing_m, 3, 30)), 72 * ARROW_IN / scale)
        for robot in route.robots:
            _draw_approach(ax, plan, robot, colour)
    # their names stand on either side, and marks keep off these, too
    beside_m = np.arange(-4, 5) * MARK_PT / scale
    chargers_m = np.array([(x + off_m, y) for x, y in (c.at for c in plan.mission.chargers) for off_m in beside_m])
    marks = _marks_of(plan, routes)
    if takes_turns(plan):
        for way_m in service_in(plan).ways_m:
            ax.plot(*way_m.T, color=WAY, linewidth=0.8, linestyle=APPROACH, zorder=3.8)
        draw_chargers(plan.mission, ax, marks_m=np.array([place_m for _, place_m, _ in marks]).reshape(-1, 2))
    _draw_marks(ax, marks, chargers_m.reshape(-1, 2))


def brief_label(route: Route) -> str:
    """A loop's line in a narrow legend: numbers of its robots as on their marks, whole metres, and seconds."""
    return f"{route.letter or _numbers(route.robots)}: " + (
        f"{route.length_m:,.0f} m, {round_off(route.duration_s)} s" if route.duration_s else "stays"
    )


def route_legend(plan: Plan, *, brief: bool = False) -> list[Line2D]:
    """Legend entries, one per loop: its line with a mark, robots, length and time; then what is left out, and ways.

    brief: robots by their numbers alone.
    """
    routes = routes_of(plan)
    entries = []
    for k, route in enumerate(routes[:LISTED_ROUTES]):
        colour, style = route_style(k)
        line = Line2D([], [], color=colour, linestyle=style, linewidth=1.5, marker="o", markersize=5)
        line.set_markeredgecolor("white")
        line.set_label(brief_label(route) if brief else route_label(plan, route))
        entries.append(line)
    if len(routes) > LISTED_ROUTES:
        entries.append(Line2D([], [], linestyle="none", label=f"… and {len(routes) - LISTED_ROUTES} more loops"))
    if any(trajectory.loop_index and not has_flights(trajectory) for trajectory in plan):
        way = Line2D([], [], color=WAY, linewidth=0.8, linestyle=APPROACH, label="way from the start")
        entries.append(way)
    if takes_turns(plan):
        entries.append(
            Line2D([], [], color=WAY, linewidth=0.8, linestyle=APPROACH, label="way from a charger and back")
        )
        entries.append(charger_entry())
    return entries
