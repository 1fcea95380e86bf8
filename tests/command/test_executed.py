"""`rota check --executed`: the verdict, what is said of the difference, and robots brought into phase anew."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapely import box
from tests.files.two_robots import ORIGIN

from rota.check import check_plan
from rota.command.cli import run
from rota.command.executed import executed_plan, in_phase_every
from rota.files.plan_file import write_plan
from rota.model.mission import DiscSensor, Fleet, Mission, Robot
from rota.model.plan import Plan, Trajectory

SENSOR = DiscSensor(radius_m=6)


def lap(robot: str, phase_s: float) -> Trajectory:
    """To and fro along 90 m of a corridor, 18 s there and 18 s back; begins so many seconds after the west end."""
    times_s = np.array([0.0, 18.0, 36.0])
    x_m = np.interp(np.array([0.0, 18.0 - phase_s, 36.0 - phase_s, 36.0]) + phase_s, [0, 18, 36, 54], [0, 90, 0, 90])
    if phase_s == 0:
        return Trajectory(robot=robot, times_s=times_s, positions_m=[[0, 0], [90, 0], [0, 0]])
    times = [0.0, 18.0 - phase_s, 36.0 - phase_s, 36.0]
    return Trajectory(robot=robot, times_s=times, positions_m=[[x, 0] for x in x_m])


def corridor() -> Plan:
    """Two robots half a round apart: each alone comes too seldom."""
    robots = tuple(Robot(name=name, speed_m_s=8, sensor=SENSOR) for name in "ab")
    mission = Mission(
        name="corridor",
        area=box(-1, -2, 91, 2),
        period_s=22,
        origin=ORIGIN,
        fleet=Fleet(speed_m_s=8, sensor=SENSOR, robots=robots),
    )
    # each robot comes to an end every 36 s, and one of both after at most 24 s
    return Plan(mission=mission, trajectories=(lap("a", 0.0), lap("b", 12.0)))


def slower(plan: Plan, share: float) -> Plan:
    """The second robot's rounds take longer by this share."""
    first, second = plan.trajectories
    return replace(plan, trajectories=(first, replace(second, times_s=second.times_s * (1 + share))))


def test_robots_out_of_phase_are_judged_so_and_brought_back_they_are_not() -> None:
    plan = corridor()
    wide = replace(plan, mission=replace(plan.mission, period_s=23))
    assert check_plan(wide).verdict == "met"
    drifting = slower(wide, 1e-3)
    assert check_plan(drifting).verdict == "violated"
    # 0.036 s a round: 3.6 s after an hour, and 0.36 s after six minutes
    often = in_phase_every(wide, drifting, 360)
    assert check_plan(often).verdict == "met"
    assert check_plan(in_phase_every(wide, drifting, 3600)).verdict == "violated"
    first, second = often.trajectories
    assert first.loop_duration_s == pytest.approx(second.loop_duration_s, rel=1e-12)
    assert second.loop_duration_s == pytest.approx(360 * 1.001, rel=1e-9)
    # the robot that is ahead waits where its loop begins
    assert first.times_s[-1] - first.times_s[-2] == pytest.approx(0.36, rel=1e-6)
    assert first.positions_m[-2].tolist() == first.positions_m[-1].tolist() == [0, 0]


def test_loops_that_share_no_period_are_left_alone_and_so_are_robots_that_stay() -> None:
    plan = corridor()
    staying = Trajectory(robot="b", times_s=[0.0], positions_m=[[45, 0]])
    alone = replace(plan, trajectories=(plan.trajectories[0], staying))
    made = in_phase_every(alone, alone, 1.0)
    assert made.trajectories[1] == staying
    assert made.trajectories[0].loop_duration_s == 36


def test_what_differs_is_told() -> None:
    plan = corridor()
    made = executed_plan(plan, "csv")
    assert (made.plan, made.drifts) == (plan, False)
    assert (
        made.told == "as csv drives it, places are up to 0 m off the plan's routes, and rounds take as long as planned"
    )
    made = executed_plan(plan, "waypoints")
    assert made.drifts
    assert "rounds differ from the plan's by" in made.told


def test_what_is_only_the_format_s_rounding_is_told_so_and_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = corridor()
    # a round along the border from x = 0 to 90.000003 m, which 1e-7 degrees cannot hold
    along = Trajectory(robot="a", times_s=[0, 18, 36], positions_m=[[0.004, 0.003], [90.006, 0.003], [0.004, 0.003]])
    touching = box(0.004, 0.003, 90.006, 2)
    fleet = replace(plan.mission.fleet, robots=plan.mission.fleet.robots[:1])
    mission = replace(plan.mission, area=touching, fleet=fleet, period_s=40)
    path = tmp_path / "border.json"
    write_plan(replace(plan, mission=mission, trajectories=(along,)), path)
    assert run(["check", str(path)]) == 0
    assert run(["check", str(path), "--executed", "kml", "--in-phase-every", "360"]) == 0
    capsys.readouterr()
    assert run(["check", str(path), "--executed", "waypoints", "--in-phase-every", "360"]) == 1
    out, err = capsys.readouterr()
    told = [line for line in out.splitlines() if line.startswith("violation: a: outside area")]
    assert len(told) == 1
    assert told[0].endswith(" more of this kind, none worse)")
    assert (
        "the plan itself is met; all violations come of what the format holds: places are rounded by up to 0.0" in err
    )
    # a plan with a fault of its own is not said to be met
    write_plan(replace(plan, mission=replace(mission, period_s=20), trajectories=(along,)), path)
    assert run(["check", str(path), "--executed", "waypoints"]) == 1
    assert "the plan itself is violated, too" in capsys.readouterr().err


def test_the_command_judges_what_files_say(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "corridor.json"
    plan = replace(corridor(), mission=replace(corridor().mission, period_s=30, origin=None))
    write_plan(plan, path)
    assert run(["check", str(path), "--executed", "nav2"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("verdict: met")
    assert "as nav2 drives it" in err
    assert run(["check", str(path), "--executed", "waypoints"]) == 2
    assert "give --origin LAT,LON" in capsys.readouterr().err
    code = run(["check", str(path), "--executed", "waypoints", "--origin", "54,12", "--in-phase-every", "300"])
    assert code == 0
    assert capsys.readouterr().out.startswith("verdict: met")
    for arguments, said in (
        (["--executed", "create2-sketch"], "'create2-sketch' is not allowed: such files are judged"),
        (["--executed", "create2-reactive"], "'create2-reactive' is not allowed: such programs drive no plan"),
        (["--executed", "paper"], "'paper' is not one of 'geojson'"),
        (["--executed", "csv", "--in-phase-every", "0"], "--in-phase-every: 0 is not allowed"),
        (["--in-phase-every", "9"], "--in-phase-every: is for --executed only"),
        (["--origin", "1,2"], "--origin: is for --executed only"),
    ):
        assert run(["check", str(path), *arguments]) == 2
        assert said in capsys.readouterr().err
