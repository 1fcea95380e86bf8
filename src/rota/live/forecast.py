"""What will happen if robots go on as planned, each as far behind its plan as it is: which periods lapse, and when."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rota.live import kernels
from rota.live.kernels import Team
from rota.live.places import Places
from rota.live.planned_sights import sights_of_plan
from rota.model.arrays import Floats
from rota.model.plan import Plan

PERIODS_AHEAD = 2.0  # how far a forecast looks, in periods of the demand


@dataclass(frozen=True, kw_only=True)
class Lapse:
    """The first place of a demand that will not be seen in time: it lapses at ``at_s``.

    next_s: when ``next_robot`` sees it then, by plan; inf and None: nobody will.
    """

    demand: int
    place: int
    at_s: float
    next_s: float
    next_robot: int | None


class Forecast:
    """When each place is seen by plan, worked out once, and what that means from any moment on."""

    def __init__(self, plan: Plan, places: Places) -> None:
        self.places = places
        self._loops_s = np.array([trajectory.loop_duration_s for trajectory in plan], np.float64)
        self._sights = sights_of_plan(plan, places.points_m[: places.points], places.demand, places.demands)

    def lapses(
        self, last_seen_s: Floats, now_s: float, lags_s: Floats, until_s: Floats, later_s: float | None = None
    ) -> list[Lapse]:
        """The first lapse of every demand that has one within two of its periods after ``later_s``, soonest first.

        last_seen_s: (n,) of the places. lags_s: (robots,) seconds that each is behind its plan. until_s: (robots,) how
        long each goes on, inf for ever, -inf for one that is not counted on. later_s: None for now.
        """
        team = Team(self._loops_s, np.ascontiguousarray(lags_s), np.ascontiguousarray(until_s))
        later_s = now_s if later_s is None else later_s
        places, count = self.places, len(self.places.demands)
        looked_s = later_s + PERIODS_AHEAD * places.periods_s
        when, where = kernels.first_lapses(
            last_seen_s, places.demand, count, places.periods_s, looked_s, now_s, self._sights, team
        )
        found = []
        for k in np.argsort(when, kind="stable"):
            if math.isfinite(when[k]):
                place = int(where[k])
                start_s, _, who = kernels.next_sight(place, float(when[k]), now_s, self._sights, team)
                found.append(
                    Lapse(
                        demand=int(k), place=place, at_s=float(when[k]), next_s=float(start_s),
                        next_robot=None if who < 0 else int(who),
                    )
                )  # fmt: skip
        return found
