"""What `rota check --executed FORMAT` judges: the plan as a format drives it, and how far that is from the plan."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from rota.command.without_mass import without_mass
from rota.errors import RotaError

if TYPE_CHECKING:
    from rota.check import Report, Violation
    from rota.model.plan import Floats, Plan, Trajectory

SAME_S = 1e-6  # of a round, that is not worth a word
HOUR_S = 3600.0


@dataclass(frozen=True, kw_only=True)
class AsPlanned:
    """A plan as it is, for the check, and what is said of its report."""

    plan: Plan

    def text(self, report: Report) -> str:
        """The report as plain text."""
        from rota.check import report_table

        return report_table(report)

    def to_json(self, report: Report) -> dict[str, Any]:
        """The report as JSON values."""
        from rota.check import report_to_json

        return report_to_json(report)

    def remarks(self, planned: Plan, report: Report) -> list[str]:
        """What people should know beside it: of whom "met" is said."""
        told = without_mass(planned) if report.verdict == "met" and report.demands else None
        return [told] if told is not None else []


@dataclass(frozen=True, kw_only=True)
class Executed(AsPlanned):
    """A plan as a format drives it, and a sentence on what differs from the plan.

    off_m: how far places are off the plan's routes. drifts: whether rounds, or single flights where it
    has_flights, take another time than planned.
    """

    told: str
    off_m: float
    drifts: bool
    has_flights: bool = False

    def text(self, report: Report) -> str:
        """The report as plain text, with the worst violation of each kind."""
        return table_of_worst(report)

    def remarks(self, planned: Plan, report: Report) -> list[str]:
        """What a violated verdict comes of; of a met one the same as of a plan."""
        return [self._comes_of(planned)] if report.verdict == "violated" else super().remarks(planned, report)

    def _comes_of(self, planned: Plan) -> str:
        """What a violated verdict comes of: a sentence, which begins with what the check says of the plan itself."""
        from rota.check import check_plan

        verdict = check_plan(planned).verdict
        if verdict != "met":
            return f"the plan itself is {verdict}, too"
        rounded = "places are rounded by up to {} m"
        what = "places are up to {} m off the curves past corners" if planned.heeds_motion else rounded
        causes = [what.format(f"{self.off_m:.2g}")] if self.off_m > 0 else []
        causes += (
            [f"{'flights' if self.has_flights else 'rounds'} take another time than planned"] if self.drifts else []
        )
        causes += ["flights start at whole milliseconds"] if self.has_flights else []
        return f"the plan itself is met; all violations come of what the format holds: {' and '.join(causes)}"


def executed_plan(plan: Plan, name: str) -> Executed:
    """The plan as a format drives it. Raises RotaError for a format whose files are judged when they are written."""
    from rota.exports import FORMATS
    from rota.files.executed.plan_as_driven import DRIVEN, plan_as_driven
    from rota.routes.flights import recharges

    if name == "create2-reactive":
        raise RotaError(f"--executed: {name!r} is not allowed: such programs drive no plan")
    if name not in DRIVEN:
        raise RotaError(f"--executed: {name!r} is not allowed: such files are judged as driven when they are written")
    if recharges(plan) and FORMATS[name].charging == "flights":
        return _executed_flights(plan, name)
    made = plan_as_driven(plan, name)
    off_m = max((_off_m(*pair) for pair in zip(plan, made, strict=True)), default=0.0)
    told = f"as {name} drives it, places are up to {off_m:.2g} m off the plan's routes"
    moving = [pair for pair in zip(plan, made, strict=True) if pair[0].loop_duration_s > 0]
    late_s = [new.loop_duration_s - old.loop_duration_s for old, new in moving]
    drifts = max(map(abs, late_s), default=0.0) >= SAME_S
    if not drifts:
        told += ", and rounds take as long as planned"
    else:
        first, last = int(np.argmin(late_s)), int(np.argmax(late_s))
        shares = [abs(late) / old.loop_duration_s for late, (old, _) in zip(late_s, moving, strict=True)]
        told += (
            f", and rounds differ from the plan's by {late_s[first]:+.2g} s ({moving[first][0].robot}) to"
            f" {late_s[last]:+.2g} s ({moving[last][0].robot}): up to {max(shares) * HOUR_S:.2g} s an hour"
        )
    return Executed(plan=made, told=told, off_m=off_m, drifts=drifts)


def _executed_flights(plan: Plan, name: str) -> Executed:
    """The plan as a format's single flights drive it, each started when the table of flights says."""
    from rota.files.executed.plan_as_driven import flights_as_driven

    made, flown = flights_as_driven(plan, name)
    off_m = max((_off_m(*pair) for pair in zip(plan, made, strict=True)), default=0.0)
    told = f"as {name} flies its single flights, places are up to {off_m:.2g} m off the plan's routes"
    drifts = False
    if flown:
        first, last = (pick(flown, key=lambda one: one.longer_s) for pick in (min, max))
        drifts = max(abs(first.longer_s), abs(last.longer_s)) >= SAME_S
        told += (
            f"; flights last {first.longer_s:+.2g} s ({first.name}) to {last.longer_s:+.2g} s ({last.name}) longer than"
            " planned, and each starts when flights.csv says"
        )
    told += "; no file says how full batteries are: they are followed as the mission has them"
    return Executed(plan=made, told=told, off_m=off_m, drifts=drifts, has_flights=True)


def require_no_flights(plan: Plan, option: str, why: str) -> None:
    """Raise RotaError for an option that a plan whose robots charge does not take, and why."""
    from rota.routes.flights import recharges

    if recharges(plan):
        raise RotaError(f"{option}: not allowed for a plan whose robots charge: {why}")


def table_of_worst(report: Report) -> str:
    """The report as plain text; of each kind of violation only the worst has a line, which says how many more are.

    Each robot in each round that is unrolled may have the same ones.
    """
    from rota.check import report_table

    by_kind: dict[str, list[Violation]] = {}
    for each in report.violations:
        by_kind.setdefault(each.kind, []).append(each)
    lines = [report_table(replace(report, violations=()))]
    for group in by_kind.values():
        worst = max(group, key=lambda each: abs(each.value - each.limit))
        more = f" (and {len(group) - 1} more of this kind, none worse)" if group[1:] else ""
        lines.append(f"violation: {worst.text()}{more}")
    return "\n".join(lines)


def _off_m(planned: Trajectory, made: Trajectory) -> float:
    """The greatest distance of a place that is driven to from the planned route."""
    places = shapely.points(made.positions_m[:, :2])
    route = planned.positions_m[:, :2]
    line = shapely.linestrings(route) if len(route) > 1 else shapely.points(route[0])
    return float(shapely.distance(places, line).max())


def in_phase_every(plan: Plan, made: Plan, every_s: float) -> Plan:
    """The plan as driven by robots that are brought into phase anew every ``every_s`` seconds, or less often.

    Loops that share a period in ``plan`` are driven until so much time has passed and all of them are to begin
    together; then each robot waits at the place where its loop begins, until the slowest is there. Raises RotaError for
    a time that is not more than 0.
    """
    from rota.check.routes import commensurable_classes

    require_no_flights(plan, "--in-phase-every", "each of its flights starts at a time of its own")
    if not 0 < every_s < math.inf:
        raise RotaError(f"--in-phase-every: {every_s:g} is not allowed; seconds are needed, more than 0")
    planned_s = [trajectory.loop_duration_s for trajectory in plan]
    classes, parts, units_s = commensurable_classes(planned_s)
    again = list(made.trajectories)
    for number in set(classes.tolist()):
        members = [k for k in np.flatnonzero(classes == number).tolist() if planned_s[k] > 0]
        if not members:
            continue
        common = math.lcm(*(int(parts[k]) for k in members))
        times = max(1, math.floor(every_s / (common * float(units_s[number]))))
        rounds = {k: times * common // int(parts[k]) for k in members}
        until_s = max(rounds[k] * again[k].loop_duration_s for k in members)
        for k in members:
            again[k] = _rounds_then_wait(again[k], rounds[k], until_s)
    return replace(made, trajectories=tuple(again))


def _rounds_then_wait(trajectory: Trajectory, rounds: int, until_s: float) -> Trajectory:
    """The trajectory whose loop is so many rounds of its own, then a wait until the loop has taken ``until_s``."""
    k, round_s = trajectory.loop_index, trajectory.loop_duration_s
    times_s, places_m = trajectory.times_s, trajectory.positions_m
    begun: list[Floats] = [times_s[k + 1 :] + number * round_s for number in range(rounds)]
    made_s = np.concatenate([times_s[: k + 1], *begun])
    made_m = np.concatenate([places_m[: k + 1], *([places_m[k + 1 :]] * rounds)])
    end_s = trajectory.loop_start_s + until_s
    accelerations = trajectory.accelerations_m_s2
    if accelerations is not None:
        accelerations = np.concatenate([accelerations[:k], *([accelerations[k:]] * rounds)])
    if end_s > made_s[-1]:
        made_s, made_m = np.append(made_s, end_s), np.concatenate([made_m, made_m[-1:]])
        accelerations = None if accelerations is None else np.append(accelerations, 0.0)
    return replace(trajectory, times_s=made_s, positions_m=made_m, headings_rad=None, accelerations_m_s2=accelerations)
