"""What a reader may choose about the frame and its partition, and what the paper leaves open (Sun et al. 2019)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal


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
    a_star: the weights tau of Eqs. 16 and 17, not given; 1 makes A* exact.
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


def _require(ok: bool, name: str, value: object, allowed: str) -> None:
    if not ok:
        raise ValueError(f"{name}: {value!r} is not allowed; must be {allowed}")


def _require_share(name: str, value: float) -> None:
    _require(math.isfinite(value) and value >= 0, name, value, "a finite number, 0 or more")


TABLE_3 = TourSettings(method="genetic", generations=10_000, population=600)
