"""Extra figure 13: the same bouncing without a grid, in polygons with straight lines and exact contacts."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.draw.palette import ROUTE_COLOURS
from rota.geometry.free_space import free_ground
from rota.model.mission import Mission
from rota.planners.bounce.bounce_map import cycles_and_basins, make_team, single_map
from rota.planners.bounce.cells import Cells, make_cells
from rota.planners.bounce.polygon import BounceRule, bounce_path, make_rim
from rota_studies.alam2020 import maps, paper
from rota_studies.alam2020.grid_beside_plane import GridBesidePlane, compare_grid_and_plane
from rota_studies.alam2020.runs import Runs
from rota_studies.panels.map_panel import MapPanel, Strokes
from rota_studies.records import what
from rota_studies.section import Picture, Section
from rota_studies.tables import Table, number

Longs = NDArray[np.int64]
Floats = NDArray[np.float64]

SHOWN_ANGLE_DEG = 135.0
GRID_COLOUR, PLANE_COLOUR = ROUTE_COLOURS[0], ROUTE_COLOURS[6]
BOUNCES = 2000


@dataclass(frozen=True, kw_only=True)
class BothCycles:
    """The limit cycles of a room by one angle, counted and compared, and one of each kind to be drawn.

    stabilities: cycles of the plane by kind. lost_share: of the starts that come to none there; same_share: of those
    whose cycle is as long in both. length_ratio: the median, plane by grid. grid_m, plane_m: (k, 2) metres.
    """

    on_grid: int
    in_plane: int
    stabilities: dict[str, int]
    lost_share: float
    same_share: float
    length_ratio: float | None
    grid_note: str
    grid_m: Floats
    plane_note: str
    plane_m: Floats


def figure_13_section(runs: Runs) -> Section:
    """The limit cycles of the plane beside those of the grid."""
    rows, compared, panels = [], {}, []
    for name, mission in maps.wide_rooms(SHOWN_ANGLE_DEG).items():
        for angle in paper.ANGLES_DEG:
            both = compared[name, angle] = _compared(runs, name, mission, angle)
            rows.append((name, f"{angle:g}°", *_row(both)))
            if angle == SHOWN_ANGLE_DEG:
                panels += _pair(name, mission, both)
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
                tuple(panels),
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


def _compared(runs: Runs, name: str, mission: Mission, angle_deg: float) -> BothCycles:
    """The limit cycles of a room by an angle."""

    def make() -> BothCycles:
        runs.now(f"figure 13: {name}, {angle_deg:g}°")
        cells, ground = make_cells(mission), free_ground(mission)
        turn = round(angle_deg * cells.headings / 360)
        radius_m = maps.ROOM_CELL_M / 2
        both = compare_grid_and_plane(cells, ground, turn=turn, body_radius_m=radius_m, bounces=BOUNCES)
        return cycles_told(mission, cells, turn, both)

    return runs.records.get(
        BothCycles, {"what": "grid beside plane", "room": name, **what(mission), "angle": angle_deg}, make
    )


def cycles_told(mission: Mission, cells: Cells, turn: int, both: GridBesidePlane) -> BothCycles:
    """What a comparison came to, the most frequent cycle on the grid, and where the same start ends in the plane."""
    most = int(both.shares.argmax())
    states = _grid_round(cells, turn, most)
    cell, heading = divmod(int(states[0]), cells.headings)
    rim = make_rim(free_ground(mission), maps.ROOM_CELL_M / 2)
    rule = BounceRule(angle_rad=turn * math.tau / cells.headings)
    x, y = cells.centres_m[cell]
    path = bounce_path(rim, rule, (float(x), float(y)), heading * math.tau / cells.headings, BOUNCES)
    cycle_number = int(both.plane.cycle_of[states[0]])
    if cycle_number < 0:
        way_m, note = path.positions_m, "never comes to a cycle"
    else:
        cycle = both.plane.cycles[cycle_number]
        way_m = path.positions_m[-cycle.period - 1 :]
        note = f"same start: {cycle.period} contacts, {both.plane.lengths_m[states[0]]:.1f} m, {cycle.stability}"
    ratios = both.length_ratios
    return BothCycles(
        on_grid=len(both.lengths_m),
        in_plane=len(both.plane.cycles),
        stabilities=dict(Counter(cycle.stability for cycle in both.plane.cycles)),
        lost_share=both.plane.unsettled_share + both.plane.stuck_share,
        same_share=both.same_share,
        length_ratio=float(np.median(ratios)) if len(ratios) else None,
        grid_note=f"{both.shares[most]:.0%} of starts, {both.bumps[most]} bumps, {both.lengths_m[most]:.1f} m",
        grid_m=cells.centres_m[states // cells.headings],
        plane_note=note,
        plane_m=way_m,
    )


def _row(both: BothCycles) -> tuple[str, ...]:
    """The row of one ground and angle: cycles on the grid, and in the plane by their stability."""
    kinds = (str(both.stabilities.get(kind, 0)) for kind in ("attracting", "half-stable", "neutral", "repelling"))
    return (
        f"{both.on_grid:,}", f"{both.in_plane:,}", " / ".join(kinds), f"{both.lost_share:.1%}",
        f"{both.same_share:.1%}", number(both.length_ratio, ".3f"),
    )  # fmt: skip


def _pair(name: str, mission: Mission, both: BothCycles) -> list[MapPanel]:
    """The most frequent cycle on the grid, and what comes of the same start in the plane."""
    lost = both.plane_note.startswith("never")
    shown = (
        ("grid", both.grid_note, Strokes("grid", (both.grid_m,), GRID_COLOUR, width_pt=1.3)),
        ("plane", both.plane_note, Strokes("plane", (both.plane_m,), PLANE_COLOUR, width_pt=0.5 if lost else 1.3)),
    )
    return [
        MapPanel(title=f"{name.capitalize()}: {where}", note=note, mission=mission, strokes=(strokes,))
        for where, note, strokes in shown
    ]


def _grid_round(cells: Cells, turn: int, number: int) -> Longs:
    """(n + 1,) states that one round of a limit cycle of the grid goes through."""
    successor = single_map(make_team(cells, [turn]))
    basins = cycles_and_basins(successor.copy())
    states = [int(basins.first[number])]
    for _ in range(int(basins.length[number])):
        states.append(int(successor[states[-1]]))
    return np.array(states)
