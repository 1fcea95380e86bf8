"""What it costs to watch a fleet: simulated vehicles that report five times a second, on one core."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator

from shapely import box

from benchmarks.row import Options, Row
from rota.links.link_settings import make_link
from rota.links.sending import routes_for, send_all, start_all
from rota.live.session import Session
from rota.live.watch import Watch
from rota.live.watch_log import LogWriter
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, Zone
from rota.model.plan import Plan, Trajectory

ROBOTS, RATE_HZ = 200, 5
WARM_S, MEASURED_S = 20.0, 60.0
COLUMNS, CELL_M, SPEED_M_S, REACH_M = 20, (60.0, 40.0), 8.0, 15.0
MOST_SHARE = 1.0


def watched_fleet(options: Options) -> Iterator[Row]:
    """200 vehicles in 480,000 m2 with 200 sheds and 20 zones: ages, forecasts, log and the vehicles themselves."""
    plan = field_of_robots()
    watch = Watch(plan)
    asyncio.run(_watched(plan, watch, options, vehicles_only=False, until_s=WARM_S))
    spent = {}
    for alone in (True, False):
        watch = Watch(plan)
        spent[alone] = asyncio.run(_watched(plan, watch, options, vehicles_only=alone, until_s=MEASURED_S))
    places, told = len(watch.places.points_m), watch.lapses
    share = spent[False] / MEASURED_S
    measured = (
        f"{share:.2f} s of CPU in a second, {spent[True] / MEASURED_S:.2f} s of them the vehicles' own;"
        f" {places:,} places, {told} lapses"
    )
    yield Row(
        f"{ROBOTS} simulated vehicles watched at {RATE_HZ} Hz", f"< {MOST_SHARE:g} s of CPU in a second: one core",
        measured, share < MOST_SHARE,
    )  # fmt: skip


async def _watched(plan: Plan, watch: Watch, options: Options, *, vehicles_only: bool, until_s: float) -> float:
    """CPU seconds that a fleet takes until some second, watched or only driven."""
    link = make_link("simulated", plan, ["clock=0", f"rate_hz={RATE_HZ}", "speed_noise=0.01"])
    await link.open()
    routes = routes_for(plan, link)
    await send_all(link, routes)
    await start_all(link, routes)
    path = options.folder / f"watched-{until_s:g}.rota-log"
    path.unlink(missing_ok=True)
    with LogWriter(path, plan, watch.settings) as log:
        begin = time.process_time()
        if vehicles_only:
            async for report in link.reports():
                if report.time_s >= until_s:
                    break
        else:
            await Session(watch, log, lambda notices: None).follow(link, until_s=until_s, should_stop=lambda: False)
        spent_s = time.process_time() - begin
    await link.close()
    return spent_s


def field_of_robots() -> Plan:
    """Each robot goes round a shed in a cell of 60 m by 40 m every 15 s, and sees all of it; every tenth is a zone."""
    wide, high = CELL_M
    corners = [(column * wide, row * high) for row in range(ROBOTS // COLUMNS) for column in range(COLUMNS)]
    cells = [box(x, y, x + wide, y + high) for x, y in corners]
    sheds = [box(x + 28, y + 18, x + 32, y + 22) for x, y in corners]
    sensor = DiscSensor(radius_m=REACH_M)
    names = [f"robot-{k + 1}" for k in range(ROBOTS)]
    ways = []
    for name, (x, y) in zip(names, corners, strict=True):
        ring = [(x + 10, y + 10), (x + wide - 10, y + 10), (x + wide - 10, y + high - 10), (x + 10, y + high - 10)]
        sides = [0.0, wide - 20, high - 20, wide - 20, high - 20]
        times = [sum(sides[: k + 1]) / SPEED_M_S for k in range(5)]
        ways.append(Trajectory(robot=name, times_s=times, positions_m=[*ring, ring[0]]))
    mission = Mission(
        name="field",
        area=box(0, 0, COLUMNS * wide, ROBOTS // COLUMNS * high),
        obstacles=tuple(Obstacle(shape=shed) for shed in sheds),
        zones=tuple(Zone(name=f"zone {k + 1}", shape=cell, period_s=24.0) for k, cell in enumerate(cells[::10])),
        period_s=30.0,
        fleet=Fleet(
            speed_m_s=SPEED_M_S,
            sensor=sensor,
            robots=tuple(Robot(name=name, speed_m_s=SPEED_M_S, sensor=sensor) for name in names),
        ),
    )
    return Plan(mission=mission, trajectories=tuple(ways))
