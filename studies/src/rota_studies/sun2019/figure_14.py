"""Figure 14 with Table 6: the method for six choices of periods, and by all readings of Eqs. 22, 26 and 28."""

from __future__ import annotations

from collections.abc import Sequence

from rota_studies.panels.map_panel import MapPanel
from rota_studies.section import Picture, Section
from rota_studies.sun2019 import paper
from rota_studies.sun2019.cases import DEFAULTS, Case, case_of, case_tables, together, with_late_spread
from rota_studies.sun2019.maps import RECONSTRUCTED
from rota_studies.sun2019.panels import printed_panel, routes_panel
from rota_studies.sun2019.readings import WEIGHTS, cuts_by_case, reading_table
from rota_studies.sun2019.runs import Reading, Runs
from rota_studies.sun2019.verdicts import verdicts_of_cases
from rota_studies.tables import joined


def figure_14_section(runs: Runs) -> Section:
    """Figure 14 and Table 6: six other choices of periods."""
    settings = runs.figure_13
    cases = [case_of(runs, case, mission, settings) for case, mission in zip(paper.TABLE_6, runs.maps_14, strict=True)]
    cuts = {weight: cuts_by_case(runs, Reading(True, weight)) for weight in WEIGHTS}
    return Section(
        figure=14,
        heading="other periods",
        pictures=(
            Picture(
                "sun2019-figure-14.png",
                "Routes as printed for six choices of periods",
                tuple(printed_panel(_title(k, case), case.mission, case.shown) for k, case in enumerate(cases)),
            ),
            Picture(
                "sun2019-figure-14-mended.png",
                "The same routes mended until the check passes",
                tuple(_mended_panel(k, case) for k, case in enumerate(cases)),
            ),
        ),
        caption=f"Figure 14, with seed {runs.seed}: the six cases of Table 6 by the paper's stages; first as printed, "
        "then mended. Periods of "
        "zone 1, zone 2 and the rest. Zones are tinted by the order of their periods, so that a zone's tint differs "
        f"between cases. Crosses: routes that are late by Eq. 26. Worst gaps are shares of the period. {RECONSTRUCTED}",
        paper=_cases_told(),
        ours=_ours_of_cases(cases),
        tables=(*case_tables("Table 6", cases), reading_table(runs)),
        verdicts=tuple(verdicts_of_cases(cases, cuts)),
    )


def _title(k: int, case: Case) -> str:
    """The title of case k's panel: its name and periods."""
    periods = " / ".join(f"{period_s:g}" for period_s in case.paper.periods_s)
    return f"({'abcdef'[k]}) {case.paper.name}: {periods} s"


def _mended_panel(k: int, case: Case) -> MapPanel:
    """The routes of case k after repair."""
    return routes_panel(_title(k, case), case.mission, case.outcomes["mended"])


def _cases_told() -> str:
    """What the paper says of its six cases."""
    robots = joined([str(len(case.routes)) for case in paper.TABLE_6])
    late = sum(route.late for case in paper.TABLE_6 for route in case.routes)
    return (
        f"{robots} robots, in the order of the cases (Section 5.2). Every route keeps its period but {late} of Case 6, "
        "which are sacrificed “for the minimum coverage cost”."
    )


def _ours_of_cases(cases: Sequence[Case]) -> str:
    """Robots of all cases together, by the paper's algorithms and by ours, in words."""
    theirs = sum(len(case.paper.routes) for case in cases)
    sums = []
    for way in ("mended", *DEFAULTS):
        outcomes = [case.outcomes[way] for case in cases]
        met, robots = sum(outcome.met for outcome in outcomes), sum(outcome.robots or 0 for outcome in outcomes)
        sums.append(f"{way} {robots}" + ("" if met == len(cases) else f" ({met} of {len(cases)} cases met)"))
    bounds = [case.lower_bound for case in cases if case.lower_bound is not None]
    unseen, seldom = (
        [float(getattr(one, of)) for case in cases for one in case.printed] for of in ("unseen_m2", "late_m2")
    )
    return (
        f"Robots of all {len(cases)} cases together: the paper {theirs}; its algorithms here by Eq. 26 "
        f"{with_late_spread(*together(cases))}, over {len(cases[0].printed)} seeds; with the first seed "
        f"{', '.join(sums)}; proved: at least {sum(bounds)}. Routes as printed leave {min(unseen):,.0f} to "
        f"{max(unseen):,.0f} m² unseen, and see {min(seldom):,.0f} to {max(seldom):,.0f} m² too seldom."
    )
