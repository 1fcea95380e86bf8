"""A team of a given size, and the method that looks for plans with as few robots as it can."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from rota.planners.patrol.methods.method import Method


@dataclass(frozen=True, kw_only=True)
class Team:
    """How many robots there are, where they start, and by what method they are planned for.

    starting: how many robots have a start of their own in each component of the standing space.
    """

    robots: int
    starting: Counter[int]
    method: Method
