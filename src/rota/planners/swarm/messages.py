"""What robots have told each other lately, and the room to look at it from one robot after the other."""

from __future__ import annotations

import numpy as np

from rota.model.arrays import Floats, Ints
from rota.planners.swarm.delayed_news_kernels import MOST_LOST_IN_ROW, Belief, DelayedNews, most_round
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.state import Grid, Hearing, Kinds, Robots


def hearing_of(settings: SwarmSettings) -> Hearing | None:
    """What robots learn of each other, where that is less than all."""
    if settings.delay_steps == 0 and settings.messages_lost == 0:
        return None
    return Hearing(delay_steps=settings.delay_steps, lost=float(settings.messages_lost))


def oldest_steps(hearing: Hearing) -> int:
    """How many steps old the oldest message is that a robot may have to heed."""
    return hearing.delay_steps + (MOST_LOST_IN_ROW if hearing.lost > 0 else 0)


def most_unheard_m(hearing: Hearing, kinds: Kinds, time_step_s: float) -> float:
    """How far any robot may have gone since it told of itself."""
    return oldest_steps(hearing) * float(kinds.speed_m_s.max()) * time_step_s


class Messages:
    """All that may still be heard: ``past`` (h, 4, n), x, y, vx, vy told at step s at s modulo h, by number.

    step_m: (n,) longest step of each robot. told: (2, n, 2) places and velocities before the first step, which all
    know; where a run goes on, what ``past`` was.
    """

    def __init__(self, hearing: Hearing, step_m: Floats, told: Floats, threads: int) -> None:
        self.hearing, self.step_m = hearing, step_m
        steps = oldest_steps(hearing) + 1
        if told.shape[1:] == (len(step_m), 2):
            told = np.concatenate([told[0].T, told[1].T])[None].repeat(steps, axis=0)
        self.past = np.ascontiguousarray(told)
        self._beliefs: list[Belief | None] = [None] * threads
        self._most = 0

    def tell(self, step: int, robots: Robots, grid: Grid) -> None:
        """Every robot tells where it is before a step."""
        news_now = self.past[step % len(self.past)]
        for values, told_values in zip((robots.x, robots.y, robots.vx, robots.vy), news_now, strict=True):
            told_values[robots.name] = values
        self._most = max(self._most, int(most_round(grid)))

    def begin(self, names: Ints, places_m: Floats) -> None:
        """Robots appear at places (k, 2), and all know of it."""
        self.past[:, :2, names] = places_m.T
        self.past[:, 2:, names] = 0.0

    def news_for(self, thread: int, robots: Robots, grid: Grid) -> DelayedNews:
        """The messages, with a belief of one thread that has room for all robots round about any robot."""
        belief = self._beliefs[thread]
        if belief is None or len(belief.spread_m) < self._most:
            n = 2 * self._most
            x, y, vx, vy = np.empty((4, n))
            known = Robots(x, y, vx, vy, np.empty(n, np.int64), np.empty(n, np.int64), robots.member_kinds)
            alone = grid._replace(start=np.zeros_like(grid.start))
            self._beliefs[thread] = belief = Belief(known, alone, np.empty(n), np.empty((3, 1)))
        return DelayedNews(self.hearing, self.past, self.step_m, belief)
