"""What a robot has heard of the others: the newest telling of each, and the bodies that follow from them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from rota.planners.swarm.nodes.apart import reach_m, silent_reach_m
from rota.planners.swarm.nodes.clocks import Clocks
from rota.planners.swarm.nodes.telling import LEFT, Telling, read_telling


class Start(NamedTuple):
    """Where a robot of the fleet stands before it takes part, and its body's radius, in metres."""

    x: float
    y: float
    body_m: float


class Known(NamedTuple):
    """A body as a robot that decides has to reckon with it: anywhere within ``reach_m`` round (x, y), in metres.

    robot: its number in the fleet. sensor_m 0: a body only, which is nobody's neighbour.
    """

    robot: int
    x: float
    y: float
    vx: float
    vy: float
    body_m: float
    sensor_m: float
    speed_m_s: float
    reach_m: float

    @property
    def is_member(self) -> bool:
        """Whether it takes part."""
        return self.sensor_m > 0.0


class Hearing:
    """The newest telling of every other robot of a swarm, as datagrams bring them, in any order and any number.

    starts: of all robots of the fleet, by number; others are not heeded. own: the number of who listens. silent_ns: one
    that has told nothing for so long is forgotten, but for its body. clock_error_ns: by which clocks may differ; with
    own_clocks, by how much one may err about others' clocks. radio_m: tellings from farther away are not received.
    ``dropped`` counts datagrams without a telling, from unknown robots and from the future; those that bring nothing
    new, late ones and doubles, are no faults. Memory is bounded by the fleet.
    """

    def __init__(
        self,
        starts: tuple[Start, ...],
        own: int,
        swarm: int,
        *,
        silent_ns: int,
        clock_error_ns: int = 0,
        own_clocks: bool = False,
        radio_m: float = math.inf,
    ) -> None:
        self._starts, self._own, self._swarm = starts, own, swarm
        self._silent_ns, self._clock_error_ns = silent_ns, clock_error_ns
        self._own_clocks, self._radio_m = own_clocks, radio_m
        self._clocks = Clocks(shared=not own_clocks)
        self._newest: dict[int, Telling] = {}  # as told, by their senders' clocks
        self.dropped = 0

    def hear(self, datagrams: Iterable[bytes], now_ns: int, place: tuple[float, float] | None = None) -> None:
        """Take in datagrams that have arrived by now; place: where who listens is, which a radio range asks for."""
        latest_ns = math.inf if self._own_clocks else now_ns + self._clock_error_ns
        for datagram in datagrams:
            telling = read_telling(datagram, self._swarm)
            if telling is None or telling.robot >= len(self._starts) or telling.told_ns > latest_ns:
                self.dropped += 1
            elif telling.robot != self._own and self._is_in_range(telling, place):
                self._clocks.hear(telling, now_ns)
                before = self._newest.get(telling.robot)
                if before is None or telling.told_ns > before.told_ns:
                    self._newest[telling.robot] = telling

    def _is_in_range(self, telling: Telling, place: tuple[float, float] | None) -> bool:
        """Whether what was told there can be received at a place."""
        return place is None or math.hypot(telling.x - place[0], telling.y - place[1]) <= self._radio_m

    def _last_of(self, robot: int) -> Telling | None:
        """The newest telling of a robot, dated by one's own clock."""
        telling = self._newest.get(robot)
        return None if telling is None else self._clocks.own(telling)

    def is_alive(self, robot: int, now_ns: int) -> bool:
        """Whether a robot was heard lately and has not left."""
        telling = self._last_of(robot)
        return telling is not None and telling.state != LEFT and now_ns - telling.told_ns <= self._silent_ns

    def known_bodies(self, now_ns: int, until_ns: int) -> list[Known]:
        """All bodies to reckon with from now until a time: first the neighbours, by number, then mere bodies."""
        members, bodies = [], []
        for robot, start in enumerate(self._starts):
            if robot == self._own:
                continue
            telling = self._last_of(robot)
            if telling is not None and self.is_alive(robot, now_ns):
                members.append(self._alive(telling, now_ns, until_ns))
                continue
            bodies.append(Known(robot, start.x, start.y, 0.0, 0.0, start.body_m, 0.0, 0.0, 0.0))
            if telling is not None:
                bodies.append(self._silent(telling))
        return members + bodies

    def _alive(self, telling: Telling, now_ns: int, until_ns: int) -> Known:
        """A robot that takes part, where it is by now as it told."""
        x, y = telling.place_at(now_ns)
        reach = reach_m(telling, now_ns, until_ns + self._clock_error_ns)
        reach += telling.speed_m_s * self._clock_error_ns * 1e-9
        moves = telling.told_ns <= now_ns < telling.end_ns
        vx, vy = (telling.vx, telling.vy) if moves else (0.0, 0.0)
        return Known(telling.robot, x, y, vx, vy, telling.body_m, telling.sensor_m, telling.speed_m_s, reach)

    def _silent(self, telling: Telling) -> Known:
        """The body of a robot that has left or fell silent."""
        x, y = telling.place_at(telling.end_ns)
        reach = 0.0 if telling.state == LEFT else silent_reach_m(telling, self._silent_ns)
        return Known(telling.robot, x, y, 0.0, 0.0, telling.body_m, 0.0, 0.0, reach)
