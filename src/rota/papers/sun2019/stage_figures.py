"""Figures 6, 8, 12 and 15: sensors with and without rules, two distances, the stages one by one, the second map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rota.draw.panels.curve_panel import CurvePanel
from rota.draw.panels.map_panel import MapPanel
from rota.draw.panels.study_picture import study_picture
from rota.mission import Mission
from rota.papers.section import Picture, Section, Verdict
from rota.papers.sun2019 import paper
from rota.papers.sun2019.maps import RECONSTRUCTED
from rota.papers.sun2019.panels import (
    cost_panel,
    deployment_panel,
    frame_panel,
    graph_edges,
    printed_panel,
    rest_note,
    segments_panel,
    sensors_by_zone,
    zone_title,
)
from rota.papers.sun2019.readings import LETTER, Counts, addition_table, counts_by_addition, spread
from rota.papers.sun2019.runs import Runs
from rota.papers.sun2019.verdicts import rules_verdicts
from rota.papers.tables import Table, counted
from rota.planners.patrol.methods.sun2019.deploy import Deployment
from rota.planners.patrol.methods.sun2019.tour import Frame

ONE_MAP_WIDTH = 3.9  # inches


def figure_6_section(runs: Runs) -> Section:
    """Figure 6: what the heuristic rules do for the deployment."""
    mission, settings = runs.map_13, runs.settings.figure_13
    with_rules = runs.framed(mission, settings).deployment
    without = runs.deployment(mission, settings.deployments[0].without_rules())
    panels: list[MapPanel | CurvePanel] = [
        deployment_panel("(a) With heuristic rules", mission, with_rules),
        deployment_panel("(b) Without", mission, without),
        cost_panel("(c) Cost", [("with rules", with_rules), ("without", without)], wide=True),
    ]
    ours, theirs = len(with_rules.positions_m), len(without.positions_m)
    zones = [*(zone_title(zone.name) for zone in mission.zones), "rest"]
    table = Table(
        title="Virtual sensors that cover the map",
        head=("CCPSO2", "paper", "ours", *(f"ours, {zone}" for zone in zones)),
        rows=(
            ("with rules", f"{paper.SENSORS_WITH_RULES}", f"{ours}", *map(str, sensors_by_zone(mission, with_rules))),
            ("without", f"{paper.SENSORS_WITHOUT_RULES}", f"{theirs}", *map(str, sensors_by_zone(mission, without))),
        ),
    )
    counts = counts_by_addition(runs)
    return Section(
        figure=6,
        heading="sensors with and without the heuristic rules",
        pictures=(
            Picture(
                "sun2019-figure-6.png",
                f"{ours} sensors with the rules, {theirs} without, and how the cost of both falls",
                study_picture(panels),
            ),
        ),
        caption=f"Figure 6. {RECONSTRUCTED} It does not say which map Figure 6 shows: under the same Table 2 it has "
        f"{paper.SENSORS_WITH_RULES} sensors with the rules there and {sum(paper.FIGURE_13.sensors)} in Figure 13. The "
        "weights λ of Eq. 11 are not printed, so that costs cannot be set beside each other.",
        paper="CCPSO2 with the rules (addition, movement, deletion, fusion) takes "
        f"{paper.SENSORS_WITH_RULES} sensors, standard CCPSO2 {paper.SENSORS_WITHOUT_RULES}; the rules make it converge"
        " faster (Section 4.2).",
        ours=f"{counted(ours, 'sensor')} with the rules, {theirs} without. "
        f"{_saved(theirs - ours, paper.SENSORS_WITHOUT_RULES - paper.SENSORS_WITH_RULES)} "
        f"{_by_the_letter(counts)} {_convergence(with_rules, without)}",
        tables=(table, addition_table(runs, counts)),
        verdicts=rules_verdicts(counts, _faster(with_rules, without)),
    )


def _saved(ours: int, theirs: int) -> str:
    """How many sensors the rules save, here and in the paper, in words."""
    if ours > 0:
        return f"The rules save {ours}, the paper's {theirs}."
    return f"The rules save none here, unlike the paper's, which save {theirs}."


def _by_the_letter(counts: Counts) -> str:
    """What becomes of the rules when our readings are left out."""
    with_rules, without = counts[LETTER]
    return (
        f"That rests on three additions of ours, without which Algorithm 1 takes {spread(with_rules)} sensors with the "
        f"rules and {spread(without)} without."
    )


def _faster(with_rules: Deployment, without: Deployment) -> bool:
    """Whether the run with rules passes the other's last cost before its end."""
    if with_rules.history is None or without.history is None:
        return False
    return bool((with_rules.history.cost[:-1] < without.history.cost[-1]).any())


def _convergence(with_rules: Deployment, without: Deployment) -> str:
    """When the run with rules passes the other's last cost."""
    if with_rules.history is None or without.history is None:
        return ""
    below = np.flatnonzero(with_rules.history.cost < without.history.cost[-1])
    last = len(without.history.cost) - 1
    if not len(below):
        return "The claim of faster convergence does not hold here: the cost never falls below the one without rules."
    return (
        f"Faster convergence holds: from iteration {below[0]} on the cost is below what the run without rules ends "
        f"with after {last}."
    )


def figure_8_section(runs: Runs) -> Section:
    """Figure 8: the frame by straight distances and by Eq. 14."""
    mission, settings = runs.map_8, runs.settings.figure_13
    deployment = runs.deployment(mission, settings.deployments[0])
    straight = runs.frame(mission, deployment, replace(settings.tour, distance="euclidean"))
    graph = runs.frame(mission, deployment, replace(settings.tour, distance="graph"))
    panels = [
        frame_panel("(a) Euclidean distances", mission, deployment, straight),
        frame_panel("(b) Distances of Eq. 14", mission, deployment, graph),
    ]

    def row(name: str, crossings: int, frame: Frame) -> tuple[str, ...]:
        return name, str(crossings), str(frame.zone_crossings), str(frame.blocked_legs), f"{frame.length_m:,.0f}"

    table = Table(
        title="Crossings between the two sub-regions",
        head=("distances", "paper", "ours", "ours, legs through walls", "ours, frame m"),
        rows=(
            row("Euclidean", paper.CROSSINGS_EUCLIDEAN, straight),
            row("Eq. 14", paper.CROSSINGS_GRAPH, graph),
        ),
    )
    fewer = graph.zone_crossings < straight.zone_crossings
    longer = graph.length_m / straight.length_m - 1
    return Section(
        figure=8,
        heading="the frame by two distances",
        pictures=(
            Picture(
                "sun2019-figure-8.png",
                f"{counted(straight.zone_crossings, 'crossing')} with Euclidean distances, {graph.zone_crossings} with "
                "those of Eq. 14",
                study_picture(panels),
            ),
        ),
        caption=f"Figure 8. {RECONSTRUCTED} Figure 8 has a map of two sub-regions that is drawn nowhere else; ours is "
        "that of Figure 13 with one zone. Red rings: where the frame crosses from one to the other.",
        paper=f"The frame crosses {paper.CROSSINGS_EUCLIDEAN} times with Euclidean distances and "
        f"{paper.CROSSINGS_GRAPH} times with those of Eq. 14 (Section 4.3).",
        ours=f"{counted(straight.zone_crossings, 'crossing')} and {graph.zone_crossings}. "
        + ("The claim holds. " if fewer else "The claim does not hold here. ")
        + _blocked(straight, graph)
        + f" The frame is {100 * abs(longer):.1f} % {'longer' if longer >= 0 else 'shorter'} for that.",
        tables=(table,),
        verdicts=(
            Verdict(
                "Distances of Eq. 14 make the frame cross between sub-regions less often",
                "4.3",
                "holds" if fewer else "does not hold",
                f"{graph.zone_crossings} crossings for {straight.zone_crossings} (the paper: {paper.CROSSINGS_GRAPH} "
                f"for {paper.CROSSINGS_EUCLIDEAN}), by α = {settings.tour.alpha:,.0f}.",
            ),
        ),
    )


def _blocked(straight: Frame, graph: Frame) -> str:
    """How many legs lead through walls by either distance, in words."""
    if straight.blocked_legs and not graph.blocked_legs:
        legs = counted(straight.blocked_legs, "leg")
        return f"Euclidean distances also lead {legs} through walls, Eq. 14's none."
    return f"Legs through walls: {straight.blocked_legs} with Euclidean distances, {graph.blocked_legs} with Eq. 14's."


def figure_12_section(runs: Runs) -> Section:
    """Figure 12: the stages of the method one after the other."""
    mission, settings = runs.map_13, runs.settings.figure_13
    printed = runs.printed(mission, settings)
    stages = printed.stages
    deployment, frame, partition = stages.framed.deployment, stages.framed.parts[0].frame, stages.partitions[0]
    range_m = settings.tour.neighbour_range * deployment.virtual_radius_m
    edges = graph_edges(mission, deployment, range_m)
    panels: list[MapPanel | CurvePanel] = [
        MapPanel(title="(1) Mission", note=rest_note(mission), mission=mission, named_zones=True),
        deployment_panel("(2) Sensors (Algorithm 1)", mission, deployment),
        frame_panel("(3) Graph and frame (Algorithm 2)", mission, deployment, frame, edges=edges),
        segments_panel("(4) Segments (Algorithm 3)", mission, deployment, frame, partition),
        printed_panel("(5) Routes", printed),
    ]
    ours, theirs = sensors_by_zone(mission, deployment), paper.FIGURE_13.sensors
    return Section(
        figure=12,
        heading="the stages of the method",
        pictures=(
            Picture(
                "sun2019-figure-12.png",
                "The mission, sensors with what they see, the frame through them, its segments, and their routes",
                study_picture(panels),
            ),
        ),
        caption=f"Figure 12. {RECONSTRUCTED} Every sensor is drawn with the {deployment.virtual_radius_m:g} m that it "
        f"sees (r_v = 2 r_s); the graph joins sensors at most {range_m:g} m apart (r_n) with no wall between them.",
        paper="Sensors are deployed zone by zone, from the smallest period up, joined to a closed frame, and the frame "
        "is cut into one segment for each robot (Section 4.5). The text says T₁ > T₂ > T₃, Table 1 the contrary, which "
        "we follow: the smallest period is the most important.",
        ours=f"{_by_zone(ours)} = {counted(sum(ours), 'sensor')} where the paper has {_by_zone(theirs)} = "
        f"{sum(theirs)}, a graph of {len(edges)} edges, a frame of {frame.length_m:,.0f} m that changes zones "
        f"{frame.zone_crossings} times, and {counted(len(partition.first), 'segment')}.",
    )


def _by_zone(sensors: tuple[int, ...]) -> str:
    """The numbers of sensors of the zones as a sum."""
    return " + ".join(map(str, sensors))


def figure_15_section(runs: Runs) -> Section:
    """Figure 15: the second map."""
    mission = runs.map_15
    panel = MapPanel(title="Task environment", note=rest_note(mission), mission=mission, named_zones=True)
    periods = ", ".join(f"{zone_title(zone.name)} {zone.period_s:g} s" for zone in mission.zones)
    return Section(
        figure=15,
        heading="the second map",
        pictures=(
            Picture(
                "sun2019-figure-15.png",
                "A pentagon with a hexagonal zone, a circular zone and two obstacles",
                study_picture([panel], columns=1, width=ONE_MAP_WIDTH),
            ),
        ),
        caption=f"Figure 15. {RECONSTRUCTED} Sizes, places and the sensors' radius are ours.",
        paper="A pentagon with a hexagonal and a circular sub-region and two obstacles; periods are told by Table 8 "
        "only, the radius of the sensors is not told again (Section 5.3).",
        ours=f"{_ground(mission)}; {periods}, the rest {mission.period_s:g} s; robots go "
        f"{mission.fleet.speed_m_s:g} m/s and see {mission.fleet.sensor.reach_m:g} m.",
    )


def _ground(mission: Mission) -> str:
    """The free ground of a mission in square metres, in words."""
    walls_m2 = sum(obstacle.shape.intersection(mission.area).area for obstacle in mission.obstacles)
    return f"{mission.area.area - walls_m2:,.0f} m² of free ground"
