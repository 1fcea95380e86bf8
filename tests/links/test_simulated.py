"""Simulated vehicles: where they are against the plan, what their seed decides, and their faults."""

from __future__ import annotations

import asyncio
import math
import time
from typing import Any

import numpy as np
import pytest
from tests.files.with_mass import with_mass
from tests.links.fleets import dropped, loop_of, plan_of, reports_until, routes_of, send_and_start, three
from tests.relieved import relieved, with_battery

from rota.errors import LinkError, RotaError
from rota.links.link import Dock, Order, Report
from rota.links.link_settings import make_link
from rota.model.plan import Plan, Trajectory

EXACT = ("clock=0", "speed_noise=0", "position_noise_m=0", "delay_s=0")


def driven(plan: Plan, until_s: float, *given: str) -> list[Report]:
    async def drive() -> list[Report]:
        link = make_link("simulated", plan, given)
        await send_and_start(link, plan)
        return await reports_until(link, until_s)

    return asyncio.run(drive())


def planned_m(trajectory: Trajectory, time_s: float) -> list[float]:
    """Where the plan has a robot, by its definition: legs at constant speed, the loop for ever."""
    if time_s > trajectory.times_s[-1]:
        past = math.fmod(time_s - trajectory.loop_start_s, trajectory.loop_duration_s or 1.0)
        time_s = trajectory.loop_start_s + past if trajectory.loop_duration_s else trajectory.times_s[-1]
    return [float(np.interp(time_s, trajectory.times_s, trajectory.positions_m[:, axis])) for axis in (0, 1)]


def test_exact_vehicles_are_where_the_plan_has_them_in_every_round() -> None:
    plan = three()
    trajectories = {trajectory.robot: trajectory for trajectory in plan}
    reports = driven(plan, 200.0, *EXACT)
    assert len(reports) > 2900
    for report in reports:
        expected = [*planned_m(trajectories[report.robot], report.time_s), 25.0]
        np.testing.assert_allclose(report.position_m, expected, atol=1e-6)
    assert {report.mode for report in reports} == {"running"}


def test_exact_vehicles_with_motion_speed_up_and_cut_corners_as_planned() -> None:
    plan = with_mass()
    moving = plan.trajectories[0]
    reports = [report for report in driven(plan, 200.0, *EXACT) if report.robot == "a"]
    assert len(reports) > 900
    planned = moving.at([report.time_s for report in reports])
    told = np.array([report.position_m[:2] for report in reports])
    assert np.linalg.norm(told - planned, axis=1).max() < 0.05 + 1e-6
    # only where it waits it stops, and loses time
    late = [report for report in driven(plan, 200.0, *EXACT, "stop_noise_s=1") if report.robot == "a"]
    off = np.linalg.norm(np.array([report.position_m[:2] for report in late]) - planned, axis=1)
    assert off[: int(5 * moving.loop_start_s)].max() < 0.05 + 1e-6
    assert off.max() > 1


def test_the_same_seed_gives_the_same_reports_and_another_one_others() -> None:
    noisy = ("clock=0", "lost=0.2", "holdups_per_h=100", "failures_per_h=20", "battery_s=90", "delay_s=1")
    first, second, other = (driven(three(), 100.0, *noisy, f"seed={seed}") for seed in (7, 7, 8))
    assert first == second
    assert first != other
    assert len(first) < 0.9 * 3 * 500


def test_noise_changes_the_pace_by_the_share_asked_for() -> None:
    plan = plan_of(*(loop_of(f"r{k}", 0.0) for k in range(50)))
    reports = driven(plan, 14.0, "clock=0", "speed_noise=0.1", "position_noise_m=0", "delay_s=0")
    along_m = np.array([report.position_m[0] for report in reports if abs(report.time_s - 10.0) < 1e-6])
    assert len(along_m) == 50
    assert 1.0 < along_m.std() < 4.5  # 10 s at about 4 m/s and 10 %, for whose paces 10 s are a long time or a short
    assert abs(along_m.mean() - 32.0) < 2.5


def test_batteries_run_down_and_leave_vehicles_where_they_are() -> None:
    reports = driven(plan_of(loop_of("a", 0.0)), 30.0, *EXACT, "battery_s=10")
    charge = {round(report.time_s, 6): report.battery for report in reports}
    assert charge[5.0] == pytest.approx(0.5)
    assert reports[-1].mode == "failed"
    assert reports[-1].battery == 0.0
    assert reports[-1].position_m == pytest.approx((32.0, 0.0, 25.0))


def test_leaving_the_ground_takes_its_share_of_a_battery() -> None:
    # of 400 s the take-off takes 30; robot-1 takes off at 0 and lands after 180 s, robot-2 is on its pad until 160 s
    reports = driven(with_battery(relieved(3), takeoff_s=30), 170.0, *EXACT)
    left = {(report.robot, round(report.time_s, 6)): report.battery for report in reports}
    assert left["robot-1", 10.0] == pytest.approx((400 - 30 - 10) / 400)
    assert left["robot-2", 150.0] == 1.0
    assert left["robot-2", 165.0] == pytest.approx((400 - 30 - 5) / 400, abs=0.002)


def test_vehicles_charge_when_they_have_landed_and_until_they_climb() -> None:
    # of 400 s robot-1 has 190 when it lands after 180 s; it charges 2 s a second from 206 s on
    plan = with_battery(relieved(2), takeoff_s=30, landing_s=26, climbing_s=13)
    reports = driven(plan, 290.0, *EXACT)
    left = {(report.robot, round(report.time_s, 6)): (report.battery or 0) * 400 for report in reports}
    at_s = {205.0: 190, 216.0: 210, 286.0: 350}
    assert [left["robot-1", time_s] for time_s in at_s] == pytest.approx(list(at_s.values()), abs=1)

    async def leaves() -> list[float]:
        link = make_link("simulated", plan, EXACT)
        await send_and_start(link, plan)
        await reports_until(link, 290.0)
        found, order = (
            list[float](),
            Order(robot="robot-1", late_s=0, behind_s=0, rate=1, dock=Dock(leaves=True, plan_s=320)),
        )
        for until_s in (291.0, 303.0, 305.0):
            await link.keep(order)
            report = [one for one in await reports_until(link, until_s) if one.robot == "robot-1"][-1]
            found += [(report.battery or 0) * 400, report.position_m[0]]
        return found

    battery_s, x_m = np.array(asyncio.run(leaves())).reshape(-1, 2).T
    # it is told to leave after 290 s, stands for 13 s, and takes off
    assert battery_s == pytest.approx([358, 358, 358 - 30 - 2], abs=2)
    assert x_m == pytest.approx([0, 0, 2], abs=0.6)


def test_pausing_goes_on_from_there_and_home_is_where_it_began() -> None:
    async def drive() -> list[Report]:
        plan = plan_of(loop_of("a", 0.0))
        link = make_link("simulated", plan, EXACT)
        await send_and_start(link, plan)
        found = [(await reports_until(link, 7.0))[-1]]
        await link.pause("a")
        found.append((await reports_until(link, 17.0))[-1])
        await link.start("a")
        found.append((await reports_until(link, 18.0))[-1])
        await link.come_home("a")
        found.append((await reports_until(link, 60.0))[-1])
        assert link.latest("a") == found[-1]
        return found

    running, paused, again, home = asyncio.run(drive())
    assert [report.position_m[0] for report in (running, paused, again, home)] == pytest.approx([20, 20, 24, -10])
    assert [report.mode for report in (running, paused, again, home)] == ["running", "paused", "running", "idle"]


def test_the_clock_can_be_scaled() -> None:
    began = time.monotonic()
    driven(plan_of(loop_of("a", 0.0)), 20.0, "clock=100", "delay_s=0")
    assert 0.15 < time.monotonic() - began < 5


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("b:refuses", "robot b: it refuses its route"),
        ("b:silent", "robot b: it has not answered"),
        ("b:wrong-type", "robot b: it is a vehicle of another type"),
    ],
)
def test_faulty_vehicles_are_named(fault: str, message: str) -> None:
    with pytest.raises(LinkError, match=message):
        driven(three(), 1.0, f"faults={fault}")


def test_a_vehicle_that_keeps_half_of_its_route_is_found_out() -> None:
    async def send() -> tuple[str, ...]:
        link = make_link("simulated", three(), ["faults=a:half"])
        route = routes_of(three())[0]
        await link.send_route(route)
        return await link.differences(route)

    assert asyncio.run(send()) == ("it holds 3 stops of 5",)


def test_the_dead_the_stuck_and_those_that_talk_nonsense() -> None:
    plan = plan_of(*(loop_of(name, 0.0) for name in "abcd"))
    faults = "faults=a:dies@5+b:stuck@5+c:nan@5+d:future@5"

    async def drive() -> tuple[list[Report], int]:
        link = make_link("simulated", plan, [*EXACT, faults])
        await send_and_start(link, plan)
        return await reports_until(link, 10.0), dropped(link)

    reports, rejected = asyncio.run(drive())
    last = {report.robot: report for report in reports}
    assert [last[name].time_s < 5.01 for name in "acd"] == [True] * 3
    assert last["b"].time_s == pytest.approx(10.0)
    assert last["b"].position_m[0] == pytest.approx(12.0, abs=1.0)
    assert rejected == 52  # two vehicles, 5 Hz, from 5 s to 10 s


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("rate_hz=0", r"simulated\.rate_hz: 0 is not allowed; it must be greater than 0"),
        ("rate_hz=fast", r'simulated\.rate_hz: "fast" is not allowed; a number is needed'),
        ("rate=5", r"--set: 'rate=5' is not allowed; KEY=VALUE is needed, with KEY one of seed, clock"),
        ("faults=z:dies@5", r"simulated\.faults: 'z:dies@5' is not allowed; ROBOT:refuses, .* of a, b, c"),
        ("faults=a:dies", r"simulated\.faults: 'a:dies' is not allowed"),
        ("faults=a:refuses@nan", r"simulated\.faults: 'a:refuses@nan' is not allowed"),
        ("lost=nan", r"simulated\.lost: \.nan is not allowed; a finite number is needed"),
    ],
)
def test_bad_settings_are_refused(given: str, message: str) -> None:
    with pytest.raises(RotaError, match=message):
        make_link("simulated", three(), [given])


def test_unknown_links_and_keys_given_twice_are_refused() -> None:
    with pytest.raises(RotaError, match="--link: 'radio' is not one of 'simulated'"):
        make_link("radio", three())
    with pytest.raises(RotaError, match="--set: seed is given twice"):
        make_link("simulated", three(), ["seed=1", "seed=2"])


def test_two_hundred_vehicles_take_a_small_part_of_a_core() -> None:
    plan = plan_of(*(loop_of(f"r{k}", 0.0) for k in range(200)))
    began_s = time.process_time()
    reports: Any = driven(plan, 60.0, "clock=0")
    used_s = time.process_time() - began_s
    assert len(reports) > 200 * 295
    assert used_s < 30  # of 60 s, with sending and much to spare for loaded machines
