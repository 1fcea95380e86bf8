"""Places with periods of their own: a hub between posts, and random places, each to be visited within its period.

The random ones are in the manner of two papers, whose instances are not at hand. Places lie anywhere in a square.
*Deadlines*, as for N. Drucker, M. Penn and O. Strichman, "Cyclic Routing of Unmanned Aerial Vehicles" (CPAIOR 2016):
periods from the longest way between two places to five times that. *Latencies*, as for A. B. Asghar, S. L. Smith and
S. Sundaram, "Multi-Robot Routing for Persistent Monitoring with Latency Constraints" (arXiv 1903.06105, 2019): from a
k-th of the shortest round trip to all of it, k from 2 to 5.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from unittest.mock import patch

import numpy as np
from shapely import MultiPolygon, Point, box

from benchmarks.row import Options, Row
from rota import DiscSensor, Fleet, Mission, PatrolSettings, Zone, make_plan
from rota.check import check_plan
from rota.planners.patrol.cycles.subset_kernels import round_trips

EACH = 100
MOST_PLACES, SIDE_M, RADIUS_M = 12, 100.0, 0.1
QUICK = PatrolSettings(effort="quick")
FLEET = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2))


def cyclic_visits(options: Options) -> Iterator[Row]:
    """The posts, then the random missions of each kind, and all of them together."""
    for ends in (2, 3):
        told = [robots_of(posts_mission(ends, robots)) for robots in (None, 1)]
        name = f"a hub every 20.5 s and {ends} posts 10 m away every {20.5 * ends:g} s, fewest, and robots: 1"
        yield Row(name, "1 robot, met", ", ".join(told), told == ["1 robot, met"] * 2)
    gaps: list[int] = []
    for kind in ("deadlines", "latencies"):
        begin = time.process_time()
        own = [robots_beyond_bound(random_places(seed, kind)) for seed in range(EACH)]
        took_s = time.process_time() - begin
        yield _row(f"{EACH} random missions of 3 to {MOST_PLACES} places, {kind}", own, f"; {took_s:.0f} s of CPU")
        gaps += own
    yield _row(f"{len(gaps)} random missions of 3 to {MOST_PLACES} places", gaps, "")
    fewer, told = spared()
    yield Row(f"the same {len(gaps)}: robots, beside those of the usual search alone", "fewer", told, fewer > 0)


def spared() -> tuple[int, str]:
    """The robots that all random missions take less with such rounds, and how many missions do."""
    missions = [random_places(seed, kind) for kind in ("deadlines", "latencies") for seed in range(EACH)]
    robots = [len(make_plan(mission, seed=0)) for mission in missions]
    with patch("rota.planners.patrol.methods.tours.fewest_for_targets", lambda context, search: search(context)):
        plain = [len(make_plan(mission, seed=0)) for mission in missions]
    more = np.subtract(plain, robots)
    told = f"{sum(robots)}, {sum(plain)} alone; {(more > 0).sum()} missions take fewer, {(more < 0).sum()} more"
    return int(more.sum()), told


def _row(name: str, gaps: list[int], more: str) -> Row:
    """How many plans have as many robots as is proved necessary, and how many have one more."""
    near = sum(gap <= 1 for gap in gaps) / len(gaps)
    told = f"{near:.1%}: {gaps.count(0)} optimal, {gaps.count(1)} within 1, {sum(gap > 1 for gap in gaps)} beyond{more}"
    return Row(f"{name}: robots beyond the proved bound", "at most 1 for 95 %", told, near >= 0.95)


def robots_beyond_bound(mission: Mission) -> int:
    """The robots of a plan at quick, which the check must pass, less those that are proved necessary."""
    plan = make_plan(mission, seed=0)
    assert check_plan(plan).verdict == "met", mission.name
    return len(plan) - (plan.lower_bound_robots or 0)


def robots_of(mission: Mission) -> str:
    """The robots of a plan, and the verdict."""
    plan = make_plan(mission, seed=0)
    return f"{len(plan)} robot{'s'[: len(plan) > 1]}, {check_plan(plan).verdict}"


def posts_mission(ends: int, robots: int | None) -> Mission:
    """A hub, and posts 10 m away, each due once in as many of the hub's periods as there are posts."""
    at_m = {"east": (10.0, 0.0), "north": (-5.0, 8.66), "south": (-5.0, -8.66)}
    places = {"hub": (0.0, 0.0), **dict(list(at_m.items())[:ends])}
    zones = [visit(name, at, 20.5 if name == "hub" else 20.5 * ends, 0.3) for name, at in places.items()]
    fleet = FLEET if robots is None else Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2), robots=robots)
    area = MultiPolygon([box(-12, -12, 12, 12)])
    return Mission(name="posts", area=area, period_s=None, zones=tuple(zones), fleet=fleet, planning=QUICK)


def random_places(seed: int, kind: str) -> Mission:
    """A mission of one kind: places to visit in a square."""
    random = np.random.default_rng(seed)
    places_m = random.uniform(0, SIDE_M, (int(random.integers(3, MOST_PLACES + 1)), 2))
    apart_m = np.hypot(*(places_m[:, None] - places_m[None]).transpose(2, 0, 1))
    if kind == "deadlines":
        periods_s = random.uniform(apart_m.max(), 5 * apart_m.max(), len(places_m))
    else:
        trip_m = float(round_trips(apart_m)[0][-1])
        periods_s = random.uniform(trip_m / int(random.integers(2, 6)), trip_m, len(places_m))
    zones = [visit(f"place {k + 1}", places_m[k], float(periods_s[k]), RADIUS_M) for k in range(len(places_m))]
    return Mission(
        name=f"{kind} {seed}", area=MultiPolygon([box(-1, -1, SIDE_M + 1, SIDE_M + 1)]), period_s=None,
        zones=tuple(zones), fleet=FLEET, planning=QUICK,
    )  # fmt: skip


def visit(name: str, at_m: tuple[float, float] | np.ndarray, period_s: float, radius_m: float) -> Zone:
    """A disc to visit."""
    shape = MultiPolygon([Point(*at_m).buffer(radius_m)])
    return Zone(name=name, period_s=period_s, demand="visit", shape=shape)
