"""A robot's way ahead on ROS 2, each place with the instant at which to be there, by the clock of all robots."""

from __future__ import annotations

import math

import numpy as np

from rota.links.link import Order
from rota.links.ros2_route import NS_PER_S, TimedPath
from rota.model.plan import Floats

AHEAD_S = 30.0  # of the plan, that a robot is told at once
MOST_ROUNDS = 1000  # of a very short loop, likewise


class Schedule:
    """What one robot is told of its route again and again.

    path: its route by a clock that is 0 when the plan's is begins_s. top_m_s: the speed up to which one that is late is
    to hurry on its legs; None: it cannot go faster than planned. What is late is made up at waits in any case, and else
    lasts.
    """

    def __init__(self, path: TimedPath, top_m_s: float | None, begins_s: float = 0.0) -> None:
        self._begins_s = begins_s
        self._held_s: float | None = None
        self._times_s = np.array(path.times_ns) / NS_PER_S
        self._places_m = np.array(path.places_m)
        self._loop_s = path.loop_ns / NS_PER_S
        self._round_s = float(self._times_s[-1]) - self._loop_s
        self._top_m_s = top_m_s

    def ahead(self, order: Order, time_s: float, zero_s: float) -> TimedPath:
        """The way from where the robot is, to where the clock of all is ``AHEAD_S`` later.

        time_s: now, since the plan's start, which was at ``zero_s`` since 1970. Times are since 1970. ``loop_ns`` is
        when the route would have started for a robot that is in time at the last place: beyond it, it drives its route
        by that. One that is to hold is told to be for so long where it was when it was first told.
        """
        clock_s = time_s - order.behind_s - self._begins_s
        here_s = max(clock_s - order.late_s, 0.0)
        if order.rate == 0:
            # what a report is old by must not let it creep on
            self._held_s = here_s if self._held_s is None else self._held_s
            return self._stay(self._held_s, time_s + zero_s)
        self._held_s = None
        moments_s, places_m = self._way(here_s, max(clock_s, here_s) + AHEAD_S)
        lengths_m, lasting_s = np.sqrt((np.diff(places_m, axis=0) ** 2).sum(axis=1)), np.diff(moments_s)
        fastest_s = lasting_s if self._top_m_s is None else np.minimum(lasting_s, lengths_m / self._top_m_s)
        needed_s = np.concatenate([[0.0], np.cumsum(np.where(lengths_m > 0, fastest_s, 0.0))])
        due_s = time_s + (moments_s - clock_s) / order.rate
        due_s[0] = time_s
        # each as soon as it is due and can be reached from those before
        told_s = zero_s + needed_s + np.maximum.accumulate(due_s - needed_s)
        told_ns = np.round(told_s * NS_PER_S).astype(np.int64)
        return TimedPath(
            places_m=tuple((x, y, z) for x, y, z in places_m.tolist()),
            times_ns=tuple(told_ns.tolist()),
            loop_ns=int(told_ns[-1]) - round(float(moments_s[-1]) * NS_PER_S),
        )

    def _stay(self, here_s: float, now_s: float) -> TimedPath:
        """The place of a moment from now, since 1970, for ``AHEAD_S``; then the route goes on from there."""
        _, ((x, y, z),) = self._way(here_s, here_s)
        now_ns, until_ns = round(now_s * NS_PER_S), round((now_s + AHEAD_S) * NS_PER_S)
        return TimedPath(
            places_m=((x, y, z), (x, y, z)),
            times_ns=(now_ns, until_ns),
            loop_ns=until_ns - round(here_s * NS_PER_S),
        )

    def _way(self, from_s: float, to_s: float) -> tuple[Floats, Floats]:
        """The moments (n,) of the plan's points between two moments, with both, and the places (n, 3)."""
        times_s, places_m, back_s = self._times_s, self._places_m, 0.0
        last_s = float(times_s[-1])
        if self._round_s > 0:
            back_s = max(math.floor((from_s - self._loop_s) / self._round_s), 0) * self._round_s
            again = self._times_s >= self._loop_s
            again[np.argmax(again)] = False  # where the loop begins is where the last round ended
            rounds = min(math.ceil(max(to_s - back_s - last_s, 0.0) / self._round_s), MOST_ROUNDS)
            later_s = self._round_s * np.arange(1, rounds + 1)[:, None]
            times_s = np.concatenate([times_s, (times_s[again] + later_s).ravel()])
            places_m = np.vstack([places_m, *[places_m[again]] * rounds])
            last_s = float(times_s[-1])
        begin_s, end_s = min(from_s - back_s, last_s), min(to_s - back_s, last_s)
        between = (times_s > begin_s) & (times_s < end_s)
        ends = np.array([begin_s, end_s]) if end_s > begin_s else np.array([begin_s])
        ends_m = np.column_stack([np.interp(ends, times_s, axis_m) for axis_m in places_m.T])
        moments_s = np.concatenate([ends[:1], times_s[between], ends[1:]])
        return moments_s + back_s, np.vstack([ends_m[:1], places_m[between], ends_m[1:]])
