"""Plans of bouncing robots: trajectories that a bumper and a clock are enough for, and that the check passes."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import shapely
from shapely import MultiPolygon, Point, box

from rota.check import check_plan
from rota.errors import MissionError, NoPlanFound
from rota.files.text_map import text_map
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, Zone
from rota.model.plan import Plan
from rota.planners.bounce import chosen_group, sentences
from rota.planners.bounce.cells import make_cells
from rota.planners.bounce.chosen_group import begin_there
from rota.planners.bounce.enumeration import groups_as_printed
from rota.planners.bounce.limit_cycles import zone_cells
from rota.planners.bounce.planner import bouncing_robots, coverage_by, monitoring_plan, watch_of
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.bounce.sentences import rattling_sentence, swept_sentence
from rota.planners.bounce.trajectories import pace_of, step_duration_s
from rota.planning.make_plan import make_plan, search_plan

ROOM = """
..........
.##.......
.....##...
..........
...#......
...#...##.
..........
.....#....
.##..#....
.........."""
SENSOR = DiscSensor(radius_m=0.5)


def mission_on(
    text: str,
    robots: int | list[Robot] | None,
    zones: tuple[Zone, ...] = (),
    *,
    body_radius_m: float = 0.3,
    turn_rate_rad_s: float | None = None,
    **options: object,
) -> Mission:
    area, walls = text_map(text, 1.0)
    fleet = Fleet(speed_m_s=0.5, sensor=SENSOR, body_radius_m=body_radius_m, turn_rate_rad_s=turn_rate_rad_s)
    if isinstance(robots, int):
        robots = [fleet.equal_robot(f"robot-{k + 1}") for k in range(robots)]
    return Mission(
        name="room",
        area=area,
        obstacles=(Obstacle(shape=walls),) if not walls.is_empty else (),
        zones=zones,
        fleet=replace(fleet, robots=None if robots is None else tuple(robots)),
        planning=BounceSettings(cell_m=1.0, **options),  # type: ignore[arg-type]
    )


def visit(name: str, period_s: float, *bounds: float) -> Zone:
    return Zone(name=name, shape=box(*bounds), period_s=period_s, demand="visit")


ZONES = (visit("door", 120, 0, 8, 1, 10), visit("window", 180, 8, 0, 10, 2))


def require_drivable(plan: Plan, *, jumps: bool) -> None:
    """Drives along the heading from cell centre to cell centre, and turns on the spot by the bouncing angle."""
    mission = plan.mission
    cells = make_cells(mission)
    pace = pace_of(mission, cells, len(plan.trajectories))
    # every duration is the longest step's, or that of a move of one of the robots
    allowed_s = np.unique([pace.longest_s, *pace.move_s.ravel()])
    angles = BounceSettings.of(mission).bouncing_angles_deg
    for k, trajectory in enumerate(plan):
        bounce = math.radians(angles[k if len(angles) > 1 else 0])
        assert trajectory.headings_rad is not None
        assert (np.hypot(*(trajectory.positions_m[:, None] - cells.centres_m).T).min(axis=0) < 1e-9).all()
        for leg, (dx, dy) in enumerate(np.diff(trajectory.positions_m, axis=0)):
            turn = (trajectory.headings_rad[leg + 1] - trajectory.headings_rad[leg]) % math.tau
            if dx or dy:
                assert turn == 0
                assert math.cos(math.atan2(dy, dx) - trajectory.headings_rad[leg]) == pytest.approx(1, abs=1e-12)
                cells_gone = math.gcd(round(dx / cells.cell_m), round(dy / cells.cell_m))
                each_s = (trajectory.times_s[leg + 1] - trajectory.times_s[leg]) / cells_gone
                assert np.abs(each_s - allowed_s).min() < 1e-9
            elif turn != 0:
                assert trajectory.times_s[leg + 1] - trajectory.times_s[leg] == pytest.approx(pace.longest_s)
                step = math.tau / BounceSettings.of(mission).headings
                by_clock = jumps and min(turn, math.tau - turn) == pytest.approx(step)
                assert by_clock or turn == pytest.approx(bounce)
            else:
                assert jumps


@pytest.mark.parametrize("corners", ["blocked", "pass"])
@pytest.mark.parametrize("angles", [(135,), (90,), (135, 45)])
def test_two_robots_monitor_two_zones_and_the_check_agrees(angles: tuple[float, ...], corners: str) -> None:
    mission = mission_on(ROOM, 2, ZONES, bouncing_angles_deg=angles, corners=corners)
    plan = make_plan(mission)
    require_drivable(plan, jumps=False)
    assert check_plan(plan).verdict == "met"


def test_sixteen_headings_and_a_turn_rate_give_longer_steps_and_a_plan_that_passes() -> None:
    mission = mission_on(ROOM, 2, ZONES, headings=16, bouncing_angles_deg=(112.5,), turn_rate_rad_s=2.0)
    cells = make_cells(mission)
    # the move (2, 1) at 0.5 m/s takes longer than turning by 112.5 degrees at 2 rad/s
    assert step_duration_s(mission, cells) == pytest.approx(math.sqrt(5) / 0.5)
    slow = replace(
        mission, fleet=replace(mission.fleet, robots=(replace(mission.fleet.robots[0], turn_rate_rad_s=0.1),))
    )
    # 5 of 16 headings: from east to (-1, 2), which is more than 112.5 degrees
    assert step_duration_s(slow, cells) == pytest.approx((math.pi / 2 + math.atan(1 / 2)) / 0.1)
    alone = replace(mission, fleet=replace(mission.fleet, robots=mission.fleet.robots[:1]))
    plan = make_plan(replace(alone, zones=(visit("west", 400, 0, 0, 5, 10),)))
    assert check_plan(plan).verdict == "met"


@pytest.mark.parametrize("angle_deg", [22.5, 112.5])
def test_robots_that_turn_slowly_have_time_for_turns_to_headings_that_are_a_little_off(angle_deg: float) -> None:
    mission = mission_on(ROOM, 1, turn_rate_rad_s=0.05, task="cover", headings=16, bouncing_angles_deg=(angle_deg,))
    assert check_plan(make_plan(mission)).verdict == "met"


def test_groups_are_counted_in_words_that_fit_their_number(monkeypatch: pytest.MonkeyPatch) -> None:
    zones = (visit("west", 34, 0, 0, 1, 1), visit("east", 34, 5, 0, 6, 1))
    found = search_plan(mission_on("......", 1, zones, bouncing_angles_deg=(180,)))
    assert found.facts[0] == "1 robot has 1 periodic group in which every zone is visited."
    monkeypatch.setattr(sentences, "MOST_COUNTING", 1)
    found = search_plan(mission_on(ROOM, 2, ZONES))
    assert found.facts[0] == "Their periodic groups are not counted: that would take long."


def test_as_few_robots_as_possible_are_enough() -> None:
    # a lane of 6 cells: a shuttle takes 2 * 5 moves of 2 s and 2 turns of 2.83 s, so one is at an end every 25.7 s
    zones = (visit("west", 26, 0, 0, 1, 1), visit("east", 26, 5, 0, 6, 1))
    settings = {"bouncing_angles_deg": (180,), "body_radius_m": 0.3}
    assert len(make_plan(mission_on("......", None, zones, **settings)).trajectories) == 1
    # for a shorter period one turns on the spot at each end
    plan = make_plan(mission_on("......", None, tuple(replace(z, period_s=20) for z in zones), **settings))
    assert [trajectory.loop_length_m for trajectory in plan] == [0, 0]
    told = rattling_sentence(plan)
    assert told is not None
    assert told.startswith("robot-1, robot-2 stay in one cell and turn there for ever: a limit cycle, too")
    # two lanes need two
    both = (visit("north", 26, 0, 2, 1, 3), visit("south", 26, 0, 0, 1, 1))
    assert len(make_plan(mission_on("......\n######\n......", None, both, **settings)).trajectories) == 2


@pytest.mark.parametrize("contact_free", ["cycle", "trajectory"])
def test_robots_with_starts_come_to_their_cycles(contact_free: str) -> None:
    fleet = [Robot(name=name, speed_m_s=0.5, sensor=SENSOR, body_radius_m=0.3, start=at)
             for name, at in (("a", (0.5, 0.5)), ("b", (5.5, 5.5)))]  # fmt: skip
    mission = mission_on(ROOM, fleet, (visit("west", 300, 0, 0, 5, 10),), contact_free=contact_free)
    plan = make_plan(mission)
    require_drivable(plan, jumps=False)
    assert [tuple(t.positions_m[0]) for t in plan] == [(0.5, 0.5), (5.5, 5.5)]
    assert plan.trajectories[0].loop_start_s == plan.trajectories[1].loop_start_s > 0
    facing = replace(mission, planning=replace(BounceSettings.of(mission), start_headings_deg=(90, 45)))
    try:
        turned = make_plan(facing)
    except NoPlanFound:
        return
    assert [t.headings_rad[0] for t in turned] == pytest.approx([math.pi / 2, math.pi / 4])


@pytest.mark.parametrize("purpose", ["periods", "worst_gap", "basin"])
@pytest.mark.parametrize("method", ["improved", "as_printed"])
def test_every_purpose_by_every_method_gives_a_plan(purpose: str, method: str) -> None:
    text = "......\n.#....\n....#.\n......"
    zones = (visit("door", 200, 0, 3, 1, 4), visit("window", 200, 5, 0, 6, 1))
    mission = mission_on(text, 2, zones, purpose=purpose, method=method)
    plan = make_plan(mission)
    require_drivable(plan, jumps=False)
    worst = check_plan(plan).worst_ratio
    best = check_plan(
        make_plan(replace(mission, planning=replace(BounceSettings.of(mission), purpose="worst_gap")))
    ).worst_ratio
    assert best <= worst + 1e-9


@pytest.mark.parametrize("method", ["improved", "as_printed"])
@pytest.mark.parametrize("robots", [1, 3])
def test_robots_cover_the_room_and_then_stay(robots: int, method: str) -> None:
    mission = mission_on(ROOM, robots, task="cover", method=method)
    if (method, robots) == ("as_printed", 1):
        words = "cells were not entered when all joint states that robots can jump to had been there"
        with pytest.raises(NoPlanFound, match=words) as caught:
            make_plan(mission, seed=1)
        assert isinstance(caught.value.best, Plan)
        require_drivable(caught.value.best, jumps=True)
        return
    searched = search_plan(mission, seed=1)
    plan = searched.plan
    require_drivable(plan, jumps=True)
    assert check_plan(plan).verdict == "met"
    assert all(trajectory.loop_duration_s == 0 for trajectory in plan)
    entered = shapely.union_all([shapely.LineString(t.positions_m).buffer(0.3) for t in plan])
    cells = make_cells(mission)
    assert all(entered.covers(Point(centre)) for centre in cells.centres_m)
    told = searched.facts[0]
    assert f"enter{'s' * (robots == 1)} 88 of 88 cells (100.0%) in " in told
    swept = shapely.union_all([shapely.LineString(t.positions_m).buffer(0.3) for t in plan]).area / 88
    assert f"Bodies pass over {swept:.1%} of the floor, discs of the sensors over " in swept_sentence(plan)
    assert 0.6 < swept < 0.9
    contacts, jumps = (int(re.search(rf"(\d+) {what}", told)[1]) for what in ("contact", "turn"))  # type: ignore[index]
    assert jumps > 0  # bumps alone leave cells out here
    assert robots > 1 or contacts == 0
    assert make_plan(mission, seed=1) == plan


def test_zones_that_no_robot_comes_to_from_its_start_are_named() -> None:
    # the pocket has a limit cycle of its own, to turn in it for ever, but nobody gets in
    rows = ("......", "......", "..##..", "..#.#.", "..####", "......")
    walls = [
        box(x / 2, y / 2, x / 2 + 0.5, y / 2 + 0.5)
        for y, row in enumerate(rows[::-1])
        for x, c in enumerate(row)
        if c == "#"
    ]
    robot = Robot(name="a", speed_m_s=0.2, sensor=DiscSensor(radius_m=0.3), body_radius_m=0.17, start=(0.25, 0.25))
    zones = [("pocket", box(1.5, 1, 2, 1.5)), ("corner", box(0, 0, 0.5, 0.5))]
    mission = Mission(
        name="room",
        area=MultiPolygon([box(0, 0, 3, 3)]),
        obstacles=tuple(Obstacle(shape=MultiPolygon([wall])) for wall in walls),
        zones=tuple(Zone(name=n, period_s=300, demand="visit", shape=MultiPolygon([s])) for n, s in zones),
        fleet=Fleet(speed_m_s=0.2, sensor=robot.sensor, robots=(robot,)),
        planning=BounceSettings(cell_m=0.5, bouncing_angles_deg=(90,)),
    )
    with pytest.raises(NoPlanFound, match=r"no team of 1 robot goes .* a limit cycle that enters pocket$"):
        make_plan(mission)


def test_what_is_walled_off_is_told_and_the_rest_is_covered() -> None:
    fleet = [Robot(name="a", speed_m_s=0.5, sensor=SENSOR, start=(0.5, 0.5))]
    with pytest.raises(NoPlanFound, match=r"66\.7% of 6 cells .* no robot has a way .* 2 cells, at \(3\.5, 0\.5\)"):
        make_plan(mission_on("..#.\n..#.", fleet, task="cover"))


def two_rooms(**options: object) -> Mission:
    """Two rooms with a door between them, whose middle lies at y = 1.3 m, a quarter off the middle of a cell."""
    walls = MultiPolygon([box(3, 0, 4, 0.9), box(3, 1.7, 4, 3)])
    robots = tuple(Robot(name=name, speed_m_s=0.5, sensor=SENSOR, body_radius_m=0.3) for name in ("a", "b"))
    return Mission(
        name="two-rooms",
        area=MultiPolygon([box(0, 0, 7, 3)]),
        obstacles=(Obstacle(shape=walls),),
        fleet=Fleet(speed_m_s=0.5, sensor=SENSOR, body_radius_m=0.3, robots=robots),
        planning=BounceSettings(cell_m=1.0, task="cover", **options),  # type: ignore[arg-type]
    )


def test_cells_that_the_grid_cuts_off_are_told_apart_with_a_grid_that_joins_them() -> None:
    both = two_rooms()
    one = replace(both, fleet=replace(both.fleet, robots=(replace(both.fleet.robots[0], start=(0.5, 0.5)),)))
    words = r"joins no robot's start with 9 cells, .* a body could drive there: bounce\.cell_origin: \[(.*), (.*)\]"
    with pytest.raises(NoPlanFound, match=words) as caught:
        make_plan(one)
    x, y = map(float, re.search(words, str(caught.value)).groups())  # type: ignore[union-attr]
    shifted = two_rooms(cell_origin=(x, y))
    cells = make_cells(shifted)
    assert np.allclose((np.subtract(cells.corner_m, (x, y)) / cells.cell_m) % 1 % 1, 0)
    assert (np.array(cells.corner_m) <= 0).all()
    plan = make_plan(shifted)
    assert check_plan(plan).verdict == "met"
    require_drivable(plan, jumps=True)
    # a corner some cells away is the same grid
    away = make_cells(two_rooms(cell_origin=(x + 3, y - 2)))
    assert np.allclose(away.centres_m, cells.centres_m)
    with pytest.raises(MissionError, match="cell_origin"):
        two_rooms(cell_origin=(math.nan, 0))


@pytest.mark.parametrize("robots", [1, 2])
def test_covering_takes_as_many_steps_as_it_is_allowed(robots: int) -> None:
    mission = mission_on(ROOM, robots, task="cover")

    def steps_of(most: int) -> tuple[int, bool]:
        allowed = replace(mission, planning=replace(BounceSettings.of(mission), most_steps=most))
        bouncing = bouncing_robots(allowed, make_cells(allowed))
        found = coverage_by(bouncing, seed=1)
        return found.steps, found.complete

    needed, complete = steps_of(10_000)
    assert complete
    assert steps_of(needed) == (needed, True)
    assert steps_of(needed - 1) == (needed - 1, False)
    assert steps_of(5) == (5, False)
    short = replace(mission, planning=replace(BounceSettings.of(mission), most_steps=5))
    with pytest.raises(NoPlanFound, match=r"cells were not entered after bounce\.most_steps: 5"):
        make_plan(short, seed=1)


def test_straight_ways_are_driven_at_full_speed_when_no_robot_needs_longer() -> None:
    """By 90 degrees along the walls of a room: 4 x 9 moves of 2 s, 4 turns of 2.83 s; every step was 2.83 s before."""
    room = "\n".join(["." * 10] * 10)
    mission = mission_on(room, 1, (visit("corner", 300, 0, 0, 1, 1),), bouncing_angles_deg=(90,), purpose="worst_gap")
    cells = make_cells(mission)
    bouncing = bouncing_robots(mission, cells)
    cycles = watch_of(bouncing).cycles
    around = next(int(cycles.start[c]) for c in range(len(cycles.length)) if cycles.length[c] == 40
                  and len(set((cycles.state[cycles.cycle == c] // 8).tolist())) == 36)  # fmt: skip
    watch = watch_of(bouncing)
    plan = monitoring_plan(bouncing, begin_there(watch, (around,), watch.ratio((around,))), 0)
    assert plan.trajectories[0].loop_duration_s == pytest.approx(36 * 2 + 4 * 2 * math.sqrt(2))
    assert plan.trajectories[0].loop_length_m == pytest.approx(36)
    assert check_plan(plan).verdict == "met"
    # two of them in step: nobody is slower than before, and the check still finds no contact
    pair = mission_on(ROOM, 2, ZONES, bouncing_angles_deg=(90,))
    found = search_plan(pair)
    assert found.report.verdict == "met"
    longest_s = bouncing_robots(pair, make_cells(pair)).step_s
    for trajectory in found.plan:
        ways_m = np.hypot(*np.diff(trajectory.positions_m, axis=0).T)
        assert (ways_m <= 0.5 * np.diff(trajectory.times_s) + 1e-9).all()
        assert trajectory.loop_duration_s <= longest_s * 2000
    assert "Robots keep in step: steps last " in " ".join(found.facts)


def test_the_printed_algorithm_tells_its_own_groups() -> None:
    text = "......\n.#....\n....#.\n......"
    zones = (visit("door", 200, 0, 3, 1, 4), visit("window", 200, 5, 0, 6, 1))
    mission = mission_on(text, 2, zones, method="as_printed", purpose="worst_gap")
    told = search_plan(mission).facts
    bouncing = bouncing_robots(mission, make_cells(mission))
    kept, listed = groups_as_printed(bouncing.team, zone_cells(bouncing.cells, list(zones)), 8)
    p, q = int(listed.length.sum()), int((listed.basin - listed.length).sum())
    groups = (
        f"Algorithm 2 as printed keeps {kept:,} periodic groups (r), of {p:,} joint states (P), and {q:,} transient"
    )
    assert told[0].startswith(groups)
    assert told[1] == "The worst gap, in steps, is the shortest of those that Algorithm 2 as printed keeps, proved."
    improved = replace(mission, planning=replace(BounceSettings.of(mission), method="improved"))
    assert search_plan(improved).facts[1] == "The worst gap, in steps, is the shortest of all groups, proved."


def test_what_was_not_searched_to_the_end_is_not_said_to_be_impossible(monkeypatch: pytest.MonkeyPatch) -> None:
    mission = mission_on(ROOM, 2, ZONES, purpose="worst_gap")
    found = search_plan(mission, should_stop=lambda: True)
    assert any("not proved to be the shortest of all groups: the search was stopped" in told for told in found.facts)
    monkeypatch.setattr(chosen_group, "best_group", partial(chosen_group.best_group, most_nodes=1))
    with pytest.raises(
        NoPlanFound, match=r"was found that .* is not proved: the search ended after 1 partial team; other"
    ):
        make_plan(mission)


def test_bodies_too_wide_to_pass_keep_apart_by_their_swept_distance() -> None:
    # at 0.45 m crossing robots of the published grid would come as near as 0.447 cells
    plan = make_plan(mission_on(ROOM, 3, task="cover", body_radius_m=0.45), seed=3)
    assert check_plan(plan).verdict == "met"
    wide = mission_on(ROOM, 2, ZONES, body_radius_m=0.45)
    assert check_plan(make_plan(wide)).verdict == "met"


TWO_HALLS = """
.........#....................
....####.#....................
....####......................
..............................
..............................
.........#....................
.........#....................
#..###################...#####
...###...####............###..
.........#....................
.........#....................
.........#....................
.........#....................
.........#....................
.........#....................
.........#....................
..............................
..............................
..............................
.........#...................."""


def test_each_robot_keeps_its_own_loop_however_long_the_common_one_is() -> None:
    # loops of 84, 25 and 62 steps come together after 65,100: no heading is a sum of as many turns
    zones = (visit("a", 6000, 1, 1, 8, 11), visit("b", 6000, 11, 1, 29, 11), visit("c", 6000, 1, 14, 8, 19))
    mission = mission_on(TWO_HALLS, 3, zones, body_radius_m=0.5, turn_rate_rad_s=1.7)
    plan = make_plan(mission)
    report = check_plan(plan)
    assert report.verdict == "met"
    step_s = step_duration_s(mission, make_cells(mission))
    steps = [trajectory.loop_duration_s / step_s for trajectory in plan]
    assert steps == pytest.approx([round(length) for length in steps], rel=1e-12)
    assert math.lcm(*map(round, steps)) > 64 * max(steps)
    assert max(len(trajectory.times_s) for trajectory in plan) < max(steps) + 2
    for trajectory in plan:
        assert trajectory.headings_rad is not None
        assert ((trajectory.headings_rad >= 0) & (trajectory.headings_rad < math.tau)).all()


def test_what_cannot_be_is_refused_with_its_reason() -> None:
    def refused(words: str, mission: Mission) -> None:
        with pytest.raises(MissionError, match=words):
            make_plan(mission)

    at = {"speed_m_s": 0.5, "sensor": SENSOR}
    off = [Robot(name="a", start=(0.4, 0.5), **at)]
    refused(r"robot a: start: \[0\.4, 0\.5\] .* the nearest is \[0\.5, 0\.5\]", mission_on(ROOM, off, task="cover"))
    tiny = Zone(name="slot", shape=box(3.6, 3.6, 3.9, 3.9), period_s=60, demand="visit")
    refused(r"zones slot: no cell .* has its centre there", mission_on(ROOM, 2, (tiny,)))
    # 45 degrees: every robot ends up along the border and never comes to the middle
    middle = (visit("middle", 60, 4, 6, 5, 7),)
    refused(r"zones middle: no limit cycle", mission_on(ROOM, 2, middle, bouncing_angles_deg=(45,)))
    refused(r"10 robots has 704 \*\* 10 .* GB", mission_on(ROOM, 10, ZONES, method="as_printed"))
    one = [Robot(name="a", start=(0.5, 0.5), **at), Robot(name="b", **at)]
    refused(r"robot b: start: is missing", mission_on(ROOM, one, ZONES))
    refused("fits at the centre of none", mission_on(ROOM, 1, task="cover", body_radius_m=4.6, corners="pass"))
    refused(r"there are only 2 free cells", mission_on("..", 3, task="cover"))
    refused(r"2 robots are not allowed; there is only 1 free cell$", mission_on(".", 2, task="cover"))
    both = [Robot(name="a", start=(0.5, 0.5), **at), Robot(name="b", start=(0.5 + 2e-6, 0.5), **at)]
    refused(r"start", mission_on(ROOM, both, task="cover", body_radius_m=0))
    with pytest.raises(MissionError, match="bouncing_angles_deg: 2 angles"):
        mission_on(ROOM, 3, task="cover", bouncing_angles_deg=(90, 45))
    with pytest.raises(MissionError, match=r"100 is not allowed; it must be a multiple of .* 45 degrees"):
        BounceSettings(cell_m=1, bouncing_angles_deg=(100,))


def test_rings_become_cells_from_the_lower_left_of_the_area() -> None:
    area = MultiPolygon([box(10, 20, 14.2, 22.3)])
    fleet = Fleet(speed_m_s=1, sensor=SENSOR, body_radius_m=0.2, robots=(Robot(name="a", speed_m_s=1, sensor=SENSOR),))
    mission = Mission(name="strip", area=area, fleet=fleet, planning=BounceSettings(cell_m=1, task="cover"))
    cells = make_cells(mission)
    # 5 x 3 cells touch the area; the centres of the last column and row lie outside
    assert cells.count == 4 * 2
    assert cells.centres_m.min(axis=0).tolist() == [10.5, 20.5]


def test_five_robots_take_the_group_that_random_starts_come_to_most() -> None:
    mission = mission_on(ROOM, 5, (visit("east", 400, 7, 0, 10, 10),), purpose="basin", bouncing_angles_deg=(90,))
    plan = make_plan(mission)
    require_drivable(plan, jumps=False)
    assert check_plan(plan).verdict == "met"
    assert make_plan(mission) == plan
