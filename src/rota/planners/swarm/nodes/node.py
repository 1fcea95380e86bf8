"""One robot of a swarm on its own: it hears, decides by the same functions as the simulation, goes, and tells."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from rota.errors import MissionError
from rota.planners.swarm.deciding import deciding_room
from rota.planners.swarm.delayed_news_kernels import MOST_SPEED_GAIN, no_faster
from rota.planners.swarm.filter_kernels import ROUNDING_M, filter_velocities
from rota.planners.swarm.free_ground_kernels import load_with_all, pass_on_distances
from rota.planners.swarm.kernels import cell_of
from rota.planners.swarm.nodes.hearing import Hearing, Known
from rota.planners.swarm.nodes.scene import HOLD_SHARE, LEAST_SILENT_PERIODS, Scene
from rota.planners.swarm.nodes.telling import LEFT, MEMBER, MOST_COUNTED, WAITING, Telling, write_telling
from rota.planners.swarm.state import Decisions, Grid, Kinds, Moving, Robots, Rule, Snapshot
from rota.planners.swarm.world import moving_at

CLIMB_TRIES, SLOWER = 20, 1 - 1e-6  # on ground that is no steeper farther on the second try is slow enough


class RobotNode:
    """A robot, by its number in the fleet; ``tick`` is all that it does, and nothing in here waits or sends.

    It listens first, for twice as long as makes others forget. As soon as its start has room it stands there and
    announces itself. At ``begin_ns`` plus the time at which the mission lets it join it takes part. One that was held
    up for half as long as makes others forget begins with announcing itself again.

    began_ns: when it began to listen. period_ns: the time between its decisions (None: the mission's time step).
    ``in_the_way``: the robots that keep it from joining, since their bodies may be where it starts. ``busy_us``:
    processor time of its last tick, which who calls it may set.
    """

    def __init__(
        self, scene: Scene, robot: int, *, began_ns: int, begin_ns: int | None = None, period_ns: int | None = None
    ) -> None:
        robots = scene.mission.fleet.robots or ()
        if not 0 <= robot < len(robots):
            raise MissionError(f"robot: number {robot} is not allowed; the fleet has 0 to {len(robots) - 1}")
        period_ns = scene.period_ns if period_ns is None else period_ns
        if LEAST_SILENT_PERIODS * period_ns > scene.silent_ns:
            raise MissionError(
                f"rate: {1e9 / period_ns:.6g} Hz is not allowed: who is silent for {scene.silent_ns * 1e-9:.6g} s is"
                f" forgotten; at least {LEAST_SILENT_PERIODS * 1e9 / scene.silent_ns:.6g} Hz are needed"
            )
        self._scene, self.robot, self._period_ns, self._hold_ns = scene, robot, period_ns, round(HOLD_SHARE * period_ns)
        self._due_ns: int | None = None
        self._own, self._spec = scene.own_kind(robot), robots[robot]
        starts = scene.starts
        self._hearing = Hearing(
            starts, robot, scene.number, silent_ns=scene.silent_ns, clock_error_ns=scene.clock_error_ns,
            own_clocks=scene.own_clocks, radio_m=scene.radio_m,
        )  # fmt: skip
        self._belief = Belief(self._own, robot, len(robots), scene.grid, scene.rule(self._hold_ns), scene.decide)
        self._place_m = starts[robot].x, starts[robot].y
        self._listen_until_ns = began_ns + 2 * scene.silent_ns
        self._begin_ns = self._listen_until_ns + scene.silent_ns if begin_ns is None else begin_ns
        self._announced_ns: int | None = None
        self._left_ns: int | None = None
        self._leaving = False
        self._told: Telling | None = None
        self._steps = 0
        self.in_the_way: tuple[int, ...] = ()
        self.busy_us = 0

    @property
    def next_ns(self) -> int | None:
        """The time of the next tick, no sooner than the last decision's hold is over; None: any."""
        return None if self._told is None or self._due_ns is None else max(self._told.end_ns, self._due_ns)

    @property
    def dropped(self) -> int:
        """How many datagrams held no telling of the swarm."""
        return self._hearing.dropped

    def leave(self) -> None:
        """Let it leave at the next tick."""
        self._leaving = True

    @property
    def has_left(self) -> bool:
        """Whether it has left and told so for long enough to be heard, or nobody knows of it."""
        if self._told is None:
            return self._leaving
        return self._left_ns is not None and self._told.told_ns - self._left_ns >= self._scene.silent_ns

    def hear(self, datagrams: Iterable[bytes], now_ns: int) -> None:
        """Hear what has arrived by now; between ticks where it matters how soon news are read."""
        place = self._place_m if self._told is None else self._told.place_at(now_ns)
        self._hearing.hear(datagrams, now_ns, place)

    def tick(self, now_ns: int, datagrams: Iterable[bytes]) -> bytes | None:
        """Hear what has arrived, decide, and return what to tell all others; None while it only listens.

        Not to be called before ``next_ns``.
        """
        self.hear(datagrams, now_ns)
        if now_ns < self._listen_until_ns or not self._is_announced(now_ns):
            return None
        velocity, state = (0.0, 0.0), self._state(now_ns)
        if self._told is not None:
            self._place_m = self._told.place_at(self._told.end_ns)
        if state == MEMBER:
            velocity = self._decision(now_ns)
        self._told = self._telling(now_ns, state, velocity)
        self._steps += 1
        # on time again after a late tick, where the hold leaves room for it
        on_time = self._due_ns is not None and now_ns - self._due_ns < self._period_ns
        self._due_ns = (self._due_ns if on_time and self._due_ns is not None else now_ns) + self._period_ns
        return write_telling(self._told, self._scene.number)

    def _is_announced(self, now_ns: int) -> bool:
        """Whether it may tell of itself, from when its start has room on; notes when it began to, last."""
        if self._told is None:
            self.in_the_way = tuple(self._who_is_at_start(now_ns))
            if self.in_the_way:
                return False
            self._announced_ns = now_ns
        elif now_ns - self._told.told_ns > self._scene.silent_ns // 2:
            self._announced_ns = now_ns
        return True

    def _who_is_at_start(self, now_ns: int) -> Iterable[int]:
        """The robots whose bodies are where this one's would be.

        Who stood clear of it when it told something still does: all keep clear of the starts of those they do not hear.
        """
        x, y = self._place_m
        for other in self._known_bodies(now_ns):
            if math.hypot(other.x - x, other.y - y) < float(self._own.body_m[0]) + other.body_m - ROUNDING_M:
                yield other.robot

    def _known_bodies(self, now_ns: int) -> list[Known]:
        """All bodies to reckon with while the next decision holds."""
        return self._hearing.known_bodies(now_ns, now_ns + self._hold_ns)

    def _state(self, now_ns: int) -> int:
        """Whether it waits, takes part or has left."""
        leaves_s = self._spec.leaves_s
        if self._leaving or (leaves_s is not None and now_ns + self._hold_ns > self._begin_ns + leaves_s * 1e9):
            self._left_ns = now_ns if self._left_ns is None else self._left_ns
            return LEFT
        assert self._announced_ns is not None
        joins_ns = self._begin_ns + self._spec.joins_s * 1e9
        announced = now_ns - self._announced_ns >= self._scene.silent_ns + self._scene.clock_error_ns
        return MEMBER if announced and now_ns >= joins_ns else WAITING

    def _decision(self, now_ns: int) -> tuple[float, float]:
        """The velocity for the next hold."""
        told = self._told
        last = (told.vx, told.vy) if told is not None else (0.0, 0.0)
        since_s = (now_ns - self._begin_ns) * 1e-9
        moving = moving_at(self._scene.mission.moving_obstacles, since_s, self._hold_ns * 1e-9)
        vx, vy = self._belief.decision(self._place_m, last, self._known_bodies(now_ns), moving, self._steps)
        share = self._share_climbing(vx, vy)
        return share * vx, share * vy

    def _share_climbing(self, vx: float, vy: float) -> float:
        """The share of a velocity at which the robot, climbing with the ground, is no faster than it can be.

        The last filter allows every share of what it allows.
        """
        ground_m, (x, y), hold_s = self._scene.ground_m, self._place_m, self._hold_ns * 1e-9
        top, share, here_m = float(self._own.speed_m_s[0]), 1.0, ground_m(*self._place_m)
        for _ in range(CLIMB_TRIES):
            climb = (ground_m(x + share * vx * hold_s, y + share * vy * hold_s) - here_m) / hold_s
            speed = math.hypot(share * vx, share * vy, climb)
            if speed <= top:
                return share
            share *= SLOWER * top / speed
        return 0.0

    def _telling(self, now_ns: int, state: int, velocity: tuple[float, float]) -> Telling:
        """What it tells of itself now."""
        x, y = self._place_m
        body_m, sensor_m, speed_m_s = (
            float(values[0]) for values in (self._own.body_m, self._own.sensor_m, self._own.speed_m_s)
        )
        height_m = self._scene.ground_m(x, y) + self._scene.mission.fleet.altitude_m
        dropped, busy_us = (min(count, MOST_COUNTED) for count in (self._hearing.dropped, self.busy_us))
        return Telling(
            state, self.robot, self._steps % (MOST_COUNTED + 1), dropped, busy_us, now_ns, self._hold_ns, x, y,
            height_m, *velocity, body_m, sensor_m, speed_m_s,
        )  # fmt: skip


class Belief:
    """Room for one robot's decision: itself and whatever it knows of, all in the cell of the grid that it stands in.

    own: what it is like, kinds of one row. Robots are as many as the fleet has at most, and their starts.
    """

    def __init__(
        self, own: Kinds, number: int, fleet: int, grid: Grid, rule: Rule, decide: Callable[..., None]
    ) -> None:
        most = 2 * fleet
        self._own, self._number, self._rule, self._decide = own, number, rule, decide
        x, y, vx, vy, self._reach_m = np.zeros((5, most))
        self._robots = Robots(x, y, vx, vy, np.arange(most), np.zeros(most, np.int64), 1)
        self._kinds = Kinds(*np.zeros((len(Kinds._fields), most)))
        self._grid = grid._replace(start=np.zeros_like(grid.start))
        self._out = Decisions(np.zeros(1), np.zeros(1), np.zeros(1))
        self._room = deciding_room(rule)
        self._members: frozenset[int] = frozenset()
        self._last_change = 0

    def decision(
        self, place: tuple[float, float], last: tuple[float, float], known: Sequence[Known], moving: Moving, step: int
    ) -> tuple[float, float]:
        """The velocity that the swarm's controller and its last filter give a robot at a place.

        last: the velocity that it went with. known: neighbours first, then mere bodies.
        """
        robots, widest_m = self._fill(place, last, known)
        members = frozenset(other.robot for other in known if other.is_member)
        if members != self._members or moving.vx.any() or moving.vy.any():
            self._members, self._last_change = members, step
        rule = self._rule._replace(last_change=self._last_change)
        snapshot = Snapshot(step, robots, self._kinds, self._grid, moving, rule)
        graph = self._grid.place_graph
        if len(graph.x):
            load_with_all(robots._replace(x=robots.x[: len(known) + 1]), self._kinds, graph)
            pass_on_distances(step, graph)
        cell = self._stand_in_cell(place, len(known) + 1)
        self._decide(0, 1, snapshot, self._out, self._room)
        filter_velocities(0, 1, snapshot, widest_m, self._reach_m, self._out, self._room)
        self._stand_in_cell(place, 0, cell)
        speed = float(np.hypot(*last)) + MOST_SPEED_GAIN * float(self._own.speed_m_s[0])
        vx, vy = no_faster(float(self._out.vx[0]), float(self._out.vy[0]), speed)
        return float(vx), float(vy)

    def _fill(
        self, place: tuple[float, float], last: tuple[float, float], known: Sequence[Known]
    ) -> tuple[Robots, float]:
        """The arrays with the robot itself in the first row, and how far off the filter must look."""
        robots, kinds, own = self._robots, self._kinds, self._own
        time_step_s = self._rule.time_step_s
        robots.x[0], robots.y[0], robots.vx[0], robots.vy[0] = *place, *last
        robots.name[0] = self._number
        for values, value in zip(kinds, own, strict=True):
            values[0] = value[0]
        members, widest_m = 1, float(own.body_m[0] + own.speed_m_s[0] * time_step_s)
        for k, other in enumerate(known, 1):
            robots.x[k], robots.y[k], robots.vx[k], robots.vy[k] = other.x, other.y, other.vx, other.vy
            robots.name[k] = other.robot
            kinds.body_m[k], kinds.sensor_m[k], kinds.speed_m_s[k] = other.body_m, other.sensor_m, other.speed_m_s
            kinds.wall_range_m[k] = own.wall_range_m[0]
            self._reach_m[k] = other.reach_m
            members += other.is_member
            widest_m = max(widest_m, other.body_m + other.speed_m_s * time_step_s + other.reach_m)
        return robots._replace(member_kinds=members), widest_m

    def _stand_in_cell(self, place: tuple[float, float], count: int, cell: int | None = None) -> int:
        """Let the first ``count`` robots be all that stands in the place's cell and beside it; returns the cell."""
        c = int(cell_of(*place, self._grid)) if cell is None else cell
        start, stride = self._grid.start, self._grid.columns + 2
        start[c - stride - 1], start[c - stride + 2] = 0, 0
        start[c - 1], start[c + 2] = 0, count
        start[c + stride - 1], start[c + stride + 2] = count, count
        return c
