"""The fewest robots of the method: covers in turn, frames cut for fewer and fewer robots, routes repaired and judged.

The paper stops at routes that Eq. 26 says are short enough. Here the check judges them: routes are led to what they
leave unseen (``repair.repair_until_feasible``), and where this makes them too long, the frame is cut for more robots.
"""

from __future__ import annotations

import math
from importlib import import_module
from typing import NamedTuple, cast

import numpy as np

from rota.model.arrays import Ints
from rota.model.mission import DiscSensor
from rota.planners.patrol.context import Context
from rota.planners.patrol.ground.extra_points import no_points
from rota.planners.patrol.methods.method import Method
from rota.planners.patrol.methods.sun2019.mission_settings import Sun2019
from rota.planners.patrol.methods.sun2019.route import route_round
from rota.planners.patrol.methods.sun2019.sensors import Frame, frames_past_sensors
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.repair.repair import Repaired, repair_until_feasible
from rota.planners.patrol.tolerances import BISECTIONS, TIE
from rota.planners.patrol.tours.tour import Tour

MOST_LOAD = 1.4  # lanes meet borders and lie farther apart than sensors: mean loads up to 1.28 came to pass


class Cuts(NamedTuple):
    """The frames, and how each is cut."""

    frames: list[Frame]
    partitions: list[Partition]

    @property
    def robots(self) -> int:
        """One for each segment."""
        return sum(len(partition.segments) for partition in self.partitions)

    @property
    def share(self) -> float:
        """The largest share of its period that a route takes by Eq. 26."""
        return max(partition.share for partition in self.partitions)


def fewest_robots_by_stages(context: Context) -> Repaired:
    """The best plan of the stages that the mission asks for: by ours, or by those that another distribution brings."""
    module, _, search = settings_of(context).search.partition(":")
    return cast(Method, getattr(import_module(module), search))(context)


def settings_of(context: Context) -> Sun2019:
    """The method's settings in the mission."""
    planning = PatrolSettings.of(context.problem.mission).method_settings
    assert isinstance(planning, Sun2019)
    return planning


def search_by_our_stages(context: Context) -> Repaired:
    """The best repaired plan of the method; it is met unless all repair failed.

    Each frame is cut for as many robots as Eq. 26 asks for, then for fewer and fewer while the check passes. When it
    never passes, the first one is cut for more robots, which leaves every route a margin. Raises NoPlanFound for square
    sensors.
    """
    covers = settings_of(context).covers(PatrolSettings.of(context.problem.mission).effort)
    best: Repaired | None = None
    first: list[Frame] | None = None
    for k, cover in enumerate(covers):
        context.progress(0.9 * k / len(covers), f"deploying sensors ({cover}) and finding a frame past them")
        frames = frames_past_sensors(context.problem, cover)
        first = first or frames
        best = reduce_team(context, frames, best)
        if context.should_stop() or (is_good(best) and best.robots <= context.enough_robots):
            break
    assert best is not None
    assert first is not None
    return best if is_good(best) or context.should_stop() else search_upwards(context, first, best)


def reduce_team(context: Context, frames: list[Frame], best: Repaired | None) -> Repaired:
    """The plan with the fewest robots that these frames give, or the best so far if that has no more."""
    cuts = cut(context, frames, None if best is None or not is_good(best) else best.robots - 1)
    while best is None or (cuts.share <= MOST_LOAD and not context.should_stop()):
        plan = repaired_routes(context, cuts)
        if not is_better(plan, best):
            return best if best is not None else plan
        best = plan
        robots = min(cuts.robots, plan.robots)
        if not is_good(plan) or robots <= max(len(frames), context.enough_robots):
            break
        cuts = cut(context, frames, robots - 1)
    return best


def search_upwards(context: Context, frames: list[Frame], best: Repaired) -> Repaired:
    """A plan of up to eight robots more than the partition asks for; at last, of as many as repair asks for."""
    first = cut(context, frames, None)
    for robots in range(first.robots + 1, first.robots + 9):
        if context.should_stop():
            return best
        plan = repaired_routes(context, cut(context, frames, robots))
        best = plan if is_better(plan, best) else best
        if is_good(best):
            return best
    context.progress(0.9, "finishing with the robots that the repair asks for")
    rounds = 3 * context.settings.repair.rounds
    last = repair_until_feasible(context, routes(context, first), no_points(), may_add=True, rounds=rounds)
    return last if is_better(last, best) else best


def cut(context: Context, frames: list[Frame], robots: int | None) -> Cuts:
    """The frames cut for so many robots in all, one in each at least; None: as many as Eq. 26 asks for.

    Where fewer do, robots leave the frame that then still has the smallest share, and where more do they go to the
    largest.
    """
    problem = context.problem
    sensor = problem.robot.sensor
    assert isinstance(sensor, DiscSensor)
    ways = [Cutting(frame, problem.periods_s, problem.robot.ground_speed_m_s, sensor.radius_m) for frame in frames]
    found = [way.best() for way in ways]
    while robots is not None and sum(len(one.segments) for one in found) > max(robots, len(frames)):
        fewer = {k: ways[k].best(len(one.segments) - 1) for k, one in enumerate(found) if len(one.segments) > 1}
        k = min(fewer, key=lambda k: fewer[k].share)
        found[k] = fewer[k]
    for _ in range(0 if robots is None else robots - sum(len(one.segments) for one in found)):
        k = max(range(len(found)), key=lambda k: found[k].share)
        found[k] = ways[k].best(min(len(found[k].segments) + 1, len(frames[k].legs_m)))
    return Cuts(frames, found)


def repaired_routes(context: Context, cuts: Cuts) -> Repaired:
    """The routes round the segments, repaired and shortened until the check passes or the rounds are over."""
    context.progress(0.5, f"leading {cuts.robots} robots round their segments")
    rounds = context.settings.repair.rounds
    return repair_until_feasible(context, routes(context, cuts), no_points(), may_add=False, rounds=rounds)


def routes(context: Context, cuts: Cuts) -> list[Tour]:
    """The segments' routes as tours of a robot each, which serve what has the shortest period of their sensors."""
    problem, tours = context.problem, list[Tour]()
    sensor = problem.robot.sensor
    assert isinstance(sensor, DiscSensor)
    for frame, partition in zip(cuts.frames, cuts.partitions, strict=True):
        for segment in partition.segments:
            line_m = problem.paths.paths_along(frame.places_m[segment])
            k = int(np.min(frame.period_class[segment]))
            tours.append(
                Tour(
                    vertices_m=route_round(line_m, problem.paths, radius_m=sensor.radius_m), period_class=k,
                    period_s=problem.periods_s[k], robots=1, robot=problem.robot, component=frame.part,
                )
            )  # fmt: skip
    return tours


def is_good(repaired: Repaired) -> bool:
    """Whether the plan passed, and no route is longer than its period allows."""
    return repaired.met and repaired.within_budgets


def is_better(plan: Repaired, best: Repaired | None) -> bool:
    """Whether a plan is better than the best so far: one that passes, then fewer robots."""
    if best is None or not is_good(plan):
        return best is None
    return not is_good(best) or plan.robots < best.robots


class Partition(NamedTuple):
    """Segments of a frame in its order: the sensors (k,) of each, and the largest share of its period any takes."""

    segments: list[Ints]
    share: float


class Cutting:
    """The ways to cut a frame for robots of a speed and a range."""

    def __init__(self, frame: Frame, periods_s: tuple[float, ...], speed_m_s: float, radius_m: float) -> None:
        n = len(frame.legs_m)
        self._n = n
        self._along_m = np.concatenate([[0.0], np.cumsum(np.tile(frame.legs_m, 2))])
        self._period_s: list[float] = np.tile(np.array(periods_s)[frame.period_class], 2).tolist()
        self._speed_m_s, self._around_m = speed_m_s, 2 * math.pi * radius_m

    def share(self, first: int, count: int) -> float:
        """Of the shortest period of so many sensors from ``first`` on, what one robot's route round them takes."""
        segment_m = self._along_m[first + count - 1] - self._along_m[first]
        time_s = (2 * float(segment_m) + self._around_m) / self._speed_m_s
        return time_s / float(min(self._period_s[first : first + count]))

    def best(self, segments: int | None = None) -> Partition:
        """So many segments at most, or as few as keep their periods, with the smallest largest share of a period."""
        n = self._n
        alone = max(self.share(k, 1) for k in range(n))
        if segments is None:
            segments = len(self._cut(max(1.0, alone)))
        whole = max(self.share(k, n) for k in range(n))
        low, high = alone, max(whole, alone) * (1 + TIE)
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            low, high = (low, middle) if len(self._cut(middle)) <= segments else (middle, high)
        firsts = self._cut(high)
        counts = [(b - a - 1) % n + 1 for a, b in zip(firsts, [*firsts[1:], firsts[0]], strict=True)]
        largest = max(self.share(a, count) for a, count in zip(firsts, counts, strict=True))
        return Partition([(a + np.arange(count)) % n for a, count in zip(firsts, counts, strict=True)], largest)

    def _cut(self, share: float) -> list[int]:
        """The first sensors of the fewest segments that each take so much of their period at most, or are alone."""
        n, longest, count = self._n, list[int](), 1
        for first in range(n):  # a segment that ends no sooner than the one before it
            count = max(1, count - 1)
            while count < n and self.share(first, count + 1) <= share:
                count += 1
            longest.append(count)
        if longest[0] == n:
            return [0]
        best: list[int] | None = None
        for begin in range(longest[0] + 1):  # some segment begins there
            firsts, at = list[int](), begin
            while at < begin + n:
                firsts.append(at % n)
                at += longest[at % n]
            best = firsts if best is None or len(firsts) < len(best) else best
        assert best is not None
        return best
