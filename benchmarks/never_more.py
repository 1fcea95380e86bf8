"""More reach or more period never takes more robots: narrow rooms, random flats and open missions, several of each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from shapely import MultiPolygon, Polygon, box

from benchmarks.random_flats import random_flat
from benchmarks.random_missions import random_mission
from benchmarks.row import Options, Row
from rota import DiscSensor, Fleet, Mission, Obstacle, PatrolSettings, SquareSensor, make_plan

MOST = 200
SHARES = (0.7, 1.0, 1.5, 2.5, 5.0)
SHARES_TOLD = ", ".join(f"{share:g}" for share in SHARES)
REACHES_M, PERIODS_S = (1.5, 3.0, 6.0, 12.0, 50.0), (15.0, 30.0, 60.0, 120.0, 240.0)
USUAL_M, USUAL_S = 4.0, 40.0
COMB_REACHES_M = (7.0, 14.0, 30.0, 70.0, 100.0)
QUICK = PatrolSettings(effort="quick")


def never_more(options: Options) -> Iterator[Row]:
    """Robots by reach in narrow rooms; by reach and by period in flats and in the open; teams of one more each time.

    ``--missions N`` takes so many of each, 200 at most. Without time for turning a speed counts as a period does.
    """
    comb = [robots_of(comb_mission(reach_m)) for reach_m in COMB_REACHES_M]
    told = ", ".join(map(str, comb))
    name = f"four narrow rooms off a corridor, reaches of {', '.join(f'{r:g}' for r in COMB_REACHES_M)} m: robots"
    yield Row(name, "1 each, never rising", told, set(comb) == {1})
    seeds = range(min(options.missions, MOST))
    by_reach = [[robots_of(flat_mission(seed, r, USUAL_S)) for r in REACHES_M] for seed in seeds]
    yield _rises(f"{len(seeds)} random flats, reaches of 1.5 to 50 m", by_reach)
    by_period = [[robots_of(flat_mission(seed, USUAL_M, s)) for s in PERIODS_S] for seed in seeds]
    yield _rises(f"{len(seeds)} random flats, periods of 15 to 240 s", by_period)
    by_reach = [[robots_of(open_mission(seed, reach=share)) for share in SHARES] for seed in seeds]
    yield _rises(f"{len(seeds)} open missions, {SHARES_TOLD} times the reach", by_reach)
    by_period = [[robots_of(open_mission(seed, period=share)) for share in SHARES] for seed in seeds]
    yield _rises(f"{len(seeds)} open missions, {SHARES_TOLD} times the periods", by_period)


def robots_of(mission: Mission) -> int:
    """The robots that a plan at quick takes."""
    return len(make_plan(mission, seed=0))


def comb_mission(reach_m: float) -> Mission:
    """Rooms of 1 m x 5 m off a corridor of 1 m; one robot can go round all in 30 s."""
    teeth = [box(x, 0, x + 1, 6) for x in (0, 4, 8, 12)]
    free = box(0, 0, 13, 1).union(MultiPolygon(teeth).buffer(0))
    walls = box(-1, -1, 14, 7) - free
    assert isinstance(walls, Polygon)
    return Mission(
        name="comb", area=box(-1, -1, 14, 7), obstacles=(Obstacle(shape=MultiPolygon([walls])),), period_s=30,
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=reach_m)), planning=QUICK,
    )  # fmt: skip


def flat_mission(seed: int, reach_m: float, period_s: float) -> Mission:
    """A random flat of 3 to 6 rooms, all of it to be seen within a period."""
    fleet = Fleet(speed_m_s=0.5, sensor=DiscSensor(radius_m=reach_m), body_radius_m=0.17)
    return replace(random_flat(seed, "periods"), zones=(), period_s=period_s, fleet=fleet, planning=QUICK)


def open_mission(seed: int, *, reach: float = 1.0, period: float = 1.0) -> Mission:
    """A random mission for as few robots as can be, with so many times its reach and its periods."""
    mission = random_mission(seed)
    sensor = mission.fleet.sensor
    farther = (
        DiscSensor(radius_m=reach * sensor.radius_m)
        if isinstance(sensor, DiscSensor)
        else SquareSensor(side_m=reach * sensor.side_m)
    )
    zones = tuple(
        zone if zone.period_s is None else replace(zone, period_s=period * zone.period_s) for zone in mission.zones
    )
    outside_s = None if mission.period_s is None else period * mission.period_s
    fleet = replace(mission.fleet, sensor=farther, robots=None)
    return replace(mission, zones=zones, period_s=outside_s, fleet=fleet, planning=QUICK)


def _rises(name: str, robots: Sequence[Sequence[int]]) -> Row:
    """How often the robots rise from one to the next."""
    counts = np.array(robots)
    rises = int((np.diff(counts, axis=1) > 0).sum())
    sums = ", ".join(map(str, counts.sum(axis=0).tolist()))
    return Row(f"{name}: times that robots rise", "0", f"{rises} of {np.diff(counts).size}; robots {sums}", rises == 0)
