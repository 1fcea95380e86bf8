"""A MAVLink vehicle on its own beside its mission: up, from place to place, and down again.

Places are told by MAV_CMD_DO_REPOSITION: ArduCopter flies there in its mode GUIDED, PX4 in HOLD.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress

from rota.errors import LinkError
from rota.files.geodesy import Projection
from rota.files.mission_items import DO_CHANGE_SPEED, TAKEOFF
from rota.links.link import Report
from rota.links.mavlink_vehicle import MavlinkVehicle
from rota.routes.route import Place3

GUIDED = 4  # ArduCopter's number for its mode, ArduCopter/mode.h
DO_SET_MODE, CUSTOM_MODE = 176, 1  # MAV_CMD; the flag that says that the mode is a number of the autopilot's own
NEAR_M, LEVEL_M = 1.0, 0.7  # of a place, at which the vehicle is there
SLOWEST_M_S, RESERVE_S = 0.5, 30.0  # a vehicle that takes longer than by these does not get there
LOOK_S = 0.1
READY_AGAIN_S = 2.0  # until a vehicle that does not arm yet is asked again
LANDS_M_S = 0.3  # no slower; ArduCopter's LAND_SPEED is 0.5 m/s for the last 10 m


class Guided:
    """One vehicle that is told where to fly. latest: its last report. ready_s: how long it may take until it arms."""

    def __init__(
        self,
        vehicle: MavlinkVehicle,
        projection: Projection,
        latest: Callable[[], Report | None],
        top_m_s: float,
        ready_s: float,
    ) -> None:
        self._vehicle, self._projection, self._latest = vehicle, projection, latest
        self._top_m_s, self._ready_s = top_m_s, ready_s

    async def climb(self, height_m: float) -> None:
        """Take off to a height; LinkError where it does not arm, or does not get there."""
        vehicle = self._vehicle
        if vehicle.in_air:
            x, y, _ = self._place_m()
            await self.go([(x, y, height_m)])
            return
        action = vehicle.plugin("action", "Action")
        await self._ready()
        if vehicle.autopilot == "ardupilot":
            await vehicle.command("taking off", TAKEOFF, [0, 0, 0, 0, 0, 0, height_m])
        else:
            await vehicle.ask("its height", action.set_takeoff_altitude_async, height_m)
            await vehicle.ask("taking off", action.takeoff_async)
        x, y, _ = self._place_m()
        await self._there((x, y, height_m), "climbing", near_m=math.inf)

    async def _ready(self) -> None:
        """Arm; a vehicle that has just been switched on looks for its place first."""
        vehicle, until_s = self._vehicle, time.monotonic() + self._ready_s
        while True:
            try:
                if vehicle.autopilot == "ardupilot":
                    await vehicle.command("its mode guided", DO_SET_MODE, [CUSTOM_MODE, GUIDED])
                await vehicle.ask("arming", vehicle.plugin("action", "Action").arm_async)
            except LinkError:
                if time.monotonic() > until_s:
                    raise
                await asyncio.sleep(READY_AGAIN_S)
            else:
                return

    async def go(self, places_m: Sequence[Place3]) -> None:
        """Fly straight to each place in turn; LinkError where it does not get there in time."""
        vehicle = self._vehicle
        action = vehicle.plugin("action", "Action")
        for place_m in places_m:
            lon, lat = self._projection.to_degrees([place_m[0]], [place_m[1]])
            to = (float(lat[0]), float(lon[0]), place_m[2] + vehicle.home_height_m)
            await vehicle.ask("flying to a place", action.goto_location_async, *to, math.nan)
            with suppress(LinkError):  # who does not know it flies at a speed of its own
                await vehicle.command("its speed", DO_CHANGE_SPEED, [1, self._top_m_s, -1])
            await self._there(place_m, "flying to a place")

    async def land(self) -> None:
        """Land and stop the motors; LinkError where it does not."""
        vehicle = self._vehicle
        height_m = self._place_m()[2]
        await vehicle.ask("landing", vehicle.plugin("action", "Action").land_async)
        until_s = time.monotonic() + max(height_m, 0.0) / LANDS_M_S + RESERVE_S
        while vehicle.in_air:
            if time.monotonic() > until_s:
                raise LinkError(f"robot {vehicle.robot}: landing: it is still in the air{vehicle.why()}")
            await asyncio.sleep(LOOK_S)

    async def _there(self, place_m: Place3, what: str, near_m: float = NEAR_M) -> None:
        """Wait until it is at a place."""
        until_s = time.monotonic() + math.dist(self._place_m(), place_m) / SLOWEST_M_S + RESERVE_S
        while True:
            at_m = self._place_m()
            if math.dist(at_m[:2], place_m[:2]) <= near_m and abs(at_m[2] - place_m[2]) <= LEVEL_M:
                return
            if time.monotonic() > until_s:
                raise LinkError(
                    f"robot {self._vehicle.robot}: {what}: it is {math.dist(at_m, place_m):.1f} m off and does not get"
                    f" on{self._vehicle.why()}"
                )
            await asyncio.sleep(LOOK_S)

    def _place_m(self) -> Place3:
        report = self._latest()
        if report is None:
            raise LinkError(f"robot {self._vehicle.robot}: it has not said where it is")
        return report.position_m
