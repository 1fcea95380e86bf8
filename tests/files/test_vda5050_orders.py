"""Orders and their updates beside the official JSON schema and the rules that vda5050-sdk gives a vehicle."""

from __future__ import annotations

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

from rota.driven_route import from_start
from rota.errors import PlanError
from rota.files.vda5050_orders import Vehicle, Window, base_end, order_message, order_messages
from rota.route import Route, route_of

ORDER = "0c6c9a2e-order"
VEHICLE = Vehicle(serial_number="robot-1", manufacturer="Rota", map_id="quay")
NOW = "2026-05-01T12:00:00.000Z"


def routes() -> tuple[Route, Route]:
    """One that loops and waits, one that stays."""
    plan = two_robots(robots=("a", "b"))
    first, second = (route_of(trajectory, 0) for trajectory in plan)
    return first, second


def messages(route: Route, window: Window, count: int) -> list[dict[str, Any]]:
    made = order_messages(route, VEHICLE, ORDER, window=window, timestamp=lambda first: f"{first:04d}-01-01T00:00:00Z")
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
            assert [str(action.blocking_type.value) for action in waits] == ["HARD"] * len(node.actions)
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
    looping, _ = routes()
    with pytest.raises(PlanError, match="order id 'a b': VDA 5050"):
        order_message(looping, VEHICLE, "a b", update=0, first=0, window=Window(), timestamp=NOW)
    most = 2**32 - 1
    ends = order_message(
        looping, VEHICLE, ORDER, update=7, first=most // 2 - 1, window=Window(released=1, announced=0), timestamp=NOW
    )
    assert SchemaValidator().errors("order", ends) == []
    assert ends["nodes"][-1]["sequenceId"] == most - 1
    with pytest.raises(PlanError, match="robot a: the order has used up VDA 5050's sequence ids"):
        order_message(looping, VEHICLE, ORDER, update=7, first=most // 2, window=Window(), timestamp=NOW)
