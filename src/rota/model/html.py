"""Missions and plans as notebooks show them: a small map as SVG, and a table."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

import numpy as np
from shapely import MultiPolygon, get_parts

from rota.model.arrays import Floats

# Missions and plans show themselves by these functions, which therefore do not import their types.
WIDTH, HEIGHT = 480, 360  # pixels, at most
MARGIN = 0.02  # of the longer side
# Okabe-Ito without yellow, which vanishes on white
COLOURS = ("#0072B2", "#E69F00", "#882255", "#009E73", "#000000", "#56B4E9", "#D55E00", "#CC79A7")
GROUND = 'fill="#FDFDFB" stroke="#333333"'
ZONE = 'fill="#F4E5BF" stroke="#6B4E16"'
BLOCKS = {
    "both": 'fill="#4A4A4A"',
    "motion": 'fill="#B3261E" fill-opacity="0.35" stroke="#B3261E"',
    "sight": 'fill="#2E7D32" fill-opacity="0.35" stroke="#2E7D32"',
}


def mission_html(mission: Any) -> str:
    """A mission's map, and a line for each zone with its period."""
    rows = [(zone.name, _period(zone.period_s), zone.demand.replace("_", " ")) for zone in mission.zones]
    if not mission.planning.makes_runs:
        rows.append(("ground outside zones" if mission.zones else "area", _period(mission.period_s), "every point"))
    return _beside(mission_map(mission), escape(repr(mission)[1:-1]), ("zone", "seen every", "asks"), rows)


def plan_html(plan: Any) -> str:
    """A plan's map, and a line for each robot with its loop."""
    rows = [
        (
            f'<span style="color:{_colour(k)}">&#9632;</span> {escape(each.robot)}',
            *((f"{each.loop_length_m:.1f}", f"{each.loop_duration_s:.1f}") if each.loop_duration_s else ("stays", "")),
        )
        for k, each in enumerate(plan)
    ]
    loops = [each.positions_m[:, :2] for each in plan]
    return _beside(mission_map(plan.mission, loops), escape(repr(plan)[1:-1]), ("robot", "loop m", "loop s"), rows)


def mission_map(mission: Any, ways_m: Sequence[Floats] = ()) -> str:
    """The mission as SVG, with these ways, each (n, 2) metres, in their colours; y goes up."""
    west, south, east, north = mission.area.bounds
    margin_m = MARGIN * max(east - west, north - south)
    width_m, height_m = east - west + 2 * margin_m, north - south + 2 * margin_m
    pixels_per_m = min(WIDTH / width_m, HEIGHT / height_m)

    def path(rings_m: Iterable[Floats], closed: bool, style: str) -> str:
        lines = []
        for ring_m in rings_m:
            at = (np.asarray(ring_m)[:, :2] - (west - margin_m, north + margin_m)) * (pixels_per_m, -pixels_per_m)
            lines.append("M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in at) + ("Z" if closed else ""))
        return f'<path d="{"".join(lines)}" fill-rule="evenodd" {style}/>'

    shapes = [path(_rings(mission.area), True, GROUND)]
    shapes += [path(_rings(zone.shape), True, ZONE) for zone in mission.zones]
    shapes += [path(_rings(obstacle.shape), True, BLOCKS[obstacle.blocks]) for obstacle in mission.obstacles]
    for k, way_m in enumerate(ways_m):
        shapes.append(path([way_m], False, f'fill="none" stroke="{_colour(k)}" stroke-width="1.5"'))
        shapes.append(path([way_m[-1:]] * 2, False, f'stroke="{_colour(k)}" stroke-width="6" stroke-linecap="round"'))
    size = f'style="flex:none" width="{width_m * pixels_per_m:.0f}" height="{height_m * pixels_per_m:.0f}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{"".join(shapes)}</svg>'


def _rings(shape: MultiPolygon) -> list[Floats]:
    """Outlines and holes, each (n, 2)."""
    return [np.array(ring.coords) for part in get_parts(shape) for ring in (part.exterior, *part.interiors)]


def _colour(index: int) -> str:
    return COLOURS[index % len(COLOURS)]


def _period(period_s: float | None) -> str:
    return "nothing asked" if period_s is None else f"{period_s:.6g} s"


def _beside(picture: str, title: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """The picture and, to its right, a table with a title; cells are HTML already."""
    lines = ["<tr>" + "".join(f"<th>{cell}</th>" for cell in head) + "</tr>"]
    lines += ["<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows]
    table = f"<table><caption>{title}</caption>{''.join(lines)}</table>"
    return f'<div style="display:flex;gap:1em;align-items:flex-start">{picture}<div>{table}</div></div>'
