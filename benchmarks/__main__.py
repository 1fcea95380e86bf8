"""Measure and print: ``python -m benchmarks`` for all figures, ``python -m benchmarks NAME ...`` for some."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from benchmarks.figures import FIGURES
from benchmarks.machine import facts
from benchmarks.warm_cache import REPEATS, SHORT_S


def main() -> None:
    """Print one row as soon as it is measured; the exit code does not depend on the figures."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Print what planning and checking cost.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"figures to measure: {', '.join(FIGURES)}; all")
    names = parser.parse_args().names or list(FIGURES)
    unknown = [name for name in names if name not in FIGURES]
    if unknown:
        parser.error(f"{', '.join(unknown)}: not known here; {', '.join(FIGURES)} are")
    for line in facts():
        print(line)
    print(f"Commands run from the shell; medians of {REPEATS} where one takes under {SHORT_S:.0f} s.\n")
    print("| figure | asked | measured | reached |\n|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            for row in FIGURES[name](Path(folder)):
                reached = {True: "yes", False: "NO", None: ""}[row.reached]
                print(f"| {row.name} | {row.asked} | {row.measured} | {reached} |", flush=True)


if __name__ == "__main__":
    main()
