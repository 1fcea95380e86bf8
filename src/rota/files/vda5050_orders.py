"""A route -> VDA 5050 orders: nodes, edges, a released base with a horizon, and updates that go on for ever.

VDA 5050 version 2.1.0, sections 6.6.1, 6.6.2 and 6.7, and 3.0.0, section 6.1. A message is a dict that JSON can write.
Stops are counted through the whole drive: those before the loop first, then the loop's again and again. Stop i has the
``sequenceId`` 2 i and the edge that leads to it 2 i - 1, so that numbers go on through all updates.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from rota.errors import PlanError
from rota.files.vda5050_versions import TIMED_WAIT, VERSION_2_1, Json, Protocol, WaitAction
from rota.routes.driven_route import from_start
from rota.routes.route import Route, RouteStop
from rota.routes.turning import with_turning

MOST_SEQUENCE = 2**32 - 1  # sequenceId is a uint32
_ID = re.compile(r"[A-Za-z0-9_.:-]+")  # section 6.1.2


@dataclass(frozen=True, kw_only=True)
class Vehicle:
    """Whom orders are for, the map that their places are on, and how it is spoken to; the metres are the mission's own.

    ``wait``: the action by which it waits at a stop; None: no order tells it to.

    Raises PlanError for names with other characters than ``A-Z a-z 0-9 _ - . :``, which VDA 5050 does not take.
    """

    serial_number: str
    manufacturer: str = "rota"
    map_id: str = "map"
    protocol: Protocol = VERSION_2_1
    wait: WaitAction | None = TIMED_WAIT

    def __post_init__(self) -> None:
        named = {"serial number": self.serial_number, "manufacturer": self.manufacturer, "map id": self.map_id}
        for what, name in named.items():
            require_id(what, name)


@dataclass(frozen=True, kw_only=True)
class Window:
    """How many stops beyond the stitching node an order releases (1 or more) and how many more it announces (0 on)."""

    released: int = 50
    announced: int = 25


@dataclass(frozen=True, kw_only=True)
class Span:
    """The stops of a message by their numbers: the stitching node, the last one released, the last one announced."""

    first: int
    released: int
    last: int


def require_id(what: str, name: str) -> None:
    """Raise PlanError for a name with other characters than VDA 5050 takes in identifiers."""
    if not _ID.fullmatch(name):
        raise PlanError(f"{what} {name!r}: VDA 5050 takes only the characters A-Z a-z 0-9 _ - . : in it")


class NumberedStops:
    """A route's stops in the order of driving, each with the id of its node, and numbers that go on for ever."""

    def __init__(self, route: Route, turn_rate_rad_s: float | None = None, charges: bool = False) -> None:
        """Stops ``once`` from where the robot begins to where rounds begin, then those of ``every_round``.

        turn_rate_rad_s: of a robot that turns on the spot; None: it turns in no time. charges: it begins to charge at
        the last stop, where it stays.
        """
        self.robot = route.robot
        self._charges = charges
        self.once, self.every_round = with_turning(from_start(route), route.every_round, turn_rate_rad_s)

    @property
    def arrived(self) -> int:
        """The number of the stop where rounds begin and end; the last one of a robot that stays."""
        return len(self.once) - 1

    def stop(self, number: int) -> RouteStop:
        """The stop that the robot drives to as its number-th, from 0, where it begins."""
        past = number - len(self.once)
        return self.once[number] if past < 0 else self.every_round[past % len(self.every_round)]

    def node_id(self, number: int) -> str:
        """``a0``, ``a1``, ... before the loop; then ``l0``, where rounds begin, ``l1``, ..., the same in each."""
        past = number - self.arrived
        return f"a{number}" if past < 0 else f"l{past % len(self.every_round) if self.every_round else 0}"

    def charges_at(self, number: int) -> bool:
        """Whether the robot begins to charge at a stop."""
        return self._charges and number == self.arrived and not self.every_round

    def last_within(self, first: int, last: int) -> int:
        """``last``, or less where the path ends before or an edge would come twice."""
        if not self.every_round:
            return min(last, self.arrived)
        return min(last, max(first, self.arrived) + len(self.every_round))


def span_of(stops: NumberedStops, first: int, window: Window) -> Span:
    """The stops of a message that begins at ``first``, at most one round of the loop: it holds no edge twice."""
    released = end_without_wait(stops, first, stops.last_within(first, first + window.released))
    return Span(first=first, released=released, last=stops.last_within(first, released + window.announced))


def end_without_wait(stops: NumberedStops, first: int, end: int) -> int:
    """The stop nearest to ``end``, later ones last, that no robot waits at, beyond ``first`` and within a round.

    An update repeats the stop at which what was released before it ends, and some vehicles then wait there again and
    again. ``end`` itself where there is none, or where the route ends.
    """
    if not stops.every_round and end == stops.arrived:
        return end
    farthest = stops.last_within(first, first + len(stops.every_round))
    near = (*range(end, first, -1), *range(end + 1, farthest + 1))
    return next((number for number in near if stops.stop(number).wait_s == 0), end)


def order_message(
    stops: NumberedStops,
    vehicle: Vehicle,
    order_id: str,
    *,
    update: int,
    span: Span,
    timestamp: str,
    told: Callable[[int], RouteStop] | None = None,
) -> Json:
    """An order (``update`` 0, from stop 0 on) or its update: stops from the last one on that was released before it.

    Its first node is the stitching node, unchanged. ``told``: with what speed and what wait each stop is told to the
    vehicle, by default those of the route. A wait is the vehicle's action for that, blockingType HARD; the time in
    which a robot turns is none. ``headerId`` is ``update``. A route that stays ends with its last stop.

    Raises PlanError for ids that VDA 5050 does not take and for sequence ids beyond 32 bits: begin a new order then.
    """
    require_id("order id", order_id)
    if 2 * span.last > MOST_SEQUENCE:
        raise PlanError(f"robot {stops.robot}: the order has used up VDA 5050's sequence ids, which have 32 bits")
    told = told or stops.stop
    numbers = range(span.first, span.last + 1)
    return {
        "headerId": update,
        "timestamp": timestamp,
        "version": vehicle.protocol.version,
        "manufacturer": vehicle.manufacturer,
        "serialNumber": vehicle.serial_number,
        "orderId": order_id,
        "orderUpdateId": update,
        "nodes": [_node(stops, vehicle, order_id, number, number <= span.released, told(number)) for number in numbers],
        "edges": [_edge(stops, vehicle, number, number <= span.released, told(number)) for number in numbers[1:]],
    }


def base_end(message: Json) -> int:
    """The number of the last stop that an order releases: where its update begins."""
    return int(max(node["sequenceId"] for node in message["nodes"] if node["released"])) // 2


def order_messages(
    stops: NumberedStops, vehicle: Vehicle, order_id: str, *, window: Window, timestamp: Callable[[int], str]
) -> Iterator[Json]:
    """The order and its updates, without end; ``timestamp`` makes a message's of the number of its first stop.

    For a robot that stays they end when its last stop is released.
    """
    first, update = 0, 0
    while True:
        span = span_of(stops, first, window)
        yield order_message(stops, vehicle, order_id, update=update, span=span, timestamp=timestamp(first))
        first, update = span.released, update + 1
        if not stops.every_round and first == stops.arrived:
            return


def wait_id(order_id: str, number: int) -> str:
    """The id of the action that waits at a stop."""
    return f"{order_id}:{2 * number}"


def _node(stops: NumberedStops, vehicle: Vehicle, order_id: str, number: int, released: bool, told: RouteStop) -> Json:
    """The node of a stop, with what the vehicle does there."""
    actions = [vehicle.wait.action(wait_id(order_id, number), told.wait_s)] if vehicle.wait and told.wait_s > 0 else []
    if stops.charges_at(number):
        charge = {"actionType": "startCharging", "actionId": f"{order_id}:{2 * number}:startCharging"}
        actions.append({**charge, "blockingType": "HARD", "actionParameters": []})
    return {
        "nodeId": stops.node_id(number),
        "sequenceId": 2 * number,
        "released": released,
        "nodePosition": {"x": told.place_m[0], "y": told.place_m[1], "mapId": vehicle.map_id},
        "actions": actions,
    }


def _edge(stops: NumberedStops, vehicle: Vehicle, number: int, released: bool, told: RouteStop) -> Json:
    """The edge that leads to a stop."""
    start, end = stops.node_id(number - 1), stops.node_id(number)
    ends = {} if vehicle.protocol.is_3 else {"startNodeId": start, "endNodeId": end}
    return {
        "edgeId": f"{start}-{end}",
        "sequenceId": 2 * number - 1,
        "released": released,
        **ends,
        vehicle.protocol.speed_key: told.speed_m_s,
        "actions": [],
    }
