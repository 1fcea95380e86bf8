"""What a reader may choose about the frame and its partition, and what the paper leaves open (Sun et al. 2019)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal, get_args

TooFew = Literal["least_late", "even"]

LEAST_WEIGHT, MOST_WEIGHT = 362.0, 523.0
"""Between which the paper's own plans have xi_1 of Eq. 28, see ``PartitionSettings``."""


@dataclass(frozen=True, kw_only=True)
class AStarWeights:
    """The weights tau of Eqs. 16 and 17, which the paper does not give; 1 each is ordinary A*, which is exact.

    tau_1 ``before``: of the cost so far; tau_2 ``step``: of the step; tau_4 ``rest``: of the straight way that remains.
    tau_3, of obstacles, has nothing left to weigh: no edge leads through one.
    """

    before: float = 1.0
    step: float = 1.0
    rest: float = 1.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            _require_share(f"a_star.{name}", value)


@dataclass(frozen=True, kw_only=True)
class TourSettings:
    """How the frame is found.

    method: "local_search", the default, is shorter and faster; "genetic" is the paper's Algorithm 2.
    distance: "graph" is Eq. 14; "euclidean" is the straight distance, obstacles and sub-regions ignored, which
    Figure 8 compares it with.
    alpha: metres that a change of sub-region counts as (Eq. 12). The paper does not say; 10,000 fits its tour of
    61,025.99, whose actual length is 1,027.40 m, as six changes.
    neighbour_range: r_n as a multiple of the virtual sensors' radius r_v. The paper asks for 2 or more.
    a_star: the weights tau of Eqs. 16 and 17, not given; 1 makes A* exact. Others change legs' paths, not the order.
    generations, population: of the genetic algorithm, Table 3.
    regroup_every: generations between two draws of its groups of four; not given. 500 keeps many families apart long
    enough to become short; with 1, tours over 96 sensors ended 7 % longer than the shortest known.
    reversal_tries: stretches drawn, at most, until one is found whose reversal is "valid", that is shortens the tour.
    The paper speaks of one; with 20, tours ended within 2 % of the shortest known, with 1 within 5 %.
    kicks_per_waypoint: work of the local search; 50 comes within 1 % of the best known tours of 1,000 random points.
    """

    method: Literal["local_search", "genetic"] = "local_search"
    distance: Literal["graph", "euclidean"] = "graph"
    alpha: float = 10_000.0
    neighbour_range: float = 2.0
    a_star: AStarWeights = field(default_factory=AStarWeights)
    generations: int = 10_000
    population: int = 600
    regroup_every: int = 500
    reversal_tries: int = 20
    kicks_per_waypoint: int = 50

    def __post_init__(self) -> None:
        _require(self.method in ("local_search", "genetic"), "method", self.method, "local_search or genetic")
        _require(self.distance in ("graph", "euclidean"), "distance", self.distance, "graph or euclidean")
        _require_share("alpha", self.alpha)
        ok = math.isfinite(self.neighbour_range) and self.neighbour_range >= 2
        _require(ok, "neighbour_range", self.neighbour_range, "a finite number, 2 or more")
        for name in ("generations", "regroup_every", "reversal_tries"):
            _require(getattr(self, name) >= 1, name, getattr(self, name), "1 or more")
        _require(self.population >= 4 and self.population % 4 == 0, "population", self.population, "a multiple of 4")
        _require(self.kicks_per_waypoint >= 0, "kicks_per_waypoint", self.kicks_per_waypoint, "0 or more")


@dataclass(frozen=True, kw_only=True)
class PartitionSettings:
    """How the frame is cut into segments, one robot each.

    method: "exact", the default, is the optimum by dynamic programming; "pso" is the paper's Algorithm 3.
    times: what Eq. 26 is taken for. "routes": the length of the closed route round the segment over the speed, as it is
    printed; the exact method then gives what Eq. 28 costs least. "estimate": twice the segment's length and 2 pi r_s,
    which needs no routes and is what our method begins with.
    joining_legs: whether a segment includes the leg from the last sensor of the segment before to its own first one, as
    Eq. 22 has it (the curve from one termination point to the next). The sensors' discs are covered without it, so that
    the default leaves it out. The paper's times say that it counts: the routes of Table 5 are 2,128 m long in all, and
    a frame of 1,027.40 m without five of its 96 legs has no five routes longer than 2,105 m round it (2 x 974 m and
    five times 2 pi r_s); with all of them it has routes of up to 2,212 m, less what bends save.
    margin_s: T_m of Eq. 28, by which a route must be shorter than its period.
    too_few: what the exact method makes smallest where the segments asked for are too few to keep all periods: the sum
    of what routes are late, as Eq. 28 has it, "least_late"; or the largest share of a period, "even", for routes that
    are to be shortened all alike afterwards. Only with the estimate.
    weight_late, weight_segments, weight_early: xi_1, xi_2 and xi_3 of Eq. 28. Not given, but T_m = 0.5 s, xi_2 = 1000
    and xi_3 = 100 give the cost 5709.23 of Figure 13 from Table 5 (5709.0, and its times are rounded); the cost 9343.48
    of Figure 16 would follow (9344) if one of Table 8's times were a second too long (9244 as printed). xi_1 is
    bounded by what the paper's plans leave undone. Table 6 prints 10.95 s for a single route of zone 1 in five cases;
    at the 8 s of Section 5.1 it is late by 3.45 s, the margin counted, and two routes instead are called cheaper: xi_1
    is at least 320, and ``LEAST_WEIGHT`` where the spare 1.42 s goes to the rest. In Case 6 routes are late by 5.76 s
    and a plan without that is called dearer: at most ``MOST_WEIGHT`` if two routes more would have been enough. The
    default lies between them. 10,000 would make Case 6 as printed cost 68,807.
    iterations, swarms, particles, least_velocity, most_velocity (shares of the frame), most_inertia, least_inertia,
    own_pull (c_1), swarm_pull (c_2): Table 4. Its 50 iterations contradict the text, whose cost still falls in the
    168th.
    """

    method: Literal["exact", "pso"] = "exact"
    times: Literal["estimate", "routes"] = "estimate"
    joining_legs: bool = False
    margin_s: float = 0.0
    too_few: TooFew = "least_late"
    weight_late: float = 440.0
    weight_segments: float = 1_000.0
    weight_early: float = 100.0
    iterations: int = 50
    swarms: int = 500
    particles: int = 1000
    least_velocity: float = -0.1
    most_velocity: float = 0.1
    most_inertia: float = 0.9
    least_inertia: float = 0.4
    own_pull: float = 2.0
    swarm_pull: float = 2.0

    def __post_init__(self) -> None:
        _require(self.method in ("exact", "pso"), "method", self.method, "exact or pso")
        _require(self.times in ("estimate", "routes"), "times", self.times, "estimate or routes")
        _require(self.too_few in get_args(TooFew), "too_few", self.too_few, "least_late or even")
        for name in ("margin_s", "weight_late", "weight_segments", "weight_early", "own_pull", "swarm_pull"):
            _require_share(name, getattr(self, name))
        for name in ("iterations", "swarms", "particles"):
            _require(getattr(self, name) >= 1, name, getattr(self, name), "1 or more")
        for least, most in (("least_velocity", "most_velocity"), ("least_inertia", "most_inertia")):
            low, high = getattr(self, least), getattr(self, most)
            _require(math.isfinite(low) and math.isfinite(high), f"{least}, {most}", (low, high), "finite numbers")
            _require(low <= high, least, low, f"at most {most}, {high!r}")


def _require(ok: bool, name: str, value: object, allowed: str) -> None:
    """Raise ValueError that names a setting, its value and what is allowed, unless ok."""
    if not ok:
        raise ValueError(f"{name}: {value!r} is not allowed; must be {allowed}")


def _require_share(name: str, value: float) -> None:
    """Raise ValueError unless the value is a finite number, 0 or more."""
    _require(math.isfinite(value) and value >= 0, name, value, "a finite number, 0 or more")


TABLE_3 = TourSettings(method="genetic", generations=10_000, population=600)

TABLE_4 = PartitionSettings(method="pso", times="routes", joining_legs=True, margin_s=0.5)
