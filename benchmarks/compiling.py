"""The table of docs/compiling.md: ``python -m benchmarks.compiling`` tells what a first run compiles.

It takes the harbour's first plan at effort quick, its check and its drawing, in one process with an empty cache.
Seconds are those of the processor, each function's without what it waits for its callees.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

from numba.core import event

EXAMPLE = Path(__file__).parent.parent / "examples" / "harbour.yaml"
LONGEST = 25
OTHERS = "numba's own"


class Compilations(event.Listener):  # type: ignore[misc]
    """How often each function was compiled, and the seconds of that."""

    def __init__(self) -> None:
        self.times: dict[str, int] = defaultdict(int)
        self.seconds: dict[str, float] = defaultdict(float)
        self._begun: list[list[float]] = []

    def on_start(self, event: Any) -> None:
        """Numba begins with a function, maybe within another one."""
        self._begun.append([time.process_time(), 0.0])

    def on_end(self, event: Any) -> None:
        """It is done with the innermost one."""
        began_s, within_s = self._begun.pop()
        lasted_s = time.process_time() - began_s
        if self._begun:
            self._begun[-1][1] += lasted_s
        function = event.data["dispatcher"].py_func
        name = f"{function.__module__}.{function.__qualname__}"
        self.times[name] += 1
        self.seconds[name] += lasted_s - within_s


def table(told: Compilations) -> str:
    """Packages first, then the functions that take longest."""
    packages: dict[str, list[str]] = defaultdict(list)
    for name in told.seconds:
        rota, _, rest = name.partition(".")
        packages[rest.rsplit(".", 2)[0] if rota == "rota" else OTHERS].append(name)
    lines = ["| package | functions | compilations | seconds |", "|---|---|---|---|"]
    for package in sorted(packages, key=lambda name: -sum(told.seconds[each] for each in packages[name])):
        names = packages[package]
        counts = f"{len(names)} | {sum(told.times[each] for each in names)}"
        lines.append(f"| {package} | {counts} | {sum(told.seconds[each] for each in names):.1f} |")
    lines.append(f"| all | {len(told.times)} | {sum(told.times.values())} | {sum(told.seconds.values()):.1f} |")
    lines += ["", "| function | compilations | seconds |", "|---|---|---|"]
    for name in sorted(told.seconds, key=lambda name: -told.seconds[name])[:LONGEST]:
        lines.append(f"| {name.removeprefix('rota.')} | {told.times[name]} | {told.seconds[name]:.2f} |")
    return "\n".join(lines)


def first_run(folder: str) -> None:
    """Plan, check and draw."""
    from rota.draw import draw_plan
    from rota.files.mission_file import read_mission
    from rota.planning.make_plan import search_plan

    mission = read_mission(EXAMPLE).mission.with_effort("quick")
    plan = search_plan(mission).plan
    assert plan is not None
    draw_plan(plan, os.path.join(folder, "harbour.png"))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        if sys.argv[1:] == ["here"]:
            told = Compilations()
            event.register("numba:compile", told)
            first_run(folder)
            print(table(told))
        else:
            environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
            subprocess.run([sys.executable, "-m", "benchmarks.compiling", "here"], env=environment, check=True)
