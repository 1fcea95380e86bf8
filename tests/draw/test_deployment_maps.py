"""Pictures and films of robots that spread and hold: what they cover in the end, and at any time of the film."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from shapely import box

from rota.draw import animate_plan, draw_plan
from rota.draw.deployment_frames import DeploymentFrames
from rota.draw.deployment_maps import covered_colour, is_deployment
from rota.draw.plan_picture import plan_figure
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, DiscSensor, Fleet, Mission, Obstacle, Robot, Zone
from rota.model.plan import Charge, Plan, Trajectory
from rota.planners.swarm.planner_settings import SwarmSettings

LENS_M2 = 2 * 10**2 * math.acos(15 / 20) - 7.5 * math.sqrt(4 * 10**2 - 15**2)  # of two discs of 10 m, 15 m apart


@pytest.fixture
def spread() -> Plan:
    """Two robots that go from the middle to 15 m of each other; they see 10 m, on 100 m x 40 m with an obstacle."""
    sensor = DiscSensor(radius_m=10)
    robots = tuple(Robot(name=f"robot-{k}", speed_m_s=1, sensor=sensor, body_radius_m=0.5) for k in (1, 2))
    mission = Mission(
        name="spread",
        area=box(0, 0, 100, 40),
        obstacles=(Obstacle(shape=box(80, 10, 90, 30)),),
        fleet=Fleet(speed_m_s=1, sensor=sensor, robots=robots),
        planning=SwarmSettings(),
    )
    ways = [[(20.0, 20.0), (20.0, 20.0)], [(22.0, 20.0), (35.0, 20.0)]]
    times = [[0.0], [0.0, 13.0]]
    trajectories = tuple(
        Trajectory(robot=robot.name, times_s=time, positions_m=way[: len(time)], loop_start_s=time[-1])
        for robot, way, time in zip(robots, ways, times, strict=True)
    )
    return Plan(mission=mission, trajectories=trajectories)


def test_the_legend_tells_the_closed_form_of_two_discs(spread: Plan):
    fig = plan_figure(spread)
    assert [ax.get_title(loc="left") for ax in fig.axes] == [
        "Ways from the starts, robots numbered where they hold",
        f"In range of some robot in the end: {(200 * math.pi - LENS_M2) / 3800:.1%} of the ground",
    ]
    told = [text.get_text() for text in fig.legends[1].get_texts()]
    share = (200 * math.pi - LENS_M2) / 3800
    assert told == [
        f"in range: {share:.1%}", "in range of two or more", f"in nobody's range: {1 - share:.1%}", "robot",
        f"of all discs {LENS_M2 / (200 * math.pi):.1%} overlap or lie outside", "obstacle",
    ]  # fmt: skip
    assert [text.get_text() for text in fig.texts] == ["spread", "2 robots · nothing asked of the ground"]


def test_ground_is_coloured_by_how_many_have_it_in_range(spread: Plan, tmp_path: Path):
    draw_plan(spread, tmp_path / "picture.png")
    fig = plan_figure(spread)
    ax = fig.axes[1]
    with Image.open(tmp_path / "picture.png") as picture:
        pixels = np.asarray(picture.convert("RGB"), dtype=int)
    for place, times in (((16, 26), 1), ((27.5, 22), 2), ((60, 20), 0)):
        x, y = ax.transData.transform(place)
        found = pixels[pixels.shape[0] - 1 - round(y), round(x)]
        assert found == pytest.approx([255 * part for part in covered_colour(times)], abs=2)


def test_what_is_asked_or_driven_for_ever_is_drawn_as_before(spread: Plan, yard: Plan):
    assert is_deployment(spread)
    assert not is_deployment(yard)
    assert not is_deployment(replace(spread, mission=replace(spread.mission, period_s=100.0)))
    assert not is_deployment(Plan(mission=spread.mission, trajectories=()))
    goes = Trajectory(robot="robot-1", times_s=[0, 5, 10], positions_m=[(20, 20), (25, 20), (20, 20)])
    assert not is_deployment(replace(spread, trajectories=(goes,)))


def test_the_film_tells_the_share_in_range_at_every_time(spread: Plan, tmp_path: Path):
    film = DeploymentFrames(spread, 1.0)
    told = []
    for _ in film.frames(np.array([0.0, 13.0, 20.0])):
        told.append(film._clock.get_text().split(" in range")[0])
    first = 2 * 10**2 * math.acos(2 / 20) - 1 * math.sqrt(4 * 10**2 - 2**2)
    assert told == [f"{(200 * math.pi - lens) / 3800:.1%}" for lens in (first, LENS_M2, LENS_M2)]
    animate_plan(spread, tmp_path / "film.gif", seconds=1)
    with Image.open(tmp_path / "film.gif") as gif:
        assert gif.n_frames == 8


def test_ground_is_shaded_by_its_importance_under_the_swarm(spread: Plan) -> None:
    zone = Zone(name="z", shape=box(0, 0, 50, 40), period_s=None, importance=4)
    shaded = replace(spread, mission=replace(spread.mission, importance=1.0, zones=(zone,)))
    figure = plan_figure(shaded)
    (image,) = figure.axes[0].images
    assert np.asarray(image.get_array())[0, [0, -1]] == pytest.approx([1, 0.25**0.6])
    assert "importance 4" in [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    # by hand: free ground 50 m x 40 m worth 4, and 50 m x 40 m less the obstacle worth 1; both discs lie in the former
    covered = (2 * math.pi * 10**2 - LENS_M2) * 4 / (50 * 40 * 4 + 50 * 40 - 200)
    assert f"{covered:.1%}"[:-3] in " ".join(ax.get_title(loc="left") for ax in figure.axes)
    assert not plan_figure(spread).axes[0].images


def test_a_swarm_that_charges_is_drawn_when_it_has_least_in_range(spread: Plan):
    """One robot stands for ever, one on its charger for the first half of each round."""
    one, other = spread.mission.fleet.robots or ()
    charging = replace(one, battery=BatteryLimits(endurance_s=100, recharge_s=50))
    fleet = replace(spread.mission.fleet, robots=(charging, other))
    mission = replace(spread.mission, fleet=fleet, chargers=(Charger(name="pad", at=(20, 20)),))
    times_s, charge = [0, 50, 100], Charge(charger="pad", from_s=0, until_s=50)
    ways = (
        Trajectory(robot=one.name, times_s=times_s, positions_m=[(20, 20)] * 3, charges=(charge,)),
        Trajectory(robot=other.name, times_s=times_s, positions_m=[(60, 20)] * 3),
    )
    plan = replace(spread, mission=mission, trajectories=ways)
    fig = plan_figure(plan)
    titles = [ax.get_title(loc="left") for ax in fig.axes]
    assert titles[0] == "Ways of a round, robots numbered where it begins"
    assert titles[1].startswith("In range at worst, after ")
    assert titles[1].endswith(f" s: {100 * math.pi / 3800:.1%} of the ground")
    assert titles[2] == "Flights and batteries, which repeat after 100 s"
    frames = DeploymentFrames(plan, 1.0)
    for time_s, robots in ((25.0, 1), (75.0, 2)):
        list(frames.frames(np.array([time_s])))
        assert frames._share == pytest.approx(robots * 100 * math.pi / 3800, rel=1e-3)
