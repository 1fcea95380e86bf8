"""What is said to VDA 5050 vehicles, and the state that each has to come to by it."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from contextlib import suppress
from functools import partial

from rota.errors import LinkError
from rota.files.vda5050_versions import SPOKEN, Json
from rota.links.vda5050_broker import Broker, Vda5050Settings
from rota.links.vda5050_state import MOST_TEXT, VehicleState
from rota.links.vda5050_vehicle import ASK_AGAIN_S, ENDED, Vda5050Vehicle

MOST_OTHERS = 10  # vehicles at the broker that are not the plan's, for error messages
MOST_ERRORS = 3  # that a vehicle reports and a message tells


class Talk:
    """Messages to vehicles over a broker. ``lost``: what keeps it from the broker; empty if nothing does."""

    def __init__(self, broker: Broker, settings: Vda5050Settings) -> None:
        self.lost = ""
        self._broker, self._settings = broker, settings
        self._others: set[str] = set()

    def hear_of_other(self, name: str) -> None:
        """A vehicle is at the broker that is none of the plan's."""
        if len(self._others) < MOST_OTHERS:
            self._others.add(name[:MOST_TEXT])

    async def publish(self, vehicle: Vda5050Vehicle, name: str, message: Json, level: str = "") -> None:
        """Send a message to one of its topics, on the level of its own unless another is given."""
        level = level or vehicle.level or vehicle.identity.protocol.level
        to = f"{self._settings.manufacturer}/{vehicle.identity.serial_number}"
        await self._broker.publish(f"{self._settings.interface}/{level}/{to}/{name}", json.dumps(message))

    async def introduce(self, vehicle: Vda5050Vehicle, limit_s: float) -> None:
        """Ask for a vehicle's state, in every version that it may speak, until it is heard; LinkError if it is not."""
        try:
            async with asyncio.timeout(limit_s):
                while vehicle.state is None and not self.lost:
                    asked = dict(vehicle.versions)
                    if asked and not vehicle.spoken:
                        raise LinkError(f"robot {vehicle.robot}: {_unspoken(vehicle)}")
                    for level, protocol in (vehicle.spoken or {"": vehicle.identity.protocol}).items():
                        _, message = vehicle.instant_action("stateRequest", protocol)
                        await self.publish(vehicle, "instantActions", message, level)
                    await self._news(vehicle, partial(self._is_heard, vehicle, asked))
        except TimeoutError:
            raise self._late(vehicle, "being heard", limit_s) from None
        if self.lost:
            raise LinkError(f"robot {vehicle.robot}: being heard: {self.lost}")

    def _is_heard(self, vehicle: Vda5050Vehicle, asked: dict[str, str]) -> bool:
        return vehicle.state is not None or vehicle.versions != asked or bool(self.lost)

    async def _news(self, vehicle: Vda5050Vehicle, is_so: Callable[[], object]) -> None:
        """Wait until news of the vehicle make it so, or it is time to ask again."""
        with suppress(TimeoutError):
            async with asyncio.timeout(ASK_AGAIN_S), vehicle.news:
                await vehicle.news.wait_for(is_so)

    async def act(self, vehicle: Vda5050Vehicle, kind: str, is_done: Callable[[VehicleState], bool]) -> None:
        """Send an instant action, and wait until the vehicle's state is what it leads to."""
        action_id, message = vehicle.instant_action(kind)

        def done(state: VehicleState) -> bool:
            # a vehicle that had no order to cancel fails to, and is as it should be
            return is_done(state) and (kind != "cancelOrder" or state.actions.get(action_id, "FINISHED") in ENDED)

        await self.until(vehicle, kind, "instantActions", message, done)

    async def until(
        self,
        vehicle: Vda5050Vehicle,
        what: str,
        topic: str,
        message: Json,
        is_done: Callable[[VehicleState], bool],
        limit_s: float | None = None,
    ) -> None:
        """Send a message, again now and then, until a state that comes after it is as wanted; LinkError if none does.

        The error says what the vehicle reports.
        """
        before = vehicle.state
        limit_s = self._settings.answer_s if limit_s is None else limit_s
        actions = [action["actionId"] for action in message.get("actions", ())]

        def failed(state: VehicleState) -> bool:
            return vehicle.refusal(topic, message) is not None or any(state.actions.get(k) == "FAILED" for k in actions)

        def is_over() -> bool:
            state = vehicle.state
            return bool(self.lost) or (state is not None and state is not before and (is_done(state) or failed(state)))

        try:
            async with asyncio.timeout(limit_s):
                while not is_over():
                    await self.publish(vehicle, topic, message)
                    await self._news(vehicle, is_over)
        except TimeoutError:
            raise self._late(vehicle, what, limit_s) from None
        if self.lost:
            raise LinkError(f"robot {vehicle.robot}: {what}: {self.lost}")
        if vehicle.state is None or not is_done(vehicle.state):
            error = vehicle.refusal(topic, message)
            told = error.text() if error else f"the vehicle failed to{self._hint(vehicle)}"
            raise LinkError(f"robot {vehicle.robot}: {what}: {told}")

    def _late(self, vehicle: Vda5050Vehicle, what: str, limit_s: float) -> LinkError:
        return LinkError(f"robot {vehicle.robot}: {what}: not done within {limit_s:g} s{self._hint(vehicle)}")

    def _hint(self, vehicle: Vda5050Vehicle) -> str:
        """Why a vehicle may not have been heard, or not have done as it was told."""
        if vehicle.connection not in ("", "ONLINE"):
            return f"; the broker says that it is {vehicle.connection}"
        if len(vehicle.spoken) < len(vehicle.versions):
            return f"; {_unspoken(vehicle)}"
        if vehicle.state is None and self._others:
            wanted = f"{self._settings.manufacturer}/{vehicle.identity.serial_number}"
            return f"; {wanted} is needed, and the broker knows of {', '.join(sorted(self._others))}"
        if vehicle.errors:
            return f"; it reports {'; '.join(error.text() for error in vehicle.errors[-MOST_ERRORS:])}"
        return ""


def _unspoken(vehicle: Vda5050Vehicle) -> str:
    versions = sorted(set(vehicle.versions.values()) - {protocol.version for protocol in vehicle.spoken.values()})
    return f"it speaks VDA 5050 {', '.join(version[:25] for version in versions)}; {SPOKEN} are spoken here"
