"""The MQTT broker between the link ``vda5050`` and its vehicles, and the settings of both."""

from __future__ import annotations

import asyncio
import ssl
from collections.abc import AsyncGenerator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from rota.errors import LinkError, RotaError
from rota.files.vda5050_versions import wait_action_given
from rota.model.planner_settings import Settings, setting

if TYPE_CHECKING:
    from aiomqtt import Client

MOST_QUEUED = 10_000  # messages that have arrived and wait; later ones are lost
LOOPBACK = "127.0.0.1"
BY_RELEASE = "release"
END_AGAIN_S = 0.1  # until a task that goes on is cancelled again
RETRY_S = 1.0  # between two tries to reach a broker that was lost


@dataclass(frozen=True, kw_only=True)
class Vda5050Settings(Settings):
    """Settings of the link ``vda5050``."""

    place: ClassVar[str] = "vda5050"
    host: str = setting(LOOPBACK, "the broker")
    port: int = setting(1883, "the broker's; with TLS often 8883", least=1, most=65535)
    username: str = setting("", "for the broker, if it asks")
    password_file: str = setting("", "a file that holds the password, and nothing else")
    tls: bool = setting(False, "encrypted, with the broker's certificate checked")
    ca_file: str = setting("", "certificates to trust in place of the system's, with tls")
    interface: str = setting("uagv", "first level of all topics")
    manufacturer: str = setting("rota", "third level of all topics; the fourth is the robot's name")
    map_id: str = setting("map", "the map that the vehicles drive on")
    released: int = setting(2, "stops that are released to a vehicle at once", least=1, most=10_000)
    announced: int = setting(5, "stops beyond them that it is told of", least=0, most=10_000)
    wait_action: str = setting(
        "",
        f"how vehicles wait: NAME:PARAMETER, an action and its parameter in seconds; NAME, an action that waits for a"
        f" trigger; {BY_RELEASE}: for stops to be released; empty: as the factsheet tells, else by release",
    )
    charging: bool = setting(True, "at chargers vehicles are told startCharging, and stopCharging before they leave")
    wait_s: float = setting(10.0, "how long a vehicle may take to be heard", above=0, most=3600)
    answer_s: float = setting(10.0, "how long it may take to do as it is told", above=0, most=3600)
    start_time: str = setting("", "when the plan started, in ISO 8601; empty: when this link opened")


async def end_task(task: asyncio.Task[None]) -> None:
    """Cancel a task until it has ended; what it raised is raised here.

    Once may not do. aiomqtt waits with ``asyncio.wait_for``, and before Python 3.12 that swallows a cancellation that
    comes just when its wait ends.
    """
    while not task.done():
        task.cancel()
        await asyncio.wait([task], timeout=END_AGAIN_S)
    with suppress(asyncio.CancelledError):
        await task


class Broker:
    """A connection to the broker; it raises LinkError, which names the broker, where that is lost or refuses."""

    def __init__(self, settings: Vda5050Settings) -> None:
        if settings.ca_file and not settings.tls:
            raise RotaError("vda5050.ca_file: is for tls only; add --set tls=true")
        if settings.password_file and not settings.username:
            raise RotaError("vda5050.password_file: is for a username only; add --set username=NAME")
        if settings.wait_action:
            wait_action_given(settings.wait_action, "vda5050.wait_action")
        self._settings = settings
        self._name = f"the broker {settings.host}:{settings.port}"
        self._client: Client | None = None
        self._topics: dict[str, int] = {}

    async def open(self) -> None:
        """Connect. Raises RotaError for files that cannot be read."""
        from aiomqtt import MqttError

        client = self._made()
        try:
            await client.__aenter__()
        except (MqttError, OSError) as error:
            raise LinkError(f"{self._name} cannot be used: {error}") from None
        self._client = client

    def _made(self) -> Client:
        """A client of the broker by the settings; RotaError for files that cannot be used."""
        from aiomqtt import Client

        given, password = self._settings, None
        if given.password_file:
            try:
                password = Path(given.password_file).read_text().rstrip("\r\n")
            except (OSError, UnicodeDecodeError) as error:
                raise RotaError(f"vda5050.password_file: {given.password_file}: cannot be read: {error}") from None
        try:
            context = ssl.create_default_context(cafile=given.ca_file or None) if given.tls else None
        except OSError as error:
            raise RotaError(f"vda5050.ca_file: {given.ca_file}: cannot be used: {error}") from None
        return Client(
            given.host,
            given.port,
            username=given.username or None,
            password=password,
            tls_context=context,
            timeout=given.answer_s,
            max_queued_incoming_messages=MOST_QUEUED,
        )

    def _open_client(self) -> Client:
        if self._client is None:
            raise LinkError(f"{self._name} is not connected")
        return self._client

    async def subscribe(self, topic: str, qos: int) -> None:
        """Ask for all messages of a topic."""
        from aiomqtt import MqttError

        try:
            await self._open_client().subscribe(topic, qos=qos)
        except MqttError as error:
            raise LinkError(f"{self._name} refuses {topic}: {error}") from None
        self._topics[topic] = qos

    async def publish(self, topic: str, text: str) -> None:
        """Send a message."""
        from aiomqtt import MqttError

        try:
            await self._open_client().publish(topic, text)
        except MqttError as error:
            raise LinkError(f"{self._name} is lost: {error}") from None

    async def messages(self) -> AsyncGenerator[tuple[str, object], None]:
        """Topic and payload of all that arrives; LinkError once the broker is lost."""
        from aiomqtt import MqttError

        try:
            async for message in self._open_client().messages:
                yield message.topic.value, message.payload
        except MqttError as error:
            raise LinkError(f"{self._name} is lost: {error}") from None

    async def reopen(self) -> None:
        """Connect again where the broker was lost, and ask for the same topics; tries until it can."""
        while True:
            await self.close()
            await asyncio.sleep(RETRY_S)
            with suppress(LinkError):
                await self.open()
                for topic, qos in self._topics.items():
                    await self.subscribe(topic, qos)
                return

    async def close(self) -> None:
        """Disconnect."""
        from aiomqtt import MqttError

        client, self._client = self._client, None
        if client is not None:
            with suppress(MqttError):
                await client.__aexit__(None, None, None)
