"""Missions with altitudes: what is refused, footprints by height, plans, their files, their check and pictures."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota.cells.cell_map import cell_map_of
from rota.check import check_plan
from rota.draw.sightings import Sightings
from rota.errors import MissionError
from rota.files.checkpoint_file import read_checkpoint, write_checkpoint
from rota.files.mission_file import read_mission
from rota.files.plan_file import plan_from_json, plan_to_json
from rota.model.mission import DiscSensor, Fleet, Mission, MovingObstacle, StartBox
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.swarm.planner import run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planning.plan_summary import range_at_the_end, range_from

CONE = DiscSensor(radius_m=40, half_angle_deg=30)
EXAMPLE = Path(__file__).parents[1] / "examples" / "swarm-space.yaml"


def mission(robots: int = 8, sensor: DiscSensor = CONE, **changed: object) -> Mission:
    like = Fleet(speed_m_s=2, sensor=sensor, body_radius_m=0.5)
    named = tuple(like.equal_robot(f"r{k}") for k in range(robots))
    values = {"controller": "reciprocal", "altitudes_m": (20, 45), "most_steps": 150, **changed}
    return Mission(
        name="space",
        area=MultiPolygon([box(0, 0, 120, 120)]),
        fleet=replace(like, robots=named, start=StartBox(low_m=(50, 50), high_m=(60, 60))),
        planning=SwarmSettings(**values),  # type: ignore[arg-type]
    )


def test_a_footprint_is_height_times_the_tangent_and_no_more_than_the_radius() -> None:
    assert CONE.radius_at_m(30) == pytest.approx(30 / math.sqrt(3))
    assert (CONE.radius_at_m(100), CONE.radius_at_m(0)) == (40, 0)
    assert CONE.full_height_m == pytest.approx(40 * math.sqrt(3))
    assert DiscSensor(radius_m=40).radius_at_m(0) == 40
    assert range_from(CONE, np.array([0, 0, 30])).area == pytest.approx(math.pi * 300, rel=1e-9)
    assert range_from(CONE, np.array([0, 0])).area == 0


@pytest.mark.parametrize(
    ("changed", "where"),
    [
        ({"altitudes_m": (45, 20)}, "swarm.altitudes_m"),
        ({"altitudes_m": (0, 20)}, "swarm.altitudes_m"),
        ({"altitudes_m": (20, math.nan)}, "swarm.altitudes_m"),
        ({"controller": "voronoi"}, "swarm.controller"),
        ({"altitudes_m": (20, 30, 40)}, "swarm.altitudes_m"),
        ({"altitudes_m": (20, 30, 25, 40)}, "swarm.altitudes_m"),
        ({"velocity": "sampled"}, "swarm.velocity"),
        ({"boundary": "circle"}, "swarm.boundary"),
        ({"delay_steps": 1}, "swarm.delay_steps"),
        ({"messages_lost": 0.1}, "swarm.messages_lost"),
        ({"device": "cuda"}, "swarm.device"),
    ],
)
def test_settings_of_the_plane_are_refused_in_space(changed: dict[str, object], where: str) -> None:
    with pytest.raises(MissionError, match=where):
        mission(**changed)


def test_what_cannot_be_judged_or_done_in_space_is_refused() -> None:
    good = mission()
    with pytest.raises(MissionError, match="period_s"):
        replace(good, period_s=10)
    with pytest.raises(MissionError, match="moving_obstacles"):
        replace(good, moving_obstacles=(MovingObstacle(radius_m=1, times_s=(0,), positions_m=((5, 5),)),))
    robots = good.fleet.robots or ()
    with pytest.raises(MissionError, match="join"):
        replace(good, fleet=replace(good.fleet, robots=(replace(robots[0], joins_s=5), *robots[1:])))
    for planning in (PatrolSettings(), SwarmSettings()):
        with pytest.raises(MissionError, match="half_angle_deg"):
            replace(good, planning=planning, period_s=10)


def test_a_file_s_faults_are_named_with_their_place(tmp_path: Path) -> None:
    text = EXAMPLE.read_text()
    for old, new, told in (
        ("swarm:\n", "swarm:\n  controller: voronoi\n", "swarm.controller"),
        ("altitudes_m: [20, 45]", "altitudes_m: [45, 20]", "swarm.altitudes_m"),
        ("  altitudes_m: [20, 45]", "  stop_m: 0.001", "fleet.sensor.half_angle_deg"),
        ("planner: swarm", "period_s: 5\nplanner: swarm", "period_s"),
        ("half_angle_deg: 30", "half_angle_deg: 90", "fleet.sensor.half_angle_deg"),
    ):
        assert old in text
        path = tmp_path / "mission.yaml"
        path.write_text(text.replace(old, new))
        with pytest.raises(MissionError, match=told):
            read_mission(path)


def test_a_plan_in_space_passes_the_check_and_survives_its_file() -> None:
    run = run_mission(mission(), seed=3)
    assert all(trajectory.positions_m.shape[1] == 3 for trajectory in run.plan)
    assert check_plan(run.plan).verdict == "met"
    again = plan_from_json(plan_to_json(run.plan))
    assert again.trajectories == run.plan.trajectories
    assert SwarmSettings.of(again.mission) == SwarmSettings.of(run.plan.mission)
    assert again.mission.fleet == run.plan.mission.fleet
    starts = np.array([trajectory.positions_m[0] for trajectory in run.plan])
    assert len(set(starts[:, 2])) == len(starts)
    assert ((starts[:, 2] >= 20) & (starts[:, 2] <= 45)).all()
    # footprints where they hold are counted as large as the heights make them
    ends = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
    discs_m2 = float((math.pi * (ends[:, 2] / math.sqrt(3)) ** 2).sum())
    assert range_at_the_end(run.plan)[2] == pytest.approx(discs_m2, rel=1e-6)


@pytest.mark.parametrize("controller", ["reciprocal", "settle"])
def test_a_run_in_space_goes_on_bit_for_bit(controller: str, tmp_path: Path) -> None:
    whole = run_mission(mission(controller=controller), seed=1)
    part = run_mission(mission(controller=controller, most_steps=60), seed=1)
    write_checkpoint(part.state, tmp_path / "a.rota-run")
    rest = run_mission(mission(controller=controller), seed=1, resume=read_checkpoint(tmp_path / "a.rota-run"))
    assert rest.plan.trajectories == whole.plan.trajectories


@pytest.mark.parametrize("controller", ["reciprocal", "settle"])
def test_robots_keep_to_the_bands_that_they_are_dealt_to(controller: str) -> None:
    run = run_mission(mission(controller=controller, altitudes_m=(20, 25, 30, 38, 45, 45)), seed=2)
    assert check_plan(run.plan).verdict == "met"
    for k, trajectory in enumerate(run.plan):
        low, high = ((20, 25), (30, 38), (45, 45))[k % 3]
        z = trajectory.positions_m[:, 2]
        assert ((z >= low - 1e-9) & (z <= high + 1e-9)).all()
        assert z[-1] == pytest.approx(high, abs=1e-9)


def test_the_example_covers_all_that_its_discs_can() -> None:
    asked = read_mission(EXAMPLE).mission
    seen, free, footprints_m2 = range_at_the_end(run_mission(asked, seed=0).plan)
    # 20 discs of 45 m x tan 30 degrees that neither overlap nor reach out of the square
    assert footprints_m2 == pytest.approx(20 * math.pi * (45 * math.tan(math.pi / 6)) ** 2, rel=1e-6)
    assert seen.area >= footprints_m2 - 0.001 * free.area


def test_the_check_wants_a_robot_in_one_band_all_the_time() -> None:
    for altitudes, heights, kinds in (
        ((20, 30, 40, 45), (21, 44), ["above altitudes"]),
        ((20, 30, 40, 45), (44, 21), ["below altitudes"]),
        ((20, 30, 40, 45), (35, 29), ["above altitudes"]),
        ((20, 30, 30, 45), (21, 44), []),
    ):
        good = mission(robots=1, altitudes_m=altitudes)
        places = [(50 + k, 50, height) for k, height in enumerate(heights)]
        plan = Plan(
            mission=good,
            trajectories=(Trajectory(robot="r0", times_s=[0, 60], positions_m=places, loop_start_s=60),),
            seed=0,
        )
        assert [violation.kind for violation in check_plan(plan).violations] == kinds


def test_the_check_names_robots_out_of_the_band() -> None:
    good = mission(robots=1)
    for height, kind in ((19.0, "below altitudes"), (46.0, "above altitudes")):
        places = [(50, 50, height), (51, 50, 30)]
        climbs = Trajectory(robot="r0", times_s=[0, 10], positions_m=places, loop_start_s=10)
        found = check_plan(Plan(mission=good, trajectories=(climbs,))).violations
        assert [(v.kind, v.value, v.time_s) for v in found] == [(kind, height, 0)]
    flat = Plan(mission=good, trajectories=(Trajectory(robot="r0", times_s=[0], positions_m=[(50, 50)]),))
    assert [v.kind for v in check_plan(flat).violations] == ["below altitudes"]


def test_a_film_s_footprints_grow_with_height() -> None:
    good = mission(robots=1)
    places = [(60, 60, 20), (60, 60, 40)]
    plan = Plan(
        mission=good, trajectories=(Trajectory(robot="r0", times_s=[0, 20], positions_m=places, loop_start_s=20),)
    )
    sightings = Sightings(plan, cell_map_of(good, 100))
    areas = [sightings.footprints(time_s)[0].area for time_s in (0, 10, 20)]
    assert areas == pytest.approx([math.pi * height**2 / 3 for height in (20, 30, 40)], rel=2e-3)
