"""The time since a plan's start, on a machine that puts the process off and whose clock is set."""

from __future__ import annotations

import pytest

from rota.links import plan_clock
from rota.links.plan_clock import DRIFT_S, PlanClock


class Machine:
    """Its two clocks; each reading takes ``pause_s``, and the system's clock is ``ahead_s`` ahead."""

    def __init__(self, ahead_s: float) -> None:
        self.passed_s, self.pause_s, self.ahead_s = 0.0, 0.0, ahead_s

    def monotonic(self) -> float:
        self.passed_s += self.pause_s
        return self.passed_s

    def time(self) -> float:
        return self.monotonic() + self.ahead_s


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Machine:
    machine = Machine(1e9)
    monkeypatch.setattr(plan_clock, "time", machine)
    return machine


def test_an_instant_stays_where_it_is_however_slowly_the_clocks_are_read(machine: Machine) -> None:
    clock = PlanClock("", "start_time")
    clock.begin()
    first_s = clock.of_unix_s(1e9 + 5)
    assert first_s == pytest.approx(5)
    for machine.pause_s in (0.2, 0.0, 3.0):
        assert clock.of_unix_s(1e9 + 5) == first_s


def test_a_clock_that_is_set_is_followed(machine: Machine) -> None:
    clock = PlanClock("", "start_time")
    clock.begin()
    clock.of_unix_s(1e9)
    machine.ahead_s += 2 * DRIFT_S
    assert clock.of_unix_s(1e9 + 5) == pytest.approx(5 - 2 * DRIFT_S, abs=1e-6)
