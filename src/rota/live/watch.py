"""The watch itself: events in, notices and states out, the same ones for the same events."""

from __future__ import annotations

import math

import numpy as np

from rota.links.link import Mode
from rota.live.ages import Ages, is_jump
from rota.live.battery import Battery
from rota.live.demand_alarms import DemandAlarms
from rota.live.events import Dropped, Event, Heard
from rota.live.following import Following
from rota.live.forecast import Forecast
from rota.live.notices import FleetState, Notice, NoticeKind, RobotState, Standing, lag_text, place_text, seconds
from rota.live.places import places_of
from rota.live.settings import WatchSettings
from rota.live.ways import Ways
from rota.model.arrays import Floats
from rota.model.mission import inner_reach_m
from rota.model.plan import Plan
from rota.routes.constant_speeds import plan_at_constant_speeds
from rota.routes.flights import on_charger

LEAST_OFF_M = 0.5  # beside its route: what positioning in the field errs by, however little a robot sees
SETTLED_M = 0.8  # of the limit: nearer than this a robot that was off its route is on it again
TOLD_MODES = ("paused", "returning", "failed")
DRIVING = (None, "running")
LEAVE_SOON_S = 60.0


class Watch:
    """A fleet watched along its plan. ``take`` is given every event, in order; ticks bring notices.

    It looks at no clock and draws no lots: the same events give the same notices and states, bit for bit. Ages count
    from the first tick on, or from the latest loop start by plan where that is later: what was seen before is not
    known, or not asked.
    """

    def __init__(self, plan: Plan, settings: WatchSettings | None = None) -> None:
        self.plan, self.settings = plan, settings or WatchSettings()
        mission = plan.mission
        self._robots = [mission.fleet.robot(way.robot) for way in plan]
        self.places = places = places_of(mission)
        self._ages = Ages(mission, places)
        ways = Ways(mission, self._robots, places)
        driven = plan_at_constant_speeds(plan)
        self._alarms = DemandAlarms(Forecast(driven, places), ways, [robot.name for robot in self._robots])
        self._ways = ways
        self._following = Following(driven)
        off_m = self.settings.off_route_m
        self._off_route_m = np.array(
            [max(inner_reach_m(robot.sensor) / 2, LEAST_OFF_M) if off_m is None else off_m for robot in self._robots],
            np.float64,
        )
        count = len(self._robots)
        self._last: list[Heard | None] = [None] * count
        self._new: dict[int, Heard] = {}
        self._standing: list[Standing] = ["ok"] * count
        self._mode: list[Mode | None] = [None] * count
        self._batteries = [Battery() for _ in self._robots]
        self._battery_told: list[NoticeKind | None] = [None] * count
        self._home_s: dict[int, float] = {}
        self._dropped: dict[str, int] = {}
        self._told: list[Notice] = []
        self._now_s = -math.inf
        self._begun_s: float | None = None
        self._ages_from_s = max((way.loop_start_s for way in plan), default=0.0)
        self._next_forecast_s = -math.inf

    @property
    def now_s(self) -> float:
        """The time of the last tick; -inf before the first."""
        return self._now_s

    @property
    def begun(self) -> bool:
        """Whether there was a tick."""
        return self._begun_s is not None

    @property
    def lapses(self) -> int:
        """How often a demand's period has lapsed so far."""
        return self._alarms.lapses

    @property
    def last_seen_s(self) -> Floats:
        """(n,) seconds of the clock, when each of ``places`` was last seen, as far as is known."""
        return self._ages.last_seen_s

    def believe(self, robot: str, lag_s: float) -> None:
        """Take it that a robot on its charger is so far behind its plan."""
        self._following.believe(next(k for k, one in enumerate(self._robots) if one.name == robot), lag_s)

    def take(self, event: Event) -> list[Notice]:
        """Take an event; a tick returns what there is to tell since the last one."""
        if isinstance(event, Heard):
            self._hear(event)
            return []
        if isinstance(event, Dropped):
            self._drop(event)
            return []
        self._tick(event.now_s)
        told, self._told = self._told, []
        return told

    # ------------------------------------------------------------ what arrives

    def _hear(self, heard: Heard) -> None:
        """Note where a robot is, and what it has seen on its way there."""
        number, robot = heard.robot, self._robots[heard.robot]
        last = self._last[number]
        if last is not None and heard.time_s <= last.time_s:
            return
        here = (heard.x_m, heard.y_m, heard.height_m)
        away = heard.time_s < robot.joins_s or (robot.leaves_s is not None and heard.time_s > robot.leaves_s)
        if (way := self.plan.trajectories[number]).charges:
            away |= bool(on_charger(way, np.array([heard.time_s - self._following.lags_s[number]]))[0])
        if not away:
            there, from_s = here, heard.time_s
            if last is not None and heard.time_s - last.time_s <= self.settings.silent_s:
                before = (last.x_m, last.y_m, last.height_m)
                if not is_jump(robot, before, here, heard.time_s - last.time_s):
                    there, from_s = before, last.time_s
            self._ages.drive(robot, there, from_s, here, heard.time_s)
        self._last[number] = self._new[number] = heard
        if heard.battery is not None:
            self._batteries[number].hear(heard.battery, heard.time_s)

    def _drop(self, dropped: Dropped) -> None:
        first = dropped.fault not in self._dropped
        self._dropped[dropped.fault] = self._dropped.get(dropped.fault, 0) + dropped.messages
        if first:
            text = f"messages are dropped and counted: {dropped.fault} ({dropped.example})"
            self._tell("dropped", dropped.fault, text, messages=dropped.messages, example=dropped.example)

    # ------------------------------------------------------------ what a tick brings

    def _tick(self, now_s: float) -> None:
        """Let time pass: follow the robots, and look ahead when it is time for that."""
        if now_s <= self._now_s:
            return
        self._now_s = now_s
        if self._begun_s is None:
            self._begun_s = now_s
            self._ages.begin(max(now_s, self._ages_from_s))
            self._next_forecast_s = now_s + self.settings.forecast_s
        self._follow()
        self._note_silence()
        self._settle()
        if now_s >= self._next_forecast_s:
            self._next_forecast_s = now_s + self.settings.forecast_s
            self._told += self._alarms.look_ahead(self._now_s, self._ages, *self._team(), self._places_m())
            self._note_batteries()

    def _follow(self) -> None:
        """Where robots are on their routes, by the last report of each since the last tick."""
        if self._new:
            heard = [self._new[number] for number in sorted(self._new)]
            self._new.clear()
            numbers = np.array([each.robot for each in heard], np.int64)
            times = np.array([each.time_s for each in heard])
            at = np.array([[each.x_m, each.y_m] for each in heard])
            self._following.hear(numbers, times, at, self._off_route_m)
            for each in heard:
                self._note_heard(each)

    def _note_heard(self, heard: Heard) -> None:
        """A robot that was lost is back; it leaves its route or comes back to it; its mode is another."""
        number, name = heard.robot, self._robots[heard.robot].name
        if self._now_s - heard.time_s <= self.settings.silent_s and self._standing[number] == "lost":
            self._standing[number] = "ok"
            self._tell("back", name, f"{name} is heard again")
        away_m, limit_m = float(self._following.away_m[number]), float(self._off_route_m[number])
        at = (heard.x_m, heard.y_m)
        if self._standing[number] == "ok" and away_m > limit_m:
            self._standing[number] = "off route"
            text = f"{name} is off its route: {away_m:.1f} m beside it, at {place_text(at)}"
            self._tell("off route", name, text, away_m=away_m, place_m=at)
        elif self._standing[number] == "off route" and away_m < SETTLED_M * limit_m:
            self._standing[number] = "ok"
            self._tell("on route", name, f"{name} is on its route again")
        held_up, behind = bool(self._following.held_up[number]), lag_text(float(self._following.lags_s[number]))
        if self._standing[number] == "ok" and held_up and heard.mode in DRIVING:
            self._standing[number] = "held up"
            text = f"{name} is held up: it does not get on, {behind}, at {place_text(at)}"
            self._tell("held up", name, text, lag_s=float(self._following.lags_s[number]), place_m=at)
        elif self._standing[number] == "held up" and not held_up:
            self._standing[number] = "ok"
            self._tell("goes on", name, f"{name} goes on, {behind}")
        if heard.mode != self._mode[number]:
            if heard.mode in TOLD_MODES or self._mode[number] in TOLD_MODES:
                self._tell("mode", name, f"{name} is {heard.mode or 'silent about its mode'}", mode=heard.mode)
            self._mode[number] = heard.mode

    def _note_silence(self) -> None:
        """Robots that have become lost, and what lapses without each."""
        for number, robot in enumerate(self._robots):
            if self._standing[number] == "lost" or self._silent_s(number) <= self.settings.silent_s:
                continue
            with_it_s = self._alarms.lapse_times_s(self._ages, *self._team())
            self._standing[number] = "lost"
            self._settle()
            missed, facts = self._alarms.lapses_without(self._now_s, self._ages, *self._team(), with_it_s)
            last = self._last[number]
            at = "never heard" if last is None else f"last at {place_text((last.x_m, last.y_m))}"
            silent = self._silent_s(number)
            text = f"{robot.name} is lost: silent for {seconds(silent)}, {at}; without it {missed}"
            self._tell("lost", robot.name, text, silent_s=silent, lapses=facts)

    def _settle(self) -> None:
        """Ages up to the moment up to which all robots have reported that are not lost."""
        heard = [
            last.time_s if last is not None else self._begun_s or 0.0
            for last, standing in zip(self._last, self._standing, strict=True)
            if standing != "lost"
        ]
        known_s = min(self._now_s, *heard) if heard else self._now_s
        if known_s > self._ages.known_s:
            self._told += self._alarms.close(self._now_s, self._ages, *self._ages.settle(known_s))

    def _silent_s(self, number: int) -> float:
        last = self._last[number]
        since_s = self._begun_s if last is None else last.time_s
        return self._now_s - (since_s if since_s is not None else self._now_s)

    def _team(self) -> tuple[Floats, Floats]:
        """The lags of all robots, and until when each is counted on: for ever, or not at all."""
        pairs = zip(self._standing, self._mode, strict=True)
        counted = [standing == "ok" and mode in DRIVING for standing, mode in pairs]
        return self._following.lags_s, np.where(counted, math.inf, -math.inf)

    def _places_m(self) -> dict[int, tuple[float, float]]:
        """Where robots are that can be asked to go somewhere."""
        return {
            number: (last.x_m, last.y_m)
            for number, last in enumerate(self._last)
            if last is not None and self._standing[number] != "lost" and self._mode[number] != "failed"
        }

    def _note_batteries(self) -> None:
        """Tell of each battery that is low, and of each robot that must leave."""
        for number, robot in enumerate(self._robots):
            battery = self._batteries[number]
            if battery.level is None or self._standing[number] == "lost" or self.plan.trajectories[number].charges:
                continue
            leaves_s = self._leaves_in_s(number)
            kind: NoticeKind | None = None
            if leaves_s is not None and leaves_s <= 0:
                kind = "must leave"
            elif battery.level <= self.settings.battery_low or (leaves_s is not None and leaves_s <= LEAVE_SOON_S):
                kind = "battery low"
            if kind == self._battery_told[number] or (kind == "battery low" and self._battery_told[number]):
                continue
            self._battery_told[number] = kind
            if kind is not None:
                missed, facts = self._lapses_after(number, leaves_s)
                when = "now" if kind == "must leave" else f"in {seconds(leaves_s)}" if leaves_s is not None else "soon"
                text = f"{robot.name}: battery at {battery.level:.0%}; it must leave {when}; without it {missed}"
                self._tell(kind, robot.name, text, battery=battery.level, leaves_in_s=leaves_s, lapses=facts)

    def _lapses_after(self, number: int, leaves_s: float | None) -> tuple[str, list[dict[str, object]]]:
        """What lapses if a robot leaves in so many seconds (None: now) and the others go on."""
        lags_s, until_s = self._team()
        later_s = self._now_s + max(leaves_s or 0.0, 0.0)
        with_it_s = self._alarms.lapse_times_s(self._ages, lags_s, until_s, later_s)
        until_s[number] = min(until_s[number], later_s)
        return self._alarms.lapses_without(self._now_s, self._ages, lags_s, until_s, with_it_s, later_s)

    def _leaves_in_s(self, number: int) -> float | None:
        """Seconds until a robot must leave for home, from the farthest place of its route; None: not known."""
        battery = self._batteries[number]
        if battery.per_s is None:
            return None
        if number not in self._home_s:
            way = self.plan.trajectories[number].positions_m[:, :2]
            self._home_s[number] = self._ways.home_s(number, way, way[0])
        return battery.leaves_in_s(self._home_s[number])

    def _tell(self, kind: NoticeKind, about: str, text: str, **facts: object) -> None:
        self._told.append(Notice(time_s=self._now_s, kind=kind, about=about, text=text, facts=facts))

    # ------------------------------------------------------------ the state

    def state(self) -> FleetState:
        """The fleet as it was at the last tick."""
        robots = []
        for number, robot in enumerate(self._robots):
            last, mode = self._last[number], self._mode[number]
            standing: Standing = self._standing[number]
            if standing == "ok" and mode not in DRIVING:
                standing = "waiting"
            robots.append(
                RobotState(
                    name=robot.name,
                    standing=standing,
                    place_m=None if last is None else (last.x_m, last.y_m),
                    away_m=float(self._following.away_m[number]),
                    lag_s=float(self._following.lags_s[number]),
                    silent_s=self._silent_s(number),
                    battery=self._batteries[number].level,
                    leaves_in_s=None if standing == "lost" else self._leaves_in_s(number),
                    mode=mode,
                )
            )
        return FleetState(
            time_s=self._now_s,
            known_s=self._ages.known_s,
            robots=tuple(robots),
            demands=self._alarms.states(self._now_s, self._ages),
            dropped=dict(self._dropped),
        )
