"""Ctrl-C or SIGTERM, once: stop and keep what there is; twice: end at once."""

from __future__ import annotations

import asyncio
import signal
import threading
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

NAMES = {signal.SIGINT: "Ctrl-C", signal.SIGTERM: "SIGTERM"}  # what ends a program, as people call it


GRACE_S = 60  # after SIGTERM: who sends it is a machine, and counts on an end


class Terminated(KeyboardInterrupt):
    """SIGTERM where nothing handles it better: what is open is cleaned up on the way out, as after Ctrl-C."""


class StopFlag:
    """False until Ctrl-C or SIGTERM; calling it asks."""

    def __init__(self) -> None:
        self.by: signal.Signals | None = None

    def __call__(self) -> bool:
        """Whether either came."""
        return self.raised

    @property
    def raised(self) -> bool:
        """Whether either came."""
        return self.by is not None

    @property
    def exit_code(self) -> int:
        """What a program ends with that was stopped so: as a shell tells it of one that the signal ended, 130 or 143.

        0 while nothing came.
        """
        return 0 if self.by is None else 128 + self.by


@contextmanager
def stop_on_interrupt(announce: Callable[[str], None]) -> Iterator[StopFlag]:
    """Within the block the first SIGINT or SIGTERM raises the flag; the next one ends the process at once.

    So does the system, by SIGALRM, when a block that SIGTERM should stop goes on for ``GRACE_S`` more. ``announce`` is
    called with the name of the first. Outside the main thread, where Python hands out no signals, the flag stays down;
    a signal that whoever started the program had it ignore (nohup) stays ignored.
    """
    flag = StopFlag()

    def raise_flag(number: int, _frame: FrameType | None) -> None:
        flag.by = signal.Signals(number)
        # left to the system, so that a long compiled loop cannot hold up the next one
        for each in taken:
            signal.signal(each, signal.SIG_DFL)
        if flag.by == signal.SIGTERM and hasattr(signal, "alarm"):
            signal.alarm(GRACE_S)
        announce(NAMES[flag.by])

    taken = _taken(raise_flag)
    try:
        yield flag
    finally:
        if flag.by == signal.SIGTERM and hasattr(signal, "alarm"):
            signal.alarm(0)
        for number, before in taken.items():
            signal.signal(number, before)


@contextmanager
def clean_end_on_terminate() -> Iterator[None]:
    """Within the block SIGTERM raises ``Terminated``, so that no half-written file is left behind."""

    def end(_signal: int, _frame: FrameType | None) -> None:
        raise Terminated

    taken = _taken(end, signal.SIGTERM)
    try:
        yield
    finally:
        for number, before in taken.items():
            signal.signal(number, before)


def run_to_its_end(main: Coroutine[Any, Any, None]) -> None:
    """``asyncio.run``, where SIGTERM cancels ``main`` alone, as Ctrl-C does: it cleans up while its other tasks go on.

    Raises Terminated then.
    """

    async def guarded() -> None:
        task = asyncio.current_task()
        assert task is not None
        loop = asyncio.get_running_loop()

        def end(_signal: int, _frame: FrameType | None) -> None:
            loop.call_soon_threadsafe(task.cancel)

        before = _taken(end, signal.SIGTERM)
        try:
            await main
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    try:
        asyncio.run(guarded())
    except asyncio.CancelledError:
        raise Terminated from None


def _taken(
    handler: Callable[[int, FrameType | None], None], *numbers: signal.Signals
) -> dict[signal.Signals, signal._HANDLER]:
    """Hand the signals (all by default) to a handler; those that were taken, with what handled them before."""
    if threading.current_thread() is not threading.main_thread():
        return {}
    wanted = [number for number in numbers or NAMES if signal.getsignal(number) is not signal.SIG_IGN]
    return {number: signal.signal(number, handler) for number in wanted}
