"""MAVLink vehicles by MAVSDK, on missions of their own; by heartbeats ArduPilot and PX4 are told apart."""

from __future__ import annotations

import asyncio
import functools
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from rota.errors import LinkError
from rota.files.geodesy import Projection
from rota.files.mission_items import Autopilot
from rota.links.expected_lags import ExpectedLags
from rota.links.inbox import Bounds
from rota.links.link import Mode, Order
from rota.links.mavlink_address import addresses
from rota.links.mavlink_failsafes import ARDUPILOT_READ, PX4_READ, read_parameters, told_of
from rota.links.mavlink_guided import Guided
from rota.links.mavlink_held import MISSION, RALLY, as_sent, clear_rally_points, fence_as_sent, read_rally_points
from rota.links.mavlink_items import (
    WireItem,
    fence_differences,
    item_differences,
    item_of,
    rally_differences,
    require_room,
    shapes_of,
    wire_fence,
    wire_items,
    wire_rally,
)
from rota.links.mavlink_pace import CORNER_S, MissionPace
from rota.links.mavlink_vehicle import MavlinkVehicle, into, silence_mavsdk, worded
from rota.links.reporting import RealTimeLink
from rota.model.planner_settings import Settings, setting
from rota.routes.route import Place3, Route

if TYPE_CHECKING:
    from mavsdk import System

DrivenWay = Literal["auto", "mission", "targets"]
VehicleType = Literal["multicopter", "fixed_wing", "rover", "submarine", "any"]

AUTOPILOTS: dict[str, Autopilot] = {"ARDUPILOT": "ardupilot", "PX4": "px4"}
MODES: dict[str, Mode] = {"MISSION": "running", "HOLD": "paused", "RETURN_TO_LAUNCH": "returning", "READY": "ready"}
MISSION_START = 300  # MAV_CMD
ON_GROUND_M = 1.0  # above where it took off
ITEM_HZ = 2.0  # how often a vehicle is asked to say which item it flies to


@dataclass(frozen=True, kw_only=True)
class MavlinkSettings(Settings):
    """Settings of the link ``mavlink``."""

    place: ClassVar[str] = "mavlink"
    address: str = setting(
        "udpin://127.0.0.1:14540", "of the first vehicle, each next one a port higher; or all, with + between"
    )
    vehicle: VehicleType = setting("multicopter", "what every vehicle must be: fixed_wing, rover, submarine, any")
    way: DrivenWay = setting(
        "auto", "mission: on missions of their own; targets: by timed targets, ArduCopters; auto: as the plan is made"
    )
    acceleration_m_s2: float = setting(3.0, "with targets: what a copter is asked for at most", above=0, most=20)
    corner_m: float = setting(1.5, "with targets: how far corners are cut at most", above=0, most=100)
    wait_s: float = setting(10.0, "how long a vehicle may take to be heard", above=0, most=3600)
    answer_s: float = setting(20.0, "how long it may take for a command, or a route", above=0, most=3600)
    ready_s: float = setting(60.0, "how long a vehicle may take until it arms", above=0, most=3600)
    rate_hz: float = setting(5.0, "reports of each vehicle in a second", above=0, most=100)
    system_id: int = setting(
        245, "of this ground station; an ArduPilot heeds the loss of SYSID_MYGCS", least=1, most=255
    )
    start_time: str = setting("", "when the plan started, in ISO 8601; empty: when this link opened")


class MavlinkLink(RealTimeLink):
    """A Link to MAVLink vehicles; see the module."""

    takes_fences = True
    drives_along = False
    keeps_phase = True
    heard_by_one = True
    flies = True
    modes: ClassVar[dict[str, Mode]] = MODES

    def __init__(
        self,
        top_m_s: dict[str, float],
        bounds_m: Bounds,
        projection: Projection,
        settings: MavlinkSettings,
        lags: Mapping[str, ExpectedLags],
    ) -> None:
        super().__init__(tuple(top_m_s), bounds_m, settings.start_time, "mavlink.start_time")
        self._addresses = dict(zip(top_m_s, addresses(settings.address, len(top_m_s)), strict=True))
        self._top_m_s = top_m_s
        self._paces: dict[str, MissionPace] = {}
        self._rallies: dict[str, int] = {}
        self._lags = lags
        self._projection, self._settings = projection, settings
        self._vehicles: dict[str, MavlinkVehicle] = {}
        self._instances: list[Any] = []

    # ------------------------------------------------------------ connecting

    async def open(self) -> None:
        """Raises LinkError for addresses in use, vehicles that are not heard, and those of another type."""
        self._clock.begin()
        await self._meet_all(self._connect)

    async def _connect(self, robot: str) -> None:
        """Connect to the vehicle at a robot's address, and listen to it."""
        from mavsdk import ComponentType, Configuration, Mavsdk

        silence_mavsdk()
        address, wait_s = self._addresses[robot], self._settings.wait_s
        configuration = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
        configuration.system_id = self._settings.system_id
        mavsdk = Mavsdk(configuration)
        self._instances.append(mavsdk)
        if (result := mavsdk.add_any_connection(address)).name != "SUCCESS":
            raise LinkError(f"robot {robot}: {address} cannot be used: {worded(result)}")
        heard: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        mavsdk.first_autopilot_async(wait_s, into(heard))
        (system,) = await heard
        if system is None:
            raise LinkError(f"robot {robot}: no vehicle was heard on {address} within {wait_s:g} s")
        self._vehicles[robot] = vehicle = self._known(robot, system)
        self._listen(vehicle)
        await vehicle.tell_item(ITEM_HZ)

    def _known(self, robot: str, system: System) -> MavlinkVehicle:
        """The vehicle; LinkError where it is not what it has to be."""
        needed, kind = self._settings.vehicle, worded(system.vehicle_type()).replace(" ", "_")
        if needed not in (kind, "any"):
            where = self._addresses[robot]
            raise LinkError(f"robot {robot}: the vehicle on {where} is a {kind}; a {needed} is needed (--set vehicle=)")
        if (autopilot := AUTOPILOTS.get(system.autopilot_type().name)) is None:
            told = worded(system.autopilot_type())
            raise LinkError(f"robot {robot}: its autopilot is {told}; ArduPilot or PX4 is needed")
        return MavlinkVehicle(robot=robot, system=system, autopilot=autopilot, answer_s=self._settings.answer_s)

    def _listen(self, vehicle: MavlinkVehicle) -> None:
        """Have the vehicle's place, battery and mode told as they come."""
        loop = asyncio.get_running_loop()
        telemetry = vehicle.plugin("telemetry", "Telemetry")

        def locate(position: Any, _data: Any) -> None:
            loop.call_soon_threadsafe(self._take, vehicle, position)

        def charge(battery: Any, _data: Any) -> None:
            percent = battery.remaining_percent
            vehicle.battery = percent / 100 if 0 <= percent <= 100 else None

        def change(mode: Any, _data: Any) -> None:
            vehicle.mode = self.modes.get(mode.name)

        vehicle.hear_words()
        telemetry.subscribe_battery(charge)

        def home(place: Any, _data: Any) -> None:
            vehicle.home = (place.latitude_deg, place.longitude_deg, place.absolute_altitude_m)

        telemetry.subscribe_in_air(lambda in_air, _data: setattr(vehicle, "in_air", bool(in_air)))
        telemetry.subscribe_home(home)
        telemetry.subscribe_flight_mode(change)
        telemetry.subscribe_position(locate)
        telemetry.set_rate_position_async(self._settings.rate_hz, lambda *_: None)
        telemetry.set_rate_battery_async(self._settings.rate_hz, lambda *_: None)  # an ArduPilot tells it who has asked

    def _take(self, vehicle: MavlinkVehicle, position: Any) -> None:
        """Take up a place that the vehicle tells, as a report."""
        lat, lon, height_m = position.latitude_deg, position.longitude_deg, position.relative_altitude_m
        if not (abs(lat) <= 90 and abs(lon) <= 180 and math.isfinite(height_m)):
            self._inbox.reject("not a number", f"{vehicle.robot}, at {lat}, {lon}, {height_m}")
            return
        vehicle.heard_s = time.monotonic()
        vehicle.home_height_m = position.absolute_altitude_m - height_m
        x, y = self._projection.to_metres(lon, lat)
        now_s = self._clock.now_s()
        self._inbox.offer(
            now_s=now_s,
            robot=vehicle.robot,
            time_s=now_s,
            position_m=(float(x), float(y), float(height_m)),
            battery=vehicle.battery,
            mode=self._mode(vehicle),
        )

    def _mode(self, vehicle: MavlinkVehicle) -> Mode | None:
        return vehicle.mode

    async def close(self) -> None:
        """Vehicles go on with what they do."""
        self._inbox.close()
        instances, self._instances = self._instances, []
        vehicles, self._vehicles = self._vehicles, {}
        for vehicle in vehicles.values():
            await asyncio.to_thread(vehicle.end_plugins)
        for mavsdk in instances:
            await asyncio.to_thread(mavsdk.destroy)

    # ------------------------------------------------------------ routes

    async def send_route(self, route: Route) -> None:
        """Replace the vehicle's mission, fence and rally points; what the route has none of is taken away."""
        vehicle = self._vehicle(route.robot)
        wired = self._items(route, vehicle)
        shapes, rally = wire_fence(route.fence, self._projection), wire_rally(route, self._projection)
        if vehicle.autopilot == "ardupilot":
            require_room(route.robot, wired, shapes, rally)
        raw = vehicle.plugin("mission_raw", "MissionRaw")
        if wired:
            await vehicle.ask("the mission", raw.upload_mission_async, as_sent(wired, MISSION))
        else:
            await vehicle.ask("clearing the mission", raw.clear_mission_async)
        late_s = self._lags[route.robot].starts_s if route.robot in self._lags else 0.0
        self._paces[route.robot] = MissionPace(vehicle, wired, route.once[0], self._top_m_s[route.robot], late_s)
        geofence = vehicle.plugin("geofence", "Geofence")
        if shapes:
            await vehicle.ask("the fence", geofence.upload_geofence_async, fence_as_sent(shapes))
        else:
            await vehicle.ask("clearing the fence", geofence.clear_geofence_async)
        if rally:
            await vehicle.ask("the rally points", raw.upload_rally_points_async, as_sent(rally, RALLY))
        else:
            await clear_rally_points(vehicle)
        self._rallies[route.robot] = len(rally)

    async def differences(self, route: Route) -> tuple[str, ...]:
        """Download mission, fence and rally points, and compare them item by item with what was sent."""
        vehicle = self._vehicle(route.robot)
        raw = vehicle.plugin("mission_raw", "MissionRaw")
        sent, found = self._items(route, vehicle), list[str]()
        if sent:
            (read,) = await vehicle.ask("reading the mission", raw.download_mission_async)
            found = item_differences(sent, [item_of(item) for item in read], vehicle.autopilot)
        (raw_fence,) = await vehicle.ask("reading the fence", raw.download_geofence_async)
        shapes = wire_fence(route.fence, self._projection)
        told = rally_differences(wire_rally(route, self._projection), await read_rally_points(vehicle))
        return (*found, *fence_differences(shapes, shapes_of(raw_fence)), *told)

    def _items(self, route: Route, vehicle: MavlinkVehicle) -> list[WireItem]:
        """The mission that the vehicle is to hold."""
        return wire_items(route, self._projection, vehicle.autopilot)

    async def clear_route(self, robot: str) -> None:
        """Take mission, fence and rally points away."""
        vehicle = self._vehicle(robot)
        raw = vehicle.plugin("mission_raw", "MissionRaw")
        await vehicle.ask("clearing the mission", raw.clear_mission_async)
        await vehicle.ask("clearing the fence", vehicle.plugin("geofence", "Geofence").clear_geofence_async)
        await clear_rally_points(vehicle)

    # ------------------------------------------------------------ commands

    async def by_itself(self, robot: str) -> tuple[str, ...]:
        """As its parameters tell."""
        vehicle = self._vehicle(robot)
        names = ARDUPILOT_READ if vehicle.autopilot == "ardupilot" else PX4_READ
        has = await read_parameters(vehicle, names)
        held = {"rally_points": self._rallies.get(robot, 0), "own_id": self._settings.system_id}
        return told_of(vehicle, has, by_targets=self.drives_along, **held)

    def is_in_air(self, robot: str) -> bool:
        """As it says, or as its height does where it says nothing."""
        told = self.latest(robot)
        return self._vehicle(robot).in_air or (told is not None and told.position_m[2] > ON_GROUND_M)

    def home_m(self, robot: str) -> Place3 | None:
        """Where it took off, as it says."""
        if (home := self._vehicle(robot).home) is None or not all(map(math.isfinite, home)):
            return None
        x, y = self._projection.to_metres(home[1], home[0])
        return float(x), float(y), 0.0

    async def climb(self, robot: str, height_m: float) -> None:
        """Arm it, as soon as it is ready, and let it take off."""
        await self._guided(robot).climb(height_m)

    async def go(self, robot: str, places_m: Sequence[Place3]) -> None:
        """By one target after the other."""
        if robot in self._paces:
            self._paces[robot].gives_up()
        await self._guided(robot).go(places_m)

    async def land(self, robot: str) -> None:
        """Until it has landed."""
        await self._guided(robot).land()

    def _guided(self, robot: str) -> Guided:
        latest = functools.partial(self.latest, robot)
        return Guided(self._vehicle(robot), self._projection, latest, self._top_m_s[robot], self._settings.ready_s)

    async def start(self, robot: str) -> None:
        """Let it fly its mission; from the air without the take-off, from the ground it is armed before."""
        vehicle = self._vehicle(robot)
        if vehicle.in_air and vehicle.autopilot == "ardupilot" and robot in self._paces:
            await self._paces[robot].start_in_air(self.time_s)
            return
        raw, action = vehicle.plugin("mission_raw", "MissionRaw"), vehicle.plugin("action", "Action")
        await vehicle.ask("arming", action.arm_async)
        await vehicle.ask("starting the mission", raw.start_mission_async)
        if vehicle.autopilot == "ardupilot" and not vehicle.in_air:
            # on the ground its mode AUTO waits for somebody to raise the throttle (Copter::update_auto_armed), or for
            # this (MAV_CMD_MISSION_START in ArduCopter/GCS_Mavlink.cpp sets auto_armed); MAVSDK only sets the mode
            # (https://github.com/mavlink/MAVSDK-Java/issues/232)
            await vehicle.command("starting the mission", MISSION_START)

    async def keep(self, order: Order) -> None:
        """By the speed of the leg that it flies, or a pause; nothing for a vehicle whose mission is not from here."""
        if order.robot not in self._paces:
            return
        lags, least_m_s = self._lags.get(order.robot), math.inf
        if lags is not None:
            plan_s = self.time_s - order.late_s - order.behind_s
            plan_s -= lags.at(plan_s)
            least_m_s = lags.least_m_s(plan_s, plan_s + CORNER_S)
        await self._paces[order.robot].keep(order.late_s, order.rate, least_m_s)

    def most_pace(self, robot: str) -> float:
        """By its firmware, on the whole of its round."""
        return self._lags[robot].pace if robot in self._lags else math.inf

    def expected_s(self, robot: str, plan_s: float) -> float:
        """What it is behind there by its firmware."""
        return self._lags[robot].at(plan_s) if robot in self._lags else 0.0

    async def pause(self, robot: str) -> None:
        """Hold."""
        vehicle = self._vehicle(robot)
        if robot in self._paces:
            self._paces[robot].stops()
        await vehicle.ask("pausing", vehicle.plugin("mission_raw", "MissionRaw").pause_mission_async)

    async def come_home(self, robot: str) -> None:
        """Return to launch."""
        vehicle = self._vehicle(robot)
        if robot in self._paces:
            self._paces[robot].gives_up()
        await vehicle.ask("returning", vehicle.plugin("action", "Action").return_to_launch_async)

    def _vehicle(self, robot: str) -> MavlinkVehicle:
        if robot not in self._vehicles:
            raise LinkError(f"robot {robot}: no vehicle has been heard for it")
        return self._vehicles[robot]
