# mypy: disable-error-code="no-any-return"
"""Compiled search for the places of the map near a point: they lie in cells, row by row from the south."""

from __future__ import annotations

from typing import Any

from rota.compiled.kernel import allocation_free


@allocation_free
def rows_within(y: float, reach_m: float, graph: Any) -> tuple[int, int]:
    """The rows of cells that a square of half side reach_m round a point at y touches, as a range."""
    low = max(int((y - reach_m - graph.y0) / graph.cell_m), 0)
    return low, min(int((y + reach_m - graph.y0) / graph.cell_m), graph.rows - 1) + 1


@allocation_free
def places_of_row(row: int, x: float, reach_m: float, graph: Any) -> tuple[int, int]:
    """The places in those cells of a row that the square round a point at x touches, as a range."""
    first = max(int((x - reach_m - graph.x0) / graph.cell_m), 0)
    last = min(int((x + reach_m - graph.x0) / graph.cell_m), graph.columns - 1)
    return graph.cell_start[row * graph.columns + first], graph.cell_start[row * graph.columns + last + 1]
