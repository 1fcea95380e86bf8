"""A plan that takes over: a first one of the rounds that there are, then better ones while time lasts."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from rota.errors import MissionError, NoPlanFound
from rota.model.anywhere import without_starts
from rota.model.plan import Plan, Trajectory
from rota.planning.near_origin import takeovers_near_origin
from rota.planning.planner import Handover, planner_of
from rota.planning.stopping import StopRule
from rota.replanning.order import Order, Rank
from rota.replanning.situation import Change, Place, Situation, situation_after

if TYPE_CHECKING:
    from rota.check.report import Report, Violation
    from rota.model.mission import Fleet, Mission

FIRST = 3  # plans of which the first answer is the least late
SHARINGS, OTHERS = 12, 1  # ways to share the rounds of the plan before, and those of another plan, that are tried
EASED = (2.0, 4.0, math.inf)  # times the periods of what is less important that are tried; inf: it is left out
LONGER = (1.5, 2.0, 3.0, 4.0)  # times the periods for which robots that charge search, if they come into no rounds
SAMPLED = 32  # of the last plans, of which it is kept what sample points say
POINTS = 150  # of each demand that plans are compared at


@dataclass(frozen=True, kw_only=True)
class Replanned:
    """A plan that takes over, and the check's report on it, which tells how late places are since.

    kept: robots that go on as before. stopped_early: the search was stopped before its end.
    """

    plan: Plan
    report: Report
    kept: tuple[str, ...]
    stopped_early: bool

    @property
    def meets_demand(self) -> bool:
        """Whether every period holds again at last."""
        return self.report.verdict == "met"


def replan(
    plan: Plan,
    *,
    at_s: float,
    lost: Iterable[str] = (),
    joined: Mapping[str, Place] | None = None,
    late: Mapping[str, float] | None = None,
    mission: Mission | None = None,
    battery: Mapping[str, float] | None = None,
    seed: int = 0,
    time_limit_s: float | None = None,
    should_stop: Callable[[], bool] | None = None,
    progress: Callable[[float, str], None] | None = None,
    on_better: Callable[[Replanned], None] | None = None,
) -> Replanned:
    """From where robots are at a moment of a plan to one for those that remain, and for the mission as it is now.

    at_s: the moment in the plan's clock; it is 0 of the new plan's. lost: robots that are there no more, with their
    bodies. joined: new robots, and where they are, (x, y) in metres. late: robots that have driven all so many seconds
    later than planned. mission: as it is from then on; its fleet says what robots are like, and it is planned for those
    that remain. None: as in the plan. battery: how full batteries are, 0 to 1: of robots that join, full unless said,
    and of others where it is less than the plan leaves them. The new plan holds what was driven before
    (``Plan.seam``), so that the check judges every window across the change. Among plans whose loops meet every demand
    that is best after which all periods hold again within two of the longest one, then the one whose latest place is
    late least, then the one after which they hold soonest, then the one that keeps most robots on their ways.
    Where none does, that is best which leaves least ground unseen, and then has the least worst ratio; the outcome's
    report then says "violated".

    time_limit_s, should_stop: the search for better plans ends then, and so it does where nothing is late. on_better:
    called with each plan that is better than all before it, the first one within moments.

    Raises MissionError for a change that cannot be, NoPlanFound where robots that remain have no way to go on.
    """
    change = Change(
        at_s=float(at_s), lost=tuple(lost), joined=dict(joined or {}), late=dict(late or {}), mission=mission,
        battery=dict(battery or {}),
    )  # fmt: skip
    if time_limit_s is not None and not time_limit_s > 0:
        raise MissionError(f"time_limit_s: {time_limit_s!r} is not allowed; must be greater than 0, or None")
    situation = situation_after(plan, change)
    stop = StopRule(time_limit_s, should_stop)
    search = _Search(situation, seed, stop, on_better)
    search.try_rounds(situation.loops, SHARINGS, situation.team)
    may_search = situation.mission.has_starts or situation.mission.chargers
    if may_search and not search.is_done and not stop():
        search.look_for_better(progress)
    return search.outcome(stop.stopped)


def first_plan(
    plan: Plan,
    *,
    at_s: float,
    lost: Iterable[str] = (),
    late: Mapping[str, float] | None = None,
    battery: Mapping[str, float] | None = None,
    seed: int = 0,
) -> Plan:
    """The first plan that ``replan`` finds, in half the time: it is checked how robots drive, not what they see.

    Raises what ``replan`` does.
    """
    change = Change(at_s=at_s, lost=tuple(lost), joined={}, late=dict(late or {}), battery=dict(battery or {}))
    situation = situation_after(plan, change)
    search = _FirstSearch(situation, seed, StopRule(None, None), None)
    search.try_rounds(situation.loops, SHARINGS, situation.team)
    return search.first()


class _Search:
    """The best plan so far, and what may be better."""

    def __init__(
        self, situation: Situation, seed: int, stop: StopRule, on_better: Callable[[Replanned], None] | None
    ) -> None:
        self._situation, self._seed, self._stop, self._tell = situation, seed, stop, on_better
        self._planner, self._order = planner_of(situation.mission), Order(situation.mission)
        self._best: Replanned | None = None
        self._rank: Rank = (math.inf,)
        self._best_sampled: Rank = (math.inf,)
        self._sampled: deque[tuple[Plan, Rank]] = deque(maxlen=SAMPLED)
        self._wrong: list[Violation] = []  # with the plan that came nearest: of those tried, least is wrong with it

    @property
    def is_done(self) -> bool:
        """Whether no plan can be better: all is met, and nothing is late."""
        return self._best is not None and self._rank[:4] == (0.0, 0.0, 0.0, 0.0)

    def outcome(self, stopped: bool) -> Replanned:
        """The best plan; NoPlanFound where there is none."""
        if self._best is None:
            why = self._wrong[0].text() if self._wrong else "none was found"
            more = f"; {len(self._wrong) - 1} more of the plan that comes nearest" if len(self._wrong) > 1 else ""
            raise NoPlanFound(f"no plan takes over at t = {self._situation.seam.at_s:g} s: {why}{more}")
        return replace(self._best, stopped_early=stopped)

    def try_rounds(self, loops: tuple[Trajectory, ...], most: int, team: Fleet, names: Sequence[str] = ()) -> None:
        """Try plans in which the robots that remain share these rounds; the least late of some comes first.

        names: of the robots of the team that drive them, if not those of the loops.
        """
        situation = self._situation
        asked = Handover(
            mission=situation.mission, places=situation.places, seam=situation.seam, seed=self._seed,
            # who charges ends the flight that it is on, whatever comes after it
            going_on=situation.going_on if loops is situation.loops or situation.mission.chargers else {}, loops=loops,
            lateness=self._sample, most=most, batteries=situation.batteries,
            importance=self._order.importance_of(loops, situation.team) if loops is situation.loops else {},
            drivers={
                one.robot: team.robot(name) for one, name in zip(loops, names or [k.robot for k in loops], strict=True)
            },
        )  # fmt: skip
        plans = takeovers_near_origin(self._planner, asked)
        # on lanes the second plan takes seconds
        first = islice(plans, 1 if situation.mission.lanes else FIRST)
        ranked: list[tuple[Rank, int, Plan]] = []
        for plan in first:
            ranked.append((self._sample(plan), len(ranked), plan))
            if self._order.is_on_time(ranked[-1][0]):
                break
        for sampled, _, plan in sorted(ranked):
            if self._is_over():
                return
            if self._best is None or sampled < self._best_sampled:
                self._try(plan)
        while not self._is_over() and (other := next(plans, None)) is not None:
            if self._best is None or self._sample(other) < self._best_sampled:
                self._try(other)
        if not self._wrong and self._best is None and not self.is_done:
            self._try(self._as_before())

    def _as_before(self) -> Plan:
        """The plan in which robots go on as before, and new ones stay where they are."""
        situation, full = self._situation, self._situation.batteries
        new = {
            name: Trajectory(robot=name, times_s=np.zeros(1), positions_m=np.array([place]), battery=full[name])
            for name, place in situation.places.items()
        }
        lines = (situation.going_on.get(name, line) for name, line in new.items())
        return Plan(mission=situation.mission, seam=situation.seam, seed=self._seed, trajectories=tuple(lines))

    def _is_over(self) -> bool:
        """Whether there is nothing to search, or no time left and a plan."""
        return self.is_done or (self._stop() and self._best is not None)

    def look_for_better(self, progress: Callable[[float, str], None] | None) -> None:
        """Search for other rounds; each that is found is shared by the robots that remain.

        Where what is more important is not met by any, also for rounds that serve the rest more rarely, or not at all.
        """
        mission = self._situation.mission
        if mission.chargers:  # batteries are not full now: robots come into rounds from anywhere
            mission = without_starts(mission)
        before = self._rank
        has_rounds = self._search(mission, progress, as_asked=True)
        if mission.chargers and has_rounds and self._rank == before:
            self._search_longer_rounds(mission, progress)
        for count in range(len(self._order.levels) - 1, 0, -1):
            for times in EASED:
                if self._is_over() or self._rank[0] == 0.0 or not any(self._rank[1 : 1 + 2 * count]):
                    return
                self._search(self._order.ease_all_but(mission, count, times), progress)

    def _search_longer_rounds(self, mission: Mission, progress: Callable[[float, str], None] | None) -> None:
        """Search for rounds of robots that charge with longer periods, where they come into none of those found."""
        before = self._rank
        for times in LONGER:
            if self._is_over() or before[0] == 0.0 or self._rank < before:
                return
            self._search(self._order.ease_all_but(mission, 0, times), progress)

    def _search(
        self, mission: Mission, progress: Callable[[float, str], None] | None, *, as_asked: bool = False
    ) -> bool:
        """Search for rounds for a mission, which may ask for less than the situation's; whether any were found."""
        from rota.planning.make_plan import search_plan

        found: list[Plan] = []

        def note(plan: Plan, report: Report) -> None:
            """Let the robots that remain share the rounds of a plan that was found."""
            found.append(plan)
            if as_asked:
                ever = self._order.of_report(report)
                if ever > self._rank[: len(ever)]:  # however robots come into such loops
                    return
            loops = tuple(replace(one, robot=f"loop {k + 1}") for k, one in enumerate(plan))
            self.try_rounds(loops, OTHERS, plan.mission.fleet, [one.robot for one in plan])
            if mission.has_starts and not any(one.kind in ("start", "no trajectory") for one in report.violations):
                self._try(replace(plan, mission=self._situation.mission, seam=self._situation.seam))

        with suppress(NoPlanFound, MissionError):
            search_plan(
                mission,
                seed=self._seed,
                progress=progress,
                on_better=note,
                should_stop=lambda: self._stop() or self.is_done,
            )
        return bool(found)

    def _try(self, plan: Plan) -> bool:
        """Have a plan checked; True where it can be driven and is better than all before it."""
        from rota.check import check_plan

        report = check_plan(plan)
        wrong = [one for one in report.violations if one.kind not in ("gap", "unseeable")]
        if wrong:
            self._note_wrong(wrong)
            return False
        kept = tuple(one.robot for one in plan if one == self._situation.going_on.get(one.robot))
        rank = self._order.of_plan(report, len(plan) - len(kept))
        if rank >= self._rank:
            return False
        self._best, self._rank = Replanned(plan=plan, report=report, kept=kept, stopped_early=False), rank
        self._best_sampled = self._sample(plan)
        if self._tell is not None:
            self._tell(self._best)
        return True

    def _note_wrong(self, wrong: list[Violation]) -> None:
        """Keep what is wrong with a plan that cannot be driven, if it comes nearer than those before."""
        if not self._wrong or len(wrong) < len(self._wrong):
            self._wrong = wrong

    def _sample(self, plan: Plan) -> Rank:
        """How late sample points are; less is better. What it came to last is kept: each plan is asked for twice."""
        from rota.check import sample_lateness

        if (known := next((rank for one, rank in self._sampled if one is plan), None)) is not None:
            return known
        changed = sum(line != self._situation.going_on.get(line.robot) for line in plan)
        rank = self._order.of_sample(sample_lateness(plan, POINTS), changed)
        self._sampled.append((plan, rank))
        return rank


class _FirstSearch(_Search):
    """A search that ends with the first plan that can be driven."""

    _first: Plan | None = None

    @property
    def is_done(self) -> bool:
        return self._first is not None

    def first(self) -> Plan:
        """The plan; NoPlanFound where there is none."""
        return self.outcome(stopped=False).plan if self._first is None else self._first

    def _try(self, plan: Plan) -> bool:
        from rota.check import violations_on_the_way

        if wrong := violations_on_the_way(plan):
            self._note_wrong(wrong)
            return False
        self._first = plan
        return True
