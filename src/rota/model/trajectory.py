"""What one robot does: timed points, straight legs between them, then its loop for ever."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from numbers import Real
from typing import Any, TypeVar

import numpy as np

from rota.errors import ArgumentError, PlanError
from rota.model.arrays import Floats
from rota.model.fields import field_of
from rota.model.limits import LARGEST_M, LONGEST_S, SHORTEST_LOOP_S
from rota.model.refusals import shorten

Part = TypeVar("Part")
Place = tuple[float, float]
PLACES: dict[str, Any] = {"least": -LARGEST_M, "most": LARGEST_M}
TIMES: dict[str, Any] = {"least": 0, "most": LONGEST_S}
STAYS: dict[str, Any] = {"least": -LONGEST_S, "most": LONGEST_S}
SHARE: dict[str, Any] = {"least": 0, "most": 1, "newer": True, "spared": True}

BACKWARDS_SHARE = 1e-9  # by which rounding may make an acceleration greater than its leg allows


def freeze(values: object) -> Floats:
    """An array of numbers that nobody can change."""
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def numbers_in(values: object, where: str) -> Floats:
    """The same array; PlanError that names the place for what is none of numbers."""
    try:
        return freeze(values)
    except (TypeError, ValueError):
        raise PlanError(f"{where}: {shorten(repr(values))} is not allowed; numbers are needed") from None


def _times_in(values: object) -> Floats:
    """The times that somebody asks for; ArgumentError for what is none, or not finite."""
    try:
        times_s = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        times_s = None
    if values is None or times_s is None or not np.isfinite(times_s).all():
        raise ArgumentError(f"times_s: {shorten(repr(values))} is not allowed; finite numbers of seconds are needed")
    return times_s


def parts_in(values: Iterable[Part], kind: type[Part], where: str) -> tuple[Part, ...]:
    """A tuple of them; PlanError that names the place for what is of another type."""
    parts = tuple(values) if isinstance(values, Iterable) else (values,)
    for part in parts:
        if not isinstance(part, kind):
            raise PlanError(f"{where}: {shorten(repr(part))} is not allowed; a {kind.__name__} is needed")
    return parts


def bends_of(times_s: Floats, positions_m: Floats, accelerations_m_s2: Floats | None) -> Floats:
    """How the ways along legs (n - 1,) bend in time; see ``Trajectory.bends``."""
    if accelerations_m_s2 is None:
        return np.zeros(len(times_s) - 1)
    lengths = np.sqrt((np.diff(positions_m, axis=0) ** 2).sum(axis=1))
    swept = accelerations_m_s2 * np.diff(times_s) ** 2 / 2
    return np.asarray(np.clip(np.divide(swept, lengths, out=np.zeros(len(swept)), where=lengths > 0), -1.0, 1.0))


def forward_accelerations(times_s: Floats, positions_m: Floats, accelerations_m_s2: Floats) -> Floats:
    """Accelerations along legs (n - 1,), none greater than with which a leg begins or ends at rest.

    Where times were told anew, rounding makes one that did so a hair too great.
    """
    lengths_m = np.sqrt((np.diff(positions_m, axis=0) ** 2).sum(axis=1))
    most = 2 * lengths_m / np.diff(times_s) ** 2
    return np.asarray(np.clip(accelerations_m_s2, -most, most))


def require_battery(who: str, times_s: Floats, charges: tuple[Charge, ...], battery: float) -> None:
    """Raise PlanError for charges that overlap, or begin or end between two of the times, and for no share of 1."""
    if not (isinstance(battery, Real) and 0 <= battery <= 1):
        raise PlanError(f"{who}: battery = {battery!r}; 0 (empty) to 1 (full) is needed")
    ended_s = float(times_s[0])
    for k, charge in enumerate(charges):
        ends = (charge.from_s, charge.until_s)
        if charge.from_s < ended_s or not np.isin(ends, times_s).all():
            raise PlanError(
                f"{who}: charges[{k}] goes from {ends[0]} to {ends[1]}; both must be times of the trajectory, from"
                f" {ended_s} on"
            )
        ended_s = charge.until_s


@dataclass(frozen=True, kw_only=True, eq=False)
class Waypoints:
    """What an autopilot that cuts corners by itself is told of a loop, instead of its legs.

    places_m: (k, 2), k >= 2; the robot begins at the first, and goes round them for ever. times_s: (k + 1,) rising,
    when it leaves the first and when it is nearest to each of the others and to the first again. speed_m_s: what it is
    told for every leg. Raises PlanError for other shapes, numbers that are not finite and a speed that is not above 0.
    """

    places_m: Floats = field_of(
        meaning="the robot begins at the first", form=tuple[Place, ...], count=((2, None),), **PLACES
    )
    times_s: Floats = field_of(
        meaning="left at the first, nearest to the others, then to it",
        form=tuple[float, ...],
        count=((3, None),),
        **TIMES,
    )
    speed_m_s: float = field_of(meaning="told for every leg", above=0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "places_m", freeze(self.places_m))
        object.__setattr__(self, "times_s", freeze(self.times_s))
        places, times = self.places_m, self.times_s
        if places.ndim != 2 or places.shape[1] != 2 or len(places) < 2 or times.shape != (len(places) + 1,):
            raise PlanError(f"waypoints: places {places.shape}, times {times.shape}; (k, 2) and (k + 1,) with k >= 2")
        if not (
            np.isfinite(places).all() and np.isfinite(times).all() and times[0] >= 0 and (np.diff(times) > 0).all()
        ):
            raise PlanError("waypoints: places must be finite, times 0 or more and rising")
        if not 0 < self.speed_m_s < math.inf:
            raise PlanError(f"waypoints: speed_m_s = {self.speed_m_s}; must be greater than 0")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Waypoints):
            return NotImplemented
        same = np.array_equal(self.places_m, other.places_m) and np.array_equal(self.times_s, other.times_s)
        return same and self.speed_m_s == other.speed_m_s


@dataclass(frozen=True, kw_only=True)
class Charge:
    """A stay at a charger, between two of the times of a way; below 0 before a plan took over from another one.

    Raises PlanError for one that does not end later.
    """

    charger: str = field_of(meaning="its name", count=((1, None),))
    from_s: float = field_of(**STAYS)
    until_s: float = field_of(**STAYS)

    def __post_init__(self) -> None:
        if not -LONGEST_S <= self.from_s < self.until_s <= LONGEST_S:
            raise PlanError(
                f"charge: from_s {self.from_s}, until_s {self.until_s}; must be times, the second one later"
            )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Trajectory:
    """Timed points of one robot: straight legs, each at a constant acceleration, then the loop for ever.

    times_s: (n,) seconds, from 0, strictly increasing; n >= 1. positions_m: (n, 2) or (n, 3) metres. headings_rad: (n,)
    or None (the direction of motion). accelerations_m_s2: (n - 1,) along each leg, or None: all legs are driven at
    constant speeds. A leg of length L in the time T with the acceleration a begins at the speed L / T - a T / 2 and
    ends at L / T + a T / 2; neither is below 0. waypoints: what its autopilot is told; None: the legs themselves.
    charges: its stays at chargers, each from one of the times to another, in their order; one that goes on across the
    loop's seam is told in two. battery: 0 (empty) to 1, how full its battery is at the first time.
    ``loop_start_s`` is one of the times: equal to the last, the robot stays where it is; otherwise the position then
    equals the last position exactly and the robot repeats from there.

    Raises PlanError for all else, for values that are not finite, times beyond 1e10 s and loops of less than 1e-6 s.
    """

    robot: str = field_of(key="name", count=((1, None),))
    loop_start_s: float = field_of(0.0, **TIMES)
    times_s: Floats = field_of(form=tuple[float, ...], **TIMES)
    positions_m: Floats = field_of(form=tuple[tuple[float, ...], ...], count=((1, None), (2, 3)), **PLACES)
    headings_rad: Floats | None = field_of(None, form=tuple[float, ...] | None, count=((0, None),))
    accelerations_m_s2: Floats | None = field_of(
        None,
        "along each leg; absent: all legs are driven at constant speeds",
        form=tuple[float, ...] | None,
        count=((0, None),),
        newer=True,
        spared=True,
    )
    waypoints: Waypoints | None = field_of(None, newer=True, spared=True)
    charges: tuple[Charge, ...] = field_of(
        (), "stays at chargers, one after the other", count=((0, None),), newer=True, spared=True
    )
    battery: float = field_of(1.0, "how full it is at the first time; absent: full", **SHARE)

    def __post_init__(self) -> None:
        if not isinstance(self.robot, str):
            raise PlanError(f"robot: {shorten(repr(self.robot))} is not allowed; text is needed")
        for name in ("times_s", "positions_m", "headings_rad", "accelerations_m_s2"):
            values = getattr(self, name)
            if values is not None or name in ("times_s", "positions_m"):
                object.__setattr__(self, name, numbers_in(values, f"robot {self.robot}: {name}"))
        if not isinstance(self.loop_start_s, Real):
            raise PlanError(
                f"robot {self.robot}: loop_start_s: {self.loop_start_s!r} is not allowed; a number is needed"
            )
        object.__setattr__(self, "loop_start_s", float(self.loop_start_s))
        times, positions = self.times_s, self.positions_m
        if times.ndim != 1 or not len(times):
            raise PlanError(f"robot {self.robot}: times_s has shape {times.shape}; at least one time is needed")
        if positions.ndim != 2 or positions.shape[0] != len(times) or positions.shape[1] not in (2, 3):
            raise PlanError(
                f"robot {self.robot}: positions_m has shape {positions.shape}; ({len(times)}, 2) or ({len(times)}, 3)"
                " is needed, one position per time"
            )
        if self.headings_rad is not None and self.headings_rad.shape != times.shape:
            raise PlanError(f"robot {self.robot}: headings_rad has shape {self.headings_rad.shape}, not {times.shape}")
        if not (np.isfinite(times).all() and np.isfinite(positions).all()):
            raise PlanError(f"robot {self.robot}: times and positions must be finite")
        if self.headings_rad is not None and not np.isfinite(self.headings_rad).all():
            k = int(np.flatnonzero(~np.isfinite(self.headings_rad))[0])
            raise PlanError(f"robot {self.robot}: headings_rad[{k}] = {self.headings_rad[k]}; headings must be finite")
        if times[0] != 0:
            raise PlanError(f"robot {self.robot}: times_s starts at {times[0]}; it must start at 0")
        late = np.flatnonzero(np.diff(times) <= 0)
        if len(late):
            k = int(late[0])
            raise PlanError(f"robot {self.robot}: times_s[{k + 1}] = {times[k + 1]} does not come after {times[k]}")
        if times[-1] > LONGEST_S:
            k = int(np.flatnonzero(times > LONGEST_S)[0])
            raise PlanError(f"robot {self.robot}: times_s[{k}] = {times[k]}; at most {LONGEST_S:g} s are allowed")
        start = np.flatnonzero(times == self.loop_start_s)
        if not len(start):
            raise PlanError(f"robot {self.robot}: loop_start_s = {self.loop_start_s} is none of the times")
        if (positions[start[0]] != positions[-1]).any():
            raise PlanError(
                f"robot {self.robot}: the loop does not close: at loop_start_s the position is"
                f" {positions[start[0]].tolist()}, at the end {positions[-1].tolist()}"
            )

        if 0 < times[-1] - self.loop_start_s < SHORTEST_LOOP_S:
            raise PlanError(
                f"robot {self.robot}: its loop takes {times[-1] - self.loop_start_s:.3g} s; loops take"
                f" {SHORTEST_LOOP_S:g} s or more, or no time where the robot stays"
            )
        self._require_forward()
        object.__setattr__(self, "charges", parts_in(self.charges, Charge, f"robot {self.robot}: charges"))
        require_battery(f"robot {self.robot}", times, self.charges, self.battery)

    def _require_forward(self) -> None:
        """Raise PlanError for accelerations that are no numbers, or with which a leg would begin or end backwards."""
        if self.accelerations_m_s2 is None:
            return
        given, legs = self.accelerations_m_s2, len(self.times_s) - 1
        if given.shape != (legs,):
            raise PlanError(
                f"robot {self.robot}: accelerations_m_s2 has shape {given.shape}, not ({legs},), one per leg"
            )
        if not np.isfinite(given).all():
            k = int(np.flatnonzero(~np.isfinite(given))[0])
            raise PlanError(f"robot {self.robot}: accelerations_m_s2[{k}] = {given[k]}; accelerations must be finite")
        lengths = np.sqrt((np.diff(self.positions_m, axis=0) ** 2).sum(axis=1))
        halved = np.diff(self.times_s) ** 2 / 2  # of the shortest legs 0, by which nothing can be divided
        noise_m = 4 * np.finfo(np.float64).eps * np.abs(self.positions_m).max()  # that lengths are off, far away
        backwards = np.flatnonzero(np.abs(given) * halved > lengths * (1 + BACKWARDS_SHARE) + noise_m)
        if len(backwards):
            k = int(backwards[0])
            raise PlanError(
                f"robot {self.robot}: accelerations_m_s2[{k}] = {given[k]:.6g}; on this leg at most"
                f" {lengths[k] / halved[k]:.6g} m/s2"
                " either way are allowed, or the robot would drive backwards"
            )

    @property
    def bends(self) -> Floats:
        """(n - 1,) how the way along each leg bends in time, from -1 to 1.

        Of the share u of the leg's time it is the share u + bend u (u - 1) of the leg.

        0 at constant speed; 1 from rest, -1 to rest. A leg of no length has 0.
        """
        return bends_of(self.times_s, self.positions_m, self.accelerations_m_s2)

    def at(self, times_s: object) -> Floats:
        """Positions (..., d) in metres at the times (...) in seconds, a number or an array, in any round.

        Before 0 the robot is where it begins. Raises ArgumentError for what is no time.
        """
        asked_s = _times_in(times_s)
        if self.loop_duration_s > 0:
            late = asked_s > self.loop_start_s
            again_s = self.loop_start_s + np.mod(asked_s - self.loop_start_s, self.loop_duration_s)
            asked_s = np.where(late, again_s, asked_s)
        if len(self.times_s) == 1:
            return np.broadcast_to(self.positions_m[0], (*asked_s.shape, self.positions_m.shape[1])).copy()
        leg = np.clip(np.searchsorted(self.times_s, asked_s, side="right") - 1, 0, len(self.times_s) - 2)
        share = np.clip((asked_s - self.times_s[leg]) / (self.times_s[leg + 1] - self.times_s[leg]), 0.0, 1.0)
        along = (share + self.bends[leg] * share * (share - 1))[..., None]
        begin = self.positions_m[leg]
        return np.asarray(
            np.where(along == 1, self.positions_m[leg + 1], begin + along * (self.positions_m[leg + 1] - begin))
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Trajectory):
            return NotImplemented
        mine, theirs = self.headings_rad, other.headings_rad
        same_headings = mine is theirs if mine is None or theirs is None else np.array_equal(mine, theirs)
        return (
            self.robot == other.robot
            and self.loop_start_s == other.loop_start_s
            and np.array_equal(self.times_s, other.times_s)
            and np.array_equal(self.positions_m, other.positions_m)
            and same_headings
            and np.array_equal(self.bends, other.bends)
            and self.waypoints == other.waypoints
            and (self.charges, self.battery) == (other.charges, other.battery)
        )

    @property
    def loop_index(self) -> int:
        """Index of ``loop_start_s`` in ``times_s``."""
        return int(np.searchsorted(self.times_s, self.loop_start_s))

    @property
    def loop_duration_s(self) -> float:
        """Length of the repeated part in seconds; 0 when the robot stays at its last position."""
        return float(self.times_s[-1]) - self.loop_start_s

    @property
    def loop_length_m(self) -> float:
        """Length of the repeated part in metres; 0 when the robot stays at its last position."""
        steps = np.diff(self.positions_m[self.loop_index :], axis=0)
        return float(np.sqrt((steps**2).sum(axis=1)).sum())

    def __repr__(self) -> str:
        points = f"{len(self.times_s)} point{'' if len(self.times_s) == 1 else 's'}"
        loop = f"a loop of {self.loop_length_m:.1f} m in {self.loop_duration_s:.1f} s"
        return f"<Trajectory {self.robot!r}: {points}, {loop if self.loop_duration_s else 'stays'}>"
