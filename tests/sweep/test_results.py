"""Finished cells outlive whatever ends the process; the table has a column for everything, each of one type."""

from __future__ import annotations

import json
from pathlib import Path

import pyarrow.parquet
import pytest
from tests.sweep.small_sweeps import write_sweep

from rota.errors import RotaError
from rota.files.sweep_file import read_sweep
from rota.sweep.cells import Cell, cells_of
from rota.sweep.planned_cells import Planned
from rota.sweep.results import JOURNAL, REST, TABLE, TEXTS, Results

MET = Planned({"outcome": "met", "robots": 3, "wall_s": 0.5, "stopped_early": False}, "the plan\n")
CRASHED = Planned({"outcome": "crashed", "reason": "it broke"}, None)


@pytest.fixture
def cells(tmp_path: Path) -> list[Cell]:
    settings = {"fleet.speed_m_s": [4, 5.5], "fleet.robots": ["fewest", 9], "unseeable": ["refuse"]}
    return cells_of(read_sweep(write_sweep(tmp_path, settings=settings)))


def test_what_is_kept_is_there_again(tmp_path: Path, cells: list[Cell]) -> None:
    results = Results(tmp_path / "out")
    results.keep([(cells[1], MET), (cells[0], CRASHED)], "yards")
    results.close()
    again = Results(tmp_path / "out")
    assert [again.has(cell) for cell in cells] == [True, True, False, False]
    assert [again.has(cell, retry=True) for cell in cells] == [False, True, False, False]
    crashed, met = again.rows(cells)  # in the order of the cells
    assert (crashed["reason"], crashed["met"], met["met"], met["robots"]) == ("it broke", False, True, 3)
    assert (tmp_path / "out" / met["plan_file"]).read_text() == "the plan\n"
    again.keep([(cells[0], MET)], "yards")
    again.close()
    assert Results(tmp_path / "out").rows(cells)[0]["outcome"] == "met"


@pytest.mark.parametrize("cut", [1, 7])
def test_a_line_cut_off_by_a_crash_is_no_finished_cell(tmp_path: Path, cells: list[Cell], cut: int) -> None:
    results = Results(tmp_path / "out")
    results.keep([(cells[0], MET)], "yards")
    results.keep([(cells[1], MET)], "yards")
    results.close()
    journal = tmp_path / "out" / JOURNAL
    journal.write_bytes(journal.read_bytes()[:-cut])
    again = Results(tmp_path / "out")
    assert [again.has(cell) for cell in cells] == [True, False, False, False]
    again.keep([(cells[1], MET)], "yards")
    again.close()
    assert [json.loads(line)["key"] for line in journal.read_text().splitlines()] == [cells[0].key, cells[1].key]


def test_a_foreign_line_is_told_with_its_number(tmp_path: Path, cells: list[Cell]) -> None:
    results = Results(tmp_path / "out")
    results.keep([(cells[0], MET)], "yards")
    results.close()
    with (tmp_path / "out" / JOURNAL).open("a") as journal:
        journal.write("nonsense\n")
    with pytest.raises(RotaError, match=r"finished\.jsonl:2: is no finished cell"):
        Results(tmp_path / "out")


def test_one_sweep_at_a_time_writes_to_a_folder(tmp_path: Path) -> None:
    results = Results(tmp_path / "out")
    with pytest.raises(RotaError, match="another rota sweep writes here"):
        Results(tmp_path / "out")
    results.close()
    Results(tmp_path / "out").close()


def test_the_table_has_a_column_of_one_type_for_everything(tmp_path: Path, cells: list[Cell]) -> None:
    results = Results(tmp_path / "out")
    results.keep([(cell, MET) for cell in cells[1:]], "yards")
    results.keep([(cells[0], CRASHED)], "yards")
    results.write_table(cells)
    table = pyarrow.parquet.read_table(tmp_path / "out" / TABLE)
    fields = ["fleet.speed_m_s", "fleet.robots", "unseeable"]
    assert table.column_names == [*TEXTS, *fields, "seed", *REST]
    assert table["fleet.speed_m_s"].to_pylist() == [4.0, 4.0, 5.5, 5.5]
    assert table["fleet.robots"].to_pylist() == ["fewest", "9", "fewest", "9"]
    assert table["key"].to_pylist() == [cell.key for cell in cells]
    assert table["robots"].to_pylist() == [None, 3, 3, 3]
    assert table["met"].to_pylist() == [False, True, True, True]
    assert [str(table.schema.field(name).type) for name in ("robots", "wall_s", "met", "reason")] == [
        "int64", "double", "bool", "string",
    ]  # fmt: skip
