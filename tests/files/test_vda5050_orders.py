"""Orders and their updates beside the official JSON schema and the rules that vda5050-sdk gives a vehicle."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import islice
from typing import Any

import pytest
from tests.files.two_robots import two_robots
from vda5050.domain.order import AcceptanceDecision, OrderAcceptancePolicy, validate_order_structure
from vda5050.domain.sessions.vehicle_session import VehicleSession
from vda5050.identity import VehicleKey
from vda5050.model.order import Order
from vda5050.validation.schema_validator import SchemaValidator

from rota.errors import PlanError
from rota.files.vda5050_orders import NumberedStops, Span, Vehicle, Window, base_end, order_message, order_messages
from rota.files.vda5050_versions import Protocol, WaitAction
from rota.routes.driven_route import from_start
from rota.routes.route import Route, RouteStop, route_of

ORDER = "0c6c9a2e-order"
VEHICLE = Vehicle(serial_number="robot-1", manufacturer="Rota", map_id="quay")
NOW = "2026-05-01T12:00:00.000Z"


def routes() -> tuple[Route, Route]:
    """One that loops and waits, one that stays."""
    plan = two_robots(robots=("a", "b"))
    first, second = (route_of(trajectory, 0) for trajectory in plan)
    return first, second


def messages(route: Route, window: Window, count: int) -> list[dict[str, Any]]:
    stops = NumberedStops(route)
    made = order_messages(stops, VEHICLE, ORDER, window=window, timestamp=lambda first: f"{first:04d}-01-01T00:00:00Z")
    return list(islice(made, count))


def drive(sent: list[dict[str, Any]], map_id: str = "map") -> list[tuple[float, float, float | None, float]]:
    """x, y, speed and wait of every node that a vehicle passes, which takes orders as the SDK says and checks them."""
    session = VehicleSession(key=VehicleKey(manufacturer="Rota", serial_number="robot-1"))
    policy, schemas = OrderAcceptancePolicy(), SchemaValidator()
    passed: dict[int, tuple[float, float, float | None, float]] = {}
    for count, message in enumerate(sent):
        assert schemas.errors("order", message) == []
        order = Order.model_validate(message)
        validate_order_structure(order)
        expected = AcceptanceDecision.ACCEPT_UPDATE if count else AcceptanceDecision.ACCEPT_NEW
        assert policy.evaluate(order, session).decision == expected
        session.apply_order(order)
        assert (order.header_id, order.order_update_id) == (count, count)
        edges = {edge.sequence_id: edge for edge in order.edges if edge.released}
        for node in (node for node in order.nodes if node.released):
            assert node.node_position is not None
            assert node.node_position.map_id == map_id
            waits = [action for action in node.actions if action.action_type == "wait"]
            assert {str(action.blocking_type.value) for action in node.actions} <= {"HARD"}
            assert {action.action_type for action in node.actions} <= {"wait", "startCharging"}
            wait_s = sum(parameter.value for action in waits for parameter in action.action_parameters or ())
            edge = edges.get(node.sequence_id - 1)
            seen = (node.node_position.x, node.node_position.y, edge.max_speed if edge else None, wait_s)
            # the stitching node comes again, unchanged but for the edge that led to it
            known = passed.setdefault(node.sequence_id, seen)
            assert (known[:2], known[3]) == (seen[:2], seen[3])
    return [passed[number] for number in sorted(passed)]


@pytest.mark.parametrize("window", [Window(), Window(released=1, announced=0), Window(released=3, announced=2)])
def test_a_vehicle_that_takes_all_updates_drives_the_loop_again_and_again(window: Window) -> None:
    looping, _ = routes()
    passed = drive(messages(looping, window, 20), "quay")
    assert len(passed) >= 21
    start, *rest = passed
    assert start[:3] == (-20, 0, None)
    stops = [*from_start(looping)[1:], *(looping.every_round * 30)]
    for node, stop in zip(rest, stops, strict=False):
        assert node == (*stop.place_m[:2], stop.speed_m_s, stop.hold_s)


def test_a_message_says_what_is_released_and_what_is_likely() -> None:
    looping, _ = routes()
    order, update = messages(looping, Window(released=3, announced=2), 2)
    assert [node["nodeId"] for node in order["nodes"]] == ["a0", "l0", "l1", "l2", "l3", "l0"]
    assert [node["released"] for node in order["nodes"]] == [True] * 4 + [False] * 2
    assert [edge["released"] for edge in order["edges"]] == [True] * 3 + [False] * 2
    assert [edge["edgeId"] for edge in order["edges"]] == ["a0-l0", "l0-l1", "l1-l2", "l2-l3", "l3-l0"]
    assert base_end(order) == 3
    assert [node["nodeId"] for node in update["nodes"]] == ["l2", "l3", "l0", "l1", "l2"]
    assert [node["sequenceId"] for node in update["nodes"]] == [6, 8, 10, 12, 14]
    assert update["nodes"][0] == order["nodes"][3]
    assert (order["timestamp"], update["timestamp"]) == ("0000-01-01T00:00:00Z", "0003-01-01T00:00:00Z")


def test_the_orders_of_a_robot_that_stays_come_to_an_end() -> None:
    _, staying = routes()
    (order,) = messages(staying, Window(), 9)
    assert [node["nodeId"] for node in order["nodes"]] == ["a0", "l0"]
    assert all(node["released"] for node in order["nodes"])
    assert drive([order], "quay") == [(200, 200, None, 0), (200, 90, 110 / 30, 0)]
    waiting = replace(staying, loop=(replace(staying.loop[0], speed_m_s=None),))
    (order,) = messages(waiting, Window(), 9)
    assert (len(order["nodes"]), order["edges"]) == (1, [])


def test_names_and_numbers_that_vda5050_cannot_hold_are_refused() -> None:
    with pytest.raises(PlanError, match="serial number 'Zoë': VDA 5050 takes only the characters"):
        replace(VEHICLE, serial_number="Zoë")
    with pytest.raises(PlanError, match="manufacturer 'a/b': VDA 5050"):
        replace(VEHICLE, manufacturer="a/b")
    with pytest.raises(PlanError, match="map id '': VDA 5050"):
        replace(VEHICLE, map_id="")
    looping = NumberedStops(routes()[0])
    with pytest.raises(PlanError, match="order id 'a b': VDA 5050"):
        order_message(looping, VEHICLE, "a b", update=0, span=Span(first=0, released=1, last=1), timestamp=NOW)
    most = 2**32 - 1
    span = Span(first=most // 2 - 1, released=most // 2, last=most // 2)
    ends = order_message(looping, VEHICLE, ORDER, update=7, span=span, timestamp=NOW)
    assert SchemaValidator().errors("order", ends) == []
    assert ends["nodes"][-1]["sequenceId"] == most - 1
    over = Span(first=most // 2, released=most // 2, last=most // 2 + 1)
    with pytest.raises(PlanError, match="robot a: the order has used up VDA 5050's sequence ids"):
        order_message(looping, VEHICLE, ORDER, update=7, span=over, timestamp=NOW)


@pytest.mark.parametrize("released", [1, 2, 3, 4, 50])
def test_what_is_released_ends_where_nobody_waits(released: int) -> None:
    looping, _ = routes()
    for message in messages(looping, Window(released=released, announced=3), 20):
        first, last = message["nodes"][0], [node for node in message["nodes"] if node["released"]][-1]
        assert first["actions"] == last["actions"] == []
        assert message["edges"]


def test_where_every_stop_waits_what_is_released_ends_at_one_that_does() -> None:
    looping, _ = routes()
    waiting = [replace(stop, hold_s=2.0) for stop in looping.loop]
    sent = messages(replace(looping, loop=tuple(waiting)), Window(released=2, announced=1), 9)
    assert sent[0]["nodes"][2]["actions"] == sent[1]["nodes"][0]["actions"] != []
    drive(sent, "quay")


def test_a_robot_waits_for_what_its_turns_leave_of_a_stop() -> None:
    square = [(0, 0), (10, 0), (10, 10), (0, 10)]
    loop = [RouteStop(place_m=(x, y, 0.0), speed_m_s=1.0, hold_s=4.0) for x, y in square]
    closing = replace(loop[0], hold_s=0.0)
    route = Route(robot="a", start_m=(-5, 0, 0), approach=(), loop=tuple(loop), closing=closing)
    # it comes in straight on, and turns by a right angle at each corner, which takes pi / 2 s at 1 rad/s
    stops = NumberedStops(route, turn_rate_rad_s=1.0)
    assert [stop.turn_s for stop in stops.once] == [0, 0]
    assert [stop.turn_s for stop in stops.every_round] == pytest.approx([math.pi / 2] * 4)
    (order,) = islice(order_messages(stops, VEHICLE, ORDER, window=Window(), timestamp=lambda _: NOW), 1)
    waits = [node["actions"][0]["actionParameters"][0]["value"] for node in order["nodes"] if node["actions"]]
    assert waits == pytest.approx([4.0, *[4 - math.pi / 2] * 4])
    # a hold that the turn takes up, as plans have it, is no wait at all
    quick = NumberedStops(route, turn_rate_rad_s=math.pi / 8)
    assert [stop.wait_s for stop in quick.every_round] == [0, 0, 0, 0]


def test_version_3_has_edges_without_ends_and_vehicles_wait_as_they_can() -> None:
    looping, _ = routes()
    lift = WaitAction(name="linger", parameter="forSeconds", whole=True)
    spoken = replace(VEHICLE, protocol=Protocol(version="3.0.0"), wait=lift)
    stops = NumberedStops(looping)
    (order,) = list(islice(order_messages(stops, spoken, ORDER, window=Window(), timestamp=lambda _: NOW), 1))
    assert order["version"] == "3.0.0"
    assert set(order["edges"][0]) == {"edgeId", "sequenceId", "released", "maximumSpeed", "actions"}
    waits = [node["actions"] for node in order["nodes"] if node["actions"]]
    assert [(action["actionType"], action["actionParameters"]) for (action,) in waits] == [
        ("linger", [{"key": "forSeconds", "value": 1}])
    ]
    triggered = WaitAction(name="waitForTrigger", parameter=None).action("a", 3.0)
    assert triggered["actionParameters"] == [{"key": "triggerType", "value": ["FLEET_CONTROL"]}]
