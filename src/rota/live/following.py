"""How robots follow their routes: how far behind the plan each is, and how far beside its route."""

from __future__ import annotations

import numpy as np

from rota.live import following_kernels
from rota.model.arrays import Floats, Ints
from rota.model.plan import Plan

# a robot that falls behind by a share of the time between these is held up, over so long and so far a way: a slow
# one stands still within the error of its reports
LOOKED_AT_S, LOOKED_AT_M, HELD_UP, MOST_HELD_UP = 2.0, 1.0, 0.7, 1.3


class Following:
    """Where robots are on their planned routes, as their last reports tell.

    lags_s: (robots,) seconds behind the plan, below 0 ahead of it. away_m: (robots,) metres beside the route. held_up:
    (robots,) whether it fell behind by most of the last seconds, in which it was to get on by a metre or more. A lag
    is told up to whole rounds: a robot that stands for a round is one round behind.
    """

    def __init__(self, plan: Plan) -> None:
        self.lags_s = np.zeros(len(plan.trajectories))
        self.away_m = np.zeros(len(plan.trajectories))
        self.held_up = np.zeros(len(plan.trajectories), np.bool_)
        self._since_s, self._lags_then_s = np.full(len(plan.trajectories), -np.inf), self.lags_s.copy()
        offsets = np.concatenate([[0], np.cumsum([len(way.times_s) for way in plan])]).astype(np.int64)
        loops = np.array([way.loop_index for way in plan], np.int64)
        self._routes = following_kernels.PlannedRoutes(
            offsets=offsets,
            knots_s=np.concatenate([np.empty(0), *(way.times_s for way in plan)]),
            knots_m=np.vstack([np.empty((0, 2)), *(way.positions_m[:, :2] for way in plan)]),
            loop_starts=offsets[:-1] + loops,
            speeds_m_s=np.array([plan.mission.fleet.robot(way.robot).speed_m_s for way in plan], np.float64),
        )

    def hear(self, robots: Ints, times_s: Floats, places_m: Floats, off_route_m: Floats) -> None:
        """Take the last reports: of robots (m,), at times_s (m,), at places (m, 2); off_route_m: (robots,).

        A robot off its route keeps the lag that it had.
        """
        lags_s, away_m = following_kernels.locate(robots, times_s, places_m, self.lags_s, self._routes, off_route_m)
        self.away_m[robots] = away_m
        on = away_m <= off_route_m[robots]
        self.lags_s[robots[on]] = lags_s[on]
        passed_s = times_s - self._since_s[robots]
        # the first look of each only notes where it is
        due = passed_s >= LOOKED_AT_S
        known = np.isfinite(passed_s)
        due[known] &= self._planned_m(robots[known], times_s[known]) >= LOOKED_AT_M
        judged, fell_s = robots[due], self.lags_s[robots[due]] - self._lags_then_s[robots[due]]
        # one that falls behind by more than the time that passes was somewhere else than was thought
        stands = (fell_s > HELD_UP * passed_s[due]) & (fell_s < MOST_HELD_UP * passed_s[due])
        # and one that was ahead of its plan may have waited for it
        stands &= self.lags_s[judged] > HELD_UP * LOOKED_AT_S
        self.held_up[judged] = stands & on[due]
        self._since_s[judged], self._lags_then_s[judged] = times_s[due], self.lags_s[judged]

    def believe(self, robot: int, lag_s: float) -> None:
        """Take it that a robot is so far behind: where it stands for long its place does not tell."""
        self.lags_s[robot] = lag_s
        self.held_up[robot], self._since_s[robot] = False, -np.inf

    def _planned_m(self, robots: Ints, times_s: Floats) -> Floats:
        """How far each was to get since the last look, if no later than then: (m,) metres."""
        since_s, lags_s = self._since_s[robots], self._lags_then_s[robots]
        apart_m: Floats = following_kernels.planned_m(robots, since_s - lags_s, times_s - lags_s, self._routes)
        return apart_m
