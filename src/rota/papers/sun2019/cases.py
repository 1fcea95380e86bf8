"""One case of Table 5, 6 or 8: the paper's routes, those of its algorithms here, and checked plans by two methods."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from shapely import LineString, Point

from rota.compare import MethodOutcome
from rota.draw.gap_map import gap_map
from rota.draw.routes import Route, routes_of
from rota.mission import AREA, Mission
from rota.papers.sun2019.panels import zone_title
from rota.papers.sun2019.paper import PaperCase, PaperRoute
from rota.papers.sun2019.runs import Printed, Runs
from rota.papers.tables import NOTHING, Table, number
from rota.plan import Plan
from rota.plan_summary import zones_served
from rota.planners.patrol.methods.sun2019.settings import MethodSettings
from rota.planners.patrol.planner_settings import Method

DEFAULTS: tuple[Method, ...] = ("sequential", "parallel", "decomposition", "sun2019", "tours")
LATE_CELLS = 60_000  # half a metre each on Figure 13's map
TIMED = ("mended", "sun2019", "tours")  # whose routes' times are told


@dataclass(frozen=True, kw_only=True)
class Case:
    """A case with all that it is compared with.

    printed: the paper's algorithms with its parameters, nothing mended. outcomes: plans that the check judged, by the
    heads of the tables' columns: the paper's algorithms with routes mended, and methods as they are by default.
    """

    paper: PaperCase
    mission: Mission
    printed: Printed
    outcomes: Mapping[str, MethodOutcome]

    @property
    def lower_bound(self) -> int | None:
        """Robots below which no plan exists, proved."""
        bounds = [outcome.lower_bound_robots for outcome in self.outcomes.values()]
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

    @cached_property
    def late_m2(self) -> float:
        """Ground that the routes as printed see, but too seldom; sampled at the middles of small cells."""
        gaps = gap_map(self.printed.plan, cells=LATE_CELLS)
        return float(gaps.late.sum()) * gaps.cell_map.cell_m**2

    @property
    def late(self) -> int:
        """Routes that Eq. 26 has no shorter than their period."""
        partitions = self.printed.stages.partitions
        return sum(int((partition.times_s >= partition.periods_s).sum()) for partition in partitions)

    @property
    def segments(self) -> int:
        """Robots by the paper's algorithms here."""
        return len(self.printed.stages.segments)


def robots_told(outcome: MethodOutcome) -> str:
    """Robots of a plan; marked where the check does not pass it."""
    if outcome.robots is None:
        return "no plan"
    return str(outcome.robots) if outcome.met else f"{outcome.robots}, not met"


def case_of(runs: Runs, case: PaperCase, mission: Mission, settings: MethodSettings) -> Case:
    """A case of the paper with all its runs."""
    printed, mended = runs.printed(mission, settings), runs.mended(mission, settings)
    methods: dict[str, MethodOutcome] = {method: runs.by_method(mission, method) for method in DEFAULTS}
    return Case(paper=case, mission=mission, printed=printed, outcomes={"mended": mended, **methods})


def case_tables(title: str, cases: Sequence[Case]) -> tuple[Table, ...]:
    """Robots, worst gaps and all routes of the cases."""
    return (
        robots_table(f"{title}: robots", cases),
        gaps_table(f"{title}: worst T^a / T^c, or worst gap / period by the check", cases),
        routes_table(f"{title}: times of the routes, s", cases),
    )


def with_late(robots: int, late: int) -> str:
    """``11, 4 late``: robots, and how many of them miss their period."""
    return f"{robots}" + (f", {late} late" if late else "")


def robots_table(title: str, cases: Sequence[Case]) -> Table:
    """A row for each case: robots by the paper, by its algorithms here, of all plans, and the proved bound."""
    head = ("case", "periods s", "paper", "Eq. 26", *cases[0].outcomes, "lower bound")
    rows = []
    for case in cases:
        late = sum(route.late for route in case.paper.routes)
        rows.append(
            (
                case.paper.name,
                ", ".join(f"{period_s:g}" for period_s in case.paper.periods_s),
                with_late(len(case.paper.routes), late),
                with_late(case.segments, case.late),
                *(robots_told(outcome) for outcome in case.outcomes.values()),
                number(case.lower_bound, "d"),
            )
        )
    if len(cases) > 1:
        totals = [str(sum(len(case.paper.routes) for case in cases)), str(sum(case.segments for case in cases))]
        totals += [_total([case.outcomes[way].robots for case in cases]) for way in cases[0].outcomes]
        rows.append(("together", "", *totals, _total([case.lower_bound for case in cases])))
    return Table(title=title, head=head, rows=tuple(rows), words=(0, 1))


def _total(values: Sequence[int | None]) -> str:
    """The sum as text; a dash where a value is missing."""
    known = [value for value in values if value is not None]
    return str(sum(known)) if len(known) == len(values) else NOTHING


def gaps_table(title: str, cases: Sequence[Case]) -> Table:
    """A row for each case: how much of a period is used at worst, and what the paper's routes leave unseen here."""
    head = ("case", "paper", "Eq. 26", "as printed: m² unseen", "as printed: m² seen too late", *cases[0].outcomes)
    rows = []
    for case in cases:
        partitions = case.printed.stages.partitions
        worst = max(float((partition.times_s / partition.periods_s).max()) for partition in partitions)
        rows.append(
            (
                case.paper.name,
                f"{max(route.time_s / route.period_s for route in case.paper.routes):.3f}",
                f"{worst:.3f}",
                f"{case.unseen_m2:,.0f}",
                f"{case.late_m2:,.0f}",
                *(_ratio_told(outcome.worst_ratio) for outcome in case.outcomes.values()),
            )
        )
    return Table(title=title, head=head, rows=tuple(rows))


def _ratio_told(ratio: float | None) -> str:
    """A worst ratio as text; a dash where it is missing."""
    return NOTHING if ratio is None else "never" if math.isinf(ratio) else f"{ratio:.3f}"


def routes_table(title: str, cases: Sequence[Case]) -> Table:
    """A row for each sub-region of each case: the times of all its routes.

    A route of ours belongs to the sub-region whose period it must keep: the smallest of those it serves.
    """
    several = len(cases) > 1
    head = ("sub-region", "T^c s", "paper: T^a s", "Eq. 26: T^a s", *TIMED)
    rows: list[tuple[str, ...]] = []
    for case in cases:
        for k, (name, period_s) in enumerate(case.zones):
            cells = (
                zone_title(name),
                f"{period_s:.2f}",
                _listed([_paper_time(route) for route in case.paper.routes if _zone(route, case) == k]),
                _listed([_our_time(time_s, period) for time_s, period in segment_times_s(case.printed, name)]),
                *(_listed(loop_times(case.outcomes[way].plan, name)) for way in TIMED),
            )
            rows.append((case.paper.name if k == 0 else "", *cells) if several else cells)
    return Table(
        title=title, head=("case", *head) if several else head, rows=tuple(rows), words=(0, 1) if several else (0,)
    )


def _our_time(time_s: float, period_s: float) -> str:
    """A route's time as text, and whether it is late."""
    return f"{time_s:.2f}" + (" (late)" if time_s >= period_s else "")


def _listed(times: list[str]) -> str:
    """Times as text; a dash for none."""
    return ", ".join(times) or NOTHING


def _zone(route: PaperRoute, case: Case) -> int:
    """The sub-region of a route of the paper, from 0 on; where the table prints none, by its period."""
    periods_s = [period_s for _, period_s in case.zones]
    if route.zone is None or route.period_s != periods_s[route.zone - 1]:
        return periods_s.index(route.period_s)
    return route.zone - 1


def _paper_time(route: PaperRoute) -> str:
    """The time of a printed route as text, and whether it is late."""
    return f"{route.time_s:.2f}" + (" (late)" if route.late else "")


def segment_times_s(printed: Printed, name: str) -> list[tuple[float, float]]:
    """Seconds of the segments that must keep this sub-region's period by Eq. 26, shortest first, each with its period.

    A segment counts for the sub-region deployed first among those whose sensors it holds.
    """
    framed = printed.stages.framed
    names = [zone.name for zone in framed.deployment.zones]
    pairs: list[tuple[float, float]] = []
    for part, partition in zip(framed.parts, printed.stages.partitions, strict=True):
        zone_of = framed.deployment.zone_of[part.sensors][part.frame.order]
        for k, times in enumerate(zip(partition.times_s.tolist(), partition.periods_s.tolist(), strict=True)):
            # zones were deployed from the smallest period up
            if names[int(zone_of[partition.places(k, len(zone_of))].min())] == name:
                pairs.append(times)
    return sorted(pairs)


def loop_times(plan: Plan | None, name: str) -> list[str]:
    """Seconds of the loops of a plan that must keep this sub-region's period, shortest first.

    ``62.83 / 2`` is a loop that two robots share: a robot comes by every 31.4 s.
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
    """The sub-region with the smallest period that a loop serves; None when it serves none.

    Between equal periods, the sub-region in which more of the loop lies.
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


def unseen_and_late(case: Case) -> str:
    """The ground that routes as printed never see, and the ground that they see too seldom."""
    asked_m2 = sum(demand.area_m2 for demand in case.printed.report.demands)
    told = [
        f"{area_m2:,.0f} m² ({100 * area_m2 / asked_m2:.1f} %) are {how}"
        for area_m2, how in (
            (case.unseen_m2, "never seen, where lanes merge or routes are cut at obstacles"),
            (case.late_m2, "seen too seldom"),
        )
        if area_m2 >= 0.5
    ]
    return ", ".join(told) or f"the check says {case.printed.report.verdict!r}"
