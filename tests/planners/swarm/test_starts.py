"""Starts in boxes that are too tight for random places."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from shapely import MultiPolygon, box

from rota.check import check_plan
from rota.errors import MissionError
from rota.geometry.free_space import free_ground
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, StartBox
from rota.planners.swarm import starts
from rota.planners.swarm.planner import run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.starts import place_starts


def mission(
    robots: int, box_m: tuple[float, float], body_m: float = 1.0, own: tuple[Any, ...] = (), **changed: Any
) -> Mission:
    fleet = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=25), body_radius_m=body_m)
    listed = [fleet.equal_robot(f"r{k}") for k in range(robots)]
    for k, start in enumerate(own):
        listed[k] = dataclasses.replace(listed[k], start=start)
    start_box = StartBox(low_m=(20, 20), high_m=(20 + box_m[0], 20 + box_m[1]))
    fleet = dataclasses.replace(fleet, robots=tuple(listed), start=start_box)
    area = MultiPolygon([box(0, 0, 150, 150)])
    return Mission(**{"name": "m", "area": area, "fleet": fleet, "planning": SwarmSettings(most_steps=30)} | changed)


@pytest.mark.parametrize(
    ("robots", "box_m"),
    [(36, (10, 10)), (39, (10, 10)), (6, (10, 0)), (6, (0, 10)), (30, (10, 10)), (100, (19, 19))],
)
@pytest.mark.parametrize("seed", [0, 1])
def test_as_many_as_a_lattice_holds_begin_apart_and_in_the_box(robots: int, box_m: Any, seed: int) -> None:
    """Centres in 10 m x 10 m, 2 m apart: 6 x 6 on a square lattice, and in rows 6 + 5 + 6 + ..., six of them, 33."""
    asked = mission(robots, box_m)
    if robots == 39:
        with pytest.raises(MissionError, match="for 39 robots with bodies of up to 1 m; a lattice holds 36 of them"):
            place_starts(asked, free_ground(asked), seed=seed, reserve_m=0.05)
        return
    starts = place_starts(asked, free_ground(asked), seed=seed, reserve_m=0.05)
    assert pdist(starts).min() >= 2 - 1e-12
    assert (starts >= 20 - 1e-9).all()
    assert (starts <= 20 + np.array(box_m) + 1e-9).all()
    assert check_plan(run_mission(asked, seed=seed).plan).violations == ()


def test_a_lattice_is_shaken_by_what_room_it_leaves() -> None:
    asked = mission(28, (10, 10))  # random places end at some 20
    one, two = (place_starts(asked, free_ground(asked), seed=seed, reserve_m=0.0) for seed in (0, 1))
    assert (one == place_starts(asked, free_ground(asked), seed=0, reserve_m=0.0)).all()
    assert np.abs(one - two).max() > 1
    distances = np.sort(pdist(one))
    assert 2 <= distances[0] < distances[20] - 1e-3  # no lattice any more


@pytest.mark.parametrize(
    ("robots", "side_m", "tried", "laid"),
    [
        (1270, 50, True, False),
        (1500, 50, True, True),
        (1650, 50, False, True),
        (2500, 50, False, True),
        (36, 6, True, True),
    ],
)
def test_no_place_is_tried_at_random_where_many_would_fill_more_than_that_can(
    robots: int, side_m: float, tried: bool, laid: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Discs of one size at random fill 0.547 of a wide room (Feder 1980); 1500, 1650 and 2500 of 1.1 m 0.55 to 0.91."""
    asked = mission(robots, (side_m, side_m), body_m=0.5)
    random: list[Any] = []
    lattices: list[Any] = []
    monkeypatch.setattr(starts, "_free_place", noting(starts._free_place, random))
    monkeypatch.setattr(starts, "lattice_starts", noting(starts.lattice_starts, lattices))
    places = place_starts(asked, free_ground(asked), seed=0, reserve_m=0.05)
    assert pdist(places).min() >= 1 - 1e-12
    assert (len(random) > 0, len(lattices) > 0) == (tried, laid)
    assert laid or len(random) == robots == len(places)


def test_a_room_of_many_parts_is_tried_at_random_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts with room for one body each are filled by it, so that shares of wide rooms say nothing."""
    parts = [box(20 + x, 20 + y, 21.15 + x, 21.15 + y) for x in 1.17 * np.arange(34) for y in 1.17 * np.arange(34)]
    asked = mission(1000, (40, 40), body_m=0.5, area=MultiPolygon(parts))
    room_m2 = free_ground(asked).buffer(-0.5).buffer(0.5).area
    assert 1000 * np.pi * 0.5**2 > 0.61 * room_m2
    monkeypatch.setattr(starts, "lattice_starts", lambda *_, **__: (np.empty((0, 2)), 0))
    assert pdist(place_starts(asked, free_ground(asked), seed=0, reserve_m=0.0)).min() >= 1


def noting(function: Any, calls: list[Any]) -> Any:
    """The function, with a list that grows at each call."""

    def noted(*args: Any, **named: Any) -> Any:
        calls.append(args)
        return function(*args, **named)

    return noted


def test_a_lattice_keeps_clear_of_obstacles_and_of_robots_with_starts() -> None:
    obstacle = Obstacle(shape=MultiPolygon([box(24, 24, 26, 26)]))
    asked = mission(24, (10, 10), own=((20.5, 29.5), (29.0, 21.0)), obstacles=(obstacle,))
    starts = place_starts(asked, free_ground(asked), seed=0, reserve_m=0.0)
    assert starts[:2].tolist() == [[20.5, 29.5], [29.0, 21.0]]
    assert pdist(starts).min() >= 2 - 1e-12
    assert check_plan(run_mission(asked, seed=0).plan).violations == ()
