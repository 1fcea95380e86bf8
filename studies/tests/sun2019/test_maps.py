"""The maps of the study: those of the example missions, and Table 6's periods on them."""

from __future__ import annotations

from pathlib import Path

import pytest

from rota.files.mission_file import read_mission
from rota.files.sweep_file import read_sweep
from rota_studies.sun2019 import figure_8, figure_13, figure_15, paper, with_periods

EXAMPLES = Path(__file__).parents[3] / "examples"


def test_the_maps_are_those_of_the_examples() -> None:
    assert figure_13() == read_mission(EXAMPLES / "sun2019-fig13.yaml").mission
    ours, read = figure_15(), read_mission(EXAMPLES / "sun2019-fig16.yaml").mission
    assert (ours.name, ours.period_s, ours.fleet, ours.obstacles) == (read.name, 45, read.fleet, read.obstacles)
    assert [zone.period_s for zone in ours.zones] == [10, 12]
    for one, other in zip([ours, *ours.zones], [read, *read.zones], strict=True):
        shapes = [thing.area if hasattr(thing, "area") else thing.shape for thing in (one, other)]
        assert shapes[0].symmetric_difference(shapes[1]).area == pytest.approx(0, abs=1e-9)


def test_other_periods_change_nothing_else() -> None:
    case = with_periods(figure_13(), (12, 7, 40))
    assert case.name == "sun2019-12-7-40"
    assert [zone.period_s for zone in case.zones] == [12, 7]
    assert with_periods(case, (8, 20, 40)).zones == figure_13().zones
    assert (case.area, case.obstacles, case.period_s) == (figure_13().area, figure_13().obstacles, 40)


def test_figure_8_has_two_sub_regions() -> None:
    assert [zone.name for zone in figure_8().zones] == ["zone-1"]
    assert figure_8().zones[0].shape == figure_13().zones[1].shape


@pytest.mark.parametrize("case", range(6))
def test_the_files_of_table_6_are_its_maps(case: int) -> None:
    read = read_mission(EXAMPLES / "sun2019-table6" / f"case-{case + 1}.yaml")
    assert read.mission == with_periods(figure_13(), paper.TABLE_6[case].periods_s)
    assert read.warnings == ()


def test_table_6_is_a_sweep_of_five_methods_and_eight_seeds() -> None:
    read = read_sweep(EXAMPLES / "sun2019-table6" / "sweep.yaml")
    assert [path.stem for path in read.missions.values()] == [f"case-{k}" for k in range(1, 7)]
    assert (len(read.file.settings["patrol.method"]), read.file.all_seeds) == (5, list(range(8)))
