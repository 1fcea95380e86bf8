"""What is said of bouncing robots that are no ideal ones: clocks that drift, turns that are off, cycles that hold."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rota.plan import Plan
from rota.planners.bounce.inexact_plan import RUNS, kept_with_errors
from rota.planners.bounce.plane_monitoring import PlaneTeam
from rota.planners.bounce.planner_settings import BounceSettings

if TYPE_CHECKING:
    from rota.planner import Report


def clocks_sentence(plan: Plan, report: Report) -> str | None:
    """How far the clocks of robots that bounce may differ, and how long drifting ones take to; None for one robot."""
    margin_s, settings = report.clock_margin_s, BounceSettings.of(plan.mission)
    if margin_s is None:
        return None
    if math.isinf(margin_s):
        return "Clocks may differ by any time: bodies never touch."
    sentence = f"Clocks may differ by {math.floor(1e3 * margin_s) / 1e3:.3g} s before bodies touch"
    if settings.clock_drift == 0:
        return sentence + "."
    drift = f"clocks off by up to {100 * settings.clock_drift:.3g} %"
    if settings.clock_signal_s is not None:
        apart = f"by {settings.clock_margin_s:.3g} s at most, from one signal to the next"
        return f"{sentence}; {drift} do {apart}, {settings.clock_signal_s:g} s later."
    lasts_s = margin_s / (2 * settings.clock_drift)
    return f"{sentence}; {drift} may do so {lasts_s:.3g} s after a common start, without a signal in between."


def errors_sentence(plan: Plan) -> str | None:
    """What simulation leaves of the plan when turns are off; None where the mission names no turning error."""
    if BounceSettings.of(plan.mission).turning_error_deg == 0 or not plan.trajectories:
        return None
    parts = []
    for kept in kept_with_errors(plan):
        share = f"{_percent(kept.inexact.value)} \u00b1 {_percent(kept.inexact.error)} %"
        exact = f"with exact turns {_percent(kept.exact.value)} %"
        if kept.name is None:
            parts.append(f"enter {share} of the cells in the plan's time ({exact})")
        else:
            parts.append(f"have visited {kept.name} within its period {share} of the time ({exact})")
    error = f"{BounceSettings.of(plan.mission).turning_error_deg:g} degrees"
    return (
        f"With turns off by up to {error}, robots that turn at every contact and by no clock "
        + ", ".join(parts)
        + f"; {RUNS:,} simulated runs in the plane, 95 % intervals."
    )


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
        )
    return "Robots follow attracting limit cycles: " + "; ".join(parts) + "."
