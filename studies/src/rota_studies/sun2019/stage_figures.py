"""Figures 6, 8, 12 and 15: sensors with and without rules, two distances, the stages one by one, the second map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rota.model.mission import Mission
from rota_studies.panels.curve_panel import CurvePanel
from rota_studies.panels.map_panel import MapPanel
from rota_studies.section import Picture, Section
from rota_studies.sun2019 import paper
from rota_studies.sun2019.cases import brief
from rota_studies.sun2019.maps import RECONSTRUCTED
from rota_studies.sun2019.panels import (
    cost_panel,
    deployment_panel,
    frame_panel,
    printed_panel,
    rest_note,
    segments_panel,
    sensors_by_zone,
    zone_title,
)
from rota_studies.sun2019.readings import AS_HERE, LETTER, addition_table, pairs_by_addition
from rota_studies.sun2019.results import Sensors, Way
from rota_studies.sun2019.runs import Runs
from rota_studies.sun2019.verdicts import crossings_verdict, graph_verdict, rules_verdicts
from rota_studies.tables import Table, counted, plus_minus

ONE_MAP_WIDTH = 3.9  # inches


def figure_6_section(runs: Runs) -> Section:
    """Figure 6: what the heuristic rules do for the deployment."""
    mission = runs.map_13
    pairs = pairs_by_addition(runs)
    with_rules, without = (several[0] for several in pairs[AS_HERE])
    panels: list[MapPanel | CurvePanel] = [
        deployment_panel("(a) With heuristic rules", mission, with_rules),
        deployment_panel("(b) Without", mission, without),
        cost_panel("(c) Cost", [("with rules", with_rules), ("without", without)], wide=True),
    ]
    zones = [*(zone_title(zone.name) for zone in mission.zones), "rest"]
    printed = (paper.SENSORS_WITH_RULES, paper.SENSORS_WITHOUT_RULES)
    table = Table(
        title=f"Virtual sensors that cover the map, {len(pairs[AS_HERE].saved)} seeds: mean (range)",
        head=("CCPSO2", "paper", "ours", *(f"ours, {zone}" for zone in zones)),
        rows=tuple(
            (name, str(theirs), *(brief(column) for column in _counts(mission, several).T.tolist()))
            for name, theirs, several in zip(("with rules", "without"), printed, pairs[AS_HERE], strict=True)
        ),
    )
    letter = pairs[LETTER]
    return Section(
        figure=6,
        heading="sensors with and without the heuristic rules",
        pictures=(
            Picture(
                "sun2019-figure-6.png",
                f"{with_rules.count} sensors with the rules, {without.count} without, and how the cost of both falls",
                tuple(panels),
            ),
        ),
        caption=f"Figure 6, with seed {runs.seed}. {RECONSTRUCTED} It does not say which map Figure 6 shows: under the "
        f"same Table 2 it has {paper.SENSORS_WITH_RULES} sensors with the rules there and "
        f"{sum(paper.FIGURE_13.sensors)} in Figure 13. The weights λ of Eq. 11 are not printed, so that costs cannot "
        "be set beside each other.",
        paper=f"CCPSO2 with the rules (addition, movement, deletion, fusion) takes {paper.SENSORS_WITH_RULES} sensors, "
        f"standard CCPSO2 {paper.SENSORS_WITHOUT_RULES}; the rules make it converge faster (Section 4.2).",
        ours=f"{brief([one.count for one in pairs[AS_HERE].with_rules])} sensors with the rules, "
        f"{brief([one.count for one in pairs[AS_HERE].without])} without. The rules save "
        f"{brief(pairs[AS_HERE].saved)}, the paper's {printed[1] - printed[0]}. That rests on three additions of ours, "
        f"without which Algorithm 1 takes {brief([one.count for one in letter.with_rules])} with the rules and "
        f"{brief([one.count for one in letter.without])} without.",
        tables=(table, addition_table(runs, pairs)),
        verdicts=rules_verdicts(pairs),
    )


def _counts(mission: Mission, several: Sequence[Sensors]) -> NDArray[np.int64]:
    """(seeds, 1 + zones) sensors in all, and of each zone."""
    by_zone = np.array([sensors_by_zone(mission, one) for one in several])
    return np.column_stack([by_zone.sum(axis=1), by_zone])


def figure_8_section(runs: Runs) -> Section:
    """Figure 8: the frame by straight distances and by Eq. 14."""
    mission, settings = runs.map_8, runs.figure_13
    deploy = settings.deployments[0]
    sensors = runs.sensors(mission, deploy, runs.seed)
    straight, graph = (
        [runs.way(mission, deploy, replace(settings.tour, distance=distance), seed) for seed in runs.seeds]
        for distance in ("euclidean", "graph")
    )
    panels = (
        frame_panel("(a) Euclidean distances", mission, sensors, straight[0]),
        frame_panel("(b) Distances of Eq. 14", mission, sensors, graph[0]),
    )

    def row(name: str, crossings: int, ways: Sequence[Way]) -> tuple[str, ...]:
        counts = (brief([way.zone_crossings for way in ways]), brief([way.blocked_legs for way in ways]))
        return name, str(crossings), *counts, plus_minus([way.length_m for way in ways], ",.0f")

    table = Table(
        title=f"Crossings between the two sub-regions, {len(graph)} seeds: mean (range)",
        head=("distances", "paper", "ours", "ours, legs through walls", "ours, frame m"),
        rows=(
            row("Euclidean", paper.CROSSINGS_EUCLIDEAN, straight),
            row("Eq. 14", paper.CROSSINGS_GRAPH, graph),
        ),
    )
    longer = 100 * np.mean([b.length_m / a.length_m - 1 for a, b in zip(straight, graph, strict=True)])
    return Section(
        figure=8,
        heading="the frame by two distances",
        pictures=(
            Picture(
                "sun2019-figure-8.png",
                f"{counted(straight[0].zone_crossings, 'crossing')} with Euclidean distances, "
                f"{graph[0].zone_crossings} with those of Eq. 14",
                panels,
            ),
        ),
        caption=f"Figure 8, with seed {runs.seed}. {RECONSTRUCTED} Figure 8 has a map of two sub-regions that is drawn "
        "nowhere else; ours is that of Figure 13 with one zone. Red rings: where the frame crosses from one to the "
        "other.",
        paper=f"The frame crosses {paper.CROSSINGS_EUCLIDEAN} times with Euclidean distances and "
        f"{paper.CROSSINGS_GRAPH} times with those of Eq. 14 (Section 4.3).",
        ours=f"{brief([way.zone_crossings for way in straight])} crossings and "
        f"{brief([way.zone_crossings for way in graph])}. Legs through walls: "
        f"{brief([way.blocked_legs for way in straight])} with Euclidean distances, "
        f"{brief([way.blocked_legs for way in graph])} with Eq. 14's. The frame is {abs(longer):.1f} % "
        f"{'longer' if longer >= 0 else 'shorter'} for that.",
        tables=(table,),
        verdicts=(crossings_verdict(straight, graph, settings.tour.alpha_m),),
    )


def figure_12_section(runs: Runs) -> Section:
    """Figure 12: the stages of the method one after the other."""
    mission, settings = runs.map_13, runs.figure_13
    printed = runs.printed(mission, settings)
    sensors, frame, partition = printed.sensors, printed.way, printed.partition
    range_m = settings.tour.neighbour_range * sensors.virtual_radius_m
    graphs = [runs.graph(mission, settings, seed) for seed in runs.seeds]
    graphs += [runs.graph(runs.map_15, runs.figure_16, seed) for seed in runs.seeds]
    edges = tuple(sensors.positions_m[pair] for pair in graphs[0].edges)
    panels: list[MapPanel | CurvePanel] = [
        MapPanel(title="(1) Mission", note=rest_note(mission), mission=mission, named_zones=True),
        deployment_panel("(2) Sensors (Algorithm 1)", mission, sensors),
        frame_panel("(3) Graph and frame (Algorithm 2)", mission, sensors, frame, edges=edges),
        segments_panel("(4) Segments (Algorithm 3)", mission, sensors, frame, partition),
        printed_panel("(5) Routes", mission, printed),
    ]
    ours, theirs = sensors_by_zone(mission, sensors), paper.FIGURE_13.sensors
    return Section(
        figure=12,
        heading="the stages of the method",
        pictures=(
            Picture(
                "sun2019-figure-12.png",
                "The mission, sensors with what they see, the frame through them, its segments, and their routes",
                tuple(panels),
            ),
        ),
        caption=f"Figure 12, with seed {runs.seed}. {RECONSTRUCTED} Every sensor is drawn with the "
        f"{sensors.virtual_radius_m:g} m that it sees (r_v = 2 r_s); the graph joins sensors at most {range_m:g} m "
        "apart (r_n) with no wall between them. Crosses: routes that are late by Eq. 26.",
        paper="Sensors are deployed zone by zone, from the smallest period up, joined to a closed frame, and the frame "
        "is cut into one segment for each robot (Section 4.5). The text says T₁ > T₂ > T₃, Table 1 the contrary, which "
        "we follow: the smallest period is the most important.",
        ours=f"{_by_zone(ours)} = {counted(sum(ours), 'sensor')} where the paper has {_by_zone(theirs)} = "
        f"{sum(theirs)}, a graph of {len(edges)} edges, a frame of {frame.length_m:,.0f} m that changes zones "
        f"{frame.zone_crossings} times, and {counted(printed.robots, 'segment')}. Further seeds are in Figure 13.",
        verdicts=(graph_verdict(graphs),),
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
                (panel,),
                columns=1,
                width=ONE_MAP_WIDTH,
            ),
        ),
        caption=f"Figure 15. {RECONSTRUCTED} Sizes, places and the sensors' radius are ours.",
        paper="A pentagon with a hexagonal and a circular sub-region and two obstacles; periods are told by Table 8 "
        "only, the radius of the sensors is not told again (Section 5.3).",
        ours=f"{_ground(mission)}; {periods}, the rest {mission.period_s:g} s; robots go {mission.fleet.speed_m_s:g} "
        f"m/s and see {mission.fleet.sensor.reach_m:g} m.",
    )


def _ground(mission: Mission) -> str:
    """The free ground of a mission in square metres, in words."""
    walls_m2 = sum(obstacle.shape.intersection(mission.area).area for obstacle in mission.obstacles)
    return f"{mission.area.area - walls_m2:,.0f} m² of free ground"
