"""The benchmarks themselves: missions as the figures ask for them, what rows say, and one real run of two."""

from __future__ import annotations

import ast
import importlib
import math
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from benchmarks import ablation, many_robots, plan_hashes
from benchmarks.__main__ import arguments, line_of
from benchmarks.figures import FIGURES, LONG
from benchmarks.flights import flights
from benchmarks.house import size_of
from benchmarks.large_areas import growth_row, write_tiles
from benchmarks.one_robot import (
    BLOCKS,
    SIDE_M,
    Loop,
    ground,
    judged,
    loop_row,
    mission_text,
    peer_settings,
    shortest_that_sees,
)
from benchmarks.planning import Planned, worst_ratio
from benchmarks.random_runs import Outcome, fault, outcomes, summary
from benchmarks.row import Options, Row
from benchmarks.shell import Run, python, run
from benchmarks.stopping_missions import write_building, write_corridor, write_drones, write_wide_turns
from benchmarks.sun_cases import CASES, case_row, total_row, write_case
from benchmarks.swarm_adversarial import LATTICES, closest, dense_states, lattice_states
from benchmarks.swarm_coverage import mission as swarm_mission, outcome as swarm_outcome
from scipy.spatial.distance import pdist
from shapely import MultiPolygon, box
from tests.vehicles.recorded import recorded_flights, recorded_tracks

from rota.files.mission_file import read_mission
from rota.model.mission import DiscSensor, Fleet, Mission, StartBox
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.efforts import EFFORTS
from rota.planners.swarm.starts import place_starts

PROJECT = Path(__file__).parents[1]
MODULES = sorted(path.stem for path in (PROJECT / "benchmarks").glob("*.py") if path.stem != "__main__")
PEERS = {"peer_paths": "coverage_path_planner", "peer_tours": "fast_tsp", "peer_crowd": "pyrvo"}


def ran(wall_s: float, peak_bytes: int = 300_000_000, code: int = 0, err: str = "") -> Run:
    return Run(wall_s=wall_s, peak_bytes=peak_bytes, code=code, out="", err=err, cpu_s=wall_s + 2)


def planned(robots: int, wall_s: float, *, bound: int = 3, verdict: str = "met") -> Planned:
    demands = [{"worst_gap_s": 39.0, "period_s": 40.0}, {"worst_gap_s": 7.9, "period_s": 8.0}]
    report = {"verdict": verdict, "robots": robots, "lower_bound_robots": bound, "demands": demands}
    return Planned(plan=ran(wall_s), check=ran(1.0), report=report)


EASY_SEED = 95  # a random mission of one open room
NO_PLAN = Planned(plan=ran(4.0, code=3, err="rota: no plan: too far | away"), check=None, report=None)


# ---------------------------------------------------------------- recorded flights


def test_recorded_flights_are_read_and_flown_again(tmp_path: Path) -> None:
    assert [row.measured for row in flights(Options(folder=tmp_path))] == ["needs --flights FOLDER"]
    flight = next(each for each in recorded_flights() if each.name == "b_tun2_w5_r2")
    points = "; ".join(
        "{:.2f} {:.2f}".format(*stop.place_m) for stop in (flight.way.once + flight.way.every_round)[:-1]
    )
    track = recorded_tracks()[flight.name] + [40, 0, 0]
    lines = [
        "# accel_m_s2=5; jerk_m_s3=5; radius_m=2; angle_max_deg=30; wind_m_s=5; wind_from_deg=240; speed_m_s=8",
        f"# points_m: {points}",
        f"# reached (point index, s): 0 1.0; 1 4.0; 0 40.0; 0 {40 + 1.01 * flight.round_s:.2f}",
        "t_s,x_m,y_m",
        *(",".join(f"{number:.2f}" for number in row) for row in track),
    ]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    (tmp_path / "manifest.csv").write_text('file,kind\na.csv,"loop, AUTO"\nb.csv,corners\n')
    rows = list(flights(Options(folder=tmp_path, flights=tmp_path)))
    assert [row.name.rpartition(": ")[2] for row in rows] == ["5 m/s2, 30 degrees, wind", "all, wind"]
    # the recorded round was written 1 % too long
    assert "1 loops: median 0.8" in rows[0].measured
    assert "tracks at most 0.2" in rows[0].measured


# ---------------------------------------------------------------- the program


@pytest.mark.parametrize("name", [name for name in MODULES if name not in PEERS])
def test_every_module_can_be_imported(name: str) -> None:
    assert importlib.import_module(f"benchmarks.{name}").__doc__


@pytest.mark.parametrize("program", PEERS)
def test_a_peers_program_needs_nothing_but_the_peer(program: str) -> None:
    tree = ast.parse((PROJECT / "benchmarks" / f"{program}.py").read_text())
    named = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    named |= {str(node.module) for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    foreign = {name.partition(".")[0] for name in named} - set(sys.stdlib_module_names)
    assert foreign == {PEERS[program]}


def test_lines_of_code_are_neither_blank_nor_words() -> None:
    head = '"""A module.\n\nMore."""\n\nimport os\n\n\n'
    text = head + 'def f(a):  # told\n    """Why."""\n    # how\n    return (\n        a\n    )\n'
    assert size_of(text) == (13, 5)  # the import, the head, and three lines that return


@pytest.mark.slow  # starts interpreters that plan
def test_one_name_is_measured_and_printed_as_a_table() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", "import"], cwd=PROJECT, capture_output=True, text=True, check=True
    )
    lines = done.stdout.splitlines()
    assert lines[-3:-1] == ["| figure | asked | measured | reached |", "|---|---|---|---|"]
    assert lines[-1].startswith("| import rota, with the interpreter's start | < 0.5 s | ")


def test_names_and_numbers_are_read_from_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    chosen = arguments().parse_args(["random-missions", "--missions", "7", "--first-seed", "0", "--tile", "250"])
    assert (chosen.names, chosen.missions, chosen.first_seed, chosen.tile) == (["random-missions"], 7, 0, 250)
    assert (chosen.effort, chosen.all, chosen.processes) == ("quick", False, None)
    assert arguments().parse_args([]).names == []
    assert set(LONG) < set(FIGURES)
    for wrong in (["fig14"], ["--missions", "0"], ["--tile", "-1"], ["--tile", "nan"], ["--effort", "much"]):
        with pytest.raises(SystemExit):
            arguments().parse_args(wrong)
        assert wrong[-1] in capsys.readouterr().err


def test_a_cell_keeps_to_its_column() -> None:
    assert line_of(Row("a", "b", "no plan:\n too far | away", False)) == "| a | b | no plan: too far / away | NO |"
    assert line_of(Row("a", "", "c", None)).endswith("| c |  |")


# ---------------------------------------------------------------- the paper's cases


def test_the_cases_are_the_papers(tmp_path: Path) -> None:
    assert sum(case.paper_robots for case in CASES) == 50
    assert sum(case.paper_late for case in CASES) == 4
    example = read_mission(PROJECT / "examples" / "sun2019-fig13.yaml").mission
    section = read_mission(write_case(CASES[-1], tmp_path)).mission
    assert (section.area, section.obstacles, section.zones) == (example.area, example.obstacles, example.zones)
    assert (section.period_s, section.fleet) == (example.period_s, example.fleet)
    third = read_mission(write_case(CASES[2], tmp_path)).mission
    assert ([zone.period_s for zone in third.zones], third.period_s) == ([12, 7], 40)


def test_a_case_is_reached_with_no_more_robots_than_asked_within_a_minute() -> None:
    case = CASES[-1]  # at most four
    row = case_row(case, planned(4, 30), "quick")
    assert row.reached
    assert row.asked == "met, at most 4 robots (the paper: 5), < 60 s"
    assert "4 robots (bound 3), met; worst gap / period 0.988; CPU 35 s" in row.measured
    assert not case_row(case, planned(5, 30), "quick").reached
    assert not case_row(case, planned(4, 60), "quick").reached
    assert not case_row(case, planned(4, 30, verdict="not proven"), "quick").reached
    assert not case_row(case, NO_PLAN, "quick").reached
    assert "exit code 3" in case_row(case, NO_PLAN, "quick").measured


def test_the_total_counts_what_is_met() -> None:
    row = total_row([planned(5, 10)] * 7, "normal")
    assert row.reached
    assert row.measured == "35 robots (bound 21) in 7 of 7 cases met; 77 s in all, CPU 105 s"
    assert not total_row([planned(5, 10)] * 6 + [planned(6, 10)], "normal").reached
    assert not total_row([planned(5, 10)] * 6 + [NO_PLAN], "normal").reached


def test_the_worst_ratio_is_without_end_where_something_is_never_seen() -> None:
    never: dict[str, Any] = {"demands": [{"worst_gap_s": None, "period_s": 40.0}]}
    assert worst_ratio(never) == math.inf


# ---------------------------------------------------------------- one robot


def test_what_a_straight_route_sees_is_a_stadium() -> None:
    loop = judged(np.array([[10.0, 10.0], [110.0, 10.0]]))
    radius_m = 5.001
    free_m2 = SIDE_M**2 - 15 * 25 - 25 * 15
    assert loop.length_m == pytest.approx(100)
    assert loop.seen_share == pytest.approx((100 * 2 * radius_m + math.pi * radius_m**2) / free_m2, abs=5e-5)
    assert loop.stays_inside
    assert not loop.sees_all


def test_walls_cut_what_a_route_sees_and_routes_through_them_do_not_count() -> None:
    along_a_wall = judged(np.array([[30.0, 60.0], [45.0, 60.0]]))  # the lower side of the first block
    free_m2 = SIDE_M**2 - 15 * 25 - 25 * 15
    # half a stadium below; above, beside the block, a quarter of a disc at either end
    assert along_a_wall.seen_share * free_m2 == pytest.approx(15 * 5.001 + math.pi * 5.001**2, abs=0.4)
    assert along_a_wall.stays_inside
    assert not judged(np.array([[20.0, 70.0], [60.0, 70.0]])).stays_inside
    assert not judged(np.array([[20.0, 70.0], [-1.0, 70.0]])).stays_inside


def test_the_shortest_route_that_sees_enough_is_chosen() -> None:
    lanes = [(x, y) for k, y in enumerate(np.arange(5, 120, 10)) for x in ((0, 120) if k % 2 == 0 else (120, 0))]
    routes = [np.array(lanes, float), np.array([[0.0, 5.0], [120.0, 5.0]]), np.array([[60.0, 5.0], [119.0, 5.0]])]
    best = shortest_that_sees(routes, 0.05)
    assert best is not None
    assert best.length_m == pytest.approx(120)
    assert shortest_that_sees(routes, 0.9) is None  # the lanes go through the blocks
    assert shortest_that_sees([], 0.1) is None


def test_a_loop_that_is_short_enough_and_sees_all_within_the_time_is_what_is_asked() -> None:
    loop = Loop(length_m=1500.4, seen_share=1.0, sees_all=True, stays_inside=True)
    row = loop_row(planned(1, 10, bound=1), loop, "normal")
    assert row.reached
    assert row.measured.startswith("1,500 m, 100.00 % seen; 11.0 s (plan 10.0, check 1.0)")
    assert row.measured.endswith("1 robots (bound 1), met; CPU 15 s")
    assert not loop_row(planned(1, 10), loop._replace(length_m=1500.6), "normal").reached
    assert not loop_row(planned(1, 10), loop._replace(sees_all=False), "normal").reached
    assert not loop_row(planned(1, 10), loop._replace(stays_inside=False), "normal").reached
    assert not loop_row(planned(1, 60), loop, "normal").reached
    assert loop_row(NO_PLAN, None, "quick").measured.startswith("none within 1,620 m: exit code 3")


def test_the_mission_of_the_loop_has_one_robot(tmp_path: Path) -> None:
    path = tmp_path / "one.json"
    path.write_text(mission_text())
    mission = read_mission(path).mission
    assert mission.fleet.robots is not None
    assert len(mission.fleet.robots) == 1
    assert mission.fleet.speed_m_s * mission.period_s == pytest.approx(1620)
    blocks = [obstacle.shape.bounds for obstacle in mission.obstacles]
    assert (
        blocks == [obstacle.shape.bounds for obstacle in ground().obstacles] == [tuple(map(float, b)) for b in BLOCKS]
    )
    assert len(peer_settings()) == 11 * 9 * 4 * 3


# ---------------------------------------------------------------- large areas


def test_tiles_are_the_square_kilometres_of_the_figures(tmp_path: Path) -> None:
    one = read_mission(write_tiles(1, 1, 1000, tmp_path)).mission
    assert one.area.bounds == (0, 0, 1000, 1000)
    corners = [obstacle.shape.bounds for obstacle in one.obstacles]
    assert corners == [(x, y, x + 80, y + 80) for x, y in ((200, 200), (700, 200), (200, 700), (700, 700))]
    ten = read_mission(write_tiles(5, 2, 1000, tmp_path)).mission
    assert ten.area.area == pytest.approx(10e6)
    assert sum(obstacle.shape.area for obstacle in ten.obstacles) == pytest.approx(40 * 6400)
    assert max(obstacle.shape.bounds for obstacle in ten.obstacles) == (4700, 1700, 4780, 1780)
    small = read_mission(write_tiles(2, 1, 50, tmp_path)).mission
    assert small.obstacles[-1].shape.bounds == (85, 35, 89, 39)


def test_growth_is_the_exponent_of_time_in_area() -> None:
    options = Options(folder=Path())
    row = growth_row(planned(7, 20), planned(70, 200), options)
    assert (row.measured, row.reached) == ("exponent 1.00 (20.0 s to 200.0 s)", True)
    assert growth_row(planned(7, 20), planned(70, 2000), options).measured.startswith("exponent 2.00")
    assert not growth_row(planned(7, 20), planned(70, 20 * 10**1.21), options).reached
    assert not growth_row(planned(7, 20), NO_PLAN, options).reached


# ---------------------------------------------------------------- random missions


def outcome(seed: int, failure: str | None = None, *, robots: int = 3, bound: int = 2, seconds: float = 4.0) -> Outcome:
    return Outcome(seed=seed, seconds=seconds, failure=failure, kind="600 m2", robots=robots, bound=bound)


def test_the_summary_counts_robots_above_their_bounds() -> None:
    options = Options(folder=Path(), missions=3)
    row = summary([outcome(0), outcome(2, robots=2), outcome(1, seconds=7)], options, 12.0)
    assert row.reached
    assert row.measured == (
        "3 of 3 passed, 100.0 %; where robots may be few 8 robots (bounds 6; 1 at +0, 2 at +1, seed 0 farthest);"
        " 5.0 s each, seed 1 slowest with 7.0 s, 12 s in all"
    )
    failed = summary([outcome(0), outcome(1), outcome(2, "no plan", robots=0)], options, 12.0)
    assert not failed.reached
    few = "where robots may be few 6 robots (bounds 4; 2 at +1, seed 0 farthest)"
    assert failed.measured.startswith(f"2 of 3 passed, 66.7 %; {few}")
    given = outcome(2, robots=9)._replace(given=True)
    assert f"3 of 3 passed, 100.0 %; {few}" in summary([outcome(0), outcome(1), given], options, 12.0).measured
    early = summary([outcome(0), outcome(1)], options, 12.0)
    assert not early.reached
    assert early.measured.startswith("2 of 2 (of 3; interrupted) passed")
    assert summary([], options, 1.0).reached is None


def test_a_plan_is_at_fault_when_the_check_or_its_own_bound_says_so() -> None:
    mission = Mission(
        name="yard", area=MultiPolygon([box(0, 0, 10, 10)]), period_s=40,
        fleet=Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=20)),
    )  # fmt: skip
    stays = Trajectory(robot="robot-1", times_s=[0.0], positions_m=[(5.0, 5.0)])
    outside = Trajectory(robot="robot-1", times_s=[0.0], positions_m=[(-5.0, 5.0)])
    assert fault(Plan(mission=mission, trajectories=(stays,), lower_bound_robots=1)) is None
    assert "the check says 'violated'" in str(fault(Plan(mission=mission, trajectories=(outside,))))
    above = fault(Plan(mission=mission, trajectories=(stays,), lower_bound_robots=2))
    assert above == "the check says 'violated' of the plan as written"  # which refutes the bound


@pytest.mark.slow  # starts interpreters that plan
def test_missions_are_planned_in_processes_until_ctrl_c(tmp_path: Path) -> None:
    before = signal.getsignal(signal.SIGINT)
    found = []
    for one in outcomes(Options(folder=tmp_path, missions=50, first_seed=EASY_SEED, processes=1)):
        found.append(one)
        os.kill(os.getpid(), signal.SIGINT)
    assert [(one.seed, one.failure) for one in found] == [(EASY_SEED, None)]
    assert 0 < found[0].bound <= found[0].robots
    assert signal.getsignal(signal.SIGINT) is before


# ---------------------------------------------------------------- swarms


def test_dense_states_are_dense_and_nothing_overlaps_in_them() -> None:
    states = dense_states(500, 6, np.random.default_rng(3))
    gaps = np.array([_gaps(at, bodies) for at, bodies in zip(states.places_m, states.bodies_m, strict=True)])
    assert gaps.min() > -1e-12
    assert (gaps.min(axis=1) < 0.2).all()  # everywhere some touch or nearly do
    low, high = states.boxes_m[:, None, :2], states.boxes_m[:, None, 2:]
    beside = np.minimum(states.places_m - low, high - states.places_m).min(axis=2) - states.bodies_m
    assert beside.min() > -1e-12
    assert np.median(beside.min(axis=1)) < 1e-9  # most boxes touch a body


def test_lattices_touch_exactly_and_nothing_overlaps_in_them() -> None:
    states = lattice_states(10 * len(LATTICES), np.random.default_rng(3))
    gaps = np.array([_gaps(at, bodies) for at, bodies in zip(states.places_m, states.bodies_m, strict=True)])
    assert gaps.min() > -1e-12
    # no fewer touch than in a row
    assert ((np.abs(gaps) < 1e-12).sum(axis=1) >= states.bodies_m.shape[1] - 1).all()


def test_the_closest_approach_of_two_that_pass_is_that_of_fine_steps() -> None:
    rng = np.random.default_rng(1)
    begin, end = rng.normal(size=(2, 50, 2))
    part = np.linspace(0, 1, 20_001)[:, None, None]
    fine = np.hypot(*np.moveaxis(begin + part * (end - begin), 2, 0)).min(axis=0)
    assert closest(begin, end) == pytest.approx(fine, abs=1e-4)
    assert (closest(begin, end) <= fine + 1e-12).all()
    assert closest(begin, begin) == pytest.approx(np.hypot(*begin.T))


def _gaps(places_m: np.ndarray, bodies_m: np.ndarray) -> np.ndarray:
    first, second = np.triu_indices(len(bodies_m), 1)
    return np.hypot(*(places_m[first] - places_m[second]).T) - bodies_m[first] - bodies_m[second]


def test_a_small_run_is_measured_as_it_is() -> None:
    asked = swarm_mission(3, (250, 250), StartBox(low_m=(100, 100), high_m=(150, 150)), 400)
    run, starts = swarm_outcome(asked, seed=1), place_starts(asked, asked.area, seed=1, reserve_m=0.05)
    assert run.at_rest
    assert run.steps < 400
    assert run.covered == pytest.approx(3 * np.pi * 25**2 / 250**2, abs=1e-4)  # three discs apart
    assert run.so_far[-1] == pytest.approx(run.covered, abs=2e-3)
    assert run.between_m == pytest.approx(pdist(starts).min() - 1)  # they only come apart
    assert run.beside_m > 20


def test_hashes_of_plans_name_what_differs() -> None:
    now = [
        "examples/a.yaml: 2 robots, bound 1, 00ff",
        "random/3: 4 robots, bound 2, ab12",
        "random/4: NoPlanFound: why",
    ]
    assert not plan_hashes.differences(list(reversed(now)), now)
    before = [now[0], now[1].replace("ab12", "cd34"), "random/9: 1 robots, bound 1, 77"]
    assert plan_hashes.differences(before, now) == [
        "random/3: 4 robots, bound 2, cd34 -> random/3: 4 robots, bound 2, ab12",
        "not there before -> random/4: NoPlanFound: why",
    ]


def test_a_plan_has_the_same_hash_in_any_folder(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    assert "examples/swarm-square.yaml" in plan_hashes.names()
    one, other = (plan_hashes.line_of("examples/swarm-square.yaml", at) for at in (tmp_path, tmp_path / "other"))
    assert one == other
    assert one.startswith("examples/swarm-square.yaml: 25 robots, bound None, ")


def test_every_mechanism_of_the_ablation_can_be_left_out() -> None:
    for mechanism in ablation.MECHANISMS:
        for function in mechanism.functions:
            assert callable(ablation._resolve(function)) or function.endswith("EFFORTS"), mechanism.name
        if mechanism.stage:
            assert any(ablation.less(settings, mechanism) != settings for settings in EFFORTS.values()), mechanism.name
    with ablation.without(ablation.MECHANISMS[0], "quick"):
        from rota.planners.patrol.repair import repair

        assert repair.can_bend(None) is False


def test_what_an_ablation_measured_is_put_into_a_table() -> None:
    line = {"mission": "a", "met": True, "robots": 4, "cpu_s": 2.0}
    known = {("a", ""): line, ("a", "detours"): {**line, "robots": 5, "cpu_s": 3.0}}
    told = [row for row in ablation.table(known).splitlines() if row.startswith("| detours ")]
    assert told == ["| detours | 1 | 4 | 5 | 0 | 0 | 2 | 3 |"]
    left = list(ablation.tasks("quick", {("case/Section 5.1", ""): {**line, "acts": {"detours": 1}}}, ["detours"], 7))
    assert ("case/Section 5.1", "quick", "detours") in left


def test_growth_of_many_robots_is_the_slope_of_logarithms() -> None:
    # twice the robots, 2 ** 1.5 times the seconds
    row = many_robots.growth_row([(100 * 2**k, 2 ** (1.5 * k)) for k in range(4)])
    assert row.measured.startswith("exponent 1.50 (CPU: 100 robots 1 s, 200 robots 3 s")
    assert row.reached is False
    assert many_robots.growth_row([(100, 1.0), (None, 5.0)]).reached is False


def test_memory_of_a_command_is_its_own_whatever_this_process_has_had() -> None:
    """On Linux the system's figure of a child begins with what its parent had at most."""
    had = np.ones(40_000_000)
    del had
    small = python("-c", "import time; a = bytearray(b'x') * 30_000_000; time.sleep(0.3)").peak_bytes
    assert 30e6 < small < 200e6


def test_the_missions_that_are_stopped_are_as_large_as_they_are_called(tmp_path: Path) -> None:
    corners = read_mission(write_building(tmp_path)).mission.area
    assert 1300 < shapely.get_num_coordinates(corners) < 1500
    assert read_mission(write_corridor(tmp_path)).mission.area.area == 22_000 * 60
    drones = read_mission(write_drones(tmp_path)).mission
    assert drones.area.area == 34e4
    assert [robot.start for robot in drones.fleet.robots or ()] == [(10, 10), (20, 10), (30, 10)]
    wide = read_mission(write_wide_turns(tmp_path)).mission
    assert wide.fleet.turn_radius_m == 75
    assert 2 * wide.fleet.sensor.radius_m == 50


def test_the_processor_time_after_a_signal_is_what_the_command_used_since() -> None:
    busy = "import signal, time\nsignal.signal(15, lambda *_: None)\nsignal.pause()\n"
    work = "u = time.process_time()\nwhile time.process_time() < u + 0.4: pass"
    told = run([sys.executable, "-c", busy + work], look_after_s=1.5, sends=signal.SIGTERM, patience_s=60)
    assert told.code == 0
    assert told.cpu_s_after is not None
    assert 0.3 < told.cpu_s_after < 0.7
