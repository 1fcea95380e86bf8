"""Reliefs live, with simulated vehicles: who stays on its charger, who leaves it, and who holds its post."""

from __future__ import annotations

import asyncio
import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from shapely import box
from tests.live.two_robots import two_robots
from tests.relieved import FLIGHT_S, TURN_S, WAY_S, relieved

from rota.links.link import Report
from rota.links.link_settings import make_link
from rota.links.sending import routes_for, send_all, start_all
from rota.live.driving import Driving
from rota.live.events import Heard, Tick
from rota.live.keeping import Keeping, robots_waited_for, teams_apart
from rota.live.notices import Notice, NoticeKind, RobotState
from rota.live.reliefs import Reliefs
from rota.live.watch import Watch
from rota.model.fleet import Robot
from rota.model.mission import Charger, Zone
from rota.model.plan import Plan

EXACT = ("clock=0", "speed_noise=0", "position_noise_m=0", "delay_s=0", "rate_hz=1")
ENDURANCE_S, RESERVE_S = 400.0, 40.0
EVERYBODY = frozenset(f"robot-{k}" for k in (1, 2, 3))


@dataclass
class Flown:
    """What was told, and each robot's batteries (t, share) and places (t, x, y)."""

    told: list[Notice] = field(default_factory=list)
    batteries: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    places: dict[str, list[tuple[float, float, float]]] = field(default_factory=dict)
    behind_s: float = 0.0

    def times_of(self, kind: NoticeKind, robot: str) -> list[float]:
        return [notice.time_s for notice in self.told if (notice.kind, notice.about) == (kind, robot)]

    def at(self, robot: str, time_s: float) -> tuple[float, float]:
        return next((x, y) for at_s, x, y in self.places[robot] if at_s >= time_s)


def in_time(_: str) -> float:
    return 0.0


def fly(plan: Plan, until_s: float, *given: str) -> Flown:
    """A plan flown by simulated vehicles."""
    link, watch, keeping, flown = (
        make_link("simulated", plan, [*EXACT, *given]),
        Watch(plan),
        Keeping(plan, {}),
        Flown(),
    )
    take = link._inbox.offer

    def note(**told: object) -> None:
        report = Report(**{key: value for key, value in told.items() if key != "now_s"})  # type: ignore[arg-type]
        flown.batteries.setdefault(report.robot, []).append((report.time_s, report.battery or 0.0))
        flown.places.setdefault(report.robot, []).append((report.time_s, *report.position_m[:2]))
        take(**told)

    link._inbox.offer = note

    async def drive() -> None:
        await link.open()
        await send_all(link, routes_for(plan, link))
        await start_all(link, routes_for(plan, link))
        await Driving(link, watch, keeping, None, flown.told.append).drive(until_s=until_s, should_stop=lambda: False)

    asyncio.run(drive())
    flown.behind_s = keeping.behind_s
    return flown


def test_robots_fly_their_single_flights_in_order_at_the_plans_times() -> None:
    flown = fly(relieved(3), 1000.0)
    for k in range(3):
        name, starts = f"robot-{k + 1}", np.arange(k * TURN_S, 1000, 3 * TURN_S)
        left = flown.times_of("takes off", name)
        assert left == pytest.approx([time_s for time_s in starts if 0 < time_s < 990], abs=8.0)
        landings = [start + FLIGHT_S for start in [starts[0] - 3 * TURN_S, *starts] if 0 < start + FLIGHT_S < 995]
        assert flown.times_of("lands", name) == pytest.approx(landings, abs=8.0)
        levels = [level for _, level in flown.batteries[name]]
        assert min(levels) == pytest.approx(1 - FLIGHT_S / ENDURANCE_S, abs=0.03)
    assert not [notice for notice in flown.told if notice.kind in ("relief late", "does not wait", "lapsed", "held up")]


def test_a_robot_holds_its_post_until_its_relief_comes() -> None:
    """Batteries fill at 0.26 s a second instead of 2: after two flights the first robot lacks a flight's."""
    flown = fly(relieved(3), 1100.0, "slower_charging=0.87")
    (late_s,), (comes_s,) = flown.times_of("relief late", "robot-1"), flown.times_of("relief comes", "robot-1")
    assert late_s == pytest.approx(6 * TURN_S, abs=8.0)
    level = next(level for at_s, level in flown.batteries["robot-1"] if at_s >= comes_s)
    assert level == pytest.approx((FLIGHT_S + RESERVE_S) / ENDURANCE_S - 0.01, abs=0.005)
    assert comes_s - late_s > 60
    assert flown.behind_s == pytest.approx(comes_s - late_s, abs=8.0)
    # robot-3 is on the square, half a round before its relief would have been there, and stays
    held = [flown.at("robot-3", time_s) for time_s in np.linspace(late_s + 3, comes_s - 1, 20)]
    assert np.ptp(np.array(held), axis=0).max() < 0.3
    assert math.dist(held[0], (0, 0)) >= WAY_S
    assert not flown.times_of("does not wait", "robot-3")
    assert flown.times_of("lands", "robot-3")[-1] == pytest.approx(comes_s + WAY_S * 2 - 2, abs=4.0)


def two_teams(apart_m: float = 100.0) -> Plan:
    """The relay, and another one beside it with a pad of its own and batteries that fill twice as fast."""
    plan, far = relieved(3), Charger(name="far", at=(apart_m, 0), places=3)
    fleet = plan.mission.fleet
    quick = replace(fleet.battery, recharge_s=100)
    robots = [Robot(name=f"robot-{k}", battery=fleet.battery) for k in (1, 2, 3)]
    others = [
        replace(
            way,
            robot=f"other-{k}",
            positions_m=way.positions_m + np.array([apart_m, 0]),
            charges=tuple(replace(stay, charger="far") for stay in way.charges),
        )
        for k, way in enumerate(plan, start=1)
    ]
    mission = replace(
        plan.mission,
        area=box(-5, -5, apart_m + 40, 30),
        chargers=(plan.mission.chargers[0], far),
        fleet=replace(fleet, robots=[*robots, *(Robot(name=way.robot, battery=quick) for way in others)]),
    )
    return replace(plan, mission=mission, trajectories=(*plan.trajectories, *others))


def test_robots_of_other_loops_do_not_wait() -> None:
    flown = fly(two_teams(), 1100.0, "slower_charging=0.87")
    (late_s,), (comes_s,) = flown.times_of("relief late", "robot-1"), flown.times_of("relief comes", "robot-1")
    assert comes_s - late_s > 60
    held = [flown.at("robot-3", time_s) for time_s in np.linspace(late_s + 3, comes_s - 1, 20)]
    assert np.ptp(np.array(held), axis=0).max() < 0.3
    others = [flown.at("other-3", time_s) for time_s in np.linspace(late_s + 3, comes_s - 1, 20)]
    assert np.ptp(np.array(others), axis=0).max() >= 9
    assert flown.times_of("takes off", "other-1")[-1] == pytest.approx(6 * TURN_S, abs=8.0)
    assert flown.times_of("takes off", "robot-1")[-1] == pytest.approx(comes_s, abs=8.0)


@pytest.mark.parametrize("body_m", [0.0, pytest.param(0.1, marks=pytest.mark.slow)])
def test_nobody_holds_for_a_late_launch_but_where_bodies_are_kept_apart(body_m: float) -> None:
    """One round each, 60 s of which the square is left alone; the first robot's battery alone fills too slowly."""
    plan = relieved(3, rounds=1)
    fleet = plan.mission.fleet
    robots = [
        Robot(name=way.robot, body_radius_m=body_m, battery=replace(fleet.battery, recharge_s=200 if k == 0 else 5))
        for k, way in enumerate(plan)
    ]
    plan = replace(plan, mission=replace(plan.mission, fleet=replace(fleet, robots=robots)))
    assert robots_waited_for(plan) == (EVERYBODY if body_m else frozenset())
    flown = fly(plan, 1700.0, "slower_charging=0.99")
    (late_s,) = flown.times_of("relief late", "robot-1")
    assert late_s == pytest.approx(9 * TURN_S, abs=8.0)
    (notice,) = [notice for notice in flown.told if notice.kind == "relief late"]
    left = [time_s for time_s in flown.times_of("takes off", "robot-2") if time_s > late_s]
    if body_m:
        assert notice.text.endswith("robots hold their posts as long as their batteries let them")
        assert left == []
        assert flown.behind_s > 200
    else:
        assert notice.text.endswith("nobody holds a post for it, and the others go on")
        assert left == pytest.approx([10 * TURN_S], abs=8.0)
        assert flown.behind_s == 0


def test_who_does_not_charge_or_relieves_somebody_is_waited_for() -> None:
    assert robots_waited_for(relieved(3)) == EVERYBODY
    assert robots_waited_for(two_robots()) == {"a", "b"}


def test_teams_are_apart_where_nothing_depends_on_how_they_follow_each_other() -> None:
    plan = two_teams()
    first, other = [f"robot-{k}" for k in (1, 2, 3)], [f"other-{k}" for k in (1, 2, 3)]

    def teams(of: Plan) -> set[frozenset[str]]:
        numbers = teams_apart(of)
        return {frozenset(name for name in numbers if numbers[name] == number) for number in numbers.values()}

    assert teams(plan) == {frozenset(first), frozenset(other)}
    together = {frozenset([*first, *other])}
    # a pad with fewer places than robots; bodies; ground that both see, and neither in time alone
    pads = tuple(replace(pad, places=5, name="pad") for pad in plan.mission.chargers[:1])
    shared = tuple(
        replace(way, charges=tuple(replace(stay, charger="pad") for stay in way.charges)) for way in plan.trajectories
    )
    assert teams(replace(plan, mission=replace(plan.mission, chargers=pads), trajectories=shared)) == together
    fleet = plan.mission.fleet
    wide = replace(fleet, robots=[replace(robot, body_radius_m=0.2) for robot in fleet.robots or ()])
    assert teams(replace(plan, mission=replace(plan.mission, fleet=wide))) == together
    # from (50, 10) a robot is out of reach for 20 m of its square and 12 m on either side: for 43 s of 80
    middle, near = Zone(name="middle", shape=box(49, 9, 51, 11), period_s=50), two_teams(apart_m=60.0)
    for period_s, expected in ((50, {frozenset(first), frozenset(other)}), (40, together)):
        zones = (replace(middle, period_s=period_s),)
        assert teams(replace(near, mission=replace(near.mission, zones=zones))) == expected


def test_it_leaves_at_its_reserve_which_is_told() -> None:
    flown = fly(relieved(3), 1100.0, "slower_charging=0.94")
    (late_s,), (leaves_s,) = flown.times_of("relief late", "robot-1"), flown.times_of("does not wait", "robot-3")
    assert leaves_s > late_s + 20
    assert flown.times_of("relief comes", "robot-1") == []
    lands_s = flown.times_of("lands", "robot-3")[-1]
    assert lands_s - leaves_s == pytest.approx(2 * WAY_S, abs=3.0)
    least = ENDURANCE_S * min(level for _, level in flown.batteries["robot-3"])
    assert RESERVE_S - 2 <= least <= RESERVE_S + 4
    (notice,) = [notice for notice in flown.told if notice.kind == "does not wait"]
    assert notice.text.startswith("robot-3 does not wait any longer: 5")
    assert notice.is_alarm


def test_nobody_waits_for_a_relief_that_is_lost() -> None:
    flown = fly(relieved(3), 400.0, "faults=robot-2:dies@100")
    assert flown.times_of("lost", "robot-2")
    assert not [notice for notice in flown.told if notice.kind in ("relief late", "does not wait")]
    assert flown.times_of("lands", "robot-1") == pytest.approx([FLIGHT_S], abs=4.0)


def state(name: str, place_m: tuple[float, float], lag_s: float, battery: float | None) -> RobotState:
    return RobotState(
        name=name, standing="ok", place_m=place_m, away_m=0.0, lag_s=lag_s, silent_s=0.0, battery=battery,
        leaves_in_s=None, mode="running",
    )  # fmt: skip


def test_who_tells_no_battery_leaves_in_time_and_does_not_wait() -> None:
    reliefs = Reliefs(relieved(3), EVERYBODY)
    pad, post = state("robot-2", (0.0, 0.0), 0.0, None), state("robot-1", (10.0, 10.0), -5.0, None)
    conduct, told = reliefs.look(TURN_S - 1, (pad, post), in_time)
    assert not conduct.docks["robot-2"].leaves
    conduct, more = reliefs.look(TURN_S, (pad, post), in_time)
    assert conduct.docks["robot-2"].leaves
    assert conduct.hurried == {"robot-1"}
    assert [notice.text for notice in (*told, *more)] == ["robot-1 does not wait any longer: its battery is not known"]


def test_who_has_to_take_off_is_told_before_its_time() -> None:
    reliefs, pad = Reliefs(relieved(3), EVERYBODY), state("robot-2", (0.0, 0.0), 0.0, 1.0)
    assert not reliefs.look(TURN_S - 16, (pad,), in_time, 15.0)[0].docks["robot-2"].leaves
    conduct, _ = reliefs.look(TURN_S - 14, (pad,), in_time, 15.0)
    assert (conduct.docks["robot-2"].leaves, conduct.docks["robot-2"].plan_s) == (True, TURN_S)


def test_a_late_relief_is_waited_for_while_it_climbs_but_not_for_ever() -> None:
    """Its battery is there 20 s late, by which its team's clock has stood still; it climbs for 15 s."""
    reliefs, waiting = Reliefs(relieved(3), EVERYBODY), []
    for now_s in range(0, 60, 5):
        pad = state("robot-2", (0.0, 0.0), 0.0, 1.0 if now_s >= 20 else 0.2)
        conduct, _ = reliefs.look(TURN_S + now_s, (pad,), lambda _, now_s=now_s: float(now_s), 15.0)
        waiting.append((conduct.docks["robot-2"].leaves, conduct.late == ("robot-2",)))
    assert waiting == [(now_s >= 20, now_s < 20 + 15) for now_s in range(0, 60, 5)]
    gone, _ = reliefs.look(TURN_S + 60, (state("robot-2", (3.0, 0.0), 60.0, 0.9),), lambda _: 60.0, 15.0)
    assert (gone.docks, gone.late) == ({}, ())


def test_a_robot_on_its_charger_sees_nothing() -> None:
    """Both are at the pad: robot-1 is about to leave it, robot-2 charges there."""
    plan, ages = relieved(3), []
    for robot in ("robot-1", "robot-2"):
        watch = Watch(replace(plan, trajectories=(plan[robot],)))
        watch.take(Tick(0.0))
        for time_s in np.arange(0.2, 3.0, 0.2).tolist():
            watch.take(Heard(time_s, 0, time_s, time_s if robot == "robot-1" else 0.0, 0.0, 0.0, 1.0, "running"))
            watch.take(Tick(time_s))
        ages.append(float(watch.last_seen_s.max()))
    assert ages == [pytest.approx(2.8), 0.0]
