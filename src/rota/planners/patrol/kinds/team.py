"""The groups of a fleet with what each was found to be worth, and the parts of the ground that are planned for them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rota.geometry.free_space import demanded_regions
from rota.model.arrays import Floats
from rota.model.mission import Charger
from rota.model.plan import Plan
from rota.planners.patrol.kinds.division import Part, divisions
from rota.planners.patrol.kinds.groups import groups_of
from rota.planners.patrol.kinds.parts import Outcome, Parts, Search
from rota.planners.patrol.planner_settings import Effort, PatrolSettings
from rota.planners.patrol.verdict import worst_reached
from rota.planning.planner import Request

TRIES: dict[Effort, int] = {"quick": 6, "normal": 16, "high": 60}  # divisions of the ground that are planned


@dataclass(frozen=True, kw_only=True)
class Division:
    """The ground divided among the groups. chargers: places at them that each group has."""

    parts: Sequence[Part]
    chargers: Sequence[tuple[Charger, ...]]


class Team:
    """The groups of a mission's fleet. worth: (g,) what a robot of each is taken to see, m2/s.

    asked: (g,) what was asked of each in the last division, m2/s. tries: divisions that may be planned.
    """

    def __init__(self, request: Request, search: Search) -> None:
        self.mission = mission = request.mission
        self.should_stop, self._request = request.should_stop, request
        self.groups, self.regions = groups_of(mission.fleet), demanded_regions(mission)
        # of perfect lanes, before any part was planned
        self.worth = np.array([0.8 * group.swath_m2_s for group in self.groups])
        self.asked = np.zeros(len(self.groups))
        self.effort = PatrolSettings.of(mission).effort
        self.tries = TRIES[self.effort]
        self._parts = Parts(mission, self.groups, request.judge, search)

    def divide(self, counts: Floats, number: int) -> Division:
        """The division of this number for so many robots of each group; the last one where there are fewer."""
        ways = divisions(
            self.regions, self.groups, counts, self.worth, self.mission.area, confined=self._parts.is_confined
        )
        parts: Sequence[Part] = list(itertools.islice(ways, number + 1))[-1]
        return Division(parts=parts, chargers=self._parts.chargers_of(parts, counts))

    def plan_parts(self, division: Division, *, in_full: bool) -> list[Outcome]:
        """What comes of each group's part, see ``Search``. Listed robots with nothing to do stay where they are."""
        self.asked = np.array([part.asked_m2_s for part in division.parts])
        charging = self._parts.charging(division.parts)
        orders = [charging, charging[::-1]] if self._parts.are_shared(division.parts) else [[]]
        for order in orders:
            in_turn = self._parts.outcomes_in_turn(order, division.parts, division.chargers, in_full=in_full)
            if all(outcome.is_met for outcome in in_turn.values()):
                break
        return [
            in_turn[k] if k in in_turn
            else self._parts.outcome(k, part, division.chargers[k], in_full=in_full) if part.regions
            else self._parts.idle(k)
            for k, part in enumerate(division.parts)
        ]  # fmt: skip

    def join(self, outcomes: Sequence[Outcome]) -> tuple[Plan, str]:
        """The plan of all parts, and what is wrong with it as a whole; nothing where the judge passes it."""
        plan = self._parts.together(outcomes, self._request.seed)
        verdict = self._request.judge(plan)
        return plan, "" if verdict.verdict == "met" else worst_reached(verdict)

    def tell(self, share: float, doing: str) -> None:
        """Tell how far the search has come."""
        self._request.progress(share, doing)
