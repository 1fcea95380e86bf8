"""The cheapest fleet of kinds of robots: fleets are tried, each with divisions of the ground among its kinds."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from rota.errors import NoPlanFound
from rota.model.plan import Plan
from rota.planners.patrol.kinds.cost_bound import CostBound, cost_bound
from rota.planners.patrol.kinds.division import load_of
from rota.planners.patrol.kinds.parts import Outcome
from rota.planners.patrol.kinds.team import Division, Team

HOPEFUL = 1.1  # times what a fleet seems to be able to do that it is tried with
IN_FULL = 0.3  # of the divisions tried, that may be planned by all that the effort allows

Fleet = tuple[int, ...]  # robots of each kind


def plan_cheapest(team: Team) -> Plan:
    """The plan with the cheapest fleet of a mission's kinds that is found, with a bound on the cost.

    Each kind alone comes first, then mixed fleets in the order of their costs, as far as what a robot of each kind saw
    in the plans before lets hope that they do. Where the mission's effort is not the least, all are tried with that
    first; the cheapest is planned again by all that the effort allows, and so are fleets that are cheaper yet. Raises
    NoPlanFound where no fleet is found.
    """
    search = _Cheapest(team, cost_bound(team.mission, team.groups, team.regions))
    if team.effort == "quick":
        search.try_fleets(team.tries, 0.0, alone=True, in_full=True)
    else:
        search.try_fleets(team.tries, 0.0, alone=True, in_full=False)
        search.plan_best_in_full()
        search.try_fleets(math.ceil(IN_FULL * team.tries), 0.5, alone=False, in_full=True)
    bound = search.bound
    if search.best is None:
        raise NoPlanFound(f"no fleet of these kinds was found that meets the demand: {search.why}", best=search.failed)
    return replace(
        search.best, lower_bound_robots=bound.robots, lower_bound_cost=bound.cost, lower_bound_reason=bound.reason
    )


class _Cheapest:
    """What is found so far: the best plan, and its cost; why: of the last fleet that failed, and failed: its plan."""

    def __init__(self, team: Team, bound: CostBound) -> None:
        self.team, self.bound = team, bound
        self.best: Plan | None = None
        self._best_division: Division | None = None
        self.failed: Plan | None = None
        self.cost, self.why = math.inf, "nothing was tried"
        self._costs = np.array([group.cost for group in team.groups])
        self._most = [1] * len(team.groups)  # robots of each that may be of use, as far as is known
        self._tried: set[tuple[Fleet, int]] = set()

    def try_fleets(self, most: int, begun: float, *, alone: bool, in_full: bool) -> None:
        """Try so many fleets at most, until one costs no more than is proved. begun: how far the search has come.

        alone: each kind by itself first. in_full: see ``Search``.
        """
        self._tried.clear()
        for number, (fleet, way) in enumerate(self._fleets(most, alone=alone)):
            # a stop waits for the very first attempt
            if self.cost <= self.bound.cost or (self.team.should_stop() and (number or not alone)):
                return
            words = ", ".join(f"{n} {group.name}" for n, group in zip(fleet, self.team.groups, strict=True) if n)
            self.team.tell(begun + 0.4 * number / (most + len(self.team.groups)), f"trying {words}")
            self._tried.add((fleet, way))
            try:
                division = self.team.divide(np.array(fleet, dtype=np.float64), way)
            except NoPlanFound as failure:  # kinds that charge are more than places at chargers
                self.why = str(failure)
                continue
            self._attempt(division, in_full=in_full)

    def plan_best_in_full(self) -> None:
        """Plan the cheapest fleet's division by all that the effort allows; what is no dearer is taken."""
        if self._best_division is not None and not self.team.should_stop():
            self.team.tell(0.4, "looking for better loops of the cheapest fleet")
            self._attempt(self._best_division, in_full=True)

    def _fleets(self, most: int, *, alone: bool) -> Iterator[tuple[Fleet, int]]:
        """Fleets to try, each with the number of a division. alone: each kind by itself first, where that may do."""
        team = self.team
        whole = sum(map(load_of, team.regions))
        for k, group in enumerate(team.groups if alone else ()):
            needed = math.ceil(whole / team.worth[k]) or 1
            may_do = group.most is None or whole <= HOPEFUL * team.worth[k] * group.most
            if may_do and all(group.serves(region) for region in team.regions):
                yield tuple(needed if i == k else 0 for i in range(len(team.groups))), 0
        for _ in range(most):
            hopeful = next(self._hopeful(whole), None)
            if hopeful is None:
                return
            yield hopeful

    def _attempt(self, division: Division, *, in_full: bool) -> None:
        """Plan for a division of the ground; parts may take other numbers of robots than it was made for."""
        outcomes = self.team.plan_parts(division, in_full=in_full)
        self._learn(outcomes)
        if late := [outcome.why for outcome in outcomes if not outcome.is_met]:
            self.why = late[0]
            return
        used, groups = [outcome.robots for outcome in outcomes], self.team.groups
        cost = float(self._costs @ used)
        crowd = [group for n, group in zip(used, groups, strict=True) if group.most is not None and n > group.most]
        if crowd:
            self.why = f"{crowd[0].most} {crowd[0].name} do not suffice"
        elif cost < self.cost or (in_full and cost == self.cost):
            plan, wrong = self.team.join(outcomes)
            if wrong:
                self.failed, self.why = plan, wrong
            else:
                self.best, self.cost, self._best_division = plan, cost, division

    def _learn(self, outcomes: Sequence[Outcome]) -> None:
        """What a robot of each kind was worth in its part: one saw that much, of several half a robot was idle.

        Far and urgent zones take robots that see little, so that no kind counts for less than half of its swath.
        """
        for k, (outcome, group) in enumerate(zip(outcomes, self.team.groups, strict=True)):
            self._most[k] = max(self._most[k], outcome.robots)
            if outcome.robots > 1:
                self.team.worth[k] = self.team.asked[k] / (outcome.robots - 0.5)
            elif outcome.robots == 1:
                self.team.worth[k] = max(self.team.worth[k], self.team.asked[k])
            self.team.worth[k] = max(self.team.worth[k], 0.5 * group.swath_m2_s)

    def _hopeful(self, whole: float) -> Iterator[tuple[Fleet, int]]:
        """Fleets that may do what is asked, the cheapest first, of equal cost the strongest; none was tried so."""
        team = self.team
        serves = np.array([[group.serves(region) for group in team.groups] for region in team.regions])
        loads = np.array([load_of(region) for region in team.regions])
        most = [
            min(10**9 if group.most is None else group.most, max(own, math.ceil(HOPEFUL * whole / worth) + 1))
            for group, worth, own in zip(team.groups, team.worth, self._most, strict=True)
        ]
        while math.prod(n + 1 for n in most) > 200_000:  # fleets to compare
            most = [max(1, n // 2) for n in most]
        fleets = np.array(list(itertools.product(*(range(n + 1) for n in most))), dtype=np.int64)
        costs, sees = fleets @ self._costs, fleets * (team.worth * HOPEFUL)
        good = (costs >= self.bound.cost * (1 - 1e-12)) & (costs < self.cost * (1 - 1e-12))
        good &= (fleets.sum(axis=1) >= self.bound.robots) & (sees.sum(axis=1) >= whole)
        for own in np.unique(serves, axis=0):
            asked = loads[(serves == own).all(axis=1)].sum()
            good &= (sees[:, own].sum(axis=1) >= asked) & (fleets[:, own].sum(axis=1) > 0)
        fleets, costs, sees = fleets[good], costs[good], sees[good]
        for fleet in map(tuple, fleets[np.lexsort((-sees.sum(axis=1), costs))].tolist()):
            for way in range(2):  # divisions of the ground for one fleet
                if (fleet, way) not in self._tried:
                    yield fleet, way
