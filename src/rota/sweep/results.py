"""The folder of a sweep's results: finished cells, their plan files, and the table made of them.

``finished.jsonl`` has a line for each finished cell, brought to the disk before the next ones. The table and what is
drawn from it can be made again at any time.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from rota.errors import RotaError
from rota.files.atomic_write import replaced_file, require_writable_folder, write_atomically
from rota.files.sole_user import SoleUser
from rota.sweep.cells import Cell
from rota.sweep.planned_cells import Planned, Row

JOURNAL, TABLE, PLANS = "finished.jsonl", "results.parquet", "plans"
IN_USE = "another rota sweep writes here; wait for it, or give another -o"
AGAIN = ("crashed", "killed")  # outcomes that another try may change

# the columns of the table in their order; fields of missions that the sweep sets follow "seed"
TEXTS = ["key", "sweep", "mission", "mission_file", "planner", "method", "effort"]
REST = {
    "time_limit_s": float, "outcome": str, "met": bool, "verdict": str, "stopped_early": bool, "reason": str,
    "robots": int, "lower_bound_robots": int, "lower_bound_reason": str, "worst_gap_ratio": float,
    "worst_gap_ratio_at_least": float, "asked_area_m2": float, "unseen_area_m2": float, "first_coverage_s": float,
    "violations": int, "length_m": float, "longest_loop_m": float, "longest_loop_s": float,
    "coverage": float, "steps": int, "wall_s": float,
    "cpu_s": float, "check_s": float, "peak_memory_mb": float, "plan_file": str, "started_at": str,
    "rota_version": str, "python_version": str, "machine": str, "system": str, "cores": int, "process": int,
    "planned_before": int,
}  # fmt: skip


class Results:
    """A folder of results, held until ``close``. What a killed process left half written is not there."""

    def __init__(self, folder: Path) -> None:
        """Raises RotaError for a folder that another sweep writes to, and for one that cannot be used."""
        require_writable_folder(folder)
        self.folder = folder
        self._sole = SoleUser(folder, kept="results", in_use=IN_USE)
        try:
            (folder / PLANS).mkdir(exist_ok=True)
            self._journal = (folder / JOURNAL).open("ab+")
            self._finished = self._read()
        except OSError as error:
            self._sole.close()
            raise RotaError(f"{folder}: cannot be used to keep results: {error}") from error

    def _read(self) -> dict[str, Row]:
        """The finished cells by their keys; a last line that was cut off is cut away."""
        self._journal.seek(0)
        content = self._journal.read()
        whole = content.rfind(b"\n") + 1
        if whole < len(content):
            self._journal.truncate(whole)
        rows: dict[str, Row] = {}
        for number, line in enumerate(content[:whole].splitlines(), start=1):
            try:
                row: Row = json.loads(line)
                rows[row["key"]] = row
            except (ValueError, KeyError, TypeError) as error:
                raise RotaError(f"{self.folder / JOURNAL}:{number}: is no finished cell: {error}") from None
        return rows

    def has(self, cell: Cell, *, retry: bool = False) -> bool:
        """Whether the cell is finished; retry: one that crashed or was killed is not."""
        row = self._finished.get(cell.key)
        return row is not None and not (retry and row["outcome"] in AGAIN)

    def keep(self, done: Iterable[tuple[Cell, Planned]], sweep: str) -> None:
        """Keep finished cells for good: plan files first, then the line that says so."""
        lines = []
        for cell, planned in done:
            row = {**describe(cell, sweep), **planned.row}
            row["met"] = row["outcome"] == "met"
            if planned.plan_text is not None:
                row["plan_file"] = f"{PLANS}/{cell.plan_name}"
                write_atomically(self.folder / PLANS / cell.plan_name, planned.plan_text)
            self._finished[cell.key] = row
            lines.append(json.dumps(row) + "\n")
        try:
            self._journal.write("".join(lines).encode())
            self._journal.flush()
            os.fsync(self._journal.fileno())
        except OSError as error:
            raise RotaError(f"{self.folder / JOURNAL}: cannot be written: {error.strerror or error}") from error

    def rows(self, cells: Sequence[Cell]) -> list[Row]:
        """The rows of those of the cells that are finished, in their order."""
        return [self._finished[cell.key] for cell in cells if cell.key in self._finished]

    def write_table(self, cells: Sequence[Cell]) -> None:
        """Write the rows of these cells as Parquet; the file is replaced as a whole."""
        import pyarrow.parquet

        with replaced_file(self.folder / TABLE) as partial:
            pyarrow.parquet.write_table(table(self.rows(cells)), partial)

    def close(self) -> None:
        """Let others have the folder."""
        self._journal.close()
        self._sole.close()


def describe(cell: Cell, sweep: str) -> Row:
    """The columns that say what a cell is. settings: by path."""
    combination = cell.combination
    mission = combination.mission
    planning = None if mission is None else mission.planning
    return {
        "key": cell.key, "sweep": sweep, "mission": None if mission is None else mission.name,
        "mission_file": combination.mission_file, "planner": combination.planner,
        "method": getattr(planning, "method", None), "effort": getattr(planning, "effort", None) or combination.effort,
        "settings": dict(combination.settings), "seed": cell.seed, "time_limit_s": cell.time_limit_s,
    }  # fmt: skip


def table(rows: Sequence[Row]) -> Any:
    """The rows as a pyarrow table: every column of ``TEXTS`` and ``REST``, and one for each field that is set.

    A field's column holds numbers where all its values are numbers, truth values where all are, and JSON otherwise.
    """
    import pyarrow

    kinds = {str: pyarrow.string(), int: pyarrow.int64(), float: pyarrow.float64(), bool: pyarrow.bool_()}
    columns = {name: pyarrow.array([row.get(name) for row in rows], kinds[str]) for name in TEXTS}
    for path in dict.fromkeys(path for row in rows for path in row["settings"]):
        values = [row["settings"].get(path) for row in rows]
        kind = kind_of([value for value in values if value is not None])
        as_text = [value if value is None or isinstance(value, str) else json.dumps(value) for value in values]
        columns[path] = pyarrow.array(as_text if kind is str else values, kinds[kind])
    columns["seed"] = pyarrow.array([row["seed"] for row in rows], kinds[int])
    columns |= {name: pyarrow.array([row.get(name) for row in rows], kinds[kind]) for name, kind in REST.items()}
    return pyarrow.table(columns)


def kind_of(values: Sequence[Any]) -> type:
    """The type of a column that holds all these values: bool, float or str."""
    if values and all(isinstance(value, bool) for value in values):
        return bool
    if values and all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return float
    return str
