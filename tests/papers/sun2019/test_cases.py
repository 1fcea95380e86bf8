"""Tables 5, 6 and 8: the paper's routes beside those of the runs."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from shapely import box

from rota.check import check_plan
from rota.check.revisits import worst_gaps_s
from rota.compare import MethodOutcome
from rota.mission import DiscSensor, Fleet, Mission, Zone
from rota.papers.sun2019 import paper
from rota.papers.sun2019.cases import Case, case_of, gaps_table, loop_times, robots_table, routes_table
from rota.papers.sun2019.figure_14 import figure_14_section
from rota.papers.sun2019.result_figures import figure_13_section
from rota.papers.sun2019.runs import Runs
from rota.plan import Plan, Trajectory


@pytest.fixture
def case(make_runs: Callable[..., Runs], without_search: list[Mission]) -> Case:
    runs = make_runs()
    return case_of(runs, paper.TABLE_5, runs.map_13, runs.settings.figure_13)


def changed(case: Case, **outcomes: MethodOutcome) -> Case:
    return replace(case, outcomes={**case.outcomes, **outcomes})


def times(cell: str) -> list[float]:
    found = []
    for told in [] if cell == "–" else cell.split(", "):
        found.append(float(told.partition(" ")[0]))
    return found


def test_robots_are_counted_for_each_way(case: Case) -> None:
    (row,) = robots_table("robots", [case]).rows
    segments = sum(len(partition.first) for partition in case.printed.stages.partitions)
    late = sum(float(t) >= float(p) for one in case.printed.stages.partitions
               for t, p in zip(one.times_s, one.periods_s, strict=True))  # fmt: skip
    robots = len(case.outcomes["tours"].plan.trajectories)
    assert row[:4] == ("Section 5.1", "8, 20, 40", "5", f"{segments}" + (f", {late} late" if late else ""))
    assert row[4:] == (*[f"{robots}, not met"] * 6, "–")


def test_several_cases_are_added_up(case: Case) -> None:
    tours = case.outcomes["tours"]
    proved = changed(case, tours=replace(tours, plan=replace(tours.plan, lower_bound_robots=3), reason=None))
    none = replace(changed(case, tours=replace(tours, plan=None, report=None)), paper=paper.TABLE_6[5])
    *rows, total = robots_table("robots", [proved, proved, none]).rows
    segments, robots = len(case.printed.stages.segments), len(tours.plan.trajectories)
    assert [row[9:] for row in rows] == [(str(robots), "3"), (str(robots), "3"), ("no plan", "–")]
    assert rows[2][2] == "11, 4 late"
    assert total == ("together", "", "21", str(3 * segments), *[str(3 * robots)] * 5, "–", "–")


def test_worst_shares_and_what_is_unseen(case: Case) -> None:
    (row,) = gaps_table("gaps", [case]).rows
    assert row[1] == "0.940"  # 18.81 of 20 s
    shares = [t / p for one in case.printed.stages.partitions for t, p in zip(one.times_s, one.periods_s, strict=True)]
    assert row[2] == f"{max(shares):.3f}"
    unseen_m2 = sum(demand.unseen_area_m2 for demand in check_plan(case.printed.plan).demands)
    assert float(row[3].replace(",", "")) == pytest.approx(unseen_m2, abs=0.5)
    # gaps of many points at random, told with their periods: about as many are late as the table has
    points_m = np.random.default_rng(0).uniform(0, 120, (4000, 2))
    gaps_s = worst_gaps_s(case.printed.plan, points_m)
    periods_s = np.full(len(points_m), 40.0)
    for (left, bottom, right, top), period_s in (((15, 15, 60, 60), 20), ((70, 70, 100, 105), 8)):
        x, y = points_m.T
        periods_s[(x >= left) & (x <= right) & (y >= bottom) & (y <= top)] = period_s
    walls = [(20, 75, 50, 100), (75, 20, 105, 45)]
    x, y = points_m.T
    free = ~np.any([(x > a) & (x < c) & (y > b) & (y < d) for a, b, c, d in walls], axis=0)
    late_m2 = 120 * 120 * np.mean(free & np.isfinite(gaps_s) & (gaps_s > periods_s))
    assert late_m2 > 100
    assert float(row[4].replace(",", "")) == pytest.approx(late_m2, rel=0.15)
    assert unseen_m2 > 0
    assert row[5:] == ("never",) * 6


def test_every_route_is_told_once_with_its_zone(case: Case) -> None:
    rows = routes_table("routes", [case]).rows
    assert [row[:3] for row in rows] == [
        ("zone 1", "8.00", "6.75, 7.19"), ("zone 2", "20.00", "18.81"), ("rest", "40.00", "36.37, 37.29"),
    ]  # fmt: skip
    segments = case.printed.stages.segments
    # Eq. 26: every segment's time stands in its zone's row
    for row, period_s in zip(rows, (8, 20, 40), strict=True):
        told = sorted(times(row[3]))
        assert told == pytest.approx(sorted(s.time_s for s in segments if s.period_s == period_s), abs=0.006)
        assert row[3].count("(late)") == sum(s.time_s >= period_s for s in segments if s.period_s == period_s)
    driven = sorted(np.round([t.loop_duration_s for t in case.printed.plan.trajectories], 2).tolist())
    # the plan is the same here; what takes longer than its segment's period is told with a longer one
    assert sorted(time_s for row in rows for time_s in times(row[4])) == driven


def test_loops_belong_to_the_zone_whose_period_they_keep() -> None:
    fleet = Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=5))
    gate = Zone(name="gate", shape=box(0, 0, 30, 30), period_s=8)
    mission = Mission(name="yard", area=box(0, 0, 100, 30), zones=(gate,), period_s=40, fleet=fleet)

    def loop(robot: str, left_m: float, right_m: float, begin: int = 0) -> Trajectory:
        ring = np.array([(left_m, 5), (right_m, 5), (right_m, 25), (left_m, 25)], dtype=float)
        ring = np.roll(ring, -begin, axis=0)[[0, 1, 2, 3, 0]]
        times_s = np.append(0, np.cumsum(np.hypot(*np.diff(ring, axis=0).T))) / 10
        return Trajectory(robot=robot, times_s=times_s, positions_m=ring)

    def times_of(*trajectories: Trajectory) -> tuple[list[str], list[str]]:
        plan = Plan(mission=mission, trajectories=trajectories)
        return loop_times(plan, "gate"), loop_times(plan, "area")

    # 2 x (20 + 10) m in 6 s; two on 2 x (20 + 25) m in 9 s, every 4.5 s; 2 x (20 + 60) m in 16 s, too long for the gate
    alone, first, second = loop("a", 10, 20), loop("b", 5, 30), loop("c", 5, 30, begin=2)
    assert times_of(alone, loop("d", 36, 96)) == (["6.00"], ["16.00"])
    assert times_of(first, second, loop("d", 36, 96)) == (["9.00 / 2"], ["16.00"])
    # two on 2 x (20 + 65) m in 17 s come by every 8.5 s: too seldom for the gate that they pass
    assert times_of(loop("e", 20, 85), loop("f", 20, 85, begin=2)) == ([], ["17.00 / 2"])
    assert loop_times(None, "gate") == []


def test_the_papers_odd_route_is_told_with_sub_region_3(make_runs, without_search: list[Mission]) -> None:
    runs = make_runs()
    odd = case_of(runs, paper.TABLE_6[3], runs.maps_14[3], runs.settings.figure_13)
    rows = routes_table("routes", [odd, odd]).rows
    assert [row[3] for row in rows[:3]] == ["10.95", "9.33, 8.74, 6.35", "18.48, 18.83, 18.92, 18.65"]
    assert [row[0] for row in rows] == ["Case 4", "", "", "Case 4", "", ""]
    assert [*odd.outcomes] == ["mended", "sequential", "parallel", "decomposition", "sun2019", "tours"]


def test_the_texts_tell_the_numbers_of_the_run(make_runs, without_search: list[Mission], case: Case) -> None:
    section = figure_13_section(make_runs())
    frame = case.printed.stages.framed.parts[0].frame
    assert f"{frame.tour_length:,.2f} long, {frame.length_m:,.2f} of it way" in section.ours
    assert f"{len(case.printed.stages.framed.deployment.positions_m)} sensors (" in section.ours
    assert f"{case.unseen_m2:,.0f} m²" in section.ours
    assert "61,025.99 is 6 crossings and 1,025.99 of way, where its text has 1,027.40" in section.ours
    assert [picture.file for picture in section.pictures] == ["sun2019-figure-13.png", "sun2019-figure-13-plans.png"]


def test_figure_14_has_the_cases_of_table_6(
    make_runs: Callable[..., Runs], without_search: list[Mission], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(paper, "TABLE_6", (paper.TABLE_6[3], paper.TABLE_6[5]))
    section = figure_14_section(make_runs())
    robots, gaps, routes, readings = section.tables
    assert robots.head == (
        "case", "periods s", "paper", "Eq. 26", "mended", "sequential", "parallel", "decomposition", "sun2019", "tours",
        "lower bound",
    )  # fmt: skip
    assert [row[:3] for row in robots.rows] == [
        ("Case 4", "12, 10, 20", "8"), ("Case 6", "12, 10, 10", "11, 4 late"), ("together", "", "19"),
    ]  # fmt: skip
    assert len(gaps.rows) == 2
    assert len(routes.rows) == 6
    assert "8 and 11 robots" in section.paper
    assert "but 4 of Case 6" in section.paper
    assert "the paper 19" in section.ours
    assert re.search(r"sun2019 \d+ \(0 of 2 cases met\)", section.ours)
    assert [mission.name for mission in without_search] == ["sun2019-12-10-20"] * 5 + ["sun2019-12-10-10"] * 5
    assert [picture.file for picture in section.pictures] == ["sun2019-figure-14.png", "sun2019-figure-14-mended.png"]
    # the paper, its swarms, and two readings of legs with four weights; sums are of Section 5.1 and the two cases
    assert readings.head[1:5] == ("5.1", "C4", "C6", "5.3")
    assert readings.rows[0][1:] == ("5", "8", "11, 4 late", "7", "24, 4 late", "")
    assert len(readings.rows) == 10
    for row in readings.rows[2:]:
        robots_of = [int(cell.partition(",")[0]) for cell in row[1:6]]
        assert sum(robots_of[:3]) == robots_of[4]
    assert {verdict.outcome for verdict in section.verdicts} <= {"holds", "bettered", "does not hold", "cannot be told"}
