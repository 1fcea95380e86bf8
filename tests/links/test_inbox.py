"""What arrives from outside becomes a report or is counted: nothing else happens, however much of it there is."""

from __future__ import annotations

import asyncio
import math
import random
import tracemalloc
from typing import Any

import pytest

from rota.links.inbox import ReportInbox

BOUNDS = (0.0, 0.0, 100.0, 100.0)
GOOD: dict[str, Any] = {
    "now_s": 10.0, "robot": "a", "time_s": 9.5, "position_m": (1, 2.5, 3), "battery": 0.5, "mode": "running"
}  # fmt: skip


def dropped(inbox: ReportInbox) -> int:
    return sum(rejected.messages for rejected in inbox.rejections.values())


@pytest.mark.parametrize(
    "wrong",
    [
        {"robot": "z"},
        {"robot": ["a"]},
        {"robot": None},
        {"time_s": math.nan},
        {"time_s": 12.1},
        {"time_s": -1e11},
        {"time_s": "9"},
        {"time_s": True},
        {"position_m": (1, 2)},
        {"position_m": (1, 2, math.nan)},
        {"position_m": (math.inf, 2, 3)},
        {"position_m": (1e6 + 101, 2, 3)},
        {"position_m": (10**400, 2, 3)},
        {"position_m": "123"},
        {"position_m": None},
        {"battery": 1.01},
        {"battery": math.nan},
        {"mode": "flying"},
        {"mode": {}},
    ],
    ids=str,
)
def test_what_is_malformed_is_counted_and_dropped(wrong: dict[str, Any]) -> None:
    inbox = ReportInbox(["a", "b"], BOUNDS)
    assert not inbox.offer(**{**GOOD, **wrong})
    assert dropped(inbox) == 1
    assert inbox.take_all() == []
    assert inbox.latest("a") is None


def test_a_good_report_is_kept_and_older_ones_after_it_are_not() -> None:
    inbox = ReportInbox(["a", "b"], BOUNDS)
    assert inbox.offer(**GOOD)
    assert not inbox.offer(**{**GOOD, "time_s": 9.4})
    assert inbox.offer(**{**GOOD, "robot": "b", "time_s": 9.4, "battery": None, "mode": None})
    first, second = inbox.take_all()
    assert (first.robot, first.time_s, first.position_m, first.battery) == ("a", 9.5, (1.0, 2.5, 3.0), 0.5)
    assert (second.robot, second.battery, second.mode) == ("b", None, None)
    assert dropped(inbox) == 1


def test_a_reader_gets_all_in_order_and_ends_when_the_inbox_closes() -> None:
    async def read() -> list[float]:
        inbox = ReportInbox(["a"], BOUNDS)
        taken: list[float] = []

        async def reader() -> None:
            async for report in inbox.reports():
                taken.append(report.time_s)

        task = asyncio.create_task(reader())
        for time_s in (1, 2, 3):
            inbox.offer(**{**GOOD, "time_s": time_s})
            await asyncio.sleep(0)
        inbox.offer(**{**GOOD, "time_s": 4})
        inbox.close()
        await asyncio.wait_for(task, 10)
        return taken

    assert asyncio.run(read()) == [1, 2, 3, 4]


@pytest.mark.slow  # counts memory over many messages
def test_fifty_thousand_messages_leave_nothing_behind() -> None:
    rng = random.Random(0)
    junk = [math.nan, math.inf, -1.0, 1e300, None, "x" * 50, [], {}, b"\0", (1, 2, 3), "a", 9.5, 10**30, True]
    names = ["robot", "time_s", "position_m", "battery", "mode"]
    offers = [{**GOOD, **{name: rng.choice(junk) for name in rng.sample(names, 2)}} for _ in range(1000)]
    inbox = ReportInbox(["a", "b"], BOUNDS, most_waiting=100)
    taken = sum(inbox.offer(**offer) for offer in offers)
    tracemalloc.start()
    kept = []  # after each round; what waits is made anew in the first of them
    for _ in range(49):
        for offer in offers:
            inbox.offer(**offer)
        kept.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    # one byte for each of the last 24,000 messages: other threads' memory is counted as well, and varies
    assert kept[-1] - kept[24] < 24_000
    assert len(inbox.take_all()) == 100
    assert dropped(inbox) >= 50 * (1000 - taken)
