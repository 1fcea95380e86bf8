"""`rota fly` with simulated vehicles: what it prints, asks and refuses."""

from __future__ import annotations

import io
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
from tests.links.fleets import three
from tests.relieved import relieved

from rota.command.cli import run
from rota.command.fly_along import Along
from rota.command.fly_reliefs import require_reliefs
from rota.errors import RotaError
from rota.files.plan_file import write_plan
from rota.links.link import Link


@pytest.fixture
def plan(tmp_path: Path) -> str:
    path = tmp_path / "quay.rota.json"
    write_plan(three(), path)
    return str(path)


class Terminal(io.StringIO):
    """Somebody at a terminal, who has typed something."""

    def isatty(self) -> bool:
        return True


def test_routes_are_sent_and_nothing_is_started(plan: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["fly", plan, "--set", "clock=0", "--set", "position_noise_m=0"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["robot", "stops", "loop", "m", "loop", "s", "fence", "battery", "from", "start", "m"]
    assert lines[1].split() == ["a", "5", "160.0", "43.0", "4", "corners,", "1", "out", "100%", "0.0"]
    assert lines[3].split()[:4] == ["c", "1", "stays", "-"]
    assert lines[4:] == [
        "3 routes sent; read back, each is the one sent.",
        "Nothing was started: --start does.",
    ]


def test_robots_start_when_somebody_says_yes(
    plan: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", Terminal("yes\n"))
    assert run(["fly", plan, "--set", "clock=0", "--start", "--seconds", "0.2"]) == 0
    assert capsys.readouterr().out.endswith("Started: 3 robots.\n")


@pytest.mark.parametrize("answer", ["no\n", "\n", "y\n", ""])
def test_they_do_not_start_otherwise(
    answer: str, plan: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", Terminal(answer))
    assert run(["fly", plan, "--set", "clock=0", "--start"]) == 0
    out = capsys.readouterr().out
    assert out.endswith("Nothing was started; the robots hold their routes.\n")
    assert "Started" not in out


def test_scripts_say_yes_beforehand_and_failures_are_told(plan: str, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--set", "clock=0", "--set", "faults=b:dies@5", "--start", "--yes", "--seconds", "0.3"]
    assert run(["fly", plan, *options]) == 0
    assert "Ctrl-C ends it" in capsys.readouterr().err


def test_what_is_driven_is_kept_in_phase_and_logged(
    plan: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = str(tmp_path / "flown.rota-log")
    options = ["--set", "clock=50", "--set", "slower=0.05", "--start", "--yes", "--seconds", "1.5", "--log", log]
    assert run(["fly", plan, *options]) == 0
    said = "robots are kept in phase; driven at less than 0.470 of the plan's pace, gate lapses"
    assert said in capsys.readouterr().out.splitlines()  # 28.2 s of 60 s
    run(["watch", plan, "--judge", log])
    assert "reports, judged from" in capsys.readouterr().out


def test_missions_with_less_slack_than_they_are_kept_in_phase_with_are_told() -> None:
    made = three()
    gate = replace(made.mission.zones[0], period_s=28.5)
    plan = replace(made, mission=replace(made.mission, zones=(gate,)))
    pace = SimpleNamespace(keeps_phase=True, flies=True, drives_along=False, robots="abc", most_pace=lambda _: math.inf)
    told = Along(plan, cast("Link", pace), None).tell_before()
    assert told[1] == (
        "copters on missions of their own go at about 0.98 of it: plan with a period_margin greater by 0.009, or for"
        " vehicle: arducopter-targets"
    )
    assert len(Along(made, cast("Link", pace), None).tell_before()) == 1  # 60 s are enough


def test_a_fault_of_one_robot_is_an_error_of_the_command(plan: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["fly", plan, "--set", "clock=0", "--set", "faults=b:refuses", "--start", "--yes"]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.splitlines() == [
        "rota: error: robot b: it refuses its route",
        "rota: error: no robot holds a route: all were cleared",
    ]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--start"], "--start: somebody has to say yes on a terminal; scripts give --yes"),
        (["--yes"], "--yes: is for --start only"),
        (["--seconds", "3"], "--seconds: is for --start only"),
        (["--hands-off"], "--hands-off: is for --start only"),
        (["--log", "x.rota-log"], "--log: is for --start only"),
        (["--start", "--yes", "--hands-off"], "--hands-off: robots on the link simulated drive only while"),
        (["--start", "--yes", "--hands-off", "--log", "x"], "--hands-off: --log is for robots that are driven along"),
        (["--start", "--yes", "--seconds", "nan"], "--seconds: nan is not allowed; a number greater than 0 is needed"),
        (["--pause", "--home"], "--start, --pause, --home: only one of them is allowed"),
        (["--link", "radio"], "--link: 'radio' is not one of 'simulated'"),
        (["--set", "seed"], "--set: 'seed' is not allowed; KEY=VALUE is needed"),
        (["--origin", "1,2"], "--origin: '1,2' is not allowed: the mission has its own, 48.1,11.5"),
    ],
)
def test_bad_options_are_refused(
    options: list[str], message: str, plan: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO())
    assert run(["fly", plan, *options]) == 2
    assert message in capsys.readouterr().err


def test_robots_pause_and_come_home(plan: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["fly", plan, "--pause"]) == 0
    assert run(["fly", plan, "--home"]) == 0
    assert capsys.readouterr().out.splitlines() == ["3 robots have stopped.", "3 robots are called home."]


def test_settings_are_listed(plan: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["fly", plan, "--settings"]) == 0
    assert "  rate_hz=5.0               reports of each vehicle in a second" in capsys.readouterr().out


def test_robots_that_charge_relieve_each_other(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "pier.rota.json"
    write_plan(relieved(3), path)
    options = ["--set", "clock=100", "--set", "speed_noise=0", "--start", "--yes", "--seconds", "4"]
    assert run(["fly", str(path), *options]) == 0
    said = capsys.readouterr().err
    for told in ("robot-3 is at pad, its battery at 9", "robot-2 leaves pad, its battery at ", "robot-1 is at pad"):
        assert told in said


def test_robots_that_charge_are_not_sent_where_nobody_can_relieve_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "pier.rota.json"
    write_plan(relieved(2), path)
    told = "on the link ros2 they cannot be sent back and relieved: rota export writes their single flights"
    with pytest.raises(RotaError, match=told):
        require_reliefs(relieved(2), SimpleNamespace(relieves=False), "ros2", hands_off=False)  # type: ignore[arg-type]
    for way in ("mission", "targets"):
        asked = ["--link", "mavlink", "--set", f"way={way}", "--start", "--yes", "--hands-off"]
        assert run(["fly", str(path), *asked]) == 2
        assert "somebody has to tell them when to leave their chargers" in capsys.readouterr().err
