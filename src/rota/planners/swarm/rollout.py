"""A swarm that moves step by step: all robots decide from one snapshot, then all move."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rota.errors import CheckpointError, MissionError
from rota.mission import MovingObstacle
from rota.planners.swarm.cuda_step import CudaStep
from rota.planners.swarm.filter_kernels import filter_velocities
from rota.planners.swarm.hearing_kernels import NUMBER_OF, OWN, decide_heard, load_with_told
from rota.planners.swarm.kernels import Grid, Hearing, Kinds, Near, Robots, Rule, move_and_sort
from rota.planners.swarm.messages import Messages, most_unheard_m
from rota.planners.swarm.news_kernels import load_with_all, pass_on_news
from rota.planners.swarm.planner_settings import Device
from rota.planners.swarm.roads import roads_of
from rota.planners.swarm.settle_kernels import decide_settle
from rota.planners.swarm.velocity_set_kernels import MOST_CORNERS, Outline
from rota.planners.swarm.world import make_grid, moving_at, require_room, widest_m, with_absent

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
CHUNKS_PER_THREAD = 4  # so that a thread with an easy share takes another one
FEWEST_PER_CHUNK = 256
EXACT = np.empty(0)  # nobody has gone on unheard


class DecidingRoom(NamedTuple):
    """What one thread writes to while it decides."""

    near: Near
    outline: Outline
    spare: Outline


class Swarm:
    """n robots, their places and velocities; ``step`` moves them. The same on any number of threads, bit for bit.

    places_m: (n, 2) starts. kinds, kind: what robots are like, and which of it each robot is, (n,). walls: (m, 4)
    segments, at least one. decide: the controller's kernel; rule: what it reads. safe: whether the last filter is
    applied. moving: discs that do not give way. velocities_m_s: (n, 2) before the first step; None: at rest.

    hearing: what robots learn of each other; None: at every step where all others are. device: what decides, the
    processor or, "cuda", an NVIDIA GPU, to within rounding.

    Robots may leave and join between two steps; those that have left are nobody's neighbours any more.

    To go on with a run that was stopped after so many ``steps``: names (n,), the numbers in the fleet of those at
    places_m, in the order in which they stood in ``robots``, past and news_m, what ``past`` and ``news_m`` were.
    """

    def __init__(
        self,
        places_m: Floats,
        *,
        kinds: Kinds,
        kind: Ints,
        walls: Floats,
        decide: Callable[..., None],
        rule: Rule,
        safe: bool = True,
        moving: tuple[MovingObstacle, ...] = (),
        hearing: Hearing | None = None,
        device: Device = "cpu",
        velocities_m_s: Floats | None = None,
        names: Ints | None = None,
        steps: int = 0,
        past: Floats | None = None,
        news_m: Floats | None = None,
        threads: int = 1,
    ) -> None:
        n = len(places_m)
        speeds = np.zeros((n, 2)) if velocities_m_s is None else velocities_m_s
        names = np.arange(n, dtype=np.int64) if names is None else names.copy()
        self.steps = steps
        self.moving = moving
        unheard_m = 0.0 if hearing is None else most_unheard_m(hearing, kinds, rule.time_step_s)
        self.grid: Grid = make_grid(walls, kinds, n, rule.time_step_s, unheard_m)
        if decide is decide_settle:
            self.grid = self.grid._replace(roads=roads_of(walls, kinds))
        if news_m is not None:
            self.grid.roads.away_m[steps % 2] = _require_places(news_m, len(self.grid.roads.x))
        self.kinds, self.rule, self.safe = with_absent(kinds), rule, safe
        self._present_kind, self._member_kinds = kind.astype(np.int64), len(kinds.body_m)
        self._decide = decide
        x, y, vx, vy = (np.array(values, np.float64) for values in (*places_m.T, *speeds.T))
        self._robots = Robots(x, y, vx, vy, self._present_kind[names], names, self._member_kinds)
        self._spare = room_for(n, self._member_kinds)
        self._cell = np.empty(n, np.int64)
        self._nearest2 = np.empty(n)
        self._widest_m = widest_m(kinds, rule.time_step_s) + unheard_m
        self._threads = threads
        chunks = min(CHUNKS_PER_THREAD * threads, n // FEWEST_PER_CHUNK) if threads > 1 else 1
        self._cuts = [n * k // max(chunks, 1) for k in range(max(chunks, 1) + 1)]
        self._rooms = [deciding_room(rule) for _ in self._cuts[1:]]
        self._pool = ThreadPoolExecutor(threads) if len(self._cuts) > 2 else None
        self._device = None if device == "cpu" else CudaStep(decide, self.kinds, rule)
        if self._device is not None and hearing is not None:
            raise MissionError("swarm.device: cuda is for robots that know all at once; no delay_steps, messages_lost")
        self._messages = None
        if hearing is not None:
            step_m = kinds.speed_m_s[self._present_kind] * rule.time_step_s
            told = np.stack([self._in_order(x, y), self._in_order(vx, vy)])
            self._messages = Messages(hearing, step_m, told if past is None else past, len(self._rooms))
        self._sort(0.0)

    def __len__(self) -> int:
        return len(self._cell)

    @property
    def robots(self) -> Robots:
        """The state in the order of the grid; only to look at, and only until the next step."""
        return self._robots

    @property
    def sensors_m(self) -> Floats:
        """(n,) in the order of the fleet: each robot's sensor radius; 0 of one that takes no part."""
        values = np.empty(len(self))
        values[self._robots.name] = self.kinds.sensor_m[self._robots.kind]
        return values

    @property
    def past(self) -> Floats:
        """(h, 4, n): places and velocities that messages may still tell; none where everybody knows all."""
        return np.empty((0, 4, len(self))) if self._messages is None else self._messages.past.copy()

    @property
    def news_m(self) -> Floats:
        """(k,): how far it is to free ground from each place of the map, as told; of "settle" only, else k = 0."""
        return np.array(self.grid.roads.away_m[self.steps % 2])

    @property
    def present(self) -> NDArray[np.bool_]:
        """(n,) in the order of the fleet: whether each robot takes part."""
        values = np.empty(len(self), np.bool_)
        values[self._robots.name] = self._robots.kind < self._member_kinds
        return values

    def leave(self, numbers: ArrayLike, *, bodies_stay: bool = True) -> None:
        """Robots of these numbers in the fleet stop, see nothing more and are nobody's neighbours.

        Their bodies stay in the way of the others, unless they are said to vanish.
        """
        chosen = self._rows(numbers)
        absent = self._present_kind[self._robots.name[chosen]] + self._member_kinds
        self._robots.kind[chosen] = absent if bodies_stay else len(self.kinds.body_m) - 1
        self._robots.vx[chosen] = self._robots.vy[chosen] = 0.0

    def join(self, numbers: ArrayLike, places_m: ArrayLike | None = None) -> None:
        """Robots of these numbers in the fleet, absent so far, take part from the next step on, from where they are.

        places_m: (k, 2) where they appear instead. Raises MissionError where a body has no room between the others and
        the walls, or outside the walls; then nobody joins.
        """
        chosen = self._rows(numbers)
        robots, kinds = self._robots, self.kinds
        names = robots.name[chosen]
        if (robots.kind[chosen] < self._member_kinds).any():
            raise MissionError(f"robot {int(names[np.argmin(robots.kind[chosen])])}: takes part already")
        places = self.places_m[names]
        if places_m is not None:
            places = np.array(places_m, np.float64).reshape(len(chosen), 2)
        others = np.ones(len(self), np.bool_)
        others[chosen] = False
        # a body that has been there all the time has its room
        new = np.full(len(chosen), places_m is not None) | np.isinf(kinds.body_m[robots.kind[chosen]])
        others[chosen[~new]] = True
        require_room(
            names[new],
            places[new],
            kinds.body_m[self._present_kind[names[new]]],
            np.stack([robots.x[others], robots.y[others]], axis=1),
            kinds.body_m[robots.kind[others]],
            self.grid.walls,
        )
        robots.kind[chosen] = self._present_kind[names]
        robots.x[chosen], robots.y[chosen] = places.T
        robots.vx[chosen] = robots.vy[chosen] = 0.0
        if self._messages is not None:
            self._messages.begin(names, places)
        self._sort(0.0)

    def _rows(self, numbers: ArrayLike) -> Ints:
        """Where robots of these numbers stand in the state, in the order of the numbers."""
        asked = np.atleast_1d(np.asarray(numbers, np.int64))
        if len(np.unique(asked)) != len(asked) or ((asked < 0) | (asked >= len(self))).any():
            raise MissionError(f"robots {asked.tolist()}: different numbers from 0 to {len(self) - 1} are needed")
        where = np.empty(len(self), np.int64)
        where[self._robots.name] = np.arange(len(self))
        return where[asked]

    @property
    def places_m(self) -> Floats:
        """(n, 2) in the order of the fleet."""
        return self._in_order(self._robots.x, self._robots.y)

    @property
    def velocities_m_s(self) -> Floats:
        """(n, 2) of the last step, in the order of the fleet."""
        return self._in_order(self._robots.vx, self._robots.vy)

    def step(self) -> float:
        """Decide and move once; returns the longest way of any robot in metres."""
        moving = moving_at(self.moving, self.steps * self.rule.time_step_s, self.rule.time_step_s)
        if self._messages is not None:
            self._messages.tell(self.steps, self._robots, self.grid)
        if len(self.grid.roads.x):
            self._pass_on_news()
        if self._device is not None:
            filtered = self._widest_m if self.safe else None
            new = self._spare
            self._device.decide(self.steps, self._robots, self.grid, moving, filtered, new.vx, new.vy)
            return self._take_decided()
        # decisions go to the spare state's velocities, which nobody reads meanwhile
        if self._pool is None:
            self._decide_for(0, len(self), 0, moving)
        else:
            jobs = [
                self._pool.submit(self._decide_for, begin, end, k, moving)
                for k, (begin, end) in enumerate(pairwise(self._cuts))
            ]
            for job in jobs:
                job.result()
        return self._take_decided()

    def _pass_on_news(self) -> None:
        """What robots tell of the way to free ground for the next step; in this one they go by what they were told."""
        heard, roads = self._messages, self.grid.roads
        if heard is None:
            load_with_all(self._robots, self.kinds, roads)
        else:
            load_with_told(self.steps, self._robots, self.kinds, self.rule, heard.hearing, heard.past, roads)
        pass_on_news(self.steps, roads)

    def _take_decided(self) -> float:
        """Move as decided, sort, and count the step."""
        decided = self._robots._replace(vx=self._spare.vx, vy=self._spare.vy)
        self._spare = self._spare._replace(vx=self._robots.vx, vy=self._robots.vy)
        self._robots = decided
        self.steps += 1
        return self._sort(self.rule.time_step_s)

    def _decide_for(self, begin: int, end: int, part: int, moving: Any) -> None:
        new, room, heard = self._spare, self._rooms[part], self._messages
        controller = NUMBER_OF.get(self._decide, OWN)
        if heard is None or controller == OWN:
            self._decide(
                begin, end, self.steps, self._robots, self.kinds, self.grid, moving, self.rule,
                new.vx, new.vy, self._nearest2, room.near, room.outline, room.spare,
            )  # fmt: skip
        if heard is not None:
            decide_heard(
                begin, end, self.steps, controller, self.safe, self._robots, self.kinds, self.grid, moving, self.rule,
                heard.hearing, heard.past, heard.step_m, self._widest_m, new.vx, new.vy, room.near, room.outline,
                room.spare, *heard.view(part, self._robots, self.grid),
            )  # fmt: skip
        elif self.safe:
            filter_velocities(
                begin, end, self._robots, self.kinds, self.grid, moving, self.rule.time_step_s, self._widest_m,
                EXACT, new.vx, new.vy, self._nearest2, room.outline, room.spare,
            )  # fmt: skip

    def _sort(self, time_step_s: float) -> float:
        farthest2 = move_and_sort(self._robots, self._spare, self.grid, self._cell, time_step_s)
        self._robots, self._spare = self._spare, self._robots
        return float(np.sqrt(farthest2))

    def _in_order(self, x: Floats, y: Floats) -> Floats:
        return in_fleet_order(self._robots, x, y)


def _require_places(news_m: Floats, places: int) -> Floats:
    if len(news_m) != places:
        raise CheckpointError(f"news_m: numbers of {len(news_m)} places; {places} are needed")
    return news_m


def room_for(n: int, member_kinds: int) -> Robots:
    """A state of n robots that is yet to be written."""
    x, y, vx, vy = np.empty((4, n))
    return Robots(x, y, vx, vy, np.empty(n, np.int64), np.empty(n, np.int64), member_kinds)


def in_fleet_order(robots: Robots, x: Floats, y: Floats) -> Floats:
    """(n, 2) in the order of the fleet: values (n,) each that stand in the order of the state."""
    values = np.empty((len(robots.name), 2))
    values[robots.name, 0] = x
    values[robots.name, 1] = y
    return values


def deciding_room(rule: Rule) -> DecidingRoom:
    """Room for one thread that decides by this rule."""
    most = max(rule.neighbours, 1)
    outlines = [Outline(np.empty(MOST_CORNERS), np.empty(MOST_CORNERS)) for _ in range(2)]
    return DecidingRoom(Near(np.empty(most, np.int64), np.empty(most)), *outlines)
