"""What the command line tells people while it works: messages on stderr and, on a terminal only, a progress bar."""

from __future__ import annotations

import logging
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeElapsedColumn
from rich.text import Text

from rota.model.refusals import escape
from rota.planning.planner import about
from rota.planning.progress import SteadyProgress

if TYPE_CHECKING:
    from rota.check.report import Report
    from rota.model.plan import Plan

STANDARD_STREAM = "-"  # stands for standard input or output where a file is asked for


def say(message: str) -> None:
    """A message of one line on stderr, under the program's name.

    Paths and what robots answer may hold anything: what would steer the terminal or begin a line is escaped.
    """
    print(f"rota: {escape(message)}", file=sys.stderr, flush=True)


class TimeLeft(ProgressColumn):
    """About how long it takes yet, as far as the share done tells."""

    def render(self, task: Task) -> Text:
        """The column of a task now."""
        left_s = task.fields["steady"].left_s(task.elapsed or 0.0)
        return Text("" if left_s is None else f"about {about(max(10 * round(left_s / 10), 10))} left")


class Bar:
    """Progress for people: on a terminal only."""

    def __init__(self, progress: Progress | None, clock: Callable[[], float] = time.monotonic) -> None:
        self._progress = progress
        self._clock, self._began_s = clock, clock()
        self._steady = SteadyProgress()
        self._task = None if progress is None else progress.add_task("planning", total=1.0, steady=self._steady)

    def show(self, fraction: float, doing: str) -> None:
        """What the planner calls; the share that is shown never falls."""
        if self._progress is not None and self._task is not None:
            share = self._steady.tell(fraction, self._clock() - self._began_s)
            self._progress.update(self._task, completed=share, description=doing)

    def show_better(self, plan: Plan, report: Report) -> None:
        """A plan that is better than all before it: its robots and the seconds until it was found, above the bar.

        Only plans that the check passes are shown, and only where the number of robots is what is looked for.
        """
        if self._progress is not None and report.verdict == "met" and plan.mission.fleet.robots is None:
            found_s, robots = self._clock() - self._began_s, len(plan.trajectories)
            self._progress.console.print(f"{found_s:7.1f} s  {robots} robot{'s' * (robots != 1)}", highlight=False)

    def announce_stop(self, by: str, outcome: str = "with the best plan so far") -> None:
        """What the first Ctrl-C or SIGTERM, ``by``, calls; ``outcome``: what there will be of the work."""
        if self._progress is not None:
            self._progress.stop()  # gives the terminal its cursor back before a second one could
        say(f"stopping {outcome}; {by} again ends at once")


@contextmanager
def progress_bar() -> Iterator[Bar]:
    """A progress bar on stderr that is gone when the work is done; where stderr is no terminal it shows nothing."""
    if not sys.stderr.isatty():
        yield Bar(None)
        return
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn(), TimeLeft())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        yield Bar(progress)


class Saying(logging.Handler):
    """What is logged, said on stderr."""

    def emit(self, record: logging.LogRecord) -> None:
        """Say it."""
        say(record.getMessage())


logging.getLogger("rota.compiled").addHandler(Saying())

READING_S_PER_MB, LONG_READING_S = 7.0, 15.0  # measured with files of 50,000 corners


def reading_ahead(path: Path) -> str | None:
    """What to say before a mission file is read; None where that takes seconds only, or there is no such file."""
    size = os.path.getsize(path) if path.is_file() else 0
    seconds = READING_S_PER_MB * size / 1e6
    return f"reading {path}, {size / 1e6:.1f} MB: about {about(seconds)}" if seconds > LONG_READING_S else None
