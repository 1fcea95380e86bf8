"""Timing that keeps bodies apart: phases, directions and waits, against distances simulated in small steps."""

import math

import numpy as np
import pytest
from tests.planners.patrol.traffic.bodies.driving import BODY_M, closest_at_any_phase_m, closest_m, fastest_m_s, tour

from rota.planners.patrol.tours.tour import Tour
from rota.planners.patrol.traffic.bodies.loops import clocks, crowds, loop_of
from rota.planners.patrol.traffic.bodies.phases import phases_apart
from rota.planners.patrol.traffic.bodies.timing import crowds_that_touch, timed_rounds
from rota.planners.patrol.traffic.bodies.waits import waits_apart

# two pairs of star-shaped loops, drawn at random, that cross each other many times; and a period for each
TANGLES = [
    (
        [(4, 8), (5, 8), (3, 5), (3, 3), (5, 6), (8, 2)],
        [(6, 6), (8, 2), (8, 1), (4, 8), (5, 3), (5, 4)],
        29.0,
    ),
    (
        [(8, 1), (5, 3), (2, 3), (4, 6), (7, 0), (2, 5)],
        [(1, 9), (7, 0), (5, 5), (0, 2), (1, 4), (5, 4)],
        44.0,
    ),
]


def circle_tour(x: float, radius_m: float, period_s: float, robots: int = 1) -> Tour:
    angle = np.linspace(0, 2 * math.pi, 24, endpoint=False)
    ring = np.column_stack([x + radius_m * np.cos(angle), radius_m * np.sin(angle)])
    return tour([(float(x), float(y)) for x, y in ring], period_s, robots)


@pytest.mark.parametrize("periods", [(40.0, 40.0), (40.0, 80.0), (40.0, 100.0)])
def test_loops_that_cross_never_bring_bodies_together(periods: tuple[float, float]) -> None:
    tours = [circle_tour(0, 5, periods[0]), circle_tour(6, 5, periods[1])]
    rounds = timed_rounds(tours, BODY_M)
    for (times, *_), period in zip(rounds, periods, strict=True):
        assert times[-1] <= period
    ratio = rounds[1][0][-1] / rounds[0][0][-1]
    assert ratio * 12 == pytest.approx(round(ratio * 12), abs=1e-9)  # a simple ratio: the phases hold for ever
    assert closest_m(rounds, 12 * periods[1]) >= 2 * BODY_M


def test_robots_that_share_a_loop_and_cross_another() -> None:
    rounds = timed_rounds([circle_tour(0, 5, 20.0, robots=2), circle_tour(6, 5, 40.0)], BODY_M)
    assert len(rounds) == 3
    assert closest_m(rounds, 400) >= 2 * BODY_M


@pytest.mark.parametrize("body_m", [0.0, BODY_M])
def test_nobody_waits_for_those_it_never_comes_near(body_m: float) -> None:
    far_m = 6 if body_m == 0 else 12
    (times, *_), _ = timed_rounds([circle_tour(0, 5, 40.0), circle_tour(far_m, 5, 40.0)], body_m)
    assert times[-1] == pytest.approx(2 * 24 * 5 * math.sin(math.pi / 24), rel=1e-5)  # the 24-gon at full speed


def test_groups_are_those_whose_lines_come_near_each_other() -> None:
    # the third is near the second, which is near the first; the fourth and a robot that stays are near each other only
    tours = [circle_tour(x, 2, 40.0) for x in (0, 4.5, 9, 30)] + [tour([(32.5, 0)], 40.0)]
    assert crowds([loop_of(one) for one in tours], 2 * BODY_M) == [[0, 1, 2], [3, 4]]


def test_headways_are_multiples_of_one_unit_within_the_periods() -> None:
    tours = [circle_tour(0, 5, 8.0 * 5), circle_tour(6, 5, 20.0 * 5), circle_tour(9, 5, 40.0 * 5, robots=2)]
    found = clocks([loop_of(one) for one in tours])
    assert found
    for clock in found:
        for one, multiple in zip(tours, clock.multiples, strict=True):
            assert loop_of(one).natural_s <= one.robots * multiple * clock.unit_s <= one.robots * one.period_s


def test_headways_are_chosen_for_their_great_common_measure() -> None:
    # rounds of 31 and 63 s within 45 and 100 s: driven in 45 and 90 s they meet in phases modulo 45 s, in 45 and 100 s
    # modulo 5 s only
    tours = [circle_tour(0, 5, 45.0), circle_tour(6, 10, 100.0)]
    clock = clocks([loop_of(one) for one in tours])[0]
    headways = [multiple * clock.unit_s for multiple in clock.multiples]
    assert headways == pytest.approx([45.0, 90.0], rel=1e-5)


def test_a_ring_that_two_robots_go_round_in_opposite_directions_is_turned() -> None:
    ring = [(0, 0), (10, 0), (10, 8), (0, 8)]
    tours = [tour(ring, 36.5), tour(ring[::-1], 36.5)]
    assert closest_at_any_phase_m(tours[0].vertices_m, tours[1].vertices_m, 36.5).max() < 0.1  # whatever the phase
    rounds = timed_rounds(tours, BODY_M)
    assert closest_m(rounds, 365) >= 2 * BODY_M
    assert fastest_m_s(rounds) <= 1


@pytest.mark.parametrize(("one", "other", "period_s"), TANGLES)
def test_waits_help_where_no_phase_does(
    one: list[tuple[float, float]], other: list[tuple[float, float]], period_s: float
) -> None:
    tours = [tour(one, period_s), tour(other, period_s)]
    first, second = (np.array(line, float) for line in (one, other))
    for line in (second, second[::-1]):
        # driven evenly they touch at every phase: on a grid of 0.05 s distances are a tenth of a metre off at most
        assert closest_at_any_phase_m(first, line, period_s).max() < 2 * BODY_M - 0.1
    loops = [loop_of(each) for each in tours]
    assert all(phases_apart(loops, clock, BODY_M) is None for clock in clocks(loops))
    rounds = timed_rounds(tours, BODY_M)
    assert [float(times[-1]) for times, *_ in rounds] == pytest.approx([period_s] * 2, rel=1e-5)
    assert closest_m(rounds, 4 * period_s) >= 2 * BODY_M
    assert fastest_m_s(rounds) <= 1
    for (_, places, _), line in zip(rounds, (first, second), strict=True):
        legs = np.vstack([line, line[:1]])
        length = float(np.hypot(*np.diff(legs, axis=0).T).sum())
        assert float(np.hypot(*np.diff(places, axis=0).T).sum()) == pytest.approx(length, abs=1e-6)


def test_robots_that_share_a_loop_wait_for_each_other_where_it_crosses_itself() -> None:
    # a figure of eight whose lobes take as long as each other: evenly spaced robots meet in the middle at every round
    eight = [(0, 0), (6, 3), (6, -3), (0, 0), (-6, 3), (-6, -3)]
    one = tour(eight, 24.0, robots=2)
    loop = loop_of(one)
    moments = np.arange(0, 48, 0.01)
    at = [np.interp(moments % 48, loop.line.times_s * 48 / loop.natural_s, loop.places_m[:, axis]) for axis in (0, 1)]
    assert np.hypot(*(np.column_stack(at) - np.roll(np.column_stack(at), 2400, axis=0)).T).min() < 0.1
    rounds = timed_rounds([one], BODY_M)
    assert closest_m(rounds, 480) >= 2 * BODY_M
    assert fastest_m_s(rounds) <= 1
    # the second is where the first is, one headway later
    half = float(rounds[0][0][-1]) / 2
    assert half <= 24.0
    late = [np.interp((moments + half) % (2 * half), *(rounds[0][0], rounds[0][1][:, axis])) for axis in (0, 1)]
    second = [np.interp(moments % (2 * half), rounds[1][0], rounds[1][1][:, axis]) for axis in (0, 1)]
    assert np.abs(np.array(late) - np.array(second)).max() < 1e-6


def test_waits_keep_turning_times() -> None:
    one, other, _ = TANGLES[0]
    tours = [tour(one, 60.0, turn=2.0), tour(other, 60.0, turn=2.0)]
    loops = [loop_of(each) for each in tours]
    found = waits_apart(loops, clocks(loops)[0], BODY_M)
    assert found is not None
    for loop, timed in zip(loops, found, strict=True):
        stands = np.diff(timed.line.times_s)[(np.diff(timed.line.places_m, axis=0) == 0).all(axis=1)]
        turns = np.diff(loop.line.times_s)[(np.diff(loop.places_m, axis=0) == 0).all(axis=1)]
        assert len(stands) >= len(turns)
        assert stands.sum() >= turns.sum() - 1e-9


def test_what_no_timing_can_do_is_said_so() -> None:
    # two robots share a line there and back: they must pass each other somewhere on it
    shared = [tour([(0, 0), (20, 0)], 30.0, robots=2)]
    assert crowds_that_touch(shared, BODY_M) == [[0]]
    assert crowds_that_touch([tour([(0, 0), (20, 0)], 60.0), tour([(10, 0)], 60.0)], BODY_M) == [[0, 1]]
    assert crowds_that_touch(shared, 0.0) == []
    assert len(timed_rounds(shared, BODY_M)) == 2
