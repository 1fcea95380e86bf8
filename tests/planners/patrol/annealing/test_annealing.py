"""The annealing: closed forms for its wrapper, and that its books are true after thousands of moves."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely import LineString, Polygon, box

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Sensor, SquareSensor, Zone
from rota.model.motion_limits import MotionLimits
from rota.planners.patrol.annealing import search as searching
from rota.planners.patrol.annealing.chain_kernels import range_m
from rota.planners.patrol.annealing.estimate_kernels import least_loss, note_leg, unseen_near
from rota.planners.patrol.annealing.random_kernels import uniform
from rota.planners.patrol.annealing.search import Annealing
from rota.planners.patrol.annealing.state import Count, Most, Tours
from rota.planners.patrol.annealing.state_kernels import bucket_of, tour_length
from rota.planners.patrol.annealing.turn_kernels import turning_m
from rota.planners.patrol.driving.driving import driving_of
from rota.planners.patrol.driving.polylines import split_legs, turns_rad, without_repeats
from rota.planners.patrol.ground.extra_points import no_points, prepare_with
from rota.planners.patrol.ground.problem import Problem, set_up_problem
from rota.planners.patrol.ground.sample_kernels import Leg, Samples, leg_sees
from rota.planners.patrol.initial.first_tours import place_groups, shared_tour
from rota.planners.patrol.tours.tour import Tour, tour_length_m

Floats = NDArray[np.float64]
ROBOT = Fleet(speed_m_s=2, sensor=DiscSensor(radius_m=3)).equal_robot("r")
SQUARE = np.array([[0.0, 0], [6, 0], [6, 6], [0, 6]])


def tour(vertices_m: object, **fields: object) -> Tour:
    values: dict[str, object] = {"period_class": 0, "period_s": 10.0, "robots": 1, "robot": ROBOT, "component": 0}
    return Tour(vertices_m=np.array(vertices_m, dtype=np.float64), **(values | fields))  # type: ignore[arg-type]


# ---------------------------------------------------------------- the wrapper, in closed form


def test_length_and_turns_of_a_square() -> None:
    assert turns_rad(SQUARE) == pytest.approx(np.full(4, math.pi / 2))
    assert tour_length_m(tour(SQUARE)) == pytest.approx(24)
    # a whole turn at 0.5 rad/s and 2 m/s: 4 m per radian
    turning = replace(ROBOT, turn_rate_rad_s=0.5)
    assert tour_length_m(tour(SQUARE, robot=turning)) == pytest.approx(24 + 4 * 2 * math.pi)


@pytest.mark.parametrize("n", [3, 5, 12, 64])
def test_a_regular_polygon_turns_once_round(n: int) -> None:
    angles = 2 * math.pi * np.arange(n) / n
    ring = 5 * np.column_stack([np.cos(angles), np.sin(angles)])
    assert turns_rad(ring) == pytest.approx(np.full(n, 2 * math.pi / n))
    assert tour_length_m(tour(ring)) == pytest.approx(2 * n * 5 * math.sin(math.pi / n))


def test_tours_of_one_and_two_vertices() -> None:
    assert turns_rad(np.array([[1.0, 2]])).tolist() == [0]
    assert tour_length_m(tour([[1, 2]], robot=replace(ROBOT, turn_rate_rad_s=1))) == 0
    there_and_back = np.array([[0.0, 0], [3, 4]])
    assert turns_rad(there_and_back) == pytest.approx([math.pi, math.pi])
    assert tour_length_m(tour(there_and_back)) == pytest.approx(10)
    assert tour_length_m(tour(there_and_back, robot=replace(ROBOT, turn_rate_rad_s=4))) == pytest.approx(10 + math.pi)


def test_a_star_turns_left_and_right() -> None:
    # turns count whatever their sign: a zigzag of right angles there, and back along the base line
    zigzag = np.array([[0.0, 0], [1, 1], [2, 0], [3, 1], [4, 0]])
    quarter = math.pi / 4
    expected = [3 * quarter, 2 * quarter, 2 * quarter, 2 * quarter, 3 * quarter]
    assert turns_rad(zigzag) == pytest.approx(expected)


def test_budgets() -> None:
    assert tour(SQUARE, robots=3).budget_m == pytest.approx(3 * 10 * 2, rel=2e-6)
    assert tour(SQUARE, robots=3).budget_m < 60  # a little less, so that rounding is never speeding
    assert driving_of(ROBOT).corner_costs.turn_m == 0
    assert driving_of(replace(ROBOT, turn_rate_rad_s=0.5)).corner_costs.turn_m == 4


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ([[0, 0], [0, 0], [1, 0], [1, 0], [1, 0], [1, 1]], [[0, 0], [1, 0], [1, 1]]),
        ([[1, 1], [0, 0], [1, 0], [1, 1]], [[0, 0], [1, 0], [1, 1]]),  # the last one repeats the first
        ([[2, 3], [2, 3]], [[2, 3]]),
        ([[2, 3]], [[2, 3]]),
        ([[0, 0], [1, 0], [0, 0], [1, 1]], [[0, 0], [1, 0], [0, 0], [1, 1]]),  # only neighbours repeat each other
    ],
)
def test_without_repeats(given: list[list[int]], expected: list[list[int]]) -> None:
    kept = without_repeats(np.array(given, dtype=np.float64))
    lists = kept.tolist()
    turned = [lists[k:] + lists[:k] for k in range(len(lists))]
    assert expected in turned  # the same round, begun anywhere


def test_long_legs_are_cut_into_equal_pieces() -> None:
    pieces = split_legs(np.array([[0.0, 0], [10, 0], [10, 1]]), 2.6)
    # 10 m make 4 pieces, 1 m one, and the way back of 10.05 m four
    assert pieces[:5] == pytest.approx(np.array([[0, 0], [2.5, 0], [5, 0], [7.5, 0], [10, 0]]))
    assert len(pieces) == 4 + 1 + 4
    back = np.hypot(*np.diff(np.vstack([pieces[5:], pieces[:1]]), axis=0).T)
    assert back == pytest.approx(np.full(4, math.hypot(10, 1) / 4))
    assert split_legs(SQUARE, 6.1).tolist() == SQUARE.tolist()
    assert split_legs(SQUARE[:1], 1.0).tolist() == SQUARE[:1].tolist()


def test_cutting_keeps_the_line_and_its_length() -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        ring = rng.uniform(0, 50, (int(rng.integers(2, 9)), 2))
        cut = split_legs(ring, 3.0)
        legs = np.hypot(*(np.roll(cut, -1, axis=0) - cut).T)
        assert legs.max() <= 3.0
        assert legs.sum() == pytest.approx(tour_length_m(tour(ring)))
        assert set(map(tuple, ring.tolist())) <= set(map(tuple, cut.tolist()))
        outline = LineString(np.vstack([ring, ring[:1]]))
        assert shapely.distance(shapely.points(cut), outline).max() < 1e-9


@pytest.mark.parametrize(
    ("way", "turn_rad"),
    [
        ([0.0, 0.0, 1.0, 0.0, 1.0, 1.0], math.pi / 2),
        ([0.0, 0.0, 1.0, 0.0, 1.0, -3.0], math.pi / 2),
        ([0.0, 0.0, 1.0, 0.0, 2.0, 0.0], 0),
        ([0.0, 0.0, 1.0, 0.0, 0.0, 0.0], math.pi),
        ([0.0, 0.0, 0.0, 0.0, 1.0, 1.0], 0),  # no direction to turn from
    ],
)
def test_turning_counts_as_metres(way: list[float], turn_rad: float) -> None:
    ax, ay, bx, by, cx, cy = way
    assert turning_m(bx - ax, by - ay, cx - bx, cy - by, 2.0, 0.0) == pytest.approx(2 * turn_rad)


def test_the_random_numbers_are_xorshift64_star() -> None:
    # the generator of Vigna, "An experimental exploration of Marsaglia's xorshift generators", figure 10: 12, 25, 27
    state, mask = 12345, 2**64 - 1
    rng = np.array([state], dtype=np.uint64)
    for _ in range(100):
        state ^= state >> 12
        state ^= (state << 25) & mask
        state ^= state >> 27
        assert uniform(rng) == ((state * 2685821657736338717) & mask) // 2**11 / 2**53
        assert int(rng[0]) == state


# ---------------------------------------------------------------- the state after many moves

OBSTACLES = (
    Obstacle(shape=box(12, 10, 22, 18)),
    Obstacle(shape=Polygon([(28, 24), (36, 26), (30, 34)]), blocks="motion"),
    Obstacle(shape=box(8, 28, 18, 28.4), blocks="sight"),
)
ZONES = (
    Zone(name="often", shape=box(25, 5, 38, 15), period_s=12),
    Zone(name="sometimes", shape=box(2, 20, 10, 36), period_s=25),
    Zone(name="gate", shape=box(34, 34, 39, 39), period_s=18, demand="visit"),
)


def problem(sensor: Sensor = ROBOT.sensor, **turning_and_body: Any) -> Problem:
    fleet = Fleet(speed_m_s=3, sensor=sensor, **turning_and_body)
    return set_up_problem(
        Mission(name="yard", area=box(0, 0, 40, 40), obstacles=OBSTACLES, zones=ZONES, period_s=60, fleet=fleet)
    )


def started(given: Problem, seed: int = 1, budget_penalty: float = 4.0) -> Annealing:
    groups = tuple((c,) for c in range(len(given.periods_s)))
    tours = [shared_tour(given, group) for group in place_groups(given, groups)]
    _, samples = prepare_with(given, no_points())
    return Annealing(
        tours,
        samples,
        given.paths.grid,
        length_weight=np.linspace(0.3, 0.9, len(tours)),
        budget_penalty=np.full(len(tours), budget_penalty),
        seed=seed,
        range_margin_m=given.range_margin_m,
    )


def run(search: Annealing, moves: int) -> None:
    assert search.run(moves, hot_m=2.0, cold_m=0.02, should_stop=lambda: False)


def rings(state: Tours) -> list[list[int]]:
    """The vertices of every tour in their order; both links of each agree."""
    found = []
    for k in range(len(state.n)):
        ring = [int(state.anchor[k])]
        while state.after[ring[-1]] != ring[0]:
            ring.append(int(state.after[ring[-1]]))
        assert len(set(ring)) == len(ring) == state.n[k]
        assert all(state.before[state.after[v]] == v and state.tour[v] == k for v in ring)
        found.append(ring)
    return found


def times_seen(search: Annealing) -> NDArray[np.int64]:
    """By how many legs each sample (n,) is seen, by the binary digits that the state has of it."""
    words = search._state.times_seen
    digits = np.unpackbits(words[:, :, None].view(np.uint8), axis=2, bitorder="little").astype(np.int64)
    worth = [1, 2, 4, 0, *(2**k for k in range(3, words.shape[1] - 1))]
    flat = (digits * np.array(worth)[None, :, None]).sum(axis=1).ravel()
    assert not flat[len(search._samples.x) :].any()
    assert (digits[:, 3] == digits[:, 4:].any(axis=1)).all()  # which samples have digits of eight and more
    return flat[: len(search._samples.x)]


def assert_books_are_true(search: Annealing) -> None:
    """All that the moves keep up to date equals what is counted afresh from the vertices."""
    state, samples = search._state, search._samples
    n = len(samples.x)
    counted = np.zeros(n, dtype=np.int64)
    out = np.empty(2 * n, dtype=np.int32)
    for k, ring in enumerate(rings(state)):
        assert state.length[k] == pytest.approx(tour_length(k, state), abs=1e-6)
        for v in ring:
            w = state.after[v]
            ends = (state.x[v], state.y[v], state.x[w], state.y[w])
            sensor, rest = (state.reach_m[k], state.square[k]), (state.period_class[k], samples, out)
            runs = state.seen[state.slot[v], : state.seen_n[state.slot[v]]]
            if runs.tolist() != out[: leg_sees(Leg(*ends, *sensor), *rest)].tolist():
                # what is seen from the very end of a leg, past a corner that it touches, depends on the direction in
                # which the leg was made
                assert runs.tolist() == out[: leg_sees(Leg(*ends[2:], *ends[:2], *sensor), *rest)].tolist()
            for first, end in runs.reshape(-1, 2):
                counted[first:end] += 1
    assert times_seen(search).tolist() == counted.tolist()
    # the list of the unseen, and where each sample stands in it
    unseen = state.unseen_item[: search.unseen]
    assert sorted(unseen.tolist()) == np.flatnonzero(counted == 0).tolist() == search.unseen_samples.tolist()
    assert state.unseen_place[unseen].tolist() == list(range(search.unseen))
    assert state.unseen[0] == pytest.approx(samples.weight[counted == 0].sum(), abs=1e-6)
    at = [bucket_of(samples.x[i], samples.y[i], state) for i in unseen]
    assert state.unseen_in.tolist() == np.bincount(at, minlength=len(state.bucket)).tolist()
    # every slot is one leg's or free; every vertex is in use or free, and in the bucket of its place
    vertices = [v for ring in rings(state) for v in ring]
    used = state.slot[vertices].tolist()
    left = state.free_slots[: state.ints[Count.SLOTS_LEFT]].tolist()
    assert sorted(used + left) == list(range(len(state.free_slots)))
    assert sorted(state.in_use[: state.ints[Count.VERTICES]].tolist()) == sorted(vertices)
    assert state.place[state.in_use[: len(vertices)]].tolist() == list(range(len(vertices)))
    free = state.free_vertices[: state.ints[Count.VERTICES_LEFT]].tolist()
    assert sorted(vertices + free) == list(range(len(state.x)))
    in_buckets = []
    for bucket in range(len(state.bucket)):
        v = int(state.bucket[bucket])
        while v >= 0:
            assert bucket_of(state.x[v], state.y[v], state) == bucket
            in_buckets.append(v)
            v = int(state.bucket_after[v])
    assert sorted(in_buckets) == sorted(vertices)


def seen_from(state: Tours, samples: Samples, k: int, places: Sequence[tuple[float, float]]) -> NDArray[np.int64]:
    """How often each sample is seen by the legs between these places, as legs of tour k."""
    times = np.zeros(len(samples.x), dtype=np.int64)
    out = np.empty(2 * len(samples.x), dtype=np.int32)
    for a, b in pairwise(places):
        count = leg_sees(Leg(*a, *b, state.reach_m[k], state.square[k]), state.period_class[k], samples, out)
        for first, end in out[:count].reshape(-1, 2):
            times[first:end] += 1
    return times


def assert_legs_are_free(given: Problem, tours: Sequence[Tour]) -> None:
    space = given.space.buffer(1e-7)
    for one in tours:
        ring = np.vstack([one.vertices_m, one.vertices_m[:1]])
        assert space.covers(LineString(ring))


CASES = [
    pytest.param({}, id="disc"),
    pytest.param({"sensor": SquareSensor(side_m=5)}, id="square"),
    pytest.param({"turn_rate_rad_s": 1.0}, id="turning"),
    pytest.param({"turn_radius_m": 0.7}, id="arcs"),
    pytest.param({"body_radius_m": 0.4}, id="body"),
    pytest.param({"sensor": SquareSensor(side_m=5), "turn_rate_rad_s": 2.0, "body_radius_m": 0.3}, id="all"),
]


@pytest.mark.parametrize("case", CASES)
def test_the_books_are_true_after_many_moves(case: dict[str, object]) -> None:
    given = problem(**case)  # type: ignore[arg-type]
    assert len(given.periods_s) == 4
    search = started(given)
    assert len(search.tours) >= 4
    assert len({one.period_class for one in search.tours}) == 4
    assert_books_are_true(search)
    for moves in (1, 10, 1000, 10_000):
        run(search, moves)
        assert_books_are_true(search)
        assert_legs_are_free(given, search.tours)
    assert search._state.ints[Count.ACCEPTED] > 1000  # moves were accepted
    search.see_more(2000)
    assert_books_are_true(search)
    assert_legs_are_free(given, search.tours)


@pytest.mark.parametrize("limits", [{"corner_m": 0.5}, {"corner_m": 0.4, "corner_acceleration_m_s2": 4.0}, {}])
def test_lengths_of_robots_with_mass_are_those_of_their_rounds(limits: dict[str, float]) -> None:
    # estimates: what a move changes farther than six vertices from it is left out; searches correct for that
    search = started(problem(motion=MotionLimits(acceleration_m_s2=2.0, **limits)))  # type: ignore[arg-type]
    for moves in (100, 5_000):
        run(search, moves)
        kept_m, exact_m = search._state.length.copy(), [tour_length_m(one) for one in search.tours]
        assert kept_m == pytest.approx(exact_m, rel=0.03)  # measured: 1.4 %
        afresh_m = [tour_length(k, search._state) for k in range(len(exact_m))]
        assert afresh_m == pytest.approx(exact_m, rel=0.02)  # measured: 0.8 %
    assert search._state.ints[Count.ACCEPTED] > 500


@pytest.mark.parametrize("case", CASES)
def test_moves_gain_no_more_and_lose_no_less_than_is_estimated(case: dict[str, object]) -> None:
    given = problem(**case)  # type: ignore[arg-type]
    search = started(given)
    run(search, 5000)
    state, samples, rng = search._state, search._samples, np.random.default_rng(5)
    lost, estimated = 0.0, 0.0
    vertices, times = rings(state), times_seen(search)
    for _ in range(120):
        k = int(rng.integers(len(state.n)))
        p = int(rng.choice(vertices[k]))
        v, q = int(state.after[p]), int(state.after[state.after[p]])
        x, y = rng.normal((state.x[v], state.y[v]), rng.choice([0.3, 3.0]))
        a, b, c = ((float(state.x[u]), float(state.y[u])) for u in (p, v, q))
        old, new = (seen_from(state, samples, k, [a, middle, c]) for middle in (b, (x, y)))
        gained_m = samples.weight[(times == 0) & (new > 0)].sum()
        box_m = (min(a[0], c[0], x), min(a[1], c[1], y), max(a[0], c[0], x), max(a[1], c[1], y))
        assert gained_m <= unseen_near(*box_m, state) <= state.unseen[0] + 1e-6
        note_leg(np.int64(0), *a, x, y, state)
        note_leg(np.int64(1), x, y, *c, state)
        slots = {int(state.slot[p]), int(state.slot[v])}
        estimate = [least_loss(s, np.int64(2), range_m(k, state), math.inf, samples, state) for s in slots]
        lost_m = samples.weight[(times == old) & (old > 0) & (new == 0)].sum()
        assert sum(estimate) <= lost_m + 1e-9
        lost, estimated = lost + lost_m, estimated + sum(estimate)
    assert estimated > 0.1 * lost > 0  # an estimate of nothing would be no lie either


def test_the_books_are_true_where_much_is_unseen() -> None:
    # so coverage_weight that tours shrink to points and nearly everything is unseen, then so cheap that they grow again
    given = problem()
    search = started(given)
    search._state.length_weight[:] = 50.0
    run(search, 20_000)
    assert_books_are_true(search)
    assert search.unseen > len(given.points) / 2
    search._state.length_weight[:] = 0.01
    run(search, 20_000)
    assert_books_are_true(search)
    assert_legs_are_free(given, search.tours)
    assert search.unseen < len(given.points) / 10


def test_what_a_tour_may_not_serve_it_does_not_count() -> None:
    given = problem()
    search = started(given)
    run(search, 5000)
    state = search._state
    for k, ring in enumerate(rings(state)):
        for slot in state.slot[ring]:
            for first, end in state.seen[slot, : state.seen_n[slot]].reshape(-1, 2):
                assert (given.points.period[first:end] >= state.period_class[k]).all()


def test_tours_of_one_vertex_grow_and_are_counted() -> None:
    given = problem()
    _, samples = prepare_with(given, no_points())
    alone = [
        tour([[5, 5]], robot=given.robot, period_s=60),
        tour([[30, 20]], robot=given.robot, period_s=60, period_class=1),
    ]
    search = Annealing(
        alone, samples, given.paths.grid, length_weight=np.full(2, 0.1), budget_penalty=np.full(2, 1.0), seed=5,
        range_margin_m=given.range_margin_m,
    )  # fmt: skip
    assert_books_are_true(search)
    before = search.unseen
    run(search, 20_000)
    assert_books_are_true(search)
    assert_legs_are_free(given, search.tours)
    assert search.unseen < before / 2


def test_samples_that_hundreds_of_legs_see_are_counted() -> None:
    given = problem()
    _, samples = prepare_with(given, no_points())
    rng = np.random.default_rng(3)
    heap = [tour(rng.uniform(2, 9, (8, 2)), robot=given.robot, period_s=60) for _ in range(40)]
    search = Annealing(
        heap, samples, given.paths.grid, length_weight=np.full(40, 0.1), budget_penalty=np.full(40, 1.0), seed=5,
        range_margin_m=given.range_margin_m,
    )  # fmt: skip
    assert times_seen(search).max() > 2**8
    assert_books_are_true(search)
    run(search, 20_000)
    assert_books_are_true(search)
    assert times_seen(search).max() < 2**7  # most have gone elsewhere, and their digits with them


def test_the_same_seed_gives_the_same_tours() -> None:
    given = problem()
    runs = []
    for seed in (7, 7, 8):
        search = started(given, seed=seed)
        run(search, 10_000)
        runs.append([one.vertices_m.tolist() for one in search.tours])
    assert runs[0] == runs[1]
    assert runs[0] != runs[2]


def test_a_price_on_vertices_leaves_fewer_of_them_while_tours_are_hot() -> None:
    given = problem(ROBOT.sensor)
    vertices = []
    for price in (0.0, 2.0):
        search = started(given)
        search.run(20_000, hot_m=2.0, cold_m=1.0, should_stop=lambda: False, vertex_price=price)
        assert_books_are_true(search)
        assert search._state.most[Most.VERTEX] == 0  # what bends legs later on pays nothing
        vertices.append(int(search._state.ints[Count.VERTICES]))
    assert vertices[1] < 0.8 * vertices[0]


def test_the_run_may_be_cut_into_chunks_or_stopped() -> None:
    given = problem()
    asked: list[bool] = []
    search = started(given)
    before = [one.vertices_m.tolist() for one in search.tours]
    assert not search.run(50_000, hot_m=1, cold_m=0.1, should_stop=lambda: not asked.append(True))
    assert asked == [True]
    assert [one.vertices_m.tolist() for one in search.tours] == before
    told: list[int] = []
    assert search.run(50_000, hot_m=1, cold_m=0.1, should_stop=lambda: False, done=told.append)
    assert sum(told) == 50_000


def test_mending_loses_nothing_that_was_seen() -> None:
    given = problem()
    search = started(given, budget_penalty=0.0)
    run(search, 3000)
    before = set(search.unseen_samples.tolist())
    assert before  # at this price something is left to mend
    weight = search._state.unseen[0]
    search.see_more(5000)
    assert search._state.unseen[0] < weight
    assert_books_are_true(search)


def test_mending_asks_on_the_way_whether_to_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    """In however many parts the tries are made, the outcome is the same."""
    given, outcomes = problem(), []
    for together, most_asked in ((5000, 1000), (30, 1000), (30, 2)):
        monkeypatch.setattr(searching, "BENDS", together)
        search, asked = started(given, budget_penalty=0.0), itertools.count()
        run(search, 3000)
        left = search.unseen
        search.see_more(5000, lambda asked=asked, most=most_asked: next(asked) == most)  # type: ignore[misc]
        outcomes.append([one.vertices_m.tolist() for one in search.tours])
    assert outcomes[0] == outcomes[1] != outcomes[2]
    assert 0 < search.unseen <= left


def test_how_far_from_done_is_what_the_books_say() -> None:
    given = problem()
    search = started(given)
    assert search.unseen_share == 0  # the first tours see everything
    run(search, 3000)
    seen = np.zeros(len(search._samples.x), dtype=bool)
    state = search._state
    for ring in rings(state):
        for slot in state.slot[ring]:
            for first, end in state.seen[slot, : state.seen_n[slot]].reshape(-1, 2):
                seen[first:end] = True
    weight = search._samples.weight
    assert search.unseen_share == pytest.approx(weight[~seen].sum() / weight.sum())
    excess = [tour_length_m(one) / one.budget_m - 1 for one in search.tours]
    assert search.over_budget_share == pytest.approx(max(0.0, *excess))


def test_arcs_cost_a_circle_more_where_legs_are_too_short_for_a_turn() -> None:
    # the kernel and the tour's length agree, and say in closed form what a square costs whose sides are half as long as
    # its right angles need: half a circle more at each
    arcs = replace(ROBOT, turn_radius_m=2.0)
    square = [[0, 0], [2, 0], [2, 2], [0, 2]]
    arcs_m = (1 - 2 / math.pi) * 2 * 2 * math.pi
    assert tour_length_m(tour(square, robot=arcs)) == pytest.approx(8 + arcs_m + 4 * math.pi * 2)
    assert turning_m(2.0, 0.0, 0.0, 2.0, 1.0, 2.0) == pytest.approx(2.5 * math.pi)
    wide = [[0, 0], [4, 0], [4, 4], [0, 4]]
    assert tour_length_m(tour(wide, robot=arcs)) == pytest.approx(16 + arcs_m)
    assert turning_m(4.0, 0.0, 0.0, 4.0, 1.0, 2.0) == pytest.approx(math.pi / 2)
