"""The command line from the outside: exit codes, where output goes, what stays untouched."""

from __future__ import annotations

import importlib
import io
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from benchmarks.create2.plans import TypedMap, bounced_plan
from PIL import Image
from shapely import Point, box, union_all
from tests.stand_in import standing_in
from tests.warm_process import run_copy

from rota.check import check_plan
from rota.command.cli import run
from rota.command.interrupt import stop_on_interrupt
from rota.errors import NoPlanFound
from rota.files.mission_file import read_mission
from rota.files.plan_file import read_plan, write_plan
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.swarm.planner_settings import SwarmSettings

MAKE_PLAN = importlib.import_module("rota.planning.make_plan")
YARD = """\
rota: 1
name: yard
area: [[0, 0], [10, 0], [10, 10], [0, 10]]
origin: {lat: 48.1, lon: 11.5}
period_s: 40
fleet: {speed_m_s: 1, sensor: {shape: disc, radius_m: 20}}
"""


def answer(mission: Mission, leg_s: float = 4) -> Plan:
    """A robot that sees all of the yard from anywhere; legs of 4 m, so below 4 s it is too fast."""
    times_s, positions_m = [0, leg_s, 2 * leg_s], [[3, 5], [7, 5], [3, 5]]
    there_and_back = Trajectory(robot="robot-1", times_s=times_s, positions_m=positions_m)
    return Plan(mission=mission, trajectories=(there_and_back,), lower_bound_robots=1)


@pytest.fixture
def yard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, with a mission file in it."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "yard.yaml"
    path.write_text(YARD)
    return path


@pytest.fixture
def plan_path(yard: Path) -> Path:
    path = yard.with_name("yard.rota.json")
    write_plan(answer(read_mission(yard).mission), path)
    return path


Use = Callable[[Callable[..., Plan]], None]


@pytest.fixture
def use(monkeypatch: pytest.MonkeyPatch) -> Use:
    """Puts a stand-in in the planner's place."""
    return lambda planner: monkeypatch.setattr(MAKE_PLAN, "planner_of", standing_in(planner))


def good(mission: Mission, **_: Any) -> Plan:
    return answer(mission)


def too_fast(mission: Mission, **_: Any) -> Plan:
    return answer(mission, leg_s=1)


# ---------------------------------------------------------------- plan


def test_a_plan_is_written_checked_and_told(yard: Path, use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    use(good)
    assert run(["plan", "yard.yaml"]) == 0
    out, err = capsys.readouterr()
    assert read_plan("yard.rota.json") == answer(read_mission(yard).mission)
    rows = [line.split() for line in out.splitlines()]
    assert rows[0] == ["robot", "loop", "m", "loop", "s", "slack", "serves"]
    assert rows[1] == ["robot-1", "8.0", "8.0", "80%", "area"]
    assert out.splitlines()[2:] == [
        "1 robot: no plan needs fewer, proved.",
        "Check: met, every demand, for ever.",
        # from (7, 5) to what is looked at in the corner, 5.82 m, is enough
        "Least range to spare: 14.181 of 20 m (70.9 %), in area at (9.99, 9.99), seen by robot-1; of 2030 places.",
        "Least time to spare: 40 of 40 s (100 %), in area, seen by robot-1.",
        "One robot more on a loop there would leave no more to spare. One robot less cannot do it, proved.",
        "The plan is for robots that change speed at once.",
        "Plan: yard.rota.json",
    ]
    assert [line for line in err.splitlines() if "compiling" not in line] == []


def test_the_reason_of_the_bound_is_told_under_the_table(
    yard: Path, use: Use, capsys: pytest.CaptureFixture[str]
) -> None:
    reason = "64 m2/s are asked for, a robot sweeps 100 at most"
    use(lambda mission, **_: replace(answer(mission), lower_bound_reason=reason))
    assert run(["plan", "yard.yaml"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2:4] == ["1 robot: no plan needs fewer, proved.", f"1 robot at least: {reason}."]
    assert read_plan("yard.rota.json").lower_bound_reason == reason


def test_seed_effort_and_time_limit_reach_the_planner(yard: Path, use: Use) -> None:
    asked: list[tuple[int, str]] = []

    def planner(mission: Mission, *, seed: int, should_stop: Callable[[], bool], **_: Any) -> Plan:
        asked.append((seed, PatrolSettings.of(mission).effort))
        while len(asked) == 2 and not should_stop():
            pass
        return answer(mission)

    use(planner)
    assert run(["plan", "yard.yaml"]) == 0
    assert run(["plan", "yard.yaml", "--seed", "5", "--effort", "quick", "--time-limit", "0.05"]) == 0
    assert asked == [(0, "normal"), (5, "quick")]


def test_a_time_limit_that_struck_is_told(yard: Path, use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    def planner(mission: Mission, *, should_stop: Callable[[], bool], **_: Any) -> Plan:
        while not should_stop():
            pass
        return answer(mission)

    use(planner)
    assert run(["plan", "yard.yaml", "--time-limit", "0.01"]) == 0
    assert "stopped early by the time limit" in capsys.readouterr().err


def test_a_dash_is_stdout_and_nothing_but_the_plan_is_there(
    yard: Path, use: Use, capsys: pytest.CaptureFixture[str]
) -> None:
    def planner(mission: Mission, *, progress: Callable[[float, str], None], **_: Any) -> Plan:
        progress(0.5, "touring")
        return answer(mission)

    use(planner)
    assert run(["plan", "yard.yaml", "-o", "-"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["rota_plan"] == 1
    assert "no plan needs fewer" in err
    assert "touring" not in err
    assert os.listdir() == ["yard.yaml"]


def test_no_plan_is_exit_code_3_with_the_reason_and_no_file(
    yard: Path, use: Use, capsys: pytest.CaptureFixture[str]
) -> None:
    use(too_fast)
    Path("yard.rota.json").write_text("old")
    assert run(["plan", "yard.yaml"]) == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert "no plan: the best plan found is not shown to meet the demand: the check says 'violated'" in err
    assert "--best writes" in err
    assert Path("yard.rota.json").read_text() == "old"


def test_best_writes_what_there_is_and_marks_it(yard: Path, use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    def planner(mission: Mission, **_: Any) -> Plan:
        raise NoPlanFound("the gate is 3.2 times too far; at least 2 robots are needed", best=answer(mission, 1))

    use(planner)
    assert run(["plan", "yard.yaml", "--best"]) == 3
    out, err = capsys.readouterr()
    assert "Check: violated. The plan does not meet its demand." in out
    assert "violation: robot-1" in out
    assert "no plan: the gate is 3.2 times too far" in err
    assert "it does NOT meet its demand" in err
    assert json.loads(Path("yard.rota.json").read_text())["meets_demand"] is False
    assert run(["check", "yard.rota.json"]) == 1


def test_best_without_any_plan_writes_nothing(yard: Path, use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    def planner(_mission: Mission, **_: Any) -> Plan:
        raise NoPlanFound("the parts of the area are not joined")

    use(planner)
    assert run(["plan", "yard.yaml", "--best"]) == 3
    assert "not joined" in capsys.readouterr().err
    assert os.listdir() == ["yard.yaml"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["missing.yaml"], "missing.yaml"),
        (["yard.yaml", "-o", "."], ".: is a folder"),
        (["yard.yaml", "-o", "none/plan.json"], "there is no folder"),
        (["yard.yaml", "-o", "yard.yaml/plan.json"], "is no folder"),
        (["yard.yaml", "-o", "yard.yaml"], "yard.yaml: is the input itself"),
        (["yard.yaml", "--effort", "huge"], "--effort"),
        (["yard.yaml", "--seed", "-1"], "--seed"),
        (["yard.yaml", "--time-limit", "0"], "time_limit_s: 0.0 is not allowed"),
        ([], "MISSION"),
    ],
)
def test_bad_arguments_are_exit_code_2_before_any_planning(
    arguments: list[str], message: str, yard: Path, use: Use, capsys: pytest.CaptureFixture[str]
) -> None:
    def never(*_: Any, **__: Any) -> Plan:
        raise AssertionError("planned although the arguments are wrong")

    use(never)
    assert run(["plan", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert os.listdir() == ["yard.yaml"]
    assert yard.read_text() == YARD


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("area: [[0, 0], [10, 0], [10, 10], [0, 10]]", "area: {", "not YAML"),
        ("period_s: 40", "perod_s: 40", "did you mean 'period_s'?"),
        ("speed_m_s: 1", "speed_m_s: fast", '"fast" is not allowed; a number is needed'),
        ("[10, 0], [10, 10]", "[10, 10], [10, 0]", "crosses or touches itself at (5, 5)"),
        ("[10, 0], [10, 10], [0, 10]", "[10, 0]", "a ring of 2 distinct points"),
        ("period_s: 40", "period_s: .nan", "a finite number is needed"),
        ("radius_m: 20", "radius_m: 0.001", "at most 50 million are possible; give radius_m of at least"),
        ("lat: 48.1, lon: 11.5", "lat: 148.1, lon: 11.5", "origin.lat: 148.1 is not allowed"),
        ("origin:", "zones: [{name: z, period_s: 9, ring: [[20, 0], [30, 0], [30, 9]]}]\norigin:", "10 m away"),
        ("origin:", "obstacles: [[[-1, -1], [11, -1], [11, 11], [-1, 11]]]\norigin:", "cover the whole area"),
        ("[[0, 0], [10, 0], [10, 10], [0, 10]]", "{map: none.yaml, inside: [1, 1]}", "none.yaml: no such file"),
    ],
)
def test_a_bad_mission_is_exit_code_2_and_leaves_the_old_plan(
    old: str, new: str, message: str, yard: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("yard.rota.json").write_text("old")
    yard.write_text(YARD.replace(old, new))
    assert run(["plan", "yard.yaml", "--best"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "rota: error: yard.yaml:" in err
    assert message in err
    assert Path("yard.rota.json").read_text() == "old"
    assert sorted(os.listdir()) == ["yard.rota.json", "yard.yaml"]


def test_every_fault_of_a_mission_is_a_line_on_stderr(yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    yard.write_text(YARD.replace("period_s: 40", "period_s: 0").replace("speed_m_s: 1", "speed_m_s: 0"))
    assert run(["plan", "yard.yaml"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert [line for line in err.splitlines() if line.startswith("rota: error: yard.yaml:5:")]
    assert [line for line in err.splitlines() if line.startswith("rota: error: yard.yaml:6:")]
    assert os.listdir() == ["yard.yaml"]


def test_warnings_of_the_reader_go_to_stderr(yard: Path, use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    use(good)
    zone = "zones: [{name: gate, period_s: 20, ring: [[5, 5], [15, 5], [15, 9], [5, 9]]}]\n"
    yard.write_text(YARD + zone)
    assert run(["plan", "yard.yaml", "-o", "-"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)
    assert "rota: warning: " in err
    assert "gate" in err


def test_a_fault_of_ours_is_exit_code_70(yard: Path, use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    def broken(*_: Any, **__: Any) -> Plan:
        raise ZeroDivisionError("oops")

    use(broken)
    assert run(["plan", "yard.yaml"]) == 70
    err = capsys.readouterr().err
    assert "ZeroDivisionError: oops" in err
    assert err.splitlines()[-1].startswith("rota: a fault in Rota, not in your input")
    assert os.listdir() == ["yard.yaml"]


# ---------------------------------------------------------------- Ctrl-C


def interrupted(mission: Mission, *, should_stop: Callable[[], bool], **_: Any) -> Plan:
    assert not should_stop()
    os.kill(os.getpid(), signal.SIGINT)
    while not should_stop():
        pass
    return answer(mission)


def test_ctrl_c_leaves_the_best_plan_so_far_checked(yard: Path, use: Use, capsys: pytest.CaptureFixture[str]) -> None:
    before = signal.getsignal(signal.SIGINT)
    use(interrupted)
    assert run(["plan", "yard.yaml"]) == 130
    out, err = capsys.readouterr()
    assert "Check: met" in out
    assert "Ctrl-C again ends at once" in err
    assert "interrupted: this is the best plan so far" in err
    assert read_plan("yard.rota.json") == answer(read_mission(yard).mission)
    assert signal.getsignal(signal.SIGINT) is before


def test_ctrl_c_without_a_passing_plan_writes_only_with_best(
    yard: Path, use: Use, capsys: pytest.CaptureFixture[str]
) -> None:
    def planner(mission: Mission, *, should_stop: Callable[[], bool], **_: Any) -> Plan:
        interrupted(mission, should_stop=should_stop)
        return answer(mission, leg_s=1)

    use(planner)
    assert run(["plan", "yard.yaml"]) == 130
    err = capsys.readouterr().err
    assert "interrupted before a plan passed the check; no plan is written" in err
    assert "the best plan so far is in yard.partial.rota.json, marked as not meeting its demand" in err
    assert sorted(os.listdir()) == ["yard.partial.rota.json", "yard.yaml"]
    assert json.loads(Path("yard.partial.rota.json").read_text())["meets_demand"] is False
    assert run(["plan", "yard.yaml", "--best"]) == 130
    assert json.loads(Path("yard.rota.json").read_text())["meets_demand"] is False
    assert sorted(os.listdir()) == ["yard.rota.json", "yard.yaml"]


STOPPED_AT = """
import importlib, os, signal, sys
from rota.command.cli import run
make_plan = importlib.import_module("rota.planning.make_plan")
ask, planner_of, asked = make_plan.StopRule.__call__, make_plan.planner_of, 0
def counted(self):
    global asked
    asked += 1
    if asked == int(sys.argv[1]):
        os.kill(os.getpid(), signal.SIGTERM)
    return ask(self)
def begun(mission):
    if sys.argv[1] == "0":
        os.kill(os.getpid(), signal.SIGTERM)
    return planner_of(mission)
make_plan.StopRule.__call__, make_plan.planner_of = counted, begun
sys.exit(run(["plan", "mission.yaml"]))
"""
EXAMPLES = Path(__file__).parents[2] / "examples"
LONG_SEARCH = """\
rota: 1
name: room
area: [[0, 0], [30, 0], [30, 20], [0, 20]]
zones: [{name: gate, period_s: 20, circle: {centre: [25, 10], radius_m: 4}}]
period_s: 60
fleet: {speed_m_s: 2, sensor: {shape: disc, radius_m: 2.5}}
patrol: {effort: high}
"""
MANY_ROBOTS = """\
rota: 1
name: field
area: [[0, 0], [160, 0], [160, 160], [0, 160]]
period_s: 10
fleet: {speed_m_s: 5, sensor: {shape: disc, radius_m: 4}}
"""
SPREADING = (EXAMPLES / "swarm-square.yaml").read_text()
BOUNCING = (EXAMPLES / "bounce-monitor.yaml").read_text()


@pytest.mark.parametrize(
    ("mission", "asked", "left"),
    [
        (LONG_SEARCH, 1, "mission.rota.json"),
        (MANY_ROBOTS, 1, "mission.rota.json"),
        (SPREADING, 20, "mission.rota-run"),
        (BOUNCING, 0, "mission.rota.json"),
    ],
    ids=["patrol", "many robots", "swarm", "bounce"],
)
def test_sigterm_stops_a_search_and_keeps_what_there_is(mission: str, asked: int, left: str, yard: Path) -> None:
    Path("mission.yaml").write_text(mission)
    done = run_copy(STOPPED_AT, str(asked), timeout=300)
    assert done.returncode == 143, done.stderr
    assert "SIGTERM again ends at once" in done.stderr
    assert left in os.listdir(), done.stderr
    assert check_plan(read_plan("mission.rota.json")).verdict == "met"


DEAF = """
import importlib, os, signal, sys, time
from rota.planning import stopping
from rota.command.cli import run
from rota.command.ending import leave
from rota.files.mission_file import read_mission
from rota.model.plan import Plan, Trajectory
from rota.planning.planner import Planner
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # which nohup has programs ignore
stopping.GRACE_S, asked = 0.3, []
class Deaf(Planner):
    settings = None
    def sentences(self, answer, report):
        return ()
    def plan(self, request):
        asked.append(request)
        for leg_s in {judged}:
            way = Trajectory(robot="robot-1", times_s=[0, leg_s, 2 * leg_s], positions_m=[[3, 5], [7, 5], [3, 5]])
            request.judge(Plan(mission=request.mission, trajectories=(way,)))
        {stop}
        while True:
            pass
for module in ("rota.planning.planner", "rota.planning.make_plan", "rota.command.plan"):
    setattr(importlib.import_module(module), "planner_of", lambda mission: Deaf())
if {stall}:
    import rota.check
    def stall(plan, **_):
        request = asked[0]
        {stop}
        while True:
            pass
    rota.check.check_plan = stall
leave(run(["plan", "yard.yaml", *sys.argv[1:]]))
"""


TIME_IS_UP, SIGTERM, SIGHUP = "request.should_stop.stop()", "os.kill(os.getpid(), 15)", "os.kill(os.getpid(), 1)"


def deaf(*options: str, judged: str = "()", stall: bool = False, stop: str = TIME_IS_UP) -> Any:
    """A search that never asks whether to stop, after plans of these times for a leg; stall: nor does the check."""
    script = DEAF.format(judged=judged, stall=stall, stop=stop)
    return run_copy(script, *options)


@pytest.mark.parametrize(("stop", "code"), [(TIME_IS_UP, 3), (SIGTERM, 143), (SIGHUP, 129)])
def test_a_search_that_does_not_stop_is_left_without_a_plan(stop: str, code: int, yard: Path) -> None:
    done = deaf(stop=stop)
    assert done.returncode == code, done.stderr
    assert "no plan: the search did not come to an end in time after it was to stop" in done.stderr
    assert os.listdir() == ["yard.yaml"]


def test_the_best_plan_of_a_search_that_is_left_is_written(yard: Path) -> None:
    done = deaf(judged="(1, 4)")
    assert done.returncode == 0, done.stderr
    assert "Check: met" in done.stdout
    assert "stopped early by the time limit: this is the best plan so far" in done.stderr
    assert check_plan(read_plan("yard.rota.json")).verdict == "met"
    assert sorted(os.listdir()) == ["yard.rota.json", "yard.yaml"]


def test_a_plan_that_fails_is_left_beside_or_with_best_in_its_place(yard: Path) -> None:
    done = deaf(judged="(1,)")
    assert done.returncode == 3, done.stderr
    assert "the check says 'violated'" in done.stderr
    assert "the best plan so far is in yard.partial.rota.json" in done.stderr
    done = deaf("--best", judged="(1,)")
    assert done.returncode == 3, done.stderr
    assert json.loads(Path("yard.rota.json").read_text())["meets_demand"] is False
    assert sorted(os.listdir()) == ["yard.rota.json", "yard.yaml"]


def test_a_plan_that_cannot_be_written_is_left_beside(
    yard: Path, use: Use, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def planner(mission: Mission, *, judge: Any, **_: Any) -> Plan:
        judge(answer(mission))
        Path("yard.rota.json").mkdir()  # in the meantime
        return answer(mission)

    use(planner)
    assert run(["plan", "yard.yaml"]) == 2
    err = capsys.readouterr().err
    assert "yard.rota.json: is a folder" in err
    assert "the best plan so far is in yard.partial.rota.json\n" in err
    assert check_plan(read_plan("yard.partial.rota.json")).verdict == "met"


def test_the_first_plan_is_on_disk_before_its_check_begins(yard: Path) -> None:
    done = deaf(judged="(4,)", stall=True, stop="os.kill(os.getpid(), 9)")
    assert done.returncode == -9
    left = read_plan("yard.partial.rota.json")
    assert left.trajectories[0].times_s.tolist() == [0, 4, 8]
    assert json.loads(Path("yard.partial.rota.json").read_text())["meets_demand"] is False


def test_a_check_that_does_not_end_never_says_met(yard: Path) -> None:
    done = deaf(judged="(4,)", stall=True)
    assert done.returncode == 3, done.stderr
    assert "its best plan so far was not checked to the end" in done.stderr
    assert json.loads(Path("yard.partial.rota.json").read_text())["meets_demand"] is False
    done = deaf("--best", judged="(4,)", stall=True)
    assert done.returncode == 3, done.stderr
    assert "Check: not checked to the end." in done.stdout
    assert "met" not in done.stdout
    assert json.loads(Path("yard.rota.json").read_text())["meets_demand"] is False


def test_sigterm_outside_the_search_leaves_no_half_of_a_file(
    plan_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def settle(*_: Any) -> None:
        os.kill(os.getpid(), signal.SIGTERM)

    before, files = signal.getsignal(signal.SIGTERM), sorted(os.listdir())
    monkeypatch.setattr("rota.files.atomic_write._settle", settle)
    assert run(["export", str(plan_path), "--to", "geojson", "-o", "yard.geojson"]) == 143
    assert capsys.readouterr().err == "rota: interrupted\n"
    assert sorted(os.listdir()) == files
    assert signal.getsignal(signal.SIGTERM) is before


def test_sigterm_before_the_search_is_told(
    yard: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def read(_path: Path) -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(60)

    monkeypatch.setattr("rota.files.mission_file.read_mission", read)
    assert run(["plan", "yard.yaml"]) == 143
    assert capsys.readouterr().err == "rota: no plan: the search had not begun\nrota: interrupted\n"


def test_ctrl_c_is_heard_while_a_plan_is_checked(
    plan_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ends = threading.Event()

    def check(*_: Any, **__: Any) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        ends.wait(60)

    monkeypatch.setattr("rota.check.check_plan", check)
    assert run(["check", str(plan_path)]) == 130
    ends.set()
    assert "rota: the plan is not checked to the end\n" in capsys.readouterr().err


def test_an_ignored_sigterm_stays_ignored(plan_path: Path) -> None:
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        with stop_on_interrupt(lambda _by: None) as stop:
            os.kill(os.getpid(), signal.SIGTERM)
            assert not stop()
            os.kill(os.getpid(), signal.SIGINT)
            assert stop()
        assert stop.exit_code == 130
    finally:
        signal.signal(signal.SIGTERM, before)


def test_ctrl_c_outside_the_search_is_told(
    plan_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stopped(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("rota.draw.animate_plan", stopped)
    assert run(["animate", str(plan_path), "-o", "yard.gif"]) == 130
    out, err = capsys.readouterr()
    assert (out, err) == ("", "rota: interrupted\n")
    assert not Path("yard.gif").exists()


@pytest.mark.parametrize("end", ["SIGINT", "SIGTERM"])
def test_the_second_signal_ends_at_once_and_leaves_the_old_file(end: str, yard: Path) -> None:
    Path("yard.rota.json").write_text("old")
    script = (
        "import importlib, os, signal, sys\n"
        "from rota.command.cli import run\n"
        "from rota.planning.planner import Planner\n"
        "class Deaf(Planner):\n"
        "  settings = None\n"
        "  def plan(self, request):\n"
        f"    os.kill(os.getpid(), signal.{end})\n"
        f"    while signal.getsignal(signal.{end}) != signal.SIG_DFL:\n"
        "      pass\n"
        "    sys.stderr.write('still here\\n')\n"
        f"    os.kill(os.getpid(), signal.{end})\n"
        "    sys.stderr.write('deaf\\n')\n"
        "for module in ('rota.planning.planner', 'rota.planning.make_plan'):\n"
        "  importlib.import_module(module).planner_of = lambda mission: Deaf()\n"
        "sys.exit(run(['plan', 'yard.yaml']))\n"
    )
    done = run_copy(script)
    assert done.returncode == -getattr(signal, end)
    assert "still here" in done.stderr
    assert "deaf" not in done.stderr
    assert Path("yard.rota.json").read_text() == "old"


# ---------------------------------------------------------------- check, draw, animate, export


def test_check_tells_met_and_violated_apart(plan_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "yard.rota.json"]) == 0
    assert "verdict: met" in capsys.readouterr().out
    write_plan(answer(read_plan(plan_path).mission, leg_s=1), "fast.json")
    assert run(["check", "fast.json"]) == 1
    assert "verdict: violated" in capsys.readouterr().out


def test_check_prints_a_report_by_its_schema(plan_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["schema", "report"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert run(["check", str(plan_path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    jsonschema.validate(report, schema)
    assert report["verdict"] == "met"


def test_check_reads_stdin(
    plan_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(plan_path.read_bytes())))
    assert run(["check", "-"]) == 0
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b"{")))
    assert run(["check", "-"]) == 2
    assert "rota: error: stdin:1:2: not JSON" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["check", "none.json"], "none.json: no such file; a plan file"),
        (["check", "yard.yaml"], "yard.yaml:1:1: not JSON"),
        (["draw", "yard.rota.json", "-o", "p.bmp"], "'.bmp' is no format for a picture; .png, .svg or .pdf is needed"),
        (["draw", "yard.rota.json", "-o", "p"], "p: has no suffix, which tells the format of a picture; .png, .svg or"),
        (["draw", "none.json", "-o", "p.png"], "none.json: no such file; a plan file"),
        (["draw", "yard.rota.json", "-o", "none/p.png"], "there is no folder"),
        (["animate", "yard.rota.json", "-o", "p.avi"], "'.avi' is no format for a film; .gif or .mp4 is needed"),
        (["animate", "yard.rota.json", "-o", "p.gif", "--fps", "0"], "fps: 0 is not allowed"),
        (["animate", "yard.rota.json", "-o", "p.gif", "--seconds", "9999"], "seconds: 9999.0 is not allowed"),
        (["export", "yard.rota.json", "--to", "qgroundcontrol", "-o", "-"], "the path of a folder is needed"),
        (["export", "yard.rota.json", "--to", "create2-sketch", "-o", "-"], "the path of a folder is needed"),
        (["export", "yard.rota.json", "--to", "create2-sketch", "-o", "p"], "a plan of the planner bounce is needed"),
        (["export", "yard.rota.json", "--to", "kmz", "-o", "p"], "'geojson', 'csv', 'kml', 'gpx', 'qgroundcontrol'"),
        (["export", "yard.rota.json", "--to", "geojson", "-o", "."], "is a folder"),
        (["export", "yard.rota.json", "--to", "waypoints", "-o", "-"], "the path of a folder is needed"),
        (["export", "yard.rota.json", "--to", "kml", "-o", "none/p.kml"], "there is no folder"),
        (
            ["export", "yard.rota.json", "--to", "kml", "-o", "p.kml", "--origin", "91,0"],
            "--origin: '91,0' is not allowed; LAT,LON in degrees is needed, such as 48.1,11.5, with LAT in -90..90",
        ),
        (["export", "yard.rota.json", "--to", "csv", "-o", "p", "--origin", "nan,0"], "--origin: 'nan,0' is not"),
        (["export", "yard.rota.json", "--to", "csv", "-o", "p", "--origin", "1,2,3"], "--origin: '1,2,3' is not"),
        (["export", "yard.rota.json", "--to", "csv", "-o", "p", "--origin", "-1,2"], "the mission has its own, "),
        (["export", "yard.rota.json", "--to", "create2-sketch", "-o", "p", "--origin", "1,2"], "own metres"),
        (
            ["export", "yard.rota.json", "--to", "csv", "-o", "p", "--start-time", "2000-01-01"],
            "csv has no clock; these have one: kml, gpx, ",
        ),
        (
            ["export", "yard.rota.json", "--to", "gpx", "-o", "p", "--start-time", "noon"],
            "--start-time: 'noon' is not allowed; a date and time in ISO 8601 is needed",
        ),
        (
            ["export", "yard.rota.json", "--to", "gpx", "-o", "p", "--start-time", "9999-12-31T23:59:59"],
            "after the year 9999",
        ),
        (["export", "yard.rota.json", "--to", "geojson", "-o", "yard.rota.json"], "is the input itself"),
        (["export", "yard.rota.json", "--to", "qgroundcontrol", "-o", "yard.yaml"], "is a file"),
        (["new", "yard.yaml"], "yard.yaml: exists already"),
        (["schema", "robots"], "'mission', 'plan', 'report'"),
        (["fly"], "fly"),
    ],
)
def test_bad_input_is_exit_code_2_and_changes_nothing(
    arguments: list[str], message: str, plan_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = plan_path.read_bytes()
    assert run(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in " ".join(err.replace("│", " ").split())
    assert sorted(os.listdir()) == ["yard.rota.json", "yard.yaml"]
    assert plan_path.read_bytes() == before


def test_pictures_films_and_exports_appear(plan_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["draw", "yard.rota.json", "-o", "yard.PNG"]) == 0
    assert Path("yard.PNG").read_bytes().startswith(b"\x89PNG")
    assert run(["animate", "yard.rota.json", "-o", "yard.gif"]) == 0
    assert Path("yard.gif").read_bytes().startswith(b"GIF8")
    assert run(["export", "yard.rota.json", "--to", "geojson", "-o", "yard.geojson"]) == 0
    assert json.loads(Path("yard.geojson").read_text())["features"][0]["properties"]["name"] == "yard"
    told = [line for line in capsys.readouterr().out.splitlines() if "compiling" not in line]
    assert told == ["yard.PNG", "yard.gif", "yard.geojson"]
    assert run(["animate", "yard.rota.json", "-o", "short.gif", "--seconds", "1", "--fps", "5"]) == 0
    with Image.open("short.gif") as film:
        assert film.n_frames == 5
    capsys.readouterr()
    assert run(["export", "yard.rota.json", "--to", "qgroundcontrol", "-o", "fly"]) == 0
    assert capsys.readouterr().out == "fly/robot-1.plan\n"
    assert json.loads(Path("fly/robot-1.plan").read_text())["mission"]["firmwareType"] == 3
    assert run(["export", "yard.rota.json", "--to", "waypoints", "-o", "fly"]) == 0
    assert Path("fly/robot-1.waypoints").read_text().startswith("QGC WPL 110\n")
    assert run(["export", "yard.rota.json", "--to", "qgroundcontrol-px4", "-o", "fly"]) == 0
    assert json.loads(Path("fly/robot-1.plan").read_text())["mission"]["firmwareType"] == 12


def test_a_plan_of_bouncing_robots_becomes_a_sketch(yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    room = TypedMap(rows=("...", "..."), cell_m=0.5)
    write_plan(bounced_plan(room, ((0, 0, 0),), turn=2, speed_m_s=0.2, headings=4), "room.json")
    assert run(["export", "room.json", "--to", "create2-sketch", "-o", "sketches"]) == 0
    assert capsys.readouterr().out == "sketches/robot-1/robot-1.ino\n"
    assert "void loop() {" in Path("sketches/robot-1/robot-1.ino").read_text()


def test_exports_without_an_origin(yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    yard.write_text("".join(line for line in YARD.splitlines(keepends=True) if "origin" not in line))
    write_plan(answer(read_mission(yard).mission), "flat.json")
    assert run(["export", "flat.json", "--to", "geojson", "-o", "-"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["coordinates_in"] == "metres"
    assert "no origin" in err
    assert run(["export", "flat.json", "--to", "qgroundcontrol", "-o", "fly"]) == 2
    assert "give --origin LAT,LON, or add origin" in capsys.readouterr().err
    assert not Path("fly").exists()
    placed = ["export", "flat.json", "--origin", "-33.5,151.25"]
    assert run([*placed, "--to", "geojson", "-o", "-"]) == 0
    out, err = capsys.readouterr()
    assert "coordinates_in" not in json.loads(out)
    assert "no origin" not in err
    assert run([*placed, "--to", "qgroundcontrol", "-o", "fly"]) == 0
    home = json.loads(Path("fly/robot-1.plan").read_text())["mission"]["plannedHomePosition"]
    assert home[:2] == pytest.approx([-33.5, 151.25], abs=0.01)
    capsys.readouterr()
    assert run([*placed, "--to", "csv", "-o", "-"]) == 0
    assert capsys.readouterr().out.startswith("robot,t_s,x_m,y_m,lat,lon,in_loop\nrobot-1,0.0,")


@pytest.mark.parametrize(("to", "first"), [("kml", "<when>2026-05-01T06:00:00.000Z"), ("gpx", "T06:00:00.000Z</time>")])
def test_exports_with_a_clock_start_when_told(
    to: str, first: str, plan_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["export", str(plan_path), "--to", to, "-o", "-"]
    assert run([*command, "--start-time", "2026-05-01T08:00+02:00"]) == 0
    assert first in capsys.readouterr().out
    assert run(command) == 0
    assert "2000-01-01T00:00:00.000Z" in capsys.readouterr().out


# ---------------------------------------------------------------- new, schema, version


def test_new_writes_a_mission_that_reads(yard: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["new"]) == 0
    assert "rota plan mission.yaml" in capsys.readouterr().out
    assert read_mission(Path("mission.yaml")).mission.zones
    assert run(["new", "-"]) == 0
    assert capsys.readouterr().out == Path("mission.yaml").read_text()
    assert run(["new"]) == 2


@pytest.mark.parametrize("name", ["mission", "plan", "report"])
def test_schemas_are_valid(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["schema", name]) == 0
    schema = json.loads(capsys.readouterr().out)
    jsonschema.Draft202012Validator.check_schema(schema)
    assert schema["type"] == "object"


def test_version_and_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out == "rota 0.1.0\n"
    assert run(["--help"]) == 0
    listed = capsys.readouterr().out
    for command in ("plan", "check", "draw", "animate", "export", "new", "schema"):
        assert f" {command} " in listed


def test_the_installed_program_runs() -> None:
    program = Path(sys.executable).with_name("rota")
    done = subprocess.run([program, "schema", "nothing"], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 2
    assert done.stdout == ""


def test_it_runs_as_a_module() -> None:
    asked = [sys.executable, "-m", "rota", "--version"]
    done = subprocess.run(asked, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout) == (0, "rota 0.1.0\n")


def test_a_plan_is_judged_for_another_mission(yard: Path, plan_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_plan(replace(answer(read_mission(yard).mission), seed=7), plan_path)
    assert run(["check", str(plan_path), "--mission", "yard.yaml"]) == 0
    told = capsys.readouterr()
    assert "lower bound: 1 by the plan's own word" in told.out
    assert told.err == "rota: for robots that change speed at once\n"
    (yard.parent / "other.yaml").write_text(
        YARD.replace("speed_m_s: 1", "speed_m_s: 0.5").replace("name: yard", "name: b")
    )
    assert run(["check", str(plan_path), "--mission", "other.yaml"]) == 1
    told = capsys.readouterr()
    assert "violation: robot-1: speed" in told.out
    assert "lower bound: not known" in told.out
    assert told.err == "rota: the plan was made for another mission than other.yaml: fleet speed 1 → 0.5 m/s\n"
    (yard.parent / "far.yaml").write_text(
        YARD.replace("[0, 0], [10, 0], [10, 10], [0, 10]", "[9e6, 0], [9.1e6, 0], [9e6, 9]")
    )
    assert run(["check", str(plan_path), "--mission", "far.yaml"]) == 2
    assert "away from the area" in capsys.readouterr().err


def test_help_names_formats_and_exit_codes_and_cuts_no_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--help"]) == 0
    listed = capsys.readouterr().out
    assert "..." not in listed.replace("ARGS]...", "")
    assert "130 Ctrl-C" in listed
    assert run(["export", "--help"]) == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert [line[:3] for name in ("waypoints", "kml") for line in lines if line[:1] == [name]] == [
        ["waypoints", "a", "folder"],
        ["kml", "a", "file"],
    ]


def test_a_cold_cache_is_told(
    plan_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from rota.compiled.compiled_cache import is_compiled

    assert run(["check", str(plan_path)]) == 0
    capsys.readouterr()
    assert run(["check", str(plan_path)]) == 0
    assert "compiling" not in capsys.readouterr().err
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "empty"))
    assert not is_compiled("check")
    assert run(["check", str(plan_path)]) == 0
    assert "rota: compiling, once: half a minute to a minute" in capsys.readouterr().err


def test_a_check_that_asks_nothing_of_a_swarm_says_that_it_compiles_what_tells_its_holdings(
    plan_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = read_plan(plan_path)
    alone = replace(plan.mission.fleet, robots=(plan.mission.fleet.equal_robot("robot-1"),))
    asks_nothing = replace(plan.mission, period_s=None, fleet=alone, planning=SwarmSettings())
    write_plan(replace(plan, mission=asks_nothing), plan_path)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "empty"))
    assert run(["check", str(plan_path)]) == 0
    told = capsys.readouterr()
    assert told.err == "rota: compiling, once: half a minute to a minute\n"
    # no table of no demands, and nobody is said to have seen all of nothing
    verdict, robots, *held = told.out.splitlines()
    assert (verdict, len(held)) == ("verdict: met", 2)
    assert robots == "robots: 1 (lower bound: 1 by the plan's own word); nothing is asked of the ground"
    assert held[0].startswith("as loops begin: 100.0% of the ground in range")
    assert held[1].startswith("over a loop: ")


# ---------------------------------------------------------------- runs of a swarm


SWARM = """
rota: 1
name: few
area: [[0, 0], [150, 0], [150, 150], [0, 150]]
fleet: {robots: 6, speed_m_s: 2, sensor: {shape: disc, radius_m: 25}, start: {box: [[1, 1], [40, 40]]}}
planner: swarm
swarm: {controller: reciprocal, most_steps: MOST}
"""


def test_a_swarm_that_is_stopped_goes_on_from_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "few.yaml").write_text(SWARM.replace("MOST", "20"))
    assert run(["plan", "few.yaml", "--seed", "3"]) == 0
    err = capsys.readouterr().err
    assert "not at rest after 20 steps" in err
    assert "--resume few.rota-run and swarm.most_steps of more than 20 goes on" in err
    assert run(["plan", "few.yaml", "--resume", "few.rota-run", "--seed", "4"]) == 2
    assert "seed: 4 is not allowed; the run has the seed 3" in capsys.readouterr().err
    (tmp_path / "few.yaml").write_text(SWARM.replace("MOST", "90").replace("[40, 40]", "[50, 40]"))
    assert run(["plan", "few.yaml", "--resume", "few.rota-run"]) == 2
    assert "the run is of another mission: fleet differs; only" in capsys.readouterr().err
    (tmp_path / "few.yaml").write_text(SWARM.replace("MOST", "90"))
    assert run(["plan", "few.yaml", "--seed", "3", "-o", "whole.rota.json"]) == 0
    assert run(["plan", "few.yaml", "--resume", "few.rota-run"]) == 0
    assert (tmp_path / "few.rota.json").read_bytes() == (tmp_path / "whole.rota.json").read_bytes()
    assert run(["plan", "few.yaml", "--resume", "few.rota-run", "-o", "few.rota-run"]) == 2
    assert "few.rota-run: is the input itself and is not overwritten" in capsys.readouterr().err
    (tmp_path / "few.rota-run").write_bytes(b"PK")
    assert run(["plan", "few.yaml", "--resume", "few.rota-run"]) == 2
    assert "few.rota-run: no run file, or not a whole one" in capsys.readouterr().err


def test_the_measures_of_every_step_are_written_as_a_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "few.yaml").write_text(SWARM.replace("MOST", "20"))
    assert run(["plan", "few.yaml", "--metrics", "steps.csv"]) == 0
    assert "the run was cut off after 20 steps by swarm.most_steps" in capsys.readouterr().out
    head, *rows = (tmp_path / "steps.csv").read_text().splitlines()
    assert head.startswith("step,time_s,coverage,covered_importance,deadweight_loss,body_gap_m,wall_gap_m,way_m,")
    table = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    assert table[:, 0].tolist() == list(range(21))
    assert table[:, 1] == pytest.approx(0.25 * np.arange(21))
    plan = read_plan(tmp_path / "few.rota.json")
    for row, time_s in ((0, 0.0), (20, 5.0)):  # what is in range in the beginning and in the end, of the plan
        at = [[np.interp(time_s, t.times_s, t.positions_m[:, k]) for k in (0, 1)] for t in plan]
        discs = union_all([Point(x, y).buffer(25, quad_segs=64) for x, y in at])
        assert table[row, 2] == pytest.approx(discs.intersection(box(0, 0, 150, 150)).area / 150**2, abs=3e-3)
    (tmp_path / "few.yaml").write_text(SWARM.replace("MOST", "25"))
    assert run(["plan", "few.yaml", "--resume", "few.rota-run", "--metrics", "more.csv"]) == 0
    assert (tmp_path / "more.csv").read_text().splitlines()[1].startswith("20,5.0,")
    assert run(["plan", "few.yaml", "--metrics", "steps.txt"]) == 2
    assert "steps.txt: '.txt' is no format for a table; .csv is needed" in capsys.readouterr().err
    (tmp_path / "few.yaml").write_text(SWARM.partition("planner")[0] + "period_s: 900\n")
    assert run(["plan", "few.yaml", "--metrics", "steps.csv"]) == 2
    assert "planner: patrol has no steps to measure; swarm does" in capsys.readouterr().err


def test_a_run_that_misses_its_demand_is_kept_without_a_plan(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "few.yaml").write_text(SWARM.replace("MOST", "9") + "period_s: 10\n")
    assert run(["plan", "few.yaml"]) == 3
    err = capsys.readouterr().err
    assert "--resume few.rota-run" in err
    assert "no plan: the best plan found is not shown to meet the demand" in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["few.partial.rota.json", "few.rota-run", "few.yaml"]
    assert run(["plan", "few.yaml", "-o", "-"]) == 3
    assert "a plan that goes to stdout leaves no run to go on with" in capsys.readouterr().err
