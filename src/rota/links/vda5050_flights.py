"""The flights of robots that charge as orders of VDA 5050: each ends on a charger, and the next begins there."""

from __future__ import annotations

from rota.files.vda5050_orders import NumberedStops
from rota.model.plan import Plan
from rota.routes.flights import has_flights
from rota.routes.moments import flight_after
from rota.routes.route import route_of


class VehicleFlights:
    """The flights of a plan's robots. charging: vehicles are told to charge, where batteries are not swapped."""

    def __init__(self, plan: Plan, charging: bool) -> None:
        self._fleet = plan.mission.fleet
        self._ways = {way.robot: way for way in plan if has_flights(way)}
        self._fills = {pad.name: charging and pad.swap_s is None for pad in plan.mission.chargers}

    def __contains__(self, robot: object) -> bool:
        """Whether a robot charges again and again."""
        return robot in self._ways

    def is_docked(self, robot: str) -> bool:
        """Whether a robot is on a charger when its plan begins."""
        return robot in self._ways and flight_after(self._ways[robot], 0.0) is None

    def stops(self, robot: str, plan_s: float) -> NumberedStops | None:
        """The stops of the flight that a robot is on, or leaves its charger for, at a moment; None: it stays on it."""
        flight = flight_after(self._ways[robot], plan_s)
        if flight is None:
            return None
        fills = bool(flight.charges) and self._fills[flight.charges[-1].charger]
        route = route_of(flight, self._fleet.altitude_m)
        return NumberedStops(route, self._fleet.robot(robot).turn_rate_rad_s, fills)
