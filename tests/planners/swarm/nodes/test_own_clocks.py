"""What is learned of others' clocks from news that are late."""

from __future__ import annotations

import random

import pytest
from tests.planners.swarm.nodes.test_hearing import GOOD, STARTS, SWARM, S, hearing

from rota.planners.swarm.nodes.clocks import Clocks
from rota.planners.swarm.nodes.hearing import Hearing
from rota.planners.swarm.nodes.telling import write_telling


@pytest.mark.parametrize("drift", [0.0, 1e-4, -1e-4])
def test_a_telling_is_dated_no_sooner_than_it_was_told_and_no_later_than_the_promptest(drift: float) -> None:
    rng, clocks, errors_s = random.Random(5), Clocks(shared=False), []
    read = []
    for k in range(2000):
        told_s = 0.1 * k
        read.append((told_s + 0.002 + (rng.random() * 0.4 if k % 5 else 0.0), told_s))  # one in five is prompt
    for read_s, told_s in sorted(read):
        telling = GOOD._replace(told_ns=round((told_s * (1 + drift) + 5000.0) * S))
        clocks.hear(telling, round(read_s * S))
        errors_s.append(clocks.own(telling).told_ns / S - told_s)
    assert min(errors_s) >= -1e-8
    # a prompt one was read up to 0.5 s before: what may drift and does, in that time
    assert max(errors_s) <= 0.002 + 0.5 * 3e-4 + 1e-8


def test_a_clock_that_all_share_is_left_as_it_is() -> None:
    clocks = Clocks(shared=True)
    clocks.hear(GOOD, GOOD.told_ns + S)
    assert clocks.own(GOOD) == GOOD


def test_a_robot_whose_clock_is_far_ahead_is_heard_by_its_own_clock_alone() -> None:
    datagram = write_telling(GOOD._replace(told_ns=9000 * S), SWARM)
    by_one = hearing()
    by_one.hear([datagram], 10 * S)
    assert (by_one.dropped, by_one.is_alive(1, 10 * S)) == (1, False)
    by_own = hearing(own_clocks=True, clock_error_ns=S // 50)
    by_own.hear([datagram], 10 * S)
    assert (by_own.dropped, by_own.is_alive(1, 10 * S)) == (0, True)
    assert by_own.is_alive(1, 10 * S + S // 2)
    assert not by_own.is_alive(1, 10 * S + S // 2 + 1)


def test_what_is_told_beyond_the_radio_range_is_not_received() -> None:
    ear = Hearing(STARTS, 0, SWARM, silent_ns=S // 2, radio_m=5.0)
    ear.hear([write_telling(GOOD, SWARM)], 10 * S, (3.0, 9.001))  # told at (3, 4)
    assert (ear.dropped, ear.is_alive(1, 10 * S)) == (0, False)
    ear.hear([write_telling(GOOD, SWARM)], 10 * S, (3.0, 9.0))
    assert ear.is_alive(1, 10 * S)
