"""A route -> VDA 5050 orders: nodes, edges, a released base with a horizon, and updates that go on for ever.

VDA 5050 version 2.1.0, sections 6.6.1, 6.6.2 and 6.7. A message is a dict that JSON can write. Stops are counted
through the whole drive: those before the loop first, then the loop's again and again. Stop i has the ``sequenceId`` 2 i
and the edge that leads to it 2 i - 1, so that numbers go on through all updates.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from rota.driven_route import from_start
from rota.errors import PlanError
from rota.route import Route, RouteStop

Json = dict[str, Any]

VERSION = "2.1.0"
WAIT = "wait"
MOST_SEQUENCE = 2**32 - 1  # sequenceId is a uint32
_ID = re.compile(r"[A-Za-z0-9_.:-]+")  # section 6.1.2


@dataclass(frozen=True, kw_only=True)
class Vehicle:
    """Whom orders are for, and the map that their places are on; the metres are the mission's own.

    Raises PlanError for names with other characters than ``A-Z a-z 0-9 _ - . :``, which VDA 5050 does not take.
    """

    serial_number: str
    manufacturer: str = "rota"
    map_id: str = "map"

    def __post_init__(self) -> None:
        named = {"serial number": self.serial_number, "manufacturer": self.manufacturer, "map id": self.map_id}
        for what, name in named.items():
            require_id(what, name)


@dataclass(frozen=True, kw_only=True)
class Window:
    """How many stops beyond the stitching node an order releases (1 or more) and how many more it announces (0 on)."""

    released: int = 50
    announced: int = 25


def require_id(what: str, name: str) -> None:
    """Raise PlanError for a name with other characters than VDA 5050 takes in identifiers."""
    if not _ID.fullmatch(name):
        raise PlanError(f"{what} {name!r}: VDA 5050 takes only the characters A-Z a-z 0-9 _ - . : in it")


class NumberedStops:
    """A route's stops in the order of driving, each with the id of its node, and numbers that go on for ever."""

    def __init__(self, route: Route) -> None:
        """Stops ``once`` from where the robot begins to where rounds begin, then those of ``every_round``."""
        self.robot = route.robot
        self.once = from_start(route)
        self.every_round = route.every_round

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

    def last_within(self, first: int, last: int) -> int:
        """``last``, or less where the path ends before or an edge would come twice."""
        if not self.every_round:
            return min(last, self.arrived)
        return min(last, max(first, self.arrived) + len(self.every_round))


def order_message(
    route: Route, vehicle: Vehicle, order_id: str, *, update: int, first: int, window: Window, timestamp: str
) -> Json:
    """An order (``update`` 0, ``first`` 0) or its update: stops from ``first`` on, the last one released before it.

    Its first node is the stitching node, unchanged. A wait is an action ``wait`` on the node, blockingType HARD, with
    the parameter ``duration`` in seconds: VDA 5050 has no timed wait, and vehicles may have actions of their own. A
    message holds no edge twice, so at most one round of the loop, whatever the window allows. ``headerId`` is
    ``update``. A route that stays ends with its last stop.

    Raises PlanError for ids that VDA 5050 does not take and for sequence ids beyond 32 bits: begin a new order then.
    """
    require_id("order id", order_id)
    stops = NumberedStops(route)
    released = stops.last_within(first, first + window.released)
    last = stops.last_within(first, released + window.announced)
    if 2 * last > MOST_SEQUENCE:
        raise PlanError(f"robot {route.robot}: the order has used up VDA 5050's sequence ids, which have 32 bits")
    numbers = range(first, last + 1)
    return {
        "headerId": update,
        "timestamp": timestamp,
        "version": VERSION,
        "manufacturer": vehicle.manufacturer,
        "serialNumber": vehicle.serial_number,
        "orderId": order_id,
        "orderUpdateId": update,
        "nodes": [_node(stops, vehicle, order_id, number, number <= released) for number in numbers],
        "edges": [_edge(stops, number, number <= released) for number in numbers[1:]],
    }


def base_end(message: Json) -> int:
    """The number of the last stop that an order releases: where its update begins."""
    return int(max(node["sequenceId"] for node in message["nodes"] if node["released"])) // 2


def order_messages(
    route: Route, vehicle: Vehicle, order_id: str, *, window: Window, timestamp: Callable[[int], str]
) -> Iterator[Json]:
    """The order and its updates, without end; ``timestamp`` makes a message's of the number of its first stop.

    For a robot that stays they end when its last stop is released.
    """
    first, update = 0, 0
    while True:
        text = timestamp(first)
        message = order_message(route, vehicle, order_id, update=update, first=first, window=window, timestamp=text)
        yield message
        first, update = base_end(message), update + 1
        if route.closing is None and first == len(from_start(route)) - 1:
            return


def _node(stops: NumberedStops, vehicle: Vehicle, order_id: str, number: int, released: bool) -> Json:
    stop = stops.stop(number)
    wait = {
        "actionType": WAIT,
        "actionId": f"{order_id}:{2 * number}",
        "blockingType": "HARD",
        "actionParameters": [{"key": "duration", "value": stop.hold_s}],
    }
    return {
        "nodeId": stops.node_id(number),
        "sequenceId": 2 * number,
        "released": released,
        "nodePosition": {"x": stop.place_m[0], "y": stop.place_m[1], "mapId": vehicle.map_id},
        "actions": [wait] if stop.hold_s > 0 else [],
    }


def _edge(stops: NumberedStops, number: int, released: bool) -> Json:
    """The edge that leads to a stop."""
    start, end = stops.node_id(number - 1), stops.node_id(number)
    return {
        "edgeId": f"{start}-{end}",
        "sequenceId": 2 * number - 1,
        "released": released,
        "startNodeId": start,
        "endNodeId": end,
        "maxSpeed": stops.stop(number).speed_m_s,
        "actions": [],
    }
