"""What robots' processes send and hear: the form of a datagram, what is dropped, and who is forgotten."""

from __future__ import annotations

import math
import random
import tracemalloc
import zlib

import pytest

from rota.planners.swarm.delayed_news_kernels import MOST_SPEED_GAIN
from rota.planners.swarm.nodes.apart import reach_m
from rota.planners.swarm.nodes.hearing import Hearing, Start
from rota.planners.swarm.nodes.telling import (
    CHECK,
    FORM,
    LEFT,
    MEMBER,
    SIZE,
    Telling,
    read_telling,
    write_telling,
)

S = 1_000_000_000
SWARM = 77
GOOD = Telling(MEMBER, 1, 5, 0, 300, 10 * S, S // 10, 3.0, 4.0, 50.0, 1.0, -2.0, 0.5, 25.0, 3.0)
STARTS = tuple(Start(10.0 * k, 0.0, 0.5) for k in range(3))


def hearing(**changed: int) -> Hearing:
    return Hearing(STARTS, 0, SWARM, **{"silent_ns": S // 2, **changed})


def test_what_is_told_is_read_again() -> None:
    datagram = write_telling(GOOD, SWARM)
    assert len(datagram) == SIZE < 200
    assert read_telling(datagram, SWARM) == GOOD
    assert read_telling(datagram, SWARM + 1) is None


@pytest.mark.parametrize(
    "wrong",
    [
        {"state": 3}, {"robot": 4096}, {"told_ns": -1}, {"hold_ns": 0}, {"hold_ns": 11 * S}, {"x": math.nan},
        {"y": math.inf}, {"height_m": -math.inf}, {"x": 2e8}, {"vx": 2.5}, {"vy": math.nan}, {"body_m": -0.1},
        {"sensor_m": 0.0}, {"speed_m_s": 0.0}, {"speed_m_s": 1e6}, {"speed_m_s": math.nan}, {"state": LEFT},
    ],
)  # fmt: skip
def test_numbers_out_of_range_are_no_telling(wrong: dict[str, float]) -> None:
    assert read_telling(write_telling(GOOD._replace(**wrong), SWARM), SWARM) is None


def malformed(count: int) -> list[bytes]:
    """Noise, cut off and prolonged tellings, flipped bits, and right check sums over wrong numbers."""
    rng, good = random.Random(1), write_telling(GOOD, SWARM)
    found = []
    while len(found) < count:
        kind = rng.randrange(5)
        if kind == 0:
            datagram = rng.randbytes(rng.randrange(0, 2 * SIZE))
        elif kind == 1:
            datagram = good[: rng.randrange(SIZE)]
        elif kind == 2:
            datagram = good + rng.randbytes(1)
        elif kind == 3:
            bit = rng.randrange(8 * SIZE)
            datagram = bytes(byte ^ (1 << bit % 8 if k == bit // 8 else 0) for k, byte in enumerate(good))
        else:
            body = good[: FORM.size - 64] + rng.randbytes(64)
            datagram = body + CHECK.pack(zlib.crc32(body))
        if read_telling(datagram, SWARM) is None:
            found.append(datagram)
    return found


def test_a_hundred_thousand_malformed_datagrams_leave_nothing_behind() -> None:
    some, ear = malformed(2000), hearing()
    ear.hear([write_telling(GOOD, SWARM)], 10 * S)
    ear.hear(some, 10 * S)
    tracemalloc.start()
    before, _ = tracemalloc.get_traced_memory()
    for _ in range(50):
        ear.hear(some, 10 * S)
    after, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert ear.dropped == 102_000
    assert after - before < 100_000  # a byte for each: other threads' memory is counted as well, and varies
    assert [known.robot for known in ear.known_bodies(10 * S, 10 * S)] == [1, 2]


def test_late_doubled_and_disordered_tellings_change_nothing() -> None:
    ear = hearing()
    new, old = GOOD._replace(told_ns=11 * S, x=5.0), GOOD
    ear.hear([write_telling(t, SWARM) for t in (new, old, new, old)], 11 * S)
    assert ear.known_bodies(11 * S, 11 * S)[0].x == 5.0
    assert ear.dropped == 0


def test_tellings_of_strangers_of_the_future_and_of_oneself_are_not_heeded() -> None:
    ear = hearing(clock_error_ns=S)
    ear.hear(
        [write_telling(GOOD._replace(robot=3), SWARM), write_telling(GOOD._replace(told_ns=13 * S), SWARM)], 10 * S
    )
    assert ear.dropped == 2
    ear.hear(
        [write_telling(GOOD._replace(robot=0), SWARM), write_telling(GOOD._replace(told_ns=11 * S), SWARM)], 10 * S
    )
    assert ear.dropped == 2
    assert [known.is_member for known in ear.known_bodies(10 * S, 10 * S)] == [True, False]


def test_a_robot_is_believed_where_it_told_it_goes_until_it_is_forgotten() -> None:
    ear = hearing()
    ear.hear([write_telling(GOOD, SWARM)], 10 * S)
    later = ear.known_bodies(10 * S + S // 20, 10 * S + S // 20)[0]
    assert (later.x, later.y) == pytest.approx((3.05, 3.9))
    assert (later.vx, later.vy) == (1.0, -2.0)
    after = ear.known_bodies(10 * S + S // 4, 10 * S + S // 4)[0]
    assert (after.x, after.y) == pytest.approx((3.1, 3.8))
    assert (after.vx, after.vy) == (0.0, 0.0)
    assert ear.is_alive(1, 10 * S + S // 2)
    assert not ear.is_alive(1, 10 * S + S // 2 + 1)
    # a body where it stopped and one where it starts; robot 2 was never heard
    silent = ear.known_bodies(20 * S, 20 * S)
    assert [(known.robot, known.is_member) for known in silent] == [(1, False), (1, False), (2, False)]
    assert (silent[0].x, silent[0].reach_m) == (10.0, 0.0)
    assert (silent[1].x, silent[1].y) == pytest.approx((3.1, 3.8))
    assert silent[1].reach_m == pytest.approx(ear.known_bodies(10 * S + S // 2, 10 * S + S // 2)[0].reach_m)


def test_one_that_said_that_it_left_is_where_it_said() -> None:
    ear = hearing()
    ear.hear([write_telling(GOOD._replace(state=LEFT, vx=0.0, vy=0.0), SWARM)], 10 * S)
    bodies = [known for known in ear.known_bodies(10 * S, 11 * S) if known.robot == 1]
    assert [(known.x, known.reach_m, known.is_member) for known in bodies] == [(10.0, 0.0, False), (3.0, 0.0, False)]


def test_reach_is_the_integral_of_the_greatest_speed() -> None:
    standing = GOOD._replace(vx=0.0, vy=0.0)
    hold, gain = 0.1, 3.0 * MOST_SPEED_GAIN
    end = standing.end_ns
    assert reach_m(standing, end, end) == 0.0
    assert reach_m(standing, end, end + S // 4) == pytest.approx(gain * (hold + 2 * hold + 3 * hold / 2))
    # nearest to the closed form by small steps, from the middle of a hold on
    speed = math.hypot(GOOD.vx, GOOD.vy)
    steps = [min(3.0, speed + gain * math.ceil((t + 0.5) / 1000)) * hold / 1000 for t in range(30_000)]
    half = GOOD.told_ns + S // 20
    assert reach_m(GOOD, half, GOOD.end_ns + 3 * S) == pytest.approx(speed * 0.05 + sum(steps), rel=1e-6)
    assert reach_m(GOOD._replace(hold_ns=1), end, GOOD.told_ns + S) == pytest.approx(3.0, rel=1e-6)  # and in no time
