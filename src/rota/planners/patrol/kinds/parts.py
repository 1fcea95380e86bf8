"""One group's part of a mission, planned as a mission of its own, and the plans of all parts put together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import shapely

from rota.errors import MissionError, NoPlanFound
from rota.geometry.free_space import nearest_free_point, standing_space
from rota.model.arrays import Floats
from rota.model.mission import AREA, Charger, Mission, Zone
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.kinds.division import Part
from rota.planners.patrol.kinds.groups import Group
from rota.planners.patrol.verdict import Judge
from rota.routes.moments import go_on

Stays = list[tuple[str, float, float]]

MOST_TURNS = 4  # of one kind to so many of another one, so that what they do together repeats soon


class Search(Protocol):
    """How a mission is planned whose robots are taken to be alike."""

    def __call__(self, part: Mission, *, in_full: bool, turns_s: Floats | None = None) -> Plan:
        """A plan for some of the ground; NoPlanFound where there is none.

        in_full: by all that the mission's effort allows; otherwise with the least effort, and as long as loops come.
        turns_s: how long turns of robots that charge may be; None: anything.
        """


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What came of planning a part. ratio: the longest gap over its period, above 1 where the demand is not met.

    plan: the best there is; None: none at all, or nothing to do. why: in words where the demand is not met.
    """

    plan: Plan | None
    ratio: float
    why: str = ""

    @property
    def is_met(self) -> bool:
        """Whether the part's demand is met."""
        return self.ratio <= 1

    @property
    def robots(self) -> int:
        """How many robots the plan has."""
        return 0 if self.plan is None else len(self.plan)


class Parts:
    """Parts of a mission and what came of them; each is planned once in either way."""

    def __init__(self, mission: Mission, groups: Sequence[Group], judge: Judge, search: Search) -> None:
        self._mission, self._groups, self._judge, self._search = mission, groups, judge, search
        self._known: dict[tuple[object, ...], Outcome] = {}

    @property
    def is_confined(self) -> bool:
        """Whether groups keep to ground of their own, since bodies of unlike robots would meet otherwise."""
        return any(group.robot.body_radius_m > 0 for group in self._groups)

    def outcome(
        self, k: int, part: Part, chargers: tuple[Charger, ...], *, in_full: bool, turns_s: Floats | None = None
    ) -> Outcome:
        """What comes of planning the part of group number k, see ``Search``."""
        shapes = [*(region.shape for region in part.regions), part.cell if self.is_confined else None]
        names = tuple(region.name for region in part.regions)
        told = None if turns_s is None else turns_s.tobytes()
        key = (k, names, tuple(map(shapely.to_wkb, shapes)), chargers, in_full, told)
        if key not in self._known:
            self._known[key] = self._plan_anew(k, part, chargers, in_full=in_full, turns_s=turns_s)
        return self._known[key]

    def idle(self, k: int) -> Outcome:
        """The outcome of group number k where it has nothing to do: listed robots stay, at their starts or anywhere."""
        robots = self._groups[k].robots
        if not robots:
            return Outcome(plan=None, ratio=1.0)
        space = standing_space(self._mission, robots[0].body_radius_m)
        middle = space.centroid
        anywhere = robots[0].start if space.is_empty else nearest_free_point(space, (middle.x, middle.y))
        ways = [
            Trajectory(
                robot=robot.name, loop_start_s=0.0, times_s=np.zeros(1), positions_m=np.array([robot.start or anywhere])
            )
            for robot in robots
        ]
        return Outcome(plan=Plan(mission=self._mission, trajectories=tuple(ways)), ratio=1.0)

    def _plan_anew(
        self, k: int, part: Part, chargers: tuple[Charger, ...], *, in_full: bool, turns_s: Floats | None
    ) -> Outcome:
        """The same, anew."""
        try:
            mission = self._part_of_mission(self._groups[k], part, chargers)
        except MissionError as error:  # a start or a charger outside its cell
            return Outcome(plan=None, ratio=math.inf, why=str(error))
        try:
            return Outcome(plan=self._search(mission, in_full=in_full, turns_s=turns_s), ratio=1.0)
        except NoPlanFound as failure:
            best = failure.best if isinstance(failure.best, Plan) else None
            demands = () if best is None else self._judge(best).demands
            worst = max((demand.worst_gap_s / demand.period_s for demand in demands), default=math.inf)
            return Outcome(plan=best, ratio=max(worst, math.nextafter(1, 2)), why=str(failure))

    def _part_of_mission(self, group: Group, part: Part, chargers: tuple[Charger, ...]) -> Mission:
        """The mission that asks a group's robots for its part alone. MissionError where they cannot be there."""
        area = part.cell if self.is_confined and part.cell is not None else self._mission.area
        zones = tuple(
            Zone(
                name="the rest" if region.name == AREA else region.name, period_s=region.period_s,
                demand=region.demand, shape=region.shape,
            )
            for region in part.regions
        )  # fmt: skip
        return replace(
            self._mission, area=area, zones=zones, period_s=None, fleet=group.fleet_of(self._mission.fleet),
            chargers=chargers if group.robot.battery.endurance_s is not None else (),
        )  # fmt: skip

    def together(self, outcomes: Sequence[Outcome], seed: int) -> Plan:
        """The plan of all parts; robots of kinds are called after them."""
        ways: list[Trajectory] = []
        for group, outcome in zip(self._groups, outcomes, strict=True):
            own = tuple(outcome.plan or ())
            if not group.robots:
                own = tuple(
                    replace(way, robot=f"{group.name}-{number}" if self._mission.fleet.kinds else f"robot-{number}")
                    for number, way in enumerate(own, start=1)
                )
            ways += own
        return Plan(mission=self._mission, trajectories=tuple(ways), seed=seed)

    def outcomes_in_turn(
        self, order: Sequence[int], parts: Sequence[Part], chargers: Sequence[tuple[Charger, ...]], *, in_full: bool
    ) -> dict[int, Outcome]:
        """What comes of groups that share chargers in time, each planned beside those before it in this order."""
        found: dict[int, Outcome] = {}
        for k in order:
            before = [outcome.plan for outcome in found.values() if outcome.plan is not None]
            turns_s = turns_beside(before[0]) if before else None
            outcome = self.outcome(k, parts[k], chargers[k], in_full=in_full, turns_s=turns_s)
            if before and outcome.is_met and outcome.plan is not None:
                others = [way for plan in before for way in plan]
                if (later := later_with_room(outcome.plan, others, chargers[k])) is None:
                    outcome = replace(outcome, ratio=math.nextafter(1, 2), why=self._too_few(len(order)))
                else:
                    outcome = replace(outcome, plan=later)
            elif before and self.outcome(k, parts[k], chargers[k], in_full=in_full).is_met:
                outcome = replace(outcome, why=self._too_few(len(order)))
            found[k] = outcome
        return found

    def _too_few(self, kinds: int) -> str:
        """That kinds need more places at chargers."""
        places = sum(charger.places for charger in self._mission.chargers)
        return (
            f"chargers: they have {places} place{'s'[: places > 1]} for {kinds} kinds of robots that charge, and these"
            " were not found to do with that one after the other: give more places"
        )

    def are_shared(self, parts: Sequence[Part]) -> bool:
        """Whether groups that charge are more than there are places."""
        return sum(charger.places for charger in self._mission.chargers) < len(self.charging(parts))

    def charging(self, parts: Sequence[Part]) -> list[int]:
        """The numbers of the groups that charge and have something to do."""
        return [
            k for k, group in enumerate(self._groups)
            if group.robot.battery.endurance_s is not None and parts[k].regions
        ]  # fmt: skip

    def chargers_of(self, parts: Sequence[Part], wanted: Floats) -> list[tuple[Charger, ...]]:
        """Each group's places at chargers: those nearest to its part, as many as it wants of all there are.

        wanted: robots of each group, or any measure of them. All have all where there are fewer places than groups that
        charge: then they share them in time.
        """
        charging = self.charging(parts)
        free = {charger: charger.places for charger in self._mission.chargers}
        if len(charging) < 2 or sum(free.values()) < len(charging):
            return [self._mission.chargers] * len(self._groups)
        dealt: list[dict[Charger, int]] = [{} for _ in self._groups]
        middles = [shapely.union_all([region.shape for region in part.regions]).centroid for part in parts]
        while any(free.values()):
            k = max(charging, key=lambda k: (not dealt[k], wanted[k] / (1 + sum(dealt[k].values()))))
            away_m = {each: shapely.distance(middles[k], shapely.Point(each.at)) for each in free if free[each]}
            near = min(away_m, key=lambda each: away_m[each])
            free[near] -= 1
            dealt[k][near] = dealt[k].get(near, 0) + 1
        return [tuple(replace(each, places=places) for each, places in own.items()) for own in dealt]


def turns_beside(plan: Plan) -> Floats:
    """Lengths of turns (n,) with which what robots do repeats together with what those of a plan do."""
    counts = np.arange(1.0, MOST_TURNS + 1)
    return np.unique(np.divide.outer(counts, counts)) * plan.trajectories[0].loop_duration_s


def later_with_room(plan: Plan, others: Sequence[Trajectory], chargers: Sequence[Charger]) -> Plan | None:
    """The plan begun at another moment of its round, so that chargers have places beside others; None: never."""
    lasts_s = max(one.loop_duration_s for one in (*plan, *others)) * MOST_TURNS
    theirs = [stay for one in others for stay in stays_until(one, lasts_s)]
    mine = [stay for one in plan for stay in stays_until(one, lasts_s)]
    round_s = plan.trajectories[0].loop_duration_s
    # some stay begins as another one ends
    moments_s = np.unique([(a - end_s) % round_s for _, a, _ in mine for _, _, end_s in theirs])
    for moment_s in moments_s:
        later = tuple(go_on(one, float(moment_s)) for one in plan)
        own = [stay for one in later for stay in stays_until(one, lasts_s)]
        if all(most_at_once([*own, *theirs], charger.name) <= charger.places for charger in chargers):
            return Plan(mission=plan.mission, trajectories=later, seed=plan.seed)
    return None


def stays_until(one: Trajectory, until_s: float) -> Stays:
    """The stays at chargers of a robot that does the same again and again, which begin until a moment."""
    rounds = np.arange(int(until_s / one.loop_duration_s) + 1) * one.loop_duration_s
    return [(each.charger, each.from_s + late_s, each.until_s + late_s) for late_s in rounds for each in one.charges]


def most_at_once(stays: Stays, charger: str) -> int:
    """How many of these stays are at a charger at once, at most; one ends at the moment at which another one begins."""
    spans = np.array([span for name, *span in stays if name == charger]).reshape(-1, 2)
    moments_s = spans[:, 0] + 1e-6
    return int(((spans[:, 0] <= moments_s[:, None]) & (moments_s[:, None] < spans[:, 1])).sum(axis=1).max(initial=0))
