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
    most_per_reach: but at most so many along one reach.
    fine_shrink: ``shrink`` where they lie denser.
    large_shrink: the same from ``large_from`` samples on, where a little overlap costs less than rounds of repair.
    large_from: number of samples.
    most_samples: the spacing is wider where more samples than this would be needed.
    widest_spacing: but at most this share of the inner reach.
    """

    per_reach: int
    shrink: float
    few_samples: int = 0
    most_per_reach: int = 0
    fine_shrink: float = 0.0
    large_shrink: float = 0.5
    large_from: int = 100_000
    most_samples: int = 400_000
    widest_spacing: float = 0.5


@dataclass(frozen=True, kw_only=True)
class BendingSettings:
    """Tours bent by linear programs, one step after another.

    longest_leg: legs are cut to at most this share of the reach, so that they can bend wherever it helps.
    longest_with_slopes: the same of robots with mass, for which every bend takes time.
    deficit_limit: samples that lack a larger share of the reach are not drawn to.
    first_trust, most_trust: share of the reach that vertices may move in the first step, and in any.
    least_trust: the bending ends when the steps become smaller than this share of the reach.
    least_gain: a step must promise at least this share of the cost.
    handover_deficit: what tight tours see is handed to others that lack at most this share of the reach for it.
    tight_share: a tour that leaves less of a budget than this share is tight.
    budget_penalty: of a metre over a budget.
    range_weight: of a metre of range that a sample lacks.
    move_weight: of a metre that a vertex moves along an axis, so that what need not move stays.
    length_weight: of a metre of the tours; 0 where all that counts is that they keep within their budgets.
    first_rows: ranges with less to spare than this share of a step are limits from the start.
    """

    longest_leg: float = 1.0
    longest_with_slopes: float = 2.0
    deficit_limit: float = 0.1
    first_trust: float = 0.04
    most_trust: float = 0.1
    least_trust: float = 1e-4
    least_gain: float = 1e-3
    handover_deficit: float = 0.02
    tight_share: float = 0.003
    budget_penalty: float = 2.0
    range_weight: float = 5.0
    move_weight: float = 1e-3
    length_weight: float = 0.0
    first_rows: float = 0.25


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
    reserve, budget_penalty: the annealing leaves this share of the budgets to the repair; of a metre over a budget.
    rounds, over_budget_limit: of the repair, as ``RepairSettings`` has them.
    most_work: moves of all attempts together, rounds of repair counted as moves. Counted and not timed, so that the
        same seed gives the same plan on any machine. An attempt that would take more is left out.
    round_moves: what a round of repair counts, for each reach of ideal loop.
    least_rounds: an attempt with fewer rounds of repair left is not worth its annealing.
    largest: ground of more reaches of ideal loop than this is left as it is.
    turn_reaches: reaches of the sensor that a turn by one radian costs where fewest turns are preferred.
    bending, bending_steps: linear programs of the repair, for which every metre counts; how many in one round.
    bend: tours are bent this much farther than to what they miss, as a share of the reach.
    """

    attempts: tuple[ShorteningAttempt, ...]
    further: tuple[ShorteningAttempt, ...]
    rounds: int
    most_work: float
    round_moves: int = 200
    least_rounds: int = 6
    coarse: SamplingSettings = SamplingSettings(per_reach=4, shrink=0.1, most_samples=150_000)
    fine: SamplingSettings = SamplingSettings(per_reach=12, shrink=0.5, most_samples=150_000)
    reserve: float = 0.03
    budget_penalty: float = 6.0
    over_budget_limit: float = 0.002
    largest: float = 2_000.0
    turn_reaches: float = 1.0
    bending_steps: int = 4
    bend: float = 0.01
    bending: BendingSettings = BendingSettings(length_weight=1.0, move_weight=0.02, range_weight=20.0, least_gain=1e-4)
