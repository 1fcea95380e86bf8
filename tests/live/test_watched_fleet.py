"""What a watch tells of two robots on a lane, where every time follows from the plan by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from shapely import box
from tests.files.with_mass import with_mass
from tests.live.two_robots import ENDS_PERIOD_S, ROUND_S, SPEED_M_S, driven, two_robots

from rota.live.events import Dropped, Event, Heard, Tick
from rota.live.notices import Notice, lag_text, state_line, summary
from rota.live.settings import WatchSettings
from rota.live.watch import Watch
from rota.model.mission import DiscSensor, Fleet, Mission, Robot, Zone
from rota.model.plan import Plan, Trajectory

SILENT_S = 3.0


def told(watch: Watch, events: list[Event]) -> list[Notice]:
    return [notice for event in events for notice in watch.take(event)]


def watched(plan: Plan | None = None) -> Watch:
    return Watch(plan or two_robots(), WatchSettings(silent_s=SILENT_S))


def test_nothing_is_told_of_robots_that_keep_to_a_plan_that_holds() -> None:
    watch = watched()
    assert told(watch, list(driven(watch.plan, 100.0))) == []
    state = watch.state()
    assert [robot.standing for robot in state.robots] == ["ok", "ok"]
    assert all(abs(robot.lag_s) < 1e-9 and robot.away_m < 1e-6 for robot in state.robots)
    worst = {demand.name: demand.worst_s for demand in state.demands}
    # the farthest lattice point of the zone is seen last from within its reach: at most a round's half apart
    assert 18.0 < worst["left"] <= ROUND_S / 2
    assert watch.lapses == 0


def test_robots_that_speed_up_and_brake_as_planned_are_on_time() -> None:
    plan = with_mass()
    watch = watched(plan)
    for time_s in np.arange(0.0, 150.0, 0.25).tolist():
        for number, way in enumerate(plan):
            x, y = way.at(time_s).tolist()
            watch.take(Heard(time_s, number, time_s, x, y, 25.0, None, "running"))
        watch.take(Tick(time_s))
        moving = watch.state().robots[0]
        assert moving.away_m < 0.06
        # where it stands or hardly moves five centimetres are worth some time
        assert abs(moving.lag_s) < 0.5
        assert moving.standing == "ok"


def test_ages_of_a_place_are_the_time_since_a_robot_was_in_reach() -> None:
    watch = watched(two_robots(zones=False))
    told(watch, list(driven(watch.plan, 30.0)))
    ages, places = watch._ages, watch._ages.places.points_m
    times_s = np.arange(0, 30.0, 0.002)
    tracks_m = [way.at(times_s) for way in watch.plan]
    for number in range(0, len(places), 37):
        at = places[number]
        if 25 < at[0] < 36:
            continue  # beside the obstacle
        seen_s = [times_s[np.hypot(*(track_m - at).T) <= 3.0] for track_m in tracks_m]
        assert ages.last_seen_s[number] == pytest.approx(max(times.max(initial=0) for times in seen_s), abs=0.003)


def test_a_zone_that_names_a_sensor_ages_until_who_has_one_comes() -> None:
    watch = watched(two_robots(thermal=True))
    told(watch, list(driven(watch.plan, 100.0)))
    worst = {demand.name: demand.worst_s for demand in watch.state().demands}
    # the far corners of the first metre are seen within 2.4 m or more of its end, every 40 s; anybody's ground as ever
    assert ROUND_S - 2 * 2.9 / SPEED_M_S < worst["left"] <= ROUND_S
    assert ROUND_S / 2 - 2 * 4.0 / SPEED_M_S <= worst["gate"] <= ROUND_S / 2
    assert worst["area"] <= ROUND_S
    anybody = watched()
    told(anybody, list(driven(anybody.plan, 100.0)))
    assert worst["area"] == next(one.worst_s for one in anybody.state().demands if one.name == "area")


def test_a_silent_robot_is_lost_and_what_lapses_without_it_is_told_in_time() -> None:
    watch = watched()
    # b is silent after 10 s at x = 50; a reaches the right end at 20 s and is back on the left at 40 s
    notices = told(watch, list(driven(watch.plan, 41.0, ends_s={"b": 10.0})))
    lost = notices[0]
    assert (lost.kind, lost.about, lost.time_s) == ("lost", "b", 10.0 + SILENT_S + 0.25)
    assert lost.is_alarm
    # the zone at the left end was last seen by a when it left: its nearest corner at sqrt(8) m, the farthest at x = 1
    lapses = {fact["demand"]: fact["in_s"] for fact in lost.facts["lapses"]}
    assert set(lapses) == {"left"}
    (place,) = [fact["place_m"] for fact in lost.facts["lapses"]]
    half_m = math.sqrt(9 - (place[1] - 2) ** 2)
    assert lapses["left"] == pytest.approx((place[0] + half_m) / SPEED_M_S + ENDS_PERIOD_S - lost.time_s, abs=1e-6)
    kinds = [(notice.kind, notice.about) for notice in notices]
    assert kinds[:3] == [("lost", "b"), ("will lapse", "left"), ("lapsed", "left")]
    due, lapsed = notices[1], notices[2]
    assert lapsed.time_s == pytest.approx(due.time_s + due.facts["in_s"], abs=0.3)
    # a is 83 m and more away when that becomes clear, and has 12 s: it could turn back, which takes it 17 s less
    assert due.time_s <= 15.0
    assert watch.lapses == 1


def test_who_could_still_make_it_goes_round_obstacles_at_its_own_speed() -> None:
    watch = watched()
    notices = told(watch, list(driven(watch.plan, 20.0, ends_s={"b": 8.0})))
    (due,) = [notice for notice in notices if notice.kind == "will lapse"]
    (could,) = due.facts["could"]
    assert could["robot"] == "a"
    x, _ = due.facts["place_m"]
    at_m = SPEED_M_S * due.time_s
    half_m = 0.98 * 3.0  # the ring from which it is looked at
    assert could["takes_s"] == pytest.approx((at_m - x - half_m) / SPEED_M_S, abs=0.3)
    assert could["takes_s"] < due.facts["in_s"]


def test_a_visit_counts_when_a_robot_is_inside() -> None:
    watch = watched()
    told(watch, list(driven(watch.plan, 30.0)))
    gate = next(demand for demand in watch.state().demands if demand.name == "gate")
    # both are in the zone from 48 m to 52 m every 20 s, last until 30.4 s
    assert gate.age_s == 0.0
    # it counts from the first report inside to the last one
    gap_s = 20.0 - 4.0 / SPEED_M_S
    assert gap_s <= gate.worst_s <= gap_s + 2 * 0.25


def test_a_robot_that_stands_is_held_up_and_not_counted_on() -> None:
    plan = two_robots()
    watch = watched(plan)
    events = []
    for event in driven(plan, 45.0):
        stands = isinstance(event, Heard) and event.robot == 1 and event.time_s > 10.0
        events.append(event._replace(x_m=50.0) if stands else event)
    notices = told(watch, events)
    assert (notices[0].kind, notices[0].about) == ("held up", "b")
    assert 12.0 <= notices[0].time_s <= 14.5
    assert ("will lapse", "left") in [(notice.kind, notice.about) for notice in notices]
    assert watch.state().robots[1].lag_s == pytest.approx(35.0, abs=0.5)


def test_a_robot_that_was_ahead_of_its_plan_and_waits_for_it_is_not_held_up() -> None:
    plan = two_robots()
    watch = watched(plan)
    events = []
    for event in driven(plan, 30.0):
        if isinstance(event, Heard) and event.robot == 0:
            # it drives at 7 m/s to where it waits from 10 s on, until it is to be there at 14 s
            waits = 70.0 if event.time_s <= 14.0 else event.x_m
            events.append(event._replace(x_m=min(7.0 * event.time_s, waits)))
        else:
            events.append(event)
    assert [notice.kind for notice in told(watch, events)] == []


def test_a_robot_beside_its_route_is_told_once_and_when_it_is_back() -> None:
    plan = two_robots()
    watch = watched(plan)
    events = []
    for event in driven(plan, 20.0):
        beside = isinstance(event, Heard) and event.robot == 0 and 5.0 <= event.time_s < 8.0
        events.append(event._replace(y_m=3.9) if beside else event)
    kinds = [(notice.kind, notice.time_s) for notice in told(watch, events) if notice.about == "a"]
    assert kinds == [("off route", 5.0), ("on route", 8.0)]


def test_batteries_tell_who_must_leave_and_when() -> None:
    plan = two_robots()
    watch = Watch(plan, WatchSettings(silent_s=SILENT_S, battery_low=0.2))
    # it loses 1 % a second; home is at most 100 m, 20 s, away: it must leave with 10 % + 20 % left, at 70 s
    events: list[Event] = []
    for event in driven(plan, 72.0):
        falls = isinstance(event, Heard) and event.robot == 0
        events.append(event._replace(battery=1 - event.time_s / 100) if falls else event)
    notices = [notice for notice in told(watch, events) if notice.about == "a"]
    assert [notice.kind for notice in notices] == ["battery low", "must leave"]
    low, leave = notices
    assert low.time_s == pytest.approx(21.0, abs=1.1)  # its rate is known after 20 s
    assert low.time_s + low.facts["leaves_in_s"] == pytest.approx(70.0, abs=0.5)
    assert leave.time_s == pytest.approx(70.0, abs=1.1)
    assert "left" in {fact["demand"] for fact in low.facts["lapses"]}


def test_dropped_messages_are_told_once_and_counted() -> None:
    watch = watched()
    events = [
        Tick(0.0),
        Dropped("unknown robot", 2, "ghost"),
        Tick(0.2),
        Dropped("unknown robot", 3, "ghost"),
        Tick(0.4),
    ]
    notices = told(watch, events)
    assert [notice.kind for notice in notices] == ["dropped"]
    assert "ghost" in notices[0].text
    assert watch.state().dropped == {"unknown robot": 5}


def test_ages_wait_for_reports_that_are_late() -> None:
    # a report that took 2 s is no lapse, if what it tells was in time
    plan = two_robots()
    watch = Watch(plan, WatchSettings(silent_s=SILENT_S))
    late: list[Event] = []
    for event in driven(plan, 60.0):
        late.append(event._replace(now_s=event.now_s + 2.0) if isinstance(event, Tick) else event)
    assert told(watch, late) == []
    assert watch.state().known_s == 60.0


def test_a_jump_is_not_driven() -> None:
    plan = two_robots(zones=False)
    watch = watched(plan)
    rows = ((0, 0.1, 1.0), (0, 1.1, 90.0), (1, 1.1, 99.0))
    heard = [Heard(time_s, robot, time_s, x, 2.0, 30.0, None, None) for robot, time_s, x in rows]
    told(watch, [Tick(0.0), *heard, Tick(1.2)])
    seen = watch._ages.last_seen_s > 0
    x = watch._ages.places.points_m[seen][:, 0]
    assert x.min() < 4
    assert not ((x > 5) & (x < 86)).any()


def test_robots_that_began_late_are_found_on_their_routes() -> None:
    plan = two_robots()
    watch = watched(plan)
    late_s = 13.0
    events: list[Event] = [
        event._replace(at_s=event.at_s + late_s, time_s=event.time_s + late_s)
        if isinstance(event, Heard)
        else event._replace(now_s=event.now_s + late_s)
        if isinstance(event, Tick)
        else event
        for event in driven(plan, 30.0)
    ]
    assert told(watch, events) == []
    assert [robot.lag_s for robot in watch.state().robots] == pytest.approx([late_s] * 2)
    assert [robot.standing for robot in watch.state().robots] == ["ok", "ok"]


def test_robots_of_a_small_world_are_not_taken_for_lost_ones() -> None:
    """Reports that err by 0.1 m, of robots that see 0.05 m and go 0.1 m in a second, and of some that creep."""
    rng = np.random.default_rng(0)
    sensor = DiscSensor(radius_m=0.05)
    names = [f"r{k}" for k in range(10)]
    robots = tuple(Robot(name=name, speed_m_s=0.1, sensor=sensor) for name in names)
    mission = Mission(
        name="table",
        area=box(0, 0, 5, 40),
        zones=(Zone(name="spot", shape=box(0, 0, 2, 2), period_s=200.0, demand="visit"),),
        fleet=Fleet(speed_m_s=0.1, sensor=sensor, robots=robots),
    )
    ways = []
    for k, name in enumerate(names):
        y, creeps = 4.0 * k + 1, k >= 5
        far_m, half_s = (0.2, 40.0) if creeps else (3.0, 30.0)
        there_and_back = [[1, y], [1 + far_m, y], [1, y]]
        ways.append(Trajectory(robot=name, times_s=[0, half_s, 2 * half_s], positions_m=there_and_back))
    watch = Watch(Plan(mission=mission, trajectories=tuple(ways)))
    notices: list[Notice] = []
    for event in driven(watch.plan, 120.0):
        if isinstance(event, Heard):
            dx, dy = rng.normal(scale=0.1, size=2).tolist()
            event = event._replace(x_m=event.x_m + dx, y_m=event.y_m + dy)
        notices += watch.take(event)
    assert notices == []
    state = watch.state()
    assert max(abs(robot.lag_s) for robot in state.robots[:5]) < 4.0
    nothing_asked = replace(state, demands=())
    assert state_line(nothing_asked).endswith("all on their routes")
    assert summary(nothing_asked, 0) == "until 120.0 s no period was asked"
    # one of them really stands, the only one that would come to the zone
    for event in driven(watch.plan, 160.0):
        if event[0] > 120.0:
            stands = isinstance(event, Heard) and event.robot == 0
            notices += watch.take(event._replace(x_m=1.0) if stands else event)
    assert [(notice.kind, notice.about) for notice in notices] == [("held up", "r0"), ("will lapse", "spot")]


def test_a_lag_is_told_as_people_say_it() -> None:
    assert lag_text(3.14) == "3.1 s behind its plan"
    assert lag_text(-3.14) == "3.1 s ahead of its plan"
