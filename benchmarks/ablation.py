"""What each mechanism of the patrol search is worth: ``python -m benchmarks.ablation quick -o FILE``.

Plans 300 random missions and the cases of Sun et al. 2019, first with all mechanisms, then without each, one at a time.
A mission is planned again without a mechanism only if the mechanism did anything there: else the plan is the same.
Lines of JSON go to the file as they come; what it already holds is not run again. ``--table`` prints what it holds.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple
from unittest.mock import patch

import rota
from benchmarks.plan_hashes import mission_of
from benchmarks.sun_cases import CASES, FIGURE_16
from rota.errors import NoPlanFound
from rota.planners.patrol.efforts import EFFORTS
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.settings import SearchSettings, Stage

RANDOM_MISSIONS = 300
PATROL = "rota.planners.patrol"
REPAIR = f"{PATROL}.repair.repair"
SEARCH = f"{PATROL}.methods.fewest.search"
ALLOCATION = f"{PATROL}.initial.allocation"

Known = dict[tuple[str, str], dict[str, Any]]
Did = Callable[[Any, tuple[Any, ...]], bool]


class Mechanism(NamedTuple):
    """A part of the search: either functions and what stands in for them, or other values of a stage's settings.

    did: whether a call did anything, told of what it returned and of its arguments.
    """

    name: str
    functions: tuple[str, ...] = ()
    instead: Callable[..., Any] | None = None
    did: Did = lambda result, _: bool(result)
    stage: str = ""
    values: Mapping[str, Any] = MappingProxyType({})


def changed(result: Any, given: tuple[Any, ...]) -> bool:
    """Whether the first argument that is a list came back as another one."""
    tours = next(argument for argument in given if isinstance(argument, list))
    return result is not tours


def is_there(result: Any, _: tuple[Any, ...]) -> bool:
    """Whether anything came back."""
    return result is not None


def always(*_: Any) -> bool:
    """A call that is made does something."""
    return True


def other_plan(result: Any, given: tuple[Any, ...]) -> bool:
    """Whether the second argument, a plan, came back as another one."""
    return result is not given[1]


def second(_: Any, given: Any, *__: Any, **___: Any) -> Any:
    """The second argument."""
    return given


def first_base(_: Any, grouping: Any, counts: list[int], __: int) -> list[Any]:
    """The grouping with robots as their loads are, alone."""
    return [grouping.with_robots(counts)]


MECHANISMS = (
    Mechanism("bending", (f"{REPAIR}.can_bend",), lambda *_: False),
    Mechanism("tightening", (f"{REPAIR}.tighten",), second, always),
    Mechanism("rerouting for bodies", (f"{REPAIR}.lead_apart",), lambda *_: None, is_there),
    Mechanism("visits of stubborn points", (f"{REPAIR}.visiting_stubborn",), second, changed),
    Mechanism("detours", (f"{PATROL}.repair.seeing.visit_places",), lambda *_, **__: None, is_there),
    Mechanism("repair of tours over their budgets", stage="repair", values={"over_budget_limit": 0.0}),
    Mechanism("nested loops", (f"{ALLOCATION}.nested_allocations",), lambda *_, **__: [], always),
    Mechanism(
        "several bases of nested loops", (f"{ALLOCATION}.nesting_bases",), first_base, lambda result, _: len(result) > 1
    ),
    Mechanism("several estimates of excursions", stage="allocation", values={"estimates": 1}),
    Mechanism("tours of one robot each", (f"{ALLOCATION}.own_tours",), lambda *_: []),
    Mechanism("several groupings", stage="allocation", values={"groupings": 1}),
    Mechanism(
        "screening",
        (f"{PATROL}.methods.fewest.team_size_plan.screen",),
        lambda _, candidates, seed: [allocation.tours for allocation in candidates],
        lambda _, given: len(given[1]) > 1,
    ),
    Mechanism("short annealings of nested loops", stage="screening", values={"nested_allocations": 0}),
    Mechanism(
        "several allocations and seeds in full", stage="multistart", values={"allocations": 1, "seeds": 1, "kept": 1}
    ),
    Mechanism(
        "coverage weight that grows with detours",
        (f"{SEARCH}.coverage_weight_for",),
        lambda _: 1.0,
        lambda result, _: result > 1,
    ),
    Mechanism(
        "two annealings before the first repair",
        stage="alternation",
        values={"first_stages": (Stage(1 / 16, 12.0, 0.005),)},
    ),
    Mechanism("annealings between repairs", stage="alternation", values={"annealings": 2}),
    Mechanism("robots given up by plans found", (f"{SEARCH}.without_spare_robots",), second, other_plan),
    Mechanism("robots that shorter loops spare", (f"{PATROL}.planner.leave_out_needless_robots",), second, other_plan),
    Mechanism("shorter sights", (f"{PATROL}.planner.with_shorter_sights",), second, other_plan),
    Mechanism("lesser efforts first", (f"{SEARCH}.EFFORTS",)),
)


def _resolve(target: str) -> Any:
    module, name = target.rsplit(".", 1)
    __import__(module)
    return getattr(sys.modules[module], name)


@contextmanager
def recorded(acts: Counter[str]) -> Iterator[None]:
    """Count in which mechanisms' functions something happens."""

    def watched(mechanism: Mechanism, original: Callable[..., Any]) -> Callable[..., Any]:
        def call(*given: Any, **more: Any) -> Any:
            result = original(*given, **more)
            acts[mechanism.name] += bool(mechanism.did(result, (*given, *more.values())))
            return result

        return call

    with ExitStack() as stack:
        for mechanism in MECHANISMS:
            if mechanism.instead is not None:
                for function in mechanism.functions:
                    stack.enter_context(patch(function, watched(mechanism, _resolve(function))))
        yield


def less(settings: SearchSettings, mechanism: Mechanism) -> SearchSettings:
    """The settings of an effort without a mechanism; the same where the effort does without it anyway."""
    stage = getattr(settings, mechanism.stage)
    values = {name: stage.estimates[:1] if name == "estimates" else value for name, value in mechanism.values.items()}
    return replace(settings, **{mechanism.stage: replace(stage, **values)})


@contextmanager
def without(mechanism: Mechanism, effort: Any) -> Iterator[None]:
    """The search without a mechanism."""
    with ExitStack() as stack:
        if mechanism.stage:
            stack.enter_context(patch.dict(EFFORTS, {name: less(EFFORTS[name], mechanism) for name in EFFORTS}))
        for function in mechanism.functions:
            alone = {effort: EFFORTS[effort]}
            stack.enter_context(patch(function, mechanism.instead or alone))
        yield


def names() -> list[str]:
    """All missions, the published cases first."""
    cases = [f"case/{case.name}" for case in (*CASES, FIGURE_16)]
    return [*cases, *(f"random/{seed}" for seed in range(RANDOM_MISSIONS))]


def planned(task: tuple[str, str, str]) -> dict[str, Any]:
    """One mission planned at an effort, with everything ("") or without a mechanism."""
    name, effort, left_out = task
    acts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        mission = mission_of(name, Path(folder))
    mission = replace(mission, planning=replace(PatrolSettings.of(mission), effort=effort))
    mechanism = next((each for each in MECHANISMS if each.name == left_out), None)
    began_s = time.process_time()
    with recorded(acts) if mechanism is None else without(mechanism, effort):
        try:
            plan, met = rota.make_plan(mission, seed=0), True
        except NoPlanFound as failure:
            plan, met = failure.best, False  # type: ignore[assignment]
    robots = None if plan is None else len(plan.trajectories)
    bound = None if plan is None else plan.lower_bound_robots
    return {
        "mission": name, "effort": effort, "without": left_out, "met": met, "robots": robots, "bound": bound,
        "cpu_s": round(time.process_time() - began_s, 2), "acts": dict(acts),
    }  # fmt: skip


def acts_at(mechanism: Mechanism, effort: Any) -> bool:
    """Whether the effort's settings give the mechanism anything to do."""
    if mechanism.stage:
        return less(EFFORTS[effort], mechanism) != EFFORTS[effort]
    return mechanism.instead is not None or effort != "quick"


def tasks(effort: str, known: Known, chosen: list[str], most: int) -> Iterator[tuple[str, str, str]]:
    """What is left to do: (mission, effort, without)."""
    for name in names()[:most]:
        if (name, "") not in known:
            yield name, effort, ""
    for mechanism in MECHANISMS:
        for name in names()[:most]:
            base = known.get((name, ""))
            if base is None or (name, mechanism.name) in known or (chosen and mechanism.name not in chosen):
                continue
            if acts_at(mechanism, effort) and (mechanism.instead is None or base["acts"].get(mechanism.name)):
                yield name, effort, mechanism.name


def table(known: Known) -> str:
    """Mechanism by mechanism: missions in which it acts, and robots, unmet missions and time without it."""
    lines = ["| mechanism | missions | robots | without | unmet | without | CPU s | without |", "|---|" + "---:|" * 7]
    for mechanism in MECHANISMS:
        pairs = [(known[name, ""], line) for (name, left_out), line in known.items() if left_out == mechanism.name]
        both = [
            (a, b) for a, b in pairs if a["robots"] is not None and b["robots"] is not None and a["met"] and b["met"]
        ]
        cells = [
            str(len(pairs)), str(sum(a["robots"] for a, _ in both)), str(sum(b["robots"] for _, b in both)),
            str(sum(not a["met"] for a, _ in pairs)), str(sum(not b["met"] for _, b in pairs)),
            f"{sum(a['cpu_s'] for a, _ in pairs):.0f}", f"{sum(b['cpu_s'] for _, b in pairs):.0f}",
        ]  # fmt: skip
        lines.append(f"| {mechanism.name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def read(path: Path) -> Known:
    """What the file holds: by mission and what was left out."""
    lines = path.read_text().splitlines() if path.exists() else []
    return {(line["mission"], line["without"]): line for line in map(json.loads, lines)}


def main(arguments: list[str] | None = None) -> int:
    """Run what is left, or print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ablation", description=__doc__.splitlines()[0])
    parser.add_argument("effort", choices=("quick", "normal", "high"))
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE")
    parser.add_argument("--mechanisms", nargs="*", default=[], metavar="NAME")
    parser.add_argument("--missions", type=int, default=len(names()), metavar="N", help="the first N only")
    parser.add_argument("--processes", type=int, default=1, metavar="N")
    parser.add_argument("--table", action="store_true", help="print what the file holds")
    chosen = parser.parse_args(arguments)
    if chosen.table:
        print(table(read(chosen.output)))
        return 0
    with get_context("spawn").Pool(chosen.processes) as pool:
        while left := list(tasks(chosen.effort, read(chosen.output), chosen.mechanisms, chosen.missions)):
            for line in pool.imap_unordered(planned, left):
                with chosen.output.open("a") as file:
                    file.write(json.dumps(line) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
