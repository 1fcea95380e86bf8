"""Plans on lanes, judged by the check: closed forms, brute force over small graphs, and teams that are too small."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import pytest
import shapely
from shapely import LineString, MultiPolygon, Point
from tests.seeds import seeds

from rota import make_plan
from rota.check import check_plan
from rota.errors import NoPlanFound
from rota.model.mission import DiscSensor, Fleet, Lane, Mission, Zone
from rota.model.plan import Plan
from rota.model.polygons import polygons_of
from rota.planners.patrol.cycles.teams import Share
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.route_graph.network import calls_of, network_of
from rota.planners.patrol.route_graph.plan_on_graph import lines_in_step, plain_shares, with_spare_robots

Place = tuple[float, float]


def mission_on(
    lanes: Sequence[Lane], periods_s: dict[Place, float], robots: int | None = None, body_m: float = 0.0
) -> Mission:
    zones = tuple(
        Zone(name=f"{x:g} {y:g}", period_s=s, demand="visit", shape=MultiPolygon([Point(x, y).buffer(0.2)]))
        for (x, y), s in periods_s.items()
    )
    area = polygons_of(shapely.union_all([LineString(lane.line_m).buffer(1.0) for lane in lanes]))
    fleet = Fleet(robots=robots or "fewest", speed_m_s=1.0, sensor=DiscSensor(radius_m=1), body_radius_m=body_m)
    return Mission(
        name="lanes", area=area, zones=zones, lanes=tuple(lanes), fleet=fleet, planning=PatrolSettings(effort="quick")
    )


def ring(corners: int, *, one_way: bool) -> list[Lane]:
    """A polygon with sides of 10 m."""
    radius = 5 / math.sin(math.pi / corners)
    at = [(radius * math.cos(a), radius * math.sin(a)) for a in np.arange(corners) * 2 * math.pi / corners]
    return [Lane(line_m=(at[k], at[(k + 1) % corners]), one_way=one_way) for k in range(corners)]


def met(plan: Plan) -> int:
    assert check_plan(plan).verdict == "met"
    return len(plan)


@pytest.mark.parametrize(("period_s", "robots"), [(60.1, 1), (59.9, 2), (30.1, 2), (15.1, 4)])
def test_round_a_one_way_ring_robots_follow_each_other(period_s: float, robots: int) -> None:
    lanes = ring(6, one_way=True)
    assert met(make_plan(mission_on(lanes, {lane.line_m[0]: period_s for lane in lanes}), seed=0)) == robots


def test_one_way_lanes_cost_the_way_round() -> None:
    """Two neighbours on a ring of 60 m: 20 s there and back, but 60 s where the ring runs one way."""
    for one_way, robots in ((False, 1), (True, 2)):
        lanes = ring(6, one_way=one_way)
        periods_s = {lanes[0].line_m[0]: 25.0, lanes[0].line_m[1]: 25.0}
        assert met(make_plan(mission_on(lanes, periods_s), seed=0)) == robots


def test_a_slow_lane_takes_its_time() -> None:
    ends: tuple[Place, Place] = (0.0, 0.0), (10.0, 0.0)
    for least_s, robots in ((None, 1), (20.0, 2)):
        lanes = [Lane(line_m=ends, least_s=least_s)]
        assert met(make_plan(mission_on(lanes, dict.fromkeys(ends, 21.0)), seed=0)) == robots


def test_a_hub_between_three_posts_is_served_by_one_robot() -> None:
    """A B A C A D: the hub every 20 s, the posts every 60 s."""
    posts: list[Place] = [(10.0, 0.0), (0.0, 10.0), (-10.0, 0.0)]
    lanes = [Lane(line_m=((0.0, 0.0), post)) for post in posts]
    plan = make_plan(mission_on(lanes, {(0.0, 0.0): 20.1, **dict.fromkeys(posts, 60.1)}), seed=0)
    assert (met(plan), plan.lower_bound_robots) == (1, 1)


def random_lanes(seed: int) -> tuple[list[Lane], list[Place]]:
    """Five places, a ring of lanes through them, and some more."""
    random = np.random.default_rng(seed)
    places = [(float(x), float(y)) for x, y in random.uniform(0, 30, (5, 2))]
    pairs = [(k, (k + 1) % 5) for k in range(5)]
    pairs += [pair for pair in itertools.combinations(range(5), 2) if pair not in pairs and random.random() < 0.3]
    return [Lane(line_m=(places[a], places[b]), one_way=bool(random.random() < 0.4)) for a, b in pairs], places


def ways_s(lanes: Sequence[Lane], places: Sequence[Place]) -> np.ndarray:
    """The fastest ways by Floyd and Warshall."""
    way = np.where(np.eye(len(places)) > 0, 0.0, np.inf)
    for lane in lanes:
        a, b = (places.index(end) for end in lane.ends_m)
        way[a, b] = min(way[a, b], lane.drawn_m)
        if not lane.one_way:
            way[b, a] = min(way[b, a], lane.drawn_m)
    for k in range(len(places)):
        way = np.minimum(way, way[:, [k]] + way[[k]])
    return way


@pytest.mark.parametrize("seed", seeds(12, at_once=4))
def test_no_sharing_of_few_places_takes_fewer_robots_with_rounds_of_each_once(seed: int) -> None:
    lanes, places = random_lanes(seed)
    way_s = ways_s(lanes, places)
    period_s = np.random.default_rng(seed + 100).uniform(15, 80, 5)

    def robots_for(part: list[int]) -> float:
        rounds = (sum(way_s[a, b] for a, b in itertools.pairwise((*o, o[0]))) for o in itertools.permutations(part))
        return max(1, np.ceil(min(rounds) / period_s[part].min()))

    fewest = min(
        sum(robots_for([k for k in range(5) if labels[k] == part]) for part in set(labels))
        for labels in itertools.product(range(5), repeat=5)
    )
    assert sum(share.robots for share in plain_shares(way_s, period_s, moves=20_000, seed=0)) == fewest
    plan = make_plan(mission_on(lanes, dict(zip(places, period_s.tolist(), strict=True))), seed=0)
    assert (plan.lower_bound_robots or 0) <= met(plan) <= fewest


def test_a_team_that_is_too_small_has_the_plan_that_is_late_by_the_least_share() -> None:
    lanes = ring(6, one_way=True)
    with pytest.raises(NoPlanFound, match="with 2 robots") as failure:
        make_plan(mission_on(lanes, {lane.line_m[0]: 15.0 for lane in lanes}, robots=2), seed=0)
    assert isinstance(failure.value.best, Plan)
    worst_s = max(demand.worst_gap_s for demand in check_plan(failure.value.best).demands)
    assert worst_s == pytest.approx(30.0 - 2 * 0.2, abs=0.01)  # it is there for 0.4 s


def test_robots_to_spare_join_a_round() -> None:
    lanes = ring(6, one_way=True)
    plan = make_plan(mission_on(lanes, {lane.line_m[0]: 61.0 for lane in lanes}, robots=3), seed=0)
    assert met(plan) == 3
    assert max(demand.worst_gap_s for demand in check_plan(plan).demands) == pytest.approx(20.0 - 2 * 0.2, abs=0.01)


def test_a_robot_to_spare_goes_along_with_one_that_keeps_step() -> None:
    lanes = [Lane(line_m=((0.0, 0.0), (10.0, 0.0)))]
    network = network_of(mission_on(lanes, {(0.0, 0.0): 30.0, (10.0, 0.0): 30.0}), 1.0)
    calls = calls_of(mission_on(lanes, {(0.0, 0.0): 30.0, (10.0, 0.0): 30.0}), network)
    share = Share(np.array([0, 1]), 1, 24.0, 24.0, np.array([2.0, 13.0]))
    (whole,) = with_spare_robots([share], 2)
    first, second = lines_in_step(network, calls, whole)
    assert (first.duration_s, first.times_s.tolist()) == (second.duration_s, second.times_s.tolist())
    assert first.duration_s == pytest.approx(24.0)


def test_parts_without_ways_between_them_have_robots_of_their_own() -> None:
    lanes = [Lane(line_m=((x, 0.0), (x + 5.0, 0.0))) for x in (0.0, 20.0, 40.0)]
    plan = make_plan(mission_on(lanes, {end: 100.0 for lane in lanes for end in lane.ends_m}), seed=0)
    assert (met(plan), plan.lower_bound_robots) == (3, 3)


def test_a_zone_in_which_no_lane_ends_is_told() -> None:
    with pytest.raises(NoPlanFound, match="zone 5 0: no lane ends in it"):
        make_plan(mission_on([Lane(line_m=((0.0, 0.0), (10.0, 0.0)))], {(5.0, 0.0): 100.0}), seed=0)


def test_a_lane_that_ends_where_it_began_has_one_place_to_come_to() -> None:
    lanes = [Lane(line_m=((0.0, 0.0), (10.0, 0.0), (5.0, 8.0), (0.0, 0.0)))]
    assert met(make_plan(mission_on(lanes, {(0.0, 0.0): 100.0}), seed=0)) == 1
    with pytest.raises(NoPlanFound, match="zone 5 8: no lane ends in it"):
        make_plan(mission_on(lanes, {(5.0, 8.0): 100.0}), seed=0)


def grid(side: int, random: np.random.Generator) -> list[Lane]:
    """Crossings 10 m apart, side by side, with lanes between them of which some run one way."""
    ends = [
        ((10.0 * i, 10.0 * j), (10.0 * a, 10.0 * b))
        for i, j in itertools.product(range(side), repeat=2)
        for a, b in ((i + 1, j), (i, j + 1))
        if max(a, b) < side
    ]
    return [Lane(line_m=pair if random.random() < 0.5 else pair[::-1], one_way=random.random() < 0.3) for pair in ends]


@pytest.mark.parametrize("seed", seeds(3, at_once=1))
def test_bodies_wait_for_each_other_where_lanes_are_shared(seed: int) -> None:
    lanes = grid(4, np.random.default_rng(seed))
    periods_s = dict.fromkeys(sorted({end for lane in lanes for end in lane.ends_m}), 50.0)
    bodiless, bodies = (make_plan(mission_on(lanes, periods_s, body_m=body_m), seed=0) for body_m in (0.0, 0.4))
    assert met(bodies) == met(bodiless) > 2


def test_bodies_that_meet_all_the_same_are_told() -> None:
    """Two lanes half a metre apart, at whose ends somebody is to be all the time."""
    lanes = [Lane(line_m=((0.0, y), (10.0, y))) for y in (0.0, 0.5)]
    asked = {(0.0, y): 1.0 for y in (0.0, 0.5)}
    assert met(make_plan(mission_on(lanes, asked), seed=0)) == 2
    with pytest.raises(NoPlanFound, match="keep bodies apart"):
        make_plan(mission_on(lanes, asked, body_m=0.3), seed=0)
