"""Extra figure 13: the same bouncing without a grid, in polygons with straight lines and exact contacts."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
from numpy.typing import NDArray

from rota.draw.palette import ROUTE_COLOURS
from rota.draw.panels.map_panel import MapPanel, Strokes
from rota.draw.panels.study_picture import study_picture
from rota.geometry.free_space import free_ground
from rota.mission import Mission
from rota.papers.alam2020 import maps, paper
from rota.papers.alam2020.grid_beside_plane import GridBesidePlane, compare_grid_and_plane
from rota.papers.alam2020.runs import Runs
from rota.papers.section import Picture, Section
from rota.papers.tables import NOTHING, Table
from rota.planners.bounce.bounce_map import cycles_and_basins, make_team, single_map
from rota.planners.bounce.cells import Cells, make_cells
from rota.planners.bounce.polygon import BounceRule, bounce_path, make_rim

Longs = NDArray[np.int64]

SHOWN_ANGLE_DEG = 135.0
GRID_COLOUR, PLANE_COLOUR = ROUTE_COLOURS[0], ROUTE_COLOURS[6]
BOUNCES = 2000


def figure_13_section(runs: Runs) -> Section:
    """The limit cycles of the plane beside those of the grid."""
    rows, compared, panels = [], {}, []
    for name, mission in maps.wide_rooms(SHOWN_ANGLE_DEG).items():
        cells, ground = make_cells(mission), free_ground(mission)
        for angle in paper.ANGLES_DEG:
            runs.now(f"figure 13: {name}, {angle:g}°")
            turn = round(angle * cells.headings / 360)
            radius_m = maps.ROOM_CELL_M / 2
            both = compare_grid_and_plane(cells, ground, turn=turn, body_radius_m=radius_m, bounces=BOUNCES)
            compared[name, angle] = both
            rows.append((name, f"{angle:g}°", *_row(both)))
            if angle == SHOWN_ANGLE_DEG:
                panels += _pair(name, mission, cells, turn, both)
    table = Table(
        title="One robot from every cell with every heading: limit cycles on the grid and in the plane",
        head=(
            "room", "angle", "cycles on the grid", "in the plane", "attracting / half-stable / neutral / repelling",
            "starts that come to none", "starts with a cycle as long in both", "length, plane by grid",
        ),
        rows=tuple(rows),
        words=(0, 1),
    )  # fmt: skip
    least = {name: min(compared[name, angle].same_share for angle in paper.ANGLES_DEG) for name, _ in compared}
    exact = [name for name, share in least.items() if share == 1]
    others = [f"{share:.0%} of the starts ({name})" for name, share in least.items() if share < 1]
    return Section(
        figure=13,
        extra=True,
        heading="the plane beside the grid",
        pictures=(
            Picture(
                "alam2020-figure-13.png",
                "The limit cycle that most starts come to, on the grid and in the plane, in three rooms",
                study_picture(panels),
            ),
        ),
        caption=f"By {SHOWN_ANGLE_DEG:g}°, rooms of 10 m by 10 m, a disc as wide as a cell of 1 m. Left: of the grid's "
        "limit cycles the one that most starts come to; right: where the same start ends in the plane. Lines are the "
        "ways of the disc's centre. The plane counts a neutral family as one cycle.",
        paper="The paper bounces on a grid; its references [13,14] have closed forms for single robots in polygons.",
        ours=("Every start comes to a cycle as long in both: " + " and ".join(exact) + ". " if exact else "")
        + ("Elsewhere not: by the worst angle only " + ", ".join(others) + " come to a cycle as long as on the "
           "grid, since a disc goes on until it touches a corner or a slanted wall, where the grid turns at a cell's "
           "centre. " if others else "")
        + "Attracting cycles take in all small displacements; in neutral families each stays as it is; half-stable "
        "cycles go through corners, where displacements to one side fade and those to the other do not. That was "
        "tried with displaced runs; the return map's derivative holds for one side of a corner only.",
        tables=(table,),
    )  # fmt: skip


def _row(both: GridBesidePlane) -> tuple[str, ...]:
    """The row of one ground and angle: cycles on the grid, and in the plane by their stability."""
    kinds = Counter(cycle.stability for cycle in both.plane.cycles)
    ratio = f"{np.median(both.length_ratios):.3f}" if len(both.length_ratios) else NOTHING
    return (
        f"{len(both.lengths_m):,}", f"{len(both.plane.cycles):,}",
        f"{kinds['attracting']} / {kinds['half-stable']} / {kinds['neutral']} / {kinds['repelling']}",
        f"{both.plane.unsettled_share + both.plane.stuck_share:.1%}", f"{both.same_share:.1%}", ratio,
    )  # fmt: skip


def _pair(name: str, mission: Mission, cells: Cells, turn: int, both: GridBesidePlane) -> list[MapPanel]:
    """The most frequent cycle on the grid, and what comes of the same start in the plane."""
    most = int(both.shares.argmax())
    states = _grid_round(cells, turn, most)
    on_grid = MapPanel(
        title=f"{name.capitalize()}: grid",
        note=f"{both.shares[most]:.0%} of starts, {both.bumps[most]} bumps, {both.lengths_m[most]:.1f} m",
        mission=mission,
        strokes=(Strokes("grid", (cells.centres_m[states // cells.headings],), GRID_COLOUR, width_pt=1.3),),
    )
    cell, heading = divmod(int(states[0]), cells.headings)
    rim = make_rim(free_ground(mission), maps.ROOM_CELL_M / 2)
    rule = BounceRule(angle_rad=turn * math.tau / cells.headings)
    x, y = cells.centres_m[cell]
    path = bounce_path(rim, rule, (float(x), float(y)), heading * math.tau / cells.headings, BOUNCES)
    number = int(both.plane.cycle_of[states[0]])
    if number < 0:
        strokes, note = Strokes("plane", (path.positions_m,), PLANE_COLOUR, width_pt=0.5), "never comes to a cycle"
    else:
        cycle = both.plane.cycles[number]
        strokes = Strokes("plane", (path.positions_m[-cycle.period - 1 :],), PLANE_COLOUR, width_pt=1.3)
        length_m = both.plane.lengths_m[states[0]]
        note = f"same start: {cycle.period} contacts, {length_m:.1f} m, {cycle.stability}"
    in_plane = MapPanel(
        title=f"{name.capitalize()}: plane",
        note=note,
        mission=mission,
        strokes=(strokes,),
    )
    return [on_grid, in_plane]


def _grid_round(cells: Cells, turn: int, number: int) -> Longs:
    """(n + 1,) states that one round of a limit cycle of the grid goes through."""
    successor = single_map(make_team(cells, [turn]))
    basins = cycles_and_basins(successor.copy())
    states = [int(basins.first[number])]
    for _ in range(int(basins.length[number])):
        states.append(int(successor[states[-1]]))
    return np.array(states)
