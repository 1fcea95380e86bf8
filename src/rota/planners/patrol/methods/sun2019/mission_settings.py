"""The settings that missions have below ``patrol.sun2019``: ours, or those of a distribution with more algorithms.

A distribution offers an entry point of the group ``rota.sun2019``: a subclass of ``our_settings.Sun2019``, whose
fields are what missions may then say, and whose ``search`` names the function that plans by them. Without it, what only
it knows is refused with a word of who brings it (``elsewhere``).
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from rota.errors import MissionError
from rota.model.planner_registry import offers
from rota.planners.patrol.methods.sun2019 import our_settings as ours

ENTRY_POINTS = "rota.sun2019"  # the group by which other distributions offer a block of settings


def offered_settings() -> type[ours.Sun2019]:
    """The block that is offered, or else ours; MissionError where it cannot be loaded."""
    for where in offers(ENTRY_POINTS).values():
        module, _, block = where.partition(":")
        try:
            found: type[ours.Sun2019] = getattr(import_module(module), block)
        except Exception as error:
            raise MissionError(f"patrol.sun2019: its settings cannot be loaded from {where}: {error}") from error
        return found
    return ours.Sun2019


if TYPE_CHECKING:
    Sun2019 = ours.Sun2019
else:
    Sun2019 = offered_settings()
