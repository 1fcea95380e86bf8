"""What a robot's process tells the others: one datagram of a fixed form, and how it is read, or dropped.

A datagram has no lengths and no names that a reader would follow. It is ``SIZE`` bytes with the right beginning, the
number of the swarm and a check sum, and every number in it lies within its limits; anything else is no telling.
"""

from __future__ import annotations

import math
import struct
import zlib
from hashlib import blake2b
from typing import NamedTuple

from rota.model.limits import LARGEST_M
from rota.model.mission import Mission

WAITING, MEMBER, LEFT = 0, 1, 2  # stands and announces itself; takes part; has left, and stands where it is
MOST_ROBOTS = 4096  # numbers of robots are below that
LONGEST_HOLD_NS = 10_000_000_000
FASTEST_M_S = 1e5
MOST_COUNTED = 2**32 - 1
ROUNDED = 1 + 1e-9  # speeds may exceed the top speed by rounding

# beginning, version, state, swarm, robot, tick, dropped, busy, told, hold, then x, y, height, vx, vy, body, sensor, top
FORM = struct.Struct("<4sBBQIIIIqQ8d")
CHECK = struct.Struct("<I")
SIZE = FORM.size + CHECK.size
BEGINNING, VERSION = b"rota", 1


class Telling(NamedTuple):
    """What one robot says of itself at the beginning of a tick.

    robot: its number in the fleet. told_ns: when, by the clock that all share. It goes with the velocity (vx, vy) from
    (x, y) until told_ns + hold_ns, then stands, and decides no sooner than then again. tick: how often it has decided;
    dropped: datagrams that it could not read; busy_us: processor time of its last tick. Metres, metres per second.
    """

    state: int
    robot: int
    tick: int
    dropped: int
    busy_us: int
    told_ns: int
    hold_ns: int
    x: float
    y: float
    height_m: float
    vx: float
    vy: float
    body_m: float
    sensor_m: float
    speed_m_s: float

    @property
    def end_ns(self) -> int:
        """When it stands, unless it has decided again."""
        return self.told_ns + self.hold_ns

    def place_at(self, time_ns: int) -> tuple[float, float]:
        """Where it is at a time by what it told: on its way until ``end_ns``, and there from then on."""
        gone_s = min(max(time_ns - self.told_ns, 0), self.hold_ns) * 1e-9
        return self.x + self.vx * gone_s, self.y + self.vy * gone_s


def swarm_number(mission: Mission, seed: int) -> int:
    """A number that differs between swarms, so that robots of another mission on the same ports are not heeded."""
    obstacles = [(obstacle.shape.wkb, obstacle.blocks) for obstacle in mission.obstacles]
    told = (mission.name, mission.area.wkb, obstacles, mission.fleet, mission.planning, mission.moving_obstacles, seed)
    return int.from_bytes(blake2b(repr(told).encode(), digest_size=8).digest(), "little")


def write_telling(telling: Telling, swarm: int) -> bytes:
    """The datagram, ``SIZE`` bytes."""
    body = FORM.pack(BEGINNING, VERSION, telling.state, swarm, *telling[1:])
    return body + CHECK.pack(zlib.crc32(body))


def read_telling(datagram: bytes, swarm: int) -> Telling | None:
    """What a datagram tells, or None: of another form, length or swarm, damaged, or with a number out of range."""
    if len(datagram) != SIZE or CHECK.unpack_from(datagram, FORM.size)[0] != zlib.crc32(datagram[: FORM.size]):
        return None
    beginning, version, state, of_swarm, *rest = FORM.unpack_from(datagram)
    if beginning != BEGINNING or version != VERSION or of_swarm != swarm:
        return None
    telling = Telling(state, *rest)
    return telling if is_sound(telling) else None


def is_sound(telling: Telling) -> bool:
    """Whether every number is finite and within its limits; only members move, and none faster than its top speed."""
    if telling.state not in (WAITING, MEMBER, LEFT) or telling.robot >= MOST_ROBOTS:
        return False
    if not 0 < telling.hold_ns <= LONGEST_HOLD_NS or telling.told_ns < 0:
        return False
    if not all(map(math.isfinite, telling[7:])):
        return False
    lengths = (telling.x, telling.y, telling.height_m, telling.body_m, telling.sensor_m)
    if max(map(abs, lengths)) > LARGEST_M or telling.body_m < 0 or telling.sensor_m <= 0:
        return False
    if not 0 < telling.speed_m_s <= FASTEST_M_S:
        return False
    speed = math.hypot(telling.vx, telling.vy)
    return speed <= telling.speed_m_s * ROUNDED and (speed == 0 or telling.state == MEMBER)
