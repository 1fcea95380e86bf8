"""A super-period of a swarm: turn by turn robots charge and rejoin, and in the end all are where they began."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rota.errors import NoPlanFound
from rota.model.arrays import Flags, Floats, Ints
from rota.model.mission import Mission
from rota.planners.swarm.charging.ways import Ways
from rota.planners.swarm.rollout import Swarm
from rota.planners.swarm.trajectory_log import TrajectoryLog

MEMBER, OUT, DOCKED, OFF, HOME = range(5)  # takes part; on its way; charges; leaves its charger; goes to its place
KEEP_SHARE, KEEP_M = 2.2, 1e-3  # of the widest body, and more: what all others keep off a charger by
THERE_M = 1e-7  # from its target, a robot is there
PATIENCE = 2.0  # super-periods after which one that has not ended is given up


def keep_m(body_m: float) -> float:
    """What all others keep off a charger by, where no body is wider: those at its rim and middle are apart."""
    return KEEP_SHARE * body_m + KEEP_M


@dataclass(frozen=True, kw_only=True, eq=False)
class Schedule:
    """The turns of a super-period in steps: which robot of the fleet leaves for which charger when, and until when it

    stays there, (L,) each; after how many steps all repeats. ready: steps before it, for those to come to their
    chargers that begin there, and for the others to close the gap. home: steps at the end in which all come home.
    """

    robot: Ints
    charger: Ints
    leaves: Ints
    until: Ints
    period: int
    ready: int
    home: int

    @property
    def begins_there(self) -> Ints:
        """The turns whose robots are at their chargers where the super-period begins and ends."""
        return np.flatnonzero(self.until >= self.period)


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """What a super-period came to, in steps of the swarm: its begin and its end, and the stays at chargers.

    stays (k, 4): robot, charger, from and until. came (L,): when the robot of each turn came, in steps from the begin.
    """

    begin: int
    end: int
    stays: Ints
    came: Ints


class SuperPeriod:
    """A super-period from where a swarm has spread to; ``run`` moves the swarm on and logs all places."""

    def __init__(self, mission: Mission, swarm: Swarm, log: TrajectoryLog, schedule: Schedule, ways: Ways) -> None:
        n = len(swarm)
        self._robots, self._swarm, self._log, self._ways = mission.fleet.robots or (), swarm, log, ways
        self._schedule, self._begin = schedule, swarm.steps
        self._places_m, self._posts_m, self._left_m = swarm.places_m, swarm.places_m, swarm.places_m
        self._state, self._charger, self._turn = np.full(n, MEMBER), np.full(n, -1), np.full(n, -1)
        self._until = np.zeros(n, np.int64)
        self._room = np.array([charger.places for charger in mission.chargers])
        self._came = np.full(len(schedule.robot), -1, np.int64)
        self._docked_at = np.zeros(n, np.int64)
        self._stays: list[tuple[int, int, int, int]] = []
        assert swarm.guide is not None
        self._guide = swarm.guide
        self._corners_m: list[list[Floats]] = [[] for _ in range(n)]

    @property
    def _step(self) -> int:
        return self._swarm.steps - self._begin

    def run(self, on_step: Callable[[], None]) -> Outcome:
        """Move on until all are where the super-period began; raises NoPlanFound where somebody never comes there.

        on_step: called at each step; what it raises ends the run.
        """
        schedule, there = self._schedule, self._schedule.begins_there
        self._go_out(there)
        while self._step < schedule.ready or (self._state == OUT).any():
            self._move_on(on_step, PATIENCE * schedule.period)
        self._begin_round()
        while self._step < schedule.period or not self._is_round_over():
            due = np.flatnonzero(schedule.leaves == self._step)
            self._go_out(due)
            if self._step >= schedule.period - schedule.home:
                ready = np.flatnonzero(self._state == MEMBER)
                self._send(ready, HOME, self._posts_m[ready])
            self._move_on(on_step, PATIENCE * schedule.period)
        self._note_stays(np.flatnonzero(self._state == DOCKED))
        stays = np.array(sorted(self._stays, key=lambda stay: (stay[0], stay[2])), np.int64).reshape(-1, 4)
        return Outcome(begin=self._begin, end=self._swarm.steps, stays=stays, came=self._came)

    def _begin_round(self) -> None:
        """Begin the super-period here and now: in its end all must be where they are, and charge where they do."""
        self._note_stays(np.flatnonzero(self._state == DOCKED))
        self._begin, there = self._swarm.steps, self._schedule.robot[self._schedule.begins_there]
        self._until[there] -= self._schedule.period
        self._log.keep_last()
        self._posts_m = self._log.recent_m[-1].copy()

    def _is_round_over(self) -> bool:
        """Whether all are at home, or at the chargers at which they began."""
        there = np.zeros(len(self._state), np.bool_)
        there[self._schedule.robot[self._schedule.begins_there]] = True
        return bool(np.where(there, self._state == DOCKED, self._at_home()).all())

    def _go_out(self, turns: Ints) -> None:
        """Send the robots of these turns to their chargers."""
        robots = self._schedule.robot[turns]
        self._turn[robots], self._until[robots] = turns, self._schedule.until[turns]
        self._charger[robots] = self._schedule.charger[turns]
        self._left_m[robots] = self._places_m[robots]
        self._send(robots, OUT, self._guide.pads_m[self._charger[robots]])

    def _move_on(self, on_step: Callable[[], None], most: float) -> None:
        """One step of all."""
        on_step()
        if self._step > most:
            raise NoPlanFound(self._stuck_text())
        for q in range(len(self._room)):
            if not (self._guide.may_enter == q).any():
                self._open_pad(q)
        self._swarm.step()
        self._places_m = self._swarm.places_m
        self._follow_ways()
        changed = self._end_ways()
        self._log.add(self._told_m())
        if changed:
            self._log.keep_last()

    def _note_stays(self, robots: Ints) -> None:
        """Note stays that end now, or where the super-period begins or ends."""
        now = self._swarm.steps
        self._log.keep_last()
        for k in robots.tolist():
            if self._docked_at[k] < now:
                self._stays.append((k, int(self._charger[k]), int(self._docked_at[k]), now))
                self._docked_at[k] = now

    def _open_pad(self, q: int) -> None:
        """Let one robot off a charger that nobody comes to or leaves; or, where it has a free place, one come to it."""
        docked = np.flatnonzero((self._state == DOCKED) & (self._charger == q))
        if (self._docked_at[docked] == self._swarm.steps).any():
            return  # who leaves now would meet who has come now
        until = self._until[docked]
        full = docked[(self._step >= until) & (until < self._schedule.period)]
        away_m = np.hypot(*(self._places_m - self._guide.pads_m[q]).T)
        bodies = self._state != DOCKED
        if len(full):
            # a body appears there
            if away_m[bodies].min(initial=np.inf) >= self._guide.keep_m * (1 - 1e-6):
                k = full[:1]
                self._guide.may_enter[k] = q
                self._note_stays(k)
                self._send(k, OFF, self._left_m[k])
            return
        coming = np.flatnonzero((self._state == OUT) & (self._charger == q))
        if len(coming) and len(docked) < self._room[q]:
            first = coming[np.argmin(away_m[coming])]
            step_m = self._robots[first].ground_speed_m_s * self._swarm.rule.time_step_s
            if away_m[first] <= self._guide.keep_m + 2 * step_m:
                self._guide.may_enter[first] = q

    def _send(self, numbers: Ints, state: int, to_m: Floats) -> None:
        """Send robots of these numbers (k,) to places (k, 2) by their shortest ways."""
        if not len(numbers):
            return
        for k, place_m in zip(numbers.tolist(), to_m, strict=True):
            self._corners_m[k] = list(self._ways.path_m(self._robots[k], self._places_m[k], place_m))
            self._guide.targets_m[k] = self._corners_m[k].pop(0)
        self._state[numbers] = state
        self._swarm.lead(numbers)

    def _follow_ways(self) -> None:
        """Lead those on that have come to a corner of their way."""
        away_m = np.hypot(*(self._guide.targets_m - self._places_m).T)
        for k in np.flatnonzero(away_m <= np.maximum(THERE_M, self._corner_m())):
            if self._corners_m[k]:
                self._guide.targets_m[k] = self._corners_m[k].pop(0)

    def _corner_m(self) -> float:
        """How near to a corner a robot has come to it: bodies are a little wider than the map takes them for."""
        return 0.5 * self._guide.keep_m

    def _end_ways(self) -> bool:
        """Dock those that have come to their chargers, let those take part that have left them; whether any docked."""
        away_m = np.hypot(*(self._guide.targets_m - self._places_m).T)
        enters = self._guide.may_enter
        docking = np.flatnonzero((self._state == OUT) & (enters >= 0) & (away_m <= THERE_M))
        if len(docking):
            self._swarm.leave(docking, bodies_stay=False)
            self._state[docking], self._docked_at[docking] = DOCKED, self._swarm.steps
            self._came[self._turn[docking]] = self._step
            enters[docking], self._guide.targets_m[docking] = -1, np.nan
        leaving = np.flatnonzero(((self._state == OFF) | (self._state == HOME)) & (enters >= 0))
        beyond = leaving[
            np.hypot(*(self._places_m[leaving] - self._guide.pads_m[enters[leaving]]).T) >= self._guide.keep_m
        ]
        enters[beyond] = -1
        free = beyond[self._state[beyond] == OFF]
        if len(free):
            self._swarm.lead(free, led=False)
            self._state[free], self._guide.targets_m[free] = MEMBER, np.nan
        return bool(len(docking))

    def _told_m(self) -> Floats:
        """Places (n, 2) as the plan has them: exactly at its charger is who charges, exactly at home who is there."""
        places = self._places_m.copy()
        docked = self._state == DOCKED
        places[docked] = self._guide.pads_m[self._charger[docked]]
        home = self._at_home()
        places[home] = self._posts_m[home]
        return places

    def _at_home(self) -> Flags:
        """Which robots (n,) have come home."""
        return np.asarray((self._state == HOME) & (np.hypot(*(self._places_m - self._posts_m).T) <= THERE_M))

    def _stuck_text(self) -> str:
        """Who is still on its way, and where."""
        late = np.flatnonzero(~self._at_home() & (self._state != DOCKED))
        k = int(late[np.argmax((self._state[late] == OUT) | (self._state[late] == HOME))])
        x, y = self._places_m[k]
        aim = "its charger" if self._state[k] in (OUT, DOCKED) else "its place"
        return (
            f"robot {self._robots[k].name} does not come to {aim}: it stands at ({x:.2f}, {y:.2f}) after"
            f" {self._step} steps; narrow ground, or others in its way, hold it up"
        )
