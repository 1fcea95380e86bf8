"""Pairs of legs that may touch: all of them, each once, and none of one robot, as comparing all with all finds them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from shapely import LineString, box

from rota.check import near_legs as near
from rota.check.routes import LOOP, TRANSIENT, Routes, routes_of
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.model.plan import Plan, Trajectory


def random_plan(rng: np.random.Generator) -> Plan:
    """Robots on a small floor: some come to hold, some loop at once or later, some wait on the way."""
    trajectories = []
    for k in range(int(rng.integers(2, 6))):
        n = int(rng.integers(1, 40))
        places = np.round(rng.uniform(0, 6, (n, 2)), int(rng.integers(0, 3)))
        times = np.concatenate([[0.0], np.cumsum(rng.choice([0.1, 0.5, 1.0, 7.0], n - 1))])
        loop = int(rng.choice([n - 1, 0, n // 2]))
        places[-1] = places[loop]
        if rng.random() < 0.5:  # as long a loop as others have, by legs as long or by one that makes up for the rest
            times[loop + 1 :] += max(0.0, 150 - times[-1] + times[loop]) if times[-1] > times[loop] else 0.0
        trajectories.append(Trajectory(robot=f"r{k}", times_s=times, positions_m=places, loop_start_s=times[loop]))
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1))
    mission = Mission(name="m", area=box(0, 0, 6, 6), period_s=9, fleet=fleet)
    return Plan(mission=mission, trajectories=tuple(trajectories))


def all_with_all(routes: Routes, bodies: NDArray[np.float64]) -> set[tuple[int, int]]:
    lines = [LineString(leg.reshape(2, 2)) for leg in routes.legs_m]
    found = set()
    for i in range(len(lines)):
        for j in range(len(lines)):
            one, other = routes.robots[i], routes.robots[j]
            if one >= other or not lines[i].distance(lines[j]) < bodies[one] + bodies[other] - 1e-6:
                continue
            (a0, a1), (b0, b1) = routes.times_s[i], routes.times_s[j]
            passing = routes.kinds[i] == routes.kinds[j] == TRANSIENT
            turn_s = routes.durations_s[one] if routes.kinds[i] == routes.kinds[j] == LOOP else 0.0
            in_step = turn_s > 0 and abs(turn_s - routes.durations_s[other]) < 1e-9 * turn_s
            shifts = np.arange(-60, 61) * turn_s if in_step else np.zeros(1)
            meets = np.maximum(a0, b0 + shifts) <= np.minimum(a1, b1 + shifts) + 1e-9 * turn_s
            if meets.any() or not (passing or in_step):
                found.add((i, j))
    return found


@pytest.mark.parametrize("seed", range(16))
def test_pairs_are_those_of_comparing_all_with_all(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(seed)
    monkeypatch.setattr(near, "FEWEST_IN_SLICE", int(rng.integers(1, 9)))
    monkeypatch.setattr(near, "MOST_AT_ONCE", 64)
    routes = routes_of(random_plan(rng))
    bodies = rng.uniform(0, 0.7, len(routes.durations_s))
    found = [pair for a, b in near.near_legs(routes, bodies) for pair in zip(a.tolist(), b.tolist(), strict=True)]
    assert len(found) == len(set(found))
    assert set(found) == all_with_all(routes, bodies)


@pytest.mark.parametrize("seed", range(3))
def test_ways_are_near_whatever_their_times(seed: int) -> None:
    routes = routes_of(random_plan(np.random.default_rng(seed)))
    lines = [LineString(leg.reshape(2, 2)) for leg in routes.legs_m]
    every = range(len(lines))
    expected = {
        (i, j)
        for i in every
        for j in every
        if routes.robots[i] < routes.robots[j] and lines[i].distance(lines[j]) <= 0.9
    }
    found = [pair for a, b in near.near_ways(routes, 0.9) for pair in zip(a.tolist(), b.tolist(), strict=True)]
    assert len(found) == len(set(found))
    assert set(found) == expected


def test_a_robot_that_trembles_is_not_compared_with_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    # two robots side by side, each leg of either within reach of all others: work must grow as the legs do
    asked = []
    query = near._near_pairs

    def counted(*args: object) -> object:
        asked.append(sum(len(a) for a, _, _ in query(*args)))  # type: ignore[arg-type]
        return query(*args)  # type: ignore[arg-type]

    monkeypatch.setattr(near, "_near_pairs", counted)
    work = {}
    for n in (500, 2000):
        asked.clear()
        rng = np.random.default_rng(1)
        tracks = tuple(
            Trajectory(
                robot=name,
                times_s=np.arange(n),
                positions_m=np.array([x, 3]) + rng.uniform(0, 0.1, (n, 2)),
                loop_start_s=n - 1,
            )
            for name, x in (("a", 1.0), ("b", 2.0))
        )
        mission = Mission(
            name="m", area=box(0, 0, 6, 6), period_s=9, fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=1))
        )
        pairs = near.near_legs(routes_of(Plan(mission=mission, trajectories=tracks)), np.array([0.6, 0.6]))
        assert sum(len(a) for a, _ in pairs) >= n - 1
        work[n] = sum(asked)
    assert work[2000] < 4.5 * work[500]
