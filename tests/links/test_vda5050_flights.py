"""Which flights vehicles get as orders, and where they charge."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.relieved import SQUARE_M, TURN_S, relieved

from rota.links.vda5050_flights import VehicleFlights
from rota.model.mission import Charger
from rota.model.plan import Plan


def swapped() -> Plan:
    """The same plan where batteries are swapped."""
    plan = relieved(3)
    pads = (Charger(name="pad", at=(0, 0), places=99, swap_s=60),)
    return replace(plan, mission=replace(plan.mission, chargers=pads))


@pytest.mark.parametrize(
    ("plan", "charging", "fills"), [(relieved(3), True, True), (relieved(3), False, False), (swapped(), True, False)]
)
def test_a_flight_ends_where_its_vehicle_charges(plan: Plan, charging: bool, fills: bool) -> None:
    flights = VehicleFlights(plan, charging)
    assert [flights.is_docked(f"robot-{k}") for k in (1, 2, 3)] == [False, True, False]
    stops = flights.stops("robot-2", TURN_S)
    assert stops is not None
    assert [stop.place_m[:2] for stop in stops.once] == [(0, 0), *SQUARE_M, *SQUARE_M[1:], (0, 0)]
    assert [stops.charges_at(number) for number in range(len(stops.once))] == [*[False] * stops.arrived, fills]
    assert flights.stops("robot-2", 1.0) is None
    under_way = flights.stops("robot-3", 0.0)  # half of the second round is left of its flight
    assert under_way is not None
    assert under_way.once[0].place_m[:2] == (10, 10)
