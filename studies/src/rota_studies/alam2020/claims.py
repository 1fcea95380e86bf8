"""What became of each claim of the paper: a verdict from the runs, and why."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from rota.model.mission import Mission
from rota.planners.bounce.bounce_map import joint_states
from rota.planners.bounce.cells import make_cells
from rota.planners.bounce.inexact_turns import Estimate
from rota.planners.bounce.planner_settings import BounceMethod
from rota_studies.alam2020 import paper
from rota_studies.alam2020.inexact import Seen
from rota_studies.alam2020.runs import CoverRuns, Driven
from rota_studies.alam2020.watched import WATCH_ERROR_DEG, ShownGroup
from rota_studies.tables import joined, plus_minus
from rota_studies.verdict import (
    LEAST_SEEDS,
    LEVEL,
    Judged,
    Outcome,
    Verdict,
    always,
    compared,
    sign_test,
)

Floats = NDArray[np.float64]


def figure_6_verdicts(complete: Mapping[str, Sequence[bool]], few: Sequence[int]) -> tuple[Verdict, ...]:
    """Section 5.1: a joint trajectory that covers, and its one contact.

    complete: by method whether each start leads to full coverage. few: runs with no more contacts, as printed and
    improved.
    """
    found, starts = always(complete["as_printed"]), len(complete["as_printed"])
    return (
        Verdict(
            "Algorithm 1 finds a joint trajectory that covers the laboratory", "5.1", found.outcome,
            f"As printed in {found.told} from random starts, improved in {sum(complete['improved'])}.",
        ),
        Verdict(
            f"It has {paper.CONTACTS_FIGURE_6} contact of both robots", "5.1, Figure 6", "cannot be told",
            f"The map is not published. On ours runs with no more than one step of contact are {few[0]} of {starts} as "
            f"printed, {few[1]} improved.",
        ),
    )  # fmt: skip


def floor_verdict(passed: Mapping[str, Floats]) -> Verdict:
    """Section 2: robots cover the boundary. passed: by method, the share of the ground that bodies pass over."""
    told = joined([f"{plus_minus(100 * shares, '.0f')} % {method}" for method, shares in passed.items()])
    return Verdict(
        "Robots cover the boundary of the area", "2", "cannot be told",
        "In cells: runs end when every cell is entered, those at walls too. On the ground they do not: when a centre "
        f"has been in every cell, bodies have passed over {told} of the floor (Figure 6), since a round body reaches "
        "no corner and leaves strips between lanes. Which of both is meant is not told.",
    )  # fmt: skip


def fewer_steps_verdict(teams: Sequence[CoverRuns], layouts: Sequence[Sequence[CoverRuns]]) -> Verdict:
    """Section 5.1, Figure 7: more robots take fewer steps. teams: on our layout, by their size; layouts: on others."""
    pairs = [compared(fewer.steps - more.steps, ours=True, form=",.0f") for fewer, more in itertools.pairwise(teams)]
    outcomes = {one.outcome for one in pairs}
    outcome: Outcome = "holds" if outcomes == {"holds"} else "cannot be told"
    told = "; ".join(f"{n} to {n + 1} robots {one.told}" for n, one in zip(paper.TEAMS, pairs, strict=False))
    falls = sum(all(a.steps.mean() > b.steps.mean() for a, b in itertools.pairwise(one)) for one in layouts)
    return Verdict(
        "The number of steps decreases with the number of robots", "5.1, Figure 7",
        "not reproduced" if "not reproduced" in outcomes else outcome,
        f"Steps saved on our layout, {told}. The mean falls with every robot on {falls} of {len(layouts)} random "
        "layouts.",
    )  # fmt: skip


def more_robots_verdict(teams: Sequence[CoverRuns], layouts: Sequence[Sequence[CoverRuns]]) -> Verdict:
    """Section 5.1, Figure 8: more robots need not take fewer steps, five take more than four.

    A claim of one map, so that one of ours would do, if chance alone would not give as many.
    """
    maps_tried = [teams, *layouts]
    gains = [five.steps - four.steps for *_, four, five in maps_tried]
    strict = LEVEL / len(gains)  # so many maps are looked at
    p = [sign_test(int((gain > 0).sum()), int((gain < 0).sum())) for gain in gains]
    more = sum(chance <= strict and gain.mean() > 0 for chance, gain in zip(p, gains, strict=True))
    fewer = sum(chance <= strict and gain.mean() < 0 for chance, gain in zip(p, gains, strict=True))
    worst = max(gains, key=lambda gain: float(gain.mean()))
    error = float(worst.std(ddof=1)) / len(worst) ** 0.5 if len(worst) > 1 else math.inf
    return Verdict(
        "More robots need not take fewer steps: five take more than four", "5.1, Figure 8",
        "holds" if more and len(teams[0].seeds) >= LEAST_SEEDS else "cannot be told",
        f"Of {len(gains)} layouts, {len(teams[0].seeds)} starts each: five take more on {more}, fewer on {fewer}, and "
        f"on the others it cannot be told (sign test, p ≤ {LEVEL:g} over the number of layouts). Where five take most "
        f"beside four, it is {worst.mean():+,.0f} ± {error:,.0f} steps (mean ± standard error). Runs are cut, so that "
        "means of the hardest layouts are too small. The paper's layout is not published.",
    )  # fmt: skip


def reasons_verdict(teams: Sequence[CoverRuns], layouts: Sequence[Sequence[CoverRuns]]) -> Verdict:
    """Section 5.1: why five may take more steps than four: collisions, and an intricate environment."""
    four, five = teams[-2], teams[-1]
    often = compared(100 * (five.contacts / five.steps - four.contacts / four.steps), unit=" points")
    cut = [[float(1 - one.complete.mean()) for one in each[-2:]] for each in layouts]
    fewer = sum(with_five <= with_four for with_four, with_five in cut)
    return Verdict(
        "That is due to collisions and to how intricate the environment is", "5.1, Figure 8", "cannot be told",
        "There is nothing to explain here, since five take more than four on no layout for certain. Collisions do "
        f"grow: the share of steps with contacts by {often.told}, from four to five on our layout. And an intricate "
        f"layout does not make the fifth robot a burden: on {fewer} of {len(layouts)} random ones five have no more "
        "runs cut than four.",
    )  # fmt: skip


def large_room_verdict(by_method: Mapping[BounceMethod, CoverRuns]) -> Verdict:
    """Section 5.1, Figure 9: ten robots cover 98 % of a larger room."""
    printed = by_method["as_printed"]
    found = always((printed.until >= 0).tolist())
    return Verdict(
        f"Ten robots cover {paper.COVERED_FIGURE_9:.0%} of a larger room", "5.1, Figure 9", found.outcome,
        f"As printed in {found.told}. They go on to all cells in {printed.complete.sum()} of {len(printed.seeds)}, as "
        f"improved ones do in {by_method['improved'].complete.sum()}: that the paper's stop at "
        f"{paper.COVERED_FIGURE_9:.0%} is a matter of its map.",
    )  # fmt: skip


def groups_verdict(figure: int, told: str, spread: Sequence[int]) -> Verdict:
    """Section 5.2: the number of periodic groups."""
    angle_deg, said = paper.GROUPS[figure]
    return Verdict(
        f"r = {said} periodic groups of two robots by {angle_deg:g}°", f"5.2, Figure {figure}", "cannot be told",
        f"Map and regions are not published, and whether robots are told apart. {told}; with random regions "
        f"{min(spread):,} to {max(spread):,}.",
    )  # fmt: skip


def apart_verdict(shown: ShownGroup, figure: int) -> Verdict:
    """Section 5.2: robots on overlapping ways never collide; what clocks and turns may do."""
    watched = joined([
        f"{share.name} {_percent(share.inexact)} (exact turns in the plane {100 * share.exact.value:.0f}%)"
        for share in shown.kept
    ])  # fmt: skip
    clocks = "by any time" if math.isinf(shown.plan.clocks_s) else f"by {shown.plan.clocks_s:.2g} s"
    return Verdict(
        "Robots on overlapping ways never collide and watch for ever, without a word between them",
        f"5.2, Figure {figure}", "does not hold" if shown.plan.violations else "holds",
        "Proved by the check for the group shown, with exact clocks and turns; chance has no part in it. Clocks may "
        f"differ {clocks} before bodies touch, and with turns off by up to {WATCH_ERROR_DEG:g}° robots that only react "
        f"keep the period of {watched} of the time.",
    )  # fmt: skip


def driven_verdict(drives: Sequence[Driven | None], place: str) -> Verdict:
    """The physical experiments: how many of our plans a Create 2 could drive, and what that asks."""
    driven = [one for one in drives if one is not None]
    slowing, legs = [one.slowing for one in driven] or [1.0], sum(one.legs for one in driven)
    slower = " to ".join(dict.fromkeys(f"{factor:.2f}" for factor in (min(slowing), max(slowing))))
    return Verdict(
        "Two iRobot Create 2, each with an Arduino Uno and one program, drive the trajectory", place, "cannot be told",
        "Three snapshots and a video stand for it; no times or distances are printed. Sketches can be exported of "
        f"{len(driven)} of {len(drives)} plans of ours, on clocks {slower} times slower than planned; "
        f"{sum(one.bumps for one in driven) / max(legs, 1):.0%} of their legs end in a contact. They have been driven "
        "in a simulator of the chip (`create2-sketch` in docs/benchmarks.md), never on a robot.",
    )  # fmt: skip


def angles_verdict(seen: Mapping[tuple[float, str], Seen], exact: str, inexact: str) -> Verdict:
    """Section 6: 135 and 45 degrees cover better than 90 and 180, by batches of runs from the same starts."""

    def better(told: str) -> Judged:
        ahead = np.minimum(*(seen[angle, told].batches for angle in (135.0, 45.0)))
        behind = np.maximum(*(seen[angle, told].batches for angle in (90.0, 180.0)))
        return compared(100 * (ahead - behind), unit=" points")

    order = {
        told: " / ".join(f"{100 * seen[angle, told].mean.value:.0f}" for angle in (135.0, 45.0, 90.0, 180.0))
        for told in (exact, inexact)
    }
    judged = {told: better(told) for told in (exact, inexact)}
    return Verdict(
        "135° and 45° provide better coverage than 90° and 180°", "6", judged[exact].outcome,
        f"Mean chance of a cell to be seen by one robot by 135° / 45° / 90° / 180°: {order[exact]} % with exact turns, "
        f"{order[inexact]} % with turns {inexact}. The worse of the first two beside the better of the others, by "
        f"batches of runs: {judged[exact].told}; with turns {inexact} {judged[inexact].told}.",
    )  # fmt: skip


def standing_verdicts(two_robots: Mission) -> tuple[Verdict, ...]:
    """Claims that no figure is evidence for: of time, and of speed. two_robots: the mission of Figure 11."""
    states = make_cells(two_robots).states
    return (
        Verdict(
            "Algorithm 1 takes O(LW), W the cells of its joint trajectory", "4.1", "holds",
            "It follows one successor after the other, and every neighbour it tries costs one such run; the joint map "
            "is never made.",
        ),
        Verdict(
            "Algorithm 2 takes O(N), N all joint cells: linear", "4.2, 6", "holds",
            "Each joint cell is mapped once, here too. But N is the states of one robot to the power of the number of "
            f"robots: on the map of Figure 11 {states:,}, {joint_states(states, 2):,} and {joint_states(states, 3):,} "
            "for one, two and three. Products of single limit cycles give the same groups without it.",
        ),
        Verdict(
            "Robots keep one speed and never stop", "2.2, 3.1", "does not hold",
            "Not on a grid whose steps are common to all: a diagonal move is √2 as long as a straight one, and who "
            "turns stands. Here a step lasts as long as the robot that needs longest; the others drive as much slower.",
        ),
        Verdict(
            "Bouncing angles can be turned reliably by such robots", "3.1", "cannot be told",
            "No error is printed. What an error does is Figure 12 here.",
        ),
    )  # fmt: skip


def _percent(estimate: Estimate) -> str:
    """A share with its error as text, in whole percent."""
    return f"{100 * estimate.value:.0f} ± {max(100 * estimate.error, 0.5):.0f}%"
