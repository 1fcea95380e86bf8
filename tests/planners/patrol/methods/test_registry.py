"""Every method that a mission may name is in the registry, and loads."""

from __future__ import annotations

import pytest

from rota.planners.patrol.methods.registry import METHODS, load_method
from rota.planners.patrol.planner_settings import METHODS as NAMES


def test_the_registry_has_the_methods_that_a_mission_may_name() -> None:
    assert set(METHODS) == set(NAMES)


@pytest.mark.parametrize("name", METHODS)
def test_methods_load_by_their_names(name: str) -> None:
    assert load_method(name).__doc__
