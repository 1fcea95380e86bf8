"""How late simulated vehicles are after ten rounds that are slower than planned and lose time at every stop."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator

from shapely import MultiPolygon, box

from benchmarks.row import Options, Row
from rota.links.link_settings import make_link
from rota.links.sending import routes_for, send_all, start_all
from rota.live.driving import Driving
from rota.live.keeping import Keeping
from rota.live.watch import Watch
from rota.model.mission import DiscSensor, Fleet, Mission, Robot
from rota.model.plan import Plan, Trajectory

ROUND_S, ROUNDS, SEEDS, MOST_S = 45.0, 10, 10, 1.0
SLOW = ("clock=0", "slower=0.05", "stop_noise_s=0.3")


def kept_phase(options: Options) -> Iterator[Row]:
    """Three robots on loops of 45 s, at half their speed and with a wait of 3 s, so that there is time to make up."""
    lags_s = [abs(lag) for seed in range(SEEDS) for lag in asyncio.run(_lags_s(_loops(), seed))]
    worst, mean = max(lags_s), sum(lags_s) / len(lags_s)
    name = f"three simulated vehicles, 5 % slower, 0.3 s lost at stops, {ROUNDS} rounds, {SEEDS} seeds: lateness"
    yield Row(name, f"within {MOST_S:g} s", f"mean {mean:.2f} s, worst {worst:.2f} s", worst < MOST_S)


async def _lags_s(plan: Plan, seed: int) -> list[float]:
    link, watch = make_link("simulated", plan, [*SLOW, f"seed={seed}"]), Watch(plan)
    await link.open()
    await send_all(link, routes_for(plan, link))
    await start_all(link, routes_for(plan, link))
    driving = Driving(link, watch, Keeping(plan, {}), None, lambda notice: None)
    await driving.drive(until_s=2 + ROUND_S * ROUNDS, should_stop=lambda: False)
    return [robot.lag_s for robot in watch.state().robots]


def _loops() -> Plan:
    """Loops of 60 m x 20 m at 4 m/s, 200 m from each other, of robots that can drive at 8 m/s."""
    names, sensor = ("a", "b", "c"), DiscSensor(radius_m=40)
    ways = tuple(
        Trajectory(
            robot=name,
            times_s=[0, 2, 17, 20, 25, 40, ROUND_S],
            positions_m=[[x - 10, 0], [x, 0], [x + 60, 0], [x + 60, 0], [x + 60, 20], [x, 20], [x, 0]],
            loop_start_s=2,
        )
        for name, x in zip(names, (0.0, 200.0, 400.0), strict=True)
    )
    fleet = Fleet(speed_m_s=8, sensor=sensor, robots=[Robot(name=name) for name in names])
    mission = Mission(name="quay", area=MultiPolygon([box(-50, -50, 600, 100)]), period_s=600, fleet=fleet)
    return Plan(mission=mission, trajectories=ways)
