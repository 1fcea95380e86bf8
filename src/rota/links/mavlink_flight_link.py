"""Copters that charge, on missions of their own: each flight is one, sent when it is due."""

from __future__ import annotations

import asyncio
import math
from dataclasses import replace

import numpy as np

from rota.errors import LinkError
from rota.files.geodesy import Projection
from rota.links.link import Dock, Mode, Order
from rota.links.mavlink_held import MISSION, as_sent
from rota.links.mavlink_items import WireItem, require_room
from rota.links.mavlink_link import MavlinkLink, MavlinkSettings
from rota.links.mavlink_pace import MissionPace
from rota.links.mavlink_target_link import OWN_SPOT_M
from rota.links.mavlink_vehicle import MavlinkVehicle
from rota.model.plan import Plan
from rota.routes.flights import has_flights
from rota.routes.moments import route_after
from rota.routes.route import Route
from rota.vehicles.presets import ARDUCOPTER, PX4

SENDS_S = 5.0  # how long a mission may take to be sent before its copter takes off


class MavlinkFlightLink(MavlinkLink):
    """A Link to copters that charge; those that do not fly their missions as ever.

    On its charger a copter holds no mission. One that is to leave gets that of its next flight, climbs, and begins with
    its first waypoint when it is time; the mission ends with a landing on the charger. ArduCopters hold their posts by
    pauses, PX4s in their mode HOLD.
    """

    relieves = True

    def __init__(self, plan: Plan, projection: Projection, settings: MavlinkSettings) -> None:
        fleet = plan.mission.fleet
        tops_m_s = {way.robot: fleet.robot(way.robot).speed_m_s for way in plan}
        super().__init__(tops_m_s, plan.mission.area.bounds, projection, settings, {})
        self._altitude_m = fleet.altitude_m
        self._ways = {way.robot: way for way in plan if has_flights(way)}
        # of those that charge the flight whose mission they hold; None: they are on a charger
        self._flown: dict[str, Route | None] = {name: self._flight_at(name, 0.0) for name in self._ways}
        self._leaving: set[str] = set()
        self.lead_s = ARDUCOPTER.climbing_s(fleet.altitude_m) + SENDS_S
        self._spots_m: dict[str, tuple[float, float]] = {}
        # PX4s that hold their posts, and copters that hover before and after their flights, as this link has told them
        self._hold: set[str] = set()
        self._hovers: set[str] = set()

    def _flight_at(self, robot: str, plan_s: float) -> Route | None:
        """The flight that a robot is on, or leaves its charger for, at a moment; None: it stays on it."""
        return route_after(self._ways[robot], plan_s, self._altitude_m)

    async def _connect(self, robot: str) -> None:
        await super()._connect(robot)
        if self._vehicle(robot).autopilot == "px4":
            self.lead_s = max(self.lead_s, PX4.climbing_s(self._altitude_m) + SENDS_S)

    def _mode(self, vehicle: MavlinkVehicle) -> Mode | None:
        """One that holds its post, or is on its charger, does what its plan asks for, though its mode is HOLD."""
        robot = vehicle.robot
        as_planned = robot in self._hold | self._hovers or (robot in self._ways and not vehicle.in_air)
        return "running" if as_planned and vehicle.mode == "paused" else vehicle.mode

    def _items(self, route: Route, vehicle: MavlinkVehicle) -> list[WireItem]:
        """Those of its flight; none on a charger."""
        flown = self._flown.get(route.robot, route)
        return [] if flown is None else super()._items(flown, vehicle)

    async def send_route(self, route: Route) -> None:
        """With the mission of the flight alone that a robot is on, and with its fence and rally points."""
        flown = self._flown.get(route.robot)
        told = route if flown is None else replace(flown, fence=route.fence, rally_m=route.rally_m)
        await super().send_route(told)

    async def start(self, robot: str) -> None:
        """One that begins on its charger, and is on the ground, stays there until ``keep`` has it leave."""
        if (spot_m := self.home_m(robot)) is not None:
            self._spots_m.setdefault(robot, spot_m[:2])  # its home is another one whenever it arms
        if self._flown.get(robot, robot) is not None or self._vehicle(robot).in_air:
            await super().start(robot)

    async def keep(self, order: Order) -> None:
        """On its charger it lands, and leaves it with the mission of its next flight."""
        if order.dock is None:
            await self._hold_or_go_on(self._vehicle(order.robot), holds=order.rate == 0)
            await super().keep(order)
        elif not order.dock.leaves:
            await self._stay(order.robot, order.dock)
        elif order.robot not in self._leaving:
            self._leaving.add(order.robot)
            try:
                await self._leave(self._vehicle(order.robot), order.dock, order.behind_s)
            except BaseException:
                self._leaving.discard(order.robot)
                raise

    async def _hold_or_go_on(self, vehicle: MavlinkVehicle, *, holds: bool) -> None:
        """Let a PX4 on its mission hold, or go on after that; not one whose mode somebody else has changed."""
        robot = vehicle.robot
        if vehicle.autopilot != "px4" or robot not in self._paces or holds == (robot in self._hold):
            return
        if holds and vehicle.mode == "running":
            self._hold.add(robot)
            raw = vehicle.plugin("mission_raw", "MissionRaw")
            await vehicle.ask("holding its post", raw.pause_mission_async)
        elif not holds:
            if vehicle.mode in ("paused", "running"):  # it may not have told yet that it holds
                await self._paces[robot].go_on_from_hold()
            self._hold.discard(robot)

    async def pause(self, robot: str) -> None:
        """Hold, whatever it was told before."""
        self._hold.discard(robot)
        self._hovers.discard(robot)
        await super().pause(robot)

    async def close(self) -> None:
        """Who holds its post goes on with its mission first: nobody would let it go later."""
        held = [self._hold_or_go_on(self._vehicles[robot], holds=False) for robot in sorted(self._hold)]
        for outcome in await asyncio.gather(*held, return_exceptions=True):
            if isinstance(outcome, BaseException) and not isinstance(outcome, LinkError):
                raise outcome
        await super().close()

    async def _stay(self, robot: str, dock: Dock) -> None:
        """Land where it stood at first, if that is at this charger: others stand beside it. Then hold no mission."""
        self._leaving.discard(robot)
        self._hold.discard(robot)
        vehicle, flown = self._vehicle(robot), self._flown.get(robot)
        if vehicle.in_air:
            await self._land_at(robot, dock)
        if flown is not None:
            raw = vehicle.plugin("mission_raw", "MissionRaw")
            await vehicle.ask("clearing the mission", raw.clear_mission_async)
            self._flown[robot] = None

    async def _land_at(self, robot: str, dock: Dock) -> None:
        """Fly to its spot at the charger, and land there."""
        x, y = self._ways[robot].at(np.array([dock.plan_s]))[0, :2].tolist()
        own_m = self._spots_m.get(robot, (x, y))
        at_m = own_m if math.dist(own_m, (x, y)) <= OWN_SPOT_M else (x, y)
        self._hovers.add(robot)
        await self.go(robot, [(*at_m, self._altitude_m)])
        await self.land(robot)
        self._hovers.discard(robot)

    async def _leave(self, vehicle: MavlinkVehicle, dock: Dock, behind_s: float) -> None:
        """Hold the mission of the flight, climb, hover until it is time, and fly it from its first waypoint on."""
        robot = vehicle.robot
        flight = self._flight_at(robot, dock.plan_s)
        if flight is None:
            return
        self._flown[robot] = flight
        items = self._items(flight, vehicle)
        if vehicle.autopilot == "ardupilot":
            require_room(robot, items, ())
        raw = vehicle.plugin("mission_raw", "MissionRaw")
        await vehicle.ask("the mission of its next flight", raw.upload_mission_async, as_sent(items, MISSION))
        self._hovers.add(robot)
        if not vehicle.in_air:
            await self.climb(robot, self._altitude_m)
        self._paces[robot] = MissionPace(vehicle, items, flight.once[0], self._top_m_s[robot], dock.plan_s + behind_s)
        await self._paces[robot].start_in_air(self.time_s)
        self._hovers.discard(robot)
