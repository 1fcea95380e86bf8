"""Better loops of the best plan so far, looked for while the search goes on for one with fewer robots.

That search fails in the end, and mostly at once. The loops are ready then. Those of a plan that was not the last are
given up.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from types import TracebackType

from rota.planners.patrol.context import Context, silent
from rota.planners.patrol.repair.repair import Repaired
from rota.planners.patrol.shortening.search import with_better_loops


@dataclass
class _Work:
    """The loops of one plan in the making."""

    plan: Repaired
    future: Future[Repaired]
    given_up: bool = False


class LoopsAhead:
    """One thread that looks for the better loops of the plan told last; a context manager, whose end ends the thread.

    What it finds is what ``with_better_loops`` finds: the search that goes on meanwhile changes nothing of it. A
    machine of one core has nothing to gain, and looks for them when they are asked for.
    """

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(max_workers=1)
        self._work: _Work | None = None

    def __enter__(self) -> LoopsAhead:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._give_up()
        self._pool.shutdown()

    def begin(self, context: Context, plan: Repaired) -> None:
        """Look for better loops of this plan instead of any other's, with the context that they are asked with later.

        A plan that does not pass gets none.
        """
        if not plan.met or (os.cpu_count() or 1) == 1 or self._works_on(plan):
            return
        self._give_up()
        work = _Work(plan, Future())
        own = replace(context, progress=silent, should_stop=_stopped(context, work))
        work.future = self._pool.submit(with_better_loops, own, plan)
        self._work = work

    def of(self, context: Context, plan: Repaired) -> Repaired:
        """``with_better_loops`` of the plan: what was begun, or else found now."""
        if self._work is None or not self._works_on(plan):
            self._give_up()
            return with_better_loops(context, plan)
        context.progress(0.91, "looking for shorter loops")
        better = self._work.future.result()
        return plan if better is self._work.plan else better

    def _works_on(self, plan: Repaired) -> bool:
        """Whether these tours are looked at; the plan may be for the same mission with another effort by now."""
        return self._work is not None and self._work.plan.tours is plan.tours

    def _give_up(self) -> None:
        if self._work is not None:
            self._work.given_up = True


def _stopped(context: Context, work: _Work) -> Callable[[], bool]:
    """Whether to stop the work: it is given up, or the whole search is to stop."""
    return lambda: work.given_up or context.should_stop()
