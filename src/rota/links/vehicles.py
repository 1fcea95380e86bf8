"""Simulated vehicles, all on arrays: each drives its route at its own pace, is held up, runs down and dies.

A vehicle's route is a chain of segments: straight at constant speed, or a wait. ``Vehicles.step`` moves all of them.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from rota.links.link import Mode
from rota.model.arrays import Flags, Floats, Ints
from rota.model.plan import Trajectory
from rota.routes.route import Place3, Route, RouteStop

PACE_MEMORY_S = 10.0  # in which a vehicle's pace becomes another
SLOWEST, FASTEST = 0.2, 2.0  # paces, as multiples of the planned speed
CATCH_UP_S = 4.0  # in which a vehicle makes up what it is late by, if it may drive so fast
AT_PAD_M, STILL_M = 0.5, 1e-6  # from a pad, within which a vehicle that does not move charges
STILL_S = 1e-9  # by which rounding may tell a time too late
HOME_SPEED_M_S = 1.0  # of a vehicle that is called home and never had a speed


class Segment(NamedTuple):
    """From one place to another in ``duration_s``; a wait where they are the same. stops: whether it ends at a stop."""

    start_m: Place3
    end_m: Place3
    duration_s: float
    is_drive: bool
    stops: bool = True


@dataclass(kw_only=True)
class Drive:
    """What one vehicle drives: ``segments``, of which those from ``repeats_from`` on are repeated for ever.

    repeats_from None: it stays at the last one's end.
    """

    segments: list[Segment]
    repeats_from: int | None


def drive_of(route: Route) -> Drive:
    """A route as segments; it begins at the route's start on the height that the vehicle takes off to."""
    if route.planned is not None:
        return _drive_as_planned(route.planned, route.start_m[2])
    once = _segments(route.start_m, route.once)
    rounds = _segments(route.loop[0].place_m, route.every_round)
    return Drive(segments=once + rounds, repeats_from=len(once) if rounds else None)


def _drive_as_planned(planned: Trajectory, height_m: float) -> Drive:
    """A trajectory as segments, at a height in metres where it has none; it stops where it waits."""
    places: list[Place3] = [(at[0], at[1], at[2] if len(at) > 2 else height_m) for at in planned.positions_m.tolist()]
    durations_s = np.diff(planned.times_s).tolist()
    waits = [start == end for start, end in itertools.pairwise(places)]
    after = [*waits[1:], bool(waits) and waits[planned.loop_index % len(waits)]]
    segments = [
        Segment(start, end, duration_s, not wait, wait or next_waits)
        for (start, end), duration_s, wait, next_waits in zip(
            itertools.pairwise(places), durations_s, waits, after, strict=True
        )
    ]
    return Drive(segments=segments, repeats_from=planned.loop_index if planned.loop_duration_s > 0 else None)


def drive_home(place_m: Place3, home_m: Place3, speed_m_s: float) -> Drive:
    """Straight home."""
    return Drive(segments=_segments(place_m, [RouteStop(place_m=home_m, speed_m_s=speed_m_s)]), repeats_from=None)


def _segments(at_m: Place3, stops: list[RouteStop] | tuple[RouteStop, ...]) -> list[Segment]:
    """The drives and waits from a place past the stops, without those of no time."""
    made: list[Segment] = []
    for stop in stops:
        length_m = math.dist(at_m, stop.place_m)
        if length_m > 0:
            made.append(Segment(at_m, stop.place_m, stop.drive_s(at_m), True))
        if stop.hold_s > 0:
            made.append(Segment(stop.place_m, stop.place_m, stop.hold_s, False))
        at_m = stop.place_m
    return [segment for segment in made if segment.duration_s > 0]


@dataclass(kw_only=True)
class Vehicle:
    """What one vehicle has been told, beside what it is doing. top_m_s: what it drives at most."""

    home_m: Place3
    top_m_s: float = math.inf
    route: Route | None = None
    drive: Drive | None = None
    mode: Mode = "idle"


class Pads(NamedTuple):
    """Where vehicles charge: places_m (p, 2), and the share of a battery that a second there adds, (n, p).

    landing_s, climbing_s: (n,) how long a vehicle is there before that, and after that, when it is told to leave.
    """

    places_m: Floats
    fills: Floats
    landing_s: Floats
    climbing_s: Floats


@dataclass(frozen=True, kw_only=True)
class Tables:
    """The drives of all vehicles end to end: (s, 3) metres, (s,) seconds, and which segment comes after each.

    most: (s,) how many times as fast as told a vehicle drives a segment at most. stops: (s,) whether it drives there to
    a stop.
    """

    start_m: Floats
    step_m: Floats
    duration_s: Floats
    is_drive: Flags
    most: Floats
    stops: Flags
    after: Ints


@dataclass(kw_only=True)
class Vehicles:
    """A fleet at ``time_s``. positions_m (n, 3); battery (n,) from 1 to 0; running (n,); held_until_s (n,).

    ``segment`` (n,) is where each is in the tables, ``done_s`` (n,) how far into it, below 0 while it loses time at the
    stop before; ``told_pace`` (n,) how many times as fast as its route says it is to drive. slower: the share by which
    all are slower than that. stop_noise_s: the deviation of the time that is lost at each stop. speed_noise: the
    standard deviation of paces. battery_s: (n,) how long batteries last while driving; infinite: for
    ever. takeoffs: (n,) the share of them that leaving the ground takes. pads: where they charge.
    """

    vehicles: list[Vehicle]
    rng: np.random.Generator
    speed_noise: float
    battery_s: Floats
    takeoffs: Floats
    pads: Pads | None = None
    slower: float = 0.0
    stop_noise_s: float = 0.0
    time_s: float = 0.0
    battery: Floats = field(init=False)
    running: Flags = field(init=False)
    positions_m: Floats = field(init=False)
    held_until_s: Floats = field(init=False)
    told_pace: Floats = field(init=False)
    _noise: Floats = field(init=False)
    _segment: Ints = field(init=False)
    _done_s: Floats = field(init=False)
    _grounded: Flags = field(init=False)
    _stood_s: Floats = field(init=False)
    _leaves_s: Floats = field(init=False)
    _tables: Tables | None = None

    def __post_init__(self) -> None:
        n = len(self.vehicles)
        self.battery, self.running = np.ones(n), np.zeros(n, dtype=bool)
        self.positions_m = np.array([vehicle.home_m for vehicle in self.vehicles], dtype=np.float64).reshape(n, 3)
        self.held_until_s, self._done_s = np.full(n, -math.inf), np.zeros(n)
        self.told_pace, self._grounded = np.ones(n), np.ones(n, dtype=bool)
        self._stood_s, self._leaves_s = np.full(n, math.inf), np.full(n, math.inf)
        self._noise = self.rng.standard_normal(n)
        self._segment = np.zeros(n, dtype=np.int64)

    def place_m(self, k: int) -> Place3:
        """Where the k-th vehicle is."""
        x, y, height = self.positions_m[k].tolist()
        return x, y, height

    def give(self, k: int, drive: Drive | None) -> None:
        """Let the k-th vehicle have a drive, from its beginning, or none."""
        firsts = self._firsts()
        inside = self._segment - firsts
        self.vehicles[k].drive = drive
        inside[k], self._done_s[k], self.told_pace[k] = 0, 0.0, 1.0
        self._tables = None
        self._segment = self._firsts() + inside

    def keep(self, k: int, late_s: float, rate: float) -> None:
        """Let the k-th vehicle gain so much time: by its pace, and by less of the wait that it is in."""
        self.told_pace[k] = rate * max(0.0, 1 + late_s / CATCH_UP_S)
        if self._tables is None:
            return
        at = self._segment[k]
        lasting_s = self._tables.duration_s[at]
        if not self._tables.is_drive[at] and late_s > 0 and math.isfinite(lasting_s) and self._done_s[k] >= 0:
            self._done_s[k] = min(lasting_s, self._done_s[k] + late_s)

    def dock(self, k: int, leaves: bool) -> None:
        """Let the k-th vehicle, at its charger or all but there, climb and leave it, or come to it and stay."""
        if not leaves:
            self._leaves_s[k] = math.inf
        elif math.isinf(self._leaves_s[k]):
            self._leaves_s[k] = self.time_s + (0.0 if self.pads is None else self.pads.climbing_s[k])
        leaves = leaves and self.time_s >= self._leaves_s[k] - STILL_S
        at, tables = self._segment[k], self._tables
        waits = tables is not None and not tables.is_drive[at]
        self.told_pace[k] = 1.0 if leaves or (not waits and self._done_s[k] > 0) else 0.0
        if tables is not None and waits and leaves and math.isfinite(tables.duration_s[at]):
            self._done_s[k] = tables.duration_s[at]

    def _firsts(self) -> Ints:
        """The number of each vehicle's first segment; each drive is followed by one that lasts for ever."""
        counts = [1 + len(vehicle.drive.segments) if vehicle.drive else 1 for vehicle in self.vehicles]
        return np.cumsum([0, *counts[:-1]], dtype=np.int64)

    def _made_tables(self) -> Tables:
        """The vehicles' drives as arrays, one row a segment."""
        starts: list[Place3] = []
        steps: list[list[float]] = []
        durations: list[float] = []
        drives: list[bool] = []
        stops: list[bool] = []
        most: list[float] = []
        after: list[int] = []
        for k, vehicle in enumerate(self.vehicles):
            drive, first = vehicle.drive, len(durations)
            for start, end, duration_s, is_drive, stops_there in drive.segments if drive else []:
                starts.append(start)
                steps.append([b - a for a, b in zip(start, end, strict=True)])
                durations.append(duration_s)
                drives.append(is_drive)
                stops.append(is_drive and stops_there)
                most.append(vehicle.top_m_s * duration_s / math.dist(start, end) if is_drive else 1.0)
                after.append(len(durations))
            if drive and drive.repeats_from is not None:
                after[-1] = first + drive.repeats_from
            starts.append(drive.segments[-1].end_m if drive and drive.segments else self.place_m(k))
            steps.append([0.0, 0.0, 0.0])
            durations.append(math.inf)
            drives.append(False)
            stops.append(False)
            most.append(1.0)
            after.append(len(durations) - 1)
        return Tables(
            start_m=np.array(starts, dtype=np.float64),
            step_m=np.array(steps, dtype=np.float64),
            duration_s=np.array(durations),
            is_drive=np.array(drives, dtype=bool),
            stops=np.array(stops, dtype=bool),
            most=np.maximum(most, 1.0),
            after=np.array(after, dtype=np.int64),
        )

    def step(self, until_s: float) -> None:
        """Let time pass for all until ``until_s``; the same seed and orders give the same places, bit by bit."""
        if self._tables is None:
            self._tables = self._made_tables()
        tables, duration_s = self._tables, until_s - self.time_s
        memory = math.exp(-duration_s / PACE_MEMORY_S)
        self._noise = memory * self._noise + math.sqrt(1 - memory**2) * self.rng.standard_normal(len(self._noise))
        pace = (1 - self.slower) * np.clip(1 + self.speed_noise * self._noise, SLOWEST, FASTEST)
        moving = self.running & (self.battery > 0)
        # a vehicle that is held up until some time within the step drives for the rest of it
        left_s = np.clip(until_s - np.maximum(self.held_until_s, self.time_s), 0, duration_s) * moving
        going = np.flatnonzero(left_s > 0)
        while len(going):
            segment = self._segment[going]
            driven = np.minimum(self.told_pace[going], tables.most[segment]) * pace[going]
            rate = np.where(tables.is_drive[segment] & (self._done_s[going] >= 0), driven, 1.0)
            goal_s = np.where(self._done_s[going] < 0, 0.0, tables.duration_s[segment])
            with np.errstate(divide="ignore"):
                rest_s = (goal_s - self._done_s[going]) / rate
            reaches = rest_s <= left_s[going]
            ends = reaches & (self._done_s[going] >= 0)
            taken_s = np.where(reaches, rest_s, left_s[going])
            lost_s = np.where(tables.stops[segment], self._lost_s(len(going)), 0.0)
            begun_s = np.where(ends, -lost_s, 0.0)
            self._done_s[going] = np.where(reaches, begun_s, self._done_s[going] + taken_s * rate)
            self._segment[going] = np.where(ends, tables.after[segment], segment)
            left_s[going] -= taken_s
            going = going[reaches & (left_s[going] > 0)]
        self.time_s = until_s
        lasting = tables.duration_s[self._segment]
        share = np.divide(
            np.maximum(self._done_s, 0.0), lasting, out=np.zeros_like(lasting), where=np.isfinite(lasting)
        )
        driven = tables.start_m[self._segment] + share[:, None] * tables.step_m[self._segment]
        before_m, self.positions_m = self.positions_m, np.where(moving[:, None], driven, self.positions_m)
        at_pad, gains = self._gains(before_m, duration_s)
        filled = gains * duration_s * moving
        leaves = self._grounded & (np.abs(self.positions_m - before_m).max(axis=1, initial=0.0) > STILL_M)
        self._grounded = (self._grounded & ~leaves) | (at_pad & moving)
        used = np.where(at_pad, 0.0, moving * duration_s / self.battery_s) + self.takeoffs * leaves
        self.battery = np.clip(self.battery + filled - used, 0.0, 1.0)

    def _gains(self, before_m: Floats, duration_s: float) -> tuple[Flags, Floats]:
        """Who is at a pad, (n,), and what a second adds to each battery (n,): to those that neither land nor climb.

        They have stood there since they were at ``before_m``, so many seconds ago.
        """
        if self.pads is None:
            return np.zeros(len(self.vehicles), np.bool_), np.zeros(len(self.vehicles))
        stood = np.abs(self.positions_m - before_m).max(axis=1) <= STILL_M
        self._stood_s = np.where(stood, self._stood_s + duration_s, 0.0)
        climbs = np.isfinite(self._leaves_s) & (self.pads.climbing_s > 0)
        charges = (self._stood_s > self.pads.landing_s) & ~climbs
        off_m = np.hypot(*np.moveaxis(self.positions_m[:, None, :2] - self.pads.places_m, -1, 0))
        at = off_m.argmin(axis=1)
        rows = np.arange(len(at))
        at_pad = stood & (off_m[rows, at] <= AT_PAD_M) & (self.pads.fills[rows, at] > 0)
        return at_pad, np.where(at_pad & charges, self.pads.fills[rows, at], 0.0)

    def _lost_s(self, stops: int) -> Floats:
        """What is lost at so many stops, (stops,) seconds."""
        if self.stop_noise_s == 0:
            return np.zeros(stops)
        return self.stop_noise_s * np.abs(self.rng.standard_normal(stops))

    def has_arrived(self, k: int) -> bool:
        """Whether the k-th vehicle has come to the end of a drive that has one."""
        drive = self.vehicles[k].drive
        return drive is None or bool(self._segment[k] - self._firsts()[k] == len(drive.segments))
