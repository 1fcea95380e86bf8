"""The pages in docs: each is what its records give, byte for byte, and some of its runs come out the same today."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rota_studies.alam2020 import maps as alam_maps
from rota_studies.alam2020.runs import Runs as AlamRuns
from rota_studies.alam2020.watched import counted_groups, group_to_show
from rota_studies.chen2018 import maps as chen_maps
from rota_studies.chen2018.runs import EXACT, FORCES, SETTLE, VORONOI, Job, Runs as ChenRuns
from rota_studies.records import Record, Records, read_records
from rota_studies.study import PaperStudy
from rota_studies.sun2019.runs import Runs as SunRuns

DOCS = Path(__file__).parents[2] / "docs"
RECORDED = [path.stem for path in sorted(DOCS.glob("*20[0-9][0-9].json"))]


def study_of(name: str) -> PaperStudy[Any, Any]:
    study: PaperStudy[Any, Any] = getattr(importlib.import_module(f"rota_studies.{name}.study"), f"{name}_study")
    return study


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name == "chen2018")) for name in RECORDED],  # 5 s, others 1
)
def test_a_page_is_what_its_records_give(name: str) -> None:
    study = study_of(name).from_records(DOCS / f"{name}.json")
    assert study.page == (DOCS / f"{name}.md").read_text(encoding="utf-8")
    assert study.records.text == (DOCS / f"{name}.json").read_text(encoding="utf-8")
    pictures = {picture.file for section in study.sections for picture in section.pictures}
    assert pictures == {path.name for path in DOCS.glob(f"{name}-figure-*.png")}


def alam(runs: AlamRuns) -> None:
    """A group that is counted and shown, a plan, and teams that cover."""
    mission = alam_maps.watching(alam_maps.lab(alam_maps.LAB_2, 2, 90.0), alam_maps.LAB_REGIONS)
    counted_groups(runs, mission)
    group_to_show(runs, mission)
    for method in ("as_printed", "improved"):
        runs.cover(alam_maps.room(alam_maps.ROOM_10, 5, 135.0), method)


def chen(runs: ChenRuns) -> None:
    """One seed of the small case by each controller."""
    mission = chen_maps.small("between")
    runs.all([Job(mission, one, runs.seed, runs.settings.steps) for one in (EXACT, VORONOI, FORCES, SETTLE)])


def sun(runs: SunRuns) -> None:
    """A plan by a quick method; sensors without rules."""
    runs.by_method(runs.map_13, "sequential")
    runs.sensors(runs.map_13, runs.figure_13.deployments[0].without_rules(), runs.seed)


AGAIN: dict[str, tuple[type[Any], Callable[[Any], None]]] = {
    "alam2020": (AlamRuns, alam), "chen2018": (ChenRuns, chen), "sun2019": (SunRuns, sun),
}  # fmt: skip


@pytest.mark.slow  # makes runs of all three studies
@pytest.mark.parametrize("name", RECORDED)
def test_some_runs_come_out_as_recorded(name: str) -> None:
    file = read_records(DOCS / f"{name}.json", name)
    made: list[Record] = []

    def again(record: Record) -> bool:
        made.append(record)
        return True

    records = Records(file.runs, may_run=False, again=again)
    make_runs, run = AGAIN[name]
    run(make_runs(study_of(name).settings_of(file), seed=file.seed, records=records))
    assert len(made) >= 2
    told = "\n".join(f"{one.run}" for one in records.changed)
    assert not records.changed, f"`rota study {name} -o docs` makes the page anew; what has changed:\n{told}"
