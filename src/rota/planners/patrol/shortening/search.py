"""Shorter loops at the same number of robots: annealed once more for length, then bent and repaired until they pass.

The search for fewest robots ends as soon as the tours keep within their budgets. What is left of the budgets is spent
here: every metre costs a metre, an unseen sample several times what it takes to see it. Tours find their shape while
they are hot, where few samples are enough; then finer ones take over.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rota.model.arrays import Flags
from rota.planners.patrol.annealing.search import LONGEST_LEG, Annealing, budget_penalties
from rota.planners.patrol.context import Context
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.driving.polylines import turns_rad
from rota.planners.patrol.ground.extra_points import metres_worth, no_points
from rota.planners.patrol.ground.nooks import nooks_of
from rota.planners.patrol.ground.problem import Problem, points_of_regions
from rota.planners.patrol.ground.sample_kernels import Samples
from rota.planners.patrol.ground.samples import SamplePoints, known_walls, lay_out
from rota.planners.patrol.loop_settings import SamplingSettings, ShorteningSettings, ShorteningStage
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.bending import layout
from rota.planners.patrol.repair.bending.search import can_bend
from rota.planners.patrol.repair.little_overlap import with_little_overlap
from rota.planners.patrol.repair.repair import Repaired, repair_until_feasible
from rota.planners.patrol.shortening.spikes import spikes, without
from rota.planners.patrol.tolerances import ROUNDING
from rota.planners.patrol.tours.tour import Tour, nests, tour_length_m, unfold_nests

LARGEST = 2_000  # reaches of ideal loop, beyond which ground is left as it is


def with_better_loops(context: Context, found: Repaired) -> Repaired:
    """The plan with the loops that the mission prefers; the plan found where no better ones pass the judge.

    Each attempt begins with the tours found: the first ones with much heat, which gives them another shape where the
    budgets leave room for one, the last with little. Loops that became shorter so are shortened further, unless some
    are nested or turns cost something. Ground where robots turn on arcs or the limit of sight is asked for is left as
    it is, for no linear program closes the gaps there; and so is ground of more than ``LARGEST`` reaches of ideal loop.
    Loops of robots with mass lose spikes alone. The larger the ground, the fewer attempts its ``most_work`` allows, and
    the last ones take least. Where none passes the last one is led by detours past what it leaves.
    """
    settings, problem = context.settings.shortening, context.problem
    if not can_bend(problem) or reaches(problem) > LARGEST or any(tour.revisits for tour in found.tours):
        return found
    fewest_turns = PatrolSettings.of(problem.mission).prefer == "fewest_turns"
    may_be_bold = not fewest_turns and not has_nests(found.tours)
    anneals = not problem.robot.motion.has_mass  # with mass they take a fourth of the time for nothing
    attempts = [attempt for attempt in settings.attempts if anneals and (may_be_bold or not attempt.bold)]
    left, tried = settings.most_work / reaches(problem), None
    for turn, attempt in enumerate(attempts):
        if context.should_stop():
            break
        rounds = rounds_within(settings, attempt.moves, left)
        if not rounds:
            continue
        left -= attempt.moves + rounds * settings.round_moves
        context.progress(0.6 * turn / len(attempts), "looking for shorter loops")
        stages = attempt.stages
        if attempt is attempts[-1] and rounds < settings.rounds and not fewest_turns:
            rounds = (rounds + 1) // 2  # the other half may be detours
            if problem.lanes_overlap_m > 0:  # nooks are asked for, so that hardly anything is left to these
                rounds, stages = 1, with_half_the_moves(stages)
        tried = annealed_and_repaired(
            with_rounds(context, rounds),
            found.tours,
            stages,
            fewest_turns=fewest_turns,
            seed=context.seed + 10 * turn,
        )
        if is_better(tried, found, fewest_turns=fewest_turns):
            found = shortened_further(context, tried, left=left) if may_be_bold else tried
            break
    else:
        if tried is not None and not fewest_turns:
            found = led_past_the_rest(context, found, tried)
    rounds = rounds_within(settings, 0, left)
    return without_spikes(with_rounds(context, rounds), found, fewest_turns=fewest_turns) if rounds else found


def with_half_the_moves(stages: tuple[ShorteningStage, ...]) -> tuple[ShorteningStage, ...]:
    """The stages with half of their moves."""
    return tuple(stage._replace(moves=stage.moves // 2) for stage in stages)


def rounds_within(settings: ShorteningSettings, moves: int, left: float) -> int:
    """Rounds of repair for which ``left`` has room beside so many moves, both for a reach; 0 where too few are left.

    An attempt with fewer than six is not worth its annealing.
    """
    rounds = min(settings.rounds, int((left - moves) // settings.round_moves))
    return rounds if rounds >= min(6, settings.rounds) else 0


def with_rounds(context: Context, rounds: int) -> Context:
    """The same search with at most so many rounds of repair in an attempt at shorter loops."""
    shortening = replace(context.settings.shortening, rounds=rounds)
    return replace(context, settings=replace(context.settings, shortening=shortening))


def shortened_further(context: Context, found: Repaired, *, left: float = math.inf) -> Repaired:
    """The plan with its loops annealed again, without the heat that would give them another shape.

    left: the work that there may be, as moves for each reach of ideal loop.
    """
    settings = context.settings.shortening
    for turn, attempt in enumerate(settings.further):
        rounds = settings.rounds if math.isinf(left) else rounds_within(settings, attempt.moves, left)
        if context.should_stop() or not rounds:
            break
        left -= attempt.moves + rounds * settings.round_moves
        context.progress(0.6 + 0.3 * turn / len(settings.further), "making the loops shorter yet")
        seed = context.seed + 10 * (len(settings.attempts) + turn)
        own = with_rounds(context, rounds)
        shorter = annealed_and_repaired(own, found.tours, attempt.stages, fewest_turns=False, seed=seed)
        if is_better(shorter, found, fewest_turns=False):
            found = shorter
    return found


def pull_tight(context: Context, found: Repaired) -> Repaired:
    """The plan with its loops bent by linear programs alone, three times as far, over samples that hardly overlap.

    Legs share these samples, and it takes more rounds to see all. The plan given where that is no better.
    """
    if context.should_stop():
        return found
    settings = context.settings.shortening
    shortening = replace(
        settings,
        rounds=2 * settings.rounds,
        bending_steps=3 * settings.bending_steps,
        bending=replace(settings.bending, shares=True),
    )
    own = replace(
        context,
        problem=with_little_overlap(context.problem),
        settings=replace(context.settings, shortening=shortening),
    )
    tighter = repair_for_length(own, found.tours, found.tours)
    return tighter if is_better(tighter, found, fewest_turns=False) else found


def without_spikes(context: Context, plan: Repaired, *, fewest_turns: bool) -> Repaired:
    """The plan with its tours straight on past their spikes, repaired; the plan given where that is no better."""
    if context.should_stop() or not (found := spikes(context.problem, plan.tours)):
        return plan
    straight = repair_for_length(context, without(plan.tours, found), plan.tours)
    return straight if is_better(straight, plan, fewest_turns=fewest_turns) else plan


def has_nests(tours: list[Tour]) -> bool:
    """Whether some loops are nested in others."""
    return any(tour.nest >= 0 for tour in tours)


def annealed_and_repaired(
    context: Context, tours: list[Tour], stages: tuple[ShorteningStage, ...], *, fewest_turns: bool, seed: int
) -> Repaired:
    """The tours annealed in stages, then repaired by linear programs that keep them short; met or not.

    fewest_turns: a turn by one radian costs as much as a reach of way.
    """
    tried = as_if_turning_cost(tours, context.problem.reach_m) if fewest_turns else tours
    tried = anneal_in_stages(context, tried, tours, stages, seed=seed)
    return repair_for_length(context, as_they_were(tried, tours), tours)


def anneal_in_stages(
    context: Context, tried: list[Tour], tours: list[Tour], stages: tuple[ShorteningStage, ...], *, seed: int
) -> list[Tour]:
    """The tours ``tried`` after the stages, over samples that ``tours`` see; these are laid out once of each kind."""
    settings = context.settings.shortening
    samples: dict[bool, Samples | None] = {}
    for turn, stage in enumerate(stages):
        if stage.coarse not in samples:
            sampling = settings.coarse if stage.coarse else settings.fine
            samples[stage.coarse] = sampled_anew(context.problem, tours, sampling)
        if (own := samples[stage.coarse]) is not None:
            tried = anneal_for_length(context, tried, own, stage, seed=seed + turn)
    return tried


def repair_for_length(context: Context, tours: list[Tour], old: list[Tour]) -> Repaired:
    """The tours after repairs by linear programs for which every metre counts; met or not.

    old: those that they are to be shorter than; once they are too long the repair ends. Tours are bent a hundredth of
    the reach beyond what they miss, a third of that where legs share, which takes more rounds. They go on while they
    are 0.2 % over their budgets.
    """
    settings, usual = context.settings.shortening, context.settings.repair
    closely = settings.bending.shares
    repair = replace(
        usual,
        bending_steps=settings.bending_steps,
        bend=0.003 if closely else 0.01, roomy_bend_growth=0.1 if closely else usual.roomy_bend_growth,
        over_budget_limit=0.002,
    )  # fmt: skip
    own = replace(context, settings=replace(context.settings, bending=settings.bending, repair=repair))
    return repair_until_feasible(
        own, tours, nooks_seen(context.problem, old), may_add=False, rounds=settings.rounds, annealed=True,
        is_in_vain=lambda tours: is_too_long(tours, old),
    )  # fmt: skip


def led_past_the_rest(context: Context, found: Repaired, tried: Repaired) -> Repaired:
    """The loops of an attempt with detours past what programs left unseen; the plan found where they are no better.

    Detours are longer than programs, and turn more, but come to an end.
    """
    if not tried.within_budgets or is_too_long(tried.tours, found.tours):
        return found
    led = repair_until_feasible(
        context, tried.tours, tried.extra, may_add=False, rounds=context.settings.shortening.rounds // 2,
        is_in_vain=lambda tours: is_too_long(tours, found.tours),
    )  # fmt: skip
    return led if is_better(led, found, fewest_turns=False) else found


def anneal_for_length(
    context: Context, tours: list[Tour], samples: Samples, stage: ShorteningStage, *, seed: int
) -> list[Tour]:
    """The tours after one annealing in which every metre that is driven costs a metre.

    It leaves 3 % of the budgets to the repair.
    """
    problem = context.problem
    search = Annealing(
        tours, samples._replace(weight=stage.coverage_weight * samples.weight), problem.paths.grid,
        length_weight=np.array(rounds_of(tours), dtype=np.float64),
        budget_penalty=budget_penalties(tours, 6.0),
        seed=seed, range_margin_m=problem.range_margin_m, reserve=0.03,
    )  # fmt: skip
    search.run(
        int(stage.moves * reaches(problem)), hot_m=stage.hot * problem.reach_m, cold_m=stage.cold * problem.reach_m,
        should_stop=context.should_stop, vertex_price=stage.vertex_price,
    )  # fmt: skip
    return search.tours


def sampled_anew(problem: Problem, tours: list[Tour], sampling: SamplingSettings) -> Samples | None:
    """The problem's ground as other samples, but for what these tours do not see at full reach: nobody can see that.

    None: they see none of them, as where all is visits and they only touch the zones.
    """
    points, _ = points_of_regions(problem.regions, problem.space, problem.robot, sampling)
    points, samples, _ = lay_out(points, problem.walls, problem.robot, weight=metres_worth(problem, points))
    seen = are_seen(problem, tours, samples)
    if seen.all():
        return samples
    if not seen.any():
        return None
    known = known_walls(samples, np.flatnonzero(seen))
    return lay_out(points[seen], problem.walls, problem.robot, weight=metres_worth(problem, points[seen]), known=known)[
        1
    ]


def nooks_seen(problem: Problem, tours: list[Tour]) -> SamplePoints:
    """Where small obstacles are many, the nooks beside them that these tours see; no points elsewhere.

    Behind a trunk next to nothing is hidden, which samples miss and the check finds sliver by sliver.
    """
    points = nooks_of(problem) if problem.lanes_overlap_m > 0 else no_points()
    if not len(points):
        return points
    points, samples, _ = lay_out(points, problem.walls, problem.robot)
    return points[are_seen(problem, tours, samples)]


def are_seen(problem: Problem, tours: list[Tour], samples: Samples) -> Flags:
    """Whether the tours see each of the samples (n,) at full reach."""
    legs, places_m = layout.lay_out_tours(tours, LONGEST_LEG * problem.reach_m)
    further_m = float(samples.shrink_m.max(initial=0.0))
    sightings = layout.sightings(legs, places_m, samples, range_margin_m=0.0, further_m=further_m)
    return np.asarray(sightings.range_deficit_m[:, 0] <= samples.shrink_m)


def reaches(problem: Problem) -> float:
    """The length of an ideal loop over all ground, in reaches of the sensor; at least one."""
    return max(1.0, ideal_reaches(problem))


def ideal_reaches(problem: Problem) -> float:
    """The same, however short; 0 where places are visited and nothing else is asked."""
    asked_m2 = sum(region.shape.area for region in problem.regions if region.demand == "every_point")
    return float(asked_m2 / problem.swath_m / problem.reach_m)


def as_if_turning_cost(tours: Sequence[Tour], metres: float) -> list[Tour]:
    """The tours with robots that take as long to turn by one radian as to drive so many metres.

    Periods are longer by what the turns that are likely to stay take. The tours of nests, whose rounds share their
    budgets, stay as they are.
    """
    return [tour if tour.nest >= 0 else _turning(tour, metres) for tour in tours]


def _turning(tour: Tour, metres: float) -> Tour:
    """One tour with a robot that takes time to turn."""
    speed_m_s = driving_of(tour.robot).pace_m_s
    # a fifth of the turning is likely to go away
    more_s = 0.8 * metres * float(turns_rad(tour.vertices_m).sum()) / (speed_m_s * tour.robots)
    robot = replace(tour.robot, turn_rate_rad_s=speed_m_s / metres)
    return replace(tour, robot=robot, period_s=tour.period_s + more_s)


def as_they_were(tried: Sequence[Tour], tours: Sequence[Tour]) -> list[Tour]:
    """The tours (k,) with the places of those that were tried (k,)."""
    return [replace(tour, vertices_m=other.vertices_m) for tour, other in zip(tours, tried, strict=True)]


def loops_m(tours: Sequence[Tour]) -> float:
    """Metres of one round of every loop as it is driven, turning counted as the metres that take the same time."""
    return sum(tour_length_m(tour) for tour in unfold_nests(tours))


def turning_rad(tours: Sequence[Tour]) -> float:
    """By how much the direction changes in one round of every loop as it is driven, in all."""
    return float(sum(turns_rad(tour.vertices_m).sum() for tour in unfold_nests(tours)))


def rounds_of(tours: Sequence[Tour]) -> list[int]:
    """How often each tour (k) is driven in one round of its loop: a hub once for each petal that leads anywhere."""
    rounds = [1] * len(tours)
    for hub, *petals in nests(tours):
        rounds[hub] = max(1, sum(len(tours[k].vertices_m) > 1 for k in petals))
    return rounds


def is_too_long(tours: Sequence[Tour], old: Sequence[Tour]) -> bool:
    """Whether loops are so much longer than others that more rounds of repair will hardly make them shorter."""
    return loops_m(tours) > 1.005 * loops_m(old)  # later rounds of repair take half a percent back, hardly ever more


def is_better(new: Repaired, old: Repaired, *, fewest_turns: bool) -> bool:
    """Whether a plan that is met has no more robots, and shorter loops, or loops no longer that turn less."""
    if not new.met or new.robots > old.robots:
        return False
    length_m, least_m = loops_m(new.tours), loops_m(old.tours)
    if fewest_turns:
        return length_m <= least_m and turning_rad(new.tours) < turning_rad(old.tours)
    return length_m < least_m * (1 - ROUNDING)
