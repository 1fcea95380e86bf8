"""What the paper leaves open, read in several ways with several seeds: sensors, tours, and robots by Eq. 26."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rota.model.mission import Mission
from rota_studies.sun2019 import paper
from rota_studies.sun2019.cases import with_late, with_late_spread
from rota_studies.sun2019.panels import zone_title
from rota_studies.sun2019.results import Printed, Sensors, Way
from rota_studies.sun2019.runs import Reading, Runs
from rota_studies.sun2019_method.algorithms import PaperAlgorithms
from rota_studies.sun2019_method.deploy import DeploySettings
from rota_studies.sun2019_method.mission_settings import SegmentSettings
from rota_studies.tables import Table, plus_minus
from rota_studies.verdict import spread

LOCAL_SEARCH = "local search (ours)"
NEVER_LATE = 1e6  # xi_1 at which a millisecond costs as much as a robot
WEIGHTS = (paper.LEAST_WEIGHT, SegmentSettings().weight_late, paper.MOST_WEIGHT, NEVER_LATE)
AS_HERE, LETTER = "as here", "all three, the letter of Algorithm 1"
Asked = tuple[paper.PaperCase, Mission, PaperAlgorithms]


class Pair(NamedTuple):
    """Deployments with the rules and without them, seed by seed."""

    with_rules: tuple[Sensors, ...]
    without: tuple[Sensors, ...]

    @property
    def saved(self) -> list[int]:
        """Sensors that the rules save."""
        return [b.count - a.count for a, b in zip(*self, strict=True)]


def additions_left_out(base: DeploySettings) -> dict[str, DeploySettings]:
    """The deployment's settings as they are, without each of our additions, and without all."""
    return {
        AS_HERE: base,
        "rules begin from where the particle strayed to": replace(base, rules_from_best=0.0),
        "sensors grouped at random": replace(base, grouping="random"),
        "one movement after a fusion": replace(base, movement_repeats=1),
        LETTER: replace(base, rules_from_best=0.0, grouping="random", movement_repeats=1),
    }


def pairs_by_addition(runs: Runs) -> dict[str, Pair]:
    """Deployments on Figure 13's map with rules and without, for each of our additions left out.

    Those that verdicts rest on have all seeds.
    """

    def pair(name: str, settings: DeploySettings) -> Pair:
        seeds = runs.seeds if name in (AS_HERE, LETTER) else runs.reading_seeds
        both = (settings, settings.without_rules())
        return Pair(*(tuple(runs.sensors(runs.map_13, one, seed) for seed in seeds) for one in both))

    changed = additions_left_out(runs.figure_13.deployments[0])
    return {name: pair(name, settings) for name, settings in changed.items()}


def addition_table(runs: Runs, pairs: dict[str, Pair]) -> Table:
    """Figure 6 with each of our additions left out."""
    rows = tuple(
        (
            name, *(spread([one.count for one in several], ".1f") for several in pair),
            f"{plus_minus(pair.saved, '.1f')}", str(len(pair.saved)),
        )
        for name, pair in pairs.items()
    )  # fmt: skip
    return Table(
        title=f"Sensors with our additions left out (the paper: {paper.SENSORS_WITH_RULES} with rules, "
        f"{paper.SENSORS_WITHOUT_RULES} without): mean ± deviation (range)",
        head=("CCPSO2", "with rules", "without", "saved", "seeds"),
        rows=rows,
    )


def tours_by_reading(runs: Runs) -> dict[str, tuple[Way, ...]]:
    """The genetic algorithm with each of our readings left out, and the local search, over the same sensors."""
    tour, deploy = runs.figure_13.tour, runs.figure_13.deployments[0]
    ways = {
        AS_HERE: tour,
        "one stretch drawn for a reversal": replace(tour, reversal_tries=1),
        "groups of four drawn in every generation": replace(tour, regroup_every=1),
        "both": replace(tour, reversal_tries=1, regroup_every=1),
        LOCAL_SEARCH: replace(tour, method="local_search"),
    }
    return {
        name: tuple(runs.way(runs.map_13, deploy, settings, seed) for seed in runs.seeds)
        for name, settings in ways.items()
    }


def tour_table(tours: dict[str, tuple[Way, ...]]) -> Table:
    """Lengths and crossings of the tours."""
    rows = [
        (name, spread([way.length_m for way in ways]), spread([way.zone_crossings for way in ways], ".1f"))
        for name, ways in tours.items()
    ]
    return Table(
        title=f"Tours over Figure 13's sensors, {len(tours[AS_HERE])} seeds: mean ± deviation (range)",
        head=("Algorithm 2", "way m", "crossings"),
        rows=tuple(rows),
    )


def lengths_table(names: Sequence[str], frames: Sequence[Printed]) -> Table:
    """The frame by sub-region, beside what the paper's times leave room for."""
    ours = []
    for name in names:
        lengths = [one.way.zones_m[[zone.name for zone in one.sensors.zones].index(name)] for one in frames]
        ours.append(spread([float(length) for length in lengths]))
    return Table(
        title=f"The frame by sub-region, m, {len(frames)} seeds; the paper's reckoned from the times of Tables 5 and 6",
        head=("", *map(zone_title, names), "in all"),
        rows=(
            ("paper", *paper.FRAME_BY_ZONE, f"{paper.FIGURE_13.length_m:,.0f}"),
            ("ours", *ours, spread([one.way.length_m for one in frames])),
        ),
    )


def asked_of(runs: Runs) -> list[Asked]:
    """All cases of the paper with their maps and settings; the last is on another map."""
    figure_13, figure_16 = runs.figure_13, runs.figure_16
    asked: list[Asked] = [(paper.TABLE_5, runs.map_13, figure_13)]
    asked += [(case, mission, figure_13) for case, mission in zip(paper.TABLE_6, runs.maps_14, strict=True)]
    return [*asked, (paper.TABLE_8, runs.map_15, figure_16)]


def robots_by_alpha(runs: Runs) -> dict[float, list[int]]:
    """Robots of Tables 5 and 6 together, seed by seed, on frames with alpha as it is and without any.

    Frames by local search and cut exactly by the estimate of Eq. 26, so that the algorithms' luck has no part in it.
    """
    found = {}
    for alpha in (runs.figure_13.tour.alpha_m, 0.0):
        sums = []
        for seed in runs.seeds:
            cuts = [
                runs.cut_exactly(
                    mission, under.deployments[0], replace(under.tour, method="local_search", alpha_m=alpha), seed
                )
                for _, mission, under in asked_of(runs)[:-1]
            ]
            sums.append(sum(cut.robots for cut in cuts))
        found[alpha] = sums
    return found


def reading_table(runs: Runs) -> Table:
    """Robots of the partitions that Eq. 28 costs least, by the reading of Eqs. 22 and 28; all cases of the paper."""
    asked = asked_of(runs)
    theirs = [(len(case.routes), sum(route.late for route in case.routes)) for case, _, _ in asked]
    sums = [sum(pair[k] for pair in theirs[:-1]) for k in (0, 1)]
    rows = [("paper", *(with_late(*pair) for pair in theirs), with_late(*sums), "")]
    under = asked[0][2].partition
    swarms = [
        [(one.robots, len(one.late)) for one in (runs.printed(mission, own, seed) for seed in runs.seeds)]
        for _, mission, own in asked
    ]
    legs = "kept" if under.joining_legs else "left out"
    rows.append(_row(f"Eq. 26: swarms; legs {legs}, ξ₁ = {under.weight_late:g}", swarms))
    for joining in (True, False):
        for weight in WEIGHTS:
            late = "never late" if weight == NEVER_LATE else f"ξ₁ = {weight:g}"
            cuts = cuts_by_case(runs, Reading(joining, weight))
            rows.append(_row(f"legs {'kept' if joining else 'left out'}, {late}", cuts))
    names = [case.name.replace("Section ", "").replace("Case ", "C") for case, _, _ in asked]
    return Table(
        title="Tables 5, 6 and 8 by readings of Eq. 26: robots of the partition that Eq. 28 costs least, means "
        "(ranges)",
        head=("reading", *names, "Tables 5 and 6", "seeds"),
        rows=tuple(rows),
    )


def cuts_by_case(runs: Runs, reading: Reading) -> list[list[tuple[int, int]]]:
    """Segments, and those that are late, of the cheapest partition: for each case, seed by seed.

    Where the leg that leads to a segment is kept, all seeds: verdicts rest on it.
    """
    seeds = runs.seeds if reading.joining_legs else runs.reading_seeds
    return [
        [(cut.robots, cut.late) for cut in (runs.cheapest(mission, under, reading, seed) for seed in seeds)]
        for _, mission, under in asked_of(runs)
    ]


def _row(name: str, by_case: Sequence[Sequence[tuple[int, int]]]) -> tuple[str, ...]:
    """Robots, and how many are late, of each case; the sum is that of Tables 5 and 6, without the last one."""
    told = [with_late_spread([n for n, _ in pairs], [late for _, late in pairs]) for pairs in by_case]
    sums = np.array(by_case[:-1]).sum(axis=0)
    return (name, *told, with_late_spread(sums[:, 0].tolist(), sums[:, 1].tolist()), str(len(by_case[0])))
