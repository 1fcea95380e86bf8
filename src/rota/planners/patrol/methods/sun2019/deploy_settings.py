"""Settings of sensor deployment: Tables 2 and 7 of Sun et al. 2019, and a named value for all that it leaves open."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, get_args

from rota.errors import MissionError
from rota.planners.patrol.methods.sun2019.cells import BorderCells

DeployMethod = Literal["ccpso2", "greedy", "exact"]
Grouping = Literal["near", "random"]


def _require(ok: bool, name: str, value: object, allowed: str) -> None:
    """Raise MissionError that names a setting, its value and what is allowed, unless ok."""
    if not ok:
        raise MissionError(f"deploy.{name}: {value!r} is not allowed; {allowed}")


@dataclass(frozen=True, kw_only=True)
class DeploySettings:
    """How sensors are deployed (Section 4.2). Shares are of the virtual sensor's radius r_v = 2 r_s.

    Printed in the paper (Table 2): iterations, swarms, particles, the velocity's and the inertia's limits, c1, c2, and
    sensors_max where it is given. All else the paper leaves open; the comments beside the fields give our reasons.
    "Measured" is on our reconstruction of its Figure 13 with seeds 0, 1 and 2, where the values below take 86, 86 and
    85 sensors (the paper: 96), and 103, 103 and 102 without the heuristic rules.

    method: the paper's improved CCPSO2; "greedy" set cover; "exact" set cover (mixed-integer program, bounded by
    node_limit, with a proved bound).
    """

    method: DeployMethod = "ccpso2"

    # l_c; None: 0.24 r_v, the proportion of the paper's 50 x 50 cells on 120 m to its r_v of 10 m
    cell_m: float | None = None
    # "clipped" asks for all ground and no other; "centre" is the picture of the paper's Figure 4 (see cells_of)
    border_cells: BorderCells = "clipped"

    iterations: int = 150  # N_ITE
    swarms: int = 30  # N_SWA, K at the beginning
    particles: int = 50  # N_PAR, in each swarm
    # S_MAX, shared out among the zones by their cells; None: for each zone half as many again as a greedy cover takes,
    # which is what Table 2's 160 come to on its map. Where they do not suffice, a zone gets what it lacks all the same.
    sensors_max: int | None = None
    velocity_min: float = -0.1  # V_MIN and V_MAX, of the zone's width and height: in metres hardly anything would move
    velocity_max: float = 0.1
    inertia_max: float = 0.9  # A_MAX, from which omega falls evenly to A_MIN: the usual reading of two limits
    inertia_min: float = 0.4
    c1: float = 2.0
    c2: float = 2.0

    # lambda of Eq. 11: "lambda_1 >> lambda_2 >> lambda_3 > lambda_4 > 0"; powers of ten. 50 and 20 for the middle two
    # do as well (85, 84, 87 sensors measured).
    weight_in_obstacle: float = 10_000.0
    weight_uncovered: float = 100.0
    weight_sensor: float = 10.0
    weight_overlapped: float = 1.0

    # p of Algorithm 1, line 27; more rules find more (measured: 0.5 takes 89, 86, 90 sensors, 0.2 takes 87, 89, 90)
    rule_probability: float = 0.8
    velocity_probability: float = 0.5  # q of line 38: Eq. 2 and Eq. 3 in turn; 1 is Eq. 2 alone and 0 is Eq. 3 alone
    cauchy_probability: float = 0.5  # p of Eq. 3; as Li and Yao (2012) have it
    # the set from which s is drawn: with the rules large swarms find most, without them small ones do (measured, all of
    # 10 to 40: 83, 86, 83 sensors with and 124, 122, 135 without; all of 2 to 10: 88, 92, 92 and 106, 106, 102)
    group_sizes: tuple[int, ...] = (4, 10, 20, 30)
    # which sensors form a swarm: "near" each other, so that Fusion and Movement find partners, or at "random" as in Li
    # and Yao (97, 97, 97 sensors measured)
    grouping: Grouping = "near"

    addition: bool = True  # Eq. 7
    movement: bool = True  # Eq. 8
    deletion: bool = True  # Eq. 9
    fusion: bool = True  # Eq. 10
    # tau of Eq. 10: discs that their middle could replace lie nearer than r_v; more, since Movement closes what opens
    # (measured: 1.2 takes 88, 87, 87 sensors, 2.0 takes 88, 88, 87)
    fusion_share: float = 1.6
    addition_share: float = 0.8  # how near to the uncovered cell: anywhere from where it is in range
    movement_share: float = 0.3  # the longest "short distance" of Eq. 8
    movement_around: float = 2.0  # how near a sensor is that counts as "around the cell"
    # Movements after one Fusion, until all is covered: with one only a gap stays, and the next Addition undoes the
    # Fusion (measured: 99, 99, 99 sensors)
    movement_repeats: int = 20
    # share of rule updates that begin from the best of the neighbourhood (Eq. 4) and not from where the particle
    # strayed to; 0 is the letter of Algorithm 1 (measured: 96, 95, 95 sensors)
    rules_from_best: float = 0.5

    node_limit: int = 1  # of the exact cover's branch and bound, for each zone; more nodes may find fewer sensors

    def __post_init__(self) -> None:
        _require(self.method in get_args(DeployMethod), "method", self.method, ", ".join(get_args(DeployMethod)))
        _require(self.border_cells in get_args(BorderCells), "border_cells", self.border_cells, "clipped or centre")
        _require(self.grouping in get_args(Grouping), "grouping", self.grouping, "near or random")
        ok = self.cell_m is None or (math.isfinite(self.cell_m) and self.cell_m > 0)
        _require(ok, "cell_m", self.cell_m, "must be a finite number of metres greater than 0, or none")
        for name, least in (("iterations", 1), ("swarms", 1), ("particles", 1), ("movement_repeats", 1)):
            _require(getattr(self, name) >= least, name, getattr(self, name), f"must be {least} or more")
        _require(self.node_limit >= 1, "node_limit", self.node_limit, "must be 1 or more")
        ok = self.sensors_max is None or self.sensors_max >= 1
        _require(ok, "sensors_max", self.sensors_max, "must be 1 or more, or none")
        sizes = self.group_sizes
        ok = len(sizes) > 0 and all(size >= 1 for size in sizes)
        _require(ok, "group_sizes", sizes, "must be numbers of sensors, at least one of them, each 1 or more")
        weights = self.weights
        ok = math.inf > weights[0] > weights[1] > weights[2] > weights[3] > 0
        _require(ok, "weights", weights, "must fall and stay above 0: in obstacle, uncovered, sensor, overlapped")
        for name in ("rule_probability", "velocity_probability", "cauchy_probability", "rules_from_best"):
            _require(0 <= getattr(self, name) <= 1, name, getattr(self, name), "must lie in 0..1")
        _require(self.velocity_min < self.velocity_max, "velocity_min", self.velocity_min, "must be below velocity_max")
        _require(self.inertia_min <= self.inertia_max, "inertia_min", self.inertia_min, "must not exceed inertia_max")
        for name in ("fusion_share", "addition_share", "movement_share", "movement_around", "c1", "c2"):
            value = getattr(self, name)
            _require(math.isfinite(value) and value >= 0, name, value, "must be a finite number, 0 or more")

    @property
    def weights(self) -> tuple[float, float, float, float]:
        """Lambda 1 to 4 of Eq. 11."""
        return (self.weight_in_obstacle, self.weight_uncovered, self.weight_sensor, self.weight_overlapped)

    @property
    def has_rules(self) -> bool:
        """Whether any heuristic rule is on."""
        return self.addition or self.movement or self.deletion or self.fusion

    def without_rules(self) -> DeploySettings:
        """The same without the heuristic rules: the normal CCPSO2 of Figure 6b."""
        return replace(self, addition=False, movement=False, deletion=False, fusion=False)


TABLE_2 = DeploySettings(iterations=150, swarms=30, particles=50, sensors_max=160)
"""Table 2: Figure 13's parameters."""
