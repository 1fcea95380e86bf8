"""What one robot drives, without a clock: stops with the speed to reach each and the time to wait there.

Exports for autopilots and links to robots are made of it. All places are in the mission's own metres.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field, replace

import numpy as np

from rota.model.plan import Trajectory, Waypoints
from rota.routes.constant_speeds import at_constant_speeds
from rota.routes.flights import ends_on_charger
from rota.routes.passed_stops import PassedStop, passed_stops, without_slight

SLIGHT_M = 0.05  # corners that bend the way by less are no stops
ROUNDING_S = 1e-6  # by which times of different rounds may differ
Place3 = tuple[float, float, float]
Ring = tuple[tuple[float, float], ...]
Disc = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class RouteStop:
    """A place (x, y, height) in metres to reach at ``speed_m_s`` and to stay at for ``hold_s`` (0 or more).

    speed_m_s: more than 0; None where the robot is there already. turn_s: of hold_s, how long the robot turns at the
    end of it, where that is told apart: a robot that turns by itself is to wait for the rest only. planned_s: how long
    the way there is planned to take, where that is more than the speed says, since the robot speeds up and brakes;
    None: what the speed says. curve_m: how far before the stop the robot may leave its straight way to cut the corner,
    and come back to the next; 0: it is not told to cut it.
    """

    place_m: Place3
    speed_m_s: float | None
    hold_s: float = 0.0
    turn_s: float = 0.0
    planned_s: float | None = None
    curve_m: float = 0.0

    @property
    def wait_s(self) -> float:
        """How long the robot stands there before it turns."""
        return self.hold_s - self.turn_s

    def drive_s(self, from_m: Place3) -> float:
        """How long the way there takes from another place, without the wait."""
        if self.planned_s is not None:
            return self.planned_s
        return math.dist(from_m, self.place_m) / self.speed_m_s if self.speed_m_s else 0.0


@dataclass(frozen=True, kw_only=True)
class Fence:
    """Where a robot has to stay: in one polygon, out of others and of circles.

    Rings of (x, y) in metres, three corners or more; circles (x, y, radius) in metres.
    """

    inside_m: Ring
    outside_m: tuple[Ring, ...] = ()
    circles_m: tuple[Disc, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Route:
    """What one robot drives: ``approach`` once, then ``loop`` and ``closing`` for ever.

    start_m: where it begins, and the height to which it takes off. The first stop of the loop (one at least) is reached
    from the approach once and from ``closing``, which has the same place, ever after. closing None: the robot stays at
    the loop's only stop. planned: the way itself of a robot whose speed changes along its legs, at constant speeds on
    shorter ones, for those who drive by a clock; None: straight from stop to stop. rally_m: where it may land, (x, y,
    height on the way there), when it returns by itself. lands: it lands where it stays.
    """

    robot: str
    start_m: Place3
    approach: tuple[RouteStop, ...]
    loop: tuple[RouteStop, ...]
    closing: RouteStop | None
    fence: Fence | None = None
    rally_m: tuple[Place3, ...] = ()
    lands: bool = False
    planned: Trajectory | None = field(default=None, compare=False, repr=False)

    @property
    def once(self) -> tuple[RouteStop, ...]:
        """The stops until the loop begins, and the one where it does."""
        return (*self.approach, self.loop[0])

    @property
    def every_round(self) -> tuple[RouteStop, ...]:
        """The stops of one round, from the second of the loop to its first again; none where the robot stays."""
        if self.closing is None:
            return ()
        return (*self.loop[1:], replace(self.closing, hold_s=self.closing.hold_s + self.loop[0].hold_s))


def route_of(trajectory: Trajectory, altitude_m: float) -> Route:
    """One robot's stops; it flies at ``altitude_m`` unless its positions have heights of their own.

    It begins at ``altitude_m`` either way, to which autopilots take off: give ``start_height_m`` for others.

    Pauses become waits. Stops without a wait are left out where another stands for the same place: the start at the
    approach's beginning, the loop's first stop at the approach's end. Corners that are cut are stops where their
    straight ways meet, each with the greatest speed on the way there; those that bend the way by less than 5 cm are
    none. Where the loop begins in the midst of a way, its stops begin with the next corner. A robot that ends on a
    charger lands there.
    """
    if ends_on_charger(trajectory):
        return replace(route_of(_until_landing(trajectory), altitude_m), lands=True)
    if trajectory.waypoints is not None:
        return _route_by_waypoints(trajectory, trajectory.waypoints, altitude_m)
    if trajectory.accelerations_m_s2 is not None:
        return _route_past_corners(trajectory, altitude_m)
    k = trajectory.loop_index
    approach = _visit(trajectory, altitude_m, 0, k) if k > 0 else []
    loop = _visit(trajectory, altitude_m, k, len(trajectory.times_s) - 1)
    if approach:
        loop[0] = replace(loop[0], speed_m_s=approach[-1].speed_m_s)
        if approach[-1].hold_s == 0 or len(loop) == 1:
            approach.pop()
    if approach and approach[0].speed_m_s is None and approach[0].hold_s == 0:
        approach.pop(0)
    closing = loop.pop() if len(loop) > 1 else None
    x, y = trajectory.positions_m[0, :2].tolist()
    return Route(
        robot=trajectory.robot,
        start_m=(x, y, altitude_m),
        approach=tuple(approach),
        loop=tuple(loop),
        closing=closing,
    )


def _until_landing(trajectory: Trajectory) -> Trajectory:
    """The trajectory of a robot that stays over the charger instead of on it."""
    lands_s = trajectory.charges[-1].from_s
    flown = int(np.searchsorted(trajectory.times_s, lands_s)) + 1
    headings, accelerations = trajectory.headings_rad, trajectory.accelerations_m_s2
    return replace(
        trajectory,
        times_s=trajectory.times_s[:flown],
        positions_m=trajectory.positions_m[:flown],
        headings_rad=None if headings is None else headings[:flown],
        accelerations_m_s2=None if accelerations is None else accelerations[: flown - 1],
        loop_start_s=lands_s,
        charges=trajectory.charges[:-1],
    )


def _route_by_waypoints(trajectory: Trajectory, told: Waypoints, altitude_m: float) -> Route:
    """The route of a robot whose autopilot cuts corners by itself: a wait at the first corner, then round them all."""
    places = [(x, y, altitude_m) for x, y in told.places_m.tolist()]
    leaves_s, again_s = float(told.times_s[0]), float(told.times_s[1]) + trajectory.loop_duration_s
    once = [
        RouteStop(place_m=place, speed_m_s=told.speed_m_s, planned_s=planned_s)
        for place, planned_s in zip([*places[1:], places[0]], np.diff(told.times_s).tolist(), strict=True)
    ]
    return Route(
        robot=trajectory.robot,
        start_m=places[0],
        approach=(RouteStop(place_m=places[0], speed_m_s=None, hold_s=leaves_s),) if leaves_s > 0 else (),
        loop=tuple(once),
        closing=replace(once[0], planned_s=again_s - float(told.times_s[-1])),
        planned=at_constant_speeds(trajectory),
    )


def _route_past_corners(trajectory: Trajectory, altitude_m: float) -> Route:
    """The route of a robot whose speed changes along its legs."""

    def stops_of(passed: list[PassedStop]) -> list[RouteStop]:
        """A stop for each place that is passed, with the time that the plan has for the way there."""
        stops = [RouteStop(place_m=_place(passed[0], altitude_m), speed_m_s=None, hold_s=_hold_s(passed[0]))]
        for before, stop in itertools.pairwise(passed):
            stops.append(
                RouteStop(
                    place_m=_place(stop, altitude_m),
                    speed_m_s=stop.top_speed_m_s,
                    hold_s=_hold_s(stop),
                    planned_s=stop.reached_s - before.left_s,
                    curve_m=stop.curve_m,
                )
            )
        return stops

    before, a_round = (without_slight(stops, SLIGHT_M) for stops in passed_stops(trajectory))
    approach = stops_of(before)
    x, y = trajectory.positions_m[0, :2].tolist()
    route = Route(
        robot=trajectory.robot,
        start_m=(x, y, altitude_m),
        approach=(),
        loop=(approach[-1],),
        closing=None,
        planned=at_constant_speeds(trajectory),
    )
    if len(a_round) > 1:
        first, *others, closing = stops_of(a_round)
        # what the robot waits there in every round, and what of it in the first
        begun_s = min(approach[-1].hold_s, first.hold_s)
        if approach[-1].hold_s > begun_s + ROUNDING_S and len(approach) > 1:
            approach.append(replace(approach[-1], hold_s=begun_s, planned_s=0.0))
            approach[-2] = replace(approach[-2], hold_s=approach[-2].hold_s - begun_s)
        # the places of different rounds differ by rounding
        loop = (replace(approach[-1], place_m=first.place_m, hold_s=begun_s), *others)
        ahead_s = first.hold_s - begun_s
        closing = replace(closing, place_m=first.place_m, hold_s=ahead_s if ahead_s > ROUNDING_S else 0.0)
        route = replace(route, loop=loop, closing=closing)
    approach.pop()
    if approach and approach[0].hold_s == 0:
        approach.pop(0)
    return replace(route, approach=tuple(approach))


def _place(stop: PassedStop, altitude_m: float) -> Place3:
    x, y, *height = stop.place_m.tolist()
    return x, y, height[0] if height else altitude_m


def _hold_s(stop: PassedStop) -> float:
    return stop.left_s - stop.reached_s


def start_height_m(trajectory: Trajectory, altitude_m: float) -> float:
    """The height in metres at which the robot begins: that of its first position, ``altitude_m`` if it has none."""
    first_m = trajectory.positions_m[0]
    return float(first_m[2]) if len(first_m) == 3 else altitude_m


def _visit(trajectory: Trajectory, altitude_m: float, first: int, last: int) -> list[RouteStop]:
    """A stop at each position from ``first`` to ``last``, those at one place taken together."""
    positions_m = trajectory.positions_m[first : last + 1]
    durations_s = np.diff(trajectory.times_s[first : last + 1]).tolist()
    lengths_m = [float(np.linalg.norm(step_m)) for step_m in np.diff(positions_m, axis=0)]
    places = [(at[0], at[1], at[2] if len(at) == 3 else altitude_m) for at in positions_m.tolist()]
    stops = [RouteStop(place_m=places[0], speed_m_s=None)]
    for place, duration_s, length_m in zip(places[1:], durations_s, lengths_m, strict=True):
        if length_m == 0:
            stops[-1] = replace(stops[-1], hold_s=stops[-1].hold_s + duration_s)
        else:
            stops.append(RouteStop(place_m=place, speed_m_s=length_m / duration_s))
    return stops
