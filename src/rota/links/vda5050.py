"""VDA 5050 vehicles over MQTT: orders with a released base that grows as the vehicle goes on.

A vehicle drives an order as soon as it has it, so it is paused before and let go by ``start``. Needs the extra
``vda5050``, and a broker.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from rota.errors import LinkError
from rota.files.vda5050_orders import Vehicle, Window
from rota.links.extras import required
from rota.links.inbox import Bounds
from rota.links.reporting import RealTimeLink
from rota.links.vda5050_broker import Broker, Vda5050Settings
from rota.links.vda5050_state import MOST_TEXT, Malformed, VehicleState, connection_of, state_of
from rota.links.vda5050_vehicle import ASK_AGAIN_S, ENDED, Vda5050Vehicle
from rota.plan import Plan
from rota.route import Route, route_of

MOST_OTHERS = 10  # vehicles at the broker that are not the plan's, for error messages
END_AGAIN_S = 0.1  # until a task that goes on is cancelled again

SETTINGS = Vda5050Settings


async def ended(task: asyncio.Task[None]) -> None:
    """Cancel a task until it has ended; what it raised is raised here.

    Once may not do. aiomqtt waits with ``asyncio.wait_for``, and before Python 3.12 that swallows a cancellation that
    comes just when its wait ends.
    """
    while not task.done():
        task.cancel()
        await asyncio.wait([task], timeout=END_AGAIN_S)
    with suppress(asyncio.CancelledError):
        await task


def link_to(plan: Plan, settings: Vda5050Settings) -> Vda5050Link:
    """A vehicle for each robot of the plan, whose serial number is the robot's name."""
    required("aiomqtt", "vda5050")
    routes = [route_of(trajectory, plan.mission.fleet.altitude_m) for trajectory in plan]
    return Vda5050Link(routes, plan.mission.area.bounds, settings)


class Vda5050Link(RealTimeLink):
    """A Link to VDA 5050 vehicles; see the module."""

    takes_fences = False
    drives_along = True

    def __init__(self, routes: list[Route], bounds_m: Bounds, settings: Vda5050Settings) -> None:
        names = [route.robot for route in routes]
        super().__init__(names, bounds_m, settings.start_time, "vda5050.start_time")
        window = Window(released=settings.released, announced=settings.announced)
        self._settings = settings
        self._vehicles: dict[str, Vda5050Vehicle] = {}
        for route in routes:
            identity = Vehicle(serial_number=route.robot, manufacturer=settings.manufacturer, map_id=settings.map_id)
            self._vehicles[route.robot] = Vda5050Vehicle(identity=identity, planned=route, window=window)
        self._others: set[str] = set()
        self._broker = Broker(settings)
        self._reader: asyncio.Task[None] | None = None
        self._lost = ""

    @property
    def trouble(self) -> str:
        """That the broker is lost, while it is."""
        return self._lost

    # ------------------------------------------------------------ the broker

    async def open(self) -> None:
        """Raises LinkError for a broker that cannot be reached or refuses, and for vehicles that are not as needed."""
        self._clock.begin()
        await self._broker.open()
        await self._broker.subscribe(self._topic("+", "state"), qos=0)
        await self._broker.subscribe(f"{self._settings.interface}/v2/+/+/connection", qos=1)
        self._reader = asyncio.create_task(self._read())
        await self._meet_all(self._meet)

    def _topic(self, serial: str, name: str) -> str:
        return f"{self._settings.interface}/v2/{self._settings.manufacturer}/{serial}/{name}"

    async def _publish(self, vehicle: Vda5050Vehicle, name: str, message: dict[str, Any]) -> None:
        await self._broker.publish(self._topic(vehicle.identity.serial_number, name), json.dumps(message))

    async def _read(self) -> None:
        """Use all that arrives, and reach the broker again for as long as it takes where it is lost."""
        while True:
            try:
                async for topic, payload in self._broker.messages():
                    await self._take(topic, payload)
            except LinkError as error:
                self._lost = str(error)
                for vehicle in self._vehicles.values():
                    vehicle.was_away = True
                    async with vehicle.news:
                        vehicle.news.notify_all()
                await self._broker.reopen()
                self._lost = ""

    async def _take(self, topic: str, payload: object) -> None:
        """Use a message, or count it; let an order go on where it is time to."""
        *_, manufacturer, serial, name = topic.split("/")
        vehicle = self._vehicles.get(serial) if manufacturer == self._settings.manufacturer else None
        if vehicle is None:
            if name == "connection":
                self._hear_of_other(f"{manufacturer}/{serial}")
            else:
                self._inbox.reject("unknown robot", topic)
            return
        try:
            if name == "connection":
                vehicle.connection = connection_of(payload)
                if vehicle.connection != "ONLINE":
                    vehicle.was_away = True
                elif vehicle.was_away:
                    # it may stand at the end of what it has, and have nothing new to tell
                    vehicle.was_away = False
                    await self._publish(vehicle, "instantActions", vehicle.instant_action("stateRequest")[1])
                return
            state = state_of(payload, serial)
        except Malformed as error:
            self._inbox.reject("malformed", f"{name} of {serial:.25}: {error}")
            return
        if not self._report(vehicle, state):
            return
        async with vehicle.news:
            vehicle.news.notify_all()
        if (update := vehicle.update_due()) is not None:
            await self._publish(vehicle, "order", update)

    def _hear_of_other(self, name: str) -> None:
        if len(self._others) < MOST_OTHERS:
            self._others.add(name[:MOST_TEXT])

    def _report(self, vehicle: Vda5050Vehicle, state: VehicleState) -> bool:
        """Take a state, unless it is from the future or older than the last one; whether it was taken."""
        time_s, before = self._clock.of_unix_s(state.unix_s), vehicle.state
        if state.place_m is not None:
            vehicle.state = state
            taken = self._inbox.offer(
                now_s=self._clock.now_s(),
                robot=vehicle.robot,
                time_s=time_s,
                position_m=(*state.place_m, vehicle.planned.start_m[2]),
                battery=state.battery,
                mode=vehicle.mode(),
            )
            vehicle.state = state if taken else before
            return taken
        vehicle.state = state
        return True

    async def close(self) -> None:
        """Vehicles drive to the end of what has been released to them, and wait there."""
        self._inbox.close()
        if self._reader is not None:
            await ended(self._reader)
        await self._broker.close()

    # ------------------------------------------------------------ orders

    async def _meet(self, name: str) -> None:
        """Hear from a vehicle, and see whether it is one that can drive the plan."""
        vehicle = self._vehicles[name]
        action_id, message = vehicle.instant_action("stateRequest")
        asked, limit_s = ("instantActions", message), self._settings.wait_s
        await self._until(vehicle, "being heard", asked, lambda _: True, action_id, limit_s)
        state, robot = vehicle.state, vehicle.robot
        assert state is not None
        if state.place_m is not None and state.map_id != self._settings.map_id:
            needed = self._settings.map_id
            raise LinkError(f"robot {robot}: it is on the map {state.map_id!r}; {needed!r} is needed (--set map_id=)")
        if not state.is_automatic:
            raise LinkError(f"robot {robot}: it is not in the operating mode AUTOMATIC and takes no orders")

    async def send_route(self, route: Route) -> None:
        """Pause the vehicle and give it the order."""
        vehicle = self._vehicle(route.robot)
        await self._act(vehicle, "startPause", lambda state: state.paused)
        await self._order(vehicle, route)

    async def _order(self, vehicle: Vda5050Vehicle, route: Route) -> None:
        order = vehicle.order(route)
        await self._until(vehicle, "the order", ("order", order), lambda _: vehicle.has_order(order), order["orderId"])

    async def differences(self, route: Route) -> tuple[str, ...]:
        """Compare the nodes, edges and waits that the vehicle says are ahead of it with those of the order."""
        return self._vehicle(route.robot).differences()

    async def clear_route(self, robot: str) -> None:
        """Cancel the vehicle's order, and end the pause."""
        vehicle = self._vehicle(robot)
        await self._cancel(vehicle)
        await self._act(vehicle, "stopPause", lambda state: not state.paused)

    async def _cancel(self, vehicle: Vda5050Vehicle) -> None:
        vehicle.forget()
        await self._act(vehicle, "cancelOrder", lambda state: not state.nodes and not state.edges)

    async def start(self, robot: str) -> None:
        """End the pause."""
        await self._act(self._vehicle(robot), "stopPause", lambda state: not state.paused)

    async def pause(self, robot: str) -> None:
        """Pause."""
        await self._act(self._vehicle(robot), "startPause", lambda state: state.paused)

    async def come_home(self, robot: str) -> None:
        """Cancel the order and send it home over planned legs: on to the end of the round, the approach backwards."""
        vehicle = self._vehicle(robot)
        await self._cancel(vehicle)
        way = vehicle.way_home()
        if way is None:
            raise LinkError(f"robot {robot}: it does not know where it is, and cannot be led home")
        vehicle.returning = True
        await self._order(vehicle, way)
        await self._act(vehicle, "stopPause", lambda state: not state.paused)

    def _vehicle(self, robot: str) -> Vda5050Vehicle:
        vehicle = self._vehicles.get(robot)
        if vehicle is None or vehicle.state is None:
            raise LinkError(f"robot {robot}: no vehicle has been heard for it")
        return vehicle

    async def _act(self, vehicle: Vda5050Vehicle, kind: str, is_done: Callable[[VehicleState], bool]) -> None:
        """Send an instant action, and wait until the vehicle's state is what it leads to."""
        action_id, message = vehicle.instant_action(kind)

        def done(state: VehicleState) -> bool:
            # a vehicle that had no order to cancel fails to, and is as it should be
            return is_done(state) and (kind != "cancelOrder" or state.actions.get(action_id, "FINISHED") in ENDED)

        await self._until(vehicle, kind, ("instantActions", message), done, action_id)

    async def _until(
        self,
        vehicle: Vda5050Vehicle,
        what: str,
        message: tuple[str, dict[str, Any]],
        is_done: Callable[[VehicleState], bool],
        name: str,
        limit_s: float | None = None,
    ) -> None:
        """Send a message, again now and then, until a state that comes after it is as wanted; LinkError if none does.

        name: the id of the order or action, which the vehicle names when it refuses.
        """
        before = vehicle.state
        limit_s = self._settings.answer_s if limit_s is None else limit_s

        def ended() -> bool:
            state = vehicle.state
            fresh = state is not None and state is not before
            return bool(self._lost) or (
                fresh and state is not None and (is_done(state) or _refused(vehicle, name, state))
            )

        try:
            async with asyncio.timeout(limit_s):
                while not ended():
                    await self._publish(vehicle, *message)
                    with suppress(TimeoutError):
                        async with asyncio.timeout(ASK_AGAIN_S), vehicle.news:
                            await vehicle.news.wait_for(ended)
        except TimeoutError:
            raise LinkError(
                f"robot {vehicle.robot}: {what}: not done within {limit_s:g} s{self._hint(vehicle)}"
            ) from None
        if self._lost:
            raise LinkError(f"robot {vehicle.robot}: {what}: {self._lost}")
        if vehicle.state is None or not is_done(vehicle.state):
            error = vehicle.refusal(name)
            raise LinkError(f"robot {vehicle.robot}: {what}: {error.text() if error else 'the vehicle failed to'}")

    def _hint(self, vehicle: Vda5050Vehicle) -> str:
        """Why a vehicle may not have been heard."""
        if vehicle.connection not in ("", "ONLINE"):
            return f"; the broker says that it is {vehicle.connection}"
        if vehicle.state is None and self._others:
            wanted = f"{self._settings.manufacturer}/{vehicle.identity.serial_number}"
            return f"; {wanted} is needed, and the broker knows of {', '.join(sorted(self._others))}"
        return ""


def _refused(vehicle: Vda5050Vehicle, name: str, state: VehicleState) -> bool:
    return vehicle.refusal(name) is not None or state.actions.get(name) == "FAILED"
