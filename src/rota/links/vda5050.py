"""VDA 5050 vehicles over MQTT: orders with a released base that grows as the vehicle goes on, and by the plan's clock.

A vehicle drives an order as soon as it has it, so it is paused before and let go by ``start``. Each is spoken to in the
version that it speaks. Needs the extra ``vda5050``, and a broker.
"""

from __future__ import annotations

import asyncio
from contextlib import suppress
from dataclasses import replace

from rota.errors import LinkError
from rota.files.vda5050_orders import NumberedStops, Vehicle, Window
from rota.files.vda5050_versions import SPOKEN, Json, WaitAction, wait_action_given
from rota.links.extras import required
from rota.links.link import Order
from rota.links.reporting import RealTimeLink
from rota.links.vda5050_broker import BY_RELEASE, Broker, Vda5050Settings, end_task
from rota.links.vda5050_flights import VehicleFlights
from rota.links.vda5050_state import (
    LOST,
    Malformed,
    VehicleState,
    connection_of,
    instant_of,
    message_of,
    place_of,
    state_of,
    version_of,
    wait_action_of,
)  # fmt: skip
from rota.links.vda5050_talk import Talk
from rota.links.vda5050_vehicle import ENDED, Vda5050Vehicle
from rota.model.plan import Plan
from rota.routes.route import Place3, Route, route_of

RELEASE_S = 0.1  # between two looks whether stops are to be released
INTRODUCED_S = 1.0  # within which the broker tells what it has kept of a vehicle
KEPT_S = 0.1  # between the first and the last of that
FACTSHEET_S = 3.0  # that a vehicle has for its factsheet
# several states of a moment, told in milliseconds, come one after another
ONE_INSTANT_S, SHORTEST_S = 0.01, 2e-3
MOST_TROUBLES = 3  # vehicles of which it is told at once what is wrong with them

SETTINGS = Vda5050Settings


def link_to(plan: Plan, settings: Vda5050Settings) -> Vda5050Link:
    """A vehicle for each robot of the plan, whose serial number is the robot's name."""
    required("aiomqtt", "vda5050")
    return Vda5050Link(plan, settings)


class Vda5050Link(RealTimeLink):
    """A Link to VDA 5050 vehicles; see the module."""

    takes_fences = False
    drives_along = True
    keeps_phase = True
    relieves = True

    def __init__(self, plan: Plan, settings: Vda5050Settings) -> None:
        fleet = plan.mission.fleet
        self._flights = VehicleFlights(plan, settings.charging)
        self._robots = {trajectory.robot: fleet.robot(trajectory.robot) for trajectory in plan}
        super().__init__(list(self._robots), plan.mission.area.bounds, settings.start_time, "vda5050.start_time")
        self._settings = settings
        self._vehicles: dict[str, Vda5050Vehicle] = {}
        for trajectory in plan:
            name = trajectory.robot
            self._vehicles[name] = Vda5050Vehicle(
                identity=Vehicle(
                    serial_number=name, manufacturer=settings.manufacturer, map_id=settings.map_id, wait=None
                ),
                planned=self._stops(route_of(trajectory, fleet.altitude_m)),
                top_speed_m_s=self._robots[name].speed_m_s,
                window=Window(released=settings.released, announced=settings.announced),
            )
        self._broker = Broker(settings)
        self._talk = Talk(self._broker, settings)
        self._tasks: list[asyncio.Task[None]] = []

    def _stops(self, route: Route) -> NumberedStops:
        return NumberedStops(route, self._robots[route.robot].turn_rate_rad_s)

    @property
    def trouble(self) -> str:
        """That the broker is lost, while it is; else which vehicles are, or cannot go on, and what they report."""
        if self._talk.lost:
            return self._talk.lost
        told = [text for vehicle in self._vehicles.values() if (text := vehicle.trouble)]
        more = len(told) - MOST_TROUBLES
        return "; ".join(told[:MOST_TROUBLES]) + (f"; and {more} more" if more > 0 else "")

    # ------------------------------------------------------------ the broker

    async def open(self) -> None:
        """Raises LinkError for a broker that cannot be reached or refuses, and for vehicles that are not as needed."""
        self._clock.begin()
        await self._broker.open()
        interface, manufacturer = self._settings.interface, self._settings.manufacturer
        for name in ("state", "factsheet", "visualization"):
            await self._broker.subscribe(f"{interface}/+/{manufacturer}/+/{name}", qos=0)
        await self._broker.subscribe(f"{interface}/+/+/+/connection", qos=1)
        self._tasks = [asyncio.create_task(self._read()), asyncio.create_task(self._release())]
        await self._meet_all(self._meet)

    async def _read(self) -> None:
        """Use all that arrives, and reach the broker again for as long as it takes where it is lost."""
        while True:
            try:
                async for topic, payload in self._broker.messages():
                    await self._take(topic, payload)
            except LinkError as error:
                self._talk.lost = str(error)
                for vehicle in self._vehicles.values():
                    vehicle.was_away = True
                    async with vehicle.news:
                        vehicle.news.notify_all()
                await self._broker.reopen()
                self._talk.lost = ""

    async def _release(self) -> None:
        """Let orders go on when it is time to."""
        while True:
            await asyncio.sleep(RELEASE_S)
            for vehicle in self._vehicles.values():
                with suppress(LinkError):  # a broker that is lost is told by who reads
                    await self._lead_on(vehicle)

    async def _lead_on(self, vehicle: Vda5050Vehicle) -> None:
        if (update := vehicle.update_due()) is not None:
            await self._talk.publish(vehicle, "order", update)
        if (trigger := vehicle.trigger_due()) is not None:
            await self._talk.publish(vehicle, "instantActions", trigger)

    async def _take(self, topic: str, payload: object) -> None:
        """Use a message, or count it; let an order go on where it is time to."""
        *_, level, manufacturer, serial, name = topic.split("/")
        vehicle = self._vehicles.get(serial) if manufacturer == self._settings.manufacturer else None
        if vehicle is None:
            if name == "connection":
                self._talk.hear_of_other(f"{manufacturer}/{serial}")
            else:
                self._inbox.reject("unknown robot", topic)
            return
        try:
            read = message_of(payload)
            if read.get("serialNumber") != serial:
                raise Malformed("another serial number than its topic's")
            await self._use(vehicle, level, name, read)
        except Malformed as error:
            self._inbox.reject("malformed", f"{name} of {serial:.25}: {error}")

    async def _use(self, vehicle: Vda5050Vehicle, level: str, name: str, read: Json) -> None:
        """Take up what a vehicle tells of its connection, its state or itself."""
        version = version_of(read)
        protocol = vehicle.hear_version(level, version, by_state=name == "state")
        connection = connection_of(read) if name == "connection" else ""
        if connection in ("OFFLINE", *LOST) and vehicle.level not in ("", level):
            return  # what the broker has kept of the version that it spoke before
        if name == "state" and vehicle.connection in LOST:
            connection = "ONLINE"  # it is back, and need not say so where not it but its broker was lost
        if connection:
            await self._connected(vehicle, connection)
        if name == "connection":
            pass
        elif protocol is None:
            raise Malformed(f"version {version:.25} is not spoken; {SPOKEN} are")
        elif name == "factsheet":
            vehicle.has_factsheet, vehicle.knows_to_wait = True, wait_action_of(read)
        elif name == "visualization":
            self._see(vehicle, *place_of(read, protocol), unix_s=instant_of(read))
        elif not self._report(vehicle, state_of(read)):
            return
        async with vehicle.news:
            vehicle.news.notify_all()
        await self._lead_on(vehicle)

    async def _connected(self, vehicle: Vda5050Vehicle, connection: str) -> None:
        vehicle.connection = connection
        if connection != "ONLINE":
            vehicle.was_away = True
        elif vehicle.was_away:
            # it may stand at the end of what it has, and have nothing new to tell
            vehicle.was_away = False
            await self._talk.publish(vehicle, "instantActions", vehicle.instant_action("stateRequest")[1])

    def _report(self, vehicle: Vda5050Vehicle, state: VehicleState) -> bool:
        """Take a state, unless it is from the future or older than the last one; whether it was taken."""
        before = vehicle.state
        vehicle.state = state  # its mode is told by it
        if state.place_m is not None and not self._offer(vehicle, state.place_m, state.unix_s):
            vehicle.state = before
            return False
        vehicle.take(state)
        return True

    def _see(self, vehicle: Vda5050Vehicle, place_m: tuple[float, float] | None, map_id: str, unix_s: float) -> None:
        """Report where a vehicle says that it is between two states."""
        last = self.latest(vehicle.robot)
        is_newer = last is not None and self._clock.of_unix_s(unix_s) >= last.time_s
        if is_newer and place_m is not None and map_id == self._settings.map_id:
            self._offer(vehicle, place_m, unix_s)

    def _offer(self, vehicle: Vda5050Vehicle, place_m: tuple[float, float], unix_s: float) -> bool:
        """Offer a vehicle's place as a report; reports of one instant count once."""
        position_m: Place3 = (*place_m, vehicle.planned.once[0].place_m[2])
        time_s, last = self._clock.of_unix_s(unix_s), self.latest(vehicle.robot)
        if last is not None and -ONE_INSTANT_S < time_s - last.time_s < SHORTEST_S:
            time_s = last.time_s + SHORTEST_S
        return self._inbox.offer(
            now_s=self._clock.now_s(),
            robot=vehicle.robot,
            time_s=time_s,
            position_m=position_m,
            battery=None if vehicle.state is None else vehicle.state.battery,
            mode=vehicle.mode(),
        )

    async def close(self) -> None:
        """Vehicles drive to the end of what has been released to them, and wait there."""
        self._inbox.close()
        for task in self._tasks:
            await end_task(task)
        await self._broker.close()

    # ------------------------------------------------------------ orders

    async def _meet(self, name: str) -> None:
        """Hear from a vehicle, and see whether it is one that can drive the plan."""
        vehicle, limit_s = self._vehicles[name], self._settings.wait_s
        with suppress(TimeoutError):
            async with asyncio.timeout(min(INTRODUCED_S, limit_s)), vehicle.news:
                await vehicle.news.wait_for(lambda: vehicle.connection == "ONLINE")
        await asyncio.sleep(KEPT_S)
        await self._talk.introduce(vehicle, limit_s)
        state = vehicle.state
        assert state is not None
        if state.place_m is not None and state.map_id != self._settings.map_id:
            needed = self._settings.map_id
            raise LinkError(f"robot {name}: it is on the map {state.map_id!r}; {needed!r} is needed (--set map_id=)")
        if not state.is_automatic:
            raise LinkError(f"robot {name}: it is not in the operating mode AUTOMATIC and takes no orders")

    async def send_route(self, route: Route) -> None:
        """Pause the vehicle and give it the order; of robots that charge, of its first flight, on a charger none."""
        vehicle, stops = self._vehicle(route.robot), self._stops(route)
        vehicle.begun_s, vehicle.left_s = None, None
        # where it turns faster than planned, it waits for what is left
        if any(stop.hold_s > 0 for stop in (*stops.once, *stops.every_round)):
            vehicle.identity = replace(vehicle.identity, wait=await self._way_to_wait(vehicle))
        await self._talk.act(vehicle, "startPause", lambda state: state.paused)
        if route.robot not in self._flights:
            await self._order(vehicle, stops)
        elif (first := self._flights.stops(route.robot, 0.0)) is not None:
            vehicle.planned = first
            await self._order(vehicle, first)

    async def _way_to_wait(self, vehicle: Vda5050Vehicle) -> WaitAction | None:
        """The action by which a vehicle is to wait; None: by what is released."""
        given = self._settings.wait_action
        if given:
            return None if given == BY_RELEASE else wait_action_given(given, "vda5050.wait_action")
        if not vehicle.has_factsheet:
            action_id, message = vehicle.instant_action("factsheetRequest")

            def is_over(state: VehicleState) -> bool:
                return vehicle.has_factsheet or state.actions.get(action_id) in ENDED

            with suppress(LinkError):  # it need not have one
                await self._talk.until(vehicle, "factsheet", "instantActions", message, is_over, FACTSHEET_S)
        return vehicle.knows_to_wait

    async def _order(self, vehicle: Vda5050Vehicle, stops: NumberedStops, from_s: float = 0.0) -> None:
        order = vehicle.order(stops, from_s)
        await self._talk.until(vehicle, "the order", "order", order, lambda _: vehicle.has_order(order))

    async def differences(self, route: Route) -> tuple[str, ...]:
        """Compare the nodes, edges and waits that the vehicle says are ahead of it with those of the order."""
        return () if self._flights.is_docked(route.robot) else self._vehicle(route.robot).differences()

    async def clear_route(self, robot: str) -> None:
        """Cancel the vehicle's order, and end the pause."""
        vehicle = self._vehicle(robot)
        await self._cancel(vehicle)
        await self._talk.act(vehicle, "stopPause", lambda state: not state.paused)

    async def _cancel(self, vehicle: Vda5050Vehicle) -> None:
        vehicle.forget()
        await self._talk.act(vehicle, "cancelOrder", lambda state: not state.nodes and not state.edges)

    async def start(self, robot: str) -> None:
        """End the pause. Robots keep to a clock that starts with the first of them."""
        begun_s = (vehicle.begun_s for vehicle in self._vehicles.values() if vehicle.begun_s is not None)
        vehicle = self._vehicle(robot)
        vehicle.begin(next(begun_s, None))
        vehicle.held = False
        await self._talk.act(vehicle, "stopPause", lambda state: not state.paused)
        if self._flights.is_docked(robot) and self._settings.charging:
            await self._talk.publish(vehicle, "instantActions", vehicle.instant_action("startCharging")[1])

    async def keep(self, order: Order) -> None:
        """Orders keep to the clock of all by what each stop is told when it is released; where all hold, it is paused.

        On its charger a vehicle has no order until it is to leave: then that of its next flight.
        """
        vehicle = self._vehicle(order.robot)
        vehicle.keep(order.behind_s)
        if order.dock is not None:
            if order.dock.leaves and vehicle.left_s != order.dock.plan_s:
                await self._leave(vehicle, order.dock.plan_s)
        elif vehicle.held != (order.rate == 0):
            held = vehicle.held = order.rate == 0
            await self._talk.act(vehicle, "startPause" if held else "stopPause", lambda state: state.paused == held)

    async def _leave(self, vehicle: Vda5050Vehicle, plan_s: float) -> None:
        """Give a vehicle on its charger the order of a flight. One that charges takes none: it stops that first."""
        if vehicle.state is not None and vehicle.state.charging and self._settings.charging:
            await self._talk.act(vehicle, "stopCharging", lambda state: not state.charging)
        if (stops := self._flights.stops(vehicle.robot, plan_s)) is not None:
            await self._order(vehicle, stops, plan_s)
            vehicle.left_s = plan_s

    def room_s(self, robot: str) -> float:
        """What the waits and the slower legs of a round leave, beyond what its vehicle takes longer."""
        vehicle = self._vehicles.get(robot)
        return 0.0 if vehicle is None else vehicle.room_s

    async def pause(self, robot: str) -> None:
        """Pause."""
        await self._talk.act(self._vehicle(robot), "startPause", lambda state: state.paused)

    async def come_home(self, robot: str) -> None:
        """Cancel the order and send it home over planned legs: on to the end of the round, the approach backwards."""
        vehicle = self._vehicle(robot)
        await self._cancel(vehicle)
        way = vehicle.way_home()
        if way is None:
            raise LinkError(f"robot {robot}: it does not know where it is, and cannot be led home")
        vehicle.returning = True
        await self._order(vehicle, self._stops(way))
        await self._talk.act(vehicle, "stopPause", lambda state: not state.paused)

    def _vehicle(self, robot: str) -> Vda5050Vehicle:
        vehicle = self._vehicles.get(robot)
        if vehicle is None or vehicle.state is None:
            raise LinkError(f"robot {robot}: no vehicle has been heard for it")
        return vehicle
