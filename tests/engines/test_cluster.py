"""A real scheduler with workers on loopback: one is killed half-way, one joins late, and nothing else changes.

Marked slow: each worker loads dask and the compiled loops, 5 s.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from tests.engines.calls import doubled, refuse
from tests.engines.loopback import WITHIN_S, Loopback, loopback
from tests.planners.patrol.searching import YARD, hasty_search_on
from tests.sweep.small_sweeps import write_sweep

from rota.check import check_plan
from rota.command.cli import run
from rota.engines import cluster as cluster_module
from rota.engines.workers import calls_at_once, workers
from rota.errors import RotaError
from rota.files.plan_file import plan_text, read_plan
from rota.files.sweep_file import read_sweep
from rota.planners.patrol.initial.allocation import period_groupings
from rota.planners.patrol.methods.fewest.team_size_plan import plan_with_team_size
from rota.sweep.cells import cells_of
from rota.sweep.results import Results
from rota.sweep.run import Standing, run_sweep

pytestmark = pytest.mark.slow


@pytest.fixture
def local(tmp_path: Path) -> Iterator[Loopback]:
    with loopback(tmp_path) as found:
        yield found


def wait_for_workers(executor: Executor, count: int) -> None:
    end_s = time.monotonic() + WITHIN_S
    while calls_at_once(executor) != count:
        assert time.monotonic() < end_s
        time.sleep(0.02)


class Killing(Executor):
    """A cluster's executor that kills a process when it is handed its third call, and begins another worker."""

    def __init__(self, inner: Any, local: Loopback, victim: int) -> None:
        self._client, self._inner, self._local, self._victim, self.calls = inner._client, inner, local, victim, 0

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = self._inner.submit(fn, *args, **kwargs)
        self.calls += 1
        if self.calls == 3:
            os.kill(self._victim, signal.SIGKILL)
            self._local.worker()
        return future


def test_a_cluster_finds_the_same_plan_though_a_worker_is_killed(local: Loopback) -> None:
    context = replace(hasty_search_on(YARD), judge=check_plan)
    groupings = period_groupings(context.problem, 4)
    alone = plan_with_team_size(context, groupings, 3, least_slack=1.0)
    victim = local.worker()
    local.worker()
    with workers(local.address) as executor:
        wait_for_workers(executor, 2)
        killing = Killing(executor, local, victim.pid)
        found = plan_with_team_size(replace(context, executor=killing), groupings, 3, least_slack=1.0)
    assert killing.calls > 6
    assert alone is not None
    assert found is not None
    assert plan_text(found.plan) == plan_text(alone.plan)


def test_a_sweep_loses_nothing_to_a_killed_worker_and_uses_a_late_one(local: Loopback, tmp_path: Path) -> None:
    cells = cells_of(read_sweep(write_sweep(tmp_path, seeds={"count": 24})))
    results = Results(tmp_path / "out")
    first, second = local.worker(), local.worker()
    late: list[int] = []
    with workers(local.address) as executor:
        wait_for_workers(executor, 2)

        def half_way(standing: Standing) -> None:
            if standing.finished >= 3 and not late:
                late.append(local.worker().pid)
                first.kill()
                first.wait()
                wait_for_workers(executor, 2)

        assert run_sweep("yards", cells, results, executor, tell=half_way), local.log()
    rows = results.rows(cells)
    assert [(row["seed"], row["outcome"]) for row in rows] == [(seed, "met") for seed in range(24)]
    assert {second.pid, late[0]} <= {row["process"] for row in rows} <= {first.pid, second.pid, late[0]}
    assert {check_plan(read_plan(results.folder / row["plan_file"])).verdict for row in rows[:3]} == {"met"}
    results.close()


def test_a_sweep_that_loses_its_scheduler_says_so_and_goes_on_elsewhere(local: Loopback, tmp_path: Path) -> None:
    cells = cells_of(read_sweep(write_sweep(tmp_path, seeds={"count": 40})))
    results = Results(tmp_path / "out")
    local.worker()

    def lose(standing: Standing) -> None:
        if standing.finished >= 2:
            local.end()

    with workers(local.address) as executor:
        wait_for_workers(executor, 1)
        with pytest.raises(RotaError, match="the connection to the cluster was lost"):
            run_sweep("yards", cells, results, executor, tell=lose)
    kept = [row["started_at"] for row in results.rows(cells)]
    assert 2 <= len(kept) < 40
    with workers(None, 1) as executor:
        assert run_sweep("yards", cells[:5], results, executor)
    assert [row["started_at"] for row in results.rows(cells)][: len(kept)] == kept
    results.close()


def test_a_cluster_without_workers_waits_and_one_of_another_version_is_refused(
    local: Loopback, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    with workers(local.address) as executor:
        assert calls_at_once(executor) == 0
        waiting = executor.submit(doubled, 4)
        local.worker()
        assert waiting.result(WITHIN_S) == 8
        with pytest.raises(ValueError, match="no such thing"):
            executor.submit(refuse, "no such thing").result(WITHIN_S)
    monkeypatch.setattr(cluster_module, "version", lambda _: "99")
    with (
        pytest.raises(RotaError, match=r"has rota .*; this is rota 99, and all must have the same"),
        workers(local.address),
    ):
        pass
    monkeypatch.undo()
    sweep = write_sweep(tmp_path)
    assert run(["sweep", str(sweep), "-o", str(tmp_path / "out"), "--cluster", local.address]) == 0
    assert "1 of 1" in capfd.readouterr().out
