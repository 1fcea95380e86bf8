"""Cells come back once each whatever is killed, and go out in batches once they are known to be short."""

from __future__ import annotations

import os
import pickle
import signal
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor, Future
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from tests.sweep.small_sweeps import write_sweep

from rota.check import check_plan
from rota.engines.processes import LocalProcesses
from rota.engines.workers import workers
from rota.errors import NoPlanFound, RotaError
from rota.files.plan_file import read_plan
from rota.files.sweep_file import read_sweep
from rota.sweep import planned_cells
from rota.sweep.cells import Cell, cells_of
from rota.sweep.planned_cells import Planned, Task
from rota.sweep.results import Results
from rota.sweep.run import AHEAD, Standing, run_sweep


class Here(Executor):
    """Does calls in this process, as soon as they come; notes how many cells each is for."""

    def __init__(self, fails: dict[int, list[Exception]] | None = None, wall_s: float = 0.01) -> None:
        self.batches: list[list[int]] = []
        self._fails, self._wall_s = fails or {}, wall_s

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        tasks: list[Task] = pickle.loads(args[0])
        seeds = [task.seed for task in tasks]
        self.batches.append(seeds)
        future: Future[Any] = Future()
        errors = [error for seed in seeds for error in self._fails.get(seed, [])[:1]]
        if errors:
            for seed in seeds:
                self._fails.get(seed, [])[:1] = []
            future.set_exception(errors[0])
        else:
            future.set_result([Planned({"outcome": "met", "wall_s": self._wall_s}, None) for _ in seeds])
        return future


class KilledWorker(Exception):  # noqa: N818
    """Has the name of what dask raises."""


@pytest.fixture
def results(tmp_path: Path) -> Iterator[Results]:
    found = Results(tmp_path / "out")
    yield found
    found.close()


def cells_with(folder: Path, count: int, **values: Any) -> list[Cell]:
    return cells_of(read_sweep(write_sweep(folder, seeds={"count": count}, **values)))


def test_short_cells_go_out_together(tmp_path: Path, results: Results) -> None:
    cells, here = cells_with(tmp_path, 400), Here(wall_s=0.01)
    told: list[Standing] = []
    assert run_sweep("yards", cells, results, here, tell=told.append)
    sizes = [len(batch) for batch in here.batches]
    first = AHEAD * (os.cpu_count() or 1)
    assert sizes[:first] == [1] * first  # nothing is known yet
    assert set(sizes[first:-1]) <= {10, 11}  # 100 ms
    assert sorted(seed for batch in here.batches for seed in batch) == list(range(400))
    assert (told[0].finished, told[-1].finished, told[-1].cells, told[-1].left_s) == (0, 400, 400, 0)


def test_long_cells_go_out_alone(tmp_path: Path, results: Results) -> None:
    here = Here(wall_s=3.0)
    run_sweep("yards", cells_with(tmp_path, 12), results, here)
    assert [len(batch) for batch in here.batches] == [1] * 12


def test_a_batch_that_no_worker_survives_costs_its_culprit_only(tmp_path: Path, results: Results) -> None:
    cells = cells_with(tmp_path, 100)
    here = Here({50: [KilledWorker("three died"), KilledWorker("three died")], 70: [ValueError("x"), ValueError("x")]})
    run_sweep("yards", cells, results, here)
    rows = results.rows(cells)
    assert Counter(row["outcome"] for row in rows) == {"met": 98, "killed": 1, "crashed": 1}
    assert (rows[50]["reason"], rows[70]["reason"]) == ("KilledWorker: three died", "ValueError: x")
    again = Here()
    run_sweep("yards", cells, results, again)
    assert again.batches == []
    run_sweep("yards", cells, results, again, retry=True)
    assert sorted(seed for batch in again.batches for seed in batch) == [50, 70]


def test_a_cluster_that_is_lost_ends_the_sweep(tmp_path: Path, results: Results) -> None:
    cells = cells_with(tmp_path, 40)
    with pytest.raises(RotaError, match="the connection to the cluster was lost"):
        run_sweep("yards", cells, results, Here({30: [CancelledError()]}))
    assert 0 < len(results.rows(cells)) < 40


def test_a_stopped_sweep_keeps_what_is_finished_and_goes_on_from_there(tmp_path: Path, results: Results) -> None:
    cells, first, second = cells_with(tmp_path, 30), Here(wall_s=1.0), Here(wall_s=1.0)
    whole = run_sweep("yards", cells, results, first, should_stop=lambda: len(results.rows(cells)) >= 8)
    assert not whole
    kept = [row["seed"] for row in results.rows(cells)]
    assert run_sweep("yards", cells, results, second)
    assert sorted(kept + [seed for batch in second.batches for seed in batch]) == list(range(30))


def test_the_first_cell_may_go_alone(tmp_path: Path, results: Results) -> None:
    here = Here(wall_s=1.0)
    seen: list[int] = []
    run_sweep(
        "yards", cells_with(tmp_path, 5), results, here, first_alone=True,
        tell=lambda standing: seen.append(len(here.batches)), should_stop=lambda: len(here.batches) == 1,
    )  # fmt: skip
    assert here.batches == [[0]]


def test_refused_missions_are_rows(tmp_path: Path, results: Results) -> None:
    cells = cells_with(tmp_path, 2, settings={"fleet.speed_m_s": [4, -1]})
    run_sweep("yards", cells, results, Here())
    rows = results.rows(cells)
    assert [row["outcome"] for row in rows] == ["met", "met", "refused", "refused"]
    assert "fleet.speed_m_s: -1 is not allowed" in rows[2]["reason"]


@pytest.mark.parametrize(
    ("error", "outcome", "reason"),
    [
        (NoPlanFound("too few"), "no plan", "too few"),
        (RotaError("not that"), "refused", "not that"),
        (MemoryError(), "crashed", "MemoryError in search_plan"),
        (ZeroDivisionError("by 0"), "crashed", "ZeroDivisionError in search_plan"),
    ],
)
def test_whatever_goes_wrong_is_a_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception, outcome: str, reason: str
) -> None:
    def search_plan(*_: Any, **__: Any) -> None:
        raise error

    monkeypatch.setattr(import_module("rota.planning.make_plan"), "search_plan", search_plan)
    mission = cells_with(tmp_path, 1)[0].combination.mission
    assert mission is not None
    (planned,) = planned_cells.planned_cells([Task(mission, 0, None)], planned_cells.version("rota"))
    assert planned.row["outcome"] == outcome
    assert planned.row["reason"].startswith(reason)
    assert planned.plan_text is None


def test_another_version_plans_nothing(tmp_path: Path) -> None:
    mission = cells_with(tmp_path, 1)[0].combination.mission
    assert mission is not None
    (planned,) = planned_cells.planned_cells([Task(mission, 0, None)], "99")
    assert planned.row["outcome"] == "crashed"
    assert "the sweep's is 99" in planned.row["reason"]


@pytest.mark.slow  # three processes that load the compiled loops: 10 s
def test_a_killed_worker_costs_nothing_but_time(tmp_path: Path, results: Results) -> None:
    cells = cells_with(tmp_path, 6)
    killed: list[int] = []
    with workers(None, 2) as executor:
        assert isinstance(executor, LocalProcesses)

        def kill_once(standing: Standing) -> None:
            if standing.finished >= 2 and not killed:
                killed.append(executor.pids[0])
                os.kill(killed[0], signal.SIGKILL)

        assert run_sweep("yards", cells, results, executor, tell=kill_once)
    assert len(killed) == 1
    rows = results.rows(cells)
    assert [row["seed"] for row in rows] == list(range(6))
    for row in rows:
        assert (row["outcome"], row["verdict"]) == ("met", "met")
        plan = read_plan(results.folder / row["plan_file"])
        assert (check_plan(plan).verdict, len(plan.trajectories), plan.seed) == ("met", row["robots"], row["seed"])
        assert 20 < row["peak_memory_mb"] < 4000
        assert row["cpu_s"] > 0 < row["wall_s"]
