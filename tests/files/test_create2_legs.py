"""What a Create 2 does leg by leg: contacts worked by hand, loops, clocks, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.create2.plans import TypedMap, bounced_plan
from benchmarks.create2.robot import Create2
from shapely import Polygon, box, union_all
from tests.seeds import seeds

from rota.errors import PlanError
from rota.files.create2_course import Surroundings, stretches_of
from rota.files.create2_driven import Driven, touching_legs
from rota.files.create2_legs import BODY_RADIUS_M, drives_of, motion_of
from rota.model.mission import Obstacle
from rota.model.plan import Plan
from rota.planners.patrol.planner_settings import PatrolSettings

ROOM = TypedMap(rows=("....", "....", "...."), cell_m=0.5)
CORRIDOR = TypedMap(rows=("......",), cell_m=0.5)
REACH_M = 0.25 - BODY_RADIUS_M  # from a cell's centre to the contact with a wall beside the cell


def with_trajectory(plan: Plan, **changes: object) -> Plan:
    return replace(plan, trajectories=(replace(plan.trajectories[0], **changes),))  # type: ignore[arg-type]


def test_a_round_along_the_walls() -> None:
    plan = bounced_plan(ROOM, ((0, 0, 0),), turn=2, speed_m_s=0.2, headings=4)
    (drive,) = drives_of(plan)
    assert [round(leg.length_m, 9) for leg in drive.legs] == [1.5, 1.0, 1.5, 1.0]
    assert [round(math.degrees(leg.heading_rad)) % 360 for leg in drive.legs] == [0, 90, 180, 270]
    for leg in drive.legs:
        assert (leg.bumps, leg.speed_m_s) == (True, 0.2)
        assert leg.back_off_m == pytest.approx(REACH_M)
        assert leg.turn_rad == pytest.approx(math.pi / 2)
    assert [leg.next_s for leg in drive.legs] == pytest.approx([10.0, 17.5, 27.5, 35.0])  # steps of 2.5 s, turns too
    assert (drive.first_s, drive.loop_from, drive.loop_s) == (0.0, 0, pytest.approx(35.0))


def test_oblique_contacts_are_farther_ahead() -> None:
    """Along a diagonal the wall beside a cell is met sqrt(2) times as far ahead as straight on."""
    plan = bounced_plan(ROOM, ((0, 1, 1),), turn=3, speed_m_s=0.2)
    first = drives_of(plan)[0].legs[0]
    assert first.length_m == pytest.approx(0.5 * math.sqrt(2))
    assert first.back_off_m == pytest.approx(REACH_M * math.sqrt(2))
    assert first.turn_rad == pytest.approx(math.radians(135))
    assert first.speed_m_s == 0.2  # a diagonal move takes a whole step, a straight one waits for it
    straight = next(leg for leg in drives_of(plan)[0].legs if round(math.degrees(leg.heading_rad)) % 90 == 0)
    assert straight.speed_m_s == round(0.2 / math.sqrt(2), 3)


def test_an_obstacles_corner_is_met_at_one_radius() -> None:
    """From (0.75, 0.75) along 45 degrees the obstacle's corner (1, 1) lies straight ahead, sqrt(2) / 4 m off."""
    ground = TypedMap(rows=("..#.", "....", "...."), cell_m=0.5)
    first = drives_of(bounced_plan(ground, ((0, 0, 1),), turn=3, speed_m_s=0.15))[0].legs[0]
    assert first.length_m == pytest.approx(math.sqrt(2) / 2)
    assert first.back_off_m == pytest.approx(math.sqrt(2) / 4 - BODY_RADIUS_M)


def test_robots_that_meet_back_off_half_of_what_is_between_them() -> None:
    """On cells 2 and 3 their centres are 0.5 m apart: each goes on for (0.5 - 2 x 0.17) / 2."""
    plan = bounced_plan(CORRIDOR, ((0, 0, 0), (5, 0, 4)), turn=4, speed_m_s=0.15, headings=4)
    for drive in drives_of(plan):
        meeting, wall = drive.legs[:2]
        assert meeting.length_m == pytest.approx(1.0)
        assert (meeting.bumps, wall.bumps) == (True, True)
        assert meeting.back_off_m == pytest.approx(0.08)
        assert wall.back_off_m == pytest.approx(REACH_M)
        assert meeting.turn_rad == pytest.approx(math.pi)


def test_robots_that_have_no_time_to_meet_turn_by_the_clock_both() -> None:
    """One free cell between them is the target of both: each would go on for 0.5 - 0.17 m, and back."""
    narrow = TypedMap(rows=(".....",), cell_m=0.5)
    plan = bounced_plan(narrow, ((0, 0, 0), (4, 0, 4)), turn=4, speed_m_s=0.15, headings=4)
    for drive in drives_of(plan):
        meeting, wall = drive.legs[:2]
        assert (meeting.length_m, meeting.bumps, wall.bumps) == (0.5, False, True)
        assert drive.slowing == 1
    slow = bounced_plan(narrow, ((0, 0, 0), (4, 0, 4)), turn=4, speed_m_s=0.04, headings=4)
    for drive in drives_of(slow):
        assert drive.legs[0].bumps
        assert drive.legs[0].back_off_m == pytest.approx(0.33)


def test_what_only_the_grid_blocks_is_turned_at_by_the_clock() -> None:
    """A bit of an obstacle in the cell beside a diagonal blocks it on the grid; a robot would pass."""
    plan = bounced_plan(ROOM, ((0, 0, 0),), turn=2, speed_m_s=0.2, headings=4)
    turns_early = with_trajectory(
        plan, times_s=[0, 5, 7.5, 12.5], positions_m=[[0.25, 0.25], [1.25, 0.25], [1.25, 0.25], [1.25, 1.25]],
        headings_rad=None, loop_start_s=12.5,
    )  # fmt: skip
    first, last = drives_of(turns_early)[0].legs
    assert (first.bumps, first.drive_s, first.next_s) == (False, pytest.approx(5.0), 7.5)
    assert last.turn_rad == 0
    assert drives_of(turns_early)[0].loop_from is None


def test_a_loop_that_begins_in_the_middle_of_a_way_is_joined_at_a_turn() -> None:
    plan = bounced_plan(ROOM, ((0, 0, 0),), turn=2, speed_m_s=0.2, headings=4)
    corners = [[0.25, 0.25], [1.75, 0.25], [1.75, 0.25], [1.75, 1.25], [1.75, 1.25], [0.25, 1.25], [0.25, 1.25]]
    corners += [[0.25, 0.25], [0.25, 0.25]]
    turned = [corners[0], [1.25, 0.25], *corners[1:], [1.25, 0.25]]
    times = [0, 5, 7.5, 10, 15, 17.5, 25, 27.5, 32.5, 35, 40]
    drive = drives_of(
        with_trajectory(plan, times_s=times, positions_m=turned, headings_rad=None, loop_start_s=5)
    )[0]  # fmt: skip
    assert [round(leg.length_m, 9) for leg in drive.legs] == [1.5, 1.0, 1.5, 1.0, 1.5]
    assert (drive.loop_from, drive.loop_s) == (1, 35.0)
    assert drive.legs[-1].next_s == pytest.approx(drive.legs[0].next_s + 35.0)


def test_a_pause_before_the_first_way_is_waited_for() -> None:
    plan = bounced_plan(ROOM, ((3, 0, 0),), turn=2, speed_m_s=0.2, headings=4)
    (drive,) = drives_of(plan)
    assert (drive.first_s, drive.loop_from) == (pytest.approx(2.5), 0)


def test_a_contact_too_near_to_turn_at_backs_off_a_little_all_the_same() -> None:
    tight = TypedMap(rows=("....", "....", "...."), cell_m=2 * BODY_RADIUS_M)
    (drive,) = drives_of(bounced_plan(tight, ((0, 0, 0),), turn=2, speed_m_s=0.1, headings=4))
    assert {leg.back_off_m for leg in drive.legs} == {0.005}


def test_obstacles_that_hide_but_do_not_block_are_no_contact() -> None:
    plan = bounced_plan(ROOM, ((0, 0, 0),), turn=2, speed_m_s=0.2, headings=4)
    hedge = Obstacle(shape=box(0.9, 0, 1.0, 0.5), blocks="sight")
    seen = replace(plan, mission=replace(plan.mission, obstacles=(hedge,)))
    assert [leg.back_off_m for leg in drives_of(seen)[0].legs] == pytest.approx([REACH_M] * 4)


def test_robots_that_cannot_be_create_2_robots_are_refused() -> None:
    plan = bounced_plan(ROOM, ((0, 0, 0),), turn=2, speed_m_s=0.2, headings=4)
    fleet = plan.mission.fleet
    patrol = replace(plan.mission, planning=PatrolSettings())
    with pytest.raises(PlanError, match="is planned by patrol: its robots must know where they are"):
        drives_of(replace(plan, mission=patrol))
    thin = tuple(replace(robot, body_radius_m=0.1) for robot in fleet.robots or ())
    with pytest.raises(PlanError, match=r"robot robot-1: body_radius_m: 0\.1 is not allowed for a Create 2"):
        drives_of(replace(plan, mission=replace(plan.mission, fleet=replace(fleet, robots=thin))))
    with pytest.raises(PlanError, match="the plan has no robots"):
        drives_of(replace(plan, trajectories=()))
    quick = tuple(replace(robot, turn_rate_rad_s=4.0) for robot in fleet.robots or ())
    with_quick = replace(plan.mission, fleet=replace(fleet, robots=quick))
    assert drives_of(replace(plan, mission=with_quick))[0].turn_speed_m_s == 0.47
    with pytest.raises(PlanError, match="robot robot-1: it never moves"):
        drives_of(
            with_trajectory(plan, times_s=[0], positions_m=[[0.25, 0.25]], headings_rad=None, loop_start_s=0)
        )  # fmt: skip


def test_a_slanting_wall_is_met_at_one_radius() -> None:
    """A wall from (1.5, 0) to (2.0, 1.0): straight on along y = 0.25 its line is met at 1.625 m."""
    plan = bounced_plan(ROOM, ((0, 0, 0),), turn=2, speed_m_s=0.2, headings=4)
    area = Polygon([(0, 0), (1.5, 0), (2.0, 1.0), (2.0, 1.5), (0, 1.5)])
    turns = with_trajectory(
        replace(plan, mission=replace(plan.mission, area=area)), times_s=[0, 5, 10, 15],
        positions_m=[[0.25, 0.25], [1.25, 0.25], [1.25, 0.25], [1.25, 1.25]], headings_rad=None, loop_start_s=15,
    )  # fmt: skip
    expected_m = 1.625 - BODY_RADIUS_M * math.sqrt(1.25) - 1.25  # radius / sine of the angle, for a slope of 2
    assert drives_of(turns)[0].legs[0].back_off_m == pytest.approx(expected_m)


def random_map(seed: int) -> tuple[TypedMap, tuple[int, int, int]]:
    """A map of 6 x 5 cells with obstacles, and a start in it."""
    rng = np.random.default_rng(seed)
    rows = tuple("".join("#" if rng.random() < 0.2 else "." for _ in range(6)) for _ in range(5))
    ground = TypedMap(rows=rows, cell_m=0.5)
    free = [(column, row) for column in range(6) for row in range(5) if ground.is_free(column, row)]
    return ground, (*free[rng.integers(len(free))], int(rng.integers(8)))


@pytest.mark.parametrize("seed", seeds(12, at_once=4))
def test_legs_on_random_maps_end_where_a_body_driven_into_walls_says(seed: int) -> None:
    """A model that knows nothing but the map drives each leg until it touches, backs off, and is at the cell."""
    ground, start = random_map(seed)
    plan = bounced_plan(ground, (start,), turn=1 + seed % 7, speed_m_s=0.03)
    (drive,) = drives_of(plan)
    blocking = union_all([obstacle.shape for obstacle in plan.mission.obstacles])
    walls = plan.mission.area.difference(blocking).boundary
    for leg in drive.legs:
        body = Create2(x_m=leg.start_m[0], y_m=leg.start_m[1], heading_rad=leg.heading_rad, walls=walls)
        body.right_m_s = body.left_m_s = 1.0
        body.advance(leg.length_m)
        if leg.bumps:
            for _ in range(80):
                body.advance(0.01)
            body.right_m_s = body.left_m_s = -1.0
            body.advance(leg.back_off_m)
        along = leg.length_m * np.array([math.cos(leg.heading_rad), math.sin(leg.heading_rad)])
        np.testing.assert_allclose((body.x_m, body.y_m), leg.start_m + along, atol=1e-6)


# ---------------------------------------------------------------- a slower clock

LAB = TypedMap(rows=(".....", ".....", "....."), cell_m=0.25)


def test_a_clock_slowed_as_little_as_the_tightest_leg_needs() -> None:
    """At 0.4 m/s steps take 1.25 s: 1 m and 0.08 m to the wall, 0.08 m back at 0.2, a quarter turn, 50 ms."""
    plan = bounced_plan(ROOM, ((0, 0, 0),), turn=2, speed_m_s=0.4, headings=4)
    beside_s = 0.08 / 0.2 + math.pi / 2 * 0.235 / 2 / 0.2 + 0.05
    expected = (1.08 / 0.4 + beside_s) / 3.75  # the shorter side: two moves and a turn
    (drive,) = drives_of(plan)
    assert drive.slowing == pytest.approx(expected)
    assert drive.loop_s == pytest.approx(14 * 1.25 * expected)
    assert all(leg.spare_s >= -1e-9 and leg.bumps for leg in drive.legs)
    assert min(leg.spare_s for leg in drive.legs) < 5e-3
    with pytest.raises(PlanError, match=r"robot-1: the plan leaves too little time to bump, back off and turn by 90"):
        drives_of(plan, most_slowing=1.0)


def test_a_leg_that_only_changes_its_speed_is_never_late() -> None:
    """1 m at 0.2 / sqrt(2) m/s and on at 0.2: in whole millimetres per second 141 would lag, 142 waits."""
    plan = bounced_plan(ROOM, ((0, 0, 0),), turn=2, speed_m_s=0.2, headings=4)
    slow_s = 1.0 / (0.2 / math.sqrt(2))
    changes = with_trajectory(
        plan, times_s=[0, slow_s, slow_s + 2.5, slow_s + 5, slow_s + 10],
        positions_m=[[0.25, 0.25], [1.25, 0.25], [1.75, 0.25], [1.75, 0.25], [1.75, 1.25]], headings_rad=None,
        loop_start_s=slow_s + 10,
    )  # fmt: skip
    first, second = drives_of(changes)[0].legs[:2]
    assert (first.turn_rad, first.speed_m_s, second.speed_m_s) == (0.0, 0.142, 0.2)
    assert first.spare_s >= 0


def test_too_fast_a_plan_is_slowed_to_what_wheels_can_do() -> None:
    (drive,) = drives_of(bounced_plan(ROOM, ((0, 0, 0),), turn=2, speed_m_s=0.9, headings=4))
    assert max(leg.speed_m_s for leg in drive.legs) <= 0.5
    assert all(leg.spare_s >= -1e-9 for leg in drive.legs)


@pytest.mark.parametrize("turn", [1, 2, 3])
def test_robots_wider_than_their_cells_can_be_driven(turn: int) -> None:
    """Cells of 0.25 m: from where the grid turns, a body that is held 0.25 m off a wall goes on by 0.08 m."""
    (drive,) = drives_of(bounced_plan(LAB, ((1, 1, 1),), turn=turn, speed_m_s=0.2))
    assert 1 <= drive.slowing < 2.5
    assert all(0.02 <= leg.speed_m_s <= 0.2 for leg in drive.legs)
    assert all(leg.spare_s >= -1e-9 for leg in drive.legs if leg.turn_rad)


def test_bodies_apart_as_driven_not_only_as_planned() -> None:
    """One goes to the wall past the other, which stands in its cell: nearer than the plan has them, never touching."""
    ground = TypedMap(rows=("...", "..."), cell_m=0.5)
    plan = bounced_plan(ground, ((0, 0, 0), (2, 1, 4)), turn=2, speed_m_s=0.3, headings=4)
    drives = drives_of(plan)
    assert not touching_legs([motion_of(drive) for drive in drives], 2 * BODY_RADIUS_M)
    near = [Driven(times_s=[0, 4], places_m=[(0, 0), (4, 0)], legs=[0, 0], loop_s=0)]
    near += [Driven(times_s=[0, 1, 2, 5], places_m=[(2, 1), (2, 1), (2, 0.33), (2, 0.33)], legs=[0, 0, 1, 2], loop_s=0)]
    assert touching_legs(near, 0.34) == {(0, 0), (1, 1), (1, 2)}
    assert touching_legs(near, 0.32) == set()


def test_loops_of_different_lengths_meet_after_many_rounds() -> None:
    """Rounds of 3 s and 5 s: on the common corner together only where both come there at once, at 9 s."""
    one = Driven(times_s=[0, 1, 3], places_m=[(0, 0), (5, 0), (0, 0)], legs=[0, 0, 1], loop_s=3)
    other = Driven(times_s=[0, 4, 5], places_m=[(0, 9), (0, 0), (0, 9)], legs=[0, 0, 1], loop_s=5)
    assert touching_legs([one, other], 0.3) == {(0, 1), (0, 0), (1, 0), (1, 1)}
    late = Driven(times_s=[0, 1, 6], places_m=[(9, 0), (5, 0), (9, 0)], legs=[0, 0, 1], loop_s=6)
    off = Driven(times_s=[0, 4, 6], places_m=[(0, 9), (5, 0.5), (0, 9)], legs=[0, 0, 1], loop_s=6)
    assert touching_legs([late, off], 0.3) == set()


def test_a_robot_that_is_bumping_into_a_wall_is_not_bumped_into_on_purpose() -> None:
    """One bumps into the west wall and backs off while the other comes from the south: a race where they would meet."""
    ground = TypedMap(rows=("....", "....", "....", "...."), cell_m=0.5)
    plan = bounced_plan(ground, ((1, 3, 5), (0, 0, 2)), turn=3, speed_m_s=0.15)
    courses = tuple(stretches_of(trajectory) for trajectory in plan)
    both = Surroundings(plan, courses, BODY_RADIUS_M)
    (_, at_wall, *_), (_, below, *_) = courses
    assert (at_wall.stays, below.stays) == (True, True)
    contact = both.contact(0, at_wall, math.radians(225))
    assert contact is not None
    assert not contact.of_robots
    assert both.contact(1, below, math.radians(90)) is None
