"""Settings small enough for tests, and plans that take no search."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from rota.compare import MethodOutcome
from rota.mission import Mission
from rota.papers.sun2019 import runs as runs_module
from rota.papers.sun2019.runs import Printed, Runs, StudySettings
from rota.planners.patrol.methods.sun2019.deploy_settings import DeploySettings
from rota.planners.patrol.methods.sun2019.frame_settings import PartitionSettings, TourSettings
from rota.planners.patrol.methods.sun2019.route_lengths import segment_lengths_m
from rota.planners.patrol.methods.sun2019.route_settings import RouteSettings
from rota.planners.patrol.methods.sun2019.settings import MethodSettings
from rota.planners.patrol.methods.sun2019.tour import Frame
from rota.planners.patrol.planner_settings import PatrolSettings

SMALL = MethodSettings(
    deployments=(DeploySettings(iterations=3, swarms=4, particles=4, cell_m=4.0),),
    tour=TourSettings(method="genetic", generations=300, population=40),
    partition=PartitionSettings(method="pso", joining_legs=True, margin_s=0.5, iterations=4, swarms=4, particles=20),
    route=RouteSettings(routes="printed"),
)


@pytest.fixture(scope="session")
def settings() -> StudySettings:
    return StudySettings(figure_13=SMALL, figure_16=SMALL, further_seeds=1)


@pytest.fixture
def make_runs(settings: StudySettings) -> Callable[..., Runs]:
    def make(seed: int = 0, should_stop: Callable[[], bool] = lambda: False) -> Runs:
        return Runs(settings, seed=seed, tell=lambda _: None, should_stop=should_stop)

    return make


@pytest.fixture(scope="session")
def printed_by_name() -> dict[str, Printed]:
    """The printed routes of a map under the small settings, seed 0, each run once in all tests."""
    return {}


@pytest.fixture
def without_search(printed_by_name: dict[str, Printed], monkeypatch: pytest.MonkeyPatch) -> list[Mission]:
    """Methods answer at once with the small settings' printed routes, lengths of routes are estimated.

    The missions that methods were asked to plan so far.
    """
    asked: list[Mission] = []
    run_it = Runs.printed

    def printed(runs: Runs, mission: Mission, settings: MethodSettings) -> Printed:
        assert (runs.seed, settings) == (0, SMALL)
        if mission.name not in printed_by_name:
            printed_by_name[mission.name] = run_it(runs, mission, settings)
        return printed_by_name[mission.name]

    def answer(mission: Mission, **_: Any) -> MethodOutcome:
        asked.append(mission)
        known = printed_by_name[mission.name]
        return MethodOutcome(
            method=PatrolSettings.of(mission).method,
            plan=known.plan,
            report=known.report,
            planning_s=0.0,
            reason="late",
        )

    def mended(runs: Runs, mission: Mission, settings: MethodSettings) -> MethodOutcome:
        known = runs.printed(mission, settings)
        return MethodOutcome(method="sun2019", plan=known.plan, report=known.report, planning_s=0.0, reason="late")

    def lengths_m(frame: Frame, *_: Any, radius_m: float, joining_legs: bool, **__: Any) -> np.ndarray:
        return 2 * segment_lengths_m(frame.legs_m, joining_legs=joining_legs) + 2 * np.pi * radius_m

    monkeypatch.setattr(Runs, "printed", printed)
    monkeypatch.setattr(Runs, "mended", mended)
    monkeypatch.setattr(runs_module, "route_lengths_m", lengths_m)

    monkeypatch.setattr(runs_module, "outcome_of", answer)
    monkeypatch.setattr(runs_module, "load_compiled_loops", lambda: None)
    return asked
