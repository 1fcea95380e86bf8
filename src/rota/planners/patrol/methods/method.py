"""What a method of the patrol planner is: a search for a plan with as few robots as it can find."""

from __future__ import annotations

from importlib import import_module
from typing import Protocol, cast

from rota.planners.patrol.context import Context
from rota.planners.patrol.method_table import METHODS
from rota.planners.patrol.repair.repair import Repaired


class Method(Protocol):
    """A method, as ``load_method`` finds it by its name."""

    def __call__(self, context: Context) -> Repaired:
        """The plan with the fewest robots that this method finds, met or not."""
        ...


def load_method(name: str) -> Method:
    """The method of this name; KeyError when there is none."""
    module, function = METHODS[name].split(":")
    return cast(Method, getattr(import_module(module), function))
