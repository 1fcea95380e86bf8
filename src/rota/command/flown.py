"""What `rota check --executed FORMAT --vehicle NAME` says: rounds as flown, what lapses and what would help."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from rota.command.arguments import wind_given
from rota.command.executed import in_phase_every, require_no_flights, table_of_worst
from rota.command.without_mass import WORTH_SAYING
from rota.compiled.compiled_cache import mention_compiling
from rota.model.columns import columns

if TYPE_CHECKING:
    from rota.check import Report
    from rota.files.executed.plan_as_flown import RobotFlown
    from rota.model.plan import Plan
    from rota.vehicles.facts import Vehicle
    from rota.vehicles.motion import Wind

STRAIGHT_M = 0.2  # what points may be off straight ways by, in what is told of leaving them out
DIRECTIONS_DEG = range(0, 360, 45)  # from which wind may blow that has no direction


@dataclass(frozen=True, kw_only=True)
class InWind:
    """What becomes of a plan in wind from one direction; slowest: the greatest factor of its robots' rounds."""

    wind: Wind
    verdict: str
    worst_ratio: float
    slowest: float


@dataclass(frozen=True, kw_only=True)
class ByVehicle:
    """A plan as a vehicle flies a format's files, in what wind; ``plan``: as it is judged.

    directions: what becomes of it in wind from each direction, where this is the worst of several; else empty.
    """

    plan: Plan
    vehicle: Vehicle
    format: str
    wind: Wind
    robots: tuple[RobotFlown, ...]
    directions: tuple[InWind, ...] = ()

    def text(self, report: Report) -> str:
        """A row for each robot (rounds planned and flown, and how far corners are cut), then the report."""
        rows: list[tuple[str, ...]] = [("robot", "planned s", "flown s", "factor", "late a round s", "corners cut m")]
        for each in self.robots:
            cut_m = float(each.motion.cut_m.max(initial=0.0))
            round_s = each.motion.round_s
            cells = [f"{each.planned_s:.1f}", f"{round_s:.1f}", f"{each.factor:.2f}", f"{round_s - each.planned_s:.1f}"]
            rows.append((each.way.robot, *(cells if each.planned_s else ["stays", "", "", ""]), f"{cut_m:.1f}"))
        lines = [f"as {self.vehicle.told} flies {self.format}, {self._wind_text()}:", "", columns(rows), ""]
        if self.directions:
            lines += [columns([("wind from", "verdict", "worst ratio", "slowest round"), *self._directions()]), ""]
        return "\n".join([*lines, table_of_worst(report)])

    def _directions(self) -> list[tuple[str, ...]]:
        """A row for each direction: the verdict, the longest gap beside its period, the slowest round."""
        return [
            (
                f"{each.wind.from_deg:g} degrees",
                each.verdict,
                "never seen" if math.isinf(each.worst_ratio) else f"{each.worst_ratio:.3f}",
                f"{each.slowest:.3f}",
            )
            for each in self.directions
        ]

    def to_json(self, report: Report) -> dict[str, Any]:
        """The same as JSON values."""
        from rota.check import report_to_json

        return {
            "rota_flown": 1,
            "vehicle": self.vehicle.name,
            "format": self.format,
            "wind_m_s": self.wind.speed_m_s,
            "wind_from_deg": self.wind.from_deg,
            "directions": [
                {
                    "wind_from_deg": each.wind.from_deg,
                    "verdict": each.verdict,
                    "worst_ratio": None if math.isinf(each.worst_ratio) else each.worst_ratio,
                    "slowest_factor": each.slowest,
                }
                for each in self.directions
            ],
            "robots": [
                {
                    "robot": each.way.robot,
                    "planned_round_s": each.planned_s,
                    "flown_round_s": each.motion.round_s,
                    "factor": each.factor,
                    "legs_s": each.motion.legs_s.tolist(),
                    "corners_cut_m": each.motion.cut_m.tolist(),
                }
                for each in self.robots
            ],
            "report": report_to_json(report),
        }

    def remarks(self, planned: Plan, report: Report) -> list[str]:
        """What lapses by how much, and what would help."""
        from rota.vehicles.straight_ways import straighten_ways

        lines = []
        lapsed = [d for d in report.demands if d.outcome == "violated" and d.worst_gap_at_least_s > d.period_s]
        if lapsed:
            told = (
                f"{d.name} for ever" if math.isinf(d.worst_gap_at_least_s)
                else f"{d.name} by {d.worst_gap_at_least_s - d.period_s:.0f} s"
                for d in lapsed
            )  # fmt: skip
            lines.append(f"demands lapse: {', '.join(told)}")
        if lapsed and 1 < report.worst_ratio < math.inf:
            lines.append(
                f"none would lapse whose period is {math.ceil(100 * report.worst_ratio) / 100:.2f} times as long"
            )
        planned_s = sum(each.planned_s for each in self.robots)
        flown_s = sum(each.motion.round_s for each in self.robots)
        if planned_s and flown_s > WORTH_SAYING * planned_s:
            length_m = sum(trajectory.loop_length_m for trajectory in planned)
            lines.append(
                f"rounds take {flown_s / planned_s:.1f} times the planned time: it makes {length_m / flown_s:.1f} m/s"
                f" on them where {length_m / planned_s:.1f} m/s are planned; plans for slower robots come nearer"
            )
            fewer = ""
            for each in (self.vehicle, *_quicker_presets(self.vehicle)):
                if not planned.heeds_motion:
                    straight = straighten_ways(planned, STRAIGHT_M)
                    fewer = (
                        f", {_factor(straight, each):.1f} times without points on straight ways (rota straighten,"
                        f" {STRAIGHT_M:g} m)"
                    )
                lines.append(f"{each.told} takes {_factor(planned, each):.1f} times it{fewer}")
        return lines

    def _wind_text(self) -> str:
        if not self.wind.speed_m_s:
            return "without wind"
        told = f"in wind of {self.wind.speed_m_s:g} m/s from {self.wind.from_deg:g} degrees"
        return f"{told}, the worst of {len(self.directions)} directions" if self.directions else told


def fly_by(
    plan: Plan, name: str, vehicle: str, wind: str | None, in_phase_every_s: float | None, origin: str | None
) -> tuple[ByVehicle, ...]:
    """The plan as a named vehicle flies it, in wind from each direction that it may blow from.

    wind: M_S,FROM_DEG, or M_S from eight directions, as is the mission's own wind where None is given. Raises RotaError
    as ``plan_as_flown`` does.
    """
    from rota.exports import export_format, place_for
    from rota.files.executed.plan_as_flown import plan_as_flown
    from rota.vehicles.presets import vehicle_named

    export_format(name, "--executed")
    require_no_flights(plan, "--vehicle", "without it its single flights are judged as files have them")
    known, winds = vehicle_named(vehicle), _winds_of(plan) if wind is None else _winds_given(wind)
    if origin is not None:
        plan = place_for(plan, origin, name)
    mention_compiling("vehicles")
    flights = []
    for blows in winds:
        made, robots = plan_as_flown(plan, name, known, blows)
        if in_phase_every_s is not None:
            made = in_phase_every(plan, made, in_phase_every_s)
        flights.append(ByVehicle(plan=made, vehicle=known, format=name, wind=blows, robots=robots))
    return tuple(flights)


def worst_flight(flights: Sequence[ByVehicle], reports: Sequence[Report]) -> tuple[ByVehicle, Report]:
    """The flight with the worst report, which then tells what becomes of the others; a single one as it is."""
    if len(flights) == 1:
        return flights[0], reports[0]
    directions = tuple(
        InWind(
            wind=flight.wind,
            verdict=report.verdict,
            worst_ratio=report.worst_ratio,
            slowest=max((robot.factor for robot in flight.robots), default=1.0),
        )
        for flight, report in zip(flights, reports, strict=True)
    )
    ranks = [(each.verdict != "met", each.worst_ratio, each.slowest) for each in directions]
    worst = ranks.index(max(ranks))
    return replace(flights[worst], directions=directions), reports[worst]


def _winds_of(plan: Plan) -> tuple[Wind, ...]:
    """The wind that a plan is for, the strongest of its robots', from each direction; where it is for none, no wind."""
    return _from_each_direction(max((plan.mission.fleet.robot(way.robot).motion.wind_m_s for way in plan), default=0.0))


def _winds_given(text: str) -> tuple[Wind, ...]:
    """The wind of the text M_S,FROM_DEG, or of M_S from each direction. Raises RotaError for other texts."""
    from rota.vehicles.motion import Wind

    speed_m_s, from_deg = wind_given(text, "from eight directions")
    return _from_each_direction(speed_m_s) if from_deg is None else (Wind(speed_m_s=speed_m_s, from_deg=from_deg),)


def _from_each_direction(speed_m_s: float) -> tuple[Wind, ...]:
    from rota.vehicles.motion import Wind

    if speed_m_s == 0:
        return (Wind(),)
    return tuple(Wind(speed_m_s=speed_m_s, from_deg=float(from_deg)) for from_deg in DIRECTIONS_DEG)


def _factor(plan: Plan, vehicle: Vehicle) -> float:
    """All rounds of a vehicle together beside the planned ones, without wind, by the closed form."""
    from rota.files.executed.plan_as_flown import way_of
    from rota.vehicles.models import model_of

    model = model_of(vehicle)
    return sum(model.round_s(way_of(plan, each)) for each in plan) / sum(each.loop_duration_s for each in plan)


def _quicker_presets(vehicle: Vehicle) -> list[Vehicle]:
    """Presets of the same formats that are quicker."""
    from rota.vehicles.presets import VEHICLES

    own = vehicle.acceleration_m_s2
    return [
        other
        for other in VEHICLES.values()
        if other.formats == vehicle.formats
        and other.acceleration_m_s2 is not None
        and own is not None
        and other.acceleration_m_s2.value > own.value
    ]
