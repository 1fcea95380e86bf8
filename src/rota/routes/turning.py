"""The time in which robots turn on the spot where their way bends, apart from that in which they wait."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from rota.routes.route import RouteStop

Stops = tuple[RouteStop, ...]
LEAST_WAIT_S = 1e-3  # a shorter one is what plans leave beside a turn, so as not to turn too fast by rounding


def with_turning(
    once: Sequence[RouteStop], every_round: Sequence[RouteStop], turn_rate_rad_s: float | None
) -> tuple[Stops, Stops]:
    """The stops before rounds begin and those of a round, each with how long the robot turns there within its hold.

    every_round: from the second stop of the loop to its first again; empty where the robot stays. A robot turns the
    shorter way from the direction in which it came to that in which it goes on. turn_rate_rad_s None: in no time.
    Nothing is known of how it stands at its start, nor of where it stays.
    """

    def within(stop: RouteStop, turns_s: float) -> RouteStop:
        return replace(stop, turn_s=stop.hold_s if stop.hold_s - turns_s < LEAST_WAIT_S else turns_s)

    return _at_bends(once, every_round, turn_rate_rad_s, within)


def turning(
    once: Sequence[RouteStop], every_round: Sequence[RouteStop], turn_rate_rad_s: float | None
) -> tuple[Stops, Stops]:
    """The same stops as a robot drives them that waits as long as it is told and then turns."""
    return _at_bends(once, every_round, turn_rate_rad_s, lambda stop, s: replace(stop, hold_s=stop.hold_s + s))


def _at_bends(
    once: Sequence[RouteStop],
    every_round: Sequence[RouteStop],
    turn_rate_rad_s: float | None,
    change: Callable[[RouteStop, float], RouteStop],
) -> tuple[Stops, Stops]:
    """The stops, each changed by the time in which its robot turns there; none when turns take no time."""
    if turn_rate_rad_s is None:
        return tuple(once), tuple(every_round)

    def change_stops(stops: Sequence[RouteStop]) -> list[RouteStop]:
        triples = zip(stops, stops[1:], stops[2:], strict=False)
        return [change(at, _turn_rad(before, at, after) / turn_rate_rad_s) for before, at, after in triples]

    first = change_stops([*once, *every_round[:1]])
    end = [] if every_round else once[-1:]
    around = change_stops([once[-1], *every_round, *every_round[:1]])
    return (once[0], *first, *(end if len(once) > 1 else [])), tuple(around)


def _turn_rad(before: RouteStop, at: RouteStop, after: RouteStop) -> float:
    """By how much the way bends at a stop, 0 to pi; 0 where the robot does not move before or after it."""
    (ax, ay), (bx, by), (cx, cy) = before.place_m[:2], at.place_m[:2], after.place_m[:2]
    ux, uy, vx, vy = bx - ax, by - ay, cx - bx, cy - by
    if math.hypot(ux, uy) == 0 or math.hypot(vx, vy) == 0:
        return 0.0
    return abs(math.atan2(ux * vy - uy * vx, ux * vx + uy * vy))
