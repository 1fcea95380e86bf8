"""Settings small enough for tests."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rota_studies.chen2018.runs import Runs, StudySettings

SMALL = StudySettings(
    seeds=2,
    steps=60,
    scales=(4, 9),
    scale_seeds=1,
    scale_steps=50,
    large_robots=40,
    large_steps=40,
    timed_steps=5,
    timed_seeds=2,
    large_seeds=1,
    gain_seeds=1,
    claim_seeds=1,
    long_steps=60,
    process_seeds=1,
    process_s=2.0,
)


@pytest.fixture(scope="session")
def settings() -> StudySettings:
    return SMALL


@pytest.fixture
def make_runs(settings: StudySettings) -> Callable[..., Runs]:
    def make(seed: int = 0, should_stop: Callable[[], bool] = lambda: False) -> Runs:
        return Runs(settings, seed=seed, tell=lambda _: None, should_stop=should_stop)

    return make
