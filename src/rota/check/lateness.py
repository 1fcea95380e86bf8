"""How late places are where a plan takes over from another one: what was driven before counts, by the same intervals.

A place is late at a moment when it was not seen within its period before it. All is asked of gaps between two sights
that end after a moment. Sample points bound them from below. From above the ground is judged in pieces, as that of any
plan, for limits just above what the samples say; where a piece shows more, limits are raised and it is judged again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from rota.check.counting import Names, groups_of
from rota.check.demands import DemandedGround, demands_of
from rota.check.findings import Findings
from rota.check.late_report import LateDemand, Lateness
from rota.check.late_samples import Sampled, long_enough_s, sample_demand, sights_across
from rota.check.report import Report
from rota.check.revisits import Sights
from rota.check.tiled_ground import findings_by_group
from rota.check.tolerances import PERIOD_TOLERANCE
from rota.model.plan import Plan

ROUNDS = 8  # in which limits are raised
FIRST_S, FIRST = 0.02, 0.004  # above what samples say, and a share of it: doubled in each round
MOST_OPEN = 2  # rounds in which no place shows more and yet some piece is in doubt


def lateness_of(plan: Plan, report: Report, *, finest_m: float, on_the_way: Callable[[], None] | None) -> Lateness:
    """How late places are from the moment on at which the plan takes over; ``report``: on its loops.

    What was not seen in the time that is told of before counts as seen when that begins. Only for a plan with a seam.
    """
    assert plan.seam is not None
    demands = demands_of(plan.mission)
    ever = all(demand.outcome == "met" for demand in report.demands)
    within_s = long_enough_s(demands, ever)
    across = {names: sights_across(plan, plan.seam, names, within_s) for names, _ in groups_of(demands)}
    sights = {names: one for names, one in across.items() if one is not None}
    if len(sights) < len(across):
        unknown = [
            LateDemand(name=d.name, worst_s=math.inf, worst_at_least_s=0.0, place_m=None, time_s=None) for d in demands
        ]
        return Lateness(
            at_s=plan.seam.at_s, lost=plan.seam.lost, demands=tuple(unknown), late_m2_s=math.inf, holds_again_s=None
        )
    sampled = [sample_demand(sights[demand.sensors], plan, k, demand) for k, demand in enumerate(demands)]
    bracket = _Bracket(plan, sights, demands, finest_m, on_the_way)
    worst = [_with_loops(one, report) for one in bracket.worst(sampled)]
    if ever and all(one.worst_s == 0 for one in worst):
        again_s: float | None = 0.0
    else:
        again_s = bracket.holds_again_s(max((one.last_s for one in sampled), default=0.0)) if ever else None
    return Lateness(
        at_s=plan.seam.at_s,
        lost=plan.seam.lost,
        demands=tuple(worst),
        late_m2_s=sum(one.late_m2_s for one in sampled) if ever else math.inf,
        holds_again_s=again_s,
    )


def _with_loops(late: LateDemand, report: Report) -> LateDemand:
    """How late a demand is, with what its loops come to for ever, where these do not meet it."""
    (demand,) = (one for one in report.demands if one.name == late.name)
    if demand.outcome == "met":
        return late
    over_s = demand.worst_gap_at_least_s - demand.period_s
    told = next((one for one in report.violations if one.kind == "gap" and one.who == late.name), None)
    if over_s > late.worst_at_least_s and told is not None:
        late = replace(late, worst_at_least_s=over_s, place_m=told.place_m, time_s=told.time_s)
    return replace(late, worst_s=max(late.worst_s, late.worst_at_least_s, demand.worst_gap_s - demand.period_s))


class _Bracket:
    """The same from above: the ground is judged in pieces for limits that are raised until they are shown."""

    def __init__(
        self, plan: Plan, sights: dict[Names, Sights], demands: Sequence[DemandedGround], finest_m: float,
        on_the_way: Callable[[], None] | None,
    ) -> None:  # fmt: skip
        self.mission, self.sights, self.demands = plan.mission, sights, demands
        self.finest_m, self.on_the_way = finest_m, on_the_way

    def _judge(self, limits_s: Sequence[float], after_s: float) -> list[Findings]:
        """Gaps that end after the moment, against these limits."""

        def sights_by(names: Names) -> Sights:
            """The sights of those that count, with gaps that end after the moment."""
            sights = self.sights[names]
            assert sights.seam is not None
            from_s, _, loops_s, to_s = sights.seam.moments_s
            return replace(sights, seam=replace(sights.seam, moments_s=(from_s, after_s, loops_s, to_s)))

        asked = tuple(replace(one, period_s=limit) for one, limit in zip(self.demands, limits_s, strict=True))
        return findings_by_group(self.mission, asked, sights_by, self.finest_m, self.on_the_way)

    def worst(self, sampled: list[Sampled]) -> list[LateDemand]:
        """How late each demand is."""
        found = [(one.gap_s, one.begin_s, one.place_m) for one in sampled]
        points = [demand.demand == "every_point" for demand in self.demands]
        uppers_s = [one.gap_s for one in sampled]
        more, open_ones = 1, [k for k, own in enumerate(points) if own and math.isfinite(found[k][0])]
        doubts = [0] * len(points)
        for _ in range(ROUNDS):
            if not open_ones:
                break
            limits = [
                max(d.period_s, gap + more * max(FIRST_S, FIRST * gap))
                for d, (gap, _, _) in zip(self.demands, found, strict=True)
            ]
            findings = self._judge([limit if k in open_ones else math.inf for k, limit in enumerate(limits)], 0.0)
            for k in list(open_ones):
                one = findings[k]
                uppers_s[k] = max(one.upper_s, found[k][0])
                if one.worst_place_m is not None:
                    found[k] = (one.worst_s, one.worst_begin_s, one.worst_place_m)
                    if math.isinf(one.worst_s):
                        open_ones.remove(k)
                elif not one.undecided_cells or uppers_s[k] <= limits[k] or doubts[k] == MOST_OPEN:
                    open_ones.remove(k)
                else:
                    doubts[k] += 1
            more *= 2
        return [
            _late(demand, upper_s, *what) for demand, upper_s, what in zip(self.demands, uppers_s, found, strict=True)
        ]

    def holds_again_s(self, last_s: float) -> float | None:
        """From when on no place is late, as far as that is shown; last_s: some point is late until then."""
        if math.isinf(last_s):
            return None
        if not any(demand.demand == "every_point" for demand in self.demands):
            return last_s
        more_s, again_s = FIRST * last_s, last_s
        for _ in range(ROUNDS):
            findings = self._judge([demand.period_s for demand in self.demands], again_s + more_s)
            later = [one for one in findings if one.worst_place_m is not None]
            if not later:
                return None if any(one.undecided_cells for one in findings) else again_s + more_s
            ends_s = [one.worst_begin_s + one.worst_s for one in later]
            again_s = max([again_s, *(end_s for end_s in ends_s if math.isfinite(end_s))])
            more_s = max(FIRST_S, FIRST * again_s, 2 * more_s)
        return None


def _late(
    demand: DemandedGround, upper_s: float, gap_s: float, begin_s: float, place_m: tuple[float, float]
) -> LateDemand:
    """How late a demand is whose gaps lie between these."""
    late = gap_s > demand.period_s * (1 + PERIOD_TOLERANCE)
    over_s = upper_s - demand.period_s if upper_s > demand.period_s * (1 + PERIOD_TOLERANCE) else 0.0
    return LateDemand(
        name=demand.name,
        worst_s=max(0.0, over_s),
        worst_at_least_s=gap_s - demand.period_s if late else 0.0,
        place_m=place_m if late else None,
        time_s=begin_s if late else None,
    )
