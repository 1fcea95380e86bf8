"""The equations of Sections 2.1 and 4.2 by hand, and what their swarms come to."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.sun_tables import TABLE_2
from scipy import stats
from shapely import MultiPolygon, box

from rota.errors import MissionError
from rota_studies.sun2019_method import rule_kernels, swarm_kernels, update_kernels
from rota_studies.sun2019_method.ccpso2 import (
    Evolution,
    evolve,
    fitness,
    group_starts,
    inertia_at,
    neighbourhood,
)
from rota_studies.sun2019_method.deploy import DeploySettings
from rota_studies.sun2019_method.rule_kernels import Group, MovementLaw, Terrain
from rota_studies.sun2019_method.swarm_kernels import Particles, Swarms
from rota_studies.sun2019_method.update_kernels import VelocityLaw
from rota_studies.sun2019_stages.cells import cells_of, ground_for, lattice_over
from rota_studies.sun2019_stages.zones import CoverTask, cover_tasks

BOX = np.array([0.0, 0.0, 100.0, 100.0])
WEIGHTS = (1000.0, 100.0, 10.0, 1.0)
FEW = replace(DeploySettings(), iterations=12, particles=8)


def random_numbers(seed: int = 1) -> np.ndarray:
    return np.array([seed * 0x9E3779B97F4A7C15 % 2**64], dtype=np.uint64)


def particles(sees: list[list[list[int]]], flags: float = 1.0) -> Particles:
    """Particles whose sensors see the cells given; each sensor's x tells it apart from all others."""
    count, n = len(sees), len(sees[0])
    place = np.zeros((count, n, 3))
    place[:, :, 0] = np.arange(count * n).reshape(count, n) / 100
    place[:, :, 2] = flags
    seen, seen_n = np.zeros((count, n, 8), dtype=np.int32), np.zeros((count, n), dtype=np.int64)
    for i in range(count):
        for d in range(n):
            seen_n[i, d] = len(sees[i][d])
            seen[i, d, : len(sees[i][d])] = sees[i][d]
    return Particles(place, seen, seen_n, np.zeros((count, n), dtype=np.int64))


def swarms(now: list[list[list[int]]], starts: list[int], cells: int) -> Swarms:
    n, count = len(now[0]), len(now)
    return Swarms(
        now=particles(now), best=particles([[[]] * n] * count), context=particles([[[]] * n]),
        velocity=np.zeros((count, n, 3)), order=np.arange(n), group_start=np.array(starts),
        best_fitness=np.zeros((count, len(starts) - 1)), times=np.zeros(cells, dtype=np.int32),
        counts=np.zeros(4, dtype=np.int64), weights=np.array(WEIGHTS),
        bare_start=np.zeros(len(starts), dtype=np.int64), bare_item=np.zeros(2 * cells, dtype=np.int64),
    )  # fmt: skip


def sensors_at(*xy: tuple[float, float], flags: list[float] | None = None) -> np.ndarray:
    """(n, 3) sensors at places in metres in the box of 100 m."""
    p = np.ones((len(xy), 3))
    p[:, :2] = np.array(xy) / 100
    if flags is not None:
        p[:, 2] = flags
    return p


def first_of(count: int) -> Group:
    """The first sensors as one group."""
    return Group(np.arange(count), 0, count)


# ---------------------------------------------------------------- the equations


def test_eq_1_one_swarm_keeps_the_best_of_each_particle_and_of_all() -> None:
    s = swarms([[[0, 1]], [[0, 1, 2]], [[3]]], [0, 1], cells=4)
    swarm_kernels.begin(s)
    s.now.seen_n[2, 0], s.now.place[2, 0, 0] = 0, 0.9  # worse than it was
    s.now.seen[0, 0, :4], s.now.seen_n[0, 0], s.now.place[0, 0, 0] = [0, 1, 2, 3], 4, 0.7  # better
    assert swarm_kernels.judge(s) == 10.0  # one sensor that sees all four cells
    assert s.best_fitness[:, 0].tolist() == [10.0, 110.0, 310.0]
    assert s.best.place[:, 0, 0].tolist() == [0.7, 0.01, 0.02]
    assert s.context.place[0, 0, 0] == 0.7


def test_eq_2_velocity_by_hand_and_its_limits() -> None:
    # 0.9 * 0.02 + 2 * 0.25 * (0.4 - 0.3) + 2 * 0.1 * (0.5 - 0.3) = 0.018 + 0.05 + 0.04
    given = (0.02, 0.3, 0.4, 0.5, 0.25, 0.1)
    law = VelocityLaw(inertia=0.9, c1=2.0, c2=2.0, least=-1.0, most=1.0)
    assert update_kernels.velocity_now(*given, law) == pytest.approx(0.108)
    assert update_kernels.velocity_now(*given, law._replace(least=-0.1, most=0.1)) == 0.1
    assert update_kernels.velocity_now(*given, law._replace(most=0.05)) == 0.05


def test_eq_3_samples_round_either_best_by_hand() -> None:
    assert update_kernels.sample(0.4, 0.6, True, 0.5) == pytest.approx(0.4 + 0.5 * 0.2)
    assert update_kernels.sample(0.4, 0.6, False, -1.5) == pytest.approx(0.6 - 1.5 * 0.2)
    assert update_kernels.sample(0.4, 0.4, True, 30.0) == 0.4


@pytest.mark.parametrize(("draw", "law"), [("cauchy_draw", stats.cauchy), ("normal_draw", stats.norm)])
def test_eq_3_draws_follow_their_laws(draw: str, law: stats.rv_continuous) -> None:
    rng = random_numbers(5)
    values = [getattr(update_kernels, draw)(rng) for _ in range(4000)]
    assert stats.kstest(values, law.cdf).pvalue > 0.01


def test_eq_4_best_of_the_ring_s_neighbourhood() -> None:
    best = np.array([[5.0], [9.0], [7.0], [8.0], [2.0], [6.0]])
    nearest = [swarm_kernels.best_neighbour(i, 0, 1, best) for i in range(6)]
    assert nearest == [0, 0, 2, 4, 4, 4]
    assert [swarm_kernels.best_neighbour(i, 0, 2, best) for i in range(6)] == [4, 0, 4, 4, 4, 4]
    assert [swarm_kernels.best_neighbour(i, 0, 99, best) for i in range(6)] == [4] * 6


def test_eqs_5_and_6_a_particle_is_judged_in_the_place_of_its_swarm() -> None:
    # context: particle 0, which sees 0, 1 | 2 and costs 20 + 3 * 100; each part of particle 1 is better in its place
    s = swarms([[[0, 1], [2]], [[0, 1, 3], [2, 4, 5]]], [0, 1, 2], cells=6)
    s.now.place[1, 0, 2] = s.now.place[1, 1, 2] = 0.0  # undeployed, so that particle 0 begins as the context
    s.now.seen_n[1] = 0
    swarm_kernels.begin(s)
    assert s.counts.tolist() == [0, 3, 2, 0]
    s.now.place[1, :, 2] = 1.0
    s.now.seen_n[1] = 3
    # swarm 0: b(0, x_1) sees 0, 1, 3, 2: 20 + 200; then swarm 1, in the new context: 0, 1, 3, 2, 4, 5: 20
    assert swarm_kernels.judge(s) == 20.0
    assert s.best_fitness.tolist() == [[320.0, 220.0], [220.0, 20.0]]
    assert s.context.place[0, :, 0].tolist() == [0.02, 0.03]
    assert s.times.tolist() == [1, 1, 1, 1, 1, 1]
    assert [s.bare_item[a:b].tolist() for a, b in ((0, s.bare_start[0]), s.bare_start[:2], s.bare_start[1:])] == [
        [],
        [0, 1, 3],
        [2, 4, 5],
    ]


def test_eq_7_addition_deploys_a_free_sensor_near_the_cell() -> None:
    task = open_task(100.0, 4.0)
    terrain = Terrain(BOX, task.cells.table, task.ground)
    for seed in range(1, 20):
        p = sensors_at((10, 10), (90, 90), (50, 50), flags=[1.0, 0.0, 0.0])
        d = rule_kernels.add_sensor(p, first_of(3), 30.0, 40.0, 8.0, terrain, random_numbers(seed))
        assert d in (1, 2)
        assert p[d, 2] == 1.0
        assert math.hypot(p[d, 0] * 100 - 30, p[d, 1] * 100 - 40) <= 8.0
    p = sensors_at((10, 10), (90, 90))
    before = p.copy()
    assert rule_kernels.add_sensor(p, first_of(2), 30.0, 40.0, 8.0, terrain, random_numbers()) == -1
    assert (p == before).all()


def test_eq_8_movement_leads_the_nearest_sensor_a_short_way_to_the_cell() -> None:
    p = sensors_at((10, 10), (40, 40), (70, 40))
    group, law = first_of(3), MovementLaw(around_m=25.0, step_m=5.0, in_range_m=8.0)
    # the cell is 22 m from sensor 1, in range within 8 m: 14 m are needed, and 5 m are allowed
    d = rule_kernels.move_sensor(p, group, 40.0, 62.0, law, BOX, random_numbers())
    assert d == 1
    assert (p[:, :2] * 100).tolist() == pytest.approx(np.array([[10, 10], [40, 45], [70, 40]]))
    # now 3 m are needed, for which up to 30 % more are gone
    d = rule_kernels.move_sensor(p, group, 40.0, 56.0, law, BOX, random_numbers())
    assert d == 1
    assert 48.0 <= p[1, 1] * 100 <= 48.9
    assert rule_kernels.move_sensor(p, group, 5.0, 90.0, law, BOX, random_numbers()) == -1


def test_eq_9_deletion_withdraws_a_sensor_nearer_than_r_s_to_another_of_the_best() -> None:
    context = sensors_at((10, 10), (14, 10), (50, 50), (50, 57), flags=[1, 1, 1, 0])
    p = context.copy()
    p[3, 2] = 1.0
    assert rule_kernels.delete_sensor(p, context, Group(np.arange(4), 2, 4), 5.0, BOX) == -1  # 7 m apart
    assert rule_kernels.delete_sensor(p, context, first_of(2), 4.0, BOX) == -1  # 4 m is not less
    assert rule_kernels.delete_sensor(p, context, first_of(2), 5.0, BOX) == 0
    assert p[:, 2].tolist() == [0, 1, 1, 1]


def test_eq_10_fusion_puts_one_sensor_midway() -> None:
    p = sensors_at((10, 10), (50, 50), (16, 18), (80, 80))
    both = rule_kernels.fuse_sensors(p, first_of(4), 10.5, BOX, random_numbers())
    kept, gone = divmod(both, 4)
    assert {kept, gone} == {0, 2}
    assert (p[kept] * 100)[:2].tolist() == pytest.approx([13, 14])
    assert p[gone, 2] == 0.0
    assert p[[1, 3], 2].tolist() == [1.0, 1.0]
    far = sensors_at((10, 10), (16, 18))
    assert rule_kernels.fuse_sensors(far, first_of(2), 10.0, BOX, random_numbers()) == -1  # 10 m is not less


def test_eq_11_by_hand() -> None:
    assert fitness(2, 3, 5, 7, (1000.0, 100.0, 10.0, 1.0)) == 2000 + 300 + 50 + 7


def test_what_eq_11_counts() -> None:
    # cells 0 and 1 are seen twice, 3 by nobody; the fourth sensor stands in an obstacle, the fifth is not deployed
    s = swarms([[[0, 1], [0, 1, 2], [1], [], []]], [0, 5], cells=4)
    s.now.off[0, 3] = 1
    s.now.place[0, 4, 2] = 0.49
    swarm_kernels.begin(s)
    assert s.counts.tolist() == [1, 1, 4, 2]
    assert s.times.tolist() == [2, 3, 1, 0]


def test_inertia_falls_and_the_neighbourhood_grows() -> None:
    assert inertia_at(0, TABLE_2) == 0.9
    assert inertia_at(149, TABLE_2) == pytest.approx(0.4)
    assert inertia_at(74, TABLE_2) + inertia_at(75, TABLE_2) == pytest.approx(1.3)
    reach = [neighbourhood(t, TABLE_2) for t in range(150)]
    assert (reach[0], reach[-1]) == (1, 25)
    assert reach == sorted(reach)


def test_swarms_of_s_sensors() -> None:
    assert group_starts(10, 5).tolist() == [0, 5, 10]
    assert group_starts(11, 5).tolist() == [0, 5, 10, 11]
    assert group_starts(3, 8).tolist() == [0, 3]


def test_near_groups_take_a_seed_and_those_nearest_to_it() -> None:
    place = sensors_at((0, 0), (50, 50), (1, 0), (51, 50), (2, 0), (60, 50))
    order = swarm_kernels.near_groups(place, BOX, np.array([3, 0, 1, 2, 4, 5]), 2)
    assert order.tolist() == [3, 1, 0, 2, 4, 5]


# ---------------------------------------------------------------- the whole


def open_task(side_m: float, cell_m: float, reach_m: float = 10.0) -> CoverTask:
    """An empty square to cover."""
    region = MultiPolygon([box(0, 0, side_m, side_m)])
    nothing = MultiPolygon()
    cells = cells_of(region, lattice_over(region, cell_m), hidden=nothing, border="clipped")
    tasks, left = cover_tasks(cells, (region,), (ground_for(region, nothing, reach_m),))
    assert len(left) == 0
    return tasks[0]


def covered(task: CoverTask, found: Evolution) -> tuple[int, int]:
    """Cells that no sensor sees and cells that several see, counted without any kernel."""
    times = np.zeros(len(task.cells), dtype=int)
    corners = np.array([[[x, y] for x in (0, 1) for y in (0, 1)]]) * task.cells.lattice.cell_m
    low = np.column_stack([task.cells.square % task.cells.lattice.nx, task.cells.square // task.cells.lattice.nx])
    corners = corners.reshape(1, 4, 2) + low[:, None] * task.cells.lattice.cell_m
    for place in found.positions_m:
        times += (np.linalg.norm(corners - place, axis=2) <= task.ground.reach_m).all(axis=1)
    return int((times == 0).sum()), int((times > 1).sum())


def test_the_history_ends_with_what_is_deployed() -> None:
    task = open_task(30.0, 2.5)
    found = evolve(task, FEW, sensors=12, seed=np.random.SeedSequence(4))
    assert found.counts.shape == (13, 4)
    assert (np.diff(found.cost) <= 0).all()
    in_obstacles, uncovered, sensors, overlapped = found.counts[-1]
    assert (in_obstacles, sensors) == (0, len(found.positions_m))
    assert covered(task, found) == (uncovered, overlapped)
    assert found.cost[-1] == fitness(0, uncovered, sensors, overlapped, FEW.weights)


def test_four_discs_cover_a_square_and_the_swarms_find_it() -> None:
    # a square of 22 m: four discs of 10 m can (one over each quarter, half a diagonal of 7.8 m), three cannot: the
    # least radius for three is sqrt(65) / 16 of the side, 11.1 m (Heppes and Melissen 1997)
    found = evolve(open_task(22.0, 2.2), replace(FEW, iterations=40), sensors=9, seed=np.random.SeedSequence(1))
    assert found.counts[-1].tolist()[:3] == [0, 0, 4]


def test_same_seed_same_sensors_on_any_number_of_threads() -> None:
    task = open_task(40.0, 4.0)
    one, three, again = (
        evolve(task, FEW, sensors=14, seed=np.random.SeedSequence(9), threads=threads) for threads in (1, 3, 3)
    )
    other = evolve(task, FEW, sensors=14, seed=np.random.SeedSequence(10), threads=3)
    assert one.positions_m.tolist() == three.positions_m.tolist() == again.positions_m.tolist()
    assert one.counts.tolist() == three.counts.tolist()
    assert one.positions_m.tolist() != other.positions_m.tolist()


def test_rules_cover_sooner_and_with_fewer_sensors() -> None:
    task = open_task(60.0, 3.0)
    settings = replace(FEW, iterations=30, particles=16)
    with_rules, without = (
        evolve(task, chosen, sensors=30, seed=np.random.SeedSequence(2))
        for chosen in (settings, settings.without_rules())
    )
    assert with_rules.cost[-1] < without.cost[-1]
    assert with_rules.counts[-1][2] < without.counts[-1][2]


@pytest.mark.parametrize("rule", ["addition", "movement", "deletion", "fusion"])
def test_each_rule_alone_makes_a_difference(rule: str) -> None:
    task = open_task(40.0, 4.0)
    none = FEW.without_rules()
    # half of the sensors suffice, so that all of them get deployed and some come near each other
    runs = [
        evolve(task, chosen, sensors=7, seed=np.random.SeedSequence(3)).counts.tolist()
        for chosen in (none, replace(none, **{rule: True}))
    ]
    assert runs[0] != runs[1]


def test_particles_follow_by_velocity_alone_or_by_sampling_alone() -> None:
    task = open_task(40.0, 4.0)
    costs = [
        evolve(
            task, replace(FEW.without_rules(), velocity_probability=q), sensors=14, seed=np.random.SeedSequence(3)
        ).cost
        for q in (0.0, 1.0)
    ]
    assert costs[0][0] == costs[1][0]
    assert costs[0].tolist() != costs[1].tolist()
    assert all(cost[-1] < cost[0] for cost in costs)


# ---------------------------------------------------------------- settings


def test_table_2_as_printed() -> None:
    printed = ("iterations", "swarms", "particles", "sensors_max", "velocity_min", "velocity_max", "inertia_max",
               "inertia_min", "c1", "c2")  # fmt: skip
    assert [getattr(TABLE_2, name) for name in printed] == [150, 30, 50, 160, -0.1, 0.1, 0.9, 0.4, 2, 2]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"method": "magic"}, 'sensors.method: "magic" is not allowed; ccpso2, greedy or exact is needed'),
        ({"cell_m": 0.0}, r"sensors\.cell_m: 0 is not allowed; it must be greater than 0"),
        ({"iterations": 0}, "sensors.iterations: 0 is not allowed; it must be at least 1"),
        ({"sensors_max": 0}, "sensors.sensors_max: 0"),
        ({"group_sizes": ()}, r"sensors.group_sizes: \[\] is not allowed; it must not be empty"),
        ({"group_sizes": (4, 10.5)}, r"sensors\.group_sizes\[1\]: 10\.5 is not allowed; a whole number is needed"),
        ({"weight_overlapped": 10.0}, "weight_overlapped: 10 is not allowed; it must be less than weight_sensor, 10"),
        ({"rule_probability": 1.5}, r"sensors\.rule_probability: 1\.5 is not allowed; it must be at most 1"),
        ({"velocity_min": 0.2}, "sensors.velocity_min"),
    ],
)
def test_wrong_settings_are_refused(wrong: dict, message: str) -> None:
    with pytest.raises(MissionError, match=message):
        replace(DeploySettings(), **wrong)
