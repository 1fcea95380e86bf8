"""Tests shared out among copies of the process that has collected them: ``pytest --copies auto``.

To import all and to collect the tests takes 7 s of the processor, and 20 s where nothing of them is compiled yet;
workers that are interpreters of their own each do so. Copies share what was loaded, and the process that programs of
tests are copied from (``tests/warm_process.py``).
"""

from __future__ import annotations

import atexit
import contextlib
import os
import pickle
import signal
import sys
import traceback
import warnings
from collections import deque
from itertools import pairwise
from multiprocessing import Pipe, connection
from typing import Any, NoReturn

import pytest

MOST_DEATHS = 5  # of copies: then whatever ends them is at fault, not a test


class Copy:
    """A copy of this process as the first one sees it: the tests that are to be its own, and those it was told of."""

    def __init__(self, span: deque[int]) -> None:
        self.span = span
        self.told: deque[int | None] = deque()  # it runs the first of them; None: there are no more
        self.line: connection.Connection
        self.pid = 0

    def tell(self, others: list[Copy]) -> None:
        """Tell it of one more test: of its own, else of the second half of the most that another one has left."""
        if not self.span:
            longest = max(others, key=lambda copy: len(copy.span)).span
            self.span = deque(longest.pop() for _ in range((len(longest) + 1) // 2))
            self.span.reverse()
        if None not in self.told:
            self.told.append(self.span.popleft() if self.span else None)
            with contextlib.suppress(OSError):  # of one that has ended, what its line tells next
                self.line.send(self.told[-1])


def copies_asked_for(config: pytest.Config) -> int:
    """How many copies share the tests, 0: none; two more than cores unless a number is given.

    Robots that go by real time, and browsers, keep processes waiting.
    """
    asked = config.getoption("--copies", default=None)
    return (os.cpu_count() or 1) + 2 if asked == "auto" else int(asked or 0)


def share_out(session: pytest.Session) -> None:
    """Have copies of this process run the collected tests, and tell of them here as they are run."""
    count = min(copies_asked_for(session.config), len(session.items))
    ends = [len(session.items) * k // count for k in range(count + 1)]
    copies = [Copy(deque(range(*span))) for span in pairwise(ends)]
    deaths = 0
    try:
        for copy in copies:
            begin(copy, copies, session)
        while at_work := {copy.line: copy for copy in copies if not copy.line.closed}:
            for line in connection.wait(list(at_work)):
                copy = at_work[line]
                try:
                    heard = copy.line.recv()
                except EOFError:
                    if lost := end(copy, session):
                        deaths += 1
                        copy.span.extendleft(reversed(lost))
                        if deaths < MOST_DEATHS:
                            begin(copy, copies, session)
                else:
                    hear(heard, session)
                    if heard[0] == "pytest_runtest_logfinish":
                        copy.told.popleft()
                        copy.tell(copies)
            if session.shouldfail:
                raise session.Failed(session.shouldfail)
            if session.shouldstop:
                raise session.Interrupted(session.shouldstop)
        if any(copy.span for copy in copies):
            raise session.Interrupted(f"{deaths} processes of tests ended")
    finally:
        for copy in copies:
            if copy.pid and not copy.line.closed:
                copy.line.close()  # it ends after its test
                os.waitpid(copy.pid, 0)


def begin(copy: Copy, copies: list[Copy], session: pytest.Session) -> None:
    """Begin a copy, and tell it of two tests: it tears down what the second one does not need."""
    copy.line, there = Pipe()
    sys.stdout.flush()
    sys.stderr.flush()
    copy.pid = os.fork()
    if not copy.pid:
        for other in copies:
            if other.pid or other is copy:
                other.line.close()
        become_copy(there, session)
    there.close()
    copy.told.clear()
    for _ in range(2):
        copy.tell(copies)


def end(copy: Copy, session: pytest.Session) -> list[int]:
    """Wait for a copy that has ended; where it was not to end yet, its test has failed, and the next one is lost."""
    copy.line.close()
    _, status = os.waitpid(copy.pid, 0)
    if copy.told == deque([None]):
        return []
    code = os.waitstatus_to_exitcode(status)
    why = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    if (first := copy.told[0]) is None:
        raise session.Interrupted(f"a process of tests ended after its last one: {why}")
    item = session.items[first]
    report = pytest.TestReport(
        item.nodeid, item.location, dict.fromkeys(item.keywords, 1), "failed", f"its process ended: {why}", "call"
    )
    session.config.hook.pytest_runtest_logreport(report=report)
    return [index for index in list(copy.told)[1:] if index is not None]


def hear(heard: tuple[str, dict[str, Any]], session: pytest.Session) -> None:
    """Tell the plugins here what those of a copy were told."""
    name, told = heard
    hooks = session.config.hook
    if name == "pytest_runtest_logreport":
        report = hooks.pytest_report_from_serializable(config=session.config, data=told["report"])
        hooks.pytest_runtest_logreport(report=report)
    elif name == "pytest_warning_recorded":
        hooks.pytest_warning_recorded.call_historic(kwargs=told)
    else:
        getattr(hooks, name)(**told)


def become_copy(line: connection.Connection, session: pytest.Session) -> NoReturn:
    """Run the tests that the line tells of, until it tells of no more or is closed; then end."""
    code = 1
    try:
        atexit._clear()  # what ends with the first process
        plugins = session.config.pluginmanager
        plugins.unregister(name="terminalreporter")
        plugins.register(Telling(line, session.config))
        capture = plugins.getplugin("capturemanager")  # whose files are shared with the other copies
        capture.stop_global_capturing()
        capture.start_global_capturing()
        capture.suspend_global_capture()
        with contextlib.suppress(EOFError, ConnectionError, KeyboardInterrupt):
            index = line.recv()
            while index is not None:
                then = line.recv()
                after = None if then is None else session.items[then]
                item = session.items[index]
                item.config.hook.pytest_runtest_protocol(item=item, nextitem=after)
                index = then
            code = 0
        session._setupstate.teardown_exact(None)  # of fixtures, where it ends early
        atexit._run_exitfuncs()
    except BaseException:
        traceback.print_exc()
        code = 1
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


class Telling:
    """A plugin that tells the first process what the plugins of a copy are told."""

    def __init__(self, line: connection.Connection, config: pytest.Config) -> None:
        self._line, self._config = line, config

    def pytest_runtest_logstart(self, nodeid: str, location: tuple[str, int | None, str]) -> None:
        self._line.send(("pytest_runtest_logstart", {"nodeid": nodeid, "location": location}))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        told = self._config.hook.pytest_report_to_serializable(config=self._config, report=report)
        self._line.send(("pytest_runtest_logreport", {"report": told}))

    def pytest_runtest_logfinish(self, nodeid: str, location: tuple[str, int | None, str]) -> None:
        self._line.send(("pytest_runtest_logfinish", {"nodeid": nodeid, "location": location}))

    def pytest_warning_recorded(
        self, warning_message: warnings.WarningMessage, when: str, nodeid: str, location: tuple[str, int, str] | None
    ) -> None:
        message = warning_message.message
        try:
            pickle.loads(pickle.dumps(message))
        except Exception:  # of a class that pickle cannot make again
            message = UserWarning(f"{type(message).__name__}: {message}")
        plain = warnings.WarningMessage(message, type(message), warning_message.filename, warning_message.lineno)
        told = {"warning_message": plain, "when": when, "nodeid": nodeid, "location": location}
        self._line.send(("pytest_warning_recorded", told))
