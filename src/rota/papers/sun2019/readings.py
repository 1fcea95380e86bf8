"""What the paper leaves open, read in several ways with several seeds: sensors, tours, and robots by Eq. 26."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from rota.mission import Mission
from rota.papers.sun2019 import paper
from rota.papers.sun2019.cases import with_late
from rota.papers.sun2019.runs import Printed, Reading, Runs
from rota.papers.tables import Table
from rota.planners.patrol.methods.sun2019.deploy_settings import DeploySettings
from rota.planners.patrol.methods.sun2019.settings import MethodSettings

NEVER_LATE = 1e6  # xi_1 at which a millisecond costs as much as a robot
WEIGHTS = (200.0, 300.0, 500.0, NEVER_LATE)
AS_HERE, LETTER = "as here", "all three, the letter of Algorithm 1"
Counts = Mapping[str, tuple[tuple[int, ...], tuple[int, ...]]]
Asked = tuple[paper.PaperCase, Mission, MethodSettings]


def additions_left_out(base: DeploySettings) -> dict[str, DeploySettings]:
    """The deployment's settings as they are, without each of our additions, and without all."""
    return {
        AS_HERE: base,
        "rules begin from where the particle strayed to": replace(base, rules_from_best=0.0),
        "sensors grouped at random": replace(base, grouping="random"),
        "one movement after a fusion": replace(base, movement_repeats=1),
        LETTER: replace(base, rules_from_best=0.0, grouping="random", movement_repeats=1),
    }


def spread(values: Sequence[int]) -> str:
    """``86``, or ``85 to 88``."""
    return f"{values[0]}" if len(set(values)) == 1 else f"{min(values)} to {max(values)}"


def counts_by_addition(runs: Runs) -> Counts:
    """Sensors on Figure 13's map with rules and without, each with each seed, for each of our additions left out."""

    def counts(settings: DeploySettings) -> tuple[int, ...]:
        deployed = [runs.deployment(runs.map_13, settings, seed=seed) for seed in runs.seeds]
        return tuple(len(zone.positions_m) for zone in deployed)

    changed = additions_left_out(runs.settings.figure_13.deployments[0])
    return {name: (counts(settings), counts(settings.without_rules())) for name, settings in changed.items()}


def addition_table(runs: Runs, counts: Counts) -> Table:
    """Figure 6 with each of our additions left out."""
    rows = tuple(
        (name, ", ".join(map(str, with_rules)), ", ".join(map(str, without)))
        for name, (with_rules, without) in counts.items()
    )
    return Table(
        title=f"Sensors with our additions left out, seeds {_listed(runs)} (the paper: {paper.SENSORS_WITH_RULES} with "
        f"rules, {paper.SENSORS_WITHOUT_RULES} without)",
        head=("CCPSO2", "with rules", "without"),
        rows=rows,
    )


def tour_table(runs: Runs, printed: Printed) -> Table:
    """The genetic algorithm with each of our readings left out, and the local search, over the same sensors."""
    tour, deployment = runs.settings.figure_13.tour, printed.stages.framed.deployment
    ways = {
        AS_HERE: tour,
        "one stretch drawn for a reversal": replace(tour, reversal_tries=1),
        "groups of four drawn in every generation": replace(tour, regroup_every=1),
        "both": replace(tour, reversal_tries=1, regroup_every=1),
        "local search (ours)": replace(tour, method="local_search"),
    }
    rows = []
    for name, settings in ways.items():
        frames = [runs.frame(printed.mission, deployment, settings, seed=seed) for seed in runs.seeds]
        lengths = ", ".join(f"{frame.length_m:,.0f}" for frame in frames)
        rows.append((name, lengths, ", ".join(str(frame.zone_crossings) for frame in frames)))
    return Table(
        title=f"Tours over the {len(deployment.positions_m)} sensors, seeds {_listed(runs)}",
        head=("Algorithm 2", "way m", "crossings"),
        rows=tuple(rows),
    )


def reading_table(runs: Runs) -> Table:
    """Robots of the partitions that Eq. 28 costs least, by the reading of Eqs. 22 and 28; all cases of the paper."""
    figure_13, figure_16 = runs.settings.figure_13, runs.settings.figure_16
    asked: list[Asked] = [(paper.TABLE_5, runs.map_13, figure_13)]
    asked += [(case, mission, figure_13) for case, mission in zip(paper.TABLE_6, runs.maps_14, strict=True)]
    asked += [(paper.TABLE_8, runs.map_15, figure_16)]
    theirs = [(len(case.routes), sum(route.late for route in case.routes)) for case, _, _ in asked]
    rows = [_row("paper", theirs), _swarms_row(runs, asked)]
    framed = [[runs.framed(mission, under, seed=seed) for seed in runs.seeds] for _, mission, under in asked]
    for joining in (True, False):
        for weight in WEIGHTS:
            by_case = []
            for (_, mission, under), frames in zip(asked, framed, strict=True):
                cuts = [runs.cheapest(frame, mission, under, Reading(joining, weight)) for frame in frames]
                by_case.append([(len(cut.first), int((cut.times_s >= cut.periods_s).sum())) for cut in cuts])
            sums = [sum(pairs[k][0] for pairs in by_case[:-1]) for k in range(len(runs.seeds))]
            late = "never late" if weight == NEVER_LATE else f"ξ₁ = {weight:g}"
            name = f"legs {'kept' if joining else 'left out'}, {late}"
            rows.append(_row(name, [pairs[0] for pairs in by_case], spread(sums)))
    names = [case.name.replace("Section ", "").replace("Case ", "C") for case, _, _ in asked]
    return Table(
        title="Tables 5, 6 and 8 by readings of Eq. 26: robots of the partition that Eq. 28 costs least",
        head=("reading", *names, "Tables 5 and 6", f"the same, seeds {_listed(runs)}"),
        rows=tuple(rows),
    )


def _row(name: str, counts: Sequence[tuple[int, int]], sums: str = "") -> tuple[str, ...]:
    """Robots, and how many of them are late, of each case; the sum is that of Tables 5 and 6, without the last one."""
    robots, late = (sum(pair[k] for pair in counts[:-1]) for k in (0, 1))
    return (name, *(with_late(*pair) for pair in counts), with_late(robots, late), sums)


def _swarms_row(runs: Runs, asked: Sequence[Asked]) -> tuple[str, ...]:
    """What Algorithm 3's swarms find by the reading of the tables above."""
    counts = []
    for _, mission, settings in asked:
        partitions = runs.printed(mission, settings).stages.partitions
        late = sum(int((partition.times_s >= partition.periods_s).sum()) for partition in partitions)
        counts.append((sum(len(partition.first) for partition in partitions), late))
    under = asked[0][2].partition
    return _row(
        f"Eq. 26: swarms; legs {'kept' if under.joining_legs else 'left out'}, ξ₁ = {under.weight_late:g}", counts
    )


def _listed(runs: Runs) -> str:
    """The seeds as text."""
    return ", ".join(map(str, runs.seeds))
