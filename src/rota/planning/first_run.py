"""Compile in two processes what a first plan takes: it comes sooner.

``python -m rota.planning.first_run PLANNER`` is one of them.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from subprocess import DEVNULL, Popen

from rota.check.compile_ahead import PARTS
from rota.compiled.parts import Part, compile_parts
from rota.planning.planner import Planner, planner_named


def parts_of(planner: Planner) -> tuple[Part, ...]:
    """What a first plan of the planner and its check compile; nothing for planners that compile in a moment."""
    own = planner.parts_to_compile()
    return (*own, *PARTS) if own else ()


@contextmanager
def compile_by_two(
    planner: Planner, *, tell: Callable[[float, str], None] | None = None, to_the_end: bool = False
) -> Iterator[None]:
    """Compile here and in another process, and then let the planner work; nothing is compiled by both.

    tell: called with the share of the parts that are done or begun, and what this process compiles next. to_the_end:
    what the other process is still at then is not stopped when the planner is done.
    """
    parts = parts_of(planner)
    if not parts:
        yield
        return
    command = [sys.executable, "-m", "rota.planning.first_run", planner.settings.planner]
    process = Popen(command, stdin=DEVNULL, stdout=DEVNULL, stderr=DEVNULL)
    try:
        compile_parts(parts, tell)
        yield
        if to_the_end:
            process.wait()
    finally:
        process.kill()
        process.wait()


if __name__ == "__main__":
    compile_parts(parts_of(planner_named(sys.argv[1])))
