"""Ground that differs in importance: gradients and integrals beside exact ones, and where robots go."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from scipy.integrate import dblquad, quad
from shapely import MultiPolygon, Point, box
from tests.planners.swarm.conftest import in_box
from tests.planners.swarm.test_area_gradient import ALL, GROUND, MOVED_M

from rota import check_plan
from rota.cells.importance_cells import ImportanceCells, importance_cells, importance_in_range
from rota.errors import MissionError
from rota.files.plan_file import plan_text
from rota.model.mission import DiscSensor, Fleet, ImportanceMap, Mission, Obstacle, StartBox, Zone
from rota.planners.swarm.arc_kernels import exposed_arcs
from rota.planners.swarm.deciding import deciding_room
from rota.planners.swarm.importance_field import field_of
from rota.planners.swarm.importance_kernels import importance_gradient, importance_in_disc, worth_gradient
from rota.planners.swarm.kernels import find_neighbours
from rota.planners.swarm.nodes.scene import scene_of
from rota.planners.swarm.planner import ALL_NEIGHBOURS, run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planners.swarm.settle_kernels import decide_settle
from rota.planners.swarm.state import Outline
from rota.planners.swarm.world import walls_of

SIDE_M = 0.5


def cells_of(worth: object, width: int = 100, height: int = 80) -> ImportanceCells:
    x, y = np.meshgrid(SIDE_M * (np.arange(2 * width) + 0.5), SIDE_M * (np.arange(2 * height) + 0.5))
    values = worth(x, y)  # type: ignore[operator]
    ground_m2 = np.full(values.shape, SIDE_M**2)
    return ImportanceCells(values=values, ground_m2=ground_m2, low_m=(SIDE_M / 2, SIDE_M / 2), side_m=SIDE_M)


def linear(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.asarray(1.0 + 0.02 * x + 0.01 * y)


def hill(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.asarray(0.1 + np.exp(-((x - 40) ** 2 + (y - 30) ** 2) / (2 * 12.0**2)))


def covered(places: np.ndarray, sensors: np.ndarray) -> float:
    """The exact integral of ``linear`` over what discs cover of the ground: its area times the centroid's value."""
    discs = shapely.buffer(shapely.points(places), sensors, quad_segs=500)
    shape = shapely.union_all(discs).intersection(GROUND)
    return float(shape.area * linear(shape.centroid.x, shape.centroid.y))


@pytest.mark.parametrize("unequal", [False, True])
def test_the_gradient_is_that_of_the_exact_integral(unequal: bool) -> None:
    rng = np.random.default_rng(7)
    places = rng.uniform(0, (100, 80), (60, 2))
    places = places[shapely.intersects_xy(GROUND.buffer(-0.5), *places.T)][:9]
    sensors = rng.uniform(8, 20, len(places)) if unequal else np.full(len(places), 14.0)
    swarm = in_box(
        places, walls=walls_of(GROUND), rule=ALL, decide=decide_settle, sensor_m=sensors, wall_range_m=sensors,
        neighbour_range_m=sensors + sensors.max(), importance=cells_of(linear),
    )  # fmt: skip
    room, robots, kinds = deciding_room(ALL), swarm.robots, swarm.kinds
    for i in range(len(places)):
        kind, k = robots.kind[i], robots.name[i]
        near, _ = find_neighbours(i, ALL_NEIGHBOURS, robots, swarm.grid, kinds.neighbour_range_m[kind], room.near)
        count = exposed_arcs(i, near, robots, kinds, swarm.grid, room.near, room.outline)
        told = worth_gradient(robots.x[i], robots.y[i], kinds.sensor_m[kind], count, room.outline, swarm.grid)
        for axis in range(2):
            step = np.zeros_like(places)
            step[k, axis] = MOVED_M
            more, less = (covered(places + sign * step, sensors) for sign in (1, -1))
            assert told[axis] == pytest.approx((more - less) / (2 * MOVED_M), abs=0.05)


def test_integrals_along_arcs_are_those_of_quadpack() -> None:
    arcs, field, x, y, radius = Outline(np.zeros(64), np.zeros(64)), field_of(cells_of(hill)), 45.0, 33.0, 14.0
    for low, high in [(-np.pi, np.pi), (-1.0, 0.3), (0.011, 0.012), (2.9, np.pi)]:
        arcs.x[0], arcs.y[0] = low, high
        told = importance_gradient(x, y, radius, 1, arcs, field)
        for axis, along in enumerate((np.cos, np.sin)):
            exact, _ = quad(
                lambda a, along=along: along(a) * hill(x + radius * np.cos(a), y + radius * np.sin(a)), low, high
            )
            assert told[axis] == pytest.approx(radius * exact, rel=2e-3, abs=2e-3)


def test_integrals_over_parts_of_discs_are_those_of_quadpack() -> None:
    outline, field = Outline(np.zeros(64), np.zeros(64)), field_of(cells_of(hill))
    corners, (x, y), radius = [(-20, -5), (9, -16), (12, 3), (-2, 12)], (45.0, 33.0), 14.0
    outline.x[:4], outline.y[:4] = np.array(corners).T
    whole, mx, my = importance_in_disc(x, y, outline, 4, radius, field)
    part = shapely.Polygon(corners).intersection(Point(0, 0).buffer(radius, quad_segs=500))

    def width(v: float) -> tuple[float, float]:
        row = part.intersection(shapely.LineString([(-99, v), (99, v)]))
        return (0.0, 0.0) if row.is_empty else (row.bounds[0], row.bounds[2])

    low, high = part.bounds[1], part.bounds[3]
    for told, times in [(whole, lambda u, v: 1.0), (mx, lambda u, v: u), (my, lambda u, v: v)]:
        exact, _ = dblquad(
            lambda u, v, times=times: times(u, v) * hill(x + u, y + v), low, high,
            lambda v: width(v)[0], lambda v: width(v)[1], epsabs=0.5,
        )  # fmt: skip
        assert told == pytest.approx(exact, rel=0.01)


def mission(robots: int, **changed: object) -> Mission:
    """Robots in the left lower corner of a square of 120 m."""
    like = Fleet(speed_m_s=2.0, sensor=DiscSensor(radius_m=12), body_radius_m=0.4)
    fleet = replace(
        like,
        robots=tuple(like.equal_robot(f"robot-{k + 1}") for k in range(robots)),
        start=StartBox(low_m=(2, 2), high_m=(40, 40)),
    )
    planning = SwarmSettings(most_steps=3000)
    square = MultiPolygon([box(0, 0, 120, 120)])
    return replace(Mission(name="m", area=square, fleet=fleet, planning=planning), **changed)  # type: ignore[arg-type]


def zone(name: str, importance: float, *corners: float) -> Zone:
    return Zone(name=name, shape=MultiPolygon([box(*corners)]), period_s=None, importance=importance)


CORNER = zone("corner", 10, 85, 85, 115, 115)
DOOR = tuple(Obstacle(shape=MultiPolygon([box(58, *ys[:1], 60, *ys[1:])])) for ys in ((0, 52), (58, 120)))


def test_few_robots_go_to_the_ground_that_matters_through_a_door() -> None:
    asked = mission(4, zones=(CORNER,), importance=0.1, obstacles=DOOR)
    run = run_mission(asked, seed=0)
    ends_m = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
    # 4 discs of 12 m cover 30 m x 30 m but for some 4 %, and none is left where ground matters less
    assert run.at_rest
    assert (Point(100, 100).buffer(25).contains(shapely.points(ends_m))).all()
    assert shapely.union_all(shapely.buffer(shapely.points(ends_m), 12)).intersection(CORNER.shape).area > 0.93 * 900
    assert check_plan(run.plan).verdict == "met"


def test_uniform_importance_is_none() -> None:
    plain = run_mission(mission(5), seed=1).plan
    everywhere = ImportanceMap(values=np.full((7, 5), 3.0), low_m=(0, 0), step_m=(20, 20))
    for changed in ({"importance": 0.7}, {"importance": everywhere}, {"zones": (zone("all", 5, 0, 0, 120, 120),)}):
        assert run_mission(mission(5, **changed), seed=1).plan.trajectories == plain.trajectories


def test_only_ratios_count() -> None:
    one, other = (
        run_mission(mission(4, zones=(replace(CORNER, importance=10 * by),), importance=0.5 * by), seed=0).plan
        for by in (1, 64)
    )
    assert one.trajectories == other.trajectories


def test_zones_replace_the_ground_and_the_largest_rules_where_they_overlap() -> None:
    zones = (zone("a", 0, 0, 0, 60, 120), zone("b", 4, 30, 0, 60, 120))
    asked = mission(1, zones=zones, importance=2.0)
    cells = importance_cells(asked, asked.area, 10.0)
    assert cells is not None
    assert cells.values[3].tolist() == pytest.approx([0, 0, 0, 4, 4, 4, 2, 2, 2, 2, 2, 2])


def test_ground_that_is_worth_nothing_anywhere_is_refused() -> None:
    with pytest.raises(MissionError, match="importance: 0 is not allowed; give the ground, or a zone"):
        mission(1, importance=0.0)
    with pytest.raises(MissionError, match="some ground must be worth more than 0"):
        run_mission(mission(1, zones=(zone("all", 0, 0, 0, 120, 120),)), seed=0)


HILLS = ImportanceMap(
    values=np.exp(-((np.arange(12)[:, None] - 8) ** 2 + (np.arange(12) - 9) ** 2) / 6), low_m=(5, 5), step_m=(10, 10)
)


@pytest.mark.parametrize(
    "planning",
    [
        SwarmSettings(most_steps=2500),
        SwarmSettings(most_steps=2500, delay_steps=1, messages_lost=0.1),
        SwarmSettings(most_steps=2500, altitudes_m=(10, 20)),
    ],
)
def test_a_run_rests_covers_what_matters_and_goes_on_as_without_a_stop(planning: SwarmSettings) -> None:
    asked = mission(6, importance=HILLS, planning=planning)
    whole = run_mission(asked, seed=2, threads=2)
    assert whole.at_rest
    told = importance_in_range(whole.plan)
    # six discs have 19 % of the ground; those of the best places of a lattice 67 % of what matters
    assert told is not None
    assert told > 0.6
    half = run_mission(replace(asked, planning=replace(planning, most_steps=57)), seed=2)
    rest = run_mission(asked, seed=2, resume=half.state)
    assert plan_text(rest.plan) == plan_text(whole.plan)


def test_voronoi_goes_up_the_importance_and_others_refuse_it() -> None:
    start = replace(mission(5).fleet, start=StartBox(low_m=(70, 60), high_m=(110, 100)))
    flat = mission(5, planning=SwarmSettings(controller="voronoi"), fleet=start)
    told = importance_in_range(run_mission(replace(flat, importance=HILLS), seed=0).plan)
    plan = run_mission(flat, seed=0).plan
    assert told > 1.05 * importance_in_range(replace(plan, mission=replace(flat, importance=HILLS)))  # type: ignore
    words = "importance: the controller reciprocal heeds none; settle and voronoi do: remove it, or choose one of them"
    with pytest.raises(MissionError, match=words):
        mission(5, importance=HILLS, planning=SwarmSettings(controller="reciprocal"))


def test_no_order_of_robots_counts() -> None:
    places = np.random.default_rng(4).uniform(10, 60, (12, 2))
    order = np.random.default_rng(5).permutation(12)
    ends = []
    for chosen in (np.arange(12), order):
        swarm = in_box(
            places[chosen], (100, 80), rule=ALL, decide=decide_settle, neighbour_range_m=30, sensor_m=15,
            importance=cells_of(hill),
        )  # fmt: skip
        for _ in range(150):
            swarm.step()
        ends.append(swarm.places_m)
    assert ends[0][order] == pytest.approx(ends[1], abs=1e-6)


def test_processes_know_what_ground_is_worth() -> None:
    scene = scene_of(mission(4, zones=(CORNER,), importance=0.1))
    assert scene.grid.importance.values.max() == 1
    assert scene.grid.place_graph.most == pytest.approx(np.pi * 12**2, rel=0.05)
    assert not len(scene_of(mission(4)).grid.place_graph.worth)


def test_hearsay_of_what_has_been_taken_dies_out() -> None:
    like = Fleet(speed_m_s=2.0, sensor=DiscSensor(radius_m=16), body_radius_m=0.4)
    robots = tuple(like.equal_robot(f"robot-{k + 1}") for k in range(8))
    wall = tuple(Obstacle(shape=MultiPolygon([box(95, *ys[:1], 100, *ys[1:])])) for ys in ((0, 60), (70, 140)))
    asked = mission(
        8,
        area=MultiPolygon([box(0, 0, 200, 140)]),
        obstacles=wall,
        importance=0.2,
        zones=(zone("stage", 5, 140, 80, 190, 130), zone("gates", 2, 120, 5, 195, 30)),
        fleet=replace(like, robots=robots, start=StartBox(low_m=(5, 5), high_m=(40, 40))),
    )
    run = run_mission(asked, seed=0)
    # before hops had a least length, robots went to and fro behind the door for 2,800 steps
    assert run.at_rest
    assert run.steps < 1000
