"""What a search is given besides the problem: how much work, who judges, whom to tell, when to stop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rota.mission import Effort
from rota.plan import Plan
from rota.planners.patrol.problem import Problem
from rota.search_state import Watch


class DemandOutcome(Protocol):
    """What the search reads of the verdict on one demand."""

    @property
    def name(self) -> str:
        """The zone's name, or "area"."""
        ...

    @property
    def period_s(self) -> float:
        """What is asked."""
        ...

    @property
    def worst_gap_s(self) -> float:
        """No point waits longer (inf: some of it is never seen, or so the verdict must assume)."""
        ...

    @property
    def worst_gap_at_least_s(self) -> float:
        """Some point waits as long (inf: it is never seen)."""
        ...


class Fault(Protocol):
    """What the search reads of something that is wrong with the routes themselves."""

    @property
    def kind(self) -> str:
        """What it is: "bodies touch", say."""
        ...

    @property
    def who(self) -> str:
        """The robots, or the robot."""
        ...

    @property
    def place_m(self) -> tuple[float, float] | None:
        """Where it is (None: nowhere in particular)."""
        ...

    @property
    def time_s(self) -> float | None:
        """When it is (None: at no particular time)."""
        ...

    @property
    def value(self) -> float:
        """How much it is."""
        ...

    @property
    def limit(self) -> float:
        """How much is allowed."""
        ...

    @property
    def unit(self) -> str:
        """Of both."""
        ...


class Verdict(Protocol):
    """What the search reads of the verdict on a plan."""

    @property
    def verdict(self) -> str:
        """Whether every demand is "met"."""
        ...

    @property
    def demands(self) -> tuple[DemandOutcome, ...]:
        """One outcome per demand."""
        ...

    @property
    def violations(self) -> Sequence[Fault]:
        """What is wrong with the routes, and demands that are violated."""
        ...

    @property
    def unmet_points_m(self) -> NDArray[np.float64]:
        """Places (n, 2) where the demand is not shown to be met."""
        ...

    @property
    def unmet_demand(self) -> NDArray[np.int64]:
        """For each of these places the index of its demand."""
        ...


Judge = Callable[[Plan], Verdict]


@dataclass(frozen=True, kw_only=True)
class Work:
    """Bounds of the work.

    moves: of one annealing, for tours of a few hundred corners; most_moves: for any. screened: splits of the ground for
    one number of robots, the roomiest, that are annealed a little. tries: those of them that are annealed in full, each
    up to ``coolings`` times, cooler and cooler. repairs: rounds of mending. groupings: of the period classes.
    least_squeeze: budgets, as a multiple of the ideal lengths, below which a number of robots is not tried.
    stretches: of the periods, tried for the best that a fixed number of robots can do, until one that failed and one
    that passed differ by no more than the factor ``nearness``. begins_anew: whether from new tours too, after some
    have passed.
    """

    moves: int
    most_moves: int
    screened: int
    tries: int
    coolings: int
    repairs: int
    groupings: int
    least_squeeze: float
    stretches: int
    nearness: float
    begins_anew: bool


WORK: dict[Effort, Work] = {
    "quick": Work(
        moves=300_000,
        most_moves=2_000_000,
        screened=6,
        tries=2,
        coolings=4,
        repairs=12,
        groupings=4,
        least_squeeze=1.15,
        stretches=4,
        nearness=1.025,
        begins_anew=False,
    ),
    "normal": Work(
        moves=1_200_000,
        most_moves=10_000_000,
        screened=8,
        tries=2,
        coolings=4,
        repairs=20,
        groupings=8,
        least_squeeze=1.1,
        stretches=6,
        nearness=1.015,
        begins_anew=True,
    ),
    "high": Work(
        moves=10_000_000,
        most_moves=100_000_000,
        screened=16,
        tries=8,
        coolings=12,
        repairs=30,
        groupings=16,
        least_squeeze=1.05,
        stretches=9,
        nearness=1.01,
        begins_anew=True,
    ),
}


@dataclass(frozen=True, kw_only=True)
class Context:
    """One search: the problem, the seed and the caller's wishes.

    dear: how many times more than on open ground it is worth, while annealing, to see anything. watch: told of the
    states that the search comes to, from several threads; it changes nothing of what is found.
    """

    problem: Problem
    seed: int
    judge: Judge
    progress: Callable[[float, str], None]
    should_stop: Callable[[], bool]
    dear: float = 1.0
    watch: Watch | None = None

    @property
    def work(self) -> Work:
        """The bounds that the mission's effort sets."""
        return WORK[self.problem.mission.patrol.effort]
