"""``rota compile``: all kernels before anybody waits for them, for images, clusters and installations."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from typing import TYPE_CHECKING, Annotated

import typer

from rota.command.terminal import Bar, progress_bar, say
from rota.compiled.compiled_cache import mention_compiling

if TYPE_CHECKING:
    from rota.planning.planner import Planner

LOOK_EVERY_S = 0.5


def compile_kernels(
    planners: Annotated[
        list[str] | None, typer.Argument(metavar="PLANNER...", help="Only for these; default patrol, swarm and bounce.")
    ] = None,
) -> None:
    """Compile ahead what a first plan and its check wait for."""
    from rota.compiled.code_cache import cache_folder, is_writable
    from rota.errors import NoPlanFound, RotaError
    from rota.model.planner_registry import PLANNERS
    from rota.planning.first_run import compile_by_two
    from rota.planning.make_plan import search_plan
    from rota.planning.planner import planner_named
    from rota.vehicles.compile_ahead import fly_a_square

    doors = {name: planner_named(name) for name in planners or PLANNERS}
    folder = cache_folder()
    if not is_writable(folder):
        raise RotaError(f"{folder} cannot be written; choose another folder by NUMBA_CACHE_DIR")
    began_s = time.monotonic()
    with progress_bar() as bar, _show_progress(bar) as compiled:
        for door in doors.values():
            small = door.small_mission()
            if small is not None:
                with compile_by_two(door, to_the_end=True), suppress(NoPlanFound):
                    search_plan(small)
        fly_a_square()
    say(f"{len(compiled())} functions compiled in {time.monotonic() - began_s:.0f} s, kept in {folder}")


@contextmanager
def compile_first(planner: Planner, packages: Sequence[str]) -> Iterator[None]:
    """Before the planner works, compile what it takes unless these packages are compiled, and show what is compiled."""
    from rota.compiled.compiled_cache import is_compiled
    from rota.planning.first_run import compile_by_two

    mention_compiling(*packages)
    with ExitStack() as held:
        if not is_compiled(*packages):
            with progress_bar() as bar:
                held.enter_context(compile_by_two(planner, tell=bar.show))
        yield


@contextmanager
def _show_progress(bar: Bar) -> Iterator[Callable[[], set[str]]]:
    """Show the newest function on the bar; gives what tells all that were compiled meanwhile, by any process."""
    from rota.compiled.code_cache import kept_names

    before, done = kept_names(), threading.Event()

    def new_names() -> set[str]:
        """What is kept now and was not before."""
        return kept_names() - before

    def show() -> None:
        """Tell how many there are until the work is done."""
        while not done.wait(LOOK_EVERY_S):
            bar.show(0.0, f"compiling, {len(new_names())} functions so far")

    shower = threading.Thread(target=show, daemon=True)
    shower.start()
    try:
        yield new_names
    finally:
        done.set()
        shower.join()
