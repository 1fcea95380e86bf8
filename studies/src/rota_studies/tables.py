"""The study's tables: rows of text with a head, as Markdown and as plain text."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

NOTHING = "–"
LONGEST_CELL = 24  # characters, in plain text


@dataclass(frozen=True, kw_only=True)
class Table:
    """A title, a head, and rows of as many cells; cells of the columns in ``words`` are text, the others numbers."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    words: tuple[int, ...] = (0,)

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.head):
                raise ValueError(f"rows: {row!r} has {len(row)} cells; must be {len(self.head)}, as many as the head")

    @property
    def markdown(self) -> str:
        """The table as Markdown, its title above it in bold."""
        rule = "|".join("---" if k in self.words else "---:" for k in range(len(self.head)))
        lines = [f"**{self.title}**", "", _piped(self.head), f"|{rule}|", *map(_piped, self.rows)]
        return "\n".join(lines)

    @property
    def text(self) -> str:
        """The table as plain text in columns, its title above it; long cells go on below."""
        rows = self._wrapped()
        widths = [max(len(row[k]) for row in rows) for k in range(len(self.head))]
        lines = [self.title]
        for row in rows:
            cells = [
                cell.ljust(width) if k in self.words else cell.rjust(width)
                for k, (cell, width) in enumerate(zip(row, widths, strict=True))
            ]
            lines.append("  ".join(cells).rstrip())
        return "\n".join(lines)

    def _wrapped(self) -> list[tuple[str, ...]]:
        """Head and rows, with as many lines for each as its longest cell needs."""
        lines: list[tuple[str, ...]] = []
        for row in (self.head, *self.rows):
            cells = [textwrap.wrap(cell, LONGEST_CELL) or [""] for cell in row]
            lines += itertools.zip_longest(*cells, fillvalue="")
        return lines


def _piped(cells: tuple[str, ...]) -> str:
    """The cells as a row of a Markdown table."""
    return "| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |"


def number(value: float | None, form: str = ",.2f") -> str:
    """A number in a format, a dash for none."""
    return NOTHING if value is None else format(value, form)


def plus_minus(values: Sequence[float] | NDArray[Any], form: str) -> str:
    """Mean and standard deviation; only the mean of one value, a dash for none."""
    if not len(values):
        return NOTHING
    mean = format(float(np.mean(values)), form)
    return mean if len(values) < 2 else f"{mean} ± {format(float(np.std(values, ddof=1)), form)}"


def counted(count: int, singular: str, plural: str | None = None) -> str:
    """``1 robot``, ``3 robots``."""
    return f"{count:,} {singular if count == 1 else plural or singular + 's'}"


def joined(words: list[str], last: str = "and") -> str:
    """``a``, ``a and b``, ``a, b and c``; ``last``: before the last one."""
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + f" {last} " + words[-1] if words else ""
