"""Each zone's name and period, in it, beside it or on a leader, where they hide least of the routes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.text import Text
from shapely import LineString, Point, Polygon, box, maximum_inscribed_circle
from shapely.geometry.base import BaseGeometry

from rota.draw.mission_picture import FONT_PT, asked_everywhere, demand_in_words, plain, points_per_metre
from rota.draw.palette import ZONE_EDGE
from rota.draw.routes import Route
from rota.model.arrays import Floats
from rota.model.mission import Mission, Zone
from rota.model.polygons import polygons_of

# from the middle outwards
STEPS_3, STEPS_4 = (0, -1, 1, -2, 2, -3, 3), (0, 1, -1, 2, -2, 3, -3, 4, -4)
PAD_PT, BESIDE_PT, MARK_RADIUS_PT = 1.7, 2.0, 7.0
AROUND = (0.0, 1.2, 2.4)  # of a label's height, by which spots outside keep off a zone
# what it costs to put all of a label off its zone, on an obstacle, or on what must stay readable: robots' marks, other
# zones and labels, the frame; on a line of its length, on any line; to hide a whole loop, since small loops are soon
# gone; to keep away from its zone by its own height; and to stand nearer to another zone
OFF_ZONE, ON_OBSTACLE, ON_OTHERS, ON_LINE, ON_ANY, ON_LOOP, AWAY, ASTRAY = 0.6, 1.0, 5.0, 0.5, 1.0, 8.0, 0.25, 1.0


def _spots(shape: Polygon, width_m: float, height_m: float, beside_m: float) -> list[Polygon]:
    """Boxes of this size worth trying for a label: all over the shape, its widest place first, then round about it."""
    left, bottom, right, top = shape.bounds
    x_m, y_m = (left + right) / 2, (bottom + top) / 2
    half_m = (right - left) / 2, (top - bottom) / 2
    inside_m = max(half_m[0] - width_m / 2 - beside_m, 0.0), max(half_m[1] - height_m / 2 - beside_m, 0.0)
    widest = maximum_inscribed_circle(shape, tolerance=0.05 * np.sqrt(shape.area)).coords[0]
    centres_m = [(float(widest[0]), float(widest[1]))]
    centres_m += [(x_m + i / 3 * inside_m[0], y_m + j / 4 * inside_m[1]) for j in STEPS_4 for i in STEPS_3]
    for off_m in (beside_m + share * height_m for share in AROUND):
        outside_m = half_m[0] + width_m / 2 + off_m, half_m[1] + height_m / 2 + off_m
        centres_m += [(x_m + i / 3 * half_m[0], y_m + side * outside_m[1]) for side in (1, -1) for i in STEPS_3]
        centres_m += [(x_m + side * outside_m[0], y_m + j / 4 * half_m[1]) for side in (1, -1) for j in STEPS_4]
    return [box(x - width_m / 2, y - height_m / 2, x + width_m / 2, y + height_m / 2) for x, y in centres_m]


def _line_costs(spots: list[Polygon], routes: Sequence[Route]) -> Floats:
    """What each spot (n,) hides of the loops."""
    left, _, right, _ = spots[0].bounds
    costs, on_any = np.zeros(len(spots)), np.zeros(len(spots), np.bool_)
    for route in routes:
        if route.length_m > 0:
            hidden_m = shapely.length(shapely.intersection(np.array(spots), LineString(route.loop_m)))
            costs += hidden_m * (ON_LINE / (right - left) + ON_LOOP / route.length_m)
            on_any |= hidden_m > 0
    return costs + ON_ANY * on_any


def _share(spots: list[Polygon], shape: BaseGeometry) -> Floats:
    """The share (n,) of each spot that lies on a shape."""
    boxes = np.array(spots)
    return np.asarray(shapely.area(shapely.intersection(boxes, shape)) / shapely.area(boxes))


def _away_costs(spots: list[Polygon], shape: Polygon, elsewhere: BaseGeometry, beside_m: float) -> Floats:
    """What it costs each spot (n,) that one may take it for a label of something else."""
    _, bottom, _, top = spots[0].bounds
    away_m = shapely.distance(np.array(spots), shape)
    costs = AWAY * np.maximum(away_m - beside_m, 0) / (top - bottom)
    if not elsewhere.is_empty:
        costs += ASTRAY * (shapely.distance(np.array(spots), elsewhere) < away_m)
    return np.asarray(costs)


def _label(zone: Zone, ax: Axes, *, brief: bool) -> Text:
    told = demand_in_words(zone.period_s, zone.demand)
    if zone.importance is not None:
        worth = f"importance {zone.importance:.3g}"
        told = worth if zone.period_s is None else f"{told}, {worth}"
    text = plain(zone.name, 28) + ("" if brief else f"  {told}")
    label = ax.text(0, 0, text, fontsize=FONT_PT, ha="center", va="center", color="#3A2A08", zorder=6)
    label.set_bbox({"boxstyle": f"round,pad={PAD_PT / FONT_PT}", "fc": "white", "ec": ZONE_EDGE, "lw": 0.5})
    return label


def draw_zone_labels(mission: Mission, ax: Axes, routes: Sequence[Route] = (), *, brief: bool = False) -> None:
    """Each zone's name and period, in or right beside it, clear of each other and of the ``routes`` where they can be.

    ``ax`` has its limits and an equal aspect. Of a zone in several parts the largest is labelled. brief: by its name,
    as it is where many zones ask the same.
    """
    brief = brief or asked_everywhere(mission) is not None
    scale = points_per_metre(ax)
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    frame_box = box(left, bottom, right, top)
    marks = [Point(start_m).buffer(MARK_RADIUS_PT / scale) for route in routes for start_m in route.starts_m]
    marks += [Point(charger.at).buffer(MARK_RADIUS_PT / scale) for charger in mission.chargers]
    obstacles = shapely.union_all([obstacle.shape for obstacle in mission.obstacles])
    parts = [max(_parts(zone, mission), key=lambda part: part.area) for zone in mission.zones]
    taken: list[Polygon] = []
    for k, (zone, shape) in enumerate(zip(mission.zones, parts, strict=True)):
        label = _label(zone, ax, brief=brief)
        window = label.get_window_extent()
        width_m, height_m = (
            (72 * side_px / ax.figure.dpi + 2 * PAD_PT) / scale for side_px in (window.width, window.height)
        )
        spots = _spots(shape, width_m, height_m, BESIDE_PT / scale)
        elsewhere = shapely.union_all([*parts[:k], *parts[k + 1 :]]).difference(shape)
        others = shapely.union_all([elsewhere, *marks, *taken])
        costs = OFF_ZONE * (1 - _share(spots, shape)) + ON_OBSTACLE * _share(spots, obstacles)
        costs += ON_OTHERS * (_share(spots, others) + 4 * (1 - _share(spots, frame_box))) + _line_costs(spots, routes)
        costs += _away_costs(spots, shape, elsewhere, BESIDE_PT / scale)
        taken.append(spots[int(np.argmin(costs))])
        label.set_position((taken[-1].centroid.x, taken[-1].centroid.y))
        leader = shapely.shortest_line(taken[-1].centroid, shape)
        if shapely.distance(taken[-1], shape) > 1.5 * BESIDE_PT / scale:  # hidden by the label as far as that goes
            ax.plot(*shapely.get_coordinates(leader).T, color=ZONE_EDGE, linewidth=0.8, zorder=5.5)


def _parts(zone: Zone, mission: Mission) -> list[Polygon]:
    return list(polygons_of(zone.shape.intersection(mission.area)).geoms)
