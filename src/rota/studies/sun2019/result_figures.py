"""Figures 13, 14 and 16 with Tables 5, 6 and 8: the method from sensors to routes, on both maps and for all periods."""

from __future__ import annotations

from collections.abc import Sequence

from rota.compare import MethodOutcome
from rota.draw.curve_panel import CurvePanel
from rota.draw.map_panel import MapPanel
from rota.draw.study_picture import study_picture
from rota.mission import Mission, Sun2019
from rota.planners.patrol.sun2019.settings import MethodSettings
from rota.planners.patrol.sun2019.tour import Frame
from rota.studies.section import Picture, Section
from rota.studies.sun2019 import paper
from rota.studies.sun2019.cases import Case, gaps_table, robots_table, routes_table, unseen_told
from rota.studies.sun2019.maps import RECONSTRUCTED
from rota.studies.sun2019.panels import (
    cost_panel,
    deployment_panel,
    frame_panel,
    partition_panel,
    routes_panel,
    sensors_by_zone,
    settled,
    tour_panel,
)
from rota.studies.sun2019.runs import Printed, Runs
from rota.studies.tables import Table, counted, joined

AS_THE_PAPER = Sun2019(deployment="ccpso2", tour="genetic", partition="pso", routes="repaired")


def case_of(
    runs: Runs, case: paper.PaperCase, mission: Mission, settings: MethodSettings, *, mend: bool = True
) -> Case:
    """A case of the paper with all its runs; ``mend``: also the paper's algorithms with their routes mended."""
    return Case(
        paper=case,
        mission=mission,
        printed=runs.printed(mission, settings),
        mended=runs.by_stages(mission, AS_THE_PAPER) if mend else None,
        stages=runs.by_stages(mission),
        tours=runs.by_tours(mission),
    )


def figure_13_section(runs: Runs) -> Section:
    """Figure 13 and Table 5: Section 5.1."""
    case = case_of(runs, paper.TABLE_5, runs.map_13, runs.settings.figure_13)
    return Section(
        figure=13,
        heading="the method on the square map",
        pictures=run_pictures(13, case),
        caption="Figure 13, (a) to (f) as in the paper, made with Tables 2 to 4, and (g), (h) the plans of two "
        f"methods. {SCALES} {RECONSTRUCTED}",
        paper=f"{_run_told(paper.FIGURE_13)} Five routes keep the periods of Table 1 (Table 5).",
        found=f"{_found(case, paper.FIGURE_13)} {_alpha_told(case.printed)}",
        tables=case_tables("Table 5 (Section 5.1)", [case]),
    )


def figure_16_section(runs: Runs) -> Section:
    """Figure 16 and Table 8: Section 5.3."""
    case = case_of(runs, paper.TABLE_8, runs.map_15, runs.settings.figure_16)
    return Section(
        figure=16,
        heading="the method on the pentagon",
        pictures=run_pictures(16, case),
        caption=f"Figure 16, (a) to (f) as in the paper, made with Tables 7, 3 and 4, and (g), (h) the plans of two "
        f"methods. {SCALES} {RECONSTRUCTED} The tour's {paper.FIGURE_16.tour_length:,.2f} is copied from Section 5.1.",
        paper=f"{_run_told(paper.FIGURE_16)} Seven routes keep the periods (Table 8).",
        found=_found(case, paper.FIGURE_16),
        tables=case_tables("Table 8 (Section 5.3)", [case]),
    )


SCALES = "Worst gaps are shares of the period. Costs have a scale of their own, since the weights are not printed."


def run_pictures(figure: int, case: Case) -> tuple[Picture, ...]:
    """Panels (a) to (f) of Figures 13 and 16, and the plans of two methods as (g) and (h)."""
    mission, (part, *_) = case.mission, case.printed.stages.framed.parts
    deployment = case.printed.stages.framed.deployment
    panels: list[MapPanel | CurvePanel] = [
        deployment_panel("(a) Sensors", mission, deployment),
        cost_panel("(b) Cost of the deployment", [("cost", deployment)]),
        frame_panel("(c) Frame", mission, deployment, part.frame),
        tour_panel("(d) Length of the tour", part.frame),
        printed_panel("(e) Routes as printed", case.printed),
        partition_panel("(f) Cost of the partition", case.printed.stages.partitions[0]),
    ]
    plans = [
        routes_panel("(g) Method sun2019", mission, case.stages),
        routes_panel("(h) Method tours", mission, case.tours),
    ]
    return (
        Picture(
            f"figure-{figure}.png",
            f"{len(deployment.positions_m)} sensors, the frame through them, {len(case.printed.plan.trajectories)} "
            "routes, and how the three algorithms came to them",
            study_picture(panels),
        ),
        Picture(
            f"figure-{figure}-plans.png",
            f"Plans by sun2019 ({_robots(case.stages)}) and tours ({_robots(case.tours)})",
            study_picture(plans),
        ),
    )


def printed_panel(title: str, printed: Printed) -> MapPanel:
    """Figures 13e and 16e: the routes as the paper has them, with what the check says of them."""
    note = f"{counted(len(printed.plan.trajectories), 'robot')}; {unseen_told(printed.report)}"
    return MapPanel(title=title, note=note, mission=printed.mission, plan=printed.plan, listed_zones=True)


def _robots(outcome: MethodOutcome) -> str:
    return "no plan" if outcome.robots is None else counted(outcome.robots, "robot")


def _run_told(run: paper.PaperRun) -> str:
    """What the paper tells of the three algorithms."""
    by_zone = " + ".join(map(str, run.sensors))
    after = "" if run.cost_iteration is None else f" after {run.cost_iteration} iterations"
    best = "" if run.best_generation is None else f" and at its best by {run.best_generation:,}"
    way = "" if run.length_m is None else f", {run.length_m:,.2f} of it way"
    return (
        f"{sum(run.sensors)} sensors ({by_zone}); their cost falls from {run.first_cost:,.0f} to "
        f"{run.last_cost:,.0f}{after}. The tour is {run.tour_length:,.2f} long{way}, stable after generation "
        f"{run.stable_generation:,}{best}. The partition costs "
        f"{run.partition_cost:,.2f} after iteration {run.partition_iteration}, where Table 4 has "
        f"{paper.TABLE_4_ITERATIONS}."
    )


def _found(case: Case, run: paper.PaperRun) -> str:
    """What comes of the three algorithms here, and how the plans compare."""
    stages = case.printed.stages
    deployment, frame, partition = stages.framed.deployment, stages.framed.parts[0].frame, stages.partitions[0]
    ours, by_zone = len(deployment.positions_m), " + ".join(map(str, sensors_by_zone(case.mission, deployment)))
    told = [f"{counted(ours, 'sensor')} ({by_zone}), {_beside(ours, sum(run.sensors))} the paper."]
    if deployment.history is not None:
        cost = deployment.history.cost
        told.append(f"Their cost falls from {cost[0]:,.0f} to {cost[-1]:,.0f}, reached in iteration {settled(cost)}.")
    told.append(
        f"The tour is {frame.tour_length:,.2f} long, {frame.length_m:,.2f} of it way{_longer(frame, run)} with "
        f"{frame.zone_crossings} crossings, by generation {settled(frame.history):,}. The partition costs "
        f"{partition.cost:,.2f} from iteration {settled(partition.history)} on and has "
        f"{counted(len(stages.segments), 'segment')}, {_beside(len(stages.segments), len(case.paper.routes))} the "
        "paper."
    )
    return " ".join([*told, _checked_told(case), _compared(case)])


def _longer(frame: Frame, run: paper.PaperRun) -> str:
    """How the way compares with the paper's, where it tells."""
    if run.length_m is None:
        return ""
    more = 100 * (frame.length_m / run.length_m - 1)
    return f" ({abs(more):.0f} % {'longer' if more > 0 else 'shorter'} than the paper's)"


def _beside(ours: int, theirs: int) -> str:
    if ours == theirs:
        return "as many as in"
    return f"{abs(ours - theirs)} {'more' if ours > theirs else 'fewer'} than in"


def _checked_told(case: Case) -> str:
    """Whether the routes as printed do what they shall."""
    if case.printed.report.verdict == "met":
        return "The routes round these segments pass the check as they are."
    asked_m2 = sum(demand.area_m2 for demand in case.printed.report.demands)
    share = 100 * case.unseen_m2 / asked_m2 if asked_m2 else 0.0
    if case.unseen_m2 <= 0:
        return f"The routes round these segments see everything, but not in time: {unseen_told(case.printed.report)}."
    return (
        f"That the routes “cover the task area completely and persistently” does not hold for these as they are: "
        f"{case.unseen_m2:,.0f} m² ({share:.1f} %) are never seen, where lanes merge or routes are cut at obstacles."
    )


def _compared(case: Case) -> str:
    """Robots of all ways, and the bound."""
    told = {
        way: _robots(outcome) + ("" if outcome.met or outcome.robots is None else " (not met)")
        for way, outcome in case.outcomes.items()
    }
    mended = f"Mended until the check passes they take {told['mended']}. " if "mended" in told else ""
    bound = "no bound is known" if case.lower_bound is None else f"proved: at least {case.lower_bound}"
    return f"{mended}sun2019 takes {told['sun2019']}, tours {told['tours']} ({bound})."


def figure_14_section(runs: Runs) -> Section:
    """Figure 14 and Table 6: six other choices of periods."""
    cases = [
        case_of(runs, case, mission, runs.settings.figure_13, mend=False)
        for case, mission in zip(paper.TABLE_6, runs.maps_14, strict=True)
    ]
    return Section(
        figure=14,
        heading="other periods",
        pictures=(
            Picture("figure-14.png", "Routes of sun2019 for six choices of periods", study_picture(_plans(cases))),
        ),
        caption="Figure 14: the six cases of Table 6 by the method sun2019; periods of zone 1, zone 2 and the rest. "
        f"Worst gaps are shares of the period. {RECONSTRUCTED}",
        paper=_cases_told(),
        found=_cases_found(cases),
        tables=case_tables("Table 6", cases),
    )


def _plans(cases: Sequence[Case]) -> list[MapPanel]:
    panels = []
    for letter, case in zip("abcdef", cases, strict=False):
        periods = " / ".join(f"{period_s:g}" for period_s in case.paper.periods_s)
        panels.append(routes_panel(f"({letter}) {case.paper.name}: {periods} s", case.mission, case.stages))
    return panels


def _cases_told() -> str:
    robots = joined([str(len(case.routes)) for case in paper.TABLE_6])
    late = sum(route.late for case in paper.TABLE_6 for route in case.routes)
    return (
        f"{robots} robots, in the order of the cases (Section 5.2). Every route keeps its period but {late} of Case 6, "
        "which are sacrificed “for the minimum coverage cost”."
    )


def _cases_found(cases: Sequence[Case]) -> str:
    theirs = sum(len(case.paper.routes) for case in cases)
    sums = []
    for way in ("sun2019", "tours"):
        outcomes = [case.outcomes[way] for case in cases]
        met, robots = sum(one.met for one in outcomes), sum(one.robots or 0 for one in outcomes)
        sums.append(f"{way} {robots}, with {met} of {len(cases)} cases met")
    bounds = [case.lower_bound for case in cases if case.lower_bound is not None]
    segments = sum(len(case.printed.stages.segments) for case in cases)
    worse = [
        case.paper.name
        for case in cases
        if case.stages.robots is None or not case.stages.met or case.stages.robots > len(case.paper.routes)
    ]
    unseen = [case.unseen_m2 for case in cases]
    return (
        f"Robots of all {len(cases)} cases together: the paper {theirs}; its algorithms here {segments} by Eq. 26; "
        f"{'; '.join(sums)}; proved: at least {sum(bounds)}. "
        + (
            f"sun2019 needs more than the paper prints in {joined(worse)}. "
            if worse
            else "sun2019 needs no more than the paper prints in any case. "
        )
        + f"Routes as printed leave {min(unseen):,.0f} to {max(unseen):,.0f} m² unseen."
    )


def _alpha_told(printed: Printed) -> str:
    """What the paper's two lengths say about alpha."""
    run = paper.FIGURE_13
    assert run.length_m is not None
    alpha, six = 10_000, 6
    way_m = run.tour_length - six * alpha
    ours = printed.stages.framed.parts[0].frame.zone_crossings
    return (
        f"With α = {alpha:,}, which is not printed, the paper's {run.tour_length:,.2f} is {six} crossings and "
        f"{way_m:,.2f} of way, where its text has {run.length_m:,.2f}; ours crosses {ours} times."
    )


def case_tables(title: str, cases: Sequence[Case]) -> tuple[Table, ...]:
    """Robots, worst gaps and all routes of the cases."""
    return (
        robots_table(f"{title}: robots", cases),
        gaps_table(f"{title}: worst T^a / T^c, or worst gap / period by the check", cases),
        routes_table(f"{title}: times of the routes, s", cases),
    )
