"""What became of each claim of the paper: a verdict from the runs, and why."""

from __future__ import annotations

from collections.abc import Sequence

from rota.compare import MethodOutcome
from rota.papers.section import Verdict
from rota.papers.sun2019.cases import Case, unseen_and_late, with_late
from rota.papers.sun2019.readings import AS_HERE, LETTER, Counts, spread
from rota.papers.tables import counted, joined

TRADITIONAL = ("sequential", "parallel", "decomposition")

NOT_RUN = Verdict(
    claim="Advantages over Karapetyan et al. and Palacios-Gasós et al.",
    place="6",
    outcome="cannot be told",
    why="Argued in words alone; neither method is made here.",
)


def rules_verdicts(counts: Counts, faster: bool) -> tuple[Verdict, ...]:
    """Section 4.2: fewer sensors, and faster convergence. faster: whether the run as here converges faster."""
    with_rules, without = counts[AS_HERE]
    letter, letter_without = counts[LETTER]
    saved = sum(letter_without) - sum(letter)
    why = (
        f"By the letter of Algorithm 1 {spread(letter)} with the rules and {spread(letter_without)} without (the paper "
        f"99 and 103); with our readings {spread(with_rules)} and {spread(without)}."
    )
    speed = "With our readings: the cost falls below what the run without rules ends with."
    return (
        Verdict("The heuristic rules save sensors", "4.2", "holds" if saved > 0 else "does not hold", why),
        Verdict(
            "The rules make CCPSO2 converge faster", "4.2", "holds" if faster else "does not hold",
            f"{speed} {'It does' if faster else 'It does not'}; costs without them cannot be set beside the paper's.",
        ),
    )  # fmt: skip


def run_verdicts(case: Case, proving: MethodOutcome, effort: str) -> tuple[Verdict, ...]:
    """Section 5.1: the number of robots, its routes, and what they cover."""
    theirs, bound = len(case.paper.routes), proving.lower_bound_robots or 0
    least = proving.robots if proving.met and proving.robots is not None else None
    if least is not None and least < theirs:
        proof = ", as few as are proved to be needed" if least == bound else f" ({bound} are proved to be needed)"
        optimal = Verdict(
            "The robots are as few as can be (“minimum”, “optimal number”)", "Title, 5.1, 6", "does not hold",
            f"Section 5.1 prints {theirs}; `tours` at effort {effort} takes {least}{proof}.",
        )  # fmt: skip
    else:
        optimal = Verdict(
            "The robots are as few as can be (“minimum”, “optimal number”)", "Title, 5.1, 6", "cannot be told",
            f"Section 5.1 prints {theirs}; no plan with fewer was found, at least {bound} are needed.",
        )  # fmt: skip
    return optimal, coverage_verdict(case, "5.1"), _mended_verdict(case)


def coverage_verdict(case: Case, place: str) -> Verdict:
    """Whether the routes as printed see everything, and in time."""
    met = case.printed.report.verdict == "met"
    return Verdict(
        "The routes cover the area “completely and persistently”", place, "holds" if met else "does not hold",
        f"{case.paper.name}, routes as printed: "
        + ("the check passes them." if met else f"{unseen_and_late(case)}."),
    )  # fmt: skip


def _mended_verdict(case: Case) -> Verdict:
    """The verdict on Table 5: whether repaired routes keep all periods with as many robots."""
    mended, theirs = case.outcomes["mended"], len(case.paper.routes)
    enough = mended.met and mended.robots is not None and mended.robots <= theirs
    return Verdict(
        "Obstacles are avoided and periods kept by so many robots", "5.1, Table 5",
        "holds" if enough else "does not hold",
        f"How a route is led round an obstacle is not told. Ours follow the walls; mended until all is seen in time "
        f"they take {counted(mended.robots or 0, 'robot')} for the {theirs} printed.",
    )  # fmt: skip


def verdicts_of_cases(cases: Sequence[Case]) -> tuple[Verdict, ...]:
    """Section 5.2, and Section 4.1's judgement on traditional methods."""
    theirs, ours = [len(case.paper.routes) for case in cases], [case.segments for case in cases]
    apart = [abs(a - b) for a, b in zip(theirs, ours, strict=True)]
    adapts = Verdict(
        "The method adapts the number of robots to the periods", "5.2, 6",
        "holds" if max(apart) <= 2 else "cannot be told",
        f"Eq. 26 gives {joined([str(n) for n in ours])} where the paper has {joined([str(n) for n in theirs])}: "
        f"{sum(ours)} for {sum(theirs)}, at most {max(apart)} apart.",
    )  # fmt: skip
    kept = [case.paper.name for case in cases if case.late == 0]
    in_time = Verdict(
        "Every route keeps its period, but in Case 6", "5.2, Table 6",
        "holds" if all(case.late == 0 for case in cases[:-1]) else "does not hold",
        f"By Eq. 26 here {with_late(sum(ours), sum(case.late for case in cases))}; "
        f"{'none in ' + joined(kept) if kept else 'some in every case'}. ξ₁ decides, and no ξ₁ gives "
        "all of the paper's counts.",
    )  # fmt: skip
    return adapts, in_time, _case_2(cases), _case_6(cases), _traditional(cases)


def _named(cases: Sequence[Case], name: str) -> Case | None:
    """The case of that name; None where it was not run."""
    return next((case for case in cases if case.paper.name == name), None)


def _fewest(case: Case) -> str:
    """The fewest robots of any method, and which one took them."""
    met = {way: outcome.robots for way, outcome in case.outcomes.items() if outcome.met and outcome.robots is not None}
    if not met:
        return "no method found a plan"
    least = min(met.values())
    return f"{joined([way for way, robots in met.items() if robots == least])} {least}"


def _case_2(cases: Sequence[Case]) -> Verdict:
    """The verdict on Case 2's number of routes."""
    claim = "Case 2: five routes, not six, are the optimal number"
    case = _named(cases, "Case 2")
    if case is None:
        return Verdict(claim, "5.2", "cannot be told", "Not run.")
    met = [outcome.robots for outcome in case.outcomes.values() if outcome.met and outcome.robots is not None]
    fewer = bool(met) and min(met) < len(case.paper.routes)
    return Verdict(
        claim, "5.2", "bettered" if fewer else "holds" if case.segments <= 5 else "cannot be told",
        f"By Eq. 26 here {with_late(case.segments, case.late)}; checked plans: {_fewest(case)} "
        f"(proved: at least {case.lower_bound}).",
    )  # fmt: skip


def _case_6(cases: Sequence[Case]) -> Verdict:
    """The verdict on Case 6's late routes."""
    claim = "Case 6: to let four routes be late is better than a robot more"
    case = _named(cases, "Case 6")
    if case is None:
        return Verdict(claim, "5.2", "cannot be told", "Not run.")
    met = [outcome.robots for outcome in case.outcomes.values() if outcome.met and outcome.robots is not None]
    needless = bool(met) and min(met) <= len(case.paper.routes)
    return Verdict(
        claim, "5.2", "bettered" if needless else "cannot be told",
        f"Eq. 28 does so here as well ({with_late(case.segments, case.late)}), for ξ₁ of a few hundred. But nothing "
        f"need be late: {_fewest(case)}, all periods kept (proved: at least {case.lower_bound}).",
    )  # fmt: skip


def _traditional(cases: Sequence[Case]) -> Verdict:
    """Whether traditional methods, mended like all others, take more robots than the paper prints."""
    theirs = sum(len(case.paper.routes) for case in cases)
    told, beats = [], False
    for way in TRADITIONAL:
        outcomes = [case.outcomes[way] for case in cases]
        robots = [outcome.robots or 0 for outcome in outcomes]
        met = all(outcome.met for outcome in outcomes)
        no_more = met and all(n <= len(case.paper.routes) for n, case in zip(robots, cases, strict=True))
        beats = beats or no_more
        told.append(f"{way} {sum(robots)}" + ("" if met else ", not all met") + (", never more" if no_more else ""))
    return Verdict(
        "Traditional methods cannot cope with obstacles and with zones of different periods", "4.1",
        "does not hold" if beats else "holds",
        f"Ours plan each group of zones with like periods, and are mended like all others. Robots for {theirs}: "
        f"{'; '.join(told)}.",
    )  # fmt: skip
