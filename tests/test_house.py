"""The house's order, read from the source: no circles, nothing imported upwards, the published method apart."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

import pytest
from benchmarks.house import MOST_PARAMETERS, SOURCE, many_parameters
from tests.sources import FILES, module_name, source_in, source_of
from tests.test_imports import within

PATROL = "rota.planners.patrol"
# from the ground up: what stands in one row is imported by the rows below it, never the other way round
PATROL_STAGES = [
    [
        "planner_settings",
        "method_table",
        "work_ahead",
        "method_settings",
        "loop_settings",
        "tolerances",
    ],
    ["driving", "tours", "verdict", "margins", "settings", "efforts", "cycles"],
    ["ground"],
    ["bounds", "context"],
    ["annealing"],
    ["initial", "traffic"],
    ["repair", "tight_corners"],
    ["shortening"],
    ["methods"],
    ["route_graph", "relief"],
    ["circuits"],
    ["handover", "kinds", "charging", "best_of_efforts"],
    ["planner", "compile_ahead", "left_out", "pockets"],
]
METHOD_STAGES = [
    ["method"],
    ["anneal_and_repair", "sweeping", "sun2019"],
    ["fewest", "large", "cycles"],
    ["tours", "fixed_team"],
]

# what needs the date: of files, of messages, of what is kept, of a plan that is told when it starts
SYSTEM_CLOCK = {
    "rota.command.ros2", "rota.compiled.code_cache", "rota.compiled.source_stamp",
    "rota.links.plan_clock", "rota.links.vda5050_vehicle", "rota.sweep.planned_cells", "rota.web.store.database",
}  # fmt: skip

MODULES = {module_name(file): file for file in FILES}


def imported_modules(module: str) -> set[str]:
    """The modules of the house that a module imports, with the names that it takes from them left out."""
    named = source_of(MODULES[module]).imports
    return {name for name in named if name in MODULES and name != module and not _is_package_of(name, named)}


def _is_package_of(name: str, named: Iterable[str]) -> bool:
    # `from rota.check import report` names rota.check too
    return any(other != name and other in MODULES and within(other, name) for other in named)


def circle_in(arrows: Mapping[str, set[str]]) -> list[str]:
    """The names on some circle of arrows, in turn; empty when there is none."""
    done: set[str] = set()

    def walk(name: str, path: list[str]) -> list[str]:
        if name in path:
            return path[path.index(name) :]
        if name in done:
            return []
        for other in sorted(arrows.get(name, ())):
            if circle := walk(other, [*path, name]):
                return circle
        done.add(name)
        return []

    return next((circle for name in sorted(arrows) if (circle := walk(name, []))), [])


def rooms(package: str) -> dict[str, set[str]]:
    """Which modules and folders of a package import which others of it."""
    arrows: dict[str, set[str]] = {}
    for module in MODULES:
        if module.startswith(package + "."):
            room = module[len(package) + 1 :].split(".")[0]
            there = {
                name[len(package) + 1 :].split(".")[0] for name in imported_modules(module) if within(name, package)
            }
            arrows.setdefault(room, set()).update(there - {room, ""})
    return arrows


def test_circles_are_seen() -> None:
    assert circle_in({"a": {"b"}, "b": {"c"}, "c": set(), "d": {"b"}}) == []
    assert circle_in({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["b", "c"]


def test_no_modules_import_each_other_in_a_circle() -> None:
    assert circle_in({module: imported_modules(module) for module in MODULES}) == []


@pytest.mark.parametrize("package", sorted({name.rsplit(".", 1)[0] for name in MODULES if "." in name}))
def test_no_folders_import_each_other_in_a_circle(package: str) -> None:
    assert circle_in(rooms(package)) == []


@pytest.mark.parametrize(("package", "stages"), [(PATROL, PATROL_STAGES), (f"{PATROL}.methods", METHOD_STAGES)])
def test_nothing_is_imported_upwards(package: str, stages: list[list[str]]) -> None:
    stage = {room: k for k, row in enumerate(stages) for room in row}
    arrows = rooms(package)
    assert set(arrows) == set(stage), "every room has its stage"
    upwards = [(room, other) for room, others in arrows.items() for other in others if stage[other] > stage[room]]
    assert upwards == []


def test_planner_branches_are_seen() -> None:
    for asks in ("x.planner == 'swarm'", "name in ('patrol', 'swarm')", "isinstance(x, a.BounceSettings)", "m.swarm.a"):
        assert source_in(asks).branches == (1,), asks
    assert source_in("isinstance(x, Settings); {'patrol': 'a'}; x.planner == name; y.method == 'tours'").branches == ()


def test_no_planner_is_asked_for_outside_its_house() -> None:
    others = [module for module in MODULES if within(module, "rota") and not within(module, "rota.planners")]
    branches = {module: lines for module in others if (lines := source_of(MODULES[module]).branches)}
    assert branches == {}
    importing = [m for m in others if any(within(name, "rota.planners") for name in imported_modules(m))]
    assert importing == ["rota"]  # the public names of the settings


def test_the_published_method_is_loaded_by_its_name_only() -> None:
    own = f"{PATROL}.methods.sun2019"
    others = [module for module in MODULES if within(module, "rota") and not within(module, own)]
    theirs = [module for module in others if any(within(name, own) for name in imported_modules(module))]
    assert theirs == []


def test_only_dates_come_from_a_clock_that_people_set() -> None:
    """Set back or forth it would end a search, a lease or a lapse at once, or never: durations are by other clocks."""
    reading = re.compile(r"\btime\.time(_ns)?\(|\bdatetime\.(now|today|utcnow)\(|\blocaltime\(|\bgmtime\(\)")
    found = {module for module, file in MODULES.items() if reading.search(file.read_text())}
    assert found == SYSTEM_CLOCK


def test_modules_and_functions_stay_short() -> None:
    too_long: dict[str, int] = {}
    for module, file in MODULES.items():
        source = source_of(file)
        lengths = {module: (source.lines, 350)}
        lengths |= {f"{module}.{each.name}": (each.lines, 60) for each in source.functions}
        too_long |= {name: lines for name, (lines, most) in lengths.items() if lines > most}
    assert too_long == {}


def test_test_modules_have_names_of_their_own() -> None:
    # pytest takes two modules of one name for one, and collects neither when both are asked for
    tests = Path(__file__).parent
    names = [file.name for folder in (tests, tests.parent / "studies") for file in folder.rglob("test_*.py")]
    assert {name for name in names if names.count(name) > 1} == set()


def test_compiled_functions_have_few_parameters(tmp_path: Path) -> None:
    names = ", ".join(f"a{k}" for k in range(MOST_PARAMETERS + 1))
    (tmp_path / "some_kernels.py").write_text(f"def many({names}): ...\ndef few(a): ...\n")
    assert many_parameters(tmp_path) == ["many"]
    assert many_parameters(SOURCE) == []


# ---------------------------------------------------------------- words

IRREGULAR = re.findall(
    r"\w+",
    """told shown laid kept held found given seen met driven drawn made led taken begun bent built bought caught chosen
    dealt dug fed felt flown frozen gone grown heard hidden known left lost meant proven ridden said sent shaken sold
    spent stuck thrown torn understood worn woven wound written overridden undone broken spoken""",
)
ENDS_SO = ("seed", "need", "speed", "feed", "bed", "embed", "red", "exceed", "hundred")
BEFORE = ("as", "all", "best", "not", "once", "newly", "half", "so")
LATER = re.findall(
    r"\w+",
    """by in at to of for from with on out off up as over into along within beside before after when where round again
    apart together away back down once here there first least""",
)
# names and docstrings that are not yet as they should be: "participle" or "silent", and the function; it only shrinks
EXCEPTIONS = Path(__file__).with_name("words_to_change.txt").read_text().splitlines()


def is_participle(name: str) -> bool:
    """Whether a function is called by a participle alone, or by one and what goes with it, as ``led_along``."""
    words = [word for word in name.split("_") if word]
    while len(words) > 1 and words[0] in BEFORE:
        del words[0]
    is_one = words[0] in IRREGULAR or (words[0].endswith("ed") and words[0] not in ENDS_SO)
    return is_one and (len(words) == 1 or words[1] in LATER)


def words_to_change() -> set[str]:
    """The functions of Rota that are called by participles, but for properties, or that say nothing of themselves."""
    found = set()
    for module in (name for name in MODULES if within(name, "rota")):
        for each in source_of(MODULES[module]).functions:
            name = f"{module.removeprefix('rota.')}:{each.name}"
            found |= {f"participle {name}"} if is_participle(each.name) and not each.is_property else set()
            found |= {f"silent {name}"} if each.is_silent else set()
    return found


def test_participles_are_seen() -> None:
    assert all(map(is_participle, ("_told", "led_along", "joined_within", "as_asked", "all_seen_by")))
    assert not any(map(is_participle, ("covered_share", "read_plan", "is_met", "seed", "run", "cut_back", "lead_past")))


def test_functions_are_verbs_or_nouns_and_longer_private_ones_say_what_they_do() -> None:
    found = words_to_change()
    told = "call it by what it does or returns, or give it a docstring of one sentence"
    assert sorted(found - set(EXCEPTIONS)) == [], told
    assert sorted(set(EXCEPTIONS) - found) == [], "take it off tests/words_to_change.txt"
