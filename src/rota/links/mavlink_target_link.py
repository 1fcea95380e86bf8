"""ArduCopters that are driven by timed targets; they hold a fence, and no mission."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from rota.errors import LinkError
from rota.files.geodesy import Projection
from rota.links.air_lead import GAINS, AirLead, Gains, drag_of, gains_of
from rota.links.link import Dock, Mode, Order
from rota.links.mavlink_failsafes import read_parameters
from rota.links.mavlink_guided import CUSTOM_MODE, DO_SET_MODE, GUIDED
from rota.links.mavlink_items import WireItem
from rota.links.mavlink_link import MODES, MavlinkLink, MavlinkSettings
from rota.links.mavlink_targets import LEAN_DEG, MOST_PACE, Target, TargetStream, most_pace, top_airspeed_m_s
from rota.links.mavlink_vehicle import MavlinkVehicle
from rota.links.rounded_track import RoundedTrack
from rota.model.plan import Plan
from rota.routes.flights import on_charger, recharges
from rota.routes.route import Place3, Route
from rota.vehicles.presets import ARDUCOPTER

OWN_SPOT_M = 5.0  # from its charger, within which a copter has a place of its own there


class MavlinkTargetLink(MavlinkLink):
    """A Link to ArduCopters in their mode GUIDED; see ``mavlink_targets``."""

    drives_along = True
    relieves = True
    modes: ClassVar[dict[str, Mode]] = {**MODES, "OFFBOARD": "running"}

    def __init__(self, plan: Plan, projection: Projection, settings: MavlinkSettings) -> None:
        fleet = plan.mission.fleet
        tops_m_s = {way.robot: fleet.robot(way.robot).speed_m_s for way in plan}
        super().__init__(tops_m_s, plan.mission.area.bounds, projection, settings, {})
        self._altitude_m = fleet.altitude_m
        self.lead_s = ARDUCOPTER.climbing_s(fleet.altitude_m) if recharges(plan) else 0.0
        self._spots_m: dict[str, tuple[float, float]] = {}
        self._docked = {way.robot for way in plan if on_charger(way, np.zeros(1))[0]}
        asked, corner_m = settings.acceleration_m_s2, settings.corner_m
        # rounded more than need be where there is room, so that all can be driven faster than planned for a while
        self._tracks = {way.robot: RoundedTrack(way, asked / MOST_PACE**2, corner_m) for way in plan}
        self._most = {name: most_pace(track, fleet.robot(name), asked) for name, track in self._tracks.items()}
        tops = {name: top_airspeed_m_s(fleet.robot(name)) for name in tops_m_s}
        self._drags = {name: drag_of(top, LEAN_DEG) for name, top in tops.items()}
        self._gains: dict[str, Gains] = {}
        self._stream = TargetStream()
        self._paused_s: dict[str, float] = {}

    def most_pace(self, robot: str) -> float:
        """By the acceleration at its corners, and by the air."""
        return self._most[robot]

    async def _connect(self, robot: str) -> None:
        await super()._connect(robot)
        if self._vehicle(robot).autopilot != "ardupilot":
            raise LinkError(f"robot {robot}: its autopilot is PX4; way=targets is for ArduCopters (--set way=mission)")
        self._gains[robot] = gains_of(await read_parameters(self._vehicle(robot), GAINS))

    def _items(self, route: Route, vehicle: MavlinkVehicle) -> list[WireItem]:
        return []

    async def start(self, robot: str) -> None:
        """From the air: follow targets from the route's beginning, or after a pause from where it is.

        One that begins on its charger, and is on the ground, stays there until ``keep`` has it leave.
        """
        vehicle = self._vehicle(robot)
        if (spot_m := self.home_m(robot)) is not None:
            self._spots_m.setdefault(robot, spot_m[:2])  # its home is another one whenever it arms
        if robot in self._docked and not vehicle.in_air:
            return
        if not vehicle.in_air:
            raise LinkError(f"robot {robot}: it is on the ground; targets are for copters that have gathered")
        await vehicle.command("its mode guided", DO_SET_MODE, [CUSTOM_MODE, GUIDED])
        paused_s = self._paused_s.pop(robot, None)
        self._stream.give(robot, await self._target(vehicle, paused_s or 0.0, lost=paused_s is not None))

    async def _target(self, vehicle: MavlinkVehicle, phase_s: float, *, lost: bool) -> Target:
        """What tells a vehicle its timed targets from a moment of its plan on, or from the nearest place to it."""
        telemetry = vehicle.plugin("telemetry", "Telemetry")
        (origin,) = await vehicle.ask("its origin", telemetry.get_gps_global_origin_async)
        return Target(
            vehicle=vehicle,
            track=self._tracks[vehicle.robot],
            projection=self._projection,
            origin=(origin.latitude_deg, origin.longitude_deg, origin.altitude_m),
            height_m=self._altitude_m,
            ramp_m_s2=self._settings.acceleration_m_s2 / 2,
            most=self._most[vehicle.robot],
            lead=AirLead(self._gains[vehicle.robot], self._drags[vehicle.robot]),
            latest=lambda: self.latest(vehicle.robot),
            phase_s=phase_s,
            lost=lost,
        )

    async def keep(self, order: Order) -> None:
        """By the pace of its targets; on its charger it lands, and takes off when it is to leave."""
        target = self._stream.target(order.robot)
        if order.dock is not None:
            await self._dock(self._vehicle(order.robot), order.dock, order)
        elif target is not None:
            target.keep(order.late_s, order.rate)

    async def _dock(self, vehicle: MavlinkVehicle, dock: Dock, order: Order) -> None:
        """Land on the charger and stay there, or take off from it, hover until it is time, and fly on by plan.

        It lands where it stood at first, if that is at this charger: others stand beside it.
        """
        robot, flown = vehicle.robot, self._stream.target(vehicle.robot)
        if not dock.leaves and vehicle.in_air:
            x, y = self._tracks[robot].at(dock.plan_s).place_m[:2].tolist()
            own_m = self._spots_m.get(robot, (x, y))
            at_m = own_m if math.dist(own_m, (x, y)) <= OWN_SPOT_M else (x, y)
            await self.go(robot, [(*at_m, self._altitude_m)])
            await self.land(robot)
        elif dock.leaves and flown is None:
            await self.climb(robot, self._altitude_m)
            made = await self._target(vehicle, dock.plan_s, lost=False)
            made.wanted = 0.0
            self._stream.give(robot, made)
        elif dock.leaves and flown is not None:
            flown.keep(order.late_s, order.rate)

    async def pause(self, robot: str) -> None:
        """No more targets, and hold."""
        target = self._stream.take(robot)
        if target is not None:
            self._paused_s[robot] = target.phase_s
        await super().pause(robot)

    async def go(self, robot: str, places_m: Sequence[Place3]) -> None:
        """Targets of its route end."""
        self._stream.take(robot)
        self._paused_s.pop(robot, None)
        await super().go(robot, places_m)

    async def come_home(self, robot: str) -> None:
        """Targets of its route end."""
        self._stream.take(robot)
        self._paused_s.pop(robot, None)
        await super().come_home(robot)

    async def close(self) -> None:
        """Vehicles get no more targets, and stop where they are."""
        self._stream.end()
        await super().close()
