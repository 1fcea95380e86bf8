"""What a method of the patrol planner is: a search for a plan with as few robots as it can find."""

from __future__ import annotations

from typing import Protocol

from rota.planners.patrol.context import Context
from rota.planners.patrol.repair.repair import Repaired


class Method(Protocol):
    """A method, as the registry loads it."""

    def __call__(self, context: Context) -> Repaired:
        """The plan with the fewest robots that this method finds, met or not."""
        ...
