"""Figures 13 and 16 with Tables 5 and 8: the method from sensors to routes, on both maps."""

from __future__ import annotations

from rota_studies.panels.curve_panel import CurvePanel
from rota_studies.panels.map_panel import MapPanel
from rota_studies.section import Picture, Section
from rota_studies.sun2019 import paper
from rota_studies.sun2019.cases import (
    DEFAULTS,
    Case,
    brief,
    case_of,
    case_tables,
    unseen_and_late,
    with_late_spread,
)
from rota_studies.sun2019.maps import RECONSTRUCTED
from rota_studies.sun2019.panels import (
    cost_panel,
    deployment_panel,
    frame_panel,
    partition_panel,
    printed_panel,
    routes_panel,
    sensors_by_zone,
    settled,
    tour_panel,
)
from rota_studies.sun2019.readings import lengths_table, robots_by_alpha, tour_table, tours_by_reading
from rota_studies.sun2019.results import Found, Printed, Way
from rota_studies.sun2019.runs import Reading, Runs
from rota_studies.sun2019.verdicts import (
    NOT_RUN,
    coverage_verdict,
    fewer_robots_verdict,
    genetic_verdict,
    run_verdicts,
)
from rota_studies.sun2019_method.algorithms import PaperAlgorithms
from rota_studies.tables import counted
from rota_studies.verdict import spread

SCALES = (
    "Worst gaps are shares of the period. Costs of Eq. 11 (b) have a scale of their own, since λ is not printed; those "
    "of Eq. 28 (f) are on the paper's scale. (b) begins with iteration 1, (d) when the tour has as few crossings as in "
    "the end. Crosses: routes that are late by Eq. 26."
)


def figure_13_section(runs: Runs) -> Section:
    """Figure 13 and Table 5: Section 5.1."""
    case = case_of(runs, paper.TABLE_5, runs.map_13, runs.figure_13)
    proving = runs.by_method(runs.map_13, "tours", effort=runs.settings.proving_effort)
    bound = max(case.lower_bound or 0, proving.lower_bound_robots or 0)
    tours = tours_by_reading(runs)
    return Section(
        figure=13,
        heading="the method on the square map",
        pictures=run_pictures(13, case, _cheapest(runs, case, runs.figure_13)),
        caption="Figure 13, (a) to (f) as in the paper, made with Tables 2 to 4, and (g), (h) the plans of two "
        f"methods, all with seed {runs.seed}. {SCALES} {RECONSTRUCTED}",
        paper=f"{_run_told(paper.FIGURE_13)} Five routes keep the periods of Table 1 (Table 5).",
        ours=f"{_ours(case, paper.FIGURE_13)} At effort {runs.settings.proving_effort} tours takes {_robots(proving)}; "
        f"at least {bound} are needed, proved. {_alpha_told(case.shown)}",
        tables=(
            *case_tables("Table 5 (Section 5.1)", [case]),
            lengths_table(case.names, case.printed),
            tour_table(tours),
        ),
        verdicts=(
            fewer_robots_verdict(robots_by_alpha(runs)),
            genetic_verdict(tours),
            *run_verdicts(case, proving, runs.settings.proving_effort),
        ),
    )


def figure_16_section(runs: Runs) -> Section:
    """Figure 16 and Table 8: Section 5.3."""
    case = case_of(runs, paper.TABLE_8, runs.map_15, runs.figure_16)
    return Section(
        figure=16,
        heading="the method on the pentagon",
        pictures=run_pictures(16, case, _cheapest(runs, case, runs.figure_16)),
        caption="Figure 16, (a) to (f) as in the paper, made with Tables 7, 3 and 4, and (g), (h) the plans of two "
        f"methods, all with seed {runs.seed}. {SCALES} {RECONSTRUCTED} The tour's {paper.FIGURE_16.tour_length:,.2f} "
        "is copied from Section 5.1.",
        paper=f"{_run_told(paper.FIGURE_16)} Seven routes keep the periods (Table 8).",
        ours=_ours(case, paper.FIGURE_16),
        tables=case_tables("Table 8 (Section 5.3)", [case]),
        verdicts=(coverage_verdict(case, "5.3"), NOT_RUN),
    )


def run_pictures(figure: int, case: Case, least: float) -> tuple[Picture, ...]:
    """Panels (a) to (f) of Figures 13 and 16, and the plans of two methods as (g) and (h)."""
    mission, shown = case.mission, case.shown
    panels: list[MapPanel | CurvePanel] = [
        deployment_panel("(a) Sensors", mission, shown.sensors),
        cost_panel("(b) Cost of the deployment", [("cost", shown.sensors)]),
        frame_panel("(c) Frame", mission, shown.sensors, shown.way),
        tour_panel("(d) Length of the tour", shown.way),
        printed_panel("(e) Routes as printed", mission, shown),
        partition_panel("(f) Cost of the partition", shown.partition, least),
    ]
    plans = (
        routes_panel("(g) Mended until the check passes", mission, case.outcomes["mended"]),
        routes_panel("(h) Method tours", mission, case.outcomes["tours"]),
    )
    return (
        Picture(
            f"sun2019-figure-{figure}.png",
            f"{shown.sensors.count} sensors, the frame through them, {shown.robots} routes, and how the three "
            "algorithms came to them",
            tuple(panels),
        ),
        Picture(
            f"sun2019-figure-{figure}-plans.png",
            f"The paper's stages, mended ({_robots(case.outcomes['mended'])}), and tours "
            f"({_robots(case.outcomes['tours'])})",
            plans,
        ),
    )


def _cheapest(runs: Runs, case: Case, settings: PaperAlgorithms) -> float:
    """What Algorithm 3 looks for: the least cost by Eq. 28 of a partition of the same frame."""
    own = Reading(settings.partition.joining_legs, settings.partition.weight_late)
    return runs.cheapest(case.mission, settings, own, runs.seed).cost


def _robots(found: Found) -> str:
    """The number of robots as text, or that there is no plan."""
    return "no plan" if found.robots is None else counted(found.robots, "robot")


def _run_told(run: paper.PaperRun) -> str:
    """What the paper tells of the three algorithms."""
    by_zone = " + ".join(map(str, run.sensors))
    after = "" if run.cost_iteration is None else f" after {run.cost_iteration} iterations"
    best = "" if run.best_generation is None else f" and at its best by {run.best_generation:,}"
    way = "" if run.length_m is None else f", {run.length_m:,.2f} of it way"
    return (
        f"{sum(run.sensors)} sensors ({by_zone}); their cost falls from {run.first_cost:,.0f} to "
        f"{run.last_cost:,.0f}{after}. The tour is {run.tour_length:,.2f} long{way}, stable after generation "
        f"{run.stable_generation:,}{best}. The partition costs {run.partition_cost:,.2f} after iteration "
        f"{run.partition_iteration}, where Table 4 has {paper.TABLE_4_ITERATIONS}."
    )


def _ours(case: Case, run: paper.PaperRun) -> str:
    """What comes of the three algorithms here, and how the plans compare."""
    shown, runs = case.shown, case.printed
    by_zone = " + ".join(map(str, sensors_by_zone(case.mission, shown.sensors)))
    told = [
        f"Over {len(runs)} seeds {spread([one.sensors.count for one in runs])} sensors, with seed {case.seed} "
        f"{shown.sensors.count} ({by_zone}), {_beside(shown.sensors.count, sum(run.sensors))} the paper."
    ]
    if shown.sensors.cost is not None:
        cost = shown.sensors.cost
        told.append(f"Their cost falls from {cost[0]:,.0f} to {cost[-1]:,.0f}, reached in iteration {settled(cost)}.")
    told.append(
        f"The tour is {shown.way.tour_length:,.2f} long, {shown.way.length_m:,.2f} of it way{_longer(shown.way, run)} "
        f"with {shown.way.zone_crossings} crossings, by generation {shown.way.fell_at[-1]:,}; over the seeds "
        f"{spread([one.way.length_m for one in runs])} m. The partition costs {shown.partition.cost:,.2f} from "
        f"iteration {settled(shown.partition.history)} on and has {counted(shown.robots, 'segment')}, "
        f"{_beside(shown.robots, len(case.paper.routes))} the paper; over the seeds "
        f"{with_late_spread(case.robots, case.late)}. By sub-region (in the order zone-1, zone-2, rest) the paper has "
        f"{' + '.join(map(str, case.theirs))} robots, ours are {' + '.join(brief(k) for k in case.ours.T.tolist())}."
    )
    return " ".join([*told, f"As printed, {unseen_and_late(case)}.", _compared(case)])


def _longer(way: Way, run: paper.PaperRun) -> str:
    """How the way compares with the paper's, where it tells."""
    if run.length_m is None:
        return ""
    more = 100 * (way.length_m / run.length_m - 1)
    return f" ({abs(more):.0f} % {'longer' if more > 0 else 'shorter'} than the paper's)"


def _beside(ours: int, theirs: int) -> str:
    """How many more or fewer ours are, in words."""
    if ours == theirs:
        return "as many as in"
    return f"{abs(ours - theirs)} {'more' if ours > theirs else 'fewer'} than in"


def _compared(case: Case) -> str:
    """Robots of all ways, and the bound."""
    told = {
        way: _robots(outcome) + ("" if outcome.met or outcome.robots is None else " (not met)")
        for way, outcome in case.outcomes.items()
    }
    bound = "no bound is known" if case.lower_bound is None else f"proved: at least {case.lower_bound}"
    rest = ", ".join(f"{way} {told[way]}" for way in DEFAULTS)
    return f"Mended until the check passes they take {told['mended']}. Other methods: {rest} ({bound})."


def _alpha_told(printed: Printed) -> str:
    """What the paper's two lengths say about alpha."""
    run = paper.FIGURE_13
    assert run.length_m is not None
    alpha, six = 10_000, 6
    way_m = run.tour_length - six * alpha
    ours = printed.way.zone_crossings
    return (
        f"With α = {alpha:,}, which is not printed, the paper's {run.tour_length:,.2f} is {six} crossings and "
        f"{way_m:,.2f} of way, where its text has {run.length_m:,.2f}; ours crosses {ours} times."
    )
