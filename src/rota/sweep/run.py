"""The cells of a sweep handed to workers, in batches, and kept as they come back; every end is one to go on from."""

from __future__ import annotations

import pickle
import time
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from dataclasses import dataclass
from importlib.metadata import version

from rota.engines.workers import calls_at_once
from rota.errors import RotaError
from rota.sweep.cells import Cell
from rota.sweep.planned_cells import Planned, Task, planned_cells
from rota.sweep.results import Results

BATCH_S = 0.1  # a batch takes at least so long, where cells are known to be short
MOST_TOGETHER = 256  # cells of a batch
AHEAD = 2  # batches for each worker: one in work, one that waits there
POLL_S = 0.1
COUNT_EVERY_S = 1.0  # workers may join and leave
TABLE_EVERY_S = 60.0
DEATHS = ("WorkerDied", "KilledWorker")  # exceptions that say that workers ended, of processes and of dask


@dataclass(frozen=True, kw_only=True)
class Standing:
    """How far a sweep is: cells, those that are finished and how many of them have no plan that meets its demand.

    left_s: an estimate of the seconds that are left, from cells of the same combination and the workers there are;
    None while nothing is known. workers: calls that can be done side by side.
    """

    cells: int
    finished: int
    failed: int
    workers: int
    left_s: float | None


def run_sweep(
    name: str,
    cells: Sequence[Cell],
    results: Results,
    executor: Executor,
    *,
    retry: bool = False,
    first_alone: bool = False,
    tell: Callable[[Standing], None] = lambda standing: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> bool:
    """Plan the cells that the results lack, and keep each; whether all are finished then.

    name: of the sweep. retry: cells that crashed or were killed are planned again. first_alone: others begin when the
    first one is done, which compiles for all. should_stop: asked often; what is not finished then is left out.

    Raises RotaError when the connection to a cluster is lost.
    """
    run = _Run(name, cells, results, executor, retry=retry, first_alone=first_alone)
    told_s = written_s = time.monotonic()
    tell(run.standing())
    while run.goes_on and not should_stop():
        run.submit()
        run.collect()
        now_s = time.monotonic()
        if now_s - told_s >= POLL_S:
            tell(run.standing())
            told_s = now_s
        if now_s - written_s >= TABLE_EVERY_S:
            results.write_table(cells)
            written_s = time.monotonic()
    tell(run.standing())
    return not run.goes_on


class _Run:
    """The cells that are left, and those that workers have."""

    def __init__(
        self, name: str, cells: Sequence[Cell], results: Results, executor: Executor, *, retry: bool, first_alone: bool
    ) -> None:
        self._name, self._results, self._executor = name, results, executor
        self._cells, self._alone = len(cells), first_alone
        missing = [cell for cell in cells if not results.has(cell, retry=retry)]
        refused = [cell for cell in missing if cell.combination.mission is None]
        results.keep([(cell, _failure("refused", str(cell.combination.refused))) for cell in refused], name)
        self._left = deque(cell for cell in missing if cell.combination.mission is not None)
        self._running: dict[Future[list[Planned]], list[Cell]] = {}
        self._pace = _Pace([cell for cell in cells if results.has(cell)], results)
        self._failed = sum(not row["met"] for row in results.rows(cells))
        self._workers, self._counted_s = calls_at_once(executor), time.monotonic()

    @property
    def goes_on(self) -> bool:
        """Whether cells are left."""
        return bool(self._left or self._running)

    def submit(self) -> None:
        """Hand cells out until every worker has some, and some that wait."""
        now_s = time.monotonic()
        if now_s - self._counted_s > COUNT_EVERY_S:
            self._workers, self._counted_s = calls_at_once(self._executor), now_s
        most = 1 if self._alone else max(1, AHEAD * self._workers)
        while self._left and len(self._running) < most:
            batch = [self._left.popleft()]
            seconds = self._pace.seconds(batch[0])
            while self._left and seconds < BATCH_S and len(batch) < MOST_TOGETHER:
                batch.append(self._left.popleft())
                seconds += self._pace.seconds(batch[-1])
            self._hand_out(batch)

    def _hand_out(self, batch: list[Cell]) -> None:
        tasks = [Task(cell.combination.mission, cell.seed, cell.time_limit_s) for cell in batch]  # type: ignore[arg-type]
        self._running[self._executor.submit(_plan_all, pickle.dumps(tasks), version("rota"))] = batch

    def collect(self) -> None:
        """Keep what came back, after a moment at most."""
        ready, _ = wait(self._running, timeout=POLL_S, return_when=FIRST_COMPLETED)
        done: list[tuple[Cell, Planned]] = []
        for future in ready:
            done += self._outcomes(future, self._running.pop(future))
        if not done:
            return
        self._alone = False
        self._results.keep(done, self._name)
        for cell, planned in done:
            self._failed += planned.row["outcome"] != "met"
            self._pace.note(cell, planned.row.get("wall_s"))

    def _outcomes(self, future: Future[list[Planned]], batch: list[Cell]) -> list[tuple[Cell, Planned]]:
        """What became of a batch. One that no worker survived is handed out again, each cell by itself."""
        try:
            return list(zip(batch, future.result(), strict=True))
        except CancelledError:
            raise RotaError("the connection to the cluster was lost") from None
        except Exception as error:
            if len(batch) > 1:
                for cell in batch:
                    self._hand_out([cell])
                return []
            outcome = "killed" if type(error).__name__ in DEATHS else "crashed"
            return [(batch[0], _failure(outcome, f"{type(error).__name__}: {error}"))]

    def standing(self) -> Standing:
        """How far it is."""
        running = [cell for batch in self._running.values() for cell in batch]
        left_s = self._pace.sum_s([*self._left, *running])
        return Standing(
            cells=self._cells, finished=self._cells - len(self._left) - len(running), failed=self._failed,
            workers=self._workers, left_s=None if left_s is None else left_s / max(1, self._workers),
        )  # fmt: skip


class _Pace:
    """How long cells take, by what others of their combination took."""

    def __init__(self, finished: Sequence[Cell], results: Results) -> None:
        self._sums_s: defaultdict[int, float] = defaultdict(float)
        self._counts: Counter[int] = Counter()
        self._all_s, self._all = 0.0, 0
        for cell, row in zip(finished, results.rows(finished), strict=True):
            self.note(cell, row.get("wall_s"))

    def note(self, cell: Cell, seconds: float | None) -> None:
        """Learn from a cell that is finished; seconds: None where that says nothing."""
        if seconds is None:
            return
        self._sums_s[id(cell.combination)] += seconds
        self._counts[id(cell.combination)] += 1
        self._all_s, self._all = self._all_s + seconds, self._all + 1

    def seconds(self, cell: Cell) -> float:
        """How long the cell is likely to take; inf while nothing is known."""
        count = self._counts[id(cell.combination)]
        if count:
            return self._sums_s[id(cell.combination)] / count
        return self._all_s / self._all if self._all else float("inf")

    def sum_s(self, cells: Sequence[Cell]) -> float | None:
        """How long the cells are likely to take one after another; None while nothing is known."""
        return sum(self.seconds(cell) for cell in cells) if self._all else None


def _plan_all(tasks: bytes, rota_version: str) -> list[Planned]:
    return planned_cells(pickle.loads(tasks), rota_version)


def _failure(outcome: str, reason: str) -> Planned:
    """The outcome of a cell that no worker told anything of."""
    return Planned({"outcome": outcome, "reason": reason, "rota_version": version("rota")}, None)
