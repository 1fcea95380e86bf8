"""One case of Table 5, 6 or 8: the paper's routes, those of its algorithms here, and checked plans by two methods."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from shapely import LineString, Point

from rota.check import Report
from rota.compare import MethodOutcome
from rota.draw.routes import Route, routes_of
from rota.mission import AREA, Mission
from rota.plan import Plan
from rota.plan_table import zones_served
from rota.studies.sun2019.panels import zone_title
from rota.studies.sun2019.paper import PaperCase, PaperRoute
from rota.studies.sun2019.runs import Printed
from rota.studies.tables import NOTHING, Table, number


@dataclass(frozen=True, kw_only=True)
class Case:
    """A case with all that it is compared with.

    printed: the paper's algorithms with its parameters, nothing mended. mended: the same by the method ``sun2019``,
    which mends the routes until the check passes; None where that was not run. stages: ``sun2019`` as it chooses its
    stages. tours: our method.
    """

    paper: PaperCase
    mission: Mission
    printed: Printed
    mended: MethodOutcome | None
    stages: MethodOutcome
    tours: MethodOutcome

    @property
    def lower_bound(self) -> int | None:
        """Robots below which no plan exists, proved."""
        bounds = [one.lower_bound_robots for one in self.outcomes.values()]
        return max((bound for bound in bounds if bound is not None), default=None)

    @property
    def zones(self) -> tuple[tuple[str, float], ...]:
        """Names and periods in seconds of the paper's sub-regions 1, 2 and 3."""
        rest_s = self.mission.period_s
        assert rest_s is not None
        return (*((zone.name, zone.period_s or rest_s) for zone in self.mission.zones), (AREA, rest_s))

    @property
    def unseen_m2(self) -> float:
        """Ground that the routes as printed never see."""
        return sum(demand.unseen_area_m2 for demand in self.printed.report.demands)

    @property
    def outcomes(self) -> dict[str, MethodOutcome]:
        """The plans that the check judged, by the heads of the tables' columns."""
        mended = {} if self.mended is None else {"mended": self.mended}
        return mended | {"sun2019": self.stages, "tours": self.tours}


def robots_told(outcome: MethodOutcome) -> str:
    """Robots of a plan; marked where the check does not pass it."""
    if outcome.robots is None:
        return "no plan"
    return str(outcome.robots) if outcome.met else f"{outcome.robots}, not met"


def robots_table(title: str, cases: Sequence[Case]) -> Table:
    """A row for each case: robots by the paper, by its algorithms here, by two methods, and the proved bound."""
    head = ("case", "periods s", "paper", "Eq. 26", *cases[0].outcomes, "lower bound")
    rows = []
    for case in cases:
        late = sum(route.late for route in case.paper.routes)
        rows.append(
            (
                case.paper.name,
                ", ".join(f"{period_s:g}" for period_s in case.paper.periods_s),
                f"{len(case.paper.routes)}" + (f", {late} late" if late else ""),
                str(len(case.printed.stages.segments)),
                *(robots_told(outcome) for outcome in case.outcomes.values()),
                number(case.lower_bound, "d"),
            )
        )
    if len(cases) > 1:
        sums = [[len(case.paper.routes), len(case.printed.stages.segments)] for case in cases]
        totals = [str(sum(column)) for column in zip(*sums, strict=True)]
        totals += [_total([case.outcomes[way].robots for case in cases]) for way in cases[0].outcomes]
        rows.append(("together", "", *totals, _total([case.lower_bound for case in cases])))
    return Table(title=title, head=head, rows=tuple(rows), words=(0, 1))


def _total(values: Sequence[int | None]) -> str:
    known = [value for value in values if value is not None]
    return str(sum(known)) if len(known) == len(values) else NOTHING


def gaps_table(title: str, cases: Sequence[Case]) -> Table:
    """A row for each case: how much of a period is used at worst, and what the paper's routes leave unseen here."""
    head = ("case", "paper", "Eq. 26", "as printed: m² unseen", *cases[0].outcomes)
    rows = []
    for case in cases:
        partitions = case.printed.stages.partitions
        worst = max(float((one.times_s / one.periods_s).max()) for one in partitions)
        rows.append(
            (
                case.paper.name,
                f"{max(route.time_s / route.period_s for route in case.paper.routes):.3f}",
                f"{worst:.3f}",
                f"{case.unseen_m2:,.0f}",
                *(_ratio_told(outcome.worst_ratio) for outcome in case.outcomes.values()),
            )
        )
    return Table(title=title, head=head, rows=tuple(rows))


def _ratio_told(ratio: float | None) -> str:
    return NOTHING if ratio is None else "never" if math.isinf(ratio) else f"{ratio:.3f}"


def routes_table(title: str, cases: Sequence[Case]) -> Table:
    """A row for each sub-region of each case: the times of all its routes.

    A route of ours belongs to the sub-region whose period it must keep: the smallest of those it serves.
    """
    several = len(cases) > 1
    head = ("sub-region", "T^c s", "paper: T^a s", "Eq. 26: T^a s", "as printed", "sun2019", "tours")
    rows: list[tuple[str, ...]] = []
    for case in cases:
        for k, (name, period_s) in enumerate(case.zones):
            by_formula, driven = segment_times_s(case.printed, name)
            cells = (
                zone_title(name),
                f"{period_s:.2f}",
                _listed([_paper_time(route) for route in case.paper.routes if _zone(route, case) == k]),
                _listed([f"{time_s:.2f}" for time_s in sorted(by_formula)]),
                _listed([f"{time_s:.2f}" for time_s in sorted(driven)]),
                _listed(loop_times(case.stages.plan, name)),
                _listed(loop_times(case.tours.plan, name)),
            )
            rows.append((case.paper.name if k == 0 else "", *cells) if several else cells)
    return Table(
        title=title, head=("case", *head) if several else head, rows=tuple(rows), words=(0, 1) if several else (0,)
    )


def _listed(times: list[str]) -> str:
    return ", ".join(times) or NOTHING


def _zone(route: PaperRoute, case: Case) -> int:
    """The sub-region of a route of the paper, from 0 on; where the table prints none, by its period."""
    periods_s = [period_s for _, period_s in case.zones]
    if route.zone is None or route.period_s != periods_s[route.zone - 1]:
        return periods_s.index(route.period_s)
    return route.zone - 1


def _paper_time(route: PaperRoute) -> str:
    return f"{route.time_s:.2f}" + (" (late)" if route.late else "")


def segment_times_s(printed: Printed, name: str) -> tuple[list[float], list[float]]:
    """Seconds of the segments that must keep this sub-region's period: by Eq. 26, and as their routes are driven.

    Of the sub-regions whose sensors a segment holds, that is the one deployed first.
    """
    framed = printed.stages.framed
    names = [zone.name for zone in framed.deployment.zones]
    by_formula: list[float] = []
    driven: list[float] = []
    routes = iter(printed.plan.trajectories)
    for part, partition in zip(framed.parts, printed.stages.partitions, strict=True):
        zone_of = framed.deployment.zone_of[part.sensors][part.frame.order]
        for k, time_s in enumerate(partition.times_s.tolist()):
            route = next(routes)
            # zones were deployed from the smallest period up
            if names[int(zone_of[partition.places(k, len(zone_of))].min())] == name:
                by_formula.append(time_s)
                driven.append(route.loop_duration_s)
    return by_formula, driven


def loop_times(plan: Plan | None, name: str) -> list[str]:
    """Seconds of the loops of a plan that must keep this sub-region's period, shortest first.

    ``62.83 / 2``: a loop that two robots share, so that one comes by every 31.4 s.
    """
    if plan is None:
        return []
    told = []
    for route in routes_of(plan):
        if _kept_zone(plan, route) == name:
            shared = "" if len(route.robots) == 1 else f" / {len(route.robots)}"
            told.append((route.duration_s, f"{route.duration_s:.2f}{shared}"))
    return [text for _, text in sorted(told)]


def _kept_zone(plan: Plan, route: Route) -> str | None:
    """Of the sub-regions that a loop serves, the one with the smallest period; None when it serves nothing.

    Between equal periods, the one in which more of the loop lies.
    """
    mission = plan.mission
    periods_s = {zone.name: zone.period_s or math.inf for zone in mission.zones} | {AREA: mission.period_s or math.inf}
    line = LineString(route.loop_m) if len(route.loop_m) > 1 else Point(route.loop_m[0])
    inside_m = {zone.name: float(line.intersection(zone.shape).length) for zone in mission.zones}
    inside_m[AREA] = route.length_m - sum(inside_m.values())
    served = zones_served(plan, plan.trajectories[route.robots[0]])
    if len(route.robots) > 1:
        every_s, reach_m = route.duration_s / len(route.robots), mission.fleet.sensor.reach_m
        near = [zone.name for zone in mission.zones if line.distance(zone.shape) < reach_m]
        served = tuple(zone for zone in (*near, AREA) if every_s <= periods_s[zone])
    return min(served, key=lambda zone: (periods_s[zone], -inside_m[zone]), default=None)


def unseen_told(report: Report) -> str:
    """What the check says of routes as printed, in a few words."""
    unseen_m2 = sum(demand.unseen_area_m2 for demand in report.demands)
    return f"check: {report.verdict}" + (f", {unseen_m2:,.0f} m² never seen" if unseen_m2 > 0 else "")
