"""Bouncing robots as the check sees them: real ones pass, others do not, and covering is a demand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.small_plans import covering, monitoring
from shapely import box

from rota import BounceSettings
from rota.check import Report, check_plan, report_table, report_to_json
from rota.check.bounce_floor import Floor, cells_on_line, heading_moves
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot
from rota.model.plan import Plan, Trajectory


def kinds(report: Report) -> list[str]:
    return [violation.kind for violation in report.violations]


def changed(plan: Plan, robot: int, **fields: object) -> Plan:
    ways = list(plan.trajectories)
    ways[robot] = replace(ways[robot], **fields)
    return replace(plan, trajectories=tuple(ways))


def test_robots_that_turn_at_the_walls_pass_and_the_cells_they_enter_are_counted() -> None:
    assert check_plan(monitoring()).verdict == "met"
    report = check_plan(covering())
    assert (report.verdict, report.cells_entered, report.not_judged) == ("met", (6, 6), ())
    assert "cells entered: 6 of 6" in report_table(report)
    assert report_to_json(report)["cells"] == {"entered": 6, "of": 6}


def test_who_is_told_nothing_of_headings_is_judged_by_its_way() -> None:
    for plan in (monitoring(), covering()):
        bare = replace(plan, trajectories=tuple(replace(way, headings_rad=None) for way in plan))
        assert check_plan(bare).verdict == "met"


@pytest.mark.parametrize("headings", [True, False])
def test_a_turn_in_the_open_is_told_where(headings: bool) -> None:
    # it turns at x = 2.5, a cell before the wall
    early = [[0.5, 0.5], [2.5, 0.5], [2.5, 0.5], [0.5, 0.5], [0.5, 0.5]]
    kept = monitoring().trajectories[0].headings_rad if headings else None
    report = check_plan(changed(monitoring(), 0, positions_m=early, headings_rad=kept))
    assert "turns where nothing is in the way" in kinds(report)
    found = next(v for v in report.violations if v.kind == "turns where nothing is in the way")
    assert (found.who, found.place_m) == ("a", (2.5, 0.5))


def test_another_angle_off_cells_off_headings_and_sideways() -> None:
    # bounces by 90 degrees cannot turn it round at once: it would go along the end of the lane
    other = monitoring()
    settings = replace(BounceSettings.of(other.mission), bouncing_angles_deg=(90.0,))
    assert "turns where nothing is in the way" in kinds(
        check_plan(replace(other, mission=replace(other.mission, planning=settings)))
    )
    off = [[0.6, 0.5], [3.5, 0.5], [3.5, 0.5], [0.6, 0.5], [0.6, 0.5]]
    assert kinds(check_plan(changed(monitoring(), 0, positions_m=off))) == ["off its cells"] * 3
    askew = [[0.5, 0.5], [3.5, 1.5], [3.5, 1.5], [0.5, 0.5], [0.5, 0.5]]
    assert "along no heading" in kinds(check_plan(changed(monitoring(), 0, positions_m=askew)))
    sideways = np.array(monitoring().trajectories[0].headings_rad) + np.pi / 2
    assert "faces another way than it drives" in kinds(check_plan(changed(monitoring(), 0, headings_rad=sideways)))


def test_a_robot_that_rests_must_be_hemmed_in() -> None:
    rests = Trajectory(robot="a", times_s=[0.0], positions_m=[[1.5, 0.5]])
    plan = monitoring()
    assert "rests where nothing is in the way" in kinds(
        check_plan(replace(plan, trajectories=(rests, plan.trajectories[1])))
    )
    # in a nook as wide as itself there is nowhere to go
    nook = (Obstacle(shape=box(1, 0, 1.25, 2)), Obstacle(shape=box(0, 1, 1, 2)))
    hemmed = Trajectory(robot="a", times_s=[0.0], positions_m=[[0.5, 0.5]])
    mission = replace(plan.mission, obstacles=nook, zones=(replace(plan.mission.zones[0], shape=box(0, 0, 1, 1)),))
    mission = replace(mission, fleet=replace(mission.fleet, robots=mission.fleet.robots[:1]))  # type: ignore[index]
    assert check_plan(Plan(mission=mission, trajectories=(hemmed,))).verdict == "met"
    # and if it turns there for ever, it turns by its angle
    angle = np.radians(BounceSettings.of(mission).bouncing_angles_deg[0])
    for turn, wrong in ((angle, []), (angle / 2, ["turns by another angle"])):
        round_about = np.append(turn * np.arange(int(4 * np.pi / turn)) % (2 * np.pi), 0.0)
        turning = replace(
            hemmed, times_s=10.0 * np.arange(len(round_about)), positions_m=[[0.5, 0.5]] * len(round_about),
            headings_rad=round_about, loop_start_s=0.0,
        )  # fmt: skip
        assert sorted(set(kinds(check_plan(Plan(mission=mission, trajectories=(turning,)))))) == wrong


def test_points_that_bounce_are_never_in_one_place() -> None:
    # bodies of no width: they would have bumped all the same
    plan = monitoring()
    robots = tuple(replace(robot, body_radius_m=0.0) for robot in plan.mission.fleet.robots or ())
    mission = replace(plan.mission, fleet=replace(plan.mission.fleet, robots=robots, body_radius_m=0.0))
    same = replace(plan.trajectories[0], robot="b")
    assert "bodies touch" in kinds(check_plan(Plan(mission=mission, trajectories=(plan.trajectories[0], same))))


def test_what_stands_still_covers_nothing() -> None:
    stands = Trajectory(robot="a", times_s=[0.0], positions_m=[[0.5, 0.5]])
    report = check_plan(replace(covering(), trajectories=(stands,)))
    (found,) = report.violations
    assert (report.verdict, found.kind, found.value, report.cells_entered) == (
        "violated",
        "cells never entered",
        5,
        (1, 6),
    )
    assert found.place_m is not None
    assert found.place_m != (0.5, 0.5)


def test_turns_that_no_wall_explains_are_the_clock_s_where_a_floor_is_covered() -> None:
    quarter = np.pi / 2
    # to the middle of the lower row, up and round: turned by the clock there, by walls after that
    way = Trajectory(
        robot="a",
        times_s=[0, 2, 4, 6, 8, 12],
        positions_m=[[0.5, 0.5], [1.5, 0.5], [1.5, 0.5], [1.5, 1.5], [1.5, 1.5], [0.5, 1.5]],
        headings_rad=[0, 0, quarter, quarter, 2 * quarter, 2 * quarter],
        loop_start_s=12,
    )
    report = check_plan(replace(covering(), trajectories=(way,)))
    assert report.not_judged == ("1 turn is taken to be by the clock: no bounce explains it",)
    assert kinds(report) == ["cells never entered"]


def test_a_turn_by_the_clock_is_one_turn_and_a_turn_at_another_robot_is_a_bounce() -> None:
    """A lane of 8 headings at 135 degrees: 45 degrees back in the open are no five bounces."""
    robots = tuple(Robot(name=name, speed_m_s=0.5, sensor=DiscSensor(radius_m=1), body_radius_m=0.2) for name in "ab")
    mission = Mission(
        name="hall", area=box(0, 0, 6, 6), fleet=Fleet(speed_m_s=0.5, sensor=DiscSensor(radius_m=1), robots=robots),
        planning=BounceSettings(cell_m=1.0, headings=8, bouncing_angles_deg=(135,), task="cover"),
    )  # fmt: skip
    eighth = np.pi / 4

    def told(places: object, headings: object, faced: bool = True) -> tuple[str, ...]:
        way = Trajectory(
            robot="a", times_s=[0, 4, 8, 12], positions_m=places,  # type: ignore[arg-type]
            headings_rad=np.array(headings) * eighth if faced else None, loop_start_s=12,
        )  # fmt: skip
        return check_plan(Plan(mission=mission, trajectories=(way,))).not_judged

    back = ([[2.5, 1.5], [3.5, 1.5], [3.5, 1.5], [4.5, 0.5]], [0, 0, -1, -1])
    for faced in (True, False):
        assert told(*back, faced) == ("1 turn is taken to be by the clock: no bounce explains it",)
    half = ([[2.5, 1.5], [3.5, 1.5], [3.5, 1.5], [2.5, 1.5]], [0, 0, 4, 4])
    assert told(*half) == ("4 turns are taken to be by the clock: no bounce explains them",)
    # the other stands in the way
    meets = Trajectory(
        robot="a", times_s=[0, 4, 8, 12], positions_m=[[2.5, 1.5], [3.5, 1.5], [3.5, 1.5], [2.5, 2.5]],
        headings_rad=np.array([0, 0, 3, 3]) * eighth, loop_start_s=12,
    )  # fmt: skip
    stands = Trajectory(robot="b", times_s=[0.0], positions_m=[[4.5, 1.5]])
    assert check_plan(Plan(mission=mission, trajectories=(meets, stands))).not_judged == ()
    assert "1 turn " not in str(check_plan(Plan(mission=mission, trajectories=(meets, stands))).not_judged)


def test_robots_that_meet_on_the_way_to_their_loops_turn_there() -> None:
    # head on in one lane of 6 cells: both are stopped by the other in the middle, and turn round at once
    robots = tuple(Robot(name=name, speed_m_s=0.5, sensor=DiscSensor(radius_m=1), body_radius_m=0.2) for name in "ab")
    mission = Mission(
        name="lane",
        area=box(0, 0, 6, 1),
        zones=(replace(monitoring().mission.zones[0], name="door", shape=box(0, 0, 1, 1)),),
        fleet=Fleet(speed_m_s=0.5, sensor=DiscSensor(radius_m=1), robots=robots, body_radius_m=0.2),
        planning=BounceSettings(cell_m=1.0, headings=4, bouncing_angles_deg=(180,)),
    )

    def lane(name: str, start: float, meets: float, back: float) -> Trajectory:
        xs = [start, meets, meets, back, back, meets, meets]
        return Trajectory(
            robot=name, times_s=[0, 4, 6, 10, 12, 16, 18], positions_m=[[x, 0.5] for x in xs], loop_start_s=6
        )

    plan = Plan(mission=mission, trajectories=(lane("a", 0.5, 2.5, 0.5), lane("b", 5.5, 3.5, 5.5)))
    # on the way they may meet; on their loops they must not, and there the turn is in the open
    found = [v for v in check_plan(plan).violations if v.kind == "turns where nothing is in the way"]
    assert [v.who for v in found] == ["a", "b"]
    alone = replace(plan, mission=replace(mission, fleet=replace(mission.fleet, robots=robots[:1])),
                    trajectories=plan.trajectories[:1])  # fmt: skip
    assert kinds(check_plan(alone)).count("turns where nothing is in the way") == 2


def test_moves_and_what_they_cross() -> None:
    assert heading_moves(8).tolist() == [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]]
    assert heading_moves(16)[1].tolist() == [2, 1]
    # the line from (0, 0) to (2, 1) runs through (1, 0) and (1, 1) alone; a diagonal touches both corners beside it
    assert sorted(cells_on_line(2, 1)) == [(1, 0), (1, 1)]
    assert sorted(cells_on_line(1, 1)) == [(0, 1), (1, 0)]
    corner = replace(covering().mission, obstacles=(Obstacle(shape=box(1, 1, 2, 2)),))
    for corners, stopped in (("blocked", True), ("pass", False)):
        settings = BounceSettings(cell_m=1.0, task="cover", corners=corners)  # type: ignore[arg-type]
        small = replace(corner, planning=settings, fleet=replace(corner.fleet, robots=(
            replace(corner.fleet.robots[0], body_radius_m=0.0),), body_radius_m=0.0))  # type: ignore[index]  # fmt: skip
        floor = Floor(small, settings)
        assert floor.blocks_moves(np.array([[0, 1]]), np.array([7]))[0] == stopped


def test_floors_of_too_many_cells_are_not_called_met() -> None:
    plan = covering()
    settings = replace(BounceSettings.of(plan.mission), cell_m=1e-9)
    report = check_plan(replace(plan, mission=replace(plan.mission, planning=settings)))
    assert kinds(report) == ["too many cells to judge"]


def in_a_room(places: object, angle_deg: float = 90.0, headings_rad: object = None) -> Report:
    """One disc of 0.5 m without a grid in a room of 10 m x 10 m, round through these places for ever.

    Where a place comes twice it stands for a second.
    """
    robot = Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=1), body_radius_m=0.5).equal_robot("a")
    mission = Mission(
        name="room",
        area=box(0, 0, 10, 10),
        zones=(replace(monitoring().mission.zones[0], name="all", shape=box(0, 0, 10, 10), period_s=99),),
        fleet=Fleet(speed_m_s=1.0, sensor=DiscSensor(radius_m=1), robots=(robot,), body_radius_m=0.5),
        planning=BounceSettings(cells="none", bouncing_angles_deg=(angle_deg,)),
    )
    way = np.array([*places, places[0]], float)  # type: ignore[misc,index]
    lengths = np.hypot(*np.diff(way, axis=0).T)
    times = np.concatenate([[0], np.cumsum(np.where(lengths > 0, lengths, 1.0))])
    round_trip = Trajectory(robot="a", times_s=times, positions_m=way, headings_rad=headings_rad, loop_start_s=0)  # type: ignore[arg-type]
    return check_plan(Plan(mission=mission, trajectories=(round_trip,)))


def test_without_cells_a_turn_is_where_the_body_touches_a_wall() -> None:
    along_the_walls = [(5, 0.5), (9.5, 0.5), (9.5, 9.5), (0.5, 9.5), (0.5, 0.5)]
    assert in_a_room(along_the_walls).verdict == "met"
    # from the middle of one wall to that of the next: by 90 degrees, each at a wall
    assert in_a_room([(5, 0.5), (9.5, 5), (5, 9.5), (0.5, 5)]).verdict == "met"
    # the south wall is touched all the way, and stops nobody who drives along it
    early = [(5, 0.5), (9.4, 0.5), (9.4, 9.5), (0.5, 9.5), (0.5, 0.5)]
    found = in_a_room(early).violations
    assert [(v.kind, v.place_m) for v in found] == [("turns where nothing is in the way", (9.4, 0.5))]
    assert set(kinds(in_a_room(along_the_walls, 135.0))) == {"turns where nothing is in the way"}
    assert set(kinds(in_a_room(along_the_walls, 80.0))) == {"turns by another angle"}


def test_without_cells_headings_are_judged_where_a_file_gives_them() -> None:
    diamond = [(5, 0.5), (9.5, 5), (5, 9.5), (0.5, 5)]
    ways = np.array([1, 3, 5, 7]) * np.pi / 4
    left = np.append(ways, ways[0])  # turned at once, as each contact comes
    assert in_a_room(diamond, headings_rad=left).verdict == "met"
    for wrong in (np.zeros(5), -left, left + 0.01, np.append(ways[0], left[:-1])):
        assert "faces another way than it drives" in kinds(in_a_room(diamond, headings_rad=wrong))
    # standing for two seconds at each contact, turning to the left by a quarter; and to the right by three
    places = [place for place in diamond for _ in (0, 1)]
    stood = np.repeat(ways, 2)
    before = np.append(np.roll(stood, 1), stood[-1])
    assert in_a_room(places, headings_rad=before).verdict == "met"
    thirds = [place for place in diamond for _ in range(4)]
    on_the_way = (np.array([0, -1, -2, -3]) * np.pi / 2 + np.roll(ways, 1)[:, None]).ravel()
    assert set(kinds(in_a_room(thirds, headings_rad=np.append(on_the_way, on_the_way[0])))) == {
        "turns by another angle"
    }
