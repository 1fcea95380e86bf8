"""The settings of the search, one type for each of its stages; ``efforts`` holds their values.

A share is of the whole: ground, a budget, the reach. A weight is a cost in the metres that it is worth."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from rota.planners.patrol.loop_settings import BendingSettings, SamplingSettings, ShorteningSettings
from rota.planners.patrol.method_settings import DistrictSettings, FixedTeamSettings, SweepingSettings


class ExcursionEstimate(NamedTuple):
    """What an excursion between two rounds of a hub is taken to cover, when slow ground is first handed to it.

    hub_detour: length of a real hub over that of an ideal one.
    travel_share: share of what the hub leaves of the budget that is spent on the ground, not on the way there.
    """

    hub_detour: float
    travel_share: float


@dataclass(frozen=True, kw_only=True)
class AllocationSettings:
    """Which tours a team size begins with.

    groupings: at most this many ways to group the period classes are tried.
    least_slack: a team size is tried if its budgets are at least this multiple of the ideal lengths.
    nested_slack_limit: nested loops are tried where the slack factor of plain tours is below this.
    estimates: each estimate gives nested loops of its own.
    """

    groupings: int
    least_slack: float
    estimates: tuple[ExcursionEstimate, ...]
    nested_slack_limit: float = 1.4


@dataclass(frozen=True, kw_only=True)
class TeamSizeSettings:
    """Which team sizes are tried.

    likely_slack: the first team size tried has budgets of this multiple of the ideal lengths.
    single_steps: on the way up, this many sizes are tried one by one.
    searches_ragged: whether fewer robots and better loops are looked for, for minutes, where corners are very many or
        districts are built-up.
    """

    single_steps: int
    searches_ragged: bool
    likely_slack: float = 1.3


@dataclass(frozen=True, kw_only=True)
class ScreeningSettings:
    """Which allocations of a team size go on after a little annealing.

    allocations: at most this many allocations are annealed, half of them nested.
    nested_allocations: at most this many nested ones compete for their half, in shorter annealings.
    moves: of one annealing.
    unseen_limit: allocations that leave a larger share of the ground unseen are dropped.
    nested_unseen_limit: the same for nested ones, which take longer to find their shape.
    multistart_limit: with several seeds, others go on if their shortfall is at most this multiple of the best one's.
    """

    allocations: int
    nested_allocations: int
    moves: int
    unseen_limit: float = 0.045
    nested_unseen_limit: float = 0.09
    multistart_limit: float = 1.5


@dataclass(frozen=True, kw_only=True)
class MultistartSettings:
    """How often the best allocations are annealed in full.

    allocations: at most this many are.
    seeds: annealings of each on average.
    tries: a team size is tried so often, with other seeds, where annealings are so short that all tries together make
        no more moves than one with tours of ``reference_corners`` corners.
    kept: at most this many annealed tours go on, those with the least shortfall.
    """

    allocations: int
    seeds: int
    kept: int
    tries: int = 1

    @property
    def is_thorough(self) -> bool:
        """Whether new tours are annealed for the sake of a little less, too: those of each allocation several times."""
        return self.seeds > 1


@dataclass(frozen=True, kw_only=True)
class AnnealingSettings:
    """One annealing from hot to cold.

    moves: of a full annealing of tours of ``reference_corners`` corners.
    most_moves: of any annealing.
    reference_corners: tours of more corners take more moves in proportion, and tours of fewer take fewer.
    least_share: but at least this share of the moves.
    """

    moves: int
    most_moves: int
    reference_corners: int = 300
    least_share: float = 1.0


class Stage(NamedTuple):
    """One annealing of those that alternate with repairs.

    heat: at its beginning, as a share of the reach.
    coverage_weight: multiple of the usual weight of seeing; corners are not worth their detours otherwise.
    reserve: share of the budgets that is left to the repair.
    """

    heat: float
    coverage_weight: float
    reserve: float


@dataclass(frozen=True, kw_only=True)
class AlternationSettings:
    """Annealing and repair in turn, from annealed tours to a plan that passes.

    attempts: with other seeds, while the tours come near to their budgets.
    annealings: of one attempt; all but the first are followed by a repair.
    moves: of one annealing.
    first_stages: the annealings before the first repair.
    later_stage: the annealing after the first repair has half of this heat and reserve, each later one half again.
    unseen_limit: an attempt ends if the tours it begins with leave a larger share of the ground unseen.
    over_budget_limit: an attempt ends if tours are over a budget by a larger share of it.
    near_budget_limit: an attempt goes on if a repair leaves less excess than any before, or at most this share of a
        budget, and another one is made if some repair came so near.
    """

    attempts: int
    annealings: int
    moves: int
    later_stage: Stage
    near_budget_limit: float
    first_stages: tuple[Stage, ...] = (Stage(1 / 4, 3.0, 0.01), Stage(1 / 16, 12.0, 0.005))
    unseen_limit: float = 0.015
    over_budget_limit: float = 0.03

    @property
    def stages(self) -> list[Stage]:
        """The annealings of one attempt, cooler and cooler."""
        halvings = range(1, self.annealings + 1 - len(self.first_stages))
        heat, weight, reserve = self.later_stage
        return [*self.first_stages, *(Stage(heat / 2**k, weight, reserve / 2**k) for k in halvings)]


@dataclass(frozen=True, kw_only=True)
class RepairSettings:
    """From tours that see all samples to a plan that the judge passes.

    rounds: of repair and judgement.
    over_budget_limit: tours over a budget by at most this share of it are repaired further.
    tight_range_margin: share of the range margin that is kept while tight tours are bent.
    bend: tours are bent this much farther than to what they miss, in reaches.
    tight_bend_growth: by which that grows in every round, as a share of the range margin.
    roomy_bend_growth: the same of other tours, and of all where linear programs are not used.
    bending_steps: linear programs of one round.
    """

    rounds: int
    over_budget_limit: float
    tight_range_margin: float
    bend: float
    tight_bend_growth: float = 0.03
    roomy_bend_growth: float = 0.25
    bending_steps: int = 25

    @property
    def patient_rounds(self) -> int:
        """Rounds where there is nothing else left to try."""
        return 3 * self.rounds


@dataclass(frozen=True, kw_only=True)
class SearchSettings:
    """All stages of one search."""

    sampling: SamplingSettings
    allocation: AllocationSettings
    team_size: TeamSizeSettings
    screening: ScreeningSettings
    multistart: MultistartSettings
    annealing: AnnealingSettings
    alternation: AlternationSettings
    repair: RepairSettings
    fixed_team: FixedTeamSettings
    sweeping: SweepingSettings
    districts: DistrictSettings
    shortening: ShorteningSettings
    bending: BendingSettings = field(default_factory=BendingSettings)
