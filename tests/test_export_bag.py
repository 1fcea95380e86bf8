"""What bags are handed, and bags as the command line makes them."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest
from benchmarks.small_plans import equal_patrolling, patrolling
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from tests.files.two_robots import two_robots

from rota.check.revisits import worst_gaps_s
from rota.command.cli import run
from rota.export_bag import full_period_s, ground_grids
from rota.files.plan_file import write_plan
from rota.model.plan import Plan, Trajectory


def loops(*durations_s: float, start_s: float = 0.0) -> Plan:
    """Robots to and fro in so many seconds each, which take ``start_s`` to come there."""
    ways = []
    for name, duration_s in zip("ab", durations_s, strict=False):
        times_s, places = [start_s, start_s + duration_s / 2, start_s + duration_s], [[0, 0], [9, 0], [0, 0]]
        if start_s:
            times_s, places = [0, *times_s], [[5, 5], *places]
        ways.append(Trajectory(robot=name, times_s=times_s, positions_m=places, loop_start_s=start_s))
    return Plan(mission=two_robots(robots=("a", "b")).mission, trajectories=tuple(ways))


@pytest.mark.parametrize(
    ("plan", "span_s"),
    [
        (loops(20), 20),
        (loops(20, 30), 60),
        (loops(20, 30, start_s=5), 65),
        (loops(20, 21), 21),  # 420 s would be 20 rounds of the longest
        (loops(20, 20 * math.sqrt(2)), 20 * math.sqrt(2)),
        (two_robots(), 30 + 61.5004),  # the second robot takes 30 s to where it stays
        (patrolling(), 37),  # loops of 12 s and 18 s, the first from 1 s on
        (Plan(mission=two_robots().mission, trajectories=()), 0),
    ],
)
def test_a_full_period_ends_when_all_loops_begin_again(plan: Plan, span_s: float) -> None:
    assert full_period_s(plan) == pytest.approx(span_s, abs=1e-9)


def test_grids_tell_free_space_and_the_checks_worst_gaps() -> None:
    plan = patrolling()
    grids = ground_grids(plan)
    gaps, free = grids["/worst_gaps"], grids["/map"]
    rows, columns = np.nonzero(gaps.values >= 0)
    points_m = np.column_stack([gaps.x_m[columns], gaps.y_m[rows]])
    in_gate = (points_m > [2, 1]).all(axis=1) & (points_m < [7, 4]).all(axis=1)
    outside = ~in_gate & ~((points_m > [25, 2]).all(axis=1) & (points_m < [27, 4]).all(axis=1))
    wanted = np.floor(100 * worst_gaps_s(plan, points_m) / np.where(in_gate, 12, 50) + 1e-9)
    for some in (in_gate, outside):
        assert some.sum() > 1000
        np.testing.assert_array_equal(gaps.values[rows, columns][some], np.minimum(wanted, 100)[some])
    # the block stands in the way, the hedge only hides
    for x_m, y_m, value in ((7, 6, 100), (22, 5.25, 0), (15, 6, 0)):
        assert free.values[np.abs(free.y_m - y_m).argmin(), np.abs(free.x_m - x_m).argmin()] == value
    assert (gaps.values[:, np.abs(gaps.x_m - 7).argmin()] == -1).any()


@pytest.mark.parametrize("to", ["rosbag2", "rosbag2-sqlite3", "rosbag1"])
def test_the_command_writes_bags(to: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan, target = tmp_path / "plan.json", tmp_path / "out.bag"
    write_plan(equal_patrolling(), plan)
    command = ["export", str(plan), "--to", to, "-o", str(target)]
    assert run([*command, "--start-time", "2026-05-01"]) == 0
    written = [Path(line) for line in capsys.readouterr().out.split()]
    assert all(path.stat().st_size > 100 for path in written)
    assert run([*command[:-1], "-"]) == 2
    assert run([*command, "--origin", "1,2"]) == 2
    assert "the mission's own metres" in capsys.readouterr().err
    if to == "rosbag2":
        with written[1].open("rb") as file:
            reader = make_reader(file, decoder_factories=[DecoderFactory()])
            topics = {channel.topic for _, channel, _, _ in reader.iter_decoded_messages()}
        assert topics == {f"/r{k}/{what}" for k in range(3) for what in ("path", "pose")} | {
            "/map", "/worst_gaps", "/tf", "/tf_static"
        }  # fmt: skip


def test_without_the_extra_it_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_plan(equal_patrolling(), tmp_path / "plan.json")
    monkeypatch.setitem(sys.modules, "rosbags.interfaces", None)
    for to in ("rosbag2", "rosbag1"):
        assert run(["export", str(tmp_path / "plan.json"), "--to", to, "-o", str(tmp_path / "out.bag")]) == 2
        assert f"{to} needs the rosbags library: pip install 'rota[ros]'" in capsys.readouterr().err
    assert not (tmp_path / "out.bag").exists()
