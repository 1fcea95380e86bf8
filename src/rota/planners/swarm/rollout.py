"""A swarm that moves step by step: all robots decide from one snapshot, then all move."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rota.cells.importance_cells import ImportanceCells
from rota.errors import MissionError
from rota.model.arrays import Flags, Floats, Ints
from rota.model.mission import MovingObstacle
from rota.planners.swarm.deciding import Controller, Deciding
from rota.planners.swarm.delayed_news_kernels import load_with_told
from rota.planners.swarm.free_ground_kernels import load_with_all, pass_on_distances
from rota.planners.swarm.kernels import move
from rota.planners.swarm.messages import Messages, most_unheard_m
from rota.planners.swarm.settle_kernels import decide_settle
from rota.planners.swarm.sorted_robots import Beginning, SortedRobots
from rota.planners.swarm.state import Decisions, FleetKinds, Guide, Kinds, Snapshot
from rota.planners.swarm.world import make_grid, moving_at, require_room, widest_m, with_absent

FEWEST_UNSORTED, STEPS_UNSORTED = 10_000, 4  # so many robots are sorted after so many of their longest steps only


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What robots move among: walls, (m, 4) segments, at least one; and discs that move and do not give way.

    importance: of the ground; None: all is worth as much.
    """

    walls: Floats
    moving: tuple[MovingObstacle, ...] = ()
    importance: ImportanceCells | None = None


class Swarm(SortedRobots):
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
        n, (kinds, kind) = len(beginning.places_m), fleet
        walls, decide, rule, hearing = surroundings.walls, controller.decide, controller.rule, controller.hearing
        self.moving = surroundings.moving
        self.guide: Guide | None = None
        unheard_m = 0.0 if hearing is None else most_unheard_m(hearing, kinds, rule.time_step_s)
        self._slack_m = _slack_m(kinds, n, rule.time_step_s)
        grid = make_grid(
            walls, kinds, n, rule.time_step_s, unheard_m + self._slack_m,
            importance=surroundings.importance, mapped=decide is decide_settle,
        )  # fmt: skip
        self._present_kind, self._member_kinds = kind.astype(np.int64), len(kinds.body_m)
        super().__init__(beginning, FleetKinds(with_absent(kinds), self._present_kind), self._member_kinds, grid, rule)
        reach_m = widest_m(kinds, rule.time_step_s) + unheard_m
        self._deciding = Deciding(controller, self.kinds, n, reach_m, threads)
        self._messages = None
        if hearing is not None:
            step_m = kinds.speed_m_s[self._present_kind] * rule.time_step_s
            told = np.stack([self.places_m, self.velocities_m_s]) if beginning.past is None else beginning.past
            self._messages = Messages(hearing, step_m, told, len(self._deciding.chunks))
        self._sort(0.0)

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

    def learn_of_free_ground(self) -> None:
        """Let places tell, from now on, what is free round robots where they are; of a run that was not followed."""
        load_with_all(self._robots, self.kinds, self.grid.place_graph)
        pass_on_distances(self.steps + 1, self.grid.place_graph)  # what is told at even or odd steps, as this one is

    @property
    def present(self) -> Flags:
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

    def lead(self, numbers: ArrayLike, *, led: bool = True) -> None:
        """Let robots of these numbers go where the guide leads them, as bodies, or take part from where they are."""
        chosen = self._rows(numbers)
        self._robots.kind[chosen] = self._present_kind[self._robots.name[chosen]] + 2 * self._member_kinds * led
        self.rule = self.rule._replace(last_change=self.steps)  # what they know begins to settle anew

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
        # decisions go to the spare state, which nobody reads meanwhile
        robots, decided = self._robots, self._spare
        decisions = Decisions(decided.vx, decided.vy, self._nearest2)
        self.steps += 1
        if self._slack_m == 0:
            self._deciding.decide(snapshot, self._messages, decisions, lambda _begin, _end: 0.0, self.guide)
            return self._move_and_sort()
        ways2 = self._deciding.decide(
            snapshot, self._messages, decisions,
            lambda begin, end: move(begin, end, robots, decided, time_step_s), self.guide,
        )  # fmt: skip
        return self._take_moved(math.sqrt(max(ways2)))

    def _pass_on_distances(self, snapshot: Snapshot) -> None:
        """Work out what robots tell of free ground for the next step; in this step they go by what they were told."""
        if self._messages is None:
            load_with_all(self._robots, self.kinds, self.grid.place_graph)
        else:
            load_with_told(snapshot, self._messages.hearing, self._messages.past)
        pass_on_distances(self.steps, self.grid.place_graph)

    def _take_moved(self, farthest_m: float) -> float:
        """Take the places of robots that have moved, and sort them where they may be too far from their cells."""
        robots, moved = self._robots, self._spare
        self._robots = moved._replace(kind=robots.kind, name=robots.name)
        self._spare = robots._replace(kind=moved.kind, name=moved.name)
        self._unsorted_m += farthest_m
        if self._unsorted_m > self._slack_m:
            self._sort(0.0)
        return farthest_m

    def _move_and_sort(self) -> float:
        """Move as decided, and sort; the longest way in metres."""
        decided = self._robots._replace(vx=self._spare.vx, vy=self._spare.vy)
        self._spare = self._spare._replace(vx=self._robots.vx, vy=self._robots.vy)
        self._robots = decided
        return self._sort(self.rule.time_step_s)


def _slack_m(kinds: Kinds, n: int, time_step_s: float) -> float:
    """How far n robots may go before they are sorted again: 0, so that they are after each step, where they are few.

    Cells are wider by that, so that all near robots are in the cells round about all the same.
    """
    return STEPS_UNSORTED * float(kinds.speed_m_s.max()) * time_step_s if n >= FEWEST_UNSORTED else 0.0
