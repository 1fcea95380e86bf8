"""The methods of the patrol planner by the names that a mission may give; none is loaded before it is asked for."""

from __future__ import annotations

from importlib import import_module
from typing import cast

from rota.planners.patrol.methods.method import Method

METHODS = {
    "tours": "rota.planners.patrol.methods.tours:fewest_robots_anywhere",
    "sequential": "rota.planners.patrol.methods.sweeping.search:sweep_sequentially",
    "parallel": "rota.planners.patrol.methods.sweeping.search:sweep_in_parallel",
    "decomposition": "rota.planners.patrol.methods.sweeping.search:sweep_decomposed",
    "sun2019": "rota.planners.patrol.methods.sun2019.search:fewest_robots_by_stages",
}


def load_method(name: str) -> Method:
    """The method of this name; KeyError when there is none."""
    module, function = METHODS[name].split(":")
    return cast(Method, getattr(import_module(module), function))
