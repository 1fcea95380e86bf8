"""Maps of robots that spread and then hold, where nothing is asked of the ground: their ways, and what they cover."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection, PathCollection
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path
from shapely.geometry.base import BaseGeometry

from rota.cells.importance_cells import importance_in_range
from rota.draw.chargers import charger_entry, draw_chargers, spots_of
from rota.draw.mission_picture import draw_mission, mission_legend, outline, points_per_metre
from rota.draw.palette import COVERED, COVERED_EDGE, GROUND, ink_on
from rota.draw.route_lines import robot_colours
from rota.draw.two_maps import Half
from rota.draw.zone_labels import draw_zone_labels
from rota.model.arrays import Floats
from rota.model.plan import Plan
from rota.model.polygons import polygons_of
from rota.planning.plan_summary import least_range_s, range_at, range_from, round_off
from rota.routes.flights import on_charger, takes_turns

COVERED_ALPHA = 0.3  # so that what two robots cover is darker
NUMBERED_ROBOTS = 60  # with more, numbers would hide the map
LEAST_BODY_PT = 2.2  # a body drawn smaller than that is not seen


def is_deployment(plan: Plan) -> bool:
    """Whether nothing is asked of any ground and all robots stay in the end, or are a swarm's that charges in turns."""
    mission = plan.mission
    asked = mission.period_s is not None or any(zone.period_s is not None for zone in mission.zones)
    charges = plan.mission.planning.makes_runs and takes_turns(plan)
    holds = charges or all(not one.loop_duration_s for one in plan)
    return not asked and len(plan.trajectories) > 0 and holds


def path_of(shape: BaseGeometry) -> Path:
    """A shape as a path; lines and points that an intersection leaves behind are dropped."""
    polygons = polygons_of(shape)
    return Path(np.empty((0, 2))) if polygons.is_empty else outline(polygons)


def ends_m(plan: Plan) -> Floats:
    """(n, 2) metres: where the robots hold in the plane."""
    return np.array([trajectory.positions_m[-1, :2] for trajectory in plan])


def turns_half(plan: Plan) -> Half:
    """The ways of robots that charge in turns, over the round that repeats; few robots carry their numbers."""
    entries: list[Artist] = [
        Line2D([], [], color="#333333", linewidth=0.9, label="way in a round, each robot's in its colour"),
        charger_entry(),
    ]
    return Half(
        title="Ways of a round, robots numbered where it begins",
        draw=lambda ax: draw_turns(plan, ax),
        legend=[*entries, *mission_legend(plan.mission)],
    )


def draw_turns(plan: Plan, ax: Axes) -> None:
    """The mission, the loops and the chargers on ``ax`` in metres, and where robots are as their loops begin."""
    _draw_lines(plan, ax, [trajectory.positions_m[trajectory.loop_index :, :2] for trajectory in plan])
    places_m = ends_m(plan)
    draw_chargers(plan.mission, ax)
    for k, (trajectory, spot_m) in enumerate(zip(plan, spots_of(plan, ax), strict=True)):
        if any(charge.until_s == trajectory.times_s[-1] for charge in trajectory.charges):
            places_m[k] = spot_m
    _draw_numbers(ax, places_m, robot_colours(plan))


def ways_half(plan: Plan) -> Half:
    """Every robot's way from its start to where it holds; few robots carry their numbers."""
    numbered = len(plan.trajectories) <= NUMBERED_ROBOTS
    entries: list[Artist] = [
        Line2D([], [], color="#333333", linewidth=0.9, label="way"),
        Line2D([], [], linestyle="", marker="s", markersize=3.5, color="#333333", markerfacecolor="white"),
        Line2D([], [], linestyle="", marker="o", markersize=5, color="#333333", label="where it holds"),
    ]
    entries[1].set_label("start")
    title = "Ways from the starts" + (", robots numbered where they hold" if numbered else "")
    return Half(title=title, draw=lambda ax: draw_ways(plan, ax), legend=[*entries, *mission_legend(plan.mission)])


def draw_ways(plan: Plan, ax: Axes) -> None:
    """The mission and the ways on ``ax`` in metres."""
    colours, many = robot_colours(plan), len(plan.trajectories) > NUMBERED_ROBOTS
    ways = [trajectory.positions_m[:, :2] for trajectory in plan]
    _draw_lines(plan, ax, ways)
    edge, size = (0.3, 1.0) if many else (0.8, 9.0)
    starts = np.array([way[0] for way in ways])
    ax.scatter(
        starts[:, 0], starts[:, 1], s=size, marker="s", c="white", edgecolors=colours, linewidths=edge, zorder=4.5
    )
    _draw_numbers(ax, ends_m(plan), colours)


def _draw_lines(plan: Plan, ax: Axes, ways_m: list[Floats]) -> None:
    """Draw the mission and a way (n, 2) of each robot."""
    draw_mission(plan.mission, ax)
    draw_zone_labels(plan.mission, ax, [])
    width = 0.35 if len(ways_m) > NUMBERED_ROBOTS else 0.75
    lines = LineCollection(ways_m, colors=robot_colours(plan), linewidths=width, joinstyle="round", zorder=4)
    ax.add_collection(lines, autolim=False)


def _draw_numbers(ax: Axes, places_m: Floats, colours: list[str]) -> None:
    """Draw a mark for each robot at places (n, 2); few carry their numbers."""
    many = len(places_m) > NUMBERED_ROBOTS
    edge, mark = (0.3, 4.0) if many else (0.8, 125.0)
    ax.scatter(places_m[:, 0], places_m[:, 1], s=mark, c=colours, edgecolors="white", linewidths=edge, zorder=7)
    if many:
        return
    style: dict[str, Any] = {"fontsize": 7, "weight": "bold", "ha": "center", "va": "center_baseline", "zorder": 8}
    for k, (x, y) in enumerate(places_m.tolist()):
        ax.text(x, y, str(k + 1), color=ink_on(colours[k]), **style)


def range_half(plan: Plan) -> Half:
    """What some robot has in range where they hold, in sum and disc by disc, and what nobody has.

    Of robots that charge in turns, when they have least in range.
    """
    time_s = least_range_s(plan)
    seen, free, sum_m2 = range_at(plan, time_s)
    share, worth = seen.area / free.area, importance_in_range(plan)
    wasted = 1 - seen.area / sum_m2 if sum_m2 > 0 else 0.0
    entries: list[Artist] = [
        Patch(facecolor=covered_colour(1), edgecolor=COVERED_EDGE, label=f"in range: {share:.1%}"),
        Patch(facecolor=covered_colour(2), edgecolor=COVERED_EDGE, label="in range of two or more"),
        Patch(facecolor=GROUND, edgecolor="#888888", label=f"in nobody's range: {1 - share:.1%}"),
        Line2D([], [], linestyle="", marker="o", markersize=4, color="#222222", label="robot"),
        Line2D([], [], linestyle="", label=f"of all discs {wasted:.1%} overlap or lie outside"),
    ]
    title = f"In range of some robot in the end: {share:.1%} of the ground"
    if worth is not None:
        title = f"In range in the end: {share:.1%} of the ground, {worth:.1%} of its importance"
    if plan.mission.chargers:
        title = f"In range at worst, after {round_off(time_s)} s: {share:.1%} of the ground"
    return Half(
        title=title, draw=lambda ax: draw_range(plan, ax, time_s), legend=[*entries, *mission_legend(plan.mission)]
    )


def covered_colour(times: int) -> tuple[float, float, float]:
    """Ground that so many robots cover, as the discs that lie on each other show it."""
    left = (1 - COVERED_ALPHA) ** times
    ground, cover = to_rgba(GROUND), to_rgba(COVERED)
    red, green, blue = (left * a + (1 - left) * b for a, b in zip(ground[:3], cover[:3], strict=True))
    return red, green, blue


def draw_range(plan: Plan, ax: Axes, time_s: float) -> None:
    """The mission on ``ax`` in metres, and at a time the footprints and bodies of all robots that do not charge."""
    ground = draw_mission(plan.mission, ax)
    there = [trajectory for trajectory in plan if not on_charger(trajectory, np.array([time_s]))[0]]
    robots, last = [plan.mission.fleet.robot(trajectory.robot) for trajectory in there], [t.at(time_s) for t in there]
    places = np.array([place[:2] for place in last]).reshape(-1, 2)
    if plan.mission.chargers:
        draw_chargers(plan.mission, ax, named=False)
    seeing = [(robot, place) for robot, place in zip(robots, last, strict=True) if robot.leaves_s is None]
    paths = [path_of(range_from(robot.sensor, place)) for robot, place in seeing]
    width = 0.3 if len(paths) > NUMBERED_ROBOTS else 0.7
    discs = PathCollection(paths, facecolors=to_rgba(COVERED, COVERED_ALPHA), edgecolors="none", zorder=1.3)
    line = to_rgba(COVERED_EDGE, 0.8)
    edges = PathCollection(paths, facecolors="none", edgecolors=line, linewidths=width, zorder=1.4)
    for collection in (discs, edges):
        ax.add_collection(collection, autolim=False)
        collection.set_clip_path(ground)
    ax.add_collection(bodies(ax, places, [robot.body_radius_m for robot in robots]), autolim=False)
    if len(paths) <= NUMBERED_ROBOTS:
        draw_zone_labels(plan.mission, ax, [])


def bodies(ax: Axes, places_m: Floats, radii_m: list[float]) -> EllipseCollection:
    """Bodies (n,) at places (n, 2) in their size, or as large as is seen."""
    least_m = LEAST_BODY_PT / points_per_metre(ax) / 2
    wide_m = 2 * np.maximum(radii_m, least_m * (0.45 if len(places_m) > NUMBERED_ROBOTS else 1.0))
    return EllipseCollection(
        wide_m, wide_m, np.zeros(len(wide_m)), units="xy", offsets=places_m, offset_transform=ax.transData,
        facecolors="#222222", edgecolors="white", linewidths=0.2, zorder=5,
    )  # fmt: skip
