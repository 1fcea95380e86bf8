"""A MAVLink vehicle kept in phase on its mission: the speed of the leg that it flies, and pauses.

ArduCopter: DO_CHANGE_SPEED acts on the running leg within 2 to 4 s, DO_PAUSE_CONTINUE stops a mission and lets it go on
where it stopped (mode AUTO, ``ModeAuto::pause``). PX4 takes the speed. It holds by another mode, HOLD, and goes on in
MISSION from where it is to the waypoint that it flew to (docs.px4.io, flight_modes_mc/mission: "Missions can be paused
by switching out of mission mode"; navigator/mission_base.cpp, ``on_inactivation``): only for long, since it brakes.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Sequence

from rota.errors import LinkError
from rota.files.mission_items import DO_CHANGE_SPEED, DO_JUMP, LOITER_UNLIMITED, WAYPOINT
from rota.links.mavlink_items import WireItem
from rota.links.mavlink_vehicle import MavlinkVehicle
from rota.routes.route import RouteStop

DO_PAUSE_CONTINUE = 193  # MAV_CMD
CATCH_UP_S = 10.0  # in which it is to make up what it is late by
LEAST_SHARE = 0.5  # of a leg's speed: who has to lose more is paused
IN_TIME_S = 0.3  # by which a vehicle may be late until it is told to hurry
EARLY_S = 0.6  # from which on a vehicle is paused; that costs it some tenths more, since it brakes and speeds up
LONGEST_PAUSE_S = 20.0
SLOW_SHARE = 0.3  # of a leg's speed: a copter that is paused while it is slower, at a corner, loses a second more
CORNER_S = 2.0  # that a pause may take effect in
SAME = 0.02  # share by which a speed has to differ to be told


def leg_speeds(items: Sequence[WireItem]) -> dict[int, float]:
    """The speed in m/s at which each waypoint is reached, by its number; of later rounds where they differ."""
    speeds: dict[int, float] = {}
    speed, at, jumped = 0.0, 0, False
    while at < len(items):
        item = items[at]
        at += 1
        if item.command == DO_CHANGE_SPEED:
            speed = item.params[1]
        elif item.command == WAYPOINT and speed > 0:
            speeds[item.seq] = speed
        elif item.command == DO_JUMP and not jumped:
            at, jumped = int(item.params[0]), True
    return speeds


class MissionPace:
    """One vehicle on its mission. begins: its first stop. top_m_s: what its robot may drive.

    late_s: how long after its plan it is to start.

    first: the number of the first item that is flown once it has gathered, and waited; None where there is none.
    """

    def __init__(
        self,
        vehicle: MavlinkVehicle,
        items: Sequence[WireItem],
        begins: RouteStop,
        top_m_s: float,
        late_s: float = 0.0,
    ) -> None:
        self._vehicle, self._top_m_s = vehicle, top_m_s
        self._speeds = leg_speeds(items)
        self._numbers = sorted(self._speeds)
        # item 0 is home on ArduPilot, which alone is told where to begin
        flown = [item.seq for item in items[1:] if item.command in (WAYPOINT, LOITER_UNLIMITED)]
        hold_s = begins.hold_s if begins.speed_m_s is None and len(flown) > 1 else 0.0
        self.first = flown[hold_s > 0] if flown else None
        self.waits_s = hold_s + late_s
        self._first_m_s = next((item.params[1] for item in items if item.command == DO_CHANGE_SPEED), 0.0)
        self._told: tuple[int, float] | None = None
        self._goes_on_to: int | None = None
        self._refused = False

    async def start_in_air(self, time_s: float) -> None:
        """Let a copter begin with its first waypoint: an ArduCopter takes off again wherever it is.

        Where its route begins with a wait it waits here: on its mission it would wait for whole seconds, and only once
        it has come to where it is. time_s: since the plan's start. After ``stops`` it goes on with the waypoint that it
        was on its way to. Either way it is told the speed of its leg, whose own item is left out.
        """
        number, speed_m_s = self._goes_on_to, self._first_m_s
        if number is None:
            number = self.first
            await asyncio.sleep(self.waits_s - time_s)
        else:
            speed_m_s = self._speeds[number]
        raw = self._vehicle.plugin("mission_raw", "MissionRaw")
        if number is not None:
            await self._vehicle.ask("its waypoint", raw.set_current_mission_item_async, number)
        await self._vehicle.ask("starting the mission", raw.start_mission_async)
        self._goes_on_to = None
        if number is not None and speed_m_s > 0:
            self._told = (number, speed_m_s)
            await self._vehicle.command("its speed", DO_CHANGE_SPEED, [1, speed_m_s, -1])

    async def go_on_from_hold(self) -> None:
        """Let a PX4 go on with its mission, and tell it the speed of its leg.

        Before 1.14 it forgets the speed when it leaves its mode (PX4-Autopilot, issue 16031 and pull request 21714).
        """
        number, raw = self._waypoint(), self._vehicle.plugin("mission_raw", "MissionRaw")
        await self._vehicle.ask("going on", raw.start_mission_async)
        self._told = None
        if number is not None:
            await self._vehicle.command("its speed", DO_CHANGE_SPEED, [1, self._speeds[number], -1])
            self._told = (number, self._speeds[number])

    def stops(self) -> None:
        """It is about to be told to stop; where it goes on is kept."""
        if self._vehicle.mode == "running":
            self._goes_on_to = self._waypoint()

    def gives_up(self) -> None:
        """It leaves its mission: whoever starts it again begins anew."""
        self._goes_on_to = None

    async def keep(self, late_s: float, rate: float, least_m_s: float = math.inf) -> None:
        """Let it gain ``late_s``, or lose as much; LinkError where it does not answer.

        least_m_s: how slow it becomes within the next ``CORNER_S`` by itself.
        """
        number = self._waypoint()
        if number is None or self._vehicle.mode != "running":
            return
        if late_s < -EARLY_S and self._vehicle.autopilot == "ardupilot":
            if least_m_s >= SLOW_SHARE * self._speeds[number]:
                await self._pause(min(-late_s, LONGEST_PAUSE_S))
            return
        planned = self._speeds[number]
        share = max(LEAST_SHARE, rate * (1 + late_s / CATCH_UP_S))
        if late_s <= IN_TIME_S and self._vehicle.autopilot == "ardupilot":
            share = 1.0  # its legs take the time that they were planned with: who is early is paused
        speed = min(planned * share, max(self._top_m_s, planned))
        before = planned if self._told is None else self._told[1]
        same_leg = self._told is not None and self._told[0] == number
        if abs(speed - before) <= SAME * planned and (same_leg or abs(speed - planned) <= SAME * planned):
            self._told = (number, before)
            return
        await self._vehicle.command("its speed", DO_CHANGE_SPEED, [1, speed, -1])
        self._told = (number, speed)

    def _waypoint(self) -> int | None:
        """The waypoint that it flies to: its item, or the first one after it."""
        item = self._vehicle.item
        return None if item is None else next((number for number in self._numbers if number >= item), None)

    async def _pause(self, duration_s: float) -> None:
        """Let it stand for so long; whatever ends this, it goes on.

        Just where it reaches a waypoint it refuses (``ModeAuto::pause``): the next try is a second later, and only when
        that is refused, too, it is an error.
        """
        loop = asyncio.get_running_loop()
        begun_s = loop.time()
        try:
            await self._vehicle.command("pausing", DO_PAUSE_CONTINUE, [0])
        except LinkError:
            self._refused = not self._refused
            if self._refused:
                return
            raise
        self._refused = False
        try:
            await asyncio.sleep(begun_s + duration_s - loop.time())
        finally:
            await asyncio.shield(self._vehicle.command("going on", DO_PAUSE_CONTINUE, [1]))
