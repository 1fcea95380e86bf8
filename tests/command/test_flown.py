"""`rota check --executed FORMAT --vehicle NAME`: rounds as flown, the verdict on them, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from tests.vehicles.small_plans import ROUND_S, square

from rota.check import check_plan
from rota.command.cli import run
from rota.files.executed.plan_as_flown import plan_as_flown
from rota.files.plan_file import write_plan
from rota.model.motion_limits import MotionLimits
from rota.model.plan import Plan, Trajectory
from rota.vehicles.motion import Wind
from rota.vehicles.presets import ARDUCOPTER


def written(plan: Plan, folder: Path) -> str:
    path = folder / "square.json"
    write_plan(plan, path)
    return str(path)


def test_what_lapses_is_told_with_rounds_and_what_would_help(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(square(ROUND_S + 2), tmp_path)
    assert run(["check", path]) == 0
    assert "rota: for robots that change speed at once; an ArduCopter by default parameters takes up to 1." in (
        capsys.readouterr().err
    )
    assert run(["check", path, "--executed", "waypoints", "--vehicle", "arducopter"]) == 1
    out, err = capsys.readouterr()
    flown_s = float(next(line for line in out.splitlines() if line.startswith("robot-1")).split()[2])
    assert flown_s > 1.2 * ROUND_S
    assert "verdict: violated" in out
    made, _ = plan_as_flown(square(ROUND_S + 2), "waypoints", ARDUCOPTER, Wind())
    lapses_s = check_plan(made).demands[0].worst_gap_at_least_s - ROUND_S - 2
    assert 1 < lapses_s < flown_s - ROUND_S
    assert f"demands lapse: area by {lapses_s:.0f} s" in err
    assert "an ArduCopter with WPNAV_ACCEL 500 and WPNAV_JERK 5 takes 1." in err


def test_who_exports_to_a_copter_is_told_what_it_takes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, told = (
        written(square(100), tmp_path),
        "rota: the plan is for robots that change speed at once; an ArduCopter by",
    )
    for name, said in (("waypoints", True), ("qgroundcontrol", True), ("qgroundcontrol-px4", False), ("nav2", False)):
        assert run(["export", path, "--to", name, "-o", str(tmp_path / name)]) == 0
        assert (told in capsys.readouterr().err) is said
    placeless = square(100)
    placeless = replace(placeless, mission=replace(placeless.mission, origin=None))
    path = written(placeless, tmp_path)
    assert run(["export", path, "--to", "waypoints", "-o", str(tmp_path / "w"), "--origin", "54,12"]) == 0
    assert told in capsys.readouterr().err


def test_the_verdict_is_the_check_s_on_what_is_flown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made, (robot,) = plan_as_flown(square(100), "waypoints", ARDUCOPTER, Wind())
    flown_s = robot.motion.round_s
    assert made.trajectories[0].loop_duration_s == pytest.approx(flown_s)
    assert robot.planned_s == ROUND_S
    report = check_plan(made)
    # each place is seen once a round, and for some seconds
    assert 0.8 * flown_s < report.demands[0].worst_gap_s < flown_s
    for period_s, code in ((flown_s, 0), (0.8 * flown_s, 1)):
        path = written(square(period_s, turn_rate_rad_s=1e3), tmp_path)
        arguments = ["check", path, "--executed", "qgroundcontrol", "--vehicle", "arducopter", "--json"]
        assert run(arguments) == code
        told = json.loads(capsys.readouterr().out)
        assert told["report"]["verdict"] == ("violated" if code else "met")
        assert {each["kind"] for each in told["report"]["violations"]} <= {"gap"}  # no speeds, no turns
        assert told["robots"][0]["flown_round_s"] == pytest.approx(flown_s, rel=1e-3)
        assert told["robots"][0]["factor"] == pytest.approx(flown_s / ROUND_S, rel=1e-3)
        assert len(told["robots"][0]["legs_s"]) == len(told["robots"][0]["corners_cut_m"]) == 4
        assert all(0 < cut_m < 2 for cut_m in told["robots"][0]["corners_cut_m"])


def test_wind_of_no_direction_blows_from_eight_and_the_worst_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = square(100)
    east = Trajectory(robot="robot-1", times_s=[0.0, 8.0, 16.0], positions_m=[[0, 0], [60, 0], [0, 0]])
    motion = MotionLimits(wind_m_s=6, top_airspeed_m_s=20)
    fleet = replace(plan.mission.fleet, motion=motion)
    plan = replace(plan, mission=replace(plan.mission, fleet=fleet), trajectories=(east,))
    path, flown = written(plan, tmp_path), ["--executed", "waypoints", "--vehicle", "arducopter"]
    assert run(["check", path, *flown, "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert [each["wind_from_deg"] for each in told["directions"]] == [0, 45, 90, 135, 180, 225, 270, 315]
    by_wind = {each["wind_from_deg"]: each["slowest_factor"] for each in told["directions"]}
    for from_deg in (0, 90):
        _, (robot,) = plan_as_flown(plan, "waypoints", ARDUCOPTER, Wind(speed_m_s=6, from_deg=from_deg))
        assert by_wind[from_deg] == pytest.approx(robot.factor)
    assert told["wind_m_s"] == 6
    assert by_wind[told["wind_from_deg"]] == told["robots"][0]["factor"] == max(by_wind.values())
    # the report is of the worst direction; another speed of one's own takes the mission's place, and so does none
    assert run(["check", path, *flown]) == 1
    out = capsys.readouterr().out
    assert f"in wind of 6 m/s from {told['wind_from_deg']:g} degrees, the worst of 8 directions" in out
    assert "\n45 degrees   violated" in out
    for wind, said in (("3", "in wind of 3 m/s from"), ("0", "without wind:"), ("3,90", "in wind of 3 m/s from 90 ")):
        assert run(["check", path, *flown, "--wind", wind]) == 1
        out = capsys.readouterr().out
        assert said in out
        assert ("8 directions" in out) is (wind == "3")


def test_robots_that_stay_have_no_rounds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = square(100)
    stays = Trajectory(robot="robot-1", times_s=[0.0, 5.0], positions_m=[[0, 0], [30, 0]], loop_start_s=5.0)
    path = written(replace(plan, trajectories=(stays,)), tmp_path)
    assert run(["check", path]) == 1
    assert capsys.readouterr().err == ""
    assert run(["check", path, "--executed", "waypoints", "--vehicle", "arducopter"]) == 1
    assert "robot-1      stays" in capsys.readouterr().out


def test_what_cannot_be_flown_is_refused_in_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(square(100), tmp_path)
    flown = ["--executed", "waypoints", "--vehicle", "arducopter"]
    for arguments, said in (
        (["--vehicle", "arducopter"], "--vehicle: is for --executed only"),
        (["--wind", "1,2"], "--wind: is for --executed only"),
        (["--executed", "waypoints", "--wind", "1,2"], "--wind: is for --vehicle only"),
        (["--executed", "kml", "--vehicle", "arducopter"], "'kml' is not allowed with --vehicle arducopter"),
        (["--executed", "paper", "--vehicle", "arducopter"], "'paper' is not one of 'geojson'"),
        (["--executed", "vda5050", "--vehicle", "agv"], "--vehicle: 'agv' is not allowed: what its firmware makes"),
        (["--executed", "waypoints", "--vehicle", "copter"], "--vehicle: 'copter' is not one of 'arducopter'"),
        ([*flown, "--wind", "5,"], "--wind: '5,' is not allowed; M_S,FROM_DEG is needed, such as 5,240"),
        ([*flown, "--wind", "-5,0"], "--wind: '-5,0' is not allowed"),
        ([*flown, "--wind", "-5"], "--wind: '-5' is not allowed"),
        ([*flown, "--wind", "nan"], "--wind: 'nan' is not allowed"),
        ([*flown, "--wind", "5,240,1"], "--wind: '5,240,1' is not allowed"),
        ([*flown, "--wind", "25"], "wind of 25 m/s from 0 degrees: an ArduCopter by default parameters"),
        ([*flown, "--wind", "25,0"], "wind of 25 m/s from 0 degrees: an ArduCopter by default parameters"),
    ):
        assert run(["check", path, *arguments]) == 2
        assert said in capsys.readouterr().err
