"""Phases of limit cycles that go together although clocks differ, beside the check's own margin of each plan."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon

from rota.check.clocks import clock_margin_s
from rota.files.text_map import text_map
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.planners.bounce.cells import make_cells
from rota.planners.bounce.chosen_group import begin_there
from rota.planners.bounce.limit_cycles import limit_cycles
from rota.planners.bounce.monitoring import Watch
from rota.planners.bounce.planner import apart_in_time, bouncing_robots, monitoring_plan
from rota.planners.bounce.planner_settings import BounceSettings


def random_room(seed: int, angle_deg: float) -> Mission:
    rng = np.random.default_rng(seed)
    text = "\n".join("".join("#" if rng.random() < 0.12 else "." for _ in range(6)) for _ in range(5))
    area, walls = text_map(text, 1.0)
    one = Fleet(speed_m_s=0.5, sensor=DiscSensor(radius_m=1), body_radius_m=0.35)
    robots = tuple(one.equal_robot(name) for name in ("a", "b"))
    fleet = Fleet(speed_m_s=0.5, sensor=one.sensor, body_radius_m=0.35, robots=robots)
    zone = Zone(name="all", shape=MultiPolygon(shapely.get_parts(area).tolist()), period_s=1e6, demand="visit")
    obstacles = () if walls.is_empty else (Obstacle(shape=walls),)
    settings = BounceSettings(cell_m=1.0, bouncing_angles_deg=(angle_deg,))
    return Mission(name="room", area=area, obstacles=obstacles, zones=(zone,), fleet=fleet, planning=settings)


@pytest.mark.parametrize(("seed", "angle_deg"), [(0, 135), (1, 90), (2, 45), (3, 90), (4, 135)])
def test_what_goes_together_is_what_the_check_finds_apart(seed: int, angle_deg: float) -> None:
    mission = random_room(seed, angle_deg)
    bouncing = bouncing_robots(mission, make_cells(mission))
    plain = limit_cycles(bouncing.team)
    asked_s = (0.3, 1.1, 2.9)
    kept = [
        apart_in_time(plain, bouncing.cells, bouncing.apart_m, margin_s / bouncing.step_s).compatible
        for margin_s in asked_s
    ]
    pairs = [pair for pair in itertools.product(range(len(plain.state)), repeat=2) if plain.compatible[pair]]
    rng = np.random.default_rng(seed)
    assert pairs
    for k in rng.choice(len(pairs), min(25, len(pairs)), replace=False):
        watch = Watch(cycles=plain, sees=np.ones((len(plain.state), 1), np.bool_), period_steps=np.ones(1))
        plan = monitoring_plan(bouncing, begin_there(watch, pairs[k], 0.0), 0)
        found_s = clock_margin_s(plan)
        assert found_s is not None
        for margin_s, compatible in zip(asked_s, kept, strict=True):
            if abs(found_s - margin_s) > 1e-4:
                assert bool(compatible[pairs[k]]) == (found_s > margin_s), (pairs[k], found_s, margin_s)
    assert not (kept[-1] & ~kept[0]).any()
    assert apart_in_time(plain, bouncing.cells, bouncing.apart_m, 0.0) is plain
