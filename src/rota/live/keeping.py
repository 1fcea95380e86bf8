"""Robots kept in phase while they drive: how late each is against one clock for all, and what is done about it.

The clock of all goes as fast as the plan's, and slower while a robot cannot keep up: loops then take longer, but robots
stay as far apart in time as planned. What was lost so is not made up, nor what all are late by.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from rota.check.revisits import worst_gaps_s
from rota.links.link import Mode, Order
from rota.live.notices import Notice, NoticeKind, RobotState, names_in_words
from rota.live.places import places_of
from rota.live.reliefs import Conduct, Reliefs
from rota.model.plan import Plan
from rota.routes.flights import flights_of, has_flights
from rota.routes.served_loops import service_of
from rota.routes.who_relieves import robots_that_relieve

MOST_PLACES = 4_000  # at which it is looked whether one team alone sees them in time
MET = 1 + 1e-9  # times its period
LATE_S = 1.0  # by which a robot is late before all wait for it
EARLY_SHARE = 0.5  # of that, from which on they begin to
CAUGHT_UP_S = 0.2  # by which one that all waited for is late when they no longer do
GAINS = 1.25  # times what it loses all lose then, until it is late by less than they begin to wait for
LOOKED_BACK_S = 40.0  # over which a robot's pace is measured at least, and half of that at the beginning
LONGEST_LOOK_S = 120.0  # a robot that breaks down on a longer round is to be waited for in time
LEAST_RATE = 0.5  # of the plan's clock: nobody waits for a robot that is slower
TOLD_AFTER_S = 10.0  # that a robot is so late without a break
NOTED = 0.01  # by which the pace has to be below the plan's to be told
NOTHING: Mapping[str, float] = MappingProxyType({})
DRIVING: tuple[Mode | None, ...] = (None, "running")


@dataclass(frozen=True, kw_only=True)
class Slack:
    """How long a demand's places wait at most by plan, and how long they may: at gap / period of its pace it lapses."""

    gap_s: float
    period_s: float


class Keeping:
    """The clock of all for a plan's robots. slack: of each demand by its name; what is met by plan is told from it.

    most_rate: the share of the plan's pace at which the clock goes at most, up to 1. conduct: what robots that charge
    are to do since the last look.
    """

    def __init__(self, plan: Plan, slack: Mapping[str, Slack], most_rate: float = 1.0) -> None:
        self._waited_for = robots_waited_for(plan)
        self._reliefs, self.conduct = Reliefs(plan, self._waited_for), Conduct()
        self._most_rate = min(most_rate, 1.0)
        self._slack = slack
        self._tracks = {way.robot: _Track(looked_back_s(way.loop_duration_s)) for way in plan}
        self._expected_s: Mapping[str, float] = NOTHING
        self._now_s: float | None = None
        self.rate = self._most_rate
        self.behind_s = 0.0
        self._team = teams_apart(plan)
        self._held_s = dict.fromkeys(self._team.values(), 0.0)
        self._holding = frozenset[int]()

    def late_s(self, robot: RobotState) -> float:
        """How many seconds a robot is behind its team's clock, less what is expected where it is; below 0: ahead."""
        return robot.lag_s - self.behind_of_s(robot.name) - self._expected_s.get(robot.name, 0.0)

    def behind_of_s(self, name: str) -> float:
        """How far a robot's clock is behind the plan's: the clock of all, and what its team alone has waited."""
        return self.behind_s + self._held_s[self._team[name]]

    def look(
        self,
        now_s: float,
        robots: tuple[RobotState, ...],
        room_s: Mapping[str, float] = NOTHING,
        expected_s: Mapping[str, float] = NOTHING,
        lead_s: float = 0.0,
    ) -> tuple[list[Order], list[Notice]]:
        """What each robot that drives its route is to make up now, and what there is to tell.

        room_s: what robots make up by themselves soon: nobody waits for that. expected_s: how late each is where it is
        while all goes well. lead_s: how long before it leaves its charger a robot has to be told. behind_s: how far the
        clock of all is behind the plan's by then.
        """
        self._expected_s = expected_s
        if self._now_s is not None:
            self.behind_s += (1 - self.rate) * (now_s - self._now_s)
            for team in self._holding:
                self._held_s[team] += self.rate * (now_s - self._now_s)
        self._now_s = now_s
        self.conduct, told = self._reliefs.look(now_s, robots, self.behind_of_s, lead_s)
        held_before, waited_for = self._holding, self._waited_for.intersection
        self._holding = frozenset(self._team[name] for name in waited_for(self.conduct.late))
        drives = {robot.name: self._drives(robot, held_before) for robot in robots}
        on_route = [
            self.late_s(robot) - room_s.get(robot.name, 0.0)
            for robot in robots
            if drives[robot.name] and robot.name in self._waited_for
        ]
        if on_route and min(on_route) > LATE_S:
            # nobody is nearer to the clock: it is they that keep it
            self.behind_s += min(on_route) - EARLY_SHARE * LATE_S
        orders, rates = [], [self._most_rate]
        for robot in robots:
            track = self._tracks[robot.name]
            held = self._team[robot.name] in self._holding
            if held or not drives[robot.name]:
                track.forget()  # what it loses now is not its own
            if not drives[robot.name]:
                continue
            late_s, own_s = self.late_s(robot), room_s.get(robot.name, 0.0)
            track.note(now_s, late_s + self.behind_of_s(robot.name) - own_s)
            orders.append((robot.name, late_s))
            pace, late_s = track.pace(), late_s - own_s
            track.judge(late_s)
            if pace is not None and self._waits_for(robot.name, pace):
                rates.append(1 - max(0.0, 1 - pace) * track.waited_share(late_s))
            told += self._standing(now_s, robot.name, track, late_s, pace)
        self.rate = 0.0 if self._holding == self._held_s.keys() else max(min(LEAST_RATE, self._most_rate), min(rates))
        docked = [
            Order(
                robot=name,
                late_s=now_s - self.behind_of_s(name) - dock.plan_s,
                behind_s=self.behind_of_s(name),
                rate=self._most_rate,
                dock=dock,
            )
            for name, dock in self.conduct.docks.items()
        ]
        return [*docked, *(self._order(name, late_s) for name, late_s in orders)], told

    def _waits_for(self, name: str, pace: float) -> bool:
        """Whether all go slower with a robot that goes at this pace."""
        return name in self._waited_for and pace >= LEAST_RATE * self._most_rate

    def _drives(self, robot: RobotState, held_before: frozenset[int]) -> bool:
        """Whether it is on its route, in the air; one that was told to hold where it is looks as if it were held up."""
        held = self._team[robot.name] in held_before
        on = robot.standing == "ok" or (held and robot.standing == "held up")
        return on and robot.mode in DRIVING and robot.place_m is not None and robot.name not in self.conduct.docks

    def _order(self, name: str, late_s: float) -> Order:
        behind_s = self.behind_of_s(name)
        if name in self.conduct.hurried:
            return Order(robot=name, late_s=max(late_s, 0.0), behind_s=behind_s, rate=self._most_rate)
        # one that is late drives as fast as it can: its pace tells how slowly all have to go
        rate = 0.0 if self._team[name] in self._holding else self.rate
        rate = rate if late_s < EARLY_SHARE * LATE_S else self._most_rate
        return Order(robot=name, late_s=late_s, behind_s=behind_s, rate=rate)

    def _standing(self, now_s: float, name: str, track: _Track, late_s: float, pace: float | None) -> list[Notice]:
        """That a robot cannot keep up, once, with what that leads to; and that it can again."""
        if pace is None:
            return []
        track.late_since_s = min(track.late_since_s, now_s) if track.is_late else math.inf
        slow = now_s - track.late_since_s >= TOLD_AFTER_S and pace < self._most_rate - NOTED
        if slow and not track.told_slow:
            track.told_slow = True
            waits = self._waits_for(name, pace)
            others = f"all go on at {pace:.2f} of the plan's pace" if waits else "the others go on without it"
            lapses = self.lapses_at(pace) if waits else []
            then = f"; at that pace {names_in_words(lapses)}" if lapses else "; nothing lapses by that" if waits else ""
            text = f"{name} cannot keep up: {late_s:.1f} s late, at {pace:.2f} of its pace; {others}{then}"
            return [_notice(now_s, "too slow", name, text, late_s=late_s, pace=pace)]
        if track.told_slow and not track.is_late:
            track.told_slow = False
            return [_notice(now_s, "keeps up", name, f"{name} keeps up again", late_s=late_s, pace=pace)]
        return []

    def lapses_at(self, pace: float) -> list[str]:
        """Which of the demands that are met by plan lapse where all robots drive at a share of its pace."""
        return [
            f"{name} is seen every {each.gap_s / pace:.1f} s of {each.period_s:g} s"
            for name, each in self._slack.items()
            if each.gap_s <= each.period_s < each.gap_s / pace
        ]

    def least_pace(self) -> tuple[float, str] | None:
        """The share of the plan's pace at which the first demand lapses, and its name; None where there is none."""
        pairs = [(each.gap_s / each.period_s, name) for name, each in self._slack.items() if each.gap_s > 0]
        return max((pair for pair in pairs if pair[0] <= 1), default=None)


def looked_back_s(round_s: float) -> float:
    """Over how many seconds a robot's pace is measured: of its rounds so many as take 40 s, of long ones 120 s.

    Whole rounds, since on each a robot is late at the same places and early at others: only where it comes past the
    same place again does its lag tell how much slower it is.
    """
    rounds_s = round_s * math.ceil(LOOKED_BACK_S / round_s) if round_s > 0 else LOOKED_BACK_S
    return min(rounds_s, LONGEST_LOOK_S)


class _Track:
    """How late one robot was, over ``most_s`` seconds."""

    def __init__(self, most_s: float) -> None:
        self._most_s = most_s
        self._noted: deque[tuple[float, float]] = deque()
        self.told_slow = False
        self.late_since_s = math.inf
        self.is_late = False

    def forget(self) -> None:
        self._noted.clear()
        self.late_since_s, self.is_late = math.inf, False

    def judge(self, late_s: float) -> None:
        """Note whether it is late by so much that all wait for it; then it is until it has caught up."""
        self.is_late = late_s >= LATE_S or (self.is_late and late_s > CAUGHT_UP_S)

    def waited_share(self, late_s: float) -> float:
        """How much of what the robot loses all lose with it: the more, the later it is.

        One that is as late as all wait for would stay so for ever: then they lose a little more than it.
        """
        begins_s = EARLY_SHARE * LATE_S
        share = min(max((late_s - begins_s) / (LATE_S - begins_s), 0.0), 1.5)
        if not self.is_late:
            return share
        return max(share, GAINS if late_s > begins_s else 1.0)

    def note(self, time_s: float, lag_s: float) -> None:
        self._noted.append((time_s, lag_s))
        while self._noted[-1][0] - self._noted[0][0] > self._most_s:
            self._noted.popleft()

    def pace(self) -> float | None:
        """The share of its plan's pace at which it got on; None until it is known."""
        (from_s, lag_then_s), (to_s, lag_s) = self._noted[0], self._noted[-1]
        if to_s - from_s < LOOKED_BACK_S / 2:
            return None
        return 1 - (lag_s - lag_then_s) / (to_s - from_s)


def _notice(now_s: float, kind: NoticeKind, about: str, text: str, **facts: float) -> Notice:
    finite = {name: value for name, value in facts.items() if math.isfinite(value)}
    return Notice(time_s=now_s, kind=kind, about=about, text=text, facts=dict(finite))


def teams_apart(plan: Plan) -> dict[str, int]:
    """The number of each robot's team, by names: a team may wait for a late relief while others go on.

    Robots are of one team that take turns at a loop, that share a charger with fewer places than robots, or without
    which some place is not seen in time: then it matters how they follow each other. All are in swarms, where
    bodies are to be kept apart, where zones are to be visited, and where nobody charges.
    """
    teams = {way.robot: k for k, way in enumerate(plan)}
    visits = any(zone.demand == "visit" for zone in plan.mission.zones)
    charge = [way for way in plan if has_flights(way)]
    if visits or _keep_apart(plan) or not charge:
        return dict.fromkeys(teams, 0)
    for loop in service_of([flight for way in charge for flight in flights_of(way)]).loops:
        _join(teams, loop.robots)
    for pad in plan.mission.chargers:
        users = [way.robot for way in charge if any(stay.charger == pad.name for stay in way.charges)]
        if len(users) > pad.places:
            _join(teams, users)
    _join_by_sight(plan, teams)
    return teams


def robots_waited_for(plan: Plan) -> frozenset[str]:
    """The names of robots for which others wait when they are late: all that do not charge, or relieve somebody.

    Others, as on circuits, are launched by themselves. In swarms, and where bodies are to be kept apart, all are waited
    for.
    """
    names = frozenset(way.robot for way in plan)
    if _keep_apart(plan):
        return names
    return names - {way.robot for way in plan if has_flights(way)} | robots_that_relieve(plan)


def _keep_apart(plan: Plan) -> bool:
    """Whether it matters to bodies, or to a swarm, how far each robot is."""
    bodies = any(plan.mission.fleet.robot(way.robot).body_radius_m > 0 for way in plan)
    return plan.mission.planning.makes_runs or bodies


def _join(teams: dict[str, int], names: Iterable[str]) -> None:
    """Make one team of all teams of these robots."""
    joined = {teams[name] for name in names}
    for name, team in teams.items():
        if team in joined:
            teams[name] = min(joined)


def _join_by_sight(plan: Plan, teams: dict[str, int]) -> None:
    """Make one team of those that see a place in time together alone."""
    places = places_of(plan.mission, MOST_PLACES)
    points_m = places.points_m[: places.points]
    while len(numbers := sorted(set(teams.values()))) > 1:
        own = [
            replace(plan, trajectories=tuple(way for way in plan if teams[way.robot] == k), seam=None) for k in numbers
        ]
        gaps_s = np.array([worst_gaps_s(each, points_m) for each in own])
        together = (gaps_s.min(axis=0) > places.periods_s[: places.points] * MET) & (
            np.isfinite(gaps_s).sum(axis=0) > 1
        )
        if not together.any():
            return
        seeing = {numbers[k] for k in np.flatnonzero((gaps_s[:, together] < math.inf).any(axis=1))}
        _join(teams, [name for name, team in teams.items() if team in seeing])
