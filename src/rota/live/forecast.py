"""What will happen if robots go on as planned, each as far behind its plan as it is: which periods lapse, and when."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rota.check.demands import visits
from rota.check.revisits import Sights, sights_of
from rota.check.routes import HOLD, LOOP
from rota.check.tolerances import slack_of
from rota.live import kernels
from rota.live.kernels import PlannedSights, Team
from rota.live.places import Places
from rota.plan import Plan

Floats = NDArray[np.float64]
Sight = tuple[int, float, float, bool]

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
        self._sights = planned(plan, places)

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
        when, where = kernels.first_lapses(
            last_seen_s, places.demand, count, places.periods_s, now_s, later_s, PERIODS_AHEAD, self._sights, team
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


def planned(plan: Plan, places: Places) -> PlannedSights:
    """The sights of all places by plan, in closed form as the check has them; visits after the points."""
    bounds = plan.mission.area.bounds
    sights = sights_of(plan, bounds)
    points = np.ascontiguousarray(places.points_m[: places.points] - sights.origin_m)
    arrays = kernels.planned_sights(points, sights.slack_m, sights.grid, sights.legs, sights.team, sights.walls)
    rows = [_visits(plan, sights, demand.region) for demand in places.demands if demand.demand == "visit"]
    offsets, *columns = arrays
    ends = offsets[-1] + np.cumsum([len(row) for row in rows], dtype=np.int64)
    flat = [sight for row in rows for sight in row]
    kinds = (np.int64, np.float64, np.float64, np.bool_)
    added: list[NDArray[Any]] = [np.array([sight[k] for sight in flat], kind) for k, kind in enumerate(kinds)]
    joined = [np.concatenate(pair) for pair in zip(columns, added, strict=True)]
    return PlannedSights(np.concatenate([offsets, ends]), *joined)


def _visits(plan: Plan, sights: Sights, region: object) -> list[Sight]:
    """When robots are in a region by plan: robot, start, end and whether it repeats."""
    routes = sights.routes
    found: list[Sight] = []
    for leg, lo, hi in visits(routes.legs_m, region, slack_of(plan.mission)):
        t0, t1 = (float(time) for time in routes.times_s[leg])
        end = math.inf if routes.kinds[leg] == HOLD else t0 + hi * (t1 - t0)
        row = (int(routes.robots[leg]), t0 + lo * (t1 - t0), end, bool(routes.kinds[leg] == LOOP))
        before = found[-1] if found else None
        if before and before[0] == row[0] and before[3] == row[3] and row[1] <= before[2] + kernels.SAME_S:
            found[-1] = (row[0], before[1], max(before[2], row[2]), row[3])
        else:
            found.append(row)
    return found
