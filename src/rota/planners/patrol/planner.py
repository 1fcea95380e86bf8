"""From the mission asked to the one that is searched: with a reserve in periods and reach, and without starts."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial

import shapely

from rota.errors import NoPlanFound
from rota.model.anywhere import without_starts
from rota.model.arrays import Floats
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planners.patrol.best_of_efforts import best_of_efforts
from rota.planners.patrol.bounds.best_bound import prove_bound, prove_by_area
from rota.planners.patrol.bounds.proved_bound import ProvedBound
from rota.planners.patrol.charging import plan_that_charges
from rota.planners.patrol.context import Context, begin_search, silent
from rota.planners.patrol.efforts import EFFORTS, lesser_efforts
from rota.planners.patrol.ground.pockets_in_the_way import refuse_pockets_in_the_way
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.ground.samples import MANY_CORNERS
from rota.planners.patrol.ground.standing import has_many_corners
from rota.planners.patrol.handover.charging.flights_from_starts import lead_to_flights
from rota.planners.patrol.kinds.groups import differs
from rota.planners.patrol.kinds.plan_with_kinds import plan_with_kinds
from rota.planners.patrol.margins import with_reserve
from rota.planners.patrol.methods.fewest.one_fewer import leave_out_needless_robots
from rota.planners.patrol.methods.fewest.search import reduce_team, share_of_progress, with_less_effort
from rota.planners.patrol.methods.fewest.shorter_sights import with_shorter_sights
from rota.planners.patrol.methods.fixed_team.charging_team import plan_at_best
from rota.planners.patrol.methods.fixed_team.planner import plan_fixed_team
from rota.planners.patrol.methods.large.search import is_wide, perfect_lanes
from rota.planners.patrol.methods.method import load_method
from rota.planners.patrol.methods.sweeping.first_plan import sweep
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.repair import Repaired
from rota.planners.patrol.route_graph.plan_on_graph import plan_on_lanes
from rota.planners.patrol.shortening.search import with_better_loops
from rota.planners.patrol.tight_corners import require_corners_in_reach
from rota.planners.patrol.traffic.starts.from_starts import lead_from_starts, require_room
from rota.planners.patrol.traffic.starts.ways_in import require_ways_in
from rota.planners.patrol.verdict import Judge, Verdict, never_seen, unmet_reason, worst_reached
from rota.planning.planner import Request
from rota.planning.stopping import put_off


def plan_patrol(request: Request) -> Plan:
    """A plan for the mission; with NoPlanFound for a fixed team that charges comes one for longer periods."""
    try:
        return best_of_efforts(request, plan_any)
    except NoPlanFound as failure:
        if not request.mission.chargers or request.mission.fleet.robots is None:
            raise
        return plan_at_best(request, plan_any, failure)


def plan_any(request: Request) -> Plan:
    """A plan for the mission, whose robots may be unlike each other; see ``plan_alike`` for those that are not."""
    if request.mission.lanes or not differs(request.mission):
        return plan_alike(request)

    def search_part(part: Mission, *, in_full: bool, turns_s: Floats | None = None) -> Plan:
        """A plan for some of the ground; how far it has come says nothing of the whole."""
        asked = part if in_full else part.with_effort("quick")
        return plan_alike(replace(request, mission=asked, progress=silent), shortens=in_full, turns_s=turns_s)

    return plan_with_kinds(request, search_part)


def plan_alike(request: Request, *, shortens: bool = True, turns_s: Floats | None = None) -> Plan:
    """A plan for the mission whose loops pass the judge with the reserve that its settings ask for.

    All robots are taken to be alike, the weakest of them in everything. Robots with starts reach their loops from
    there. The lower bound is that of the mission as it is asked. shortens: whether shorter loops are looked for once
    robots are as few as are found. turns_s: how long turns of robots that charge may be; None: anything. Raises
    NoPlanFound, with the best plan found for this mission, when there is none; also when bodies touch on the way from
    the starts, and when the reserve of range hides ground that only the full reach sees.
    """
    mission, judge = request.mission, request.judge
    require_room(mission)
    if mission.chargers:
        anywhere = replace(request, mission=without_starts(mission))
        try:
            charging = plan_that_charges(anywhere, partial(plan_alike, shortens=shortens), turns_s)
            if mission.has_starts:
                charging = lead_to_flights(charging, with_reserve(mission), judge)
        except NoPlanFound as failure:
            raise NoPlanFound(str(failure), best=answer_for(failure.best, mission)) from failure
        return with_full_reach(charging, mission, judge)
    if mission.lanes:
        return plan_on_lanes(request)
    tight = with_reserve(mission)
    require_ways_in(mission)
    require_corners_in_reach(mission)
    searched = without_starts(tight)
    leads: Judge = judge if searched is tight else LeadingJudge(searched, tight, judge)
    try:
        plans = plan_tours(searched, asked=request, judge=leads, shortens=shortens)
    except NoPlanFound as failure:
        raise NoPlanFound(str(failure), best=lead_from_starts_asked(failure.best, mission)) from failure
    plan = plans[0]
    if mission.has_starts:
        request.progress(0.95, "leading the robots from their starts")
        try:
            plan = first_led(plans, tight, judge)
        except NoPlanFound as failure:
            raise NoPlanFound(str(failure), best=answer_for(failure.best, mission)) from failure
    return with_full_reach(plan, mission, judge)


def with_full_reach(plan: Plan, mission: Mission, judge: Judge) -> Plan:
    """A plan for ``with_reserve(mission)`` as one for the mission; NoPlanFound where full reach alone sees ground."""
    final = plan if plan.mission is mission else replace(plan, mission=mission)  # the judge knows the plan judged last
    margin_m = PatrolSettings.of(mission).range_margin_m
    if margin_m > 0 and (verdict := judge(final)).verdict != "met":
        raise NoPlanFound(
            f"patrol.range_margin_m: {margin_m:.6g} hides ground that only sensors of full reach"
            f" see, and the plan misses it: {worst_reached(verdict)}; give less",
            best=final,
        )
    return final


class LeadingJudge:
    """The judge, which also leads the first plan for the searched mission that passes from the mission's starts.

    So there is a plan to tell, and to stop with, long before the search ends.
    """

    def __init__(self, searched: Mission, mission: Mission, judge: Judge) -> None:
        self._searched, self._mission, self._judge = searched, mission, judge
        self._has_led = False

    def __reduce__(self) -> tuple[Callable[[Judge], Judge], tuple[Judge]]:
        """Sent to another process it judges there, and leads nobody."""
        return itself, (self._judge,)

    def __call__(self, plan: Plan) -> Verdict:
        """The verdict on a plan."""
        verdict = self._judge(plan)
        if not self._has_led and verdict.verdict == "met" and plan.mission == self._searched:
            self._has_led = True  # another thread may lead its own at this moment, which does no harm
            with suppress(NoPlanFound):
                lead_from_starts(plan, self._mission, self._judge)
        return verdict


def itself(judge: Judge) -> Judge:
    """The judge."""
    return judge


def plan_tours(mission: Mission, *, asked: Request, judge: Judge, shortens: bool = True) -> list[Plan]:
    """Plans of closed tours that the judge passes, with as few robots as the mission's method finds within the effort.

    The last is what the method finds; before it comes the same with better loops, if there are any.
    asked: has the mission with its starts and before any reserve: the bound is proved for it, and a fixed fleet's spare
    robots go where their starts are. judge: the verdict on a plan for ``mission``. shortens: see ``plan_alike``. Raises
    NoPlanFound, with the best plan found, when the demand is not met.
    """
    progress, should_stop = asked.progress, asked.should_stop
    progress(0.0, "looking at the mission")
    least = mission_to_begin_with(mission)
    laid_out_by = put_off(should_stop, 6.0)  # most ground is laid out sooner, and then has a plan of lanes
    problem = set_up_problem(least, should_stop=laid_out_by)
    if least is not mission and not first_tours_do(problem):
        problem = set_up_problem(mission, should_stop=laid_out_by)
    refuse_pockets_in_the_way(problem)

    def search(problem: Problem) -> Context:
        prove = prove_nothing if should_stop() else first_bound_proof(problem)
        return begin_search(problem, asked, prove, judge=judge)

    context = search(problem)
    goes_on = context.anneals and not context.keeps_first_tours and mission.fleet.robots is None
    if shortens := shortens and goes_on:
        context = replace(context, progress=share_of_progress(progress, 0, 0.5))  # shorter loops take about as long
    method = load_method(PatrolSettings.of(mission).method)
    if mission.fleet.robots is not None:
        return [plan_fixed_team(context, asked.mission, method)]
    best = method(context)
    if problem.mission is not mission:
        best = for_mission(best, mission)
        if not best.met and not should_stop() and never_seen(best.verdict) is None:
            context = search(set_up_problem(mission))
            best = reduce_team(context, best)
    if context.proves_later:
        context = replace(context, bound=claimed_bound(best.plan), proves_later=False)  # proved on its way
    if goes_on:
        best = with_shorter_sights(context, best)
    # over ragged ground lanes take minutes to lay, and who has asked to stop waits
    if not best.met and should_stop() and context.anneals and not context.problem.is_ragged:
        best = sweep(context, EFFORTS["quick"]) or best
    if not best.met:
        raise NoPlanFound(unmet_reason(best.plan, best.verdict) + what_helps(mission, best.verdict), best=best.plan)
    context = replace(context, progress=share_of_progress(progress, 0.5, 0.97))
    best, better = with_loops_improved(context, best) if shortens else (best, best)
    return [best.plan] if better is best else [better.plan, best.plan]


def mission_to_begin_with(mission: Mission) -> Mission:
    """The mission with effort quick, where corners are as many as a scanned floor's and normal would do no more.

    Finer samples give first tours that are as long there, take as long again to lay out, and fill memory.
    """
    settings = PatrolSettings.of(mission)
    shapes = [mission.area, *(obstacle.shape for obstacle in mission.obstacles)]
    is_scanned = int(shapely.get_num_coordinates(shapes).sum()) > MANY_CORNERS
    keeps_first = not EFFORTS[settings.effort].team_size.searches_ragged and settings.method == "tours"
    begins_with_less = is_scanned and keeps_first and settings.effort != "quick" and mission.fleet.robots is None
    return mission.with_effort("quick") if begins_with_less else mission


def first_tours_do(problem: Problem) -> bool:
    """Whether the search is for any plan with the first tours: over a scanned floor, neither large nor for many robots.

    How many robots are needed is told from perfect lanes, as half of those that make a mission one for many.
    """
    settings = PatrolSettings.of(problem.mission)
    effort = EFFORTS[settings.effort]
    keeps_first = problem.is_ragged and not effort.team_size.searches_ragged and settings.method == "tours"
    if not keeps_first or problem.mission.fleet.robots is not None:
        return False
    return not is_wide(problem, effort.districts) and perfect_lanes(problem) < effort.districts.many_robots / 2


def first_bound_proof(problem: Problem) -> Callable[[Problem], ProvedBound]:
    """The proof that the search begins with; the best bound is proved as soon as there are tours.

    First tours and lanes need no bound, but that of the area tells whether the ground takes so many robots that lanes
    are laid over districts.
    """
    if first_tours_do(problem):
        return prove_nothing
    settings = PatrolSettings.of(problem.mission)
    if settings.method != "tours" or problem.is_ragged:
        return prove_bound
    districts = EFFORTS[settings.effort].districts
    takes_few = not is_wide(problem, districts) and perfect_lanes(problem) < districts.many_robots / 2
    return prove_nothing if takes_few else prove_by_area


def for_mission(found: Repaired, mission: Mission) -> Repaired:
    """The same as a plan for this mission, which differs in its effort only."""
    return replace(found, plan=replace(found.plan, mission=mission))


def prove_nothing(problem: Problem) -> ProvedBound:
    """One robot at least, for whatever is asked."""
    return ProvedBound(robots=1, reason="something is to be seen")


def what_helps(mission: Mission, verdict: Verdict) -> str:
    """What to do where a place of a scanned floor was never seen, with that place; nothing to say elsewhere."""
    worst = never_seen(verdict)
    if worst is None or not has_many_corners(mission):
        return ""
    x, y = verdict.shown_unmet_m[verdict.shown_unmet_demand == worst][0]
    anywhere = mission.fleet.entrances is None
    pockets = "fleet.entrances leaves out what is seen only from pockets, and " if anywhere else ""
    return f"; ({x:.2f}, {y:.2f}) is never seen: on a scanned floor {pockets}close_gaps_m of the map leaves out nooks"


def claimed_bound(plan: Plan) -> ProvedBound:
    """What a plan claims is proved."""
    return ProvedBound(robots=plan.lower_bound_robots or 0, reason=plan.lower_bound_reason or "")


def with_loops_improved(context: Context, best: Repaired) -> tuple[Repaired, Repaired]:
    """The plan with the fewest robots found, and the same with the loops that the mission prefers.

    Shorter loops may do with fewer robots; these then get loops that are better still.
    """
    best = leave_out_by_lesser_efforts(context, best)
    better = with_better_loops(context, best)
    fewer = leave_out_needless_robots(context, better)
    if fewer is not better and not context.should_stop():
        best, better = fewer, with_better_loops(context, fewer)
    return best, better


def leave_out_by_lesser_efforts(context: Context, best: Repaired) -> Repaired:
    """The plan without the robots that loops spare which are shortened with lesser efforts: more never takes more."""
    mission = context.problem.mission
    for effort in lesser_efforts(PatrolSettings.of(mission).effort):
        if context.should_stop() or best.robots <= context.enough_robots:
            break
        own = replace(with_less_effort(context, effort), progress=silent)
        fewer = leave_out_needless_robots(own, with_better_loops(own, best))
        best = for_mission(fewer, mission) if fewer.robots < best.robots else best
    return best


def first_led(plans: list[Plan], mission: Mission, judge: Judge) -> Plan:
    """The first of the plans whose loops can be reached from the mission's starts; NoPlanFound where none can."""
    for plan in plans[:-1]:
        with suppress(NoPlanFound):
            return lead_from_starts(plan, mission, judge)
    return lead_from_starts(plans[-1], mission, judge)


def answer_for(best: object | None, mission: Mission) -> Plan | None:
    """The best plan found for the searched mission as one for the mission asked."""
    return replace(best, mission=mission) if isinstance(best, Plan) else None


def lead_from_starts_asked(best: object | None, mission: Mission) -> Plan | None:
    """The best plan found for the searched mission, led from the asked mission's starts as far as that can be."""
    if not isinstance(best, Plan) or not mission.has_starts:
        return answer_for(best, mission)
    try:
        return lead_from_starts(best, mission, judge=None)
    except NoPlanFound as failure:
        return answer_for(failure.best, mission)
