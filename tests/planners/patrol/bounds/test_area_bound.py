"""The proved number of robots against the published cases, closed forms and plans that are known to do."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapely import box

from rota.files.mission_file import read_mission
from rota.geometry.free_space import demanded_regions
from rota.model.mission import DiscSensor, Fleet, Mission, Robot, Sensor, SquareSensor, Zone
from rota.planners.patrol.bounds.area_bound import area_rate_bound
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.bounds.strongest_robot import footprint_m2, strongest_robot, sweep_m2_s
from rota.planners.patrol.ground.problem import set_up_problem

EXAMPLES = Path(__file__).parents[4] / "examples"

# Sun et al. 2019: periods of zones 1, 2, 3 in seconds (section 5.1, then Table 6, cases 1 to 6), and the paper's robots
CASES = {
    (8, 20, 40): 5,
    (12, 10, 40): 5,
    (12, 20, 30): 5,
    (12, 7, 40): 7,
    (12, 10, 20): 8,
    (8, 10, 20): 9,
    (12, 10, 10): 11,
}
# areas of figure 13 by hand: 30 x 35, 45 x 45, and 120 x 120 less both and less two obstacles of 30 x 25
FIG13_M2 = (1050.0, 2025.0, 9825.0)


def disc_robot(radius_m: float, speed_m_s: float) -> Robot:
    return Fleet(speed_m_s=speed_m_s, sensor=DiscSensor(radius_m=radius_m)).equal_robot("r")


def with_periods(mission: Mission, periods_s: tuple[float, float, float]) -> Mission:
    zones = tuple(replace(zone, period_s=t) for zone, t in zip(mission.zones, periods_s[:2], strict=True))
    return replace(mission, zones=zones, period_s=periods_s[2])


def bound_of_ground(mission: Mission) -> int:
    regions = demanded_regions(mission)
    areas, periods = [r.shape.area for r in regions], [r.period_s for r in regions]
    return area_rate_bound(areas, periods, strongest_robot(mission.fleet))


def test_the_cases_of_table_6() -> None:
    mission = read_mission(EXAMPLES / "sun2019-fig13.yaml").mission
    regions = demanded_regions(mission)
    assert [region.shape.area for region in regions] == pytest.approx(FIG13_M2)
    bounds = [bound_of_ground(with_periods(mission, periods)) for periods in CASES]
    assert bounds == [3, 3, 3, 3, 4, 4, 7]
    assert sum(bounds) == 27
    assert all(bound <= paper for bound, paper in zip(bounds, CASES.values(), strict=True))


def test_what_a_robot_holds_is_what_sets_the_bound_apart_from_the_sweep_rate() -> None:
    # without the held term every case asks for sum A / T over 2 r V = 200 m2/s: the practical floor
    floors = [math.ceil(sum(a / t for a, t in zip(FIG13_M2, periods, strict=True)) / 200) for periods in CASES]
    assert sum(floors) == 29
    bounds = [area_rate_bound(FIG13_M2, periods, disc_robot(5, 20)) for periods in CASES]
    assert [floor - bound for floor, bound in zip(floors, bounds, strict=True)].count(0) == 5


@pytest.mark.parametrize(("name", "bound"), [("sun2019-fig13", 3), ("sun2019-fig16", 4)])
def test_the_planner_proves_the_published_bound(name: str, bound: int) -> None:
    mission = read_mission(EXAMPLES / f"{name}.yaml").mission
    assert bound_of_ground(mission) == bound
    assert prove_bound(set_up_problem(mission)).robots == bound


def test_by_hand() -> None:
    robot = disc_robot(1, 2)  # sweeps 4 m2/s, holds pi
    assert sweep_m2_s(robot) == 4
    assert footprint_m2(robot) == pytest.approx(math.pi)
    # 100 m2 in 10 s: 10 / (4 + 0.314) = 2.3
    assert area_rate_bound([100], [10], robot) == 3
    # two periods: at mu = 1/5 (20 + 10) / 4.628 = 6.5, at mu = 1/10 (10 + 10) / 4.314 = 4.6
    assert area_rate_bound([100, 100], [5, 10], robot) == 7
    # a small quick zone must not hide what the slow one asks: mu = 1/100 gives 10.01 / 4.03, mu = 1 gives 11 / 7.1
    assert area_rate_bound([1, 1000], [1, 100], robot) == 3
    # standing still is enough for a footprint, and not for a little more
    assert area_rate_bound([math.pi], [1e-9], robot) == 1
    assert area_rate_bound([math.pi * 1.001], [1e-9], robot) == 2
    # exactly 2 robots: rounding must not make it 3
    assert area_rate_bound([2 * (4 * 7 + math.pi)], [7], robot) == 2


def test_nothing_asked_and_hardly_anything_asked() -> None:
    robot = disc_robot(1, 1)
    assert area_rate_bound([], [], robot) == 0
    assert area_rate_bound([0.0, 0.0], [5, 10], robot) == 0
    assert area_rate_bound([1e-12], [1e6], robot) == 1


def test_a_square_sweeps_most_along_its_diagonal() -> None:
    robot = Fleet(speed_m_s=3, sensor=SquareSensor(side_m=2)).equal_robot("r")
    # what a leg at an angle sweeps is the footprint's width across it: brute force over headings
    angles = np.linspace(0, math.pi, 100_001)
    widths = 2 * (np.abs(np.cos(angles)) + np.abs(np.sin(angles)))
    assert sweep_m2_s(robot) == pytest.approx(3 * widths.max())
    assert footprint_m2(robot) == 4
    # 1000 m2 in 20 s: 50 / (8.485 + 0.2) = 5.76
    assert area_rate_bound([1000], [20], robot) == 6


def test_the_worst_window_has_the_length_of_a_period() -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        k = int(rng.integers(1, 5))
        areas, periods = rng.uniform(1, 1000, k), rng.uniform(1, 100, k)
        robot = disc_robot(float(rng.uniform(0.5, 5)), float(rng.uniform(0.5, 5)))
        mu = np.geomspace(1e-4, 1e3, 20_001)
        rate = (areas[:, None] * np.minimum(1 / periods[:, None], mu)).sum(axis=0)
        brute = (rate / (sweep_m2_s(robot) + footprint_m2(robot) * mu)).max()
        bound = area_rate_bound(areas.tolist(), periods.tolist(), robot)
        assert brute <= bound < brute + 1 + 0.01 * brute  # the grid may miss the top by a little


def test_never_above_robots_that_follow_each_other_round_a_ring() -> None:
    # k robots on a circle of radius R >= r see the ring of area 4 pi R r once per 2 pi R / (k V)
    rng = np.random.default_rng(5)
    for _ in range(200):
        k = int(rng.integers(1, 12))
        r, speed = rng.uniform(0.5, 5, 2)
        ring = r * rng.uniform(1, 20)
        area, period = 4 * math.pi * ring * r, 2 * math.pi * ring / (k * speed)
        assert 1 <= area_rate_bound([area], [period], disc_robot(r, speed)) <= k
    # with a long way round, what they hold hardly matters and the bound is tight
    assert area_rate_bound([4 * math.pi * 500], [2 * math.pi * 500 / 5], disc_robot(1, 1)) == 5


def test_never_above_robots_that_stand_side_by_side() -> None:
    for n in range(1, 8):
        side = n * math.sqrt(2)  # n x n unit discs, each round a square of side sqrt 2
        for period in (1e-6, 1e-3, 1.0, 1e3):
            assert area_rate_bound([side**2], [period], disc_robot(1, 1)) <= n * n
        square = Fleet(speed_m_s=1, sensor=SquareSensor(side_m=2)).equal_robot("r")
        assert area_rate_bound([(2 * n) ** 2], [1e-9], square) == n * n


def test_never_above_a_square_that_goes_to_and_fro_along_a_diagonal() -> None:
    # it sees a band of width sqrt(2) a: A = a^2 + sqrt(2) a L after L metres one way, and is back at the end after 2 L
    a, speed = 2.0, 3.0
    robot = Fleet(speed_m_s=speed, sensor=SquareSensor(side_m=a)).equal_robot("r")
    for length in (0.1, 1.0, 10.0, 1000.0):
        area = a * a + math.sqrt(2) * a * length
        assert area_rate_bound([area], [2 * length / speed], robot) == 1
        # nobody can do it in less than one way: the bound is exact there
        assert area_rate_bound([area], [length / speed], robot) == 1
        assert area_rate_bound([1.001 * area], [length / speed], robot) == 2


@pytest.mark.parametrize(
    ("sensors", "expected"),
    [
        ((DiscSensor(radius_m=2), DiscSensor(radius_m=5)), DiscSensor(radius_m=5)),
        ((SquareSensor(side_m=4), SquareSensor(side_m=3)), SquareSensor(side_m=4)),
        # no disc smaller than the one round the square holds both
        ((DiscSensor(radius_m=2), SquareSensor(side_m=4)), DiscSensor(radius_m=4 / math.sqrt(2))),
        ((DiscSensor(radius_m=3), SquareSensor(side_m=4)), DiscSensor(radius_m=3)),
    ],
)
def test_the_bound_of_a_mixed_fleet_is_that_of_its_strongest(sensors: tuple[Sensor, Sensor], expected: Sensor) -> None:
    robots = tuple(Robot(name=f"r{i}", speed_m_s=1 + i, sensor=sensor) for i, sensor in enumerate(sensors))
    fleet = Fleet(speed_m_s=9, sensor=DiscSensor(radius_m=9), robots=robots)
    strongest = strongest_robot(fleet)
    assert strongest.speed_m_s == 2  # the fleet's common values are nobody's here
    assert type(strongest.sensor) is type(expected)
    assert strongest.sensor.reach_m == pytest.approx(expected.reach_m)
    for robot in fleet.robots or ():
        assert sweep_m2_s(strongest) >= sweep_m2_s(robot) * (1 - 1e-12)
        assert footprint_m2(strongest) >= footprint_m2(robot) - 1e-12


def test_a_slow_robot_does_not_lower_the_bound() -> None:
    quick, slow = disc_robot(5, 20), replace(disc_robot(1, 0.1), name="slow")
    mixed = Fleet(speed_m_s=20, sensor=DiscSensor(radius_m=5), robots=(quick, slow))
    assert area_rate_bound(FIG13_M2, (8, 20, 40), strongest_robot(mixed)) == 3


def test_only_what_can_be_seen_counts() -> None:
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=5))
    # 40 x 40 less a 20 x 20 block: 1200 m2 in 30 s at 10 + 2.6 m2/s = 3.2; with the block it would be 4.2
    block = Mission(name="block", area=box(0, 0, 40, 40).difference(box(10, 10, 30, 30)), period_s=30, fleet=fleet)
    assert prove_bound(set_up_problem(block)).robots == 4
    assert prove_bound(set_up_problem(replace(block, area=box(0, 0, 40, 40)))).robots == 5
    # a zone of 20 x 40 where nothing is asked leaves 800 m2: 2.1
    quiet = Zone(name="quiet", shape=box(0, 0, 20, 40), period_s=None)
    assert prove_bound(set_up_problem(replace(block, area=box(0, 0, 40, 40), zones=(quiet,)))).robots == 3
    # a visit sweeps nothing, and still asks for a robot
    visit = Zone(name="yard", shape=box(0, 0, 40, 40), period_s=5, demand="visit")
    assert prove_bound(set_up_problem(replace(block, zones=(visit,), period_s=None))).robots <= 1
