"""One case of Table 5, 6 or 8: the paper's routes, those of its algorithms here, and checked plans by two methods."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rota.model.mission import AREA, Mission
from rota.planners.patrol.planner_settings import Method
from rota_studies.sun2019.panels import zone_title
from rota_studies.sun2019.paper import PaperCase, PaperRoute
from rota_studies.sun2019.results import Found, Printed
from rota_studies.sun2019.runs import Runs
from rota_studies.sun2019_method.algorithms import PaperAlgorithms
from rota_studies.tables import NOTHING, Table, number, plus_minus

DEFAULTS: tuple[Method, ...] = ("sequential", "parallel", "decomposition", "sun2019", "tours")
TIMED = ("mended", "sun2019", "tours")  # whose routes' times are told


@dataclass(frozen=True, kw_only=True)
class Case:
    """A case with all that it is compared with.

    printed: the paper's algorithms with its parameters, nothing mended, by seed; the first is drawn. outcomes: plans
    that the check judged, by the heads of the tables' columns: the paper's algorithms with routes mended, and methods
    as they are by default, with the first ``seed``.
    """

    paper: PaperCase
    mission: Mission
    seed: int
    printed: tuple[Printed, ...]
    outcomes: Mapping[str, Found]

    @property
    def shown(self) -> Printed:
        """The run that is drawn."""
        return self.printed[0]

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
    def names(self) -> tuple[str, ...]:
        """The names of the sub-regions."""
        return tuple(name for name, _ in self.zones)

    @property
    def theirs(self) -> tuple[int, ...]:
        """The paper's robots by sub-region."""
        of = [paper_zone(route, self) for route in self.paper.routes]
        return tuple(of.count(k) for k in range(len(self.zones)))

    @property
    def ours(self) -> NDArray[np.int64]:
        """(seeds, sub-regions) robots by Eq. 26."""
        return np.array([[len(one.of_zone(name)) for name in self.names] for one in self.printed])

    @property
    def robots(self) -> list[int]:
        """By Eq. 26, seed by seed."""
        return [one.robots for one in self.printed]

    @property
    def late(self) -> list[int]:
        """Routes that Eq. 26 has no shorter than their period, seed by seed."""
        return [len(one.late) for one in self.printed]

    @property
    def fewest(self) -> int | None:
        """The fewest robots of any plan that the check passes."""
        met = [found.robots for found in self.outcomes.values() if found.met and found.robots is not None]
        return min(met, default=None)


def robots_told(found: Found) -> str:
    """Robots of a plan; marked where the check does not pass it."""
    if found.robots is None:
        return "no plan"
    return str(found.robots) if found.met else f"{found.robots}, not met"


def case_of(runs: Runs, case: PaperCase, mission: Mission, settings: PaperAlgorithms) -> Case:
    """A case of the paper with all its runs."""
    printed = tuple(runs.printed(mission, settings, seed) for seed in runs.seeds)
    methods = {method: runs.by_method(mission, method) for method in DEFAULTS}
    return Case(
        paper=case,
        mission=mission,
        seed=runs.seed,
        printed=printed,
        outcomes={"mended": runs.mended(mission, settings), **methods},
    )


def case_tables(title: str, cases: Sequence[Case]) -> tuple[Table, ...]:
    """Robots, by sub-region too, worst gaps and all routes of the cases."""
    return (
        robots_table(f"{title}: robots", cases),
        zones_table(f"{title}: robots by sub-region", cases),
        gaps_table(f"{title}: worst T^a / T^c, or worst gap / period by the check", cases),
        routes_table(f"{title}: times of the routes, s", cases),
    )


def with_late(robots: int, late: int) -> str:
    """``11, 4 late``: robots, and how many of them miss their period."""
    return f"{robots}" + (f", {late} late" if late else "")


def with_late_spread(robots: Sequence[int], late: Sequence[int]) -> str:
    """The same seed by seed, as means and ranges: ``6.1 (5 to 7), 1.5 (1 to 3) late``."""
    return brief(robots) + (f", {brief(late)} late" if any(late) else "")


def brief(values: Sequence[float] | NDArray[np.int64]) -> str:
    """The mean and the range: ``6.1 (5 to 7)``; of equal values one."""
    least, most = min(values), max(values)
    return f"{least}" if least == most else f"{np.mean(values):.1f} ({least} to {most})"


def robots_table(title: str, cases: Sequence[Case]) -> Table:
    """A row for each case: robots by the paper, by its algorithms here, of all plans, and the proved bound."""
    seeds = len(cases[0].printed)
    head = ("case", "periods s", "paper", f"Eq. 26, {seeds} seeds", *cases[0].outcomes, "lower bound")
    rows = []
    for case in cases:
        late = sum(route.late for route in case.paper.routes)
        rows.append(
            (
                case.paper.name,
                ", ".join(f"{period_s:g}" for period_s in case.paper.periods_s),
                with_late(len(case.paper.routes), late),
                with_late_spread(case.robots, case.late),
                *(robots_told(outcome) for outcome in case.outcomes.values()),
                number(case.lower_bound, "d"),
            )
        )
    if len(cases) > 1:
        totals = [str(sum(len(case.paper.routes) for case in cases)), with_late_spread(*together(cases))]
        totals += [_total([case.outcomes[way].robots for case in cases]) for way in cases[0].outcomes]
        rows.append(("together", "", *totals, _total([case.lower_bound for case in cases])))
    return Table(title=title, head=head, rows=tuple(rows), words=(0, 1))


def together(cases: Sequence[Case]) -> tuple[list[int], list[int]]:
    """Robots of all cases by Eq. 26, and how many of them are late, seed by seed."""
    robots, late = (np.sum([getattr(case, each) for case in cases], axis=0).tolist() for each in ("robots", "late"))
    return robots, late


def zones_table(title: str, cases: Sequence[Case]) -> Table:
    """A row for each sub-region of each case: robots of the paper, by Eq. 26 over the seeds, and of plans."""
    rows = []
    for case in cases:
        told = {way: found.robots_by_zone(case.names) for way, found in case.outcomes.items()}
        for k, (name, period_s) in enumerate(case.zones):
            ours = case.ours[:, k]
            within = "yes" if ours.min() <= case.theirs[k] <= ours.max() else "no"
            rows.append((
                case.paper.name if k == 0 else "", zone_title(name), f"{period_s:g}", str(case.theirs[k]),
                brief(ours.tolist()), within, *(str(of_zone[k]) for of_zone in told.values()),
            ))  # fmt: skip
    head = ("case", "sub-region", "period s", "paper", f"Eq. 26, {len(cases[0].printed)} seeds", "paper's among ours")
    return Table(title=title, head=(*head, *cases[0].outcomes), rows=tuple(rows), words=(0, 1, 5))


def _total(values: Sequence[int | None]) -> str:
    """The sum as text; a dash where a value is missing."""
    known = [value for value in values if value is not None]
    return str(sum(known)) if len(known) == len(values) else NOTHING


def gaps_table(title: str, cases: Sequence[Case]) -> Table:
    """A row for each case: how much of a period is used at worst, and what the paper's routes leave unseen here."""
    head = (
        "case",
        "paper",
        f"Eq. 26, {len(cases[0].printed)} seeds",
        "as printed: m² unseen",
        "as printed: m² seen too late",
        *cases[0].outcomes,
    )
    rows = []
    for case in cases:
        worst = [float((one.partition.times_s / one.partition.periods_s).max()) for one in case.printed]
        rows.append(
            (
                case.paper.name,
                f"{max(route.time_s / route.period_s for route in case.paper.routes):.3f}",
                plus_minus(worst, ".3f"),
                plus_minus([one.unseen_m2 for one in case.printed], ",.0f"),
                plus_minus([one.late_m2 for one in case.printed], ",.0f"),
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
    head = ("sub-region", "T^c s", "paper: T^a s", "Eq. 26, seed of the picture: T^a s", *TIMED)
    rows: list[tuple[str, ...]] = []
    for case in cases:
        for k, (name, period_s) in enumerate(case.zones):
            cells = (
                zone_title(name),
                f"{period_s:.2f}",
                _listed([_paper_time(route) for route in case.paper.routes if paper_zone(route, case) == k]),
                _listed([_our_time(time_s, period) for time_s, period in case.shown.of_zone(name)]),
                *(_listed(case.outcomes[way].times(name)) for way in TIMED),
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


def paper_zone(route: PaperRoute, case: Case) -> int:
    """The sub-region of a route of the paper, from 0 on; where the table prints none, by its period."""
    periods_s = [period_s for _, period_s in case.zones]
    if route.zone is None or route.period_s != periods_s[route.zone - 1]:
        return periods_s.index(route.period_s)
    return route.zone - 1


def _paper_time(route: PaperRoute) -> str:
    """The time of a printed route as text, and whether it is late."""
    return f"{route.time_s:.2f}" + (" (late)" if route.late else "")


def unseen_and_late(case: Case) -> str:
    """The ground that routes as printed never see, and the ground that they see too seldom, over the seeds."""
    asked_m2 = case.shown.asked_m2
    told = []
    for areas_m2, how in (
        ([one.unseen_m2 for one in case.printed], "never seen, where lanes merge or routes are cut at obstacles"),
        ([one.late_m2 for one in case.printed], "seen too seldom"),
    ):
        share = 100 * float(np.mean(areas_m2)) / asked_m2
        told.append(f"{plus_minus(areas_m2, ',.0f')} m² ({share:.1f} %) are {how}")
    return ", ".join(told)
