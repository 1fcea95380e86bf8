"""One robot that sees everything at one period: the shortest loop found has the smallest ratio, whatever the period.

So no periods are tried. In a period that no loop exceeds the search for the fewest robots ends with its first tour;
what time there is goes into making that shorter, from several seeds.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from rota.geometry.free_space import DemandedRegion
from rota.model.limits import LONGEST_S
from rota.model.mission import Mission
from rota.planners.patrol.context import Context, silent
from rota.planners.patrol.ground.problem import stretch_periods
from rota.planners.patrol.loop_settings import ShorteningSettings
from rota.planners.patrol.methods.fixed_team.least_ratio import Reached, reach_of
from rota.planners.patrol.methods.fixed_team.team import Team
from rota.planners.patrol.methods.large.search import is_large
from rota.planners.patrol.repair.bending.search import can_bend
from rota.planners.patrol.shortening.search import LARGEST, has_nests, pull_tight, reaches, with_better_loops


def is_one_loop(context: Context, team: Team) -> bool:
    """Whether the shortest loop is what is looked for: of one robot, at one period, where loops can be shortened."""
    problem = context.problem
    if team.robots != 1 or len({region.period_s for region in problem.regions}) != 1:
        return False
    searched = context.anneals and not context.keeps_first_tours and not is_large(context)
    return searched and can_bend(problem) and not problem.robot.motion.has_mass and reaches(problem) <= LARGEST


def shortest_loop(context: Context, team: Team) -> Reached | None:
    """The plan of one robot with the shortest loop found; None where no one loop passes.

    context: the search without the fleet's own robots.
    """
    problem = context.problem
    ample = ample_s(problem.regions, problem.mission, problem.reach_m, problem.pace_m_s)
    stretch = max(1.0, ample / problem.regions[0].period_s)
    # twice the moves with which loops of several robots are shortened
    settings = replace(context.settings, shortening=with_more_care(context.settings.shortening, 2))
    own = replace(context, problem=stretch_periods(problem, stretch), settings=settings, progress=silent)
    best = team.method(own)
    if not best.met or best.robots > 1:
        return None
    # short loops are shortened so often that these are 100 reaches
    most = 4
    tries = 1 if has_nests(best.tours) else int(100.0 / reaches(problem))
    for turn in range(min(max(1, tries), most)):
        if context.should_stop():
            break
        context.progress(0.3 + 0.7 * turn / most, "looking for a shorter loop")
        best = with_better_loops(replace(own, seed=context.seed + 100 * turn), best)
    return reach_of(pull_tight(own, best), stretch)


def ample_s(regions: Iterable[DemandedRegion], mission: Mission, reach_m: float, pace_m_s: float) -> float:
    """A period that is ample for one robot to see all of some ground in."""
    x0, y0, x1, y1 = mission.area.bounds
    lanes_m = sum(region.shape.area for region in regions) / reach_m
    # no loop of one robot takes 20 times as long as ideal lanes and a way across
    return min(20.0 * float(lanes_m + x1 - x0 + y1 - y0) / pace_m_s, LONGEST_S)


def with_more_care(settings: ShorteningSettings, times: int) -> ShorteningSettings:
    """The same attempts with so many times the moves, at last over samples that lie so many times nearer."""
    attempts = tuple(
        attempt._replace(stages=tuple(stage._replace(moves=times * stage.moves) for stage in attempt.stages))
        for attempt in settings.attempts
    )
    fine = replace(settings.fine, per_reach=times * settings.fine.per_reach)
    most_work = (times + 1) * settings.most_work  # so that a bold attempt that fails leaves room for a careful one
    return replace(settings, attempts=attempts, fine=fine, most_work=most_work)
