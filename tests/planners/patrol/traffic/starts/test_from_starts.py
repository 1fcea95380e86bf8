"""Plans led out from starts: arrival times in closed form, phases kept, rooms apart, bodies, fixed fleets."""

import math
from dataclasses import replace

import numpy as np
import pytest
from shapely import MultiPolygon, Polygon, box

import rota
from rota.check import check_plan
from rota.files.geodesy import Projection
from rota.files.qgroundcontrol import trajectory_to_qgroundcontrol
from rota.model.mission import DiscSensor, Fleet, GeoPoint, Mission, Obstacle, SquareSensor, StartBox, StartPoints, Zone
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.driving.timed_line import start_at, steady
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planners.patrol.traffic.starts.from_starts import lead_from_starts, require_room
from rota.planning.plan_summary import robot_rows

WALL = Obstacle(shape=MultiPolygon([box(4, -1, 5, 1)]))


def street(
    start: object, *, robots: int = 1, body_m: float = 0.0, turn: float | None = None, **more: object
) -> Mission:
    """A corridor 40 m by 8 m, to be seen from a line along y = 4 in every 18 s."""
    common = {"speed_m_s": 2.0, "sensor": SquareSensor(side_m=9), "body_radius_m": body_m, "turn_rate_rad_s": turn}
    return Mission(
        name="street",
        area=MultiPolygon([box(0, 0, 40, 8)]),
        period_s=18,
        fleet=Fleet(**common, start=start),
        **more,
    )


def there_and_back(
    x0: float, x1: float, y: float, speed: float, first: float, name: str, pause: float = 0.0
) -> Trajectory:
    """A loop from x0 to x1 and back, begun the share ``first`` of a round later, waiting at both ends."""
    leg = (x1 - x0) / speed
    steps = np.array([leg, pause, leg, pause])
    times = np.concatenate([[0.0], np.cumsum(steps[steps > 0])])
    x = np.array([x0, x1, x1, x0, x0])[np.r_[True, steps > 0]]
    places = np.column_stack([x, np.full(len(x), y)])
    times, places, _ = start_at(steady(times, places), first * float(times[-1]))
    return Trajectory(robot=name, times_s=times, positions_m=places)


def of_loops(mission: Mission, *loops: Trajectory) -> Plan:
    return Plan(mission=replace(mission, fleet=replace(mission.fleet, start=None)), trajectories=loops)


def two_on_one_line(mission: Mission, turn_s: float = 0.0) -> Plan:
    loops = [
        there_and_back(4, 36, 4, 2 * (1 - 1e-6), share, f"robot-{k + 1}", turn_s) for k, share in enumerate((0, 0.5))
    ]
    return of_loops(mission, *loops)


def test_one_robot_arrives_after_the_distance_over_its_speed() -> None:
    mission = replace(street(StartPoints(points_m=((10, 1),))), period_s=33)
    loop = there_and_back(4, 36, 4, 2 * (1 - 1e-6), 0, "robot-1")
    led = lead_from_starts(
        of_loops(mission, loop),
        mission,
        check_plan,
    )
    (trajectory,) = led
    # the loop passes 3 m away, at (10, 4), and 3 m take 1.5 s
    assert trajectory.loop_start_s == pytest.approx(1.5, rel=2e-6)
    assert trajectory.positions_m[0].tolist() == [10, 1]
    assert trajectory.positions_m[trajectory.loop_index] == pytest.approx([10, 4], abs=1e-6)
    assert trajectory.loop_duration_s == pytest.approx(loop.loop_duration_s, rel=1e-12)
    assert trajectory.loop_length_m == pytest.approx(64)
    assert check_plan(led).verdict == "met"


def test_a_way_round_a_corner_and_into_the_loop_takes_its_turns() -> None:
    # the only way from (2, 1) up to the stay at (2, 7) leads round the wall's end at (10, 4)
    wall = Obstacle(shape=MultiPolygon([box(0, 3.9, 10, 4)]))
    start = StartPoints(points_m=((2, 1),))
    gate = Zone(name="gate", shape=MultiPolygon([box(0, 5, 5, 8)]), period_s=1.0)
    fleet = street(start, turn=0.5).fleet
    area = MultiPolygon([box(0, 0, 40, 8)])
    mission = Mission(name="gate", area=area, obstacles=(wall,), zones=(gate,), fleet=fleet)
    stay = Trajectory(robot="robot-1", times_s=[0], positions_m=[[2, 7]])
    led = lead_from_starts(
        of_loops(mission, stay),
        mission,
        check_plan,
    )
    (trajectory,) = led
    corners = np.array([(2, 1), (10, 3.9), (10, 4), (2, 7)])
    steps = np.diff(corners, axis=0)
    length = np.hypot(*steps.T).sum()
    heading = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    turn_s = np.abs(np.diff(heading)).sum() / 0.5
    assert trajectory.loop_start_s == pytest.approx(length / 2 + turn_s, rel=3e-6)
    assert trajectory.loop_duration_s == 0
    assert check_plan(led).verdict == "met"


@pytest.mark.parametrize("turn", [None, 1.0])
def test_robots_that_share_a_tour_keep_half_a_round_between_them(turn: float | None) -> None:
    mission = street(StartPoints(points_m=((0.5, 0.5), (1, 7), (39, 7))), turn=turn)
    turn_s = 0.0 if turn is None else math.pi / turn * (1 + 1e-6)
    plan = two_on_one_line(mission, turn_s)
    assert check_plan(plan).verdict == "met"
    led = lead_from_starts(plan, mission, check_plan)
    report = check_plan(led)
    assert report.verdict == "met", [violation.text() for violation in report.violations]
    one, other = led
    assert one.loop_start_s == other.loop_start_s > 0
    half_s = one.loop_duration_s / 2
    at = [
        np.interp((half_s * k) % (2 * half_s) + t.loop_start_s, t.times_s, t.positions_m[:, 0])
        for t, k in ((one, 1), (other, 0))
    ]
    assert at[0] == pytest.approx(at[1], abs=1e-6)
    # one of the three points stays empty
    assert {tuple(t.positions_m[0]) for t in led} <= {(0.5, 0.5), (1, 7), (39, 7)}
    # had the other begun where it is 4 s later, the gaps would be 4 s worse than half a round
    begun = steady(other.times_s[other.loop_index :] - other.loop_start_s, other.positions_m[other.loop_index :])
    times_s, places_m, _ = start_at(begun, 4.0)
    late = Trajectory(
        robot=other.robot,
        times_s=np.append(other.times_s[: other.loop_index], other.loop_start_s + times_s),
        positions_m=np.vstack([other.positions_m[: other.loop_index], places_m]),
        loop_start_s=other.loop_start_s,
    )
    assert check_plan(replace(led, trajectories=(one, late))).demands[0].worst_gap_at_least_s > mission.period_s


def test_a_start_in_another_room_is_named() -> None:
    wall = Obstacle(shape=MultiPolygon([box(19, 0, 21, 8)]))
    loops = tuple(there_and_back(a, b, 4, 2, 0, f"robot-{k + 1}") for k, (a, b) in enumerate([(4, 15), (25, 36)]))
    for points, words in [
        (((1, 1), (2, 2)), r"round \(25.00, 4.00\) needs \d robots?, but 0 can reach it .* from \(1, 1\), \(2, 2\)"),
        (((1, 1),), r"needs 2 robots, but fleet.start has only 1 of the points"),
    ]:
        mission = replace(street(StartPoints(points_m=points)), obstacles=(wall,))
        plan = of_loops(mission, *loops)
        with pytest.raises(rota.NoPlanFound, match=words):
            lead_from_starts(plan, mission, check_plan)
    mission = replace(street(StartPoints(points_m=((38, 1), (1, 1)))), obstacles=(wall,))
    led = lead_from_starts(replace(plan, mission=mission), mission, check_plan)
    assert [t.positions_m[0].tolist() for t in led] == [[1, 1], [38, 1]]
    assert check_plan(led).verdict == "met"


def test_bodies_that_start_side_by_side_do_not_touch() -> None:
    mission = street(StartBox(low_m=(0, 0), high_m=(4, 2)), body_m=0.45)
    mission = replace(mission, area=MultiPolygon([box(0, 0, 40, 8)]), period_s=34)
    # three lanes apart from each other
    loops = tuple(there_and_back(4, 36, y, 2 * (1 - 1e-6), 0, f"robot-{k + 1}") for k, y in enumerate((2, 4, 6)))
    plan = of_loops(mission, *loops)
    led = lead_from_starts(plan, mission, check_plan)
    report = check_plan(led)
    assert report.verdict == "met", [violation.text() for violation in report.violations]
    end_s = 2 * led.trajectories[0].loop_start_s
    moments = np.arange(0, end_s, 0.01)
    at = [np.column_stack([np.interp(moments, t.times_s, t.positions_m[:, a]) for a in (0, 1)]) for t in led]
    assert min(np.hypot(*(a - b).T).min() for i, a in enumerate(at) for b in at[:i]) >= 0.9
    starts = np.array([places[0] for places in at])
    assert (starts >= 0.45 - 1e-9).all()
    assert (starts <= [4, 2]).all()


def test_table_film_and_exports_keep_the_way_and_the_loop_apart() -> None:
    start = StartPoints(points_m=((10, 1),))
    mission = replace(street(start), period_s=33, origin=GeoPoint(lat=48.1, lon=11.5))
    led = lead_from_starts(of_loops(mission, there_and_back(4, 36, 4, 1.99, 0, "robot-1")), mission, check_plan)
    (trajectory,) = led
    (row,) = robot_rows(led)
    assert (row.loop_length_m, row.loop_time_s) == pytest.approx((64, 64 / 1.99))
    late_s = trajectory.loop_start_s + 3 * trajectory.loop_duration_s
    np.testing.assert_allclose(trajectory.at(np.array([0.0, late_s])), [(10, 1), (10, 4)], atol=1e-6)
    items = trajectory_to_qgroundcontrol(led, trajectory)["mission"]["items"]
    projection = Projection(GeoPoint(lat=48.1, lon=11.5))

    def metres(item: dict) -> tuple[float, float]:
        x, y = projection.to_metres(item["params"][5], item["params"][4])
        return float(x), float(y)

    assert items[0]["command"] == 22  # take off
    assert metres(items[0]) == pytest.approx((10, 1), abs=1e-3)
    assert items[-1]["command"] == 177  # jump, to the loop's first waypoint
    (target,) = [item for item in items if item["doJumpId"] == items[-1]["params"][0]]
    assert metres(target) == pytest.approx((10, 4), abs=1e-3)
    assert all(math.dist(metres(item), (10, 1)) > 1 for item in items[1:-1] if item["command"] == 16)


def test_the_check_tells_robots_that_begin_elsewhere() -> None:
    loops = [there_and_back(4, 36, 4, 2, share, f"robot-{k + 1}") for k, share in enumerate((0.0, 0.5))]
    for start, kind, away_m in [
        (StartBox(low_m=(0, 0), high_m=(5, 1)), "start", [3.0, math.hypot(31, 3)]),
        (StartPoints(points_m=((4, 4), (36, 7))), "start", [3.0]),
        (StartPoints(points_m=((4, 4),)), "no start left", [0.0]),
        (StartPoints(points_m=((36, 4), (4, 4))), "start", []),
    ]:
        plan = Plan(mission=street(start), trajectories=tuple(loops))
        found = [violation for violation in check_plan(plan).violations if "start" in violation.kind]
        assert [violation.value for violation in found] == pytest.approx(away_m)
        assert {violation.kind for violation in found} <= {kind}


def test_too_many_for_the_box_are_told_so() -> None:
    mission = street(StartBox(low_m=(0, 0), high_m=(1.5, 0.6)), body_m=0.4)
    loops = tuple(there_and_back(4, 36, y, 2, 0, f"robot-{k + 1}") for k, y in enumerate((2, 4, 6)))
    plan = of_loops(mission, *loops)
    # centres have 1.1 m by 0.2 m in the box, bodies need 0.8 m
    with pytest.raises(rota.NoPlanFound, match="has room for 2 robots in free ground, where 3 are needed"):
        lead_from_starts(plan, mission, check_plan)
    robots = tuple(mission.fleet.equal_robot(f"robot-{k + 1}") for k in range(3))
    fixed = replace(mission, fleet=replace(mission.fleet, robots=robots))
    for refused in (lambda: lead_from_starts(plan, fixed, check_plan), lambda: rota.make_plan(fixed)):
        with pytest.raises(rota.MissionError, match="has room for 2 robots"):
            refused()
    # a body in the middle of the box takes all of its room; a box narrower than a body has none
    taken = (replace(robots[0], start=(0.75, 0.5)), *robots[1:])
    with pytest.raises(rota.MissionError, match="has room for 0 robots in free ground, where 2 are needed"):
        require_room(replace(mission, fleet=replace(mission.fleet, robots=taken)))
    corner = StartBox(low_m=(0, 0), high_m=(0.3, 0.3))
    with pytest.raises(rota.MissionError, match="has room for 0 robots in free ground, where 1 is needed"):
        rota.make_plan(replace(mission, fleet=replace(mission.fleet, start=corner)))


def test_starts_in_the_box_keep_clear_of_robots_with_a_start_of_their_own() -> None:
    mission = street(StartBox(low_m=(0, 0), high_m=(4, 2)), body_m=0.45)
    loops = tuple(there_and_back(4, 36, y, 2 * (1 - 1e-6), 0, f"robot-{k + 1}") for k, y in enumerate((2, 4, 6)))
    own = replace(mission.fleet.equal_robot("robot-3"), start=(2.0, 1.0))  # the middle, which would be taken first
    robots = (*(mission.fleet.equal_robot(f"robot-{k + 1}") for k in range(2)), own)
    mission = replace(mission, period_s=34, fleet=replace(mission.fleet, robots=robots))
    led = lead_from_starts(of_loops(mission, *loops), mission, check_plan)
    assert check_plan(led).verdict == "met"
    starts = [trajectory.positions_m[0] for trajectory in led]
    assert starts[2].tolist() == [2, 1]
    assert min(np.hypot(*(a - b)) for i, a in enumerate(starts) for b in starts[:i]) >= 0.9


def stays(*places: tuple[float, float]) -> list[Trajectory]:
    return [Trajectory(robot=f"robot-{k + 1}", times_s=[0], positions_m=[place]) for k, place in enumerate(places)]


def pipe(*robots: tuple[float, float, float]) -> Mission:
    """A pipe 20 m by 1 m, then 5 m by 0.5 m; both ends and the narrow part are watched from within.

    robots: where each starts, its speed, its body's radius.
    """
    fleet = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=2))
    named = tuple(
        replace(fleet.equal_robot(f"robot-{k + 1}"), start=(x, 0.5), speed_m_s=speed, body_radius_m=body_m)
        for k, (x, speed, body_m) in enumerate(robots)
    )
    return Mission(
        name="pipe",
        area=MultiPolygon([Polygon([(0, 0), (20, 0), (20, 1), (0, 1), (0, 0.75), (-5, 0.75), (-5, 0.25), (0, 0.25)])]),
        zones=(Zone(name="end", shape=MultiPolygon([box(19, 0, 20, 1)]), period_s=1.0),),
        fleet=replace(fleet, robots=named),
    )


def test_in_a_corridor_nobody_overtakes_though_a_fast_robot_would_arrive_earlier() -> None:
    # the fast one could be at 0.5 after 7.25 s, past the one at 10; in their order it takes 9.5 s
    mission = pipe((19.5, 1, 0.3), (10, 1, 0.3), (15, 2, 0.3))
    led = lead_from_starts(of_loops(mission, *stays((0.5, 0.5), (10, 0.5), (19.5, 0.5))), mission, check_plan)
    assert check_plan(led).verdict == "met"
    assert [trajectory.positions_m[-1, 0] for trajectory in led] == [19.5, 0.5, 10]
    assert led.trajectories[0].loop_start_s == pytest.approx(9.5, rel=1e-5)


def test_bodies_that_cannot_get_past_each_other_are_told_and_reported() -> None:
    # only the small robot fits into the narrow part, and the big one stands before it
    mission = pipe((10, 1, 0.4), (15, 1, 0.2))
    with pytest.raises(rota.NoPlanFound, match="cannot reach their loops without bodies touching") as caught:
        lead_from_starts(of_loops(mission, *stays((-4, 0.5), (19.5, 0.5))), mission, check_plan)
    best = caught.value.best
    assert isinstance(best, Plan)
    assert [trajectory.positions_m[[0, -1], 0].tolist() for trajectory in best] == [[10, 19.5], [15, -4]]
    assert {violation.kind for violation in check_plan(best).violations} == {"bodies touch"}


def yard(**fleet: object) -> Mission:
    common = Fleet(speed_m_s=1, sensor=DiscSensor(radius_m=4), **fleet)
    wall = Obstacle(shape=MultiPolygon([box(6, 0, 7, 8)]))
    return Mission(
        name="yard",
        area=MultiPolygon([box(0, 0, 13, 8)]),
        obstacles=(wall,),
        period_s=30,
        fleet=common,
        planning=PatrolSettings(effort="quick"),
    )


def test_spare_robots_of_a_fixed_fleet_go_where_they_start() -> None:
    mission = yard()
    starts = [(11.0, 2.0), (11.0, 3.0), (11.0, 4.0), (2.0, 5.0)]  # two loops suffice; the spare robots are on the right
    robots = tuple(replace(mission.fleet.equal_robot(f"guard-{k}"), start=start) for k, start in enumerate(starts))
    plan = rota.make_plan(replace(mission, fleet=replace(mission.fleet, robots=robots)))
    assert [trajectory.robot for trajectory in plan] == [f"guard-{k}" for k in range(4)]
    assert [tuple(trajectory.positions_m[0]) for trajectory in plan] == starts
    assert plan.mission.fleet.robots == robots
    assert check_plan(plan).verdict == "met"


def test_a_room_without_a_robot_is_told_with_the_best_plan() -> None:
    mission = yard().with_method("parallel")
    lonely = tuple(replace(mission.fleet.equal_robot(f"guard-{k}"), start=(2.0, 2.0 + k)) for k in range(4))
    with pytest.raises(rota.NoPlanFound, match=r"needs \d robots?, but 0 can reach it") as caught:
        rota.make_plan(replace(mission, fleet=replace(mission.fleet, robots=lonely)))
    assert isinstance(caught.value.best, Plan)
    assert caught.value.best.mission.fleet.robots == lonely


def test_a_plan_from_a_box_begins_there_and_the_same_every_time() -> None:
    mission = yard(start=StartBox(low_m=(3, 0), high_m=(9, 3)), body_radius_m=0.3)
    plan = rota.make_plan(mission, seed=3)
    assert check_plan(plan).verdict == "met"
    assert plan == rota.make_plan(mission, seed=3)
    starts = np.array([trajectory.positions_m[0] for trajectory in plan])
    assert (starts >= [3, 0.3]).all()
    assert (starts <= [9, 3]).all()
    assert {bool(x > 7) for x in starts[:, 0]} == {True, False}  # robots of both rooms
    assert len({trajectory.loop_start_s for trajectory in plan}) == 1
