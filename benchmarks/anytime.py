"""How many robots the best plan so far has, by seconds of search: with a plan of lanes first, and without."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from benchmarks.random_missions import random_mission
from benchmarks.row import Options, Row
from rota.errors import NoPlanFound
from rota.model.mission import Mission
from rota.planners.patrol.methods import tours
from rota.planning.make_plan import search_plan
from rota.planning.progress import SearchState

MISSIONS = 100
AFTER_S = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0)


class Found(NamedTuple):
    """Processor seconds of one search, its bound, and each better plan that passes: after which seconds, its robots."""

    cpu_s: float
    bound: int
    plans: list[tuple[float, int]]

    def robots_after(self, seconds: float) -> int | None:
        """The robots of the best plan so far; None before the first."""
        return min((robots for told_s, robots in self.plans if told_s <= seconds), default=None)


def anytime(options: Options) -> Iterator[Row]:
    """Robots against seconds over a hundred of the random missions, beside a search that does not begin with lanes.

    Seconds are those of the processor, from the mission to the verdict, in a process that has compiled all.
    """
    seeds = range(options.first_seed, options.first_seed + min(options.missions, MISSIONS))
    missions = [mission for mission in map(random_mission, seeds) if mission.fleet.robots is None]
    for mission in missions[:3]:
        searched(mission)  # compiles
    new, old = [], []
    for mission in missions:
        new.append(searched(mission))
        with without_lanes():
            old.append(searched(mission))
    what = f"{len(missions)} random missions, quick"
    for seconds in AFTER_S:
        measured = f"{told(new, seconds)}; without lanes first {told(old, seconds)}"
        yield Row(f"{what}: after {seconds:g} s", "-", measured, None)
    most_s = max(found.plans[0][0] for found in new if found.plans)
    late = sum(not found.plans or found.plans[0][0] > 1 for found in new)
    measured = f"{len(new) - late} of {len(new)}; the last after {most_s:.1f} s"
    yield Row(f"{what}: a plan that passes", "within 1 s", measured, late == 0)
    robots, before = (sum(found.plans[-1][1] for found in founds if found.plans) for founds in (new, old))
    cpu_s, cpu_before_s = (sum(found.cpu_s for found in founds) for founds in (new, old))
    measured = f"{robots} robots, {cpu_s:.0f} s; without lanes first {before} robots, {cpu_before_s:.0f} s"
    yield Row(f"{what}: at the end", "no robot more", measured, robots <= before)


def searched(mission: Mission) -> Found:
    """The search for a plan of this mission, and the plans on its way."""
    plans: list[tuple[float, int]] = []
    began_s = time.process_time()

    def note(state: SearchState) -> None:
        if state.met and (not plans or state.robots < plans[-1][1]):
            plans.append((time.process_time() - began_s, state.robots))

    bound = 0
    try:
        bound = search_plan(mission, watch=note).plan.lower_bound_robots or 0
    except NoPlanFound:
        plans.clear()
    return Found(time.process_time() - began_s, bound, plans)


@contextmanager
def without_lanes() -> Iterator[None]:
    """Within the block the search does not begin with lanes."""
    swept = tours.sweep
    tours.sweep = lambda *_: None  # type: ignore[assignment]
    try:
        yield
    finally:
        tours.sweep = swept


def told(founds: list[Found], seconds: float) -> str:
    """How many missions have a plan by then, and how many robots in all, beside the bounds of these missions."""
    begun = [(count, found.bound) for found in founds if (count := found.robots_after(seconds)) is not None]
    robots, bounds = (sum(column) for column in zip(*begun, strict=True)) if begun else (0, 0)
    return f"{len(begun)} have a plan, {robots} robots (bounds {bounds})"
