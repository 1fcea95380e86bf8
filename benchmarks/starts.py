"""How long short commands keep one waiting, from the shell, when all is compiled."""

from __future__ import annotations

import statistics
from collections.abc import Iterator

from benchmarks.missions import EXAMPLES
from benchmarks.planning import peak
from benchmarks.row import Options, Row
from benchmarks.shell import rota
from benchmarks.warm_cache import measured_warm

REPEATS = 7
ASKED_S = {"--help": 0.2, "check": 1.0, "draw": 2.0}


def warm_start(options: Options) -> Iterator[Row]:
    """``rota --help``, ``rota check`` and ``rota draw`` of the harbour, start-up included, when all is compiled."""
    plan = options.folder / "harbour.rota.json"
    made = rota("plan", EXAMPLES / "harbour.yaml", "--effort", "quick", "-o", plan)
    if made.code != 0:
        raise RuntimeError(made.err)
    commands = {
        "--help": ("--help",),
        "check": ("check", plan),
        "draw": ("draw", plan, "-o", options.folder / "harbour.png"),
    }
    for name, command in commands.items():
        runs = measured_warm(lambda c=command: rota(*c), lambda run: run.wall_s, repeats=REPEATS)  # type: ignore[misc]
        wall_s, cpu_s = (statistics.median(getattr(run, field) for run in runs) for field in ("wall_s", "cpu_s"))
        reached = wall_s <= ASKED_S[name] and all(run.code == 0 for run in runs)
        what = "rota --help" if name == "--help" else f"rota {name} of the harbour"
        yield Row(what, f"< {ASKED_S[name]:g} s", f"{wall_s:.2f} s, {cpu_s:.2f} s of processor, {peak(runs)}", reached)
