"""What a watch tells: notices as things happen, and the state of the fleet at a moment."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from typing import Any, Literal

from rota.links.link import Mode

NoticeKind = Literal[
    "lost", "back", "off route", "on route", "held up", "goes on", "mode", "battery low", "must leave",
    "will lapse", "in time", "lapsed", "seen again", "dropped", "too slow", "keeps up",
    "lands", "takes off", "relief late", "relief comes", "does not wait",
]  # fmt: skip
ALARMS: tuple[NoticeKind, ...] = (
    "lost",
    "off route",
    "held up",
    "battery low",
    "must leave",
    "will lapse",
    "lapsed",
    "too slow",
    "relief late",
    "does not wait",
)
Standing = Literal["ok", "waiting", "held up", "off route", "lost"]
DemandStanding = Literal["ok", "will lapse", "lapsed"]


@dataclass(frozen=True, kw_only=True)
class Notice:
    """Something that happened to a robot or a demand, ``about``, told at ``time_s``; ``facts`` are its numbers."""

    time_s: float
    kind: NoticeKind
    about: str
    text: str
    facts: dict[str, Any] = field(default_factory=dict)

    @property
    def is_alarm(self) -> bool:
        """Whether somebody should look."""
        return self.kind in ALARMS


@dataclass(frozen=True, kw_only=True)
class RobotState:
    """One robot: where it said it is (None: it said nothing), metres beside its route, seconds behind its plan."""

    name: str
    standing: Standing
    place_m: tuple[float, float] | None
    away_m: float
    lag_s: float
    silent_s: float
    battery: float | None
    leaves_in_s: float | None
    mode: Mode | None


@dataclass(frozen=True, kw_only=True)
class DemandState:
    """One demand: the age of the place that was seen longest ago, the longest gap so far, and when it will lapse.

    lapses_in_s None: not within the forecast. could: robots that could still see that place in time.
    """

    name: str
    period_s: float
    standing: DemandStanding
    age_s: float
    place_m: tuple[float, float] | None
    worst_s: float
    lapses_in_s: float | None
    could: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class FleetState:
    """A moment of the watch. known_s: up to when all robots that are not lost have reported."""

    time_s: float
    known_s: float
    robots: tuple[RobotState, ...]
    demands: tuple[DemandState, ...]
    dropped: dict[str, int]


def seconds(value: float) -> str:
    """A time as people read it."""
    return "never" if math.isinf(value) else f"{value:.2g} s" if abs(value) < 1 else f"{value:.1f} s"


def lag_text(lag_s: float) -> str:
    """How late a robot is as people read it."""
    return f"{seconds(abs(lag_s))} {'ahead of' if lag_s < 0 else 'behind'} its plan"


def place_text(place_m: tuple[float, float]) -> str:
    """A place as people read it."""
    return f"({place_m[0]:.1f}, {place_m[1]:.1f})"


def names_in_words(names: list[str], most: int = 3) -> str:
    """Names in a row, the first few of them."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def notice_json(notice: Notice) -> str:
    """A notice as one line of JSON, without its end."""
    told = {"time_s": notice.time_s, "notice": notice.kind, "about": notice.about, "text": notice.text}
    return json.dumps({**told, **notice.facts}, allow_nan=False)


def state_json(state: FleetState) -> str:
    """A state as one line of JSON, without its end; never is null."""
    robots = [{key: _finite(value) for key, value in vars(robot).items()} for robot in state.robots]
    demands = [{key: _finite(value) for key, value in vars(demand).items()} for demand in state.demands]
    told = {"time_s": state.time_s, "known_s": state.known_s, "robots": robots, "demands": demands}
    return json.dumps({**told, "dropped": state.dropped}, allow_nan=False)


def notice_line(notice: Notice) -> str:
    """A notice as a line for people."""
    return f"{notice.time_s:9.1f} s  {'ALARM' if notice.is_alarm else '     '}  {notice.text}"


def state_line(state: FleetState) -> str:
    """A state as a line for people: who is not all right, and each demand's age beside its period."""
    bad = [f"{robot.name} {robot.standing}" for robot in state.robots if robot.standing != "ok"]
    demands = [f"{demand.name} {demand.age_s:.0f}/{demand.period_s:.0f} s" for demand in state.demands]
    fleet = f"{len(state.robots)} robots, {names_in_words(bad) if bad else 'all on their routes'}"
    ages = f"; ages: {', '.join(demands)}" if demands else ""
    return f"{state.time_s:9.1f} s         {fleet}{ages}"


def summary(state: FleetState, lapses: int) -> str:
    """What a watch came to, as a line for people."""
    longest = [(demand.name, max(demand.worst_s, demand.age_s), demand.period_s) for demand in state.demands]
    worst = [f"{name} {gap_s:.1f} of {period_s:g} s" for name, gap_s, period_s in longest]
    times = (
        "no period has lapsed" if not lapses else "a period has lapsed" + ("" if lapses == 1 else f" {lapses} times")
    )
    dropped = sum(state.dropped.values())
    more = f"; {dropped} messages were dropped" if dropped else ""
    gaps = f"{times}; longest gaps: {', '.join(worst)}" if worst else "no period was asked"
    return f"until {state.time_s:.1f} s {gaps}{more}"


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
