"""A swarm that moves step by step: all robots decide from one snapshot, then all move."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rota.errors import CheckpointError, MissionError
from rota.mission import MovingObstacle
from rota.planners.swarm.cuda_step import CudaStep
from rota.planners.swarm.delayed_news_kernels import NUMBER_OF, OWN, Filtering, decide_from_delayed_news, load_with_told
from rota.planners.swarm.filter_kernels import filter_velocities
from rota.planners.swarm.free_ground_kernels import load_with_all, pass_on_distances
from rota.planners.swarm.kernels import move_and_sort
from rota.planners.swarm.messages import Messages, most_unheard_m
from rota.planners.swarm.place_graph import place_graph_of
from rota.planners.swarm.planner_settings import Device
from rota.planners.swarm.settle_kernels import decide_settle
from rota.planners.swarm.state import (
    Decisions,
    FleetKinds,
    Grid,
    Hearing,
    Near,
    Outline,
    Robots,
    Room,
    Rule,
    Snapshot,
)
from rota.planners.swarm.velocity_set_kernels import MOST_CORNERS
from rota.planners.swarm.world import make_grid, moving_at, require_room, widest_m, with_absent

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
CHUNKS_PER_THREAD = 4  # so that a thread with an easy share takes another one
FEWEST_PER_CHUNK = 256
EXACT = np.empty(0)  # nobody has gone on unheard


@dataclass(frozen=True, eq=False)
class Beginning:
    """Where n robots begin: at their starts, or in the middle of a run that goes on; d is 2, in space 3.

    places_m: (n, d). velocities_m_s: (n, d) before the first step; None: at rest. The rest tells of the run so far.
    names: (n,) the numbers in the fleet of those at places_m, in the order in which they stood in ``Swarm.robots``;
    None: 0 to n - 1. steps: how many the run has made. past, news_m: ``Swarm.past`` and ``Swarm.news_m`` then; None:
    nothing has been told.
    """

    places_m: Floats
    velocities_m_s: Floats | None = None
    names: Ints | None = None
    steps: int = 0
    past: Floats | None = None
    news_m: Floats | None = None

    @property
    def known_velocities_m_s(self) -> Floats:
        """(n, d) velocities, 0 where none are given."""
        return np.zeros(self.places_m.shape) if self.velocities_m_s is None else self.velocities_m_s

    @property
    def known_names(self) -> Ints:
        """(n,) numbers in the fleet, a copy."""
        return np.arange(len(self.places_m), dtype=np.int64) if self.names is None else self.names.copy()


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What robots move among: walls, (m, 4) segments, at least one; and discs that move and do not give way."""

    walls: Floats
    moving: tuple[MovingObstacle, ...] = ()


@dataclass(frozen=True)
class Controller:
    """How robots decide.

    decide: the compiled controller; rule: what it reads. safe: whether the last filter is applied. hearing: what robots
    learn of each other; None: at every step where all others are. device: what decides, the processor or, "cuda", an
    NVIDIA GPU, to within rounding.
    """

    decide: Callable[..., None]
    rule: Rule
    safe: bool = True
    hearing: Hearing | None = None
    device: Device = "cpu"


class Swarm:
    """n robots, their places and velocities; ``step`` moves them. The same on any number of threads, bit for bit.

    Robots may leave and join between two steps; those that have left are nobody's neighbours any more. Raises
    MissionError for a device that is not there or does not do what is asked, CheckpointError for news of other places.
    """

    def __init__(
        self,
        beginning: Beginning,
        fleet: FleetKinds,
        surroundings: Surroundings,
        controller: Controller,
        *,
        threads: int = 1,
    ) -> None:
        n, names = len(beginning.places_m), beginning.known_names
        kinds, kind = fleet
        walls, decide, rule, hearing = surroundings.walls, controller.decide, controller.rule, controller.hearing
        self.steps = beginning.steps
        self.moving = surroundings.moving
        unheard_m = 0.0 if hearing is None else most_unheard_m(hearing, kinds, rule.time_step_s)
        self.grid: Grid = make_grid(walls, kinds, n, rule.time_step_s, unheard_m)
        if decide is decide_settle:
            self.grid = self.grid._replace(place_graph=place_graph_of(walls, kinds))
        if beginning.news_m is not None:
            news_m = _require_places(beginning.news_m, len(self.grid.place_graph.x))
            self.grid.place_graph.away_m[self.steps % 2] = news_m
        self.kinds, self.rule, self.safe = with_absent(kinds), rule, controller.safe
        self._present_kind, self._member_kinds = kind.astype(np.int64), len(kinds.body_m)
        self._decide = decide
        starts = (*beginning.places_m.T, *beginning.known_velocities_m_s.T)
        x, y, vx, vy = (np.array(values, np.float64) for values in starts)
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
        self._device = None if controller.device == "cpu" else CudaStep(decide, self.kinds, rule)
        if self._device is not None and hearing is not None:
            raise MissionError("swarm.device: cuda is for robots that know all at once; no delay_steps, messages_lost")
        self._messages = None
        if hearing is not None:
            step_m = kinds.speed_m_s[self._present_kind] * rule.time_step_s
            told = np.stack([self._in_order(x, y), self._in_order(vx, vy)])
            told = told if beginning.past is None else beginning.past
            self._messages = Messages(hearing, step_m, told, len(self._rooms))
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
        return np.array(self.grid.place_graph.away_m[self.steps % 2])

    @property
    def present(self) -> NDArray[np.bool_]:
        """(n,) in the order of the fleet: whether each robot takes part."""
        values = np.empty(len(self), np.bool_)
        values[self._robots.name] = self._robots.kind < self._member_kinds
        return values

    def leave(self, numbers: ArrayLike, *, bodies_stay: bool = True) -> None:
        """Let robots of these numbers in the fleet stop: they see nothing more and are nobody's neighbours.

        Their bodies stay in the way of the others unless ``bodies_stay`` is false.
        """
        chosen = self._rows(numbers)
        absent = self._present_kind[self._robots.name[chosen]] + self._member_kinds
        self._robots.kind[chosen] = absent if bodies_stay else len(self.kinds.body_m) - 1
        self._robots.vx[chosen] = self._robots.vy[chosen] = 0.0

    def join(self, numbers: ArrayLike, places_m: ArrayLike | None = None) -> None:
        """Let absent robots of these numbers in the fleet take part from the next step on, from where they are.

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
        """The rows (k,) of the state in which robots of these numbers (k,) stand; MissionError for wrong numbers."""
        chosen = np.atleast_1d(np.asarray(numbers, np.int64))
        if len(np.unique(chosen)) != len(chosen) or ((chosen < 0) | (chosen >= len(self))).any():
            raise MissionError(f"robots {chosen.tolist()}: different numbers from 0 to {len(self) - 1} are needed")
        where = np.empty(len(self), np.int64)
        where[self._robots.name] = np.arange(len(self))
        return where[chosen]

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
        time_step_s = self.rule.time_step_s
        if self._messages is not None:
            self._messages.tell(self.steps, self._robots, self.grid)
        moving = moving_at(self.moving, self.steps * time_step_s, time_step_s)
        snapshot = Snapshot(self.steps, self._robots, self.kinds, self.grid, moving, self.rule)
        if len(self.grid.place_graph.x):
            self._pass_on_distances(snapshot)
        # decisions go to the spare state's velocities, which nobody reads meanwhile
        decisions = Decisions(self._spare.vx, self._spare.vy, self._nearest2)
        if self._device is not None:
            self._device.decide(snapshot, self._widest_m if self.safe else None, decisions)
        elif self._pool is None:
            self._decide_for(0, len(self), 0, snapshot, decisions)
        else:
            jobs = [
                self._pool.submit(self._decide_for, begin, end, k, snapshot, decisions)
                for k, (begin, end) in enumerate(pairwise(self._cuts))
            ]
            for job in jobs:
                job.result()
        return self._take_decided()

    def _pass_on_distances(self, snapshot: Snapshot) -> None:
        """Work out what robots tell of free ground for the next step; in this step they go by what they were told."""
        if self._messages is None:
            load_with_all(self._robots, self.kinds, self.grid.place_graph)
        else:
            load_with_told(snapshot, self._messages.hearing, self._messages.past)
        pass_on_distances(self.steps, self.grid.place_graph)

    def _take_decided(self) -> float:
        """Move as decided, sort, and count the step."""
        decided = self._robots._replace(vx=self._spare.vx, vy=self._spare.vy)
        self._spare = self._spare._replace(vx=self._robots.vx, vy=self._robots.vy)
        self._robots = decided
        self.steps += 1
        return self._sort(self.rule.time_step_s)

    def _decide_for(self, begin: int, end: int, part: int, snapshot: Snapshot, decisions: Decisions) -> None:
        """Decide for the robots begin..end - 1 in one thread, with its part of the room."""
        room, controller = self._rooms[part], NUMBER_OF.get(self._decide, OWN)
        if self._messages is None or controller == OWN:
            self._decide(begin, end, snapshot, decisions, room)
        if self._messages is not None:
            news = self._messages.news_for(part, self._robots, self.grid)
            filtering = Filtering(self.safe, self._widest_m)
            decide_from_delayed_news(begin, end, controller, filtering, snapshot, news, decisions, room)
        elif self.safe:
            filter_velocities(begin, end, snapshot, self._widest_m, EXACT, decisions, room)

    def _sort(self, time_step_s: float) -> float:
        """Move the robots for that time and sort them by cell; returns the longest way in metres."""
        farthest2 = move_and_sort(self._robots, self._spare, self.grid, self._cell, time_step_s)
        self._robots, self._spare = self._spare, self._robots
        return float(np.sqrt(farthest2))

    def _in_order(self, x: Floats, y: Floats) -> Floats:
        """(n, 2) values in the order of the fleet, from two (n,) in the order of the grid."""
        return in_fleet_order(self._robots, x, y)


def _require_places(news_m: Floats, places: int) -> Floats:
    """The numbers (k,) of places; raises CheckpointError where their count is another."""
    if len(news_m) != places:
        raise CheckpointError(f"news_m: numbers of {len(news_m)} places; {places} are needed")
    return news_m


def room_for(n: int, member_kinds: int) -> Robots:
    """A state of n robots that is yet to be written."""
    x, y, vx, vy = np.empty((4, n))
    return Robots(x, y, vx, vy, np.empty(n, np.int64), np.empty(n, np.int64), member_kinds)


def in_fleet_order(robots: Robots, x: Floats, y: Floats) -> Floats:
    """(n, 2) values in the order of the fleet, of x and y, (n,) each, in the order of the state."""
    values = np.empty((len(robots.name), 2))
    values[robots.name, 0] = x
    values[robots.name, 1] = y
    return values


def deciding_room(rule: Rule) -> Room:
    """Room for one thread that decides by this rule."""
    most = max(rule.neighbours, 1)
    outlines = [Outline(np.empty(MOST_CORNERS), np.empty(MOST_CORNERS)) for _ in range(2)]
    return Room(Near(np.empty(most, np.int64), np.empty(most)), *outlines)
