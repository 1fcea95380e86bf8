"""`rota watch` with simulated vehicles: what it prints, its log, its replay, and what the check says of it."""

from __future__ import annotations

import io
import json
import threading
from pathlib import Path

import pytest
from rich.console import Console
from tests.live.two_robots import driven, two_robots

from rota import Plan
from rota.command.cli import run
from rota.command.watch_replans import Replans
from rota.command.watch_table import WatchTable
from rota.files.plan_file import read_plan, write_plan
from rota.live.notices import Notice
from rota.live.settings import WatchSettings
from rota.live.watch import Watch

FAST = ["--set", "clock=0", "--set", "position_noise_m=0", "--set", "speed_noise=0"]


@pytest.fixture
def plan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A plan file in the folder where the program runs."""
    monkeypatch.chdir(tmp_path)
    write_plan(two_robots(), "lane.rota.json")
    return "lane.rota.json"


def test_a_fleet_that_keeps_to_its_plan_is_watched_logged_and_replayed(
    plan: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["watch", plan, *FAST, "--seconds", "50", "--every", "20"]) == 0
    live = capsys.readouterr()
    assert "all that arrives is written to lane.rota-log" in live.err
    lines = live.out.splitlines()
    assert len(lines) == 4
    assert "2 robots, all on their routes; ages: left" in lines[1]
    assert lines[-1].startswith("until 50.0 s no period has lapsed; longest gaps: left ")
    assert run(["watch", plan, "--replay", "lane.rota-log", "--every", "20"]) == 0
    assert capsys.readouterr().out == live.out
    # a second watch writes a log of its own
    assert run(["watch", plan, *FAST, "--seconds", "1"]) == 0
    assert Path("lane-2.rota-log").exists()


def test_alarms_in_json_come_again_byte_by_byte_from_the_log(plan: str, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["--set", "faults=b:dies@8", "--silent", "3", "--log", "dies.rota-log", "--seconds", "45", "--json"]
    assert run(["watch", plan, *FAST, *asked]) == 1
    live = capsys.readouterr().out
    told = [json.loads(line) for line in live.splitlines()]
    kinds = [line["notice"] for line in told if "notice" in line]
    assert kinds[:3] == ["lost", "will lapse", "lapsed"]
    assert [robot["standing"] for robot in told[-1]["robots"]] == ["ok", "lost"]
    assert run(["watch", plan, "--replay", "dies.rota-log", "--json"]) == 1
    assert capsys.readouterr().out == live


def test_a_log_is_judged_by_the_check(plan: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["watch", plan, *FAST, "--log", "kept.rota-log", "--seconds", "70"]) == 0
    assert run(["watch", plan, *FAST, "--set", "faults=b:dies@8", "--log", "lost.rota-log", "--seconds", "70"]) == 1
    capsys.readouterr()
    assert run(["watch", plan, "--judge", "kept.rota-log", "--tolerance", "0.1"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("recorded: 69")  # of 702 reports: the last ones were on their way
    assert "judged from 0.0 s to 70.0 s, with 0.1 m more reach\nverdict: met\n" in out
    assert run(["watch", plan, "--judge", "lost.rota-log", "--json"]) == 1
    report = json.loads(capsys.readouterr().out)
    assert report["verdict"] == "violated"
    assert {violation["who"] for violation in report["violations"]} >= {"left"}


def test_a_damaged_log_is_used_up_to_the_damage(plan: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["watch", plan, *FAST, "--log", "whole.rota-log", "--seconds", "30"]) == 0
    whole = Path("whole.rota-log").read_bytes()
    Path("cut.rota-log").write_bytes(whole[: len(whole) // 2])
    capsys.readouterr()
    for option in ("--replay", "--judge"):
        run(["watch", plan, option, "cut.rota-log"])
        told = capsys.readouterr()
        assert "warning: cut.rota-log:" in told.err
        assert "the line is cut off; what comes before it is used" in told.err
        assert told.out
    write_plan(two_robots(zones=False), "other.rota.json")
    assert run(["watch", "other.rota.json", "--replay", "whole.rota-log"]) == 2
    assert "the log of another plan" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--silent", "0"], "--silent: 0 is not allowed"),
        (["--battery", "2"], "--battery: 2 is not allowed"),
        (["--off-route", "nan"], "--off-route: nan is not allowed"),
        (["--seconds", "-1"], "--seconds: -1 is not allowed; a number greater than 0 is needed"),
        (["--every", "nan"], "--every: nan is not allowed"),
        (["--tolerance", "nan"], '--tolerance: "nan" is not allowed; it must be at least 0'),
        (["--tolerance", "inf"], "--tolerance: inf is not allowed"),
        (["--replay", "a", "--judge", "b"], "--replay, --judge: only one of them is allowed"),
        (["--replay", "a", "--seconds", "3"], "--replay: the log says what was watched"),
        (["--judge", "none.rota-log"], "none.rota-log: cannot be read"),
        (["--link", "pigeon"], "--link: 'pigeon' is not one of"),
        (["--set", "clock=fast"], "clock"),
        (["--log", ""], "an empty path cannot be written to"),
        (["--log", "lane.rota.json", "--seconds", "1"], "lane.rota.json: exists already; a log is never written over"),
    ],
)
def test_what_is_asked_wrongly_is_refused(
    arguments: list[str], words: str, plan: str, capsys: pytest.CaptureFixture[str]
) -> None:
    before = Path(plan).read_bytes()
    assert run(["watch", plan, *arguments]) == 2
    assert words in capsys.readouterr().err
    assert Path(plan).read_bytes() == before


def test_a_terminal_has_a_table_of_demands_and_robots() -> None:
    watch = Watch(two_robots(), WatchSettings(silent_s=3.0))
    screen = io.StringIO()
    with WatchTable(watch, Console(file=screen, width=120, force_terminal=False)) as table:
        for event in driven(watch.plan, 15.0, ends_s={"b": 8.0}):
            table.show(watch.take(event))
    shown = screen.getvalue()
    assert "ALARM  b is lost" in shown
    last = shown[shown.rindex("t = 15.0 s") :].splitlines()
    assert last[2].split()[:3] == ["left", "will", "lapse"]
    assert next(line for line in last if line.strip().startswith("b")).split()[:2] == ["b", "lost"]


def test_a_plan_for_those_that_remain_is_offered_when_a_robot_is_lost(
    plan: str, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["--set", "faults=b:dies@8", "--silent", "3", "--log", "dies.rota-log", "--seconds", "45"]
    assert run(["watch", plan, *FAST, *asked, "--replan"]) == 1
    assert "without b from t = 2" in capsys.readouterr().err
    (offered,) = Path().glob("dies-at-*.rota.json")
    after = read_plan(offered)
    assert [line.robot for line in after] == ["a"]
    assert after.seam is not None
    assert after.seam.lost == ("b",)
    assert run(["watch", plan, "--replay", "dies.rota-log", "--replan"]) == 2


def test_what_is_offered_is_not_offered_again_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search that ends at once would take the place of the plan that a longer one has found."""
    asked: list[tuple[str, ...]] = []
    searched = threading.Event()

    def search(plan: Plan, *, lost: tuple[str, ...], **_: object) -> None:
        asked.append(lost)
        searched.set()

    monkeypatch.setattr("rota.replanning.replan.replan", search)
    replans = Replans(two_robots(), "log")
    for lost in ("b", "a"):
        searched.clear()
        replans.note([Notice(time_s=8.0, kind="lost", about=lost, text="it is lost")])
        assert searched.wait(10)
    replans.end()
    assert asked == [("b",), ("b", "a")]
