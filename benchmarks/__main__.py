"""Measure and print: ``python -m benchmarks`` for all figures, ``python -m benchmarks NAME ...`` for some."""

from __future__ import annotations

import argparse
import math
import tempfile
from pathlib import Path
from typing import get_args

from benchmarks.figures import FIGURES, LONG
from benchmarks.machine import facts
from benchmarks.measured import PAGE, cell, kept_row, page_of, read_kept, replaced, write_kept
from benchmarks.row import EFFORT_TAKEN, Options, Row
from benchmarks.warm_cache import REPEATS, SHORT_S
from rota.planners.patrol.planner_settings import Effort


def main() -> None:
    """Print one row as soon as it is measured; the exit code does not depend on the figures."""
    chosen = arguments().parse_args()
    names = chosen.names or [name for name in FIGURES if chosen.all or name not in LONG]
    for line in facts():
        print(line)
    print(f"Commands run from the shell; medians of {REPEATS} where one takes under {SHORT_S:.0f} s.\n")
    print("| figure | asked | measured | reached |\n|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        options = Options(
            folder=Path(folder),
            effort=chosen.effort,
            missions=chosen.missions,
            first_seed=chosen.first_seed,
            tile_m=chosen.tile,
            processes=chosen.processes,
            steps=chosen.steps,
            flights=chosen.flights,
            graphs=chosen.graphs,
        )
        for name in names:
            for row in FIGURES[name](options):
                print(line_of(row), flush=True)
                if chosen.keep:
                    keep(row, name, chosen.effort)


def keep(row: Row, name: str, effort: str) -> None:
    """Put the row into the file of figures, and write the page that shows them."""
    rows = replaced(read_kept(), [kept_row(row, name, effort)])
    write_kept(rows)
    PAGE.write_text(page_of(read_kept()))


def line_of(row: Row) -> str:
    """The row in Markdown; a cell may hold anything."""
    cells = (row.name, row.asked, row.measured, {True: "yes", False: "NO", None: ""}[row.reached])
    return "| " + " | ".join(cell(text) for text in cells) + " |"


def arguments() -> argparse.ArgumentParser:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Print what planning and checking cost.")
    known = f"{', '.join(FIGURES)}; default all but {' and '.join(LONG)}, which take long"
    parser.add_argument("names", nargs="*", type=figure_name, metavar="NAME", help=f"figures to measure: {known}")
    parser.add_argument("--all", action="store_true", help="measure those that take long, too")
    parser.add_argument("--keep", action="store_true", help="keep the rows in measured.csv and docs/benchmarks.md")
    parser.add_argument(
        "--effort",
        choices=get_args(Effort),
        default="quick",
        help=f"of {', '.join(EFFORT_TAKEN[:-1])} and {EFFORT_TAKEN[-1]}; default quick, as all else is",
    )
    parser.add_argument(
        "--missions", type=count, default=1000, metavar="N", help="of random-missions, known-plans; default 1000"
    )
    parser.add_argument(
        "--first-seed", type=seed, default=0, metavar="K", help="of random-missions, known-plans; default 0"
    )
    parser.add_argument("--processes", type=count, metavar="N", help="for random-missions; default one a core")
    parser.add_argument(
        "--tile", type=metres, default=1000.0, metavar="M", help="side of a tile of plan-1-km2 and plan-10-km2, metres"
    )
    parser.add_argument("--steps", type=count, default=1000, metavar="N", help="of swarm-million; default 1000")
    parser.add_argument("--flights", type=Path, metavar="FOLDER", help="recorded flights, for flights")
    parser.add_argument("--graphs", type=Path, metavar="FOLDER", help="a checkout of patrolling_sim, for graph-patrols")
    return parser


def figure_name(text: str) -> str:
    """A figure's name, or a message that lists them."""
    if text not in FIGURES:
        raise argparse.ArgumentTypeError(f"{text!r} is not known here; {', '.join(FIGURES)} are")
    return text


def count(text: str) -> int:
    """A number of things, at least one."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not allowed; a whole number from 1 on is needed")
    return int(text)


def seed(text: str) -> int:
    """A seed, 0 or more."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is not allowed; a whole number from 0 on is needed")
    return int(text)


def metres(text: str) -> float:
    """A length that is greater than 0."""
    try:
        length_m = float(text)
    except ValueError:
        length_m = math.nan
    if not (length_m > 0 and math.isfinite(length_m)):
        raise argparse.ArgumentTypeError(f"{text!r} is not allowed; a number of metres greater than 0 is needed")
    return length_m


if __name__ == "__main__":
    main()
