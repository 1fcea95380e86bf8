"""News of free ground: how much of the ground and of discs lies round the places of the map."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota.planners.swarm.free_ground_kernels import FREE_BELOW, HELD_FROM, load_with_all, pass_on_distances
from rota.planners.swarm.place_graph import place_graph_of
from rota.planners.swarm.sorted_robots import have_arrived, room_for
from rota.planners.swarm.world import kinds_of, walls_of

KINDS, _ = kinds_of(1, body_m=0.0, sensor_m=10.0, speed_m_s=1.0, neighbour_range_m=20.0, wall_range_m=10.0)


def test_ground_round_places_is_all_of_a_disc_in_the_open_half_at_a_wall_and_a_quarter_in_a_corner() -> None:
    graph = place_graph_of(walls_of(MultiPolygon([box(0, 0, 100, 100)])), KINDS)
    x, y = graph.x, graph.y
    to_x, to_y = np.minimum(x, 100 - x), np.minimum(y, 100 - y)
    assert graph.capacity[(to_x > 20) & (to_y > 20)] == pytest.approx(1.0, abs=0.01)
    # places stand 2.5 m from walls; the integral of the cone over what is left there, by quadrature
    u, v = np.meshgrid(np.arange(-20, 20, 0.05) + 0.025, np.arange(-20, 20, 0.05) + 0.025)
    cone = np.maximum(1 - np.hypot(u, v) / 20, 0)
    beside, corner = cone[u > -2.5].sum() / cone.sum(), cone[(u > -2.5) & (v > -2.5)].sum() / cone.sum()
    assert graph.capacity[(to_x < 5) & (to_y > 20)] == pytest.approx(beside, abs=0.01)
    assert graph.capacity[(to_x < 5) & (to_y < 5)] == pytest.approx(corner, abs=0.01)


def test_places_are_free_with_few_discs_round_them_and_change_by_more_than_a_little() -> None:
    graph = place_graph_of(walls_of(MultiPolygon([box(0, 0, 100, 100)])), KINDS)
    robots = room_for(1, 1)
    robots.kind[:] = robots.name[:] = 0
    robots.x[:], robots.y[:] = 50.0, 50.0
    load_with_all(robots, KINDS, graph)
    away = np.hypot(graph.x - 50, graph.y - 50)
    expected = 0.75 * np.maximum(1 - away / 20, 0)  # the cone of the volume of a disc of 10 m
    assert graph.load == pytest.approx(expected)
    pass_on_distances(0, graph)
    free = graph.away_m[1] == 0
    assert (free == (expected < FREE_BELOW * graph.capacity)).all()
    graph.load[:] = 0.5 * (FREE_BELOW + HELD_FROM) * graph.capacity  # between the two each place stays what it was
    pass_on_distances(1, graph)
    assert ((graph.away_m[0] == 0) == free).all()
    graph.load[:] = HELD_FROM * graph.capacity
    pass_on_distances(2, graph)
    assert (graph.away_m[1] > 0).all()


def test_news_of_free_ground_are_waited_for_and_news_of_ground_that_is_taken_are_not() -> None:
    graph = place_graph_of(walls_of(MultiPolygon([box(0, 0, 200, 20)])), KINDS)
    graph.load[:] = HELD_FROM * graph.capacity
    graph.away_m[0] = graph.x  # as if all ground were free beyond the left end, where it has just been taken
    assert have_arrived(0, graph)
    last = int(np.argmax(graph.x))
    graph.load[last] = 0.0
    steps = 0
    while steps == 0 or not have_arrived(steps, graph):
        pass_on_distances(steps, graph)
        steps += 1
        assert steps <= graph.news_steps
    assert steps > 10
    assert graph.away_m[steps % 2] == pytest.approx(graph.x[last] - graph.x, abs=20.0)
