"""Cells of typed maps, and bouncing robots again in plain Python, from the paper's words."""

from __future__ import annotations

import itertools
from typing import Any

import shapely
from shapely import MultiPolygon

from rota.files.text_map import text_map
from rota.planners.bounce.cells import Cells, cells_of

State = tuple[int, int, int]


def typed_cells(text: str, **options: Any) -> Cells:
    """Cells of 1 m of a typed map."""
    area, walls = text_map(text, 1.0)
    ground = MultiPolygon(list(shapely.get_parts(area.difference(walls))))
    return cells_of(ground, area.bounds, cell_m=1.0, **options)


class PlainTeam:
    """Robots on a typed map: states are (column, row, heading), moves and contacts as in the readings of the paper."""

    def __init__(self, text: str, bounces: list[int], headings: int = 8, corners: str = "blocked") -> None:
        lines = text.strip().splitlines()[::-1]
        self.free = {(x, y) for y, line in enumerate(lines) for x, mark in enumerate(line.strip()) if mark == "."}
        self.headings, self.bounces, self.corners = headings, bounces, corners
        ring = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
        self.moves = ring if headings == 8 else ring[::2]

    def states(self) -> list[State]:
        return [(x, y, h) for x, y in sorted(self.free, key=lambda c: (c[1], c[0])) for h in range(self.headings)]

    def aim(self, state: State) -> tuple[int, int] | None:
        x, y, h = state
        dx, dy = self.moves[h]
        beside = [(x + dx, y), (x, y + dy)] if self.corners == "blocked" else []
        return (x + dx, y + dy) if all(c in self.free for c in [(x + dx, y + dy), *beside]) else None

    def step(self, joint: tuple[State, ...]) -> tuple[tuple[State, ...], int]:
        aims = [self.aim(state) for state in joint]
        contacts = 0
        while True:
            ends = [aim or state[:2] for aim, state in zip(aims, joint, strict=True)]
            met = set()
            for i, j in itertools.combinations(range(len(joint)), 2):
                if aims[i] is None and aims[j] is None:
                    continue
                middles = [(joint[k][0] + ends[k][0], joint[k][1] + ends[k][1]) for k in (i, j)]
                if ends[i] == ends[j] or middles[0] == middles[1]:
                    met |= {i, j}
                    contacts += 1
            if not met:
                break
            for i in met:
                aims[i] = None
        after = []
        for (x, y, h), aim, bounce in zip(joint, aims, self.bounces, strict=True):
            after.append((x, y, (h + bounce) % self.headings) if aim is None else (*aim, h))
        return tuple(after), contacts

    def joints(self) -> list[tuple[State, ...]]:
        """All joint states without two robots in one cell."""
        found = itertools.product(self.states(), repeat=len(self.bounces))
        return [joint for joint in found if len({state[:2] for state in joint}) == len(joint)]
