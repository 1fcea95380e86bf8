"""The air between robots' processes, in one process and by a clock that only tests move: the same for each seed."""

from __future__ import annotations

import heapq
import itertools
import random
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import shapely

from rota.model.fleet import DiscSensor, Fleet, Robot, StartBox
from rota.model.mission import Mission
from rota.planners.swarm.nodes.node import RobotNode
from rota.planners.swarm.nodes.scene import Scene
from rota.planners.swarm.nodes.telling import Telling, read_telling
from rota.planners.swarm.planner_settings import SwarmSettings

TICK, ARRIVAL = 1, 0
S = 1_000_000_000


def mission_of(
    count: int, side_m: float, box_m: tuple[float, float], *, sensor_m: float, speed_m_s: float, **settings: Any
) -> Mission:
    """Equal robots with discs and bodies of 0.5 m that start in a box within a square."""
    like = {"sensor": DiscSensor(radius_m=sensor_m), "speed_m_s": speed_m_s, "body_radius_m": 0.5}
    robots = tuple(Robot(name=f"robot-{k + 1}", **like) for k in range(count))
    (low, high) = box_m
    return Mission(
        name="square",
        area=shapely.MultiPolygon([shapely.box(0, 0, side_m, side_m)]),
        fleet=Fleet(robots=robots, start=StartBox(low_m=(low, low), high_m=(high, high)), **like),
        planning=SwarmSettings(**{"time_step_s": 0.1, **settings}),
    )


@dataclass
class Air:
    """Robots that tick at their own times, and messages between them that come late, twice, out of order, or never.

    A message takes up to ``delay_s``; each is lost with the probability ``lost``, of which no more than
    ``lost_in_row`` on the same way in a row. A tick comes up to ``jitter_s`` late and, once in ``stall_every`` ticks,
    up to ``stall_s``. ``clocks``: of each robot, by number, the nanoseconds that its clock is ahead, and the share by
    which it is fast; they read news when they arrive. ``told`` is by the true clock.
    """

    scene: Scene
    seed: int
    delay_s: float = 0.0
    lost: float = 0.0
    lost_in_row: int = 2
    jitter_s: float = 0.002
    stall_s: float = 0.0
    stall_every: int = 50
    periods_ns: tuple[int, ...] = ()
    clocks: tuple[tuple[int, float], ...] = ()
    now_ns: int = 0
    begin_ns: int = 0
    nodes: dict[int, RobotNode] = field(default_factory=dict)
    told: dict[int, list[Telling]] = field(default_factory=dict)
    events: list[tuple[int, int, int, int, object]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._random = random.Random(self.seed)
        self._order = itertools.count()
        self._row: dict[tuple[int, int], int] = {}
        self._inbox: dict[int, list[bytes]] = {}
        self.begin_ns = 3 * self.scene.silent_ns + S // 10

    def start(self, robot: int) -> None:
        """Start the process of a robot, now or within a hold."""
        period_ns = self.periods_ns[robot % len(self.periods_ns)] if self.periods_ns else None
        began_ns, begin_ns = self._shown(robot, self.now_ns), self._shown(robot, self.begin_ns)
        self.nodes[robot] = RobotNode(self.scene, robot, began_ns=began_ns, begin_ns=begin_ns, period_ns=period_ns)
        self._inbox[robot] = []
        self._at(self.now_ns + self._random.randrange(self.scene.period_ns), TICK, robot, self.nodes[robot])

    def kill(self, robot: int) -> None:
        """End a robot's process at once; nobody is told."""
        del self.nodes[robot]

    def run_until(self, time_s: float) -> None:
        """Let time go by, up to so long after the begin."""
        end_ns = self.begin_ns + round(time_s * S)
        while self.events and self.events[0][0] <= end_ns:
            self.now_ns, kind, _, robot, what = heapq.heappop(self.events)
            if kind == ARRIVAL:
                if not self.clocks:
                    self._inbox[robot].append(what)
                elif robot in self.nodes:
                    self.nodes[robot].hear([what], self._shown(robot, self.now_ns))
            elif self.nodes.get(robot) is what:
                self._tick(robot)
        self.now_ns = end_ns

    def _tick(self, robot: int) -> None:
        node, datagrams = self.nodes[robot], self._inbox[robot]
        self._inbox[robot] = []
        datagram = node.tick(self._shown(robot, self.now_ns), datagrams)
        if datagram is not None:
            telling = read_telling(datagram, self.scene.number)
            assert telling is not None
            hold_ns = self._true(robot, telling.end_ns) - self.now_ns
            self.told.setdefault(robot, []).append(telling._replace(told_ns=self.now_ns, hold_ns=hold_ns))
            for other in self.nodes:
                if other != robot:
                    self._send(robot, other, datagram)
        if node.has_left:
            return
        stalls = self.stall_s > 0 and self._random.randrange(self.stall_every) == 0
        late_s = self._random.random() * (self.stall_s if stalls else self.jitter_s)
        next_ns = self.now_ns + self.scene.period_ns if node.next_ns is None else self._true(robot, node.next_ns)
        self._at(next_ns + round(late_s * S), TICK, robot, node)

    def _shown(self, robot: int, time_ns: int) -> int:
        """What a robot's clock shows at a time."""
        ahead_ns, fast = self.clocks[robot] if self.clocks else (0, 0.0)
        return time_ns + ahead_ns + round(fast * time_ns)

    def _true(self, robot: int, shown_ns: int) -> int:
        """The first time at which a robot's clock shows that."""
        ahead_ns, fast = self.clocks[robot] if self.clocks else (0, 0.0)
        time_ns = round((shown_ns - ahead_ns) / (1 + fast)) - 2
        while self._shown(robot, time_ns) < shown_ns:
            time_ns += 1
        return time_ns

    def _send(self, robot: int, other: int, datagram: bytes) -> None:
        way = (robot, other)
        if self._random.random() < self.lost and self._row.get(way, 0) < self.lost_in_row:
            self._row[way] = self._row.get(way, 0) + 1
            return
        self._row[way] = 0
        for _ in range(1 + (self._random.random() < 0.1)):
            self._at(self.now_ns + round(self._random.random() * self.delay_s * S), ARRIVAL, other, datagram)

    def _at(self, time_ns: int, kind: int, robot: int, what: object) -> None:
        heapq.heappush(self.events, (time_ns, kind, next(self._order), robot, what))

    def places_at(self, time_s: float) -> np.ndarray:
        """(n, 2): where the robots that have told anything are so long after the begin, by number."""
        time_ns = self.begin_ns + round(time_s * S)
        return np.array(
            [
                next(t for t in reversed(self.told[robot]) if t.told_ns <= time_ns).place_at(time_ns)
                for robot in sorted(self.told)
            ]
        )

    def least_gap_m(self) -> float:
        """The least distance between the rims of any two bodies at any moment, in closed form between all events."""
        times = np.unique([t for told in self.told.values() for one in told for t in (one.told_ns, one.end_ns)])
        robots = sorted(self.told)
        begins, ends = np.empty((2, len(robots), len(times) - 1, 2))
        for k, robot in enumerate(robots):
            told = self.told[robot]
            which = np.searchsorted([one.told_ns for one in told], times, side="right") - 1
            at = [told[max(w, 0)].place_at(int(t)) for w, t in zip(which, times, strict=True)]
            begins[k] = at[:-1]
            # the end of a stretch as the telling of its beginning has it: one that joins again appears elsewhere
            ends[k] = [told[max(w, 0)].place_at(int(t)) for w, t in zip(which[:-1], times[1:], strict=True)]
        bodies = [self.told[robot][0].body_m for robot in robots]
        least = np.inf
        for a, b in itertools.combinations(range(len(robots)), 2):
            p, q = begins[a] - begins[b], ends[a] - ends[b]
            way = q - p
            along = np.clip(-(p * way).sum(1) / np.maximum((way**2).sum(1), 1e-300), 0, 1)
            least = min(least, np.hypot(*(p + along[:, None] * way).T).min() - bodies[a] - bodies[b])
        return float(least)
