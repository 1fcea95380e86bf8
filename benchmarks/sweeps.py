"""What handing work to others costs, and what it gains: sweeps in processes, and one search on a dask cluster."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from tests.engines.loopback import loopback
from tests.sweep.small_sweeps import write_sweep

from benchmarks.missions import EXAMPLES
from benchmarks.row import Options, Row
from rota.engines.workers import calls_at_once, workers
from rota.files.mission_file import read_mission
from rota.files.plan_file import plan_text
from rota.files.sweep_file import read_sweep
from rota.planning.make_plan import search_plan
from rota.sweep.cells import Cell, cells_of
from rota.sweep.results import Results
from rota.sweep.run import run_sweep

FIG13 = EXAMPLES / "sun2019-fig13.yaml"
SHORT, LONG = 200, 12  # cells of a tenth of a second, and of some seconds


def sweeps(options: Options) -> Iterator[Row]:
    """What a cell costs beside its plan, and two processes beside one."""
    yield _cost_of_a_cell(options.folder)
    long = _cells(options.folder, LONG, {"patrol.method": ["tours"], "fleet.sensor.radius_m": [2.5]})
    walls_s = [_swept(options.folder / f"of-{processes}", long, processes)[0] for processes in (1, 2)]
    measured = f"{walls_s[0]:.1f} s with one, {walls_s[1]:.1f} s with two: {walls_s[0] / walls_s[1]:.2f} times as fast"
    yield Row(f"rota sweep, {LONG} plans of some seconds, two processes", "sooner", measured, walls_s[1] < walls_s[0])


def _cost_of_a_cell(folder: Path) -> Row:
    wall_s, cpu_s, own_s = _swept(folder / "short", _cells(folder, SHORT, {}), 1)
    measured = (
        f"{1e3 * (wall_s - own_s) / SHORT:.1f} ms beside {1e3 * own_s / SHORT:.0f} ms of planning and checking; "
        f"CPU of the program itself {1e3 * cpu_s / SHORT:.1f} ms"
    )
    return Row(f"rota sweep, cost of a cell, {SHORT} short ones", "< 10 ms", measured, wall_s - own_s < 0.01 * SHORT)


def _cells(folder: Path, count: int, settings: dict[str, list[object]]) -> list[Cell]:
    return cells_of(read_sweep(write_sweep(folder, seeds={"count": count}, settings=settings)))


def _swept(folder: Path, cells: list[Cell], processes: int) -> tuple[float, float, float]:
    """Wall and CPU seconds of this process, and those that plans and checks took, with loops that are loaded."""
    with workers(None, processes) as executor:
        for name, some in (("first", cells[:processes]), ("all", cells)):
            results = Results(folder.with_name(f"{folder.name}-{name}"))
            wall_s, cpu_s = time.perf_counter(), time.process_time()
            run_sweep("benchmark", some, results, executor)
            wall_s, cpu_s = time.perf_counter() - wall_s, time.process_time() - cpu_s
            rows = results.rows(some)
            results.close()
            if not all(row["met"] for row in rows):
                raise RuntimeError(f"not met: {[row['reason'] for row in rows if not row['met']]}")
    return wall_s, cpu_s, sum(row["wall_s"] + row["check_s"] for row in rows)


def plan_on_cluster(options: Options) -> Iterator[Row]:
    """One search here, and on one and on two workers of a scheduler on loopback: the same plan, sooner."""
    mission = read_mission(FIG13).mission.with_effort(options.effort)
    with ExitStack() as stack:
        local = stack.enter_context(loopback(options.folder))
        texts, walls_s, own_s = [], [], []
        for count in (0, 1, 2):
            executor = None
            if count:
                local.worker()
                executor = stack.enter_context(workers(local.address))
                while calls_at_once(executor) < count:
                    time.sleep(0.1)
            search_plan(mission.with_effort("quick"), executor=executor)  # loads compiled loops everywhere
            began_s, cpu_s = time.perf_counter(), time.process_time()
            texts.append(plan_text(search_plan(mission, executor=executor).plan))
            walls_s.append(time.perf_counter() - began_s)
            own_s.append(time.process_time() - cpu_s)
    same = len(set(texts)) == 1
    measured = (
        f"{walls_s[0]:.0f} s on two threads here, {walls_s[1]:.0f} s on one worker, {walls_s[2]:.0f} s on two; "
        f"CPU of this process {own_s[0]:.1f}, {own_s[1]:.1f} and {own_s[2]:.1f} s; "
        f"{'the same plan' if same else 'other plans'}"
    )
    what = f"sun2019-fig13, {options.effort}, --cluster with workers of one thread on this machine"
    yield Row(what, "the same plan, two sooner than one", measured, same and walls_s[2] < walls_s[1])
