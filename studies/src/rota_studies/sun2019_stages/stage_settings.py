"""Settings of the stages that are the same by whatever algorithm: cells, distances between sensors, the frame's work.

Sun et al., Sensors 19(9):1994, 2019.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from rota.model.planner_settings import LENGTH, LENGTH_OR_ZERO, Settings, setting

SegmentRoutes = Literal["shortened", "repaired", "printed"]
BorderCells = Literal["clipped", "centre"]
Distance = Literal["graph", "euclidean"]


@dataclass(frozen=True, kw_only=True)
class SensorSettings(Settings):
    """The deployment of virtual sensors, of radius r_v = 2 r_s: Section 4.2."""

    place: ClassVar[str] = "patrol.sun2019.sensors"

    # None: the proportion of the paper's 50 x 50 cells on 120 m to its r_v of 10 m
    cell_m: float | None = setting(None, "l_c, side of a cell; null: 0.24 r_v", written=LENGTH, above=0)
    # "clipped" asks for all ground and no other; "centre" is the picture of the paper's Figure 4 (see cells_of)
    border_cells: BorderCells = setting("clipped", "cells at borders: clipped, or whole where their centre is inside")


@dataclass(frozen=True, kw_only=True)
class AStarWeights(Settings):
    """The weights tau of Eqs. 16 and 17, which the paper does not give; 1 each is ordinary A*, which is exact.

    tau_3, of obstacles, has nothing left to weigh: no edge leads through one.
    """

    place: ClassVar[str] = "patrol.sun2019.frame.a_star"
    before: float = setting(1.0, "tau_1 of Eq. 16: of the cost so far", least=0, most=1e6)
    step: float = setting(1.0, "tau_2 of Eq. 16: of the step", least=0, most=1e6)
    rest: float = setting(1.0, "tau_4 of Eq. 17: of the straight way that remains", least=0, most=1e6)


@dataclass(frozen=True, kw_only=True)
class PathSettings(Settings):
    """How sensors are apart and how the frame leads from one to the next, whoever orders them: Section 4.3.

    alpha_m: the paper has alpha > 0 and no value; 10,000 fits its tour of 61,025.99, whose actual length is 1,027.40 m,
    as six changes. 0 leaves the term out, to compare. neighbour_range: the paper asks for r_n >= 2 r_v. a_star: other
    weights change legs' paths, not the order.
    """

    place: ClassVar[str] = "patrol.sun2019.frame"
    distance: Distance = setting(
        "graph", "between sensors: graph, Eq. 14, or euclidean, through walls, as in Figure 8a"
    )
    alpha_m: float = setting(
        10_000.0, "alpha of Eqs. 12 and 19: a change of sub-region", written=LENGTH_OR_ZERO, least=0
    )
    neighbour_range: float = setting(2.0, "r_n of Section 4.3, in r_v", least=2, most=1e6)
    a_star: AStarWeights = setting(AStarWeights)


@dataclass(frozen=True, kw_only=True)
class FrameSettings(PathSettings):
    """The frame, a tour past all sensors: Section 4.3, Algorithm 2, Table 3.

    kicks_per_waypoint: 50 comes within 1 % of the best known tours of 1,000 random points.
    """

    kicks_per_waypoint: int = setting(50, "work of tour local_search", least=0, most=10_000)
