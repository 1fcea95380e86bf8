"""The figures kept in ``measured.csv``, and the page made of them: ``python -m benchmarks.measured`` writes it anew."""

from __future__ import annotations

import csv
import datetime
import platform
from collections.abc import Iterable, Sequence
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from benchmarks.figures import FIGURES, LONG
from benchmarks.machine import cores_told
from benchmarks.row import EFFORT_TAKEN, Row

KEPT = Path(__file__).with_name("measured.csv")
PAGE = Path(__file__).parents[1] / "docs" / "benchmarks.md"

INTRODUCTION = """\
# Benchmarks

<!-- Written by `python -m benchmarks.measured` from benchmarks/measured.csv; do not edit by hand. -->

Every figure has what is asked beside what was measured. Times are those of `rota plan` and `rota check` from the shell,
start-up included. Exceptions: under `methods` they are as `rota compare` tells them, and under the stages of Sun 2019
they are CPU seconds of the stage alone. Effort is quick unless a row says otherwise. *Date* is the day on which the row
was entered.

`make bench` measures all but {long}, which take some minutes to an hour and are measured when named, or with `--all`.
`.venv/bin/python -m benchmarks NAME` measures the rows of one name; the names are the headings below. `--keep` puts the
rows into `benchmarks/measured.csv` and writes this page anew. `--effort` is heeded by {efforts}.

- `parcel-nl` (a Dutch parcel), `cumberland` (a scanned building) and `lawn-mowing` (published polygons) need data that
  is not part of the repository; without it their rows say so.
- `one-robot` installs coverage-path-planner from PyPI, which names no licence, into a temporary folder to run beside
  it; `sun2019-frame` does so with fast-tsp, `swarm-peer` with pyrvo, and `swarm-importance` with coverage_control
  (GPL-3.0, no dependency).
- `random-missions` plans a thousand small missions; `--missions 1 --first-seed N` plans one of them again, and Ctrl-C
  ends it with what is done.

The machine's speed varies by half. Sun's cases at quick and normal were measured in slow hours, most others in fast
ones; the first run of sun2019-fig13 takes 79 s in a slow one. Sun's cases at high were measured in part beside other
work, and before linear programs were solved by highspy instead of scipy, to the same optimum.
"""


class Kept(NamedTuple):
    """A figure as it was measured: ``command`` follows ``python -m benchmarks``; ``reached`` is yes, NO or empty."""

    command: str
    figure: str
    asked: str
    measured: str
    reached: str
    date: str
    machine: str

    @property
    def name(self) -> str:
        """The name in FIGURES."""
        return self.command.split()[0]


def kept_row(row: Row, name: str, effort: str) -> Kept:
    """A row that this machine has measured now."""
    return Kept(
        command=name + (f" --effort {effort}" if name in EFFORT_TAKEN and effort != "quick" else ""),
        figure=row.name,
        asked=row.asked,
        measured=row.measured,
        reached={True: "yes", False: "NO", None: ""}[row.reached],
        date=datetime.datetime.now(datetime.UTC).date().isoformat(),
        machine=f"{cores_told()}; Python {platform.python_version()}",
    )


def read_kept(path: Path = KEPT) -> list[Kept]:
    """The rows in the file's order."""
    with path.open(newline="") as file:
        lines = csv.reader(file)
        require_head(next(lines, []), path)
        return [Kept(*line) for line in lines]


def require_head(head: Sequence[str], path: Path) -> None:
    """Raise ValueError for a file with other columns."""
    if tuple(head) != Kept._fields:
        raise ValueError(f"{path}: columns {', '.join(head)}; {', '.join(Kept._fields)} are needed")


def write_kept(rows: Iterable[Kept], path: Path = KEPT) -> None:
    """Write all rows, in the order of FIGURES and within a name as they come."""
    places = {name: k for k, name in enumerate(FIGURES)}
    ordered = sorted(rows, key=lambda row: places[row.name])  # before the file is emptied: a name may be unknown
    with path.open("w", newline="") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow(Kept._fields)
        lines.writerows(ordered)


def replaced(old: Sequence[Kept], new: Iterable[Kept]) -> list[Kept]:
    """The old rows with those of the same command and figure replaced, and new ones at the end."""
    rows = {(row.command, row.figure): row for row in old}
    rows.update({(row.command, row.figure): row for row in new})
    return list(rows.values())


def cell(text: str) -> str:
    """What stands in a cell of a Markdown table, on one line."""
    return " ".join(text.split()).replace("|", "/")


def page_of(rows: Sequence[Kept]) -> str:
    """The page: a section for each name, and in it a table."""
    long = f"{', '.join(LONG[:-1])} and {LONG[-1]}"
    efforts = f"{', '.join(EFFORT_TAKEN[:-1])} and {EFFORT_TAKEN[-1]}"
    parts = [INTRODUCTION.format(long=long, efforts=efforts)]
    for name, its in groupby(rows, key=lambda row: row.name):
        parts.append(section(name, list(its)))
    return "\n".join(parts)


def section(name: str, rows: Sequence[Kept]) -> str:
    """What the benchmark measures, the commands that measure it, its rows, and where they were measured."""
    commands = [f"`python -m benchmarks {command}`" for command in dict.fromkeys(row.command for row in rows)]
    lines = [f"## {name}", "", " ".join((FIGURES[name].__doc__ or "").split()), f"{', '.join(commands)}.", ""]
    lines += ["| figure | asked | measured | reached | date |", "|---|---|---|---|---|"]
    lines += [
        "| " + " | ".join(cell(text) for text in (row.figure, row.asked, row.measured, row.reached, row.date)) + " |"
        for row in rows
    ]
    machines = dict.fromkeys(row.machine for row in rows)
    return "\n".join([*lines, "", f"Machine: {'; or '.join(machines)}.", ""])


def main() -> None:
    """Write the page."""
    PAGE.write_text(page_of(read_kept()))


if __name__ == "__main__":
    main()
