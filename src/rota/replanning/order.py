"""The order of plans that take over: of two, the one with the lesser rank is better."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from rota.model.limits import LONGEST_S
from rota.model.mission import AREA, Fleet, ImportanceMap, Mission
from rota.model.plan import Plan, Trajectory

if TYPE_CHECKING:
    from rota.check.late_report import ForEver, LateSample
    from rota.check.report import Report

RATIO_DIGITS, LATE_DIGITS = 2, 1  # to which plans are compared: sample points are no nearer to the worst ones
LOOP_POINTS = 100  # of each demand at which it is seen what depends on a loop
SOON = 2.0  # longest periods: when all hold again within so many, how late places are matters more than how long
NEARLY = 1 + 1e-6  # so many times its period a gap is met for ever, as far as sample points go

Rank = tuple[float, ...]


def levels_of(mission: Mission) -> list[frozenset[str]]:
    """The names of demands by their importance, the most important ones first; without any, all are one level."""
    ground = 1.0 if mission.importance is None or isinstance(mission.importance, ImportanceMap) else mission.importance
    worth = {zone.name: ground if zone.importance is None else zone.importance for zone in mission.zones}
    worth[AREA] = ground
    asked = {zone.name for zone in mission.zones if zone.period_s is not None}
    asked |= set() if mission.period_s is None else {AREA}
    return [
        frozenset(name for name in asked if worth[name] == value)
        for value in sorted({worth[name] for name in asked}, reverse=True)
    ]


class Order:
    """Ranks of plans of a mission.

    Plans that meet all come first, of these such after which all periods hold again soon; then those whose more
    important demands miss less: level by level less ground that is never seen, and then the least worst ratio of gap to
    period.
    """

    def __init__(self, mission: Mission) -> None:
        self._mission, self.levels = mission, levels_of(mission)
        periods_s = [mission.period_s or 0.0, *(zone.period_s or 0.0 for zone in mission.zones)]
        self._soon_s = SOON * max(periods_s)

    def for_ever(self, demands: Sequence[ForEver]) -> Rank:
        """What loops alone decide, level by level: ground that is never seen, and the worst ratio; 0: all is met."""
        rank: list[float] = []
        for level in self.levels:
            own = [one for one in demands if one.name in level]
            ratio = max((one.ratio for one in own), default=0.0)
            rank += [sum(one.unseen_m2 for one in own), round(ratio, RATIO_DIGITS) if ratio > NEARLY else 0.0]
        return tuple(rank)

    def of_report(self, report: Report) -> Rank:
        """The part of a rank that loops alone decide, by the check."""
        return (0.0,) if report.verdict == "met" else (1.0, *self.for_ever(list(_for_ever(report))))

    def of_plan(self, report: Report, changed: int) -> Rank:
        """The rank of a plan that can be driven, in which so many robots are not on their ways as before."""
        late = report.lateness
        assert late is not None
        worst_s = round(max((one.worst_at_least_s for one in late.demands), default=0.0), LATE_DIGITS)
        if report.verdict != "met":
            return *self.of_report(report), worst_s, changed
        again_s = math.inf if late.holds_again_s is None else late.holds_again_s
        again_s = round(again_s, LATE_DIGITS) if math.isfinite(again_s) else again_s
        return *self.of_report(report), again_s > self._soon_s, worst_s, again_s, changed, late.late_m2_s

    def of_sample(self, sample: LateSample, changed: int) -> Rank:
        """The rank of a plan as far as sample points tell."""
        last_s = round(sample.last_s, LATE_DIGITS) if math.isfinite(sample.last_s) else sample.last_s
        late = last_s > self._soon_s, round(sample.worst_s, LATE_DIGITS), last_s
        return *self.for_ever(sample.for_ever), *late, changed, sample.late_m2_s

    def is_on_time(self, sampled: Rank) -> bool:
        """Whether sample points tell that all is met and nothing late: then others can change fewer ways at best."""
        return not any(sampled[: 2 * len(self.levels) + 3])

    def ease_all_but(self, mission: Mission, count: int, times: float) -> Mission:
        """A mission with these demands, but for so many levels with so many times the periods; inf: with none at all.

        The levels that keep theirs are the most important ones.
        """
        kept = frozenset().union(*self.levels[:count])

        def ease(name: str, period_s: float | None) -> float | None:
            if name in kept or period_s is None:
                return period_s
            return None if math.isinf(times) else min(times * period_s, LONGEST_S)

        zones = tuple(replace(zone, period_s=ease(zone.name, zone.period_s)) for zone in mission.zones)
        return replace(mission, zones=zones, period_s=ease(AREA, mission.period_s))

    def importance_of(self, loops: Sequence[Trajectory], team: Fleet) -> dict[str, float]:
        """How important is what depends on each loop, by the names of a team's robots; nothing where all is alike.

        Without the loop some demand of that level misses more; 0: none does.
        """
        from rota.check import sample_loops

        if len(self.levels) < 2:
            return {}

        def ranks(kept: Sequence[Trajectory]) -> Rank:
            mission = replace(self._mission, fleet=team)
            return self.for_ever(sample_loops(Plan(mission=mission, trajectories=tuple(kept)), LOOP_POINTS))

        whole, found = ranks(loops), {}
        for loop in loops:
            less = ranks([one for one in loops if one is not loop])
            worse = [k // 2 for k, (one, other) in enumerate(zip(less, whole, strict=True)) if one > other]
            found[loop.robot] = float(len(self.levels) - worse[0]) if worse else 0.0
        return found


def _for_ever(report: Report) -> Iterable[ForEver]:
    """What the check says of each demand for ever."""
    from rota.check.late_report import ForEver

    for demand in report.demands:
        gap_s = demand.worst_gap_at_least_s
        ratio = gap_s / demand.period_s if math.isfinite(gap_s) else 0.0
        yield ForEver(demand.name, demand.unseen_area_m2, ratio)
