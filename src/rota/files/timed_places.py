"""Plan -> what files with a clock hold of each robot: places on the globe, each with its instant."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np

from rota.errors import PlanError, RotaError
from rota.files.geodesy import Projection
from rota.model.plan import Floats, Plan, Trajectory
from rota.routes.constant_speeds import plan_at_constant_speeds

START = datetime(2000, 1, 1, tzinfo=UTC)  # fixed, so that the same plan gives the same file
NS_PER_S = 1_000_000_000


@dataclass(frozen=True, kw_only=True)
class TimedRoute:
    """A robot's approach and one round of its loop. lon, lat (n,) degrees; heights_m (n,); instants: n times in UTC."""

    robot: str
    lon: Floats
    lat: Floats
    heights_m: Floats
    instants: list[str]


def instant_given(text: str | datetime, where: str) -> datetime:
    """An instant, or one in ISO 8601; without a zone it is UTC. RotaError for other text, which names ``where``."""
    try:
        instant = text if isinstance(text, datetime) else datetime.fromisoformat(text)
        return (instant if instant.tzinfo else instant.replace(tzinfo=UTC)).astimezone(UTC)
    except (ValueError, OverflowError):
        raise RotaError(
            f"{where}: {text!r} is not allowed; a date and time in ISO 8601 is needed, such as 2000-01-01T00:00:00Z,"
            " of the years 1 to 9999"
        ) from None


def timed_routes(plan: Plan, projection: Projection, start: datetime) -> Iterator[TimedRoute]:
    """Each robot's route, in the plan's order; a robot that stays ends where it stays.

    Places keep all digits: robots that touch walls would be beyond them otherwise. Instants are rounded to nanoseconds,
    so that loops that share a period go on sharing it; those on a millisecond have three digits. A third coordinate of
    positions is the height; else it is the fleet's altitude. Raises PlanError for routes that end after the year 9999,
    which ISO 8601 has no four digits for. Legs with accelerations are shorter ones at constant speeds, see
    ``plan_at_constant_speeds``.
    """
    for trajectory in plan_at_constant_speeds(plan):
        places_m = trajectory.positions_m
        lon, lat = projection.to_degrees(places_m[:, 0], places_m[:, 1])
        flat = places_m.shape[1] == 2
        heights_m = np.full(len(lat), plan.mission.fleet.altitude_m) if flat else places_m[:, 2]
        yield TimedRoute(
            robot=trajectory.robot,
            lon=lon,
            lat=lat,
            heights_m=heights_m,
            instants=_instants(trajectory, start),
        )


def instant_text(instant: datetime) -> str:
    """An instant in UTC as ISO 8601, in milliseconds."""
    return instant.astimezone(UTC).replace(tzinfo=None).isoformat(timespec="milliseconds") + "Z"


def require_dated(robot: str, start: datetime, duration_s: float) -> None:
    """Raise PlanError for a robot's route of so many seconds that ends after the year 9999."""
    try:
        start + timedelta(seconds=duration_s + 1)
    except OverflowError:
        raise PlanError(
            f"robot {robot}: its route of {duration_s:g} s from {instant_text(start)} on ends after the year 9999; name"
            " an earlier start"
        ) from None


def _instants(trajectory: Trajectory, start: datetime) -> list[str]:
    require_dated(trajectory.robot, start, float(trajectory.times_s[-1]))
    # seconds and nanoseconds apart: both together have no room in 64 bits for the years up to 9999
    begin = start.astimezone(UTC).replace(tzinfo=None)
    whole_s = np.floor(trajectory.times_s)
    parts_ns = np.round((trajectory.times_s - whole_s) * NS_PER_S).astype(np.int64) + begin.microsecond * 1000
    seconds = np.datetime64(begin.replace(microsecond=0), "s") + (whole_s.astype(np.int64) + parts_ns // NS_PER_S)
    texts = np.datetime_as_string(seconds).tolist()
    return [f"{text}.{_decimals(ns)}Z" for text, ns in zip(texts, (parts_ns % NS_PER_S).tolist(), strict=True)]


def _decimals(ns: int) -> str:
    return f"{ns // 1_000_000:03d}" if ns % 1_000_000 == 0 else f"{ns:09d}"
