"""Names in tables that spreadsheets open: none may be taken for a formula."""

from __future__ import annotations

from collections.abc import Iterable

_FORMULA = ("=", "+", "-", "@", "\t", "\r")  # what makes a spreadsheet compute a cell
_TEXT = "'"  # before a cell: it is text


def as_cell(name: str) -> str:
    """The name, with an apostrophe before it where a spreadsheet would compute it, or take an apostrophe away."""
    return _TEXT + name if name.lstrip(_TEXT).startswith(_FORMULA) else name


def from_cell(cell: str) -> str:
    """The name that ``as_cell`` made a cell of."""
    return cell[1:] if cell.startswith(_TEXT) and as_cell(cell[1:]) == cell else cell


def as_cells(values: Iterable[object]) -> list[object]:
    """Values of a row: texts as cells, the others as they are."""
    return [as_cell(value) if isinstance(value, str) else value for value in values]
