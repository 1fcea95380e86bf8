"""What became of each claim of the paper: a verdict from the runs, and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from rota_studies.sun2019 import paper
from rota_studies.sun2019.cases import Case, brief, together, unseen_and_late, with_late_spread
from rota_studies.sun2019.panels import zone_title
from rota_studies.sun2019.readings import AS_HERE, LETTER, LOCAL_SEARCH, NEVER_LATE, WEIGHTS, Pair
from rota_studies.sun2019.results import Found, Sensors, Way
from rota_studies.sun2019.runs import Graph
from rota_studies.tables import joined
from rota_studies.verdict import LEAST_SEEDS, Verdict, always, compared, mostly

TRADITIONAL = ("sequential", "parallel", "decomposition")

NOT_RUN = Verdict(
    claim="Advantages over Karapetyan et al. and Palacios-Gasós et al.",
    place="6",
    outcome="cannot be told",
    why="Argued in words alone; neither method is made here.",
)


def rules_verdicts(pairs: Mapping[str, Pair]) -> tuple[Verdict, ...]:
    """Section 4.2: fewer sensors, and faster convergence, by the letter of Algorithm 1 and with our additions."""
    letter, here = pairs[LETTER], pairs[AS_HERE]
    saved = {name: compared(pair.saved) for name, pair in ((LETTER, letter), (AS_HERE, here))}
    sooner = {
        name: compared([_near_end(b) - _near_end(a) for a, b in zip(*pair, strict=True)], unit=" iterations")
        for name, pair in ((LETTER, letter), (AS_HERE, here))
    }
    passes = {
        name: sum(_passes(a, b) for a, b in zip(*pair, strict=True))
        for name, pair in ((LETTER, letter), (AS_HERE, here))
    }
    seeds = len(letter.saved)
    return (
        Verdict(
            "The heuristic rules save sensors", "4.2", saved[LETTER].outcome,
            f"By the letter of Algorithm 1 {brief([one.count for one in letter.with_rules])} with the rules and "
            f"{brief([one.count for one in letter.without])} without (the paper 99 and 103): saved "
            f"{saved[LETTER].told}.",
        ),
        Verdict(
            "The same with three additions of ours (see below)", "4.2", saved[AS_HERE].outcome,
            f"{brief([one.count for one in here.with_rules])} with the rules and "
            f"{brief([one.count for one in here.without])} without: saved {saved[AS_HERE].told}.",
        ),
        Verdict(
            "The rules make CCPSO2 converge faster", "4.2", sooner[LETTER].outcome,
            f"In speed: by the letter the cost is within twice its own last value sooner by {sooner[LETTER].told}; "
            f"with our additions by {sooner[AS_HERE].told}. Not in depth: the cost falls below what the run without "
            f"rules ends with in {passes[LETTER]} of {seeds} seeds by the letter, in {passes[AS_HERE]} with our "
            "additions.",
        ),
    )  # fmt: skip


def _near_end(sensors: Sensors) -> int:
    """The first iteration whose cost is within twice the last."""
    assert sensors.cost is not None
    return int(np.flatnonzero(sensors.cost <= 2 * sensors.cost[-1])[0])


def _passes(with_rules: Sensors, without: Sensors) -> bool:
    """Whether the run with rules passes the other's last cost before its end."""
    assert with_rules.cost is not None
    assert without.cost is not None
    return bool((with_rules.cost[:-1] < without.cost[-1]).any())


def crossings_verdict(straight: Sequence[Way], graph: Sequence[Way], alpha: float) -> Verdict:
    """Section 4.3: distances of Eq. 14 make the frame cross between sub-regions less often."""
    fewer = compared([a.zone_crossings - b.zone_crossings for a, b in zip(straight, graph, strict=True)])
    return Verdict(
        "Distances of Eq. 14 make the frame cross between sub-regions less often", "4.3", fewer.outcome,
        f"{brief([way.zone_crossings for way in graph])} crossings for "
        f"{brief([way.zone_crossings for way in straight])} (the paper: {paper.CROSSINGS_GRAPH} for "
        f"{paper.CROSSINGS_EUCLIDEAN}), by α = {alpha:,.0f}: fewer by {fewer.told}.",
    )  # fmt: skip


def fewer_robots_verdict(by_alpha: Mapping[float, Sequence[int]]) -> Verdict:
    """Section 4.3: fewer crossings let fewer robots do, the reason for Eqs. 12 to 14."""
    (alpha, few), (_, many) = by_alpha.items()
    fewer = compared([b - a for a, b in zip(few, many, strict=True)])
    return Verdict(
        "Fewer crossings let fewer robots do", "4.3, Eqs. 12 to 14", fewer.outcome,
        f"Tables 5 and 6 together, frames by local search and cut exactly: α = {alpha:,.0f} takes {brief(few)} robots, "
        f"α = 0 {brief(many)}; fewer by {fewer.told}.",
    )  # fmt: skip


def graph_verdict(graphs: Sequence[Graph]) -> Verdict:
    """Section 4.3: with r_n of 2 r_v or more the graph is connected."""
    whole = always([graph.parts == 1 for graph in graphs])
    parts = max(graph.parts for graph in graphs)
    return Verdict(
        "r_n ≥ 2 r_v makes the graph connected", "4.3", whole.outcome,
        "As printed, edges ask for a distance alone: what sensors see touches where they cover connected ground, so "
        "that it is true. A robot needs edges that no wall crosses; with walls, sensors that are near may not see "
        f"each other. On the paper's maps, with r_n = 2 r_v, a graph of such edges is in one part in {whole.told}"
        + (f", in {parts} parts at most. Legs between parts then lead round the walls." if parts > 1 else "."),
    )  # fmt: skip


def genetic_verdict(tours: Mapping[str, Sequence[Way]]) -> Verdict:
    """Section 4.3: the genetic algorithm is one of the most ideal for the travelling salesman."""
    pairs = zip(tours[AS_HERE], tours[LOCAL_SEARCH], strict=True)
    shorter = compared([other.tour_length - own.tour_length for own, other in pairs], ours=True, form=",.0f", unit=" m")
    best = [100 * (a.length_m / b.length_m - 1) for a, b in zip(tours[AS_HERE], tours[LOCAL_SEARCH], strict=True)]
    return Verdict(
        "GA is one of the most ideal algorithms for the tour", "4.3", shorter.outcome,
        f"Shorter by Eq. 12 than a plain local search (2-opt and Or-opt with kicks) by {shorter.told}; its way is "
        f"{np.mean(best):+.1f} % ({min(best):+.1f} to {max(best):+.1f} %) beside it. When groups are drawn and how "
        "many reversals are tried is our reading; others of it come out longer.",
    )  # fmt: skip


def run_verdicts(case: Case, proving: Found, effort: str) -> tuple[Verdict, ...]:
    """Section 5.1: the number of robots, its routes, and what they cover."""
    bound = max(case.lower_bound or 0, proving.lower_bound_robots or 0)
    plans = [found for found in (proving, *case.outcomes.values()) if found.met and found.robots is not None]
    least = min((found.robots for found in plans if found.robots is not None), default=None)
    fewer = least is not None and least < min(case.robots) and len(case.robots) >= LEAST_SEEDS
    told = "no plan passes the check" if least is None else f"a plan that the check passes has {least}"
    return (
        Verdict(
            "The robots are as few as can be (“minimum”, “optimal number”)", "Title, 5.1, 6",
            "does not hold" if fewer else "cannot be told",
            f"On our map the paper's algorithms take {with_late_spread(case.robots, case.late)} (the paper "
            f"{len(case.paper.routes)}); {told} (`tours`, at effort {effort}), and {bound} are proved to be needed.",
        ),
        coverage_verdict(case, "5.1"),
        _mended_verdict(case),
    )  # fmt: skip


def coverage_verdict(case: Case, place: str) -> Verdict:
    """Whether the routes as printed see everything, and in time."""
    met = always([one.verdict == "met" for one in case.printed], ours=True)
    return Verdict(
        "The routes cover the area “completely and persistently”", place, met.outcome,
        f"{case.paper.name}, routes as printed: the check passes them in {met.told}; {unseen_and_late(case)}. How "
        "routes are led at walls and at their own next lane is not told.",
    )  # fmt: skip


def _mended_verdict(case: Case) -> Verdict:
    """The verdict on Table 5: whether repaired routes keep all periods with as many robots."""
    mended, theirs = case.outcomes["mended"], len(case.paper.routes)
    enough = mended.met and mended.robots is not None and mended.robots <= theirs
    return Verdict(
        "Obstacles are avoided and periods kept by so many robots", "5.1, Table 5",
        "holds" if enough else "not reproduced",
        "How a route is led round an obstacle is not told. Ours follow the walls; mended until the check passes they "
        f"take {mended.robots or 'no number of'} robots for the {theirs} printed, on our map.",
    )  # fmt: skip


def verdicts_of_cases(
    cases: Sequence[Case], cuts: Mapping[float, Sequence[Sequence[tuple[int, int]]]]
) -> list[Verdict]:
    """Section 5.2, and Section 4.1's judgement on traditional methods.

    cuts: by xi_1, for the cases of Tables 5, 6 and 8 in this order, segments and late ones of the cheapest partition.
    """
    return [
        adapts_verdict(cases),
        _by_zone(cases),
        _in_time(cases, cuts),
        _case_2(cases),
        _case_6(cases),
        _traditional(cases),
    ]


def adapts_verdict(cases: Sequence[Case]) -> Verdict:
    """Section 5.2: shorter periods take more robots."""
    pairs = [
        (one, later)
        for one in cases
        for later in cases
        if one is not later and all(b <= a for a, b in zip(one.paper.periods_s, later.paper.periods_s, strict=True))
    ]
    more = np.array([np.subtract(later.robots, one.robots) for one, later in pairs])  # (pairs, seeds)
    does = mostly([bool(run.all()) for run in (more > 0).T])
    robots, late = together(cases)
    return Verdict(
        "The method adapts the number of robots to the periods", "5.2, 6", does.outcome,
        "Of any two cases of which one has no longer period anywhere, that one takes more robots in "
        f"{does.told}; pair by pair more in {(more > 0).sum()} of {more.size}, fewer in {(more < 0).sum()}. Together "
        f"{with_late_spread(robots, late)} for the paper's {sum(len(case.paper.routes) for case in cases)}.",
    )  # fmt: skip


def _by_zone(cases: Sequence[Case]) -> Verdict:
    """Tables 5 and 6 sub-region by sub-region: totals may agree by chance."""
    within, off = [], []
    for case in cases:
        for k, name in enumerate(case.names):
            ours = case.ours[:, k]
            within.append(bool(ours.min() <= case.theirs[k] <= ours.max()))
            if not within[-1]:
                off.append(f"{case.paper.name} {zone_title(name)} {case.theirs[k]} against {brief(ours.tolist())}")
    judged = always(within, ours=True)
    return Verdict(
        "Robots of each sub-region as in Table 6", "5.2, Table 6",
        judged.outcome if len(cases[0].printed) >= LEAST_SEEDS else "cannot be told",
        f"The paper's number is among those of our seeds in {sum(within)} of {len(within)} sub-regions. Not in: "
        f"{'; '.join(off) or 'none'}. Map, frames and ξ₁ are ours.",
    )  # fmt: skip


def _in_time(cases: Sequence[Case], cuts: Mapping[float, Sequence[Sequence[tuple[int, int]]]]) -> Verdict:
    """Section 5.2: every route keeps its period, but in Case 6."""
    kept = always([late == 0 for case in cases[:-1] for late in case.late], ours=True)
    named = [f"ξ₁ = {weight:g}" for weight in WEIGHTS if weight != NEVER_LATE]
    late = [np.sum([[pair[1] for pair in case] for case in cuts[w][1:-1]], axis=0) for w in WEIGHTS if w != NEVER_LATE]
    told = joined([f"{brief(values.tolist())} late by {name}" for name, values in zip(named, late, strict=True)])
    return Verdict(
        "Every route keeps its period, but in Case 6", "5.2, Table 6", kept.outcome,
        f"By Eq. 26 here in {kept.told} of Cases 1 to 5; {with_late_spread(*together(cases))} robots of all six. ξ₁, "
        f"which is not printed, decides, with map and frames: of the cheapest partitions {told}.",
    )  # fmt: skip


def _named(cases: Sequence[Case], name: str) -> Case | None:
    """The case of that name; None where it was not run."""
    return next((case for case in cases if case.paper.name == name), None)


def _fewest(case: Case) -> str:
    """The fewest robots of any method, and which one took them."""
    least = case.fewest
    if least is None:
        return "no method found a plan"
    return f"{joined([way for way, found in case.outcomes.items() if found.met and found.robots == least])} {least}"


def _case_2(cases: Sequence[Case]) -> Verdict:
    """The verdict on Case 2's number of routes."""
    claim = "Case 2: five routes, not six, are the optimal number"
    case = _named(cases, "Case 2")
    if case is None:
        return Verdict(claim, "5.2", "cannot be told", "Not run.")
    fewer = case.fewest is not None and case.fewest < min(case.robots) and len(case.robots) >= LEAST_SEEDS
    return Verdict(
        claim, "5.2", "bettered" if fewer else "cannot be told",
        f"By Eq. 26 here {with_late_spread(case.robots, case.late)}; checked plans on the same map: {_fewest(case)} "
        f"(proved: at least {case.lower_bound}).",
    )  # fmt: skip


def _case_6(cases: Sequence[Case]) -> Verdict:
    """The verdict on Case 6's late routes."""
    claim = "Case 6: to let four routes be late is better than a robot more"
    case = _named(cases, "Case 6")
    if case is None:
        return Verdict(claim, "5.2", "cannot be told", "Not run.")
    needless = case.fewest is not None and case.fewest <= min(case.robots) and len(case.robots) >= LEAST_SEEDS
    return Verdict(
        claim, "5.2", "bettered" if needless else "cannot be told",
        f"Eq. 28 lets {brief(case.late)} be late here ({with_late_spread(case.robots, case.late)}), for ξ₁ of a few "
        f"hundred. But nothing need be late: {_fewest(case)}, all periods kept (proved: at least {case.lower_bound}).",
    )  # fmt: skip


def _traditional(cases: Sequence[Case]) -> Verdict:
    """Whether traditional methods, mended like all others, take more robots than the paper's own, on the same maps."""
    told, beats = [], False
    for way in TRADITIONAL:
        found = [case.outcomes[way] for case in cases]
        met = all(one.met and one.robots is not None for one in found)
        no_more = met and all((one.robots or 0) <= min(case.robots) for one, case in zip(found, cases, strict=True))
        beats = beats or no_more
        told.append(
            f"{way} {sum(one.robots or 0 for one in found)}"
            + ("" if met else ", not all met")
            + (", in no case more than the paper's own by any seed" if no_more else "")
        )
    enough = all(len(case.robots) >= LEAST_SEEDS for case in cases)
    return Verdict(
        "Traditional methods cannot cope with obstacles and with zones of different periods", "4.1",
        "does not hold" if beats and enough else "cannot be told",
        "Ours plan each group of zones with like periods, and are mended until the check passes. Robots of all cases: "
        f"{'; '.join(told)}; the paper's algorithms here {with_late_spread(*together(cases))}. *parallel* gives each "
        "robot a strip, which is our reading: the paper lets more robots fly abreast.",
    )  # fmt: skip
