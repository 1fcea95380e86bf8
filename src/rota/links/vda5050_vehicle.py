"""One VDA 5050 vehicle as its master sees it: the order that it has, its last state, and what it is to be sent next."""

from __future__ import annotations

import asyncio
import time
import uuid
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from rota.files.timed_places import instant_text
from rota.files.vda5050_orders import VERSION, NumberedStops, Vehicle, Window, base_end, order_message
from rota.links.link import Mode
from rota.links.vda5050_state import Part, VehicleError, VehicleState
from rota.route import Route, RouteStop

Json = dict[str, Any]

ENDED = ("FINISHED", "FAILED")
ASK_AGAIN_S = 2.0  # MQTT's quality of service 0, which VDA 5050 asks for, may lose messages


@dataclass(kw_only=True)
class Vda5050Vehicle:
    """What is known of a vehicle. ``planned``: the route of its robot, also where another program has sent it.

    ``news`` is told of every state. ``was_away``: it or the broker was lost since it was last asked for its state.
    """

    identity: Vehicle
    planned: Route
    window: Window
    state: VehicleState | None = None
    connection: str = ""
    was_away: bool = False
    returning: bool = False
    news: asyncio.Condition = field(default_factory=asyncio.Condition)
    _route: Route | None = None
    _order: Json | None = None
    _sent_s: float = 0.0
    _actions: int = 0

    @property
    def robot(self) -> str:
        """The robot's name."""
        return self.planned.robot

    def order(self, route: Route) -> Json:
        """A new order for a route, which replaces what it had."""
        order_id = f"{self.identity.serial_number}-{uuid.uuid4().hex}"
        self._route, self._order = route, self._message(route, order_id, update=0, first=0)
        return self._order

    def forget(self) -> None:
        """It has no order of this program any more."""
        self._route, self._order, self.returning = None, None, False

    def update_due(self) -> Json | None:
        """The order's update, once it has half of the released stops behind it and has taken the update before.

        A vehicle that is paused gets none: it does not get on, and what it holds may just be being compared.
        An update that it has not taken after ``ASK_AGAIN_S`` is due again: it may have been lost. None also where the
        order was cancelled, or replaced, by others.
        """
        state, order, route = self.state, self._order, self._route
        if state is None or order is None or route is None or not route.every_round or state.paused:
            return None
        if state.order_id != order["orderId"]:
            return None
        if state.update != order["orderUpdateId"]:
            is_late = time.monotonic() - self._sent_s > ASK_AGAIN_S
            return self._again() if is_late and state.update == order["orderUpdateId"] - 1 else None
        last, end = state.last_sequence // 2, base_end(order)
        # without stops ahead it has either come to the end of what was released or been told to give up
        is_driving = bool(state.nodes) or last >= end
        released = end - order["nodes"][0]["sequenceId"] // 2
        if not is_driving or end - last > max(1, released // 2):
            return None
        self._order = self._message(route, order["orderId"], update=order["orderUpdateId"] + 1, first=end)
        return self._again()

    def _again(self) -> Json | None:
        self._sent_s = time.monotonic()
        return self._order

    def _message(self, route: Route, order_id: str, *, update: int, first: int) -> Json:
        now = instant_text(datetime.now(UTC))
        return order_message(
            route, self.identity, order_id, update=update, first=first, window=self.window, timestamp=now
        )

    def instant_action(self, kind: str) -> tuple[str, Json]:
        """An instant action without parameters: its id, and the message."""
        self._actions += 1
        action_id = f"{kind}-{uuid.uuid4().hex}"
        blocking = "HARD" if kind in ("startPause", "stopPause", "cancelOrder") else "NONE"
        action = {"actionType": kind, "actionId": action_id, "blockingType": blocking, "actionParameters": []}
        message = {
            "headerId": self._actions,
            "timestamp": instant_text(datetime.now(UTC)),
            "version": VERSION,
            "manufacturer": self.identity.manufacturer,
            "serialNumber": self.identity.serial_number,
            "actions": [action],
        }
        return action_id, message

    def refusal(self, *ids: str) -> VehicleError | None:
        """An error of its last state that names one of these orders or actions."""
        errors = self.state.errors if self.state is not None else ()
        return next((error for error in errors if error.about & set(ids)), None)

    def has_order(self, order: Json) -> bool:
        """Whether its last state is about this order."""
        state = self.state
        return state is not None and (state.order_id, state.update) == (order["orderId"], order["orderUpdateId"])

    def mode(self) -> Mode:
        """What it is doing, as its last state tells."""
        state = self.state
        if state is None or any(error.is_fatal for error in state.errors):
            return "failed" if state is not None else "idle"
        if not state.nodes and not self._stands_as_planned(state):
            return "idle"
        return "paused" if state.paused else "returning" if self.returning else "running"

    def _stands_as_planned(self, state: VehicleState) -> bool:
        """Whether it has come to where its route ends, and stays there."""
        arrived = NumberedStops(self.planned).arrived
        return bool(state.order_id) and not self.planned.every_round and state.last_sequence // 2 == arrived

    def differences(self) -> tuple[str, ...]:
        """How what it says is ahead of it differs from its order."""
        order, state = self._order, self.state
        if order is None or state is None or not self.has_order(order):
            return ("it does not have the order",)
        found = [
            *_part_differences("node", order["nodes"], "nodeId", state.nodes, state.last_sequence),
            *_part_differences("edge", order["edges"], "edgeId", state.edges, state.last_sequence),
        ]
        ahead = (node for node in order["nodes"] if node["sequenceId"] > state.last_sequence)
        waits = {action["actionId"] for node in ahead for action in node["actions"]}
        return (*found, *(f"it does not know of the action {name}" for name in sorted(waits - set(state.actions))))

    def way_home(self) -> Route | None:
        """From where it is over planned legs alone: on to the end of its round, then its approach backwards.

        None where it does not say where it is. A robot on its approach turns back at once.
        """
        if self.state is None or self.state.place_m is None:
            return None
        stops = NumberedStops(self.planned)
        last = self.state.last_sequence // 2
        speed_m_s = next((stop.speed_m_s for stop in stops.once if stop.speed_m_s), None)
        speed_m_s = speed_m_s or next((stop.speed_m_s for stop in stops.every_round if stop.speed_m_s), 1.0)
        ahead: list[RouteStop] = []
        if last >= stops.arrived and stops.every_round:
            done = (last - stops.arrived) % len(stops.every_round)
            ahead = list(stops.every_round[done:]) if done else []
        back = stops.once[: min(last, stops.arrived) + 1][::-1]
        places = [stop.place_m for stop in (*ahead, *back)]
        way = [RouteStop(place_m=place, speed_m_s=speed_m_s) for place in places]
        here = (*self.state.place_m, places[0][2])
        return Route(robot=self.robot, start_m=here, approach=tuple(way[:-1]), loop=(way[-1],), closing=None)


def _part_differences(what: str, sent: list[Json], key: str, held: tuple[Part, ...], last: int) -> list[str]:
    wanted = [
        Part(name=part[key], sequence=part["sequenceId"], released=part["released"])
        for part in sent
        if part["sequenceId"] > last
    ]
    if len(wanted) != len(held):
        return [f"it holds {len(held)} {what}s of {len(wanted)}"]
    return [
        f"{what} {was.sequence}: it holds {have}; {was} was sent"
        for was, have in zip(wanted, held, strict=True)
        if was != have
    ]
