"""What all runs of a rehearsal have in common: the places that are looked at, and when they are seen by plan."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely

from rota.check.counting import groups_of
from rota.check.demands import DemandedGround
from rota.check.seeable import seeable
from rota.check.standing import standing_areas
from rota.errors import MissionError, RotaError
from rota.live.kernels import PlannedSights
from rota.live.places import places_of
from rota.live.planned_sights import sights_of_plan
from rota.model.arrays import Flags, Floats, Ints
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota.rehearsal.conditions import Conditions
from rota.rehearsal.contacts import Pair, pairs_near
from rota.rehearsal.drive_kernels import Batteries
from rota.rehearsal.kernels import Asked
from rota.routes.charging_legs import ChargingLegs, charging_legs
from rota.routes.flights import has_flights
from rota.routes.who_relieves import robots_that_relieve

HOUR_S = 3600.0
MOST_PLACES = 10_000
MOST_CORNERS = 2_000
CORNER_IN_M = 0.01  # how far inside of a corner it is looked at
TICK_S = 1.0  # how often a robot is compared with the clock
TICKS_PER_PERIOD = 20
MOST_TICKS = 25_000_000  # of all robots: 200 MB


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """A plan made ready to be rehearsed. Runs begin at 0; they are looked at from begin_s to end_s.

    demands: what is asked, empty ground left out. points_m: (n, 2) the places; those after them, one each, stand for
    demands to visit. asked: weights are what share of its demand each place stands for: points of a lattice equal ones,
    corners of zones none, since they are looked at beside it. sights: of the places by plan. pairs: of robots whose
    bodies can touch. batteries: what the plan asks of them.
    """

    plan: Plan
    conditions: Conditions
    demands: tuple[DemandedGround, ...]
    points_m: Floats
    asked: Asked
    sights: PlannedSights
    pairs: tuple[Pair, ...]
    batteries: Batteries
    begin_s: float
    end_s: float
    tick_s: float

    @property
    def ticks(self) -> int:
        """How many ticks a run has."""
        return math.ceil(self.end_s / self.tick_s) + 1

    @property
    def charges(self) -> bool:
        """Whether any robot charges, or has a battery that runs down."""
        return any(way.charges for way in self.plan) or bool(np.isfinite(self.batteries.endurance_s).any())

    @cached_property
    def relieves_nobody(self) -> Flags:
        """Which robots (k,) leave chargers for loops that nobody holds for them: when they are late nobody waits."""
        relieve = robots_that_relieve(self.plan)
        flying = [has_flights(way) and way.loop_duration_s > 0 for way in self.plan]
        return np.array([flies and way.robot not in relieve for flies, way in zip(flying, self.plan, strict=True)])

    def most_charges(self, way: Trajectory) -> int:
        """How often a robot is at a charger in a run at most."""
        rounds = 2 + int(self.ticks * self.tick_s / way.loop_duration_s) if way.loop_duration_s else 1
        return rounds * len(way.charges)


def scene_of(plan: Plan, conditions: Conditions) -> Scene:
    """The scene of a plan.

    Raises MissionError for runs that are too long for so many robots, RotaError where there is nothing to rehearse.
    """
    if not len(plan.trajectories):
        raise RotaError("the plan has no robots; there is nothing to rehearse")
    begin_s = max(way.loop_start_s for way in plan)
    end_s = begin_s + conditions.hours * HOUR_S
    places = places_of(plan.mission, MOST_PLACES)
    if not places.demands:
        raise RotaError("the mission asks for nothing; there is nothing to rehearse")
    tick_s = min(TICK_S, float(places.periods_s.min()) / TICKS_PER_PERIOD)
    if len(plan.trajectories) * end_s / tick_s > MOST_TICKS:
        most_h = (MOST_TICKS * tick_s / len(plan.trajectories) - begin_s) / HOUR_S
        raise MissionError(
            f"hours: {conditions.hours:g} is not allowed; at most {max(most_h, 0.0):.0f} are with so many robots"
        )
    corners_m, corner_of = _corners(plan.mission, places.demands)
    lattice = places.points
    points_m = np.ascontiguousarray(np.vstack([places.points_m[:lattice], corners_m]))
    demand = np.concatenate([places.demand[:lattice], corner_of, places.demand[lattice:]])
    counts = np.bincount(places.demand, minlength=len(places.demands))
    weights = np.where(np.isin(np.arange(len(demand)), lattice + np.arange(len(corner_of))), 0.0, 1 / counts[demand])
    periods_s = np.array([each.period_s for each in places.demands])[demand]
    return Scene(
        plan=plan,
        conditions=conditions,
        demands=places.demands,
        points_m=points_m,
        asked=Asked(demand, np.ascontiguousarray(periods_s), weights),
        sights=sights_of_plan(plan, points_m, demand, places.demands),
        pairs=pairs_near(plan),
        batteries=batteries_of(plan),
        begin_s=begin_s,
        end_s=end_s,
        tick_s=tick_s,
    )


def scene_with(scene: Scene, plan: Plan) -> Scene:
    """The scene in which the same robots, in the same order, drive another plan for the same ground."""
    return replace(
        scene,
        plan=plan,
        sights=sights_of_plan(plan, scene.points_m, scene.asked.demand, scene.demands),
        pairs=pairs_near(plan),
        batteries=batteries_of(plan),
    )


def _corners(mission: Mission, demands: Sequence[DemandedGround]) -> tuple[Floats, Ints]:
    """Places (n, 2) just inside the corners of all that is to be seen and can be, and the demand (n,) of each.

    Where there are more than ``MOST_CORNERS``, every so-and-so-many-th.
    """
    found, owner = [np.empty((0, 2))], [np.empty(0, np.int64)]
    for k, each in enumerate(demands):
        if each.demand == "every_point":
            inside = shapely.buffer(each.region, -CORNER_IN_M, join_style="mitre")
            found.append(shapely.get_coordinates(inside))
            owner.append(np.full(len(found[-1]), k, np.int64))
    corners_m, corner_of = np.vstack(found), np.concatenate(owner)
    step = math.ceil(max(1, len(corners_m)) / MOST_CORNERS)
    corners_m, corner_of = np.ascontiguousarray(corners_m[::step]), corner_of[::step]
    seen = np.zeros(len(corners_m), np.bool_)
    for names, own in groups_of(demands):
        mine = np.isin(corner_of, own)
        if mine.any():
            seen[mine] = seeable(mission, standing_areas(mission, names), corners_m[mine])
    return corners_m[seen], corner_of[seen]


def batteries_of(plan: Plan) -> Batteries:
    """What the plan asks of the battery of each robot."""
    robots = [plan.mission.fleet.robot(way.robot) for way in plan]
    legs = [charging_legs(way, robot, plan.mission.chargers) for way, robot in zip(plan, robots, strict=True)]
    firsts = np.concatenate([[0], np.cumsum([len(own.ends_s) for own in legs], dtype=np.int64)])
    joined = {name: np.concatenate([getattr(own, name) for own in legs]) for name in ChargingLegs._fields}
    return Batteries(
        firsts=firsts,
        again=firsts[:-1] + np.array([way.loop_index for way in plan], np.int64),
        loops_s=np.array([way.loop_duration_s for way in plan], np.float64),
        endurance_s=np.array([robot.battery.endurance_s or math.inf for robot in robots], np.float64),
        takeoff_s=np.array([robot.battery.departure_s for robot in robots], np.float64),
        landing_s=np.array([robot.battery.landing_s for robot in robots], np.float64),
        climbing_s=np.array([robot.battery.climbing_s for robot in robots], np.float64),
        reserve_s=np.array([robot.battery.reserve_s for robot in robots], np.float64),
        **joined,
    )
