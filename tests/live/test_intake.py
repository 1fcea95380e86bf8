"""What arrives and does not hold is dropped and counted, however much of it there is."""

from __future__ import annotations

import math
import tracemalloc
from typing import Any

import pytest
from tests.live.two_robots import two_robots

from rota.links.link import Report
from rota.live.events import Dropped, Heard, Tick
from rota.live.intake import Intake
from rota.live.watch import Watch


def intake() -> Intake:
    return Intake(["a", "b"], (0.0, 0.0, 100.0, 4.0), future_s=1.0)


def report(**changes: Any) -> Report:
    fields: dict[str, Any] = {"robot": "b", "time_s": 5.0, "position_m": (1.0, 2.0, 30.0), "battery": 0.5}
    return Report(**{**fields, **changes})


def test_a_report_that_holds_becomes_an_event() -> None:
    taken = intake().take(report(mode="running"), 5.25)
    assert taken == Heard(5.25, 1, 5.0, 1.0, 2.0, 30.0, 0.5, "running")


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"robot": "ghost"}, "unknown robot"),
        ({"robot": ["a"]}, "unknown robot"),
        ({"time_s": math.nan}, "not a number"),
        ({"position_m": (math.inf, 0.0, 0.0)}, "not a number"),
        ({"battery": math.nan}, "not a number"),
        ({"battery": 1.5}, "out of range"),
        ({"position_m": (1e9, 0.0, 0.0)}, "out of range"),
        ({"time_s": 7.0}, "from the future"),
        ({"time_s": "soon"}, "malformed"),
        ({"position_m": (1.0, 2.0)}, "malformed"),
        ({"position_m": (1.0, 2.0, 10**400)}, "malformed"),
        ({"mode": "dancing"}, "malformed"),
    ],
)
def test_what_does_not_hold_is_dropped_with_its_fault(changes: dict[str, Any], fault: str) -> None:
    taker = intake()
    assert taker.take(report(**changes), 5.25) is None
    (dropped,) = taker.take_dropped()
    assert (dropped.fault, dropped.messages) == (fault, 1)
    assert taker.take_dropped() == []
    assert taker.take(report(), 5.25) is not None


def test_reports_out_of_order_and_twice_are_dropped() -> None:
    taker = intake()
    assert taker.take(report(), 5.0) is not None
    assert taker.take(report(), 5.1) is None
    assert taker.take(report(time_s=4.0), 5.2) is None
    assert taker.take(report(time_s=4.0, robot="a"), 5.2) is not None
    assert [(each.fault, each.messages) for each in taker.take_dropped()] == [("out of order", 2)]


def test_a_hundred_thousand_malformed_messages_do_no_harm_and_take_no_room() -> None:
    taker, watch = intake(), Watch(two_robots())
    watch.take(Tick(0.0))
    bad = [report(robot=f"\x1b[31mghost {k}") for k in range(50)] + [report(time_s=math.nan)] * 50

    def flood(rounds: range) -> int:
        notices = 0
        for k in rounds:
            for each in bad:
                assert taker.take(each, 5.0) is None
            for dropped in taker.take_dropped():
                assert isinstance(dropped, Dropped)
                assert dropped.example.isprintable()
                watch.take(dropped)
            notices += [notice.kind for notice in watch.take(Tick(0.01 * k))].count("dropped")
        return notices

    assert flood(range(1, 1001, 5)) == 2  # each fault is told once; by now the watch has used all its compiled loops
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    assert flood(range(1001, 1801)) == 0
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert grown < 100_000
    assert watch.state().dropped == {"unknown robot": 50_000, "not a number": 50_000}
