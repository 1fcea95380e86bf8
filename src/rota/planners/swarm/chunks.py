"""A swarm's robots in parts that several threads work on."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")
PER_THREAD = 4  # so that a thread with an easy part takes another one
TRY_AGAIN = 200  # runs after which what has been slower is tried once more
NEWEST = 0.2  # weight of the newest run in the mean time


class Chunks:
    """Robots 0 to n - 1 in parts, which threads take one after the other; the calling thread is one of them.

    It works alone as long as that is faster: where there is little to do, or other programs have the other cores, it
    would wait for the others to wake. fewest: so many robots are worth a part of their own. What becomes of a robot
    must not depend on its part.
    """

    def __init__(self, n: int, threads: int, fewest: int) -> None:
        parts = max(min(PER_THREAD * threads, n // fewest), 1) if threads > 1 else 1
        self._bounds = [(n * k // parts, n * (k + 1) // parts) for k in range(parts)]
        self._helpers = min(threads, parts) - 1
        self._pool = ThreadPoolExecutor(self._helpers) if self._helpers > 0 else None
        self._runs, self._mean_s = 0, [0.0, 0.0]  # of runs alone and of shared ones; 0: none yet

    def __len__(self) -> int:
        return len(self._bounds)

    def run(self, job: Callable[[int, int, int], T]) -> list[T]:
        """What job(begin, end, part) returns for the robots begin to end - 1 of each part, in the order of the parts.

        Raises what a job raises.
        """
        shared = self._pool is not None and self._mean_s[1] <= self._mean_s[0]
        trial = self._pool is not None and self._runs % TRY_AGAIN == TRY_AGAIN - 1
        shared = shared != trial
        began_s = time.perf_counter()
        results = self._share(job) if shared else [job(*bounds, k) for k, bounds in enumerate(self._bounds)]
        took_s, before_s = time.perf_counter() - began_s, self._mean_s[shared]
        self._mean_s[shared] = took_s if before_s == 0 or trial else before_s + NEWEST * (took_s - before_s)
        self._runs += 1
        return results

    def _share(self, job: Callable[[int, int, int], T]) -> list[T]:
        """Likewise, on all threads."""
        assert self._pool is not None
        waiting = iter(enumerate(self._bounds))  # one thread at a time takes from it

        def work() -> list[tuple[int, T]]:
            return [(part, job(*bounds, part)) for part, bounds in waiting]

        helping = [self._pool.submit(work) for _ in range(self._helpers)]
        done = work() + [found for helper in helping for found in helper.result()]
        return [result for _, result in sorted(done, key=lambda found: found[0])]
