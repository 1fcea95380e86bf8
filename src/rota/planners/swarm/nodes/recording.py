"""What robots' processes tell, recorded: the way of each, coverage by time, and a plan of what was done."""

from __future__ import annotations

import functools
from array import array
from collections import deque
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from rota.errors import LinkError
from rota.model.mission import Mission, Robot
from rota.model.plan import EndReason, Plan, RunEnd, Trajectory
from rota.planners.swarm.deciding import Controller
from rota.planners.swarm.metrics import covered_share
from rota.planners.swarm.nodes.clocks import Clocks
from rota.planners.swarm.nodes.scene import Scene
from rota.planners.swarm.nodes.telling import LEFT, MEMBER, Telling, read_telling
from rota.planners.swarm.presence import holding_from_joining
from rota.planners.swarm.rest import blocked_robots, longest_rest_m
from rota.planners.swarm.rollout import Surroundings, Swarm
from rota.planners.swarm.sensing import sensors_of, squares_of
from rota.planners.swarm.sorted_robots import Beginning
from rota.planning.robot_processes import HeightAt, RobotRecord, SwarmRecord, level

REST_S = 2.0  # a swarm that has not moved for so long is at rest
KEPT = 16  # tellings of each robot, from which its place a moment ago is known
SAME_TIME_S = 1e-9


class Life:
    """What one robot told: the points of its way, straight between them, and numbers about its ticks."""

    def __init__(self, first: Telling, begin_ns: int) -> None:
        self._begin_ns = begin_ns
        self.times_s, self.places_m = [0.0], [(first.x, first.y)]
        self.recent: deque[Telling] = deque(maxlen=KEPT)
        self.busy_us = array("L")
        self.first, self.last, self.ticks, self.lost = first, first, 0, 0
        self.joined_s: float | None = None
        self.left_s: float | None = None
        self.again = False
        self.add(first)

    def add(self, telling: Telling) -> None:
        """The next telling; one of a second life, after its process had died, only counts as that."""
        if telling.tick < self.last.tick or self.again:
            self.again = True
            return
        self.lost += max(telling.tick - self.last.tick - 1, 0)
        self.ticks += 1
        self.busy_us.append(telling.busy_us)
        self.last = telling
        self.recent.append(telling)
        told_s = (telling.told_ns - self._begin_ns) * 1e-9
        if telling.state == MEMBER and self.joined_s is None:
            self.joined_s = max(told_s, 0.0)
        if telling.state == LEFT and self.left_s is None:
            self.left_s = told_s
        if telling.vx != 0.0 or telling.vy != 0.0:
            self._note(told_s, (telling.x, telling.y))
            self._note((telling.end_ns - self._begin_ns) * 1e-9, telling.place_at(telling.end_ns))

    def _note(self, time_s: float, place: tuple[float, float]) -> None:
        """Add a point; at the time of the last one, it takes its place."""
        if time_s > self.times_s[-1] + SAME_TIME_S:
            self.times_s.append(time_s)
            self.places_m.append(place)
        elif len(self.times_s) > 1:
            self.places_m[-1] = place

    def place_at(self, time_ns: int) -> tuple[float, float]:
        """Where it was at a time a moment ago."""
        for telling in reversed(self.recent):
            if telling.told_ns <= time_ns:
                return telling.place_at(time_ns)
        return self.recent[0].x, self.recent[0].y

    def trajectory(self, name: str, height_at: HeightAt | None) -> Trajectory:
        """Its way, at heights where these are told; at the end it holds."""
        times_s, places_m = np.array(self.times_s), np.array(self.places_m)
        if height_at is not None:
            places_m = np.column_stack([places_m, [height_at(x, y) for x, y in self.places_m]])
        return Trajectory(robot=name, times_s=times_s, positions_m=places_m, loop_start_s=float(times_s[-1]))


class Recorder:
    """Takes in all robots' datagrams; the time of everything recorded counts from ``begin_ns``, when all begin.

    Robots that the mission does not know, and datagrams without a telling, are counted in ``dropped``. Nothing is
    recorded of what was later than ``until_ns``, however late it is heard.
    """

    def __init__(self, scene: Scene, begin_ns: int, every_s: float = 1.0, until_ns: int | None = None) -> None:
        self._until_ns = until_ns
        self._scene, self._begin_ns, self._every_ns = scene, begin_ns, round(every_s * 1e9)
        self._robots = scene.mission.fleet.robots or ()
        self._lives: dict[int, Life] = {}
        self._clocks = Clocks(shared=not scene.own_clocks)
        self._sensors_m, self._squares = sensors_of(scene.mission), squares_of(scene.mission)
        self._rest_m = functools.cache(lambda hold_ns: longest_rest_m(scene.mission, hold_ns * 1e-9))
        self._quiet_since_ns: int | None = None
        self._blocked: tuple[int | None, tuple[str, ...]] = (None, ())
        self.coverage: list[tuple[float, float, int]] = []
        self.dropped = 0

    def hear(self, datagrams: Iterable[bytes], now_ns: int) -> None:
        """Take in what has arrived by now, and measure coverage where it is due."""
        for datagram in datagrams:
            telling = read_telling(datagram, self._scene.number)
            if telling is None or telling.robot >= len(self._robots):
                self.dropped += 1
                continue
            self._clocks.hear(telling, now_ns)
            telling = self._clocks.own(telling)
            if self._until_ns is not None and telling.told_ns > self._until_ns:
                continue
            if telling.robot not in self._lives:
                self._lives[telling.robot] = Life(telling, self._begin_ns)
            elif telling.told_ns > self._lives[telling.robot].last.told_ns:
                self._lives[telling.robot].add(telling)
        # a hold later all have told where they were then
        while (due_ns := self._begin_ns + len(self.coverage) * self._every_ns) + 2 * self._scene.period_ns <= now_ns:
            if self._until_ns is not None and due_ns > self._until_ns:
                break
            self._measure(due_ns)
        alive = self._alive(now_ns)
        quiet = bool(alive) and now_ns >= self._begin_ns and all(self._rests(self._lives[k].last) for k in alive)
        self._quiet_since_ns = (self._quiet_since_ns or now_ns) if quiet else None

    def _rests(self, telling: Telling) -> bool:
        """Whether a robot took part and went no farther than the mission's stop rule allows."""
        way_m = float(np.hypot(telling.vx, telling.vy)) * telling.hold_ns * 1e-9
        return telling.state != MEMBER or way_m <= self._rest_m(telling.hold_ns)

    def quiet_s(self, now_ns: int) -> float:
        """For how long no robot has moved."""
        return 0.0 if self._quiet_since_ns is None else (now_ns - self._quiet_since_ns) * 1e-9

    def is_at_rest(self, now_ns: int) -> bool:
        """Whether no robot has moved for ``REST_S``, and nobody will: all who want to go on have heard where to."""
        quiet_s = self.quiet_s(now_ns)
        if quiet_s < REST_S:
            return False
        news_ns = self._scene.grid.place_graph.news_steps * max(life.last.hold_ns for life in self._lives.values())
        return quiet_s >= REST_S + news_ns * 1e-9 or not self._blocked_robots(now_ns)

    def _blocked_robots(self, now_ns: int) -> tuple[str, ...]:
        """The robots that want to go on and stand, by ``blocked_robots``; asked once for each time that all stand."""
        since_ns = self._quiet_since_ns
        if since_ns is not None and self._blocked[0] != since_ns:
            self._blocked = since_ns, blocked_robots(self._swarm_at(now_ns), self._scene.mission)
        return self._blocked[1]

    def _swarm_at(self, now_ns: int) -> Swarm:
        """The robots that take part, where they stand, as the simulation has them; to be asked what they want."""
        scene = self._scene
        there = [k for k in self._alive(now_ns) if self._lives[k].last.state == MEMBER]
        hold_ns = max((self._lives[k].last.hold_ns for k in there), default=scene.period_ns)
        places_m = scene.starts_m.copy()
        for k in there:
            places_m[k] = self._lives[k].place_at(now_ns)
        # all news have come by then, as robots see it
        beginning = Beginning(places_m, steps=scene.grid.place_graph.news_steps)
        controller = Controller(scene.decide, scene.rule(hold_ns))
        swarm = Swarm(beginning, scene.fleet, Surroundings(scene.grid.walls), controller)
        swarm.leave(np.setdiff1d(np.arange(len(self._robots)), there), bodies_stay=False)
        swarm.learn_of_free_ground()
        return swarm

    def _alive(self, now_ns: int) -> list[int]:
        """The robots that have been heard lately and have not left."""
        return [
            k
            for k, life in sorted(self._lives.items())
            if life.last.state != LEFT and not life.again and now_ns - life.last.told_ns <= self._scene.silent_ns
        ]

    def _measure(self, time_ns: int) -> None:
        """Coverage at a time, of those that took part then."""
        by_s = (time_ns - self._begin_ns + self._scene.period_ns) * 1e-9
        there = [
            k for k in self._alive(time_ns) if (joined_s := self._lives[k].joined_s) is not None and joined_s <= by_s
        ]
        share = 0.0
        if there:
            places = np.array([self._lives[k].place_at(time_ns) for k in there])
            share = covered_share(places, self._sensors_m[there], self._scene.mission.area, self._squares[there])
        self.coverage.append(((time_ns - self._begin_ns) * 1e-9, share, len(there)))

    def record(self, end_ns: int, *, stopped: bool) -> SwarmRecord:
        """All that was heard by ``end_ns``, when the record ends; LinkError where nobody was heard.

        stopped: whether it was ended before all were at rest. Robots that were never heard are left out of the plan's
        fleet; those that fell silent left it when their last hold was over.
        """
        if not self._lives:
            raise LinkError("no robot was heard, so that there is nothing to record")
        mission = self._mission_done(end_ns)
        names = {robot.name: k for k, robot in enumerate(self._robots)}
        lives = [self._lives[names[robot.name]] for robot in mission.fleet.robots or ()]
        trajectories = tuple(
            life.trajectory(robot.name, self._height_at())
            for life, robot in zip(lives, mission.fleet.robots or (), strict=True)
        )
        blocked = () if stopped else self._blocked_robots(end_ns)
        reason: EndReason = "stopped" if stopped else "blocked" if blocked else "rest"
        steps = max(life.last.tick for life in lives)
        end = RunEnd(at_rest=reason == "rest", steps=steps, reason=reason, blocked=blocked)
        plan = Plan(
            mission=mission,
            trajectories=holding_from_joining(trajectories, mission),
            seed=self._scene.seed,
            run_end=end,
        )
        return SwarmRecord(
            plan=plan,
            coverage=tuple(self.coverage),
            robots=tuple(self._robot_record(k, end_ns) for k in sorted(self._lives)),
            warnings=tuple(self._warnings()),
        )

    def _height_at(self) -> HeightAt | None:
        """Where robots fly over a place; None over level ground, where a plan needs no heights."""
        ground_m, altitude_m = self._scene.ground_m, self._scene.mission.fleet.altitude_m
        return None if ground_m is level else lambda x, y: ground_m(x, y) + altitude_m

    def _mission_done(self, end_ns: int) -> Mission:
        """The mission with the robots that were heard, and when they really joined and left."""
        alive = set(self._alive(end_ns))
        mission = self._scene.mission
        robots = [self._robot_done(k, life, k in alive) for k, life in sorted(self._lives.items())]
        return replace(mission, fleet=replace(mission.fleet, robots=tuple(robots), start=None))

    def _robot_done(self, number: int, life: Life, alive: bool) -> Robot:
        """The robot with the start and the times of its life as they were recorded."""
        robot = self._robots[number]
        least_s = self._scene.period_ns * 1e-9
        joined_s = robot.joins_s if life.joined_s is None else life.joined_s
        if joined_s - robot.joins_s <= 2 * least_s:  # it ticks when it ticks
            joined_s = robot.joins_s
        left_s = life.left_s
        if left_s is None and not alive:
            left_s = (life.last.end_ns - self._begin_ns) * 1e-9
        left_s = None if left_s is None else max(left_s, joined_s + least_s)
        return replace(robot, start=life.places_m[0], joins_s=joined_s, leaves_s=left_s)

    def _robot_record(self, number: int, end_ns: int) -> RobotRecord:
        """What was recorded of a robot: its ticks, losses, rate, load and end."""
        life = self._lives[number]
        told_s = (life.last.told_ns - life.first.told_ns) * 1e-9
        end = "left" if life.last.state == LEFT else "runs" if number in self._alive(end_ns) else "silent"
        return RobotRecord(
            robot=self._robots[number].name,
            ticks=life.ticks,
            lost=life.lost,
            dropped=life.last.dropped,
            rate_hz=(life.last.tick - life.first.tick) / told_s if told_s > 0 else 0.0,
            busy_ms=tuple(us / 1000 for us in life.busy_us[1:]),
            end=end,
        )

    def _warnings(self) -> Iterable[str]:
        for k, robot in enumerate(self._robots):
            if k not in self._lives:
                yield f"{robot.name} was never heard: it is not in the plan"
            elif self._lives[k].again:
                yield f"{robot.name} came back after its process had ended: the plan has its first life only"
        if lost := sum(life.lost for life in self._lives.values()):
            yield f"{lost} tellings were lost on their way to the recorder: the plan goes straight across them"
