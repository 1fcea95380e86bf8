"""Ctrl-C, once: stop and keep what there is; twice: end at once."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


class StopFlag:
    """False until Ctrl-C; calling it asks."""

    def __init__(self) -> None:
        self.raised = False

    def __call__(self) -> bool:
        """Whether Ctrl-C was pressed."""
        return self.raised


@contextmanager
def stop_on_interrupt(announce: Callable[[], None]) -> Iterator[StopFlag]:
    """Within the block the first SIGINT raises the flag and calls ``announce``; the second ends the process at once.

    Outside the main thread, where Python hands out no signals, the flag stays down.
    """
    flag = StopFlag()
    if threading.current_thread() is not threading.main_thread():
        yield flag
        return

    def raise_flag(_signal: int, _frame: FrameType | None) -> None:
        flag.raised = True
        # left to the system, so that a long compiled loop cannot hold up the second one
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        announce()

    before = signal.signal(signal.SIGINT, raise_flag)
    try:
        yield flag
    finally:
        signal.signal(signal.SIGINT, before)
