"""What became of each claim of the paper: a verdict from the runs, and why."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

from rota.check import check_plan
from rota.errors import PlanError
from rota.files.create2_legs import drives_of
from rota.mission import Mission
from rota.papers.alam2020 import paper
from rota.papers.section import Verdict
from rota.papers.tables import joined
from rota.plan import Plan
from rota.planners.bounce.bounce_map import joint_states
from rota.planners.bounce.cells import make_cells
from rota.planners.bounce.inexact_plan import kept_with_errors
from rota.planners.bounce.inexact_turns import Estimate
from rota.planners.bounce.planner_settings import BounceSettings

WATCH_ERROR_DEG = 1.0


def figure_6_verdicts(
    complete: Mapping[str, int], starts: int, few: Sequence[int], exported: Verdict
) -> tuple[Verdict, ...]:
    """Section 5.1: a joint trajectory that covers, its one contact, and the robots that drove it."""
    holds = complete["as_printed"] == starts
    return (
        Verdict(
            "Algorithm 1 finds a joint trajectory that covers the laboratory", "5.1", _holds(holds),
            f"From {complete['as_printed']} of {starts} starts as printed, from {complete['improved']} improved.",
        ),
        Verdict(
            f"It has {paper.CONTACTS_FIGURE_6} contact of both robots", "5.1, Figure 6", "cannot be told",
            "The map is not published. On ours runs with no more than one step of contact are "
            f"{few[0]} of {starts} as printed, {few[1]} improved.",
        ),
        exported,
    )  # fmt: skip


def fewer_steps_verdict(means: Sequence[float], others: Sequence[Sequence[float]]) -> Verdict:
    """Section 5.1, Figure 7: more robots take fewer steps."""
    falls = all(after < before for before, after in itertools.pairwise(means))
    elsewhere = sum(all(after < before for before, after in itertools.pairwise(layout)) for layout in others)
    return Verdict(
        "The number of steps decreases with the number of robots", "5.1, Figure 7", _holds(falls),
        f"On our layout the mean {'falls' if falls else 'does not fall'} with every robot; it falls on {elsewhere} of "
        f"{len(others)} random layouts.",
    )  # fmt: skip


def more_robots_verdict(means: Sequence[float], others: Sequence[Sequence[float]]) -> Verdict:
    """Section 5.1, Figure 8: more robots need not take fewer steps, five take more than four."""
    last_rises = means[-1] > means[-2]
    five = sum(layout[-1] > layout[-2] for layout in others)
    some = sum(any(after > before for before, after in itertools.pairwise(layout)) for layout in others)
    return Verdict(
        "More robots need not take fewer steps: five take more than four", "5.1, Figure 8",
        "holds" if five + last_rises > 0 else "cannot be told",
        f"Not on every map: five take more than four on {five} of {len(others)} random layouts and "
        f"{'also' if last_rises else 'not'} on ours; on {some} some team takes more than a smaller one. Runs are cut, "
        "so that means of the hardest layouts are too small.",
    )  # fmt: skip


def large_room_verdict(complete: Mapping[str, int], starts: int) -> Verdict:
    """Section 5.1, Figure 9: ten robots cover 98 % of a larger room."""
    ok = complete["as_printed"] == starts
    return Verdict(
        f"Ten robots cover {paper.COVERED_FIGURE_9:.0%} of a larger room", "5.1, Figure 9",
        "bettered" if ok else "holds",
        f"All cells from {complete['as_printed']} of {starts} starts as printed, {complete['improved']} improved.",
    )  # fmt: skip


def groups_verdict(figure: int, told: str, spread: Sequence[int]) -> Verdict:
    """Section 5.2: the number of periodic groups."""
    angle_deg, said = paper.GROUPS[figure]
    return Verdict(
        f"r = {said} periodic groups of two robots by {angle_deg:g}°", f"5.2, Figure {figure}", "cannot be told",
        f"Map and regions are not published, and whether robots are told apart. {told}; with random regions "
        f"{min(spread):,} to {max(spread):,}.",
    )  # fmt: skip


def apart_verdict(plan: Plan, figure: int) -> Verdict:
    """Section 5.2: robots on overlapping ways never collide; what clocks and turns may do."""
    report = check_plan(plan)
    margin_s = report.clock_margin_s
    assert margin_s is not None
    asked = replace(BounceSettings.of(plan.mission), turning_error_deg=WATCH_ERROR_DEG)
    kept = kept_with_errors(replace(plan, mission=replace(plan.mission, planning=asked)))
    watched = joined([
        f"{share.name} {_percent(share.inexact)} (exact turns in the plane {100 * share.exact.value:.0f}%)"
        for share in kept
    ])  # fmt: skip
    clocks = "by any time" if math.isinf(margin_s) else f"by {margin_s:.2g} s"
    return Verdict(
        "Robots on overlapping ways never collide and watch for ever, without a word between them",
        f"5.2, Figure {figure}", _holds(not report.violations),
        f"For the group shown and with exact clocks and turns. Clocks may differ {clocks} before bodies touch, and "
        f"with turns off by up to {WATCH_ERROR_DEG:g}° robots that only react keep the period of {watched} of "
        "the time.",
    )  # fmt: skip


def driven_verdict(plans: Mapping[str, Plan], place: str) -> Verdict:
    """The physical experiments: how many of our plans a Create 2 could drive, and what that asks."""
    slowing, legs, bumps = [], 0, 0
    for plan in plans.values():
        try:
            drives = drives_of(plan)
        except PlanError:
            continue
        slowing.append(drives[0].slowing)
        legs += sum(len(drive.legs) for drive in drives)
        bumps += sum(leg.bumps for drive in drives for leg in drive.legs)
    extremes = dict.fromkeys(f"{factor:.2f}" for factor in (min(slowing, default=1.0), max(slowing, default=1.0)))
    slower = " to ".join(extremes)
    return Verdict(
        "Two iRobot Create 2, each with an Arduino Uno and one program, drive the trajectory", place, "cannot be told",
        f"Three snapshots and a video stand for it; no times or distances are printed. Sketches can be exported of "
        f"{len(slowing)} of {len(plans)} plans of ours, on clocks {slower} times slower than planned; "
        f"{bumps / max(legs, 1):.0%} of their legs end in a contact. They have been driven in a simulator "
        "of the chip (`create2-sketch` in docs/benchmarks.md), never on a robot.",
    )  # fmt: skip


def angles_verdict(mean: Mapping[tuple[float, str], Estimate], exact: str, inexact: str) -> Verdict:
    """Section 6: 135 and 45 degrees cover better than 90 and 180."""

    def better(told: str) -> bool:
        return min(mean[135.0, told].value, mean[45.0, told].value) > max(
            mean[90.0, told].value, mean[180.0, told].value
        )

    order = {
        told: " / ".join(f"{100 * mean[angle, told].value:.0f}" for angle in (135.0, 45.0, 90.0, 180.0))
        for told in (exact, inexact)
    }
    return Verdict(
        "135° and 45° provide better coverage than 90° and 180°", "6", _holds(better(exact)),
        f"Mean chance of a cell to be seen by one robot by 135° / 45° / 90° / 180°: {order[exact]} % with exact turns, "
        f"{order[inexact]} % with turns {inexact}" + ("." if better(inexact) else ", where the order is another."),
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


def _holds(ok: bool) -> Literal["holds", "does not hold"]:
    """The outcome of a claim of which a run decides."""
    return "holds" if ok else "does not hold"


def _percent(estimate: Estimate) -> str:
    """A share with its error as text, in whole percent."""
    return f"{100 * estimate.value:.0f} ± {max(100 * estimate.error, 0.5):.0f}%"
