"""The pages: what is generated is up to date, every page is in the contents, and every link leads somewhere."""

from __future__ import annotations

import importlib
import importlib.util
import re
from pathlib import Path
from textwrap import dedent
from types import SimpleNamespace
from typing import Any

import pytest
import shapely
from benchmarks.measured import KEPT, PAGE, page_of, read_kept, replaced, write_kept
from docs.field_tables import with_fields
from docs.house_picture import PICTURE, picture, reduced, rows_of
from tests.planners.patrol.searching import YARD, search_on

import rota
from rota import Plan, Trajectory
from rota.command.cli import app
from rota.exports import FORMATS
from rota_studies.command import app as study_app

PROJECT = Path(__file__).parents[1]
DOCS = PROJECT / "docs"
SOURCE = PROJECT / "src"
PAGES = sorted(DOCS.glob("*.md"))
SWARM = """\
rota: 1
name: two
area: [[0, 0], [40, 0], [40, 40], [0, 40]]
planner: swarm
swarm: {most_steps: 3, time_step_s: 0.25}
fleet:
  robots: 2
  speed_m_s: 2
  body_radius_m: 0.5
  sensor: {shape: disc, radius_m: 10}
  start: {box: [[18, 18], [22, 22]]}
"""
LINK = re.compile(r"\]\(([^)\s]+)\)")
FENCED = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


def test_the_page_of_figures_is_what_the_kept_rows_give() -> None:
    assert PAGE.read_text() == page_of(read_kept()), "run python -m benchmarks.measured"


def test_kept_rows_are_replaced_by_command_and_figure(tmp_path: Path) -> None:
    rows = read_kept()
    assert len(rows) > 100
    newer = rows[3]._replace(measured="7 s", date="2030-01-01")
    added = rows[3]._replace(figure="another", command=f"{rows[3].command} --effort high")
    kept = replaced(rows, [newer, added])
    assert kept[3] == newer
    assert kept[:3] + kept[4:-1] == rows[:3] + rows[4:]
    assert kept[-1] == added
    write_kept(rows, tmp_path / "kept.csv")
    assert (tmp_path / "kept.csv").read_text() == KEPT.read_text()
    with pytest.raises(KeyError):  # of a name that is not known nothing is written
        write_kept([*rows, added._replace(command="unheard-of")], tmp_path / "kept.csv")
    assert (tmp_path / "kept.csv").read_text() == KEPT.read_text()


def test_kept_rows_with_other_columns_are_refused(tmp_path: Path) -> None:
    (tmp_path / "kept.csv").write_text("figure,asked\na,b\n")
    with pytest.raises(ValueError, match=r"kept\.csv: columns figure, asked; command, figure, .* are needed"):
        read_kept(tmp_path / "kept.csv")


def test_every_page_is_in_the_contents() -> None:
    contents = "\n".join(re.findall(r"^```\{toctree\}.*?^```", (DOCS / "index.md").read_text(), re.M | re.S))
    listed = {line.strip() for line in contents.splitlines() if line and line[0] not in ":`"}
    notebooks = {f"notebooks/{page.stem}" for page in (DOCS / "notebooks").glob("*.ipynb")}
    assert listed == {page.stem for page in PAGES} - {"index"} | notebooks


@pytest.mark.parametrize("page", [*PAGES, PROJECT / "README.md"], ids=lambda page: page.name)
def test_links_lead_to_files(page: Path) -> None:
    links = LINK.findall(FENCED.sub("", page.read_text()))
    files = [link.partition("#")[0] for link in links if "://" not in link and not link.startswith("#")]
    assert [file for file in files if not (page.parent / file).exists()] == []


def test_every_picture_is_shown_somewhere() -> None:
    shown = "".join(page.read_text() for page in [*PAGES, PROJECT / "README.md"])
    pictures = [*DOCS.glob("*.png"), *DOCS.glob("*.gif"), *DOCS.glob("*.svg")]
    assert [picture.name for picture in pictures if picture.name not in shown] == []


def test_the_reference_names_modules_that_exist_and_all_public_names() -> None:
    reference = (DOCS / "api.md").read_text()
    modules = re.findall(r"^\.\. (?:auto)?module:: (\S+)", reference, re.M)
    assert [name for name in modules if importlib.util.find_spec(name) is None] == []
    listed = {name: home for name, home in re.findall(r"`(\w+) <(rota\.[\w.]+)\.\w+>`", reference)}
    assert sorted(listed) == rota.__all__
    wrong = [
        name for name, home in listed.items() if home not in modules or not hasattr(importlib.import_module(home), name)
    ]
    assert wrong == []


def test_the_picture_of_the_house_is_what_the_imports_give() -> None:
    assert PICTURE.read_text() == picture(), "run python -m docs.house_picture"


def test_usage_says_of_fields_what_their_declarations_say() -> None:
    page = (DOCS / "usage.md").read_text()
    assert page == with_fields(page), "run python -m docs.field_tables"
    assert page.count("<!-- end -->") == 6


def test_the_house_is_drawn_from_arrows_that_do_not_follow_from_others() -> None:
    arrows = {"a": {"b", "c", "d"}, "b": {"c"}, "c": set(), "d": {"c"}}
    assert reduced(arrows) == {"a": {"b", "d"}, "b": {"c"}, "c": set(), "d": {"c"}}
    rows = rows_of({"a": {"b", "c"}, "b": {"d"}, "c": set(), "d": set()})
    assert [[point.name for point in row] for row in rows] == [["a"], [None, "b"], ["c", "d"]]


def test_the_readme_is_short_and_its_figures_are_kept_rows() -> None:
    readme = (PROJECT / "README.md").read_text()
    assert len(readme.splitlines()) <= 200
    figures = re.findall(r"^\| \[.*\]\(docs/benchmarks\.md#([\w-]+)\).* \| (.+) \|$", readme, re.M)
    assert len(figures) == 7
    kept = read_kept()
    told = [
        [row.measured for row in kept if row.name == name and measured in row.measured] for name, measured in figures
    ]
    assert [figure for figure, rows in zip(figures, told, strict=True) if not rows] == []


def test_what_draws_the_search_can_be_loaded() -> None:
    module = importlib.import_module("docs.search_picture")
    assert module.PICTURE.exists()
    assert module.MISSION.exists()


@pytest.mark.parametrize("page", [PROJECT / "README.md", DOCS / "usage.md"], ids=lambda page: page.name)
def test_the_missions_that_pages_show_can_be_read(page: Path, tmp_path: Path) -> None:
    (text,) = [
        block for block in re.findall(r"^```yaml\n(.*?)^```", page.read_text(), re.M | re.S) if "rota: 1" in block
    ]
    (tmp_path / "shown.yaml").write_text(text)
    read = rota.read_mission(tmp_path / "shown.yaml")
    assert not read.warnings
    assert [zone.name for zone in read.mission.zones] == ["gate", "tank"]


def python_of(page: str) -> list[str]:
    """The Python samples of a page's text."""
    return [dedent(code) for code in re.findall(r"^ *```python\n(.*?)^ *```", page, re.M | re.S)]


def recipe(title: str) -> str:
    """A section of docs/contributing.md."""
    _, _, rest = (DOCS / "contributing.md").read_text().partition(f"## {title}\n")
    return rest.partition("\n## ")[0]


def test_the_sample_of_usage_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    yard = "rota: 1\nname: yard\narea: [[0, 0], [20, 0], [20, 10], [0, 10]]\nperiod_s: 60\n"
    Path("mission.yaml").write_text(f"{yard}fleet: {{speed_m_s: 2, sensor: {{shape: disc, radius_m: 4}}}}\n")
    for sample in python_of((DOCS / "usage.md").read_text()):
        exec(sample, {})
    assert "met 1 robots, at least 1" in capsys.readouterr().out
    assert Path("mission.png").stat().st_size > 1000


def test_the_sample_of_swarms_goes_on_with_a_stopped_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mission.yaml").write_text(SWARM)
    (sample,) = python_of((DOCS / "swarm.md").read_text())
    went: dict[str, Any] = {}
    exec(sample, went)
    assert Path("mission.rota-run").exists()
    assert went["found"].checkpoint is None
    assert went["found"].plan == rota.search_plan(went["longer"], seed=0).plan


def test_the_method_that_contributing_shows_plans() -> None:
    module, shown = python_of(recipe("Add a patrol method"))
    method: dict[str, Any] = {}
    exec(module, method)
    found = method["visit_centres"](search_on(YARD))
    assert rota.check_plan(found.plan).verdict == "met"
    assert len(found.plan.trajectories) >= 1
    test: dict[str, Any] = {}
    exec(shown, test)
    # the name centres is no method of Rota: the plan comes from the sample itself
    test |= {"YARD": SimpleNamespace(with_method=str), "make_plan": lambda mission, seed: found.plan}
    test["test_its_plans_pass_the_check"]()


def test_the_export_that_contributing_shows_loses_no_digit() -> None:
    (module,) = python_of(recipe("Add an export"))
    export: dict[str, Any] = {}
    exec(module, export)
    way = Trajectory(
        robot="one, two", times_s=[0, 1, 2.1, 3], positions_m=[[0, 1], [1, 1], [1 / 3, 1], [1, 1]], loop_start_s=1
    )
    (line,) = export["wkt_text"](Plan(mission=YARD, trajectories=(way,))).splitlines()
    assert shapely.from_wkt(line).coords[:] == [(1, 1), (1 / 3, 1), (1, 1)]


def test_pages_name_all_commands_and_formats() -> None:
    readme, usage = (PROJECT / "README.md").read_text(), (DOCS / "usage.md").read_text()
    names = {command.name or command.callback.__name__ for command in app.registered_commands if command.callback}
    for page in (readme, usage):
        assert {name for name in names if f"`rota {name} " not in page} == set()
    assert {f"`{to}`" for to in FORMATS if f"`{to}`" not in usage} == set()
    studies = {command.name for command in study_app.registered_commands}
    assert {name for name in studies if f"`rota study {name} " not in usage} == set()


@pytest.mark.parametrize("name", ["architecture.md", "algorithm.md"])
def test_pages_name_files_that_exist(name: str) -> None:
    tree = [
        path.relative_to(PROJECT).as_posix()
        for path in [*SOURCE.rglob("*"), *(PROJECT / "studies").rglob("*"), *(PROJECT / "tests").rglob("*.py")]
    ]
    page = (DOCS / name).read_text().replace("planners/NAME", "planners/patrol").replace("PAPER", "sun2019")
    named = re.findall(r"`([\w/]+(?:/|\.py|_bound))`", page)
    files = {f"{file}.py" if file.endswith("_bound") else file.rstrip("/") for file in named}
    assert len(files) > 5
    assert {file for file in files if not any(path == file or path.endswith(f"/{file}") for path in tree)} == set()
