"""Which cells a sweep has, and that a cell's key is the same exactly when its plan is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from tests.sweep.small_sweeps import write_sweep

from rota.files.sweep_file import read_sweep
from rota.sweep import cells
from rota.sweep.cells import Cell, cells_of


def cells_in(folder: Path, **values: Any) -> list[Cell]:
    return cells_of(read_sweep(write_sweep(folder, **values)))


def test_every_combination_is_there_with_every_seed(tmp_path: Path) -> None:
    found = cells_in(
        tmp_path, efforts=["quick", "normal"], seeds=[0, 1],
        settings={"fleet.speed_m_s": [2, 4], "zones.gate.period_s": [20, 30]},
    )  # fmt: skip
    assert len(found) == len({cell.key for cell in found}) == 16
    assert [cell.seed for cell in found[:4]] == [0, 1, 0, 1]
    missions = [cell.combination.mission for cell in found[::2]]
    asked = [(m.planning.effort, m.fleet.speed_m_s, m.zones[0].period_s) for m in missions if m is not None]
    speeds_periods = [(2, 20), (2, 30), (4, 20), (4, 30)]
    assert asked == [(effort, *pair) for effort in ("quick", "normal") for pair in speeds_periods]


def test_keys_stay_and_differ_where_plans_may(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (first,) = cells_in(tmp_path)
    assert [cell.key for cell in cells_in(tmp_path, name="another")] == [first.key]
    assert first.key in {cell.key for cell in cells_in(tmp_path, seeds=[4, 0])}
    others = [
        cells_in(tmp_path, seeds=[1]),
        cells_in(tmp_path, time_limit_s=5),
        cells_in(tmp_path, settings={"fleet.speed_m_s": [5]}),
        cells_in(tmp_path, efforts=["normal"]),
    ]
    (tmp_path / "yard.yaml").write_text((tmp_path / "yard.yaml").read_text().replace("60", "61"))
    others.append(cells_of(read_sweep(tmp_path / "sweep.json")))
    monkeypatch.setattr(cells, "version", lambda _: "99")
    others.append(cells_in(tmp_path))
    assert len({first.key, *(cell.key for other in others for cell in other)}) == 1 + len(others)


def test_settings_of_another_planner_make_no_cells_of_their_own(tmp_path: Path) -> None:
    found = cells_in(
        tmp_path, planners=["patrol", "swarm"], efforts=["quick"],
        settings={"fleet.robots": [3], "patrol.method": ["tours", "sequential"]},
    )  # fmt: skip
    told = [(c.combination.planner, c.combination.effort, dict(c.combination.settings)) for c in found]
    assert told == [
        ("patrol", "quick", {"fleet.robots": 3, "patrol.method": "tours"}),
        ("patrol", "quick", {"fleet.robots": 3, "patrol.method": "sequential"}),
        ("swarm", None, {"fleet.robots": 3}),
    ]
    assert [None if c.combination.mission is None else c.combination.mission.planning.planner for c in found[:2]] == [
        "patrol",
        "patrol",
    ]


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ({"fleet.sped_m_s": [1]}, "override: fleet.sped_m_s: unknown key; did you mean 'speed_m_s'?"),
        ({"fleet.speed_m_s": ["fast"]}, "override: fleet.speed_m_s: "),
        ({"zones.none.period_s": [1]}, "override: zones.none.period_s: there is no 'none' among its 1 items"),
        ({"zones.7.period_s": [1]}, "override: zones.7.period_s: there is no '7' among its 1 items"),
    ],
)
def test_what_a_mission_does_not_take_is_refused_with_the_reason(
    tmp_path: Path, settings: dict[str, Any], reason: str
) -> None:
    (cell,) = cells_in(tmp_path, settings=settings)
    assert cell.combination.mission is None
    assert str(cell.combination.refused).startswith(reason)


def test_a_mission_that_cannot_be_read_is_refused_and_the_others_are_there(tmp_path: Path) -> None:
    (tmp_path / "broken.yaml").write_text("rota: [1\n")
    found = cells_in(tmp_path, missions=["broken.yaml", "yard.yaml"])
    assert [cell.combination.mission is None for cell in found] == [True, False]
    assert "broken.yaml:2:1: not YAML" in str(found[0].combination.refused)


def test_names_of_plan_files_are_safe(tmp_path: Path) -> None:
    (tmp_path / "a b").mkdir()
    (tmp_path / "a b" / "ö x;.yaml").write_text("")
    (cell,) = cells_in(tmp_path, missions=["a b/ö x;.yaml"])
    assert cell.plan_name == f"ö-x--patrol-seed0-{cell.key}.rota.json"
