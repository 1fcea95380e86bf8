"""Ctrl-C, SIGTERM or SIGHUP, once: stop and keep what there is; Ctrl-C or SIGTERM twice: end at once."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import threading
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

from rota.command.exit_codes import SIGNALLED
from rota.command.terminal import say

# what ends a program, as people call it; a system that closes no terminals has no SIGHUP
NAMES = {signal.SIGINT: "Ctrl-C", signal.SIGTERM: "SIGTERM"}
HANG_UP: signal.Signals | None = getattr(signal, "SIGHUP", None)
if HANG_UP is not None:
    NAMES[HANG_UP] = "the end of the terminal"
ENDS = tuple(number for number in NAMES if number != signal.SIGINT)  # those that are no Ctrl-C


class Terminated(KeyboardInterrupt):
    """SIGTERM or SIGHUP where nothing handles it better: what is open is cleaned up on the way out, as after Ctrl-C."""

    def __init__(self, number: int = signal.SIGTERM) -> None:
        super().__init__()
        self.number = number


def signalled_code(end: KeyboardInterrupt) -> int:
    """The exit code of a program that was ended so."""
    return SIGNALLED + (end.number if isinstance(end, Terminated) else signal.SIGINT)


class StopFlag:
    """False until Ctrl-C, SIGTERM or SIGHUP; calling it asks."""

    def __init__(self) -> None:
        self.by: signal.Signals | None = None

    def __call__(self) -> bool:
        """Whether one of them came."""
        return self.raised

    @property
    def raised(self) -> bool:
        """Whether one of them came."""
        return self.by is not None

    @property
    def exit_code(self) -> int:
        """What a program ends with that was stopped so: as a shell tells it of one that the signal ended.

        0 while nothing came.
        """
        return 0 if self.by is None else SIGNALLED + self.by


@contextmanager
def stop_on_interrupt(announce: Callable[[str], None]) -> Iterator[StopFlag]:
    """Within the block the first SIGINT, SIGTERM or SIGHUP raises the flag; the next SIGINT or SIGTERM ends at once.

    ``announce`` is called with the name of the first. A shell that closes sends SIGHUP more than once: later ones are
    ignored. Outside the main thread, where Python hands out no signals, the flag stays down; a signal that whoever
    started the program had it ignore (nohup) stays ignored.
    """
    flag = StopFlag()

    def raise_flag(number: int, _frame: FrameType | None) -> None:
        flag.by = signal.Signals(number)
        # left to the system, so that nothing can hold up the next one
        for each in taken:
            signal.signal(each, signal.SIG_IGN if each == HANG_UP else signal.SIG_DFL)
        if number == HANG_UP:
            _forget_terminal()
        announce(NAMES[flag.by])

    taken = _take(raise_flag)
    try:
        yield flag
    finally:
        for number, before in taken.items():
            signal.signal(number, before)


@contextmanager
def clean_end_on_terminate() -> Iterator[None]:
    """Within the block SIGTERM and SIGHUP raise ``Terminated``, so that no half-written file is left behind."""

    def end(number: int, _frame: FrameType | None) -> None:
        if number == HANG_UP:
            _forget_terminal()
        raise Terminated(number)

    taken = _take(end, *ENDS)
    try:
        yield
    finally:
        for number, before in taken.items():
            signal.signal(number, before)


@contextmanager
def saying_when_interrupted(what: str) -> Iterator[None]:
    """Say what there is of the work where Ctrl-C, SIGTERM or SIGHUP ends the block."""
    try:
        yield
    except KeyboardInterrupt:
        say(what)
        raise


def run_to_its_end(main: Coroutine[Any, Any, None]) -> None:
    """``asyncio.run``, where SIGTERM and SIGHUP cancel ``main`` alone, as Ctrl-C does.

    It cleans up while its other tasks go on. Raises Terminated then.
    """
    came: list[int] = []

    async def guard() -> None:
        task = asyncio.current_task()
        assert task is not None
        loop = asyncio.get_running_loop()

        def end(number: int, _frame: FrameType | None) -> None:
            came.append(number)
            if number == HANG_UP:
                _forget_terminal()
            loop.call_soon_threadsafe(task.cancel)

        before = _take(end, *ENDS)
        try:
            await main
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    try:
        asyncio.run(guard())
    except asyncio.CancelledError:
        raise Terminated(*came[:1]) from None


def _take(
    handler: Callable[[int, FrameType | None], None], *numbers: signal.Signals
) -> dict[signal.Signals, signal._HANDLER]:
    """Hand the signals (all by default) to a handler; those that were taken, with what handled them before."""
    if threading.current_thread() is not threading.main_thread():
        return {}
    wanted = [number for number in numbers or NAMES if signal.getsignal(number) is not signal.SIG_IGN]
    return {number: signal.signal(number, handler) for number in wanted}


def _forget_terminal() -> None:
    """Write nowhere what would go to a terminal that is closed: there it would fail, and end what cleans up."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):
            if os.isatty(stream.fileno()):
                nowhere = os.open(os.devnull, os.O_WRONLY)
                os.dup2(nowhere, stream.fileno())
                os.close(nowhere)
