"""Sequential linear programming on tours: as little over budget and unseen as their shapes can be bent to.

Annealing finds which leg sees what; but it moves one vertex at a time and at random, and the last metres and slivers
take it more moves than all the rest. Here who sees what is kept for one step, lengths and ranges are taken as linear,
and a linear program moves all vertices at once within a trust region (Fletcher and Sainz de la Maza, Mathematical
Programming 43, 1989); then everybody sightings again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import shapely

from rota.geometry.free_space import border_segments
from rota.geometry.kernels import free_segments
from rota.model.arrays import Flags, Floats, Ints
from rota.model.mission import DiscSensor
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.ground.problem import Problem
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.initial.standing import robots_stand
from rota.planners.patrol.loop_settings import BendingSettings
from rota.planners.patrol.repair.bending.layout import Layout, lay_out_tours, sightings
from rota.planners.patrol.repair.bending.program import BUDGET_PENALTY, Rows, best_step, range_rows, rows_along
from rota.planners.patrol.repair.bending.sighting_kernels import Sightings
from rota.planners.patrol.tolerances import HAIR_M, ON_LINE_M
from rota.planners.patrol.tours.tour import Tour

ROUNDING = 1e-7  # costs below this are rounding
FIRST_TRUST = 0.04  # of the reach: how far vertices may move in the first step
MOST_DEFICIT = 0.1  # of the reach: samples that lack more are not drawn to


def can_bend(problem: Problem) -> bool:
    """Whether it is worth while: turns on arcs are not linear, the rim of what can be seen leaves no room to move in.

    Nor do robots that stand have lengths to speak of.
    """
    stands = any(robots_stand(problem, period_s) for period_s in problem.periods_s)
    robot = problem.robot
    is_linear = robot.turn_radius_m == 0 and (robot.turn_rate_rad_s is None or driving_of(robot).slopes is not None)
    return not stands and is_linear and not problem.at_limit


class Bending:
    """One search: tours within their budgets less a reserve that see all samples, as near as steps can come to that."""

    def __init__(
        self,
        problem: Problem,
        tours: Sequence[Tour],
        samples: Samples,
        settings: BendingSettings,
        *,
        reserve: float = 0.0,
    ) -> None:
        """Tours within their budgets are as good as shorter ones: they move no more than they need to."""
        self._problem, self._samples, self._settings = problem, samples, settings
        self._reserve = reserve
        self._reach_m = problem.reach_m
        self._square = not isinstance(problem.robot.sensor, DiscSensor)
        self._border = Border(border_segments(problem.space))
        longest = 1.0 if driving_of(problem.robot).slopes is None else 2.0  # where corners take time every bend does
        self._layout, self._places_m = lay_out_tours(tours, longest * self._reach_m)
        self._handicap_m = np.zeros(len(tours))
        self._sightings = self._look(self._places_m)
        self._cost = self._cost_of(self._places_m, self._sightings)
        self._trust_m = FIRST_TRUST * self._reach_m

    @property
    def tours(self) -> list[Tour]:
        """The tours as they stand."""
        return self._layout.tours_at(self._places_m)

    @property
    def some_far(self) -> bool:
        """Whether no leg comes near some of the samples; steps do nothing about them."""
        return len(self.far_samples) > 0

    @property
    def far_samples(self) -> Ints:
        """The numbers of the samples that no leg comes near."""
        return np.flatnonzero(self._sightings.leg[:, 0] < 0)

    def run(self, steps: int, *, should_stop: Callable[[], bool]) -> None:
        """Take at most so many steps."""
        for _ in range(steps):
            if should_stop() or not self.step():
                return

    def hand_over(self, steps: int, *, should_stop: Callable[[], bool]) -> None:
        """Leave to others what tours with nothing to spare see and those nearly do, then go on as ``run`` does.

        Nothing changes when that is no gain.
        """
        layout, kept = self._layout, (self._places_m, self._sightings, self._cost)
        left_m = layout.budget_m * (1 - self._reserve) - layout.counts @ layout.lengths_m(self._places_m)
        tight = (layout.counts[left_m < 0.003 * layout.budget_m] > 0).any(axis=0)
        if tight.all() or not tight.any():
            return
        for handicap_m in (0.02 * self._reach_m, 0.0):  # others that lack no more can take it over
            self._handicap_m = np.where(tight, handicap_m, 0.0)
            self._sightings = self._look(self._places_m)
            self._cost = self._cost_of(self._places_m, self._sightings)
            self._trust_m = FIRST_TRUST * self._reach_m
            self.run(steps, should_stop=should_stop)
        if self._cost >= kept[2]:
            self._places_m, self._sightings, self._cost = kept

    def step(self) -> bool:
        """Take one step, if it is one ahead; False when no further step is worth its time."""
        # steps as small gain nothing that the check would see
        if self._trust_m < 1e-4 * self._reach_m or self._cost < ROUNDING:
            return False
        layout, places_m, near_m = self._layout, self._places_m, 2.5 * self._trust_m
        clearances, fixed = self._border.clearances(layout, places_m, near_m)
        step = best_step(
            layout, places_m, self._settings,
            range_rows(
                layout, places_m, self._sightings, self._samples, square=self._square, near_m=near_m,
            ),
            clearances, fixed=fixed, trust_m=self._trust_m, reserve=self._reserve,
        )  # fmt: skip
        if step is None or self._cost - step.cost < self._worth:
            return False
        then_m = self._kept_free(places_m + step.moves_m)
        sightings_then = self._look(then_m)
        cost = self._cost_of(then_m, sightings_then)
        kept = (self._cost - cost) / (self._cost - step.cost)
        if kept > 0.7:
            self._trust_m = min(1.5 * self._trust_m, 0.1 * self._reach_m)  # beyond, ranges are far from linear
        elif kept < 0.3:
            self._trust_m *= 0.5
        if kept > 0.02:
            self._places_m, self._sightings, self._cost = then_m, sightings_then, cost
        return True

    def _look(self, places_m: Floats) -> Sightings:
        return sightings(
            self._layout, places_m, self._samples,
            range_margin_m=self._problem.range_margin_m,
            further_m=MOST_DEFICIT * self._reach_m, handicap_m=self._handicap_m,
            most=3 if self._settings.shares else 1,  # in the plane what is farthest from all lies between three
        )  # fmt: skip

    @property
    def _worth(self) -> float:
        """What a step must promise to gain."""
        return max(ROUNDING, self._settings.least_gain * self._cost)

    def _cost_of(self, places_m: Floats, sightings: Sightings) -> float:
        layout, settings = self._layout, self._settings
        lengths_m = layout.lengths_m(places_m)
        over_m = np.maximum(0.0, layout.counts @ lengths_m - layout.budget_m * (1 - self._reserve)).sum()
        deficit_m = np.clip(sightings.range_deficit_m[:, 0], 0.0, MOST_DEFICIT * self._reach_m).sum()
        length_m = settings.length_weight * lengths_m.sum()
        return float(BUDGET_PENALTY * over_m + settings.range_weight * deficit_m + length_m)

    def _kept_free(self, then_m: Floats) -> Floats:
        """The places, with the vertices of legs that would leave the space back where they were."""
        start, end = self._layout.start, self._layout.end
        while True:
            free = free_segments(then_m[start], then_m[end], self._problem.paths.grid)
            if free.all():
                return then_m
            back = np.concatenate([start[~free], end[~free]])
            moved = (then_m[back] != self._places_m[back]).any(axis=1)
            if not moved.any():
                return self._places_m
            then_m[back] = self._places_m[back]


class Border:
    """The border of the standing space, as segments (m, 4), made ready to be asked."""

    def __init__(self, segments_m: Floats) -> None:
        self._lines = shapely.linestrings(segments_m.reshape(-1, 2, 2))
        self._tree = shapely.STRtree(self._lines)

    def clearances(self, layout: Layout, places_m: Floats, near_m: float) -> tuple[Rows, Flags]:
        """Limits on moves of what is within ``near_m`` of the border; and the vertices (n,) that had better stay.

        Towards each segment nobody moves farther than there is room; along it everybody may. What touches the border
        stays: it does so to go round a corner, which no single step leaves behind.
        """
        n = len(places_m)
        a, b = layout.start, layout.end
        legs = shapely.linestrings(np.stack([places_m[a], places_m[b]], axis=1))
        leg, segment = self._tree.query(legs, predicate="dwithin", distance=near_m)
        ways_m = shapely.get_coordinates(shapely.shortest_line(legs[leg], self._lines[segment])).reshape(-1, 2, 2)
        t = leg_parameters(places_m[a[leg]], places_m[b[leg]], ways_m[:, 0])
        points = shapely.points(places_m)
        vertex, beside = self._tree.query(points, predicate="dwithin", distance=near_m)
        to_m = shapely.get_coordinates(shapely.shortest_line(points[vertex], self._lines[beside])).reshape(-1, 2, 2)
        first, last = np.concatenate([a[leg], vertex]), np.concatenate([b[leg], vertex])
        ways_m, t = np.vstack([ways_m, to_m]), np.concatenate([t, np.zeros(len(vertex))])
        out_m = ways_m[:, 1] - ways_m[:, 0]
        room_m = np.hypot(*out_m.T)
        touches = room_m < HAIR_M
        fixed = np.zeros(n, dtype=np.bool_)
        fixed[first[touches & (t < 1)]] = True
        fixed[last[touches & (t > 0)]] = True
        keep = ~touches
        along = rows_along(out_m[keep] / room_m[keep, None], first[keep], last[keep], t[keep], n)
        return Rows(along, room_m[keep] - ON_LINE_M), fixed


def leg_parameters(start_m: Floats, end_m: Floats, places_m: Floats) -> Floats:
    """How far along legs (r, 2) to (r, 2) the places (r, 2) on them lie: 0 to 1; 0 on a leg without length."""
    along_m = end_m - start_m
    share = ((places_m - start_m) * along_m).sum(axis=1) / np.maximum((along_m**2).sum(axis=1), 1e-18)
    return np.asarray(np.clip(share, 0.0, 1.0))
