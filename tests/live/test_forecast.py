"""Forecasts beside brute force: sights by plan in small steps of time, each robot as late as it is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.live.two_robots import two_robots

from rota.geometry.free_space import sight_walls
from rota.geometry.line_of_sight import edge_grid, sees
from rota.live.forecast import Forecast
from rota.live.places import places_of

STEP_S = 0.02


@pytest.mark.parametrize("thermal", [False, True])
@pytest.mark.parametrize(
    ("lags_s", "until_s"),
    [((0.0, 0.0), (math.inf, math.inf)), ((7.0, -2.5), (math.inf, 20.0)), ((0.0, 3.0), (-math.inf, math.inf))],
)
def test_first_lapses_agree_with_brute_force(
    lags_s: tuple[float, float], until_s: tuple[float, float], thermal: bool
) -> None:
    plan = two_robots(thermal=thermal)
    places = places_of(plan.mission, most=400)
    now_s = 11.0
    rng = np.random.default_rng(2)
    last_seen_s = now_s - rng.uniform(0, 15, len(places.points_m))
    forecast = Forecast(plan, places)
    lapses = forecast.lapses(last_seen_s, now_s, np.array(lags_s), np.array(until_s))
    times_s = np.arange(now_s, now_s + 2 * 60.0, STEP_S)
    tracks_m = [way.at(np.maximum(times_s - lag, 0)) for way, lag in zip(plan, lags_s, strict=True)]
    walls = edge_grid(sight_walls(plan.mission))
    firsts: dict[int, float] = {}
    for place, (at, k) in enumerate(zip(places.points_m, places.demand, strict=True)):
        demand = places.demands[k]
        seen = np.zeros(len(times_s), bool)
        # for zones that name a sensor the second robot counts alone
        first = 1 if demand.sensors else 0
        for track_m, until in list(zip(tracks_m, until_s, strict=True))[first:]:
            if demand.demand == "visit":
                near = (track_m[:, 0] >= 48) & (track_m[:, 0] <= 52)
            else:
                near = np.hypot(*(track_m - at).T) <= 3.0
                near[near] = sees(track_m[near], np.tile(at, (near.sum(), 1)), walls)
            seen |= near & (times_s <= until)
        moments = np.concatenate([[last_seen_s[place]], times_s[seen], [np.inf]])
        late = np.flatnonzero(np.diff(moments) > demand.period_s + 2 * STEP_S)
        if len(late):
            lapse_s = moments[late[0]] + demand.period_s
            if lapse_s <= now_s + 2 * demand.period_s:
                firsts[int(k)] = min(firsts.get(int(k), math.inf), lapse_s)
    assert {lapse.demand for lapse in lapses} == set(firsts)
    for lapse in lapses:
        assert lapse.at_s == pytest.approx(firsts[lapse.demand], abs=3 * STEP_S)


def test_places_are_as_close_as_is_told() -> None:
    mission = two_robots().mission
    places = places_of(mission)
    spacings = dict(zip((demand.name for demand in places.demands), places.spacings_m, strict=True))
    assert spacings["area"] == pytest.approx(3.0 / 8)
    assert spacings["left"] == pytest.approx(math.sqrt(2.0) / 6)  # its sides are 1 m and 2 m
    assert math.isnan(spacings["gate"])
    area = places.points_m[places.demand == [d.name for d in places.demands].index("area")]
    assert len(area) == pytest.approx((400 - 16 - 2 - 0.5) / 0.375**2, rel=0.05)
    few = places_of(mission, most=100)
    assert 60 < len(few.points_m) < 240
