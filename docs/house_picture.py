"""Draw which package imports which, from the source: ``python -m docs.house_picture`` writes docs/house.svg.

An arrow stands for an import. Arrows that follow from others are left out: where A imports B and B imports C, a direct
import of C by A is not drawn.
"""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Mapping
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from tests.test_house import MODULES as ALL_MODULES, PATROL, imported_modules

PICTURE = Path(__file__).with_name("house.svg")
MODULES = {module: file for module, file in ALL_MODULES.items() if module.startswith("rota.")}
BOX_W, GAP_X, LANE_W, GAP_Y, LINE_H, PAD = 200, 22, 14, 46, 15, 9
SWEEPS = 40
HEAD = ' marker-end="url(#head)"'
STYLE = """\
<style>
text { font: 11px sans-serif; fill: #333 } .name { font-weight: bold; fill: #000 } .title { font: bold 15px sans-serif }
rect { fill: #eef3f8; stroke: #5b7fa3 } .paper { fill: #fff; stroke: none }
path { fill: none; stroke: #888; stroke-width: 1.2 } #head path { fill: #888; stroke: none }
</style>
<defs><marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">
<path d="M 0 0 L 8 4 L 0 8 z"/></marker></defs>"""

Arrows = dict[str, set[str]]


class Point(NamedTuple):
    """A box (``name`` set), or the place where a long ``arrow`` passes a row of the given height."""

    name: str | None
    arrow: tuple[str, str] | None = None
    height: int = 0


# ---------------------------------------------------------------- what is imported


def house_arrows() -> Arrows:
    """Which top package, or module beside them, imports which; planners count for themselves."""
    return _arrows({module: _house_room(module) for module in MODULES if module != "rota.__main__"})


def patrol_arrows() -> Arrows:
    """Which folder or module of patrol imports which."""
    inside = [module for module in MODULES if module.startswith(PATROL + ".")]
    return _arrows({module: module[len(PATROL) + 1 :].split(".")[0] for module in inside})


def _house_room(module: str) -> str:
    parts = module.split(".")
    return ".".join(parts[1:3]) if parts[1] == "planners" and len(parts) > 2 else parts[1]


def _arrows(room_of: Mapping[str, str]) -> Arrows:
    arrows: Arrows = {room: set() for room in room_of.values()}
    for module, room in room_of.items():
        arrows[room] |= {room_of[name] for name in imported_modules(module) if name in room_of} - {room}
    imported = set().union(*arrows.values())
    return {room: others for room, others in arrows.items() if others or room in imported}


def reached(arrows: Arrows, room: str) -> set[str]:
    """All that a room imports, directly or not."""
    seen: set[str] = set()
    todo = list(arrows[room])
    while todo:
        other = todo.pop()
        if other not in seen:
            seen.add(other)
            todo.extend(arrows[other])
    return seen


def reduced(arrows: Arrows) -> Arrows:
    """The arrows that do not follow from others."""
    return {
        room: {other for other in others if not any(other in reached(arrows, via) for via in others - {other})}
        for room, others in arrows.items()
    }


# ---------------------------------------------------------------- where it stands


def rows_of(arrows: Arrows) -> list[list[Point]]:
    """Boxes in rows, all arrows downwards; an arrow that passes rows has a point in each. The top row comes first."""
    height: dict[str, int] = {}

    def rise(room: str) -> int:
        if room not in height:
            height[room] = 1 + max((rise(other) for other in arrows[room]), default=-1)
        return height[room]

    rows: list[list[Point]] = [[] for _ in range(1 + max(rise(room) for room in sorted(arrows)))]
    for room in sorted(arrows):
        rows[height[room]].append(Point(room))
        for other in sorted(arrows[room]):
            for between in range(height[other] + 1, height[room]):
                rows[between].append(Point(None, (room, other), between))
    return rows[::-1]


def neighbours_of(rows: list[list[Point]], arrows: Arrows) -> dict[Point, list[Point]]:
    """The points in the rows above and below that a point is joined with."""
    joined: dict[Point, list[Point]] = {point: [] for row in rows for point in row}
    for room, others in arrows.items():
        for other in sorted(others):
            chain = [p for row in rows for p in row if p.name in (room, other) or p.arrow == (room, other)]
            for above, below in pairwise(chain):
                joined[above].append(below)
                joined[below].append(above)
    return joined


def placed(rows: list[list[Point]], joined: Mapping[Point, list[Point]]) -> dict[Point, float]:
    """The middle of each point across: rows ordered by their neighbours' middles, then spread so that none overlap."""
    at = {point: float(k) for row in rows for k, point in enumerate(row)}
    best, fewest = [list(row) for row in rows], None
    for sweep in range(SWEEPS):
        for k in range(len(rows)) if sweep % 2 else reversed(range(len(rows))):
            side = set(rows[k - 1] if sweep % 2 and k else rows[k + 1] if not sweep % 2 and k + 1 < len(rows) else [])
            middle = {p: [at[q] for q in joined[p] if q in side] for p in rows[k]}
            rows[k].sort(key=lambda p: sum(middle[p]) / len(middle[p]) if middle[p] else at[p])
            at.update({point: float(place) for place, point in enumerate(rows[k])})
        crossed = crossings(rows, joined)
        if fewest is None or crossed < fewest:
            best, fewest = [list(row) for row in rows], crossed
    rows[:] = best
    x = {point: k * (BOX_W + GAP_X) * 1.0 for row in rows for k, point in enumerate(row)}
    for _ in range(SWEEPS):
        for row in rows:
            wanted = {p: (sum(x[q] for q in joined[p]) / len(joined[p]) + x[p]) / 2 if joined[p] else x[p] for p in row}
            x.update(_spread(row, wanted))
    left = min(x[point] - _width(point) / 2 for point in x)
    return {point: middle - left for point, middle in x.items()}


def crossings(rows: list[list[Point]], joined: Mapping[Point, list[Point]]) -> int:
    """How many pairs of lines between neighbouring rows cross."""
    total = 0
    for upper, lower in pairwise(rows):
        place = {point: k for k, point in enumerate(lower)}
        lines = [(k, place[q]) for k, point in enumerate(upper) for q in joined[point] if q in place]
        total += sum(a < c and b > d for a, b in lines for c, d in lines)
    return total


def _width(point: Point) -> float:
    return BOX_W if point.name else LANE_W


def _spread(row: list[Point], wanted: Mapping[Point, float]) -> dict[Point, float]:
    """Middles near those wanted, in the row's order and apart: the mean of pushing rightwards and leftwards."""
    right, left = dict(wanted), dict(wanted)
    for a, b in pairwise(row):
        right[b] = max(right[b], right[a] + (_width(a) + _width(b)) / 2 + GAP_X)
    for b, a in pairwise(reversed(row)):
        left[a] = min(left[a], left[b] - (_width(a) + _width(b)) / 2 - GAP_X)
    return {point: (right[point] + left[point]) / 2 for point in row}


# ---------------------------------------------------------------- how it looks


def said_of(module: str) -> list[str]:
    """What a module's docstring says of it first, in lines that fit into a box."""
    text = (ast.get_docstring(ast.parse(MODULES[module].read_text())) or "").split("\n")[0]
    return textwrap.wrap(re.split(r"[;:.]| \(", text)[0], 29)


class Layout(NamedTuple):
    """Where points stand: neighbours, middle across, top and bottom edge of each."""

    joined: Mapping[Point, list[Point]]
    x: Mapping[Point, float]
    top: Mapping[Point, float]
    bottom: Mapping[Point, float]

    def port(self, point: Point, other: Point) -> float:
        """Where across a box the line to another point begins or ends: lines share the edge evenly."""
        upwards = self.top[other] < self.top[point]
        same_side = sorted(
            (q for q in self.joined[point] if (self.top[q] < self.top[point]) == upwards), key=lambda q: self.x[q]
        )
        share = (same_side.index(other) + 1) / (len(same_side) + 1)
        return self.x[point] + (share - 0.5) * (BOX_W if point.name else 0)


class Panel(NamedTuple):
    """A drawing of one level of the house: its lines of SVG, and its size."""

    lines: list[str]
    width: float
    height: float


def panel(title: str, arrows: Arrows, texts: Mapping[str, list[str]]) -> Panel:
    """Boxes with their texts, and arrows between them; every row is as high as its highest box."""
    arrows = reduced(arrows)
    rows = rows_of(arrows)
    joined = neighbours_of(rows, arrows)
    x = placed(rows, joined)
    top: dict[Point, float] = {}
    bottom: dict[Point, float] = {}
    y = 34.0
    for row in rows:
        tall = max((_height(texts[point.name]) for point in row if point.name), default=LINE_H)
        for point in row:
            top[point], bottom[point] = y, y + (_height(texts[point.name]) if point.name else tall)
        y += tall + GAP_Y
    layout = Layout(joined, x, top, bottom)
    lines = [f'<text x="0" y="16" class="title">{escape(title)}</text>']
    lines += [line for row in rows for point in row for line in _wires(point, layout)]
    lines += [line for point in x if point.name for line in _box(point.name, texts[point.name], x[point], top[point])]
    return Panel(lines, max(x[point] + _width(point) / 2 for point in x), y - GAP_Y)


def _height(text: list[str]) -> float:
    return 2 * PAD + LINE_H * (1 + len(text))


def _box(name: str, text: list[str], middle: float, top: float) -> list[str]:
    left = middle - BOX_W / 2
    lines = [f'<rect x="{left:.0f}" y="{top:.0f}" width="{BOX_W}" height="{_height(text):.0f}" rx="5"/>']
    lines.append(f'<text x="{left + PAD:.0f}" y="{top + PAD + 12:.0f}" class="name">{escape(name)}</text>')
    for k, line in enumerate(text):
        lines.append(f'<text x="{left + PAD:.0f}" y="{top + PAD + 12 + LINE_H * (k + 1):.0f}">{escape(line)}</text>')
    return lines


def _wires(point: Point, layout: Layout) -> list[str]:
    """The lines from a point to those below it, and its own way through its row where it is no box."""
    lines = []
    y0 = layout.bottom[point]
    if point.name is None:
        lines.append(f'<path d="M {layout.x[point]:.0f} {layout.top[point]:.0f} V {y0:.0f}"/>')
    for other in layout.joined[point]:
        y1 = layout.top[other]
        if y1 > y0:
            x0, x1, bend = layout.port(point, other), layout.port(other, point), (y1 - y0) / 2
            curve = f"M {x0:.0f} {y0:.0f} C {x0:.0f} {y0 + bend:.0f} {x1:.0f} {y1 - bend:.0f} {x1:.0f} {y1:.0f}"
            lines.append(f'<path d="{curve}"{HEAD if other.name else ""}/>')
    return lines


def picture() -> str:
    """The SVG: the house above, patrol's rooms below."""
    arrows = house_arrows()
    house = panel("rota", arrows, {room: said_of(f"rota.{room}") for room in arrows})
    rooms = patrol_arrows()
    patrol = panel("rota.planners.patrol", rooms, {room: said_of(f"{PATROL}.{room}") for room in rooms})
    width, height = max(house.width, patrol.width) + 40, house.height + patrol.height + 100
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}">',
            STYLE,
            f'<rect width="{width:.0f}" height="{height:.0f}" class="paper"/>',
            '<g transform="translate(20 16)">',
            *house.lines,
            "</g>",
            f'<g transform="translate(20 {house.height + 76:.0f})">',
            *patrol.lines,
            "</g>",
            "</svg>",
            "",
        ]
    )


def main() -> None:
    """Write the picture."""
    PICTURE.write_text(picture())


if __name__ == "__main__":
    main()
