"""Settings small enough for tests, and plans that take no search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import pytest

from rota.check import check_plan
from rota.compare import MethodOutcome
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota_studies.sun2019.kept import found_of
from rota_studies.sun2019.printed_settings import AS_PRINTED
from rota_studies.sun2019.results import Found, Printed
from rota_studies.sun2019.runs import Runs, StudySettings
from rota_studies.sun2019_method.algorithms import PaperAlgorithms
from rota_studies.sun2019_method.mission_settings import FrameSettings, SegmentSettings, SensorSettings

SMALL = replace(
    AS_PRINTED,
    sensors=SensorSettings(iterations=3, swarms=4, particles=4, cell_m=4.0),
    frame=FrameSettings(generations=300, population=40),
    segments=SegmentSettings(iterations=4, swarms=4, particles=20),
)


class Asked(NamedTuple):
    """A method that was asked for a plan."""

    mission: str
    method: str
    effort: str | None


@pytest.fixture(scope="session")
def settings() -> StudySettings:
    return StudySettings(figure_13=SMALL, figure_16=SMALL, seeds=2, reading_seeds=1)


@pytest.fixture
def make_runs(settings: StudySettings) -> Callable[..., Runs]:
    def make(**shared: Any) -> Runs:
        runs = Runs(settings, **shared)
        quick = replace(runs.figure_13.partition, times="estimate")  # hundreds of routes would be measured
        runs.figure_13 = runs.figure_16 = replace(runs.figure_13, partition=quick)
        return runs

    return make


@pytest.fixture(scope="session")
def printed_by_name() -> dict[tuple[str, int], Printed]:
    """The printed routes of a map under the small settings by seed, each run once in all tests."""
    return {}


@pytest.fixture
def without_search(printed_by_name: dict[tuple[str, int], Printed], monkeypatch: pytest.MonkeyPatch) -> list[Asked]:
    """Methods answer at once with the small settings' printed routes, of seed 0. What was asked so far."""
    asked: list[Asked] = []
    run_it = Runs.printed

    def printed(runs: Runs, mission: Mission, settings: PaperAlgorithms, seed: int | None = None) -> Printed:
        at = runs.seed if seed is None else seed
        if (mission.name, at) not in printed_by_name:
            printed_by_name[mission.name, at] = run_it(runs, mission, settings, at)
        return printed_by_name[mission.name, at]

    def found(runs: Runs, mission: Mission) -> Found:
        routes = runs.printed(mission, runs.figure_13).routes
        assert routes is not None
        plan = Plan(mission=mission, trajectories=routes)
        outcome = MethodOutcome(method="tours", plan=plan, report=check_plan(plan), planning_s=0.0, reason="late")
        return found_of(outcome, drawn=True)

    def by_method(runs: Runs, mission: Mission, method: str, *, effort: str | None = None) -> Found:
        asked.append(Asked(mission.name, method, effort))
        return found(runs, mission)

    monkeypatch.setattr(Runs, "printed", printed)
    monkeypatch.setattr(Runs, "by_method", by_method)
    monkeypatch.setattr(Runs, "mended", lambda runs, mission, _: found(runs, mission))
    return asked
