"""The settings of what makes tours see everything and short: samples, linear programs, annealing for length.

A share is of the whole: ground, a budget, the reach. ``efforts`` holds the values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True, kw_only=True)
class SamplingSettings:
    """The lattice of sample points that stands for the ground.

    per_reach: samples along one inner reach of the sensor.
    shrink: sensors are taken to reach less by this share of the spacing, for the ground between samples.
    few_samples: on small ground samples lie denser, up to about so many of them, since they are few anyway.
    most_samples: the spacing is wider where more samples than this would be needed.
    """

    per_reach: int
    shrink: float
    few_samples: int = 0
    most_samples: int = 400_000


@dataclass(frozen=True, kw_only=True)
class BendingSettings:
    """Tours bent by linear programs, one step after another.

    least_gain: a step must promise at least this share of the cost.
    range_weight: of a metre of range that a sample lacks.
    move_weight: of a metre that a vertex moves along an axis, so that what need not move stays.
    length_weight: of a metre of the tours; 0 where all that counts is that they keep within their budgets.
    shares: whether legs share what they see about as well, see ``share_kernels``; programs take four times as long.
    """

    least_gain: float = 1e-3
    range_weight: float = 5.0
    move_weight: float = 1e-3
    length_weight: float = 0.0
    shares: bool = False


class ShorteningStage(NamedTuple):
    """One annealing for length.

    moves: for each reach of ideal loop, which is the ground over the swath.
    hot, cold: heat at the beginning and at the end, as shares of the reach.
    coverage_weight: multiple of the usual weight of seeing.
    coarse: whether the samples are few, which is enough while tours find their shape.
    vertex_price: what a vertex more costs, as a multiple of the heat.
    """

    moves: int
    hot: float
    cold: float
    coverage_weight: float
    coarse: bool = False
    vertex_price: float = 0.0


class ShorteningAttempt(NamedTuple):
    """Annealings one after another, then a repair.

    bold: whether it leaves much unseen while hot; not made where loops are nested, whose rounds have no room for that
    later, nor where turns cost something.
    """

    stages: tuple[ShorteningStage, ...]
    bold: bool = False

    @property
    def moves(self) -> int:
        """Of all its annealings, for each reach of ideal loop."""
        return sum(stage.moves for stage in self.stages)


@dataclass(frozen=True, kw_only=True)
class ShorteningSettings:
    """Shorter loops for the plan with the fewest robots found.

    attempts: each begins with the tours found; the first that gives shorter loops is the last.
    further: attempts to shorten what that gave, one after another; each is kept if it gives shorter loops yet.
    coarse, fine: the samples of annealing; with range that is taken much shorter robots would weave.
    rounds: of the repair, as ``RepairSettings`` has them.
    most_work: moves of all attempts together, rounds of repair counted as moves. Counted and not timed, so that the
        same seed gives the same plan on any machine. An attempt that would take more is left out.
    round_moves: what a round of repair counts, for each reach of ideal loop.
    bending, bending_steps: linear programs of the repair, for which every metre counts; how many in one round.
    """

    attempts: tuple[ShorteningAttempt, ...]
    further: tuple[ShorteningAttempt, ...]
    rounds: int
    most_work: float
    round_moves: int = 200
    coarse: SamplingSettings = SamplingSettings(per_reach=4, shrink=0.1, most_samples=150_000)
    fine: SamplingSettings = SamplingSettings(per_reach=12, shrink=0.5, most_samples=150_000)
    bending_steps: int = 4
    bending: BendingSettings = BendingSettings(length_weight=1.0, move_weight=0.02, range_weight=20.0, least_gain=1e-4)
