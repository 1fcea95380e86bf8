"""The judgement of a recording: what was really covered, by the same intervals as a plan's, from when to when."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rota.check.arrays import Flags, Floats
from rota.check.counting import Names, counts
from rota.check.demands import demands_of
from rota.check.judge import Verdicts, judge_points, judge_visits, too_much_excluded
from rota.check.report import Outcome, Report
from rota.check.revisits import Sights, sights_along
from rota.check.routes import Routes, routes_driven
from rota.check.tiled_ground import findings_by_group
from rota.errors import PlanError
from rota.model.mission import DiscSensor, Mission

FINEST_M = 0.05  # robots know no better where they are


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordedTrack:
    """What one robot drove: straight legs (m, 4) x0, y0, x1, y1 in metres, in times_s (m, 2), one after the other.

    Between two legs it may have been anywhere, and nothing is credited. heights_m: (m,) the lower one of each leg's
    ends.
    """

    robot: str
    legs_m: Floats
    times_s: Floats
    heights_m: Floats


def check_recording(
    mission: Mission,
    tracks: Sequence[RecordedTrack],
    window_s: tuple[float, float],
    *,
    robots: int,
    tolerance_m: float = 0.0,
    finest_m: float = FINEST_M,
) -> Report:
    """The verdict on a recording: "met" only when every window of a period that lies within ``window_s`` had a sight.

    So the time from the window's beginning to the first sight of a place counts as a gap, and so does the time from
    the last one to its end. A demand whose period is longer than the window says nothing, and is told as not judged.
    Motion and bodies are not judged: reports hold noise. robots: how many the plan has. tolerance_m: sensors are
    credited with so much more reach, for places that are told with an error. finest_m: see ``check_plan``.

    Raises PlanError for a window that does not last.
    """
    from_s, to_s = window_s
    if not to_s > from_s:
        raise PlanError(f"the recording lasts from {from_s:.6g} s to {to_s:.6g} s: there is nothing to judge")
    demands = demands_of(mission)

    @functools.cache
    def sights_by(names: Names) -> Sights:
        """What the robots see that count for demands that name these sensors."""
        own = [track for track in tracks if counts(mission.fleet.robot(track.robot).sensor, names)]
        return sights_along(*_drive(mission, own, tolerance_m), mission, mission.area.bounds, window_s)

    findings = findings_by_group(mission, demands, sights_by, finest_m)
    excluded = too_much_excluded(mission, demands, findings)
    verdicts = Verdicts()
    not_judged = ["batteries: a recording is judged by what was seen"] if mission.chargers else []
    for found, demand in zip(findings, demands, strict=True):
        number = len(verdicts.demands)
        if demand.period_s > to_s - from_s:
            lasted = f"longer than what was recorded, {to_s - from_s:.1f} s"
            not_judged.append(f"{demand.name}: its period, {demand.period_s:g} s, is {lasted}")
        elif demand.demand == "visit":
            judge_visits(verdicts, number, demand, sights_by(demand.sensors), mission)
        else:
            judge_points(verdicts, number, demand, found, bool(excluded))
    outcomes = {demand.outcome for demand in verdicts.demands}
    violated = "violated" in outcomes or excluded
    verdict: Outcome = "violated" if violated else "met" if outcomes == {"met"} else "not proven"
    first_s = max(verdicts.firsts_s, default=math.inf)
    return Report(
        verdict=verdict,
        robots=robots,
        lower_bound_robots=None,
        cells_entered=None,
        not_judged=tuple(not_judged),
        demands=tuple(verdicts.demands),
        violations=tuple(verdicts.violations + excluded),
        clock_margin_s=None,
        first_coverage_s=first_s if math.isfinite(first_s) else None,
        holds_from_s=from_s,
        **verdicts.places(),
        run_end=None,
    )


def _drive(
    mission: Mission, tracks: Sequence[RecordedTrack], tolerance_m: float
) -> tuple[Routes, tuple[Floats, Flags]]:
    """All legs as driven once, and what the robots of each see with.

    A sensor whose reach depends on the height has one entry for each height, as a robot of its own.
    """
    legs, times, owners = [np.empty((0, 4))], [np.empty((0, 2))], [np.empty(0, np.int64)]
    reaches: list[float] = []
    squares: list[bool] = []
    for track in tracks:
        sensor = mission.fleet.robot(track.robot).sensor
        if isinstance(sensor, DiscSensor):
            reach_m = np.array([sensor.radius_at_m(float(height)) for height in track.heights_m])
        else:
            reach_m = np.full(len(track.legs_m), sensor.side_m / 2)
        for reach in np.unique(reach_m):
            own = reach_m == reach
            legs.append(track.legs_m[own])
            times.append(track.times_s[own])
            owners.append(np.full(np.count_nonzero(own), len(reaches), np.int64))
            reaches.append(float(reach) + tolerance_m)
            squares.append(not isinstance(sensor, DiscSensor))
    legs_m = np.vstack(legs)
    routes = routes_driven(legs_m, np.vstack(times), np.zeros(len(legs_m)), np.concatenate(owners), len(reaches))
    return routes, (np.array(reaches, np.float64), np.array(squares, np.bool_))
