"""Work in a thread of its own, and the rule by which it is stopped and left; processor time is made up."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from rota.planning import stopping
from rota.planning.stopping import GRACE_S, OwnThread, StopRule, WorkLeftError, put_off, work_left_running


@pytest.fixture
def used(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[float]]:
    """The processor time of this process, which a test sets."""
    used_s = [100.0]
    monkeypatch.setattr(time, "process_time", lambda: used_s[0])
    return used_s


def test_after_the_stop_processor_time_counts_and_no_other(used: list[float]) -> None:
    rule = StopRule(None, lambda: True)
    assert not rule.is_spent()
    assert rule()
    used[0] += GRACE_S
    assert not rule.is_spent()
    used[0] += 0.01
    assert rule.is_spent()


def test_work_that_uses_no_processor_time_is_not_waited_for(used: list[float]) -> None:
    rule = StopRule(None, lambda: True)
    rule.stop()
    ticks = 0
    while not rule.is_spent():
        ticks += 1
    assert ticks * stopping.TICK_S == pytest.approx(stopping.IDLE_S)


def test_one_that_gets_little_of_a_busy_machine_has_all_its_grace(used: list[float]) -> None:
    rule = StopRule(None, lambda: True)
    rule.stop()
    for _ in range(10_000):  # at 1 % of a core
        used[0] += 0.01 * stopping.TICK_S
        assert not rule.is_spent()


def test_what_is_put_off_comes_so_much_processor_time_later(used: list[float]) -> None:
    stopped: list[None] = []
    later = put_off(lambda: bool(stopped), 8.0)
    used[0] += 100
    assert not later()
    stopped.append(None)
    assert not later()
    used[0] += 7.9
    assert not later()
    used[0] += 0.2
    assert later()


def test_who_waits_asks_for_work_that_does_not() -> None:
    calls: list[None] = []
    rule = StopRule(None, lambda: bool(calls.append(None)) or True)
    assert not rule.is_spent()
    assert not calls  # the work may still ask by itself
    rule._asked_s -= 10
    assert not rule.is_spent()
    assert rule.stopped
    late = StopRule(1e-9)
    late.is_spent()
    assert late.stopped


def test_what_work_gives_or_raises_is_given_or_raised() -> None:
    def fails() -> int:
        raise KeyError("gate")

    assert OwnThread(lambda: threading.current_thread()).do_work() is not threading.current_thread()
    with pytest.raises(KeyError, match="gate"):
        OwnThread(fails).do_work()
    with np.errstate(divide="raise"), pytest.raises(FloatingPointError):
        OwnThread(lambda: np.ones(1) / 0).do_work()


def test_who_is_interrupted_while_waiting_leaves_the_work() -> None:
    goes_on = threading.Event()
    own: OwnThread[bool] = OwnThread(goes_on.wait)

    def interrupted() -> bool:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        own.result(interrupted)
    assert own.is_left
    goes_on.set()


def test_work_that_is_left_tells_nobody_anything_more() -> None:
    going_on, ends = threading.Event(), threading.Event()
    raised: list[BaseException] = []

    def work() -> int:
        going_on.wait()
        try:
            own.require_awaited()
        except BaseException as error:
            raised.append(error)
            raise
        finally:
            ends.set()
        return 1

    own: OwnThread[Any] = OwnThread(work)
    assert own.result(lambda: True) is None
    assert work_left_running()
    going_on.set()
    assert ends.wait(30)
    assert isinstance(raised[0], WorkLeftError)
    own._thread.join(30)
    assert not work_left_running()
