"""Flights that lead robots that take over into their loops: drawn as such, and as no loops of their own."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.replanning.relays import relay

from rota import Kind, Plan, replan
from rota.draw.charging_chart import charging_chart
from rota.draw.route_lines import route_label
from rota.draw.routes import ONCE, routes_of, service_in
from rota.routes.flights import flights_of


@pytest.fixture(scope="module")
def taken_over() -> Plan:
    """A relay of three in which the one to spare takes the place of one that was lost in flight."""
    return replan(relay(spare=True), at_s=10.0, lost=["a"], should_stop=lambda: True).plan


def test_a_flight_that_is_flown_once_serves_no_loop(taken_over: Plan) -> None:
    service, flights = service_in(taken_over), [flight for line in taken_over for flight in flights_of(line)]
    assert len(service.loops) == len(routes_of(taken_over)) == 1
    assert {flight.every_s == 0 for flight in flights} == {True, False}
    assert [loop == ONCE for loop in service.serves] == [flight.every_s == 0 for flight in flights]
    told = [entry.get_label() for entry in charging_chart(taken_over).legend]
    assert told[:2] == ["serves A, ways included", "flown once, until loops begin"]


def test_robots_are_told_by_name_where_their_numbers_are_others(taken_over: Plan) -> None:
    [route] = routes_of(taken_over)
    assert route_label(taken_over, route) == "A: 40.0 m, 40.0 s, b, c, d in turns"


def test_robots_of_kinds_are_told_by_name_since_several_have_a_number() -> None:
    plan = relay(spare=False)
    named = tuple(replace(way, robot=f"quad-{k + 1}") for k, way in enumerate(plan))
    alike = replace(plan.mission.fleet, robots="fewest")
    of_kinds = replace(alike, kinds=(Kind(name="quad", cost=1.0),))
    for fleet, told in (alike, "robots 1–3 in turns"), (of_kinds, "quad-1, quad-2, quad-3 in turns"):
        own = replace(plan, trajectories=named, mission=replace(plan.mission, fleet=fleet))
        [route] = routes_of(own)
        assert route_label(own, route).endswith(told)


def test_a_plan_without_such_flights_has_no_word_of_them() -> None:
    plan = relay(spare=False)
    assert ONCE not in service_in(plan).serves
    assert not any("once" in str(entry.get_label()) for entry in charging_chart(plan).legend)
