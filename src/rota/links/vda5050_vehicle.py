"""One VDA 5050 vehicle as its master sees it: the order that it has, its last state, and what it is to be sent next."""

from __future__ import annotations

import asyncio
import time
import uuid
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from typing import Any

from rota.files.timed_places import instant_text
from rota.files.vda5050_orders import NumberedStops, Vehicle, Window, order_message, wait_id
from rota.files.vda5050_versions import Protocol, WaitAction, protocol_of
from rota.links.link import Mode
from rota.links.vda5050_pace import Pace
from rota.links.vda5050_state import Part, VehicleError, VehicleState
from rota.routes.route import Route, RouteStop

Json = dict[str, Any]

ENDED = ("FINISHED", "FAILED")
MOST_LEVELS = 5  # of topics on which a vehicle is heard
ASK_AGAIN_S = 2.0  # MQTT's quality of service 0, which VDA 5050 asks for, may lose messages


@dataclass(kw_only=True)
class Vda5050Vehicle:
    """What is known of a vehicle. ``planned``: the stops of its robot, also where another program has sent it.

    ``versions``: what it says that it speaks, by the second level of its topics; ``level``: the one that its states
    have, empty until one is heard.
    ``has_factsheet``: whether it has told one; ``knows_to_wait``: the action by which it waits, as that tells.
    ``news`` is told of every message. ``was_away``: it or the broker was
    lost since it was last asked for its state. ``held``: it is paused until all go on. ``left_s``: when in the plan it
    last left a charger. ``begun_s``: when the clock that it keeps to started, None: it has not; ``behind_s``: how far
    that is behind the plan's.
    """

    identity: Vehicle
    planned: NumberedStops
    top_speed_m_s: float
    window: Window
    state: VehicleState | None = None
    versions: dict[str, str] = field(default_factory=dict)
    level: str = ""
    has_factsheet: bool = False
    knows_to_wait: WaitAction | None = None
    connection: str = ""
    was_away: bool = False
    returning: bool = False
    held: bool = False
    left_s: float | None = None
    begun_s: float | None = None
    behind_s: float = 0.0
    news: asyncio.Condition = field(default_factory=asyncio.Condition)
    _pace: Pace | None = None
    _order: Json | None = None
    _sent_s: float = 0.0
    # a vehicle may still report what was wrong with messages of the program before this one
    _header: int = field(default_factory=lambda: int(time.time()) % 2**31)
    _triggered: tuple[str, float] = ("", 0.0)

    @property
    def robot(self) -> str:
        """The robot's name."""
        return self.planned.robot

    def hear_version(self, level: str, version: str, *, by_state: bool) -> Protocol | None:
        """It says that it speaks a version on topics of a level; its states decide which of them it is spoken to in.

        Brokers also keep what vehicles said before they were given a newer one. Returns the version's protocol.
        """
        if level in self.versions or len(self.versions) < MOST_LEVELS:
            self.versions[level] = version
        protocol = protocol_of(version)
        if protocol is not None and (by_state or not self.level):
            self.identity = replace(self.identity, protocol=protocol)
            self.level = level if by_state else ""
        return protocol

    @property
    def spoken(self) -> dict[str, Protocol]:
        """The versions that it says it speaks and that are spoken here, by their levels."""
        known = {level: protocol_of(version) for level, version in self.versions.items()}
        return {level: protocol for level, protocol in known.items() if protocol is not None}

    def order(self, stops: NumberedStops, from_s: float = 0.0) -> Json:
        """A new order for a route's stops, which replaces what it had; from_s: when in the plan it begins."""
        self._pace = Pace(stops, self.top_speed_m_s)
        if from_s and self.begun_s is not None:
            self.planned = stops
            self._pace.begin(self.begun_s + from_s)
            self.keep(self.behind_s)
        return self._extended(f"{self.identity.serial_number}-{uuid.uuid4().hex}", update=0)

    def forget(self) -> None:
        """It has no order of this program any more."""
        self._pace, self._order, self.returning, self.held = None, None, False, False
        self.begun_s, self.left_s, self.behind_s = None, None, 0.0

    def begin(self, others_s: float | None) -> None:
        """The clock that it keeps to starts now, or has when that of others did, unless it runs already."""
        if self.returning or self.begun_s is not None:
            return
        self.begun_s = time.monotonic() if others_s is None else others_s
        if self._pace is not None:
            self._pace.begin(self.begun_s)

    def keep(self, behind_s: float) -> None:
        """Let the clock that it keeps to be so far behind the plan's."""
        self.behind_s = behind_s
        if self._pace is not None:
            self._pace.behind_s = behind_s

    @property
    def room_s(self) -> float:
        """How late it may be and make it up within a round."""
        return 0.0 if self._pace is None else self._pace.room_s()

    @property
    def trouble(self) -> str:
        """That it is lost, cannot go on, or does not take what it is told, and what it reports; else empty."""
        if self.connection not in ("", "ONLINE"):
            return f"robot {self.robot}: the broker says that it is {self.connection}"
        error, order = next((error for error in self.errors if error.is_fatal), None), self._order
        if error is None and order is not None and not self.has_order(order):
            error = self.refusal("order", order)
            has_another = self.state is not None and self.state.order_id != order["orderId"]
            if error is None and has_another and self.begun_s is not None:
                return f"robot {self.robot}: it does not have its order any more; it needs to be sent its route again"
        return f"robot {self.robot}: it reports {error.text()}" if error is not None else ""

    def take(self, state: VehicleState) -> None:
        """Use a new state of its."""
        self.state = state
        if self._pace is not None and self._order is not None and state.order_id == self._order["orderId"]:
            self._pace.heard(_reached(state), time.monotonic())

    def update_due(self) -> Json | None:
        """The order's update, once it is time for it and the vehicle has taken the update before.

        A vehicle that is paused gets none: it does not get on, and what it holds may just be being compared.
        An update that it has not taken after ``ASK_AGAIN_S`` is due again: it may have been lost. None also where the
        order was cancelled, or replaced, by others.
        """
        state, order, pace, now_s = self.state, self._order, self._pace, time.monotonic()
        if state is None or order is None or pace is None or state.paused or state.order_id != order["orderId"]:
            return None
        if state.update != order["orderUpdateId"]:
            is_late = now_s - self._sent_s > ASK_AGAIN_S
            return self._again() if is_late and state.update == order["orderUpdateId"] - 1 else None
        last = _reached(state)
        # without stops ahead it has either come to the end of what was released or been told to give up
        is_driving = bool(state.nodes) or last >= pace.end
        if not is_driving or not pace.is_due(last, self.window, now_s):
            return None
        return self._extended(order["orderId"], update=order["orderUpdateId"] + 1)

    def trigger_due(self) -> Json | None:
        """The instant action that ends its wait where it is, once it is time for it; again if it was lost."""
        state, order, pace, now_s = self.state, self._order, self._pace, time.monotonic()
        wait = self.identity.wait
        if state is None or order is None or pace is None or wait is None or wait.parameter is not None:
            return None
        last = _reached(state)
        name, sent_s = self._triggered
        waiting = wait_id(order["orderId"], last)
        if state.paused or state.actions.get(waiting) != "RUNNING" or now_s < pace.goes_on_s(last):
            return None
        if name == waiting and now_s - sent_s <= ASK_AGAIN_S:
            return None
        self._triggered = (waiting, now_s)
        return self.instant_action("trigger")[1]

    def _again(self) -> Json | None:
        self._sent_s = time.monotonic()
        return self._order

    def _extended(self, order_id: str, *, update: int) -> Json:
        """The order with the stops that are released next, or a new one."""
        assert self._pace is not None
        pace, with_waits = self._pace, self.identity.wait is not None
        span = pace.span(self.window, with_waits=with_waits)
        pace.release(span.released, time.monotonic(), with_waits=with_waits)
        self._order = order_message(
            pace.stops, self.identity, order_id, update=update, span=span, timestamp=_now(), told=pace.told
        )
        self._sent_s = time.monotonic()
        return self._order

    def instant_action(self, kind: str, protocol: Protocol | None = None) -> tuple[str, Json]:
        """An instant action without parameters, by another version if one is given: its id, and the message."""
        self._header += 1
        action_id, protocol = f"{kind}-{uuid.uuid4().hex}", protocol or self.identity.protocol
        blocking = protocol.instant_blocking if kind in ("startPause", "stopPause", "cancelOrder") else "NONE"
        action = {"actionType": kind, "actionId": action_id, "blockingType": blocking, "actionParameters": []}
        message = {
            "headerId": self._header,
            "timestamp": _now(),
            "version": protocol.version,
            "manufacturer": self.identity.manufacturer,
            "serialNumber": self.identity.serial_number,
            **protocol.instant_actions([action]),
        }
        return action_id, message

    def refusal(self, topic: str, message: Json) -> VehicleError | None:
        """An error of its last state that names the order or the actions of a message to a topic, or these' header."""
        names = {message.get("orderId"), *(action["actionId"] for action in message.get("actions", ()))}
        header = {("topic", topic), ("headerId", str(message["headerId"]))} if "actions" in message else None
        for error in self.errors:
            if any(value in names for _, value in error.about) or (header and header <= error.about):
                return error
        return None

    @property
    def errors(self) -> tuple[VehicleError, ...]:
        """What it reports as errors in its last state."""
        return self.state.errors if self.state is not None else ()

    def has_order(self, order: Json) -> bool:
        """Whether its last state is about this order."""
        state = self.state
        return state is not None and (state.order_id, state.update) == (order["orderId"], order["orderUpdateId"])

    def mode(self) -> Mode:
        """What it is doing, as its last state tells."""
        state = self.state
        if state is None or any(error.is_fatal for error in state.errors):
            return "failed" if state is not None else "idle"
        docked = self._order is None and self.begun_s is not None
        if not docked and not state.nodes and not self._stands_as_planned(state):
            return "idle"
        return "paused" if state.paused and not self.held else "returning" if self.returning else "running"

    def _stands_as_planned(self, state: VehicleState) -> bool:
        """Whether it has come to where its route ends, and stays there."""
        stays = not self.planned.every_round and _reached(state) == self.planned.arrived
        return bool(state.order_id) and (stays or self._is_held(state))

    def _is_held(self, state: VehicleState) -> bool:
        """Whether it waits at the end of what this program has released to it."""
        pace, order = self._pace, self._order
        return pace is not None and order is not None and self.has_order(order) and _reached(state) == pace.end

    def differences(self) -> tuple[str, ...]:
        """How what it says is ahead of it differs from its order."""
        order, state = self._order, self.state
        if order is None or state is None or not self.has_order(order):
            return ("it does not have the order",)
        last = 2 * _reached(state)
        found = [
            *_part_differences("node", order["nodes"], "nodeId", state.nodes, last),
            *_part_differences("edge", order["edges"], "edgeId", state.edges, last),
        ]
        ahead = (node for node in order["nodes"] if node["released"] and node["sequenceId"] > last)
        waits = {action["actionId"] for node in ahead for action in node["actions"]}
        return (*found, *(f"it does not know of the action {name}" for name in sorted(waits - set(state.actions))))

    def way_home(self) -> Route | None:
        """From where it is over planned legs alone: on to the end of its round, then its approach backwards.

        None where it does not say where it is. A robot on its approach turns back at once.
        """
        if self.state is None or self.state.place_m is None:
            return None
        stops, last = self.planned, _reached(self.state)
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


def _reached(state: VehicleState) -> int:
    """The stop that it reached last. One that is paused may not have begun with the first, and names an older one."""
    return 0 if any(part.sequence == 0 for part in state.nodes) else state.last_sequence // 2


def _part_differences(what: str, sent: list[Json], key: str, held: tuple[Part, ...], last: int) -> list[str]:
    """How the nodes or edges that a vehicle holds differ from those sent, in words."""
    wanted = [
        Part(name=part[key], sequence=part["sequenceId"], released=part["released"])
        for part in sent
        if part["sequenceId"] > last
    ]
    # a vehicle that is paused may not have left the node where it stands
    held = tuple(part for part in held if part.sequence > last)
    if len(wanted) != len(held):
        return [f"it holds {len(held)} {what}s of {len(wanted)}"]
    return [
        f"{what} {was.sequence}: it holds {have}; {was} was sent"
        for was, have in zip(wanted, held, strict=True)
        if was != have
    ]


def _now() -> str:
    return instant_text(datetime.fromtimestamp(time.time(), UTC))
