"""When work ends early: a time limit, a caller's wish, and the processor time that it may still use after either."""

from __future__ import annotations

import contextvars
import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

from rota.errors import NoPlanFound

GRACE_S = 20.0  # of processor time, of the whole process; what comes after, such as writing, has a few seconds more
TICK_S = 0.1  # who waits looks so often
UNASKED_S = 2.0  # a caller is asked by who waits where the work itself has not asked for so long
IDLE_S, HARDLY_S = 60.0, 0.2  # who uses so little in so long waits for somebody who will not come

Result = TypeVar("Result")


class StopRule:
    """True once the time is up or the caller says so, and from then on.

    ``stopped``: whether it was so when it was asked last. From that moment the process has ``GRACE_S`` of processor
    time, however long a busy machine takes to give it; ``is_spent`` tells that it is used up.
    """

    def __init__(self, time_limit_s: float | None = None, should_stop: Callable[[], bool] | None = None) -> None:
        self._deadline_s = None if time_limit_s is None else time.monotonic() + time_limit_s
        self._should_stop = should_stop
        self._asked_s = time.monotonic()
        self._used_s = 0.0  # processor time at the stop, and at the last tick at which it had grown
        self._grown_s, self._idle_ticks = 0.0, 0
        self.stopped = False

    def __call__(self) -> bool:
        """Whether to stop."""
        self._asked_s = time.monotonic()
        if not self.stopped and (self._is_late() or (self._should_stop is not None and self._should_stop())):
            self.stop()
        return self.stopped

    def stop(self) -> None:
        """Stop from now on."""
        if not self.stopped:
            self._used_s = self._grown_s = time.process_time()
            self.stopped = True

    def is_spent(self) -> bool:
        """Whether what is left after the stop is used up; asked every ``TICK_S`` by who waits for the work.

        So it is, too, where the process has hardly used any for ``IDLE_S`` of such ticks.
        """
        if not self.stopped:
            if self._is_late() or time.monotonic() - self._asked_s > UNASKED_S:
                self()
            return False
        used_s = time.process_time()
        self._idle_ticks += 1
        if used_s - self._grown_s > HARDLY_S:
            self._grown_s, self._idle_ticks = used_s, 0
        return used_s - self._used_s > GRACE_S or self._idle_ticks * TICK_S > IDLE_S

    def _is_late(self) -> bool:
        return self._deadline_s is not None and time.monotonic() >= self._deadline_s


def put_off(should_stop: Callable[[], bool], by_s: float) -> Callable[[], bool]:
    """The same, but by so much processor time later: for work without which there is nothing to stop with."""
    since_s: list[float] = []

    def should_stop_later() -> bool:
        if not should_stop():
            return False
        since_s[:] = since_s or [time.process_time()]
        return time.process_time() - since_s[0] >= by_s

    return should_stop_later


def require_going_on(should_stop: Callable[[], bool], goal: str) -> None:
    """NoPlanFound once the search is to stop, with what it had not come to."""
    if should_stop():
        raise NoPlanFound(f"the search was stopped before {goal}")


class WorkLeftError(BaseException):
    """Raised within work that nobody waits for any more: no ``except Exception`` on its way goes on with it."""


class OwnThread(Generic[Result]):
    """Work in a thread of its own, so that the one who waits hears signals and can leave it, whatever it does.

    Python hands out signals in the main thread alone, and not while that runs compiled code.
    """

    def __init__(self, work: Callable[[], Result]) -> None:
        self._work: Callable[[], Result] | None = work
        self._results: list[Result] = []
        self._error: BaseException | None = None
        self._done = threading.Event()
        self.is_left = False
        within = contextvars.copy_context()  # numpy's handling of floating-point errors is a part of it
        self._thread = threading.Thread(target=within.run, args=(self._run,), name="rota work", daemon=True)

    def do_work(self) -> Result:
        """Do the work; what it gives or raises. It is left by who is interrupted while waiting."""
        self.result(lambda: False)
        return self._results[0]

    def result(self, is_over: Callable[[], bool]) -> Result | None:
        """The same; None once ``is_over``, which is asked every ``TICK_S``: it is left then."""
        self._thread.start()
        try:
            while not self._done.wait(TICK_S):
                if is_over() and not self._done.is_set():
                    self._leave()
                    return None
        except BaseException:
            self._leave()
            raise
        if self._error is not None:
            error, self._error = self._error, None
            raise error
        return self._results[0]

    def require_awaited(self) -> None:
        """To be called by the work before it tells anybody anything: raises WorkLeftError once it is left."""
        if self.is_left:
            raise WorkLeftError

    def _leave(self) -> None:
        self.is_left = True
        _LEFT[:] = [*(thread for thread in _LEFT if thread.is_alive()), self._thread]

    def _run(self) -> None:
        work, self._work = self._work, None
        assert work is not None
        try:
            self._results.append(work())
        except BaseException as error:  # to be raised where it is waited for
            self._error = error
        finally:
            self._done.set()


_LEFT: list[threading.Thread] = []


def work_left_running() -> bool:
    """Whether a thread runs that was left: a program that ends as usual would wait for it, or fall over it."""
    return any(thread.is_alive() for thread in _LEFT)
