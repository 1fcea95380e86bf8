"""A race of annealed tours through repairs: the winner passes after the fewest of them."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import TypeVar

from rota.planners.patrol.annealing.search import Annealed
from rota.planners.patrol.context import Context
from rota.planners.patrol.methods.anneal_and_repair import anneal_and_repair
from rota.planners.patrol.repair.repair import Repaired

Result = TypeVar("Result")
Runner = Callable[[Callable[[], bool]], Iterator[Result | None]]


def first_to_pass(context: Context, searches: list[Annealed], *, seed: int) -> Repaired | None:
    """The plan of the search that passes after the fewest repairs, the first of several; None when none passes."""

    def repairs(turn: int, should_stop: Callable[[], bool]) -> Iterator[Repaired | None]:
        return anneal_and_repair(replace(context, should_stop=should_stop), searches[turn], seed=seed + 100 * turn)

    runners = [partial(repairs, turn) for turn in range(len(searches))]
    return race(runners, context.should_stop, threads=context.threads)


def race(
    runners: Sequence[Runner[Result]], should_stop: Callable[[], bool], *, threads: int | None = None
) -> Result | None:
    """The result of the runner that has one after the fewest tries, the first of several; None when none has one.

    A runner is given what tells it to stop, and yields None after every try that failed, or its result at last. It is
    stopped once another is ahead of it for good, so that the answer is the same on any number of threads (None: one for
    each core).
    """
    passed_after: list[float] = [math.inf] * len(runners)

    def run(turn: int) -> Result | None:
        """The result of one runner; None, too, when another is ahead of it for good."""
        tries = 0

        def beaten() -> bool:
            return any((after, other) < (tries, turn) for other, after in enumerate(passed_after))

        for result in runners[turn](lambda: should_stop() or beaten()):
            if result is not None:
                passed_after[turn] = tries
                return result
            tries += 1
        return None

    with ThreadPoolExecutor(max_workers=threads or os.cpu_count()) as pool:
        results = list(pool.map(run, range(len(runners))))
    return min(zip(passed_after, results, strict=True), key=lambda pair: pair[0], default=(math.inf, None))[1]
