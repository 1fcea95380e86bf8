"""Robots kept in phase: what a slow one costs all, what is told of it, and simulated vehicles that lose time."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Iterator

import pytest
from tests.links.fleets import loop_of, plan_of
from tests.live.two_robots import two_robots
from tests.seeds import seeds

from rota.errors import LinkError
from rota.links.link import Link, Order
from rota.links.link_settings import make_link
from rota.links.sending import routes_for, send_all, start_all
from rota.live.driving import Driving
from rota.live.keeping import Keeping, Slack, looked_back_s
from rota.live.notices import Notice, NoticeKind, RobotState, Standing
from rota.live.watch import Watch
from rota.model.plan import Plan, Trajectory


def state(name: str, lag_s: float, standing: Standing = "ok") -> RobotState:
    return RobotState(
        name=name, standing=standing, place_m=(0.0, 0.0), away_m=0.0, lag_s=lag_s, silent_s=0.0, battery=None,
        leaves_in_s=None, mode="running",
    )  # fmt: skip


def looks(keeping: Keeping, until_s: int, loses: float) -> Iterator[tuple[list[Order], list[Notice]]]:
    """What comes of robot a losing a share of the time that passes, and of b driving as it is told."""
    for now_s in range(until_s + 1):
        yield keeping.look(float(now_s), (state("a", loses * now_s), state("b", keeping.behind_s)))


def test_all_drive_as_slowly_as_the_slowest_and_what_lapses_by_that_is_told() -> None:
    slack = {"left": Slack(gap_s=24.0, period_s=25.0), "lane": Slack(gap_s=40.0, period_s=60.0)}
    keeping = Keeping(two_robots(), slack)
    told = [notice for _, notices in looks(keeping, 400, 0.05) for notice in notices]
    assert keeping.rate == pytest.approx(0.95, abs=1e-3)
    assert 0.2 < keeping.late_s(state("a", 20.0)) < 0.51  # it was a second late: all waited until it had caught up
    assert [(notice.kind, notice.about) for notice in told] == [("too slow", "a")]
    assert told[0].text == (
        "a cannot keep up: 0.9 s late, at 0.95 of its pace; all go on at 0.95 of the plan's pace; at that pace left is"
        " seen every 25.3 s of 25 s"
    )
    assert keeping.behind_s == pytest.approx(19.6, abs=0.2)
    orders, _ = keeping.look(401.0, (state("a", 20.0), state("b", keeping.behind_s)))
    assert {order.behind_s for order in orders} == {keeping.behind_s}
    assert keeping.least_pace() == (pytest.approx(0.96), "left")


def test_nobody_waits_for_one_that_is_slower_than_half_or_held_up() -> None:
    keeping = Keeping(two_robots(), {})
    told = [notice for _, notices in looks(keeping, 100, 0.6) for notice in notices]
    assert keeping.rate == 1.0
    assert told[0].text.endswith("at 0.40 of its pace; the others go on without it")
    orders, notices = keeping.look(101.0, (state("a", 80.0, "held up"), state("b", 0.0)))
    assert [order.robot for order in orders] == ["b"]
    assert notices == []


def test_one_that_is_late_and_early_at_the_same_places_of_every_round_slows_nobody_down() -> None:
    """On a round of 43 s it is up to 4 s late: over 40 s that looked like a pace of its own."""
    keeping, round_s = Keeping(plan_of(round_of("a", 43.0)), {}), 43.0
    rates = []
    for now_s in range(600):
        lag_s = 4 * math.sin(2 * math.pi * now_s / round_s)
        keeping.look(float(now_s), (state("a", lag_s),))
        rates.append(keeping.rate)
    assert min(rates[86:]) == pytest.approx(1.0)  # from its second round on; 0.992 over 40 s
    assert looked_back_s(43.0) == 43.0
    assert looked_back_s(15.0) == 45.0
    assert looked_back_s(0.0) == 40.0  # it stays
    assert looked_back_s(621.0) == 120.0


def round_of(name: str, round_s: float) -> Trajectory:
    return Trajectory(robot=name, times_s=[0.0, round_s / 2, round_s], positions_m=[[0, 0], [20, 0], [0, 0]])


def test_what_is_expected_of_a_robot_where_it_is_does_not_count_as_late() -> None:
    keeping = Keeping(two_robots(), {})
    (a, b), _ = keeping.look(10.0, (state("a", 3.0), state("b", 0.5)), expected_s={"a": 2.75})
    assert (a.late_s, b.late_s) == (0.25, 0.5)
    assert keeping.late_s(state("a", 3.0)) == 0.25


def test_orders_say_what_is_late_against_the_clock_of_all() -> None:
    keeping = Keeping(two_robots(), {})
    (a, b), _ = keeping.look(10.0, (state("a", 3.0), state("b", -2.0)))
    assert (a.late_s, b.late_s, a.rate) == (3.0, -2.0, 1.0)


def after_ten_rounds(plan: Plan, *given: str, keeps: bool = True) -> tuple[list[float], list[str]]:
    """How late simulated vehicles are after ten rounds of 45 s, and what was told."""
    link, watch, keeping = make_link("simulated", plan, ["clock=0", *given]), Watch(plan), Keeping(plan, {})
    told: list[str] = []

    async def drive() -> None:
        await link.open()
        await send_all(link, routes_for(plan, link))
        await start_all(link, routes_for(plan, link))
        driving = Driving(Plain(link) if not keeps else link, watch, keeping, None, lambda n: told.append(n.text))
        await driving.drive(until_s=452.0, should_stop=lambda: False)

    asyncio.run(drive())
    return [robot.lag_s for robot in watch.state().robots], told


class Plain:
    """A link whose robots cannot be kept in phase."""

    keeps_phase = False

    def __init__(self, link: Link) -> None:
        self._link = link

    def __getattr__(self, name: str) -> object:
        return getattr(self._link, name)


SLOW = ("slower=0.05", "stop_noise_s=0.3")


@pytest.mark.parametrize("seed", seeds(3, at_once=1))
def test_vehicles_that_are_slower_and_lose_time_at_stops_keep_their_phase_where_legs_leave_room(seed: int) -> None:
    plan = plan_of(loop_of("a", 0.0), loop_of("b", 200.0), loop_of("c", 400.0))
    lags_s, _ = after_ten_rounds(plan, *SLOW, keeps=False)
    assert min(lags_s) > 20
    lags_s, told = after_ten_rounds(plan, *SLOW, f"seed={seed}")
    assert max(map(abs, lags_s)) < 1.0
    assert told == []


def test_a_link_that_does_not_answer_is_told_once() -> None:
    class Deaf(Plain):
        keeps_phase = True

        async def keep(self, order: Order) -> None:
            raise LinkError(f"robot {order.robot}: no answer")

    plan = plan_of(loop_of("a", 0.0))
    told: list[str] = []

    async def drive() -> None:
        link = Deaf(make_link("simulated", plan, ["clock=0"]))
        driving = Driving(link, Watch(plan), Keeping(plan, {}), None, lambda n: told.append(n.text))  # type: ignore[arg-type]
        await send_all(link, routes_for(plan, link))  # type: ignore[arg-type]
        await start_all(link, routes_for(plan, link))  # type: ignore[arg-type]
        await driving.drive(until_s=30.0, should_stop=lambda: False)

    asyncio.run(drive())
    assert told == ["robot a: no answer; it is not kept in phase meanwhile"]


def test_a_robot_that_waits_for_the_clock_of_all_is_not_told_to_be_held_up() -> None:
    plan = two_robots()
    watch, keeping, told = Watch(plan), Keeping(plan, {}), []
    driving = Driving(make_link("simulated", plan), watch, keeping, None, lambda notice: told.append(notice.kind))

    def happens(kind: NoticeKind) -> None:
        driving._look([Notice(time_s=1.0, kind=kind, about="a", text="")])

    happens("held up")
    happens("goes on")
    assert told == []
    keeping.behind_s = -2.0  # now it is two seconds late
    happens("held up")
    happens("goes on")
    assert told == ["held up", "goes on"]
