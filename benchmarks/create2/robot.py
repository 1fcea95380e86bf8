"""A model of the iRobot Create 2: what it does with the bytes it gets, and how its body moves in a mission's map.

The Open Interface as its specification tells it: modes, drive direct, the stream of sensor packets every 15 ms, text
while it boots. The body is a disc that stops where it touches a wall or another robot, or slides along.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

TICK_US = 15_000
RADIUS_M = 0.17
WHEEL_BASE_M = 0.235
PRESSED_M = 1e-3  # by how much the bumper gives way
BOOT_TEXT = b"\n\rbl-start\n\rSTR730\n\rbootloader id: #x47135160 5BFFFFFF\n\r\x13\n\rbattery-current-zero 257\n\r"
BOOT_TICKS = 130  # close to two seconds
ARGUMENTS = {128: 0, 129: 1, 131: 0, 132: 0, 133: 0, 137: 4, 139: 3, 145: 4, 150: 1, 173: 0, 7: 0}
START, SAFE, FULL, DRIVE_DIRECT, STREAM = 128, 131, 132, 145, 148


@dataclass(frozen=True, kw_only=True)
class Faults:
    """What a robot does worse than planned.

    late_bump_s: from the contact to the bit in packet 7, beyond the stream's own delay. turn_error: every turn in place
    is off by a share drawn from -turn_error..turn_error. slides: it slides along what it touches instead of standing.
    """

    late_bump_s: float = 0.0
    turn_error: float = 0.0
    slides: bool = False
    seed: int = 0


@dataclass(kw_only=True)
class Create2:
    """A robot: place and heading, and the state of its interface. ``cliff``, ``dropped``, ``overcurrent`` of
    a wheel, ``clean``, its button: set by whoever tests them.
    """

    x_m: float
    y_m: float
    heading_rad: float
    walls: BaseGeometry
    others: list[Create2] = field(default_factory=list)
    faults: Faults = field(default_factory=Faults)
    mode: str = "off"
    right_m_s: float = 0.0
    left_m_s: float = 0.0
    cliff: bool = False
    dropped: bool = False
    overcurrent: bool = False
    clean: bool = False
    ticks: int = 0
    turns: int = 0

    def __post_init__(self) -> None:
        shapely.prepare(self.walls)
        self._rng = np.random.default_rng(self.faults.seed)
        self._skew = 1.0
        self._command: list[int] = []
        self._stream: list[int] = []
        self._pressed_ticks = 0

    # ------------------------------------------------------------ interface

    def receive(self, byte: int) -> None:
        """Take a byte; a command is obeyed with its last one. While it boots the robot hears nothing."""
        if self.ticks < BOOT_TICKS:
            return
        self._command.append(byte)
        code = self._command[0]
        if code == STREAM:
            wanted = 2 + self._command[1] if len(self._command) > 1 else 2
        elif code in ARGUMENTS:
            wanted = 1 + ARGUMENTS[code]
        else:
            raise AssertionError(f"opcode {code} is not one that a sketch should send")
        if len(self._command) == wanted:
            self._obey(code, self._command[1:])
            self._command = []

    def _obey(self, code: int, data: list[int]) -> None:
        if code == START:
            self.mode = "passive"
        elif self.mode == "off":
            return
        elif code in (SAFE, FULL):
            self.mode = "safe" if code == SAFE else "full"
        elif code == STREAM:
            self._stream = data[1:]
        elif code == DRIVE_DIRECT and self.mode in ("safe", "full"):
            was_turning = self.turns_in_place
            right, left = (_signed(data[k], data[k + 1]) for k in (0, 2))
            assert max(abs(right), abs(left)) <= 500
            self.right_m_s, self.left_m_s = right / 1e3, left / 1e3
            if self.turns_in_place and not was_turning:
                self.turns += 1
                self._skew = 1 + self._rng.uniform(-1, 1) * self.faults.turn_error

    def frame(self) -> bytes:
        """What it sends at the end of a tick: text while it boots, then the stream that was asked for."""
        self.ticks += 1
        if self.ticks <= BOOT_TICKS:
            return BOOT_TEXT[(self.ticks * 4) % len(BOOT_TEXT) :][:4]
        if self.mode == "safe" and (self.cliff or self.dropped):
            self.mode, self.right_m_s, self.left_m_s = "passive", 0.0, 0.0
        bits = self._bump_bits()
        self._pressed_ticks = self._pressed_ticks + 1 if bits else 0
        if self._pressed_ticks * TICK_US <= self.faults.late_bump_s * 1e6:
            bits = 0
        if not self._stream:
            return b""
        values = {7: bits | (0b1100 if self.dropped else 0)}
        values |= {packet: int(self.cliff) for packet in (9, 10, 11, 12)}
        values |= {14: 0b01000 * self.overcurrent, 18: int(self.clean)}
        body = [part for packet in self._stream for part in (packet, values[packet])]
        frame = [19, len(body), *body]
        return bytes([*frame, -sum(frame) % 256])

    # ------------------------------------------------------------ body

    @property
    def turns_in_place(self) -> bool:
        """Whether its wheels turn against each other."""
        return self.right_m_s == -self.left_m_s != 0

    def advance(self, duration_s: float) -> None:
        """Move as the wheels do, up to what is in the way."""
        speed_m_s = (self.right_m_s + self.left_m_s) / 2
        turned = (self.right_m_s - self.left_m_s) / WHEEL_BASE_M * duration_s
        self.heading_rad += turned * (self._skew if self.turns_in_place else 1.0)
        if speed_m_s:
            step = speed_m_s * duration_s
            self._move(step * math.cos(self.heading_rad), step * math.sin(self.heading_rad))

    def _move(self, dx: float, dy: float, may_slide: bool = True) -> None:
        if self._gap_m(self.x_m + dx, self.y_m + dy) >= -1e-9:
            self.x_m, self.y_m = self.x_m + dx, self.y_m + dy
            return
        low, high = 0.0, 1.0
        for _ in range(40):
            middle = (low + high) / 2
            fits = self._gap_m(self.x_m + middle * dx, self.y_m + middle * dy) >= -1e-9
            low, high = (middle, high) if fits else (low, middle)
        self.x_m, self.y_m = self.x_m + low * dx, self.y_m + low * dy
        if self.faults.slides and may_slide:
            bearing = self._bearing(self.x_m, self.y_m)
            along = -dx * math.sin(bearing) + dy * math.cos(bearing)
            along *= (1 - low) * (1 - 1e-6)
            self._move(-along * math.sin(bearing), along * math.cos(bearing), may_slide=False)

    def _gap_m(self, x: float, y: float) -> float:
        """From the body's rim, were it there, to the nearest wall or other robot."""
        gap = float(shapely.distance(self.walls, shapely.Point(x, y))) - RADIUS_M
        return min([gap, *(math.hypot(o.x_m - x, o.y_m - y) - 2 * RADIUS_M for o in self.others)])

    def _bearing(self, x: float, y: float) -> float:
        """Direction of what is nearest."""
        line = shapely.shortest_line(shapely.Point(x, y), self.walls)
        near_x, near_y = line.coords[1]
        nearest_m = math.hypot(near_x - x, near_y - y)
        for other in self.others:
            if math.hypot(other.x_m - x, other.y_m - y) - RADIUS_M < nearest_m:
                near_x, near_y = other.x_m, other.y_m
        return math.atan2(near_y - y, near_x - x)

    def _bump_bits(self) -> int:
        """Bit 1: bump left, bit 0: bump right; both where it is straight ahead."""
        ahead_x = self.x_m + PRESSED_M * math.cos(self.heading_rad)
        ahead_y = self.y_m + PRESSED_M * math.sin(self.heading_rad)
        if self._gap_m(ahead_x, ahead_y) > -PRESSED_M / 4:
            return 0
        off = math.remainder(self._bearing(ahead_x, ahead_y) - self.heading_rad, 2 * math.pi)
        return (0b10 if off > -0.2 else 0) | (0b01 if off < 0.2 else 0)


def _signed(high: int, low: int) -> int:
    value = high << 8 | low
    return value - 65536 if value >= 32768 else value
