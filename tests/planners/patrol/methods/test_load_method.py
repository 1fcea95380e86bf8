"""Every method that a mission may name loads, and settings take their names from the one table."""

from __future__ import annotations

import pytest

from rota.errors import MissionError
from rota.planners.patrol.method_table import METHODS
from rota.planners.patrol.methods.method import load_method
from rota.planners.patrol.planner_settings import PatrolSettings


@pytest.mark.parametrize("name", METHODS)
def test_methods_load_by_their_names(name: str) -> None:
    assert load_method(name).__doc__
    assert PatrolSettings(method=name).method == name


def test_other_names_are_refused_with_those_that_there_are() -> None:
    with pytest.raises(MissionError, match=r"tours.*parallel.*sequential.*decomposition.*sun2019"):
        PatrolSettings(method="spiral")
