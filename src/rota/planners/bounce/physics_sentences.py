"""What is said of bouncing robots that are no ideal ones: clocks that drift, turns that are off, cycles that hold."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rota.model.plan import Plan
from rota.planners.bounce.inexact_plan import SHARES, Inexact, covering, with_errors
from rota.planners.bounce.plane_monitoring import PlaneTeam
from rota.planners.bounce.planner_settings import BounceSettings

SMALL_MARGIN_S = 0.5  # of clocks, below which people are warned
USUAL_DRIFT = 0.005  # of a small board's ceramic resonator

if TYPE_CHECKING:
    from rota.planning.planner import Report


def clocks_sentence(plan: Plan, report: Report) -> str | None:
    """How far the clocks of robots that bounce may differ, and how long drifting ones take to; None for one robot."""
    margin_s, settings = report.clock_margin_s, BounceSettings.of(plan.mission)
    if margin_s is None:
        return None
    if math.isinf(margin_s):
        return "Clocks may differ by any time: bodies never touch."
    sentence = f"Clocks may differ by {math.floor(1e3 * margin_s) / 1e3:.3g} s before bodies touch"
    if settings.clock_drift == 0:
        return f"{sentence}.{_alarm(margin_s, settings.task == 'monitor')}"
    drift = f"clocks off by up to {100 * settings.clock_drift:.3g} %"
    if settings.clock_signal_s is not None:
        apart = f"by {settings.clock_margin_s:.3g} s at most, from one signal to the next"
        return f"{sentence}; {drift} do {apart}, {settings.clock_signal_s:g} s later."
    lasts_s = margin_s / (2 * settings.clock_drift)
    return f"{sentence}; {drift} may do so {lasts_s:.3g} s after a common start, without a signal in between."


def _alarm(margin_s: float, monitors: bool) -> str:
    """What so small a margin means for clocks as cheap boards have them; nothing where it is not small."""
    if margin_s >= SMALL_MARGIN_S:
        return ""
    lasts_s = margin_s / (2 * USUAL_DRIFT)
    return (
        f" Careful: that is next to nothing. Two clocks that are {100 * USUAL_DRIFT:g} % off, one fast and one slow,"
        f" use it up in {lasts_s:.3g} s."
        + " bounce.clock_drift and bounce.clock_signal_s choose a team with a margin."
        * monitors
    )


def errors_sentence(plan: Plan) -> str | None:
    """What simulation leaves of the plan when turns are off, and when bodies first touch; None without robots."""
    if not plan.trajectories:
        return None
    parts, inexact = [], with_errors(plan)
    for kept in inexact.kept:
        share = f"{_percent(kept.inexact.value)} \u00b1 {_percent(kept.inexact.error)} %"
        exact = f"with exact turns {_percent(kept.exact.value)} %"
        if kept.name is None:
            parts.append(f"enter {share} of the cells in the plan's time ({exact})")
        else:
            parts.append(f"have visited {kept.name} within its period {share} of the time ({exact})")
    error = f"{inexact.error_deg:g} degree" + "s" * (inexact.error_deg != 1)
    example = "" if BounceSettings.of(plan.mission).turning_error_deg else " (the mission states no turning_error_deg)"
    return (
        f"With turns off by up to {error}{example}, robots that turn at every contact and by no clock "
        + ", ".join(parts)
        + ("" if inexact.met_s is None else f"; {_contact(inexact)}")
        + f"; {inexact.runs:,} simulated runs in the plane, 95 % intervals."
    )


def covering_sentence(plan: Plan) -> str:
    """By when robots that turn at every contact, and know no plan, have entered all cells."""
    found = covering(plan)
    late = f"later than {found.lasting_s:,.0f}"
    told = " / ".join(late if math.isinf(time_s) else f"{time_s:,.0f}" for time_s in found.times_s)
    return (
        f"all {found.cells} cells entered after {told} s in {' / '.join(f'{100 * share:.0f}' for share in SHARES)} % of"
        f" {found.runs} simulated runs, turns off by up to {found.error_deg:g} degrees"
    )


def _contact(inexact: Inexact) -> str:
    """When bodies first touch in 10, 50 and 90 % of the runs."""
    assert inexact.met_s is not None
    late = f"later than {inexact.lasting_s:,.0f}"
    if math.isinf(inexact.met_s[0]):
        return f"in less than {SHARES[0]:.0%} of the runs their bodies touch within {inexact.lasting_s:,.0f} s"
    told = " / ".join(late if math.isinf(met_s) else f"{met_s:,.0f}" for met_s in inexact.met_s)
    return f"their bodies first touch after {told} s ({' / '.join(f'{100 * share:.0f}' for share in SHARES)} % of runs)"


def _percent(share: float) -> str:
    """A share as a percentage with one decimal."""
    return f"{100 * share:.1f}"


def cycles_sentence(team: PlaneTeam) -> str:
    """What limit cycles robots without a grid follow, and how these hold them."""
    parts = []
    for t in dict.fromkeys(team.on):
        track, robots = team.tracks[t], team.on.count(t)
        fades = abs(track.cycle.multiplier)
        left = "nothing" if fades < 5e-4 else f"{fades:.3f}"
        parts.append(
            f"{robots} on a cycle of {track.cycle.period} contacts, {track.round_s:.1f} s, to which"
            f" {track.cycle.share:.0%} of random starts come and which leaves {left} of a small displacement per round"
            + " but leaves contacts along a wall, where rounding alone may throw a robot off"
            * track.cycle.grazes
        )
    return "Robots follow attracting limit cycles: " + "; ".join(parts) + "."
