"""The settings of each effort: what a mission's ``effort`` chooses. What is not named here is the same for all."""

from __future__ import annotations

from dataclasses import replace

from rota.planners.patrol.loop_settings import SamplingSettings, ShorteningAttempt, ShorteningSettings, ShorteningStage
from rota.planners.patrol.method_settings import DistrictSettings, FixedTeamSettings, SweepingSettings
from rota.planners.patrol.planner_settings import Effort
from rota.planners.patrol.settings import (
    AllocationSettings,
    AlternationSettings,
    AnnealingSettings,
    ExcursionEstimate,
    MultistartSettings,
    RepairSettings,
    ScreeningSettings,
    SearchSettings,
    Stage,
    TeamSizeSettings,
)

# annealing hardly moves ground from one robot to another, so that more effort tries more of these
ESTIMATES = (
    ExcursionEstimate(1.15, 0.8),
    ExcursionEstimate(1.15, 0.67),
    ExcursionEstimate(1.05, 0.55),
    ExcursionEstimate(1.05, 0.67),
    ExcursionEstimate(1.25, 0.8),
    ExcursionEstimate(1.05, 0.8),
    ExcursionEstimate(0.95, 0.55),
)


def shortening_attempts(moves: int) -> tuple[ShorteningAttempt, ...]:
    """Attempts at shorter loops: with much heat, which gives the tours other shapes; then with little.

    The less seeing weighs while tours are hot, the shorter they become, and the more often the budgets then have no
    room for what is left unseen.
    """
    bold = (ShorteningStage(moves, 0.7, 1 / 10, 1.0, coarse=True, vertex_price=1.0), lukewarm_stage(moves))
    careful = (
        ShorteningStage(moves, 0.7, 1 / 10, 1.5, coarse=True, vertex_price=1 / 2),
        ShorteningStage(3 * moves // 16, 1 / 10, 1 / 100, 2.0, vertex_price=1 / 8),
        ShorteningStage(3 * moves // 32, 1 / 32, 1 / 500, 8.0),
    )
    cold = (ShorteningStage(moves // 4, 1 / 16, 1 / 1000, 8.0),)
    return ShorteningAttempt(bold, bold=True), ShorteningAttempt(careful), ShorteningAttempt(cold)


def lukewarm_stage(moves: int) -> ShorteningStage:
    """An annealing in which loops keep their shape, and find where they can be shorter."""
    return ShorteningStage(moves, 1 / 8, 1 / 500, 4.0, vertex_price=1 / 4)


EFFORTS: dict[Effort, SearchSettings] = {
    "quick": SearchSettings(
        sampling=SamplingSettings(per_reach=8, shrink=0.4, few_samples=2_500),
        allocation=AllocationSettings(groupings=4, least_slack=1.15, estimates=ESTIMATES[:1]),
        team_size=TeamSizeSettings(single_steps=2, searches_ragged=False),
        screening=ScreeningSettings(allocations=8, nested_allocations=0, moves=50_000),
        multistart=MultistartSettings(allocations=2, seeds=1, kept=2, tries=4),
        annealing=AnnealingSettings(moves=300_000, most_moves=2_000_000, least_share=0.1),
        alternation=AlternationSettings(
            attempts=2,
            annealings=5,
            moves=150_000,
            later_stage=Stage(1 / 8, 6.0, 0.0075),
            near_budget_limit=0.006,
        ),
        repair=RepairSettings(rounds=12, over_budget_limit=0.0, tight_range_margin=1.0, bend=0.005),
        fixed_team=FixedTeamSettings(screened=6, tries=4, nearness=1.025),
        sweeping=SweepingSettings(tries=2, angles=3),
        districts=DistrictSettings(enough=1.1, piece_moves=300),
        shortening=ShorteningSettings(attempts=shortening_attempts(1600), further=(), rounds=14, most_work=4.5e6),
    ),
    "normal": SearchSettings(
        sampling=SamplingSettings(per_reach=12, shrink=0.2),
        allocation=AllocationSettings(groupings=8, least_slack=1.1, estimates=ESTIMATES[:4]),
        team_size=TeamSizeSettings(single_steps=2, searches_ragged=False),
        screening=ScreeningSettings(allocations=8, nested_allocations=24, moves=50_000),
        multistart=MultistartSettings(allocations=2, seeds=2, kept=2),
        annealing=AnnealingSettings(moves=600_000, most_moves=10_000_000),
        alternation=AlternationSettings(
            attempts=1,
            annealings=5,
            moves=600_000,
            later_stage=Stage(1 / 8, 6.0, 0.0075),
            near_budget_limit=0.006,
        ),
        repair=RepairSettings(rounds=20, over_budget_limit=0.0002, tight_range_margin=1.0, bend=0.005),
        fixed_team=FixedTeamSettings(screened=8, tries=6, nearness=1.015),
        sweeping=SweepingSettings(tries=2, angles=6),
        districts=DistrictSettings(enough=1.05, piece_moves=1_200),
        shortening=ShorteningSettings(
            attempts=shortening_attempts(6000),
            further=(ShorteningAttempt((lukewarm_stage(6000),)),),
            rounds=16,
            most_work=2e7,
        ),
    ),
    "high": SearchSettings(
        sampling=SamplingSettings(per_reach=16, shrink=0.15),
        allocation=AllocationSettings(groupings=16, least_slack=1.05, estimates=ESTIMATES),
        team_size=TeamSizeSettings(single_steps=8, searches_ragged=True),
        screening=ScreeningSettings(allocations=16, nested_allocations=56, moves=100_000),
        multistart=MultistartSettings(allocations=4, seeds=6, kept=8),
        annealing=AnnealingSettings(moves=800_000, most_moves=100_000_000),
        alternation=AlternationSettings(
            attempts=6,
            annealings=9,
            moves=1_200_000,
            later_stage=Stage(1 / 16, 20.0, 0.0075),
            near_budget_limit=0.002,
        ),
        repair=RepairSettings(rounds=30, over_budget_limit=0.001, tight_range_margin=0.1, bend=0.002),
        fixed_team=FixedTeamSettings(screened=16, tries=9, nearness=1.01),
        sweeping=SweepingSettings(tries=8, angles=12),
        districts=DistrictSettings(enough=1.0, piece_moves=4_800),
        shortening=ShorteningSettings(
            attempts=shortening_attempts(18000),
            further=2 * (ShorteningAttempt((lukewarm_stage(18000),)),),
            rounds=16,
            most_work=8e7,
        ),
    ),
}

# the plan with which every search begins: lanes, from the two groupings that promise the fewest robots, bent farther in
# every round, since there are metres to spare and a round takes time
EARLY = replace(
    EFFORTS["quick"],
    sweeping=replace(EFFORTS["quick"].sweeping, groupings=2),
    repair=replace(EFFORTS["quick"].repair, roomy_bend_growth=1.0),
)
TIGHT = replace(EFFORTS["quick"].repair, rounds=4)  # of the same lanes, if these took another robot


def lesser_efforts(effort: Effort) -> list[Effort]:
    """The efforts below this one, the least first."""
    names = list(EFFORTS)
    return names[: names.index(effort)]
