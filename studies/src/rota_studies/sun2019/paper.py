"""What the paper prints (Sun et al., Sensors 19(9):1994, 2019), each number with its place; nothing here is ours."""

from __future__ import annotations

from typing import NamedTuple

CITATION = (
    "G. Sun, R. Zhou, B. Di, Z. Dong and Y. Wang, “A Novel Cooperative Path Planning for Multi-robot Persistent "
    "Coverage with Obstacles and Coverage Period Constraints”, *Sensors* 19(9):1994, 2019, "
    "<https://doi.org/10.3390/s19091994>"
)


class PaperRoute(NamedTuple):
    """One row of Table 5, 6 or 8: T^c, T^a in seconds, and the sub-region, which Tables 5 and 8 do not print."""

    period_s: float
    time_s: float
    zone: int | None = None

    @property
    def late(self) -> bool:
        """Whether Eq. 25 does not hold."""
        return self.time_s >= self.period_s


class PaperCase(NamedTuple):
    """Periods of zone 1, zone 2 and the rest in seconds, and the routes of the table."""

    name: str
    periods_s: tuple[float, float, float]
    routes: tuple[PaperRoute, ...]

    @classmethod
    def of(
        cls,
        name: str,
        periods_s: tuple[float, float, float],
        *routes: tuple[float, float] | tuple[float, float, int],
    ) -> PaperCase:
        """A case from the rows of its table."""
        return cls(name, periods_s, tuple(PaperRoute(*route) for route in routes))


class PaperRun(NamedTuple):
    """What the text beside Figures 13 and 16 tells of the three algorithms; None: not told.

    sensors: in each zone. cost: of the first swarms and in the end (Eq. 11). cost_iteration: from which on it stayed.
    tour_length: Eq. 12; length_m: without alpha. stable_generation, best_generation: of the genetic algorithm.
    partition_cost, partition_iteration: Eq. 28, and the iteration that reached it.
    """

    sensors: tuple[int, int, int]
    first_cost: float
    last_cost: float
    cost_iteration: int | None
    tour_length: float
    length_m: float | None
    stable_generation: int
    best_generation: int | None
    partition_cost: float
    partition_iteration: int


# Section 4.2, beside Figure 6
SENSORS_WITH_RULES, SENSORS_WITHOUT_RULES = 99, 103
# Section 4.3, beside Figure 8: changes of sub-region with Euclidean distances and with Eq. 14's
CROSSINGS_EUCLIDEAN, CROSSINGS_GRAPH = 8, 2
# Table 4, against the text beside Figures 13 and 16
TABLE_4_ITERATIONS = 50
# between which its own plans have xi_1 of Eq. 28, see ``SegmentSettings``
LEAST_WEIGHT, MOST_WEIGHT = 362.0, 523.0

FIGURE_13 = PaperRun(
    sensors=(10, 15, 71), first_cost=5743, last_cost=3600, cost_iteration=139, tour_length=61_025.99,
    length_m=1_027.40, stable_generation=1722, best_generation=7113, partition_cost=5_709.23, partition_iteration=168,
)  # fmt: skip
"""Section 5.1, below Table 5."""

FIGURE_16 = PaperRun(
    sensors=(7, 5, 71), first_cost=7613, last_cost=5321, cost_iteration=None, tour_length=61_025.99,
    length_m=None, stable_generation=5156, best_generation=None, partition_cost=9_343.48, partition_iteration=102,
)  # fmt: skip
"""Section 5.3, below Table 8."""

FRAME_BY_ZONE = ("94 to 108", "172", "705")
"""Metres of the frame in sub-regions 1, 2 and 3 that the times of Tables 5 and 6 leave room for; reckoned."""

TABLE_5 = PaperCase.of(
    "Section 5.1", (8, 20, 40),
    (40.00, 36.37), (20.00, 18.81), (40.00, 37.29), (8.00, 6.75), (8.00, 7.19),
)  # fmt: skip
"""Table 5, with the periods of Table 1."""

TABLE_6 = (
    PaperCase.of(
        "Case 1", (12, 10, 40),
        (10.00, 9.33, 2), (10.00, 8.68, 2), (40.00, 38.39, 3), (12.00, 10.95, 1), (40.00, 38.22, 3),
    ),
    PaperCase.of(
        "Case 2", (12, 20, 30),
        (20.00, 19.47, 2), (20.00, 19.41, 2), (30.00, 28.77, 3), (12.00, 10.95, 1), (30.00, 29.03, 3),
    ),
    PaperCase.of(
        "Case 3", (12, 7, 40),
        (7.00, 6.30, 2), (7.00, 5.74, 2), (7.00, 5.91, 2), (7.00, 5.57, 2), (40.00, 36.22, 3), (12.00, 10.95, 1),
        (40.00, 38.22, 3),
    ),
    PaperCase.of(
        "Case 4", (12, 10, 20),
        (10.00, 9.33, 2), (10.00, 8.74, 2), (10.00, 6.35, 2), (20.00, 18.48, 2), (20.00, 18.83, 3), (12.00, 10.95, 1),
        (20.00, 18.92, 3), (20.00, 18.65, 3),
    ),
    PaperCase.of(
        "Case 5", (8, 10, 20),
        (10.00, 6.94, 2), (10.00, 8.82, 2), (10.00, 9.34, 2), (20.00, 18.28, 3), (20.00, 19.27, 3), (8.00, 7.24, 1),
        (8.00, 7.40, 1), (20.00, 17.20, 3), (20.00, 18.52, 3),
    ),
    PaperCase.of(
        "Case 6", (12, 10, 10),
        (10.00, 9.53, 2), (10.00, 9.75, 2), (10.00, 8.97, 2), (10.00, 9.05, 3), (10.00, 9.41, 3), (10.00, 9.05, 3),
        (12.00, 10.95, 1), (10.00, 11.64, 3), (10.00, 10.53, 3), (10.00, 10.90, 3), (10.00, 10.41, 3),
    ),
)  # fmt: skip

TABLE_8 = PaperCase.of(
    "Section 5.3", (10, 12, 45),
    (45.00, 44.12), (45.00, 37.65), (12.00, 10.12), (45.00, 39.17), (10.00, 7.86), (10.00, 8.00), (45.00, 39.14),
)  # fmt: skip
