"""The design's import rules, read from the source, and what `import rota` loads."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest
from tests.sources import FILES, SOURCE, module_name, source_in, source_of

import rota


def within(module: str, package: str) -> bool:
    return module == package or module.startswith(package + ".")


def importers(package: str) -> set[str]:
    """Modules of rota and of the studies that import the package or anything below it."""
    return {module_name(file) for file in FILES if any(within(name, package) for name in source_of(file).imports)}


def test_the_reader_of_imports_sees_every_kind() -> None:
    text = "import a.b as c\ndef f():\n  from . import d\n  from ..e import g\n  importlib.import_module('h')\n"
    text += "from i import j"
    assert source_in(text, "rota.x.y").imports >= {"a.b", "rota.x.d", "rota.e.g", "h", "i", "i.j"}
    assert source_in("from . import d\nfrom .e import f", "rota.x", is_package=True).imports >= {
        "rota.x.d",
        "rota.x.e.f",
    }
    assert len(FILES) > 20
    assert "rota.model.plan" in importers("rota.model.mission")


def test_check_imports_mission_plan_errors_and_third_parties_only() -> None:
    # compiled tells how a loop becomes machine code; it holds no loop, and nothing of planners
    allowed = (
        "rota.check",
        "rota.model.mission",
        "rota.model.plan",
        "rota.model.violation_kinds",
        "rota.errors",
        "rota.compiled",
    )
    for file in (SOURCE / "check").rglob("*.py"):
        ours = {name for name in source_of(file).imports if within(name, "rota")}
        assert [name for name in ours if not any(within(name, good) for good in allowed)] == [], file


def test_only_draw_imports_matplotlib() -> None:
    drawing = ("rota.draw", "rota_studies.panels", "rota_studies.progress_picture")
    assert [name for name in importers("matplotlib") if not any(within(name, room) for room in drawing)] == []


def test_planners_import_neither_each_other_nor_check() -> None:
    planners = [folder.name for folder in (SOURCE / "planners").iterdir() if (folder / "__init__.py").exists()]
    assert "patrol" in planners
    for planner in planners:
        own = f"rota.planners.{planner}"
        for file in (SOURCE / "planners" / planner).rglob("*.py"):
            for name in source_of(file).imports:
                assert not within(name, "rota.check"), file
                assert not within(name, "rota.planners") or name == "rota.planners" or within(name, own), file


def test_nothing_knows_what_stands_to_its_right() -> None:
    # mission file -> Mission -> planner -> Plan -> check -> draw, files; planning joins them and command shows them
    above = ["rota.files", "rota.geometry", "rota.planners", "rota.check", "rota.draw", "rota.planning.make_plan"]
    right_of = {
        "rota.errors": ["rota"],
        "rota.model": ["rota.routes", "rota.planning", "rota.cells", *above],
        "rota.model.mission": ["rota.model.plan"],
        "rota.routes": ["rota.planning", "rota.cells", *above],
        "rota.cells": above,
        "rota.geometry": ["rota.model.plan", *above],
        "rota.planners": ["rota.files", "rota.check", "rota.draw", "rota.planning.make_plan"],
        "rota.check": ["rota.files", "rota.draw", "rota.planning"],
        "rota.vehicles": above,
        "rota.files": above,
        "rota.draw": ["rota.geometry", "rota.planners", "rota.planning.make_plan"],
        "rota.live": ["rota.planners", "rota.draw", "rota.planning.make_plan", "rota.playback"],
        "rota.playback": [
            "rota.geometry", "rota.planners", "rota.draw", "rota.planning.make_plan", "rota.links", "rota.web",
        ],
    }  # fmt: skip
    for package in ("errors", "model", "routes", "geometry", "planners", "check", "vehicles", "files", "draw", "links"):
        right_of.setdefault(f"rota.{package}", []).append("rota.live")  # a watch looks at all of them
    for package in ("geometry", "check"):
        right_of[f"rota.{package}"].append("rota.vehicles")
    for file in FILES:
        for package, forbidden in right_of.items():
            if within(module_name(file), package):
                others = [bad for bad in forbidden if not within(module_name(file), bad)]
                wrong = [name for name in source_of(file).imports for bad in others if within(name, bad)]
                assert wrong == [], f"{module_name(file)} imports {wrong}"


def test_nothing_imports_the_command_line_and_only_it_talks_to_terminals() -> None:
    assert importers("rota.command.cli") == {"rota.__main__"}
    assert all(name.startswith(("rota.command.", "rota_studies.command")) for name in importers("typer"))
    assert importers("rota_studies.command") == set()


def test_the_product_does_not_know_its_studies() -> None:
    assert [name for name in importers("rota_studies") if not within(name, "rota_studies")] == []
    assert importers("rich") == {"rota.command.plan", "rota.command.terminal", "rota.command.watch_table"}


def test_what_compiles_loops_knows_none_of_them() -> None:
    for file in (SOURCE / "compiled").rglob("*.py"):
        ours = {name for name in source_of(file).imports if within(name, "rota")}
        assert all(within(name, "rota.compiled") for name in ours), file


def test_compiled_loops_live_in_kernels_files_only() -> None:
    assert all(name.endswith("kernels") for name in importers("rota.compiled.kernel.kernel"))
    # numba's own njit keeps code that cannot find what it calls in another process: use @kernel of rota.compiled.kernel
    elsewhere = {
        "rota.compiled.by_reference",
        "rota.compiled.code_libraries",
        "rota.compiled.bits",
        "rota.compiled.kernel",
        "rota.planners.swarm.cuda_kernels",
    }
    assert set(importers("numba")) == elsewhere


def test_test_tools_stay_out_of_the_package() -> None:
    for tool in ("pytest", "hypothesis", "jsonschema", "pymavlink"):
        assert importers(tool) == set(), tool


def test_libraries_of_robots_are_known_to_their_links_only() -> None:
    parts = ("failsafes", "held", "link", "targets", "vehicle")
    assert importers("mavsdk") == {f"rota.links.mavlink_{part}" for part in parts}
    assert importers("aiomqtt") == {"rota.links.vda5050_broker"}


def modules_after(statement: str) -> set[str]:
    code = f"{statement}\nimport json, sys\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


@pytest.mark.parametrize("statement", ["import rota", "import rota; rota.make_plan; rota.__version__; dir(rota)"])
def test_importing_rota_loads_nothing_heavy(statement: str) -> None:
    loaded = modules_after(statement)
    assert loaded & {"numba", "scipy", "matplotlib", "pyproj", "pydantic", "shapely", "numpy", "PIL", "typer"} == set()


def test_reading_and_writing_plans_needs_no_compiler_and_no_pictures() -> None:
    assert modules_after("import rota; rota.read_plan, rota.Plan") & {"numba", "scipy", "matplotlib"} == set()


def test_the_patrol_planner_loads_no_solver_that_most_plans_do_without() -> None:
    assert "scipy.optimize" not in modules_after("import rota.planners.patrol.planner")


def test_every_public_name_is_there() -> None:
    for name in rota.__all__:
        value = getattr(rota, name)
        assert callable(value), name
        assert value.__doc__, name
    assert set(rota.__all__) <= set(dir(rota))
    assert rota.__all__ == sorted(rota.__all__)
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = rota.nonsense
