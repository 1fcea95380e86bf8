"""How a VDA 5050 vehicle is led so that it keeps to the plan's clock: speeds, waits, and when stops are released.

A stop that has been released cannot be changed any more. So what the vehicle is told of a stop is decided when that is
released: from where it was last, and from what it has taken longer than it was told.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from rota.files.vda5050_orders import NumberedStops, Span, Window, end_without_wait
from rota.routes.route import RouteStop

# what is expected before anything is known, each with its standard deviation: seconds lost at a stop, the share of the
# planned time in which it turns, that of the told time in which it drives, and seconds lost by waiting as it is told
EXPECTED = np.array([0.0, 1.0, 1.0, 0.0])
UNSURE = np.array([0.3, 0.5, 0.05, 0.3])
# by how much these may change from leg to leg, and what a leg takes more or less without a reason
CHANGES = np.array([0.02, 0.03, 0.003, 0.02])
NOISE_S = 0.3
BLOCKED_S = 3.0  # a leg that takes so much longer is no sign of how the vehicle drives: somebody stood in its way
SLOWEST = 0.5  # of the planned speed: what a vehicle that is early is slowed down to
EARLY_S = 0.5  # by which it may be early, beyond what slower legs leave of that
KNOWN = 4  # legs, from which on it is known somewhat how it drives: until then stops are released one by one
AHEAD_S = 6.0  # a vehicle has stops for so long ahead of it, however short its legs are
LEAST_DRIVE_S = 1e-3
MOST_ROOM_S = 1.0


class Pace:
    """The times of one vehicle's stops, in seconds of the clock that ``begin`` and ``heard`` are told.

    begun_s: when the plan started by that clock; None until it has. behind_s: how far the clock of all robots, which
    the vehicle keeps to, is behind the plan's.
    """

    def __init__(self, stops: NumberedStops, top_speed_m_s: float) -> None:
        self.stops = stops
        self._top_m_s = top_speed_m_s
        # rounds are alike from the end of the first on: what comes before it may end with another hold than a round
        self._once_s, self._round_s = [0.0], [0.0]
        for number in range(1, stops.arrived + len(stops.every_round) + 1):
            self._once_s.append(self._once_s[-1] + self._planned_s(number))
        for number in self._one_round:
            self._round_s.append(self._round_s[-1] + self._planned_s(number))
        self.begun_s: float | None = None
        self.behind_s = 0.0
        self._last, self._last_s = 0, 0.0
        self._times = LegTimes()
        self._told: dict[int, RouteStop] = {0: replace(stops.stop(0), hold_s=0.0, turn_s=0.0)}
        self._released_s: dict[int, float] = {}

    @property
    def _one_round(self) -> range:
        """The stops of a round like all others."""
        first = len(self.stops.once) + len(self.stops.every_round)
        return range(first, first + len(self.stops.every_round))

    def _planned_s(self, number: int) -> float:
        """From the arrival at the stop before to that at this one, by plan."""
        before, stop = self.stops.stop(number - 1), self.stops.stop(number)
        return before.hold_s + stop.drive_s(before.place_m)

    # ------------------------------------------------------------ the plan's times

    @property
    def zero_s(self) -> float | None:
        """When the plan started as the clock of all has it; None until it has."""
        return None if self.begun_s is None else self.begun_s + self.behind_s

    def begin(self, now_s: float) -> None:
        """The plan's clock starts now, unless it has."""
        if self.begun_s is None:
            self.begun_s = self._last_s = now_s
            self._released_s.clear()  # what was released was so before

    def arrives_s(self, number: int) -> float:
        """When the vehicle is at a stop by plan, in seconds since the start."""
        past = number - (len(self._once_s) - 1)
        if past < 0:
            return self._once_s[number]
        rounds, part = divmod(past, len(self.stops.every_round) or past + 1)
        return self._once_s[-1] + rounds * self._round_s[-1] + self._round_s[part]

    def waits(self, number: int) -> bool:
        """Whether the vehicle is to wait there: by plan, or for what it does not need of the time to turn there."""
        return self.stops.stop(number).wait_s > 0 or self._wait_s(number) > EARLY_S

    def _wait_s(self, number: int) -> float:
        """How long it stands there if it came in time, before it turns in the time that it takes."""
        stop = self.stops.stop(number)
        return stop.wait_s + max(1 - self._times.turn_share, 0.0) * stop.turn_s

    def goes_on_s(self, number: int) -> float:
        """The moment at which it is to be let go on from a stop, before it turns. Never before the start."""
        if self.zero_s is None:
            return math.inf
        lost_s = max(self._times.stop_s, 0.0)
        return self.zero_s + self.arrives_s(number) + self._wait_s(number) - lost_s

    def room_s(self) -> float:
        """What a round leaves to be made up: its waits, and its legs at top speed, as it is expected to drive them.

        No more than ``MOST_ROOM_S``: a vehicle may not be able to drive as fast as it is told.
        """
        room_s, stops = 0.0, self.stops
        for number in self._one_round:
            fastest = self._leg(number, max(self._top_m_s, stops.stop(number).speed_m_s or 0.0), waits=False)
            room_s += self._planned_s(number) - self._times.expected_s(fastest)
        return min(max(room_s, 0.0), MOST_ROOM_S)

    @property
    def end(self) -> int:
        """The last stop that is released."""
        return max(self._told)

    # ------------------------------------------------------------ what happens

    def heard(self, number: int, now_s: float) -> None:
        """The vehicle has reached a stop."""
        if number <= self._last or self.zero_s is None or number not in self._told:
            return
        passed = range(self._last + 1, number + 1)
        waited_s = sum(self._told[k].wait_s for k in passed[:-1])
        legs = [self._leg(k, self._told[k].speed_m_s, waits=self._told[k - 1].wait_s > 0) for k in passed]
        self._times.learn(legs, now_s - waited_s - self._leaves_s(self._last, self._last_s))
        self._last, self._last_s = number, now_s
        for known in (self._told, self._released_s):
            for key in [key for key in known if key < number]:
                del known[key]

    def _expected_s(self, number: int) -> float:
        """When it is expected at a stop that has been released, from where it was last."""
        at_s = self._last_s
        for k in range(self._last + 1, number + 1):
            leg = self._leg(k, self._told[k].speed_m_s, waits=self._told[k - 1].wait_s > 0)
            at_s = self._leaves_s(k - 1, at_s) + self._times.expected_s(leg)
        return at_s

    def _leaves_s(self, number: int, arrives_s: float) -> float:
        """When it sets out from a stop that it reaches then: once it has waited, and the next one is released."""
        return max(arrives_s + self._told[number].wait_s, self._released_s.get(number + 1, -math.inf))

    def _leg(self, number: int, speed_m_s: float | None, *, waits: bool) -> Leg:
        """The leg to a stop at a speed."""
        drive_s = self._lost_s(number) + self._length_m(number) / (speed_m_s or math.inf)
        return Leg(turn_s=self.stops.stop(number - 1).turn_s, drive_s=drive_s, waits=waits)

    def _lost_s(self, number: int) -> float:
        """How long the robot takes to a stop by plan beyond what its speed says: it speeds up and brakes."""
        before, stop = self.stops.stop(number - 1), self.stops.stop(number)
        return max(stop.drive_s(before.place_m) - self._length_m(number) / (stop.speed_m_s or math.inf), 0.0)

    def _length_m(self, number: int) -> float:
        return math.dist(self.stops.stop(number - 1).place_m, self.stops.stop(number).place_m)

    # ------------------------------------------------------------ what it is told

    def span(self, window: Window, *, with_waits: bool) -> Span:
        """The stops of the next message: from the last one that is released to the last that will be, and beyond it.

        Without waits that the vehicle is told, what is released ends where it is to wait.
        """
        stops, first = self.stops, self.end
        farthest = stops.last_within(first, first + len(stops.every_round))
        end = stops.last_within(first, first + (window.released if self._times.learned >= KNOWN else 1))
        while end < farthest and self.arrives_s(end) - self.arrives_s(first) < AHEAD_S:
            end += 1
        if first == 0 and self.zero_s is None and self.waits(0):
            end = 0
        elif with_waits:
            end = end_without_wait(stops, first, end)
        else:
            end = next((number for number in range(first + 1, end) if self.waits(number)), end)
        return Span(first=first, released=end, last=stops.last_within(first, end + window.announced))

    def is_due(self, last: int, window: Window, now_s: float) -> bool:
        """Whether more is to be released to a vehicle that was last at a stop: it needs it, and it is time for it.

        It needs more with half of what a message releases ahead of it, or little time. One that will be early waits
        where what is released ends.
        """
        end = self.end
        if not self.stops.every_round and end >= self.stops.arrived:
            return False
        has_enough = end - last > max(1, window.released // 2)
        if has_enough and self.arrives_s(end) - self.arrives_s(last) > AHEAD_S / 2:
            return False
        is_early = self.zero_s is not None and self._expected_s(end) < self.goes_on_s(end) - EARLY_S
        return not (self.waits(end) or is_early) or now_s >= self.goes_on_s(end)

    def release(self, last: int, now_s: float, *, with_waits: bool) -> None:
        """Decide on the stops that follow those that are released, up to ``last``.

        with_waits: the vehicle knows how to wait. At ``last`` it is not told to: it waits for what is released next.
        """
        first = self.end
        at_s = self._expected_s(first) if self.zero_s is not None else 0.0
        for number in range(first + 1, last + 1):
            self._released_s[number] = now_s
            stop = self.stops.stop(number)
            leaves_s, waits = self._leaves_s(number - 1, at_s), self._told[number - 1].wait_s > 0
            speed_m_s = self._speed_m_s(number, leaves_s, waits)
            at_s = leaves_s + self._times.expected_s(self._leg(number, speed_m_s, waits=waits))
            wait_s = 0.0
            if with_waits and number < last and self.waits(number):
                wait_s = max(self.goes_on_s(number) - at_s, 0.0) if self.zero_s is not None else stop.wait_s
            self._told[number] = replace(stop, speed_m_s=speed_m_s, hold_s=wait_s, turn_s=0.0)

    def _speed_m_s(self, number: int, leaves_s: float, waits: bool) -> float | None:
        """The speed at which it comes to a stop in time, as far as it may drive so fast or so slowly."""
        stop, turn_s = self.stops.stop(number), self.stops.stop(number - 1).turn_s
        if self.zero_s is None or stop.speed_m_s is None:
            return stop.speed_m_s
        drive_s = self._times.drive_s(self.zero_s + self.arrives_s(number) - leaves_s, turn_s, waits)
        needed_m_s = self._length_m(number) / max(drive_s - self._lost_s(number), LEAST_DRIVE_S)
        return min(max(needed_m_s, SLOWEST * stop.speed_m_s), max(self._top_m_s, stop.speed_m_s))

    def told(self, number: int) -> RouteStop:
        """What the vehicle is told of a stop; of one that is not released, what it may be."""
        return self._told.get(number) or replace(self.stops.stop(number), hold_s=0.0, turn_s=0.0)


@dataclass(frozen=True, kw_only=True)
class Leg:
    """A leg as it is told: how long the robot turns by plan, how long it drives at the told speed, and waits before."""

    turn_s: float
    drive_s: float
    waits: bool

    @property
    def parts(self) -> np.ndarray:
        """(4,) what the four learned numbers are multiplied by."""
        return np.array([1.0, self.turn_s, self.drive_s, float(self.waits)])


class LegTimes:
    """A linear model of a vehicle's legs, fitted to each by a Kalman filter (Kalman 1960) whose weights may move.

    learned: how many legs it has learned from.
    """

    def __init__(self) -> None:
        self.learned = 0
        self._weights = EXPECTED.copy()
        self._covariance = np.diag(UNSURE**2)

    def expected_s(self, leg: Leg) -> float:
        """How long a leg is expected to take, without its wait; no less than nothing."""
        return max(float(self._weights @ leg.parts), 0.0)

    @property
    def stop_s(self) -> float:
        """How long a stop costs by itself."""
        return float(self._weights[0])

    @property
    def turn_share(self) -> float:
        """In which share of the planned time it turns."""
        return float(self._weights[1])

    def drive_s(self, left_s: float, turn_s: float, waits: bool) -> float:
        """The told driving time with which a leg takes ``left_s`` in all; below 0 where there is none."""
        rest_s = left_s - float(self._weights @ Leg(turn_s=turn_s, drive_s=0.0, waits=waits).parts)
        return rest_s / float(self._weights[2])

    def learn(self, legs: list[Leg], took_s: float) -> None:
        """Legs, one at least, took so long together, without their waits."""
        parts = np.sum([leg.parts for leg in legs], axis=0)
        off_s = took_s - float(self._weights @ parts)
        if abs(off_s) > BLOCKED_S * len(legs):
            return
        self.learned += len(legs)
        self._covariance = self._covariance + len(legs) * np.diag(CHANGES**2)
        spread = self._covariance @ parts
        gain = spread / (parts @ spread + len(legs) * NOISE_S**2)
        self._weights = self._weights + gain * off_s
        self._covariance = self._covariance - np.outer(gain, spread)
