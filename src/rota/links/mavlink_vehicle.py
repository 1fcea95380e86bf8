"""One MAVLink vehicle that MAVSDK has heard: what is asked of it, with a limit on time, and what it last said."""

from __future__ import annotations

import asyncio
import functools
import json
import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any

from rota.errors import LinkError
from rota.files.mission_items import Autopilot
from rota.links.link import Mode

if TYPE_CHECKING:
    from mavsdk import System

SAID_S = 5.0  # before a refusal, in which a vehicle may have said why
MOST_SAID = 3  # texts of it that a message tells
ALERT = 5  # MAV_SEVERITY of notices: what is graver says why something does not work
SET_MESSAGE_INTERVAL = 511  # MAV_CMD
MISSION_CURRENT = 42  # a message's number
TRIES = 3  # MAVSDK gives a transfer up when its last answer is lost; all that is asked may be asked again


@dataclass(kw_only=True)
class MavlinkVehicle:
    """A vehicle; it has ``answer_s`` for all that is asked of it.

    item: the number of the mission item that it flies to, as it said last. home: its degrees of latitude and longitude,
    and its height over sea in metres. heard_s: when it
    last said where it is, by the monotonic clock.
    """

    robot: str
    system: System
    autopilot: Autopilot
    answer_s: float
    battery: float | None = None
    mode: Mode | None = None
    item: int | None = None
    in_air: bool = False
    home: tuple[float, float, float] | None = None
    home_height_m: float = 0.0
    heard_s: float = -math.inf
    _said: list[tuple[float, str]] = field(default_factory=list)
    _plugins: dict[str, Any] = field(default_factory=dict)

    def hear_words(self) -> None:
        """Keep what it says in words, and which item it flies to."""
        direct = self.plugin("mavlink_direct", "MavlinkDirect")

        def said(message: Any, _data: Any) -> None:
            told = json.loads(message.fields_json)
            if int(told.get("severity", ALERT)) < ALERT:
                # from another thread: one list in place of another
                self._said = [*self._said, (time.monotonic(), str(told.get("text", ""))[:100])][-MOST_SAID:]

        def flies_to(message: Any, _data: Any) -> None:
            self.item = int(json.loads(message.fields_json)["seq"])

        direct.subscribe_message("STATUSTEXT", said)
        direct.subscribe_message("MISSION_CURRENT", flies_to)

    def why(self) -> str:
        """What it has said in the last seconds that may be the reason for a refusal; empty where it said nothing."""
        texts = [text for at_s, text in self._said if time.monotonic() - at_s <= SAID_S]
        return f"; it says: {'; '.join(dict.fromkeys(texts))}" if texts else ""

    def plugin(self, module: str, name: str) -> Any:
        """A plugin of MAVSDK, made once."""
        if module not in self._plugins:
            self._plugins[module] = getattr(import_module(f"mavsdk.plugins.{module}"), name)(self.system)
        return self._plugins[module]

    def end_plugins(self) -> None:
        """Let go of all plugins before MAVSDK ends: the garbage collector might do so meanwhile, in another thread."""
        for plugin in self._plugins.values():
            plugin.destroy()

    async def ask(self, what: str, call: Callable[..., Any], *given: Any) -> tuple[Any, ...]:
        """Call what answers by a callback from another thread; returns what it answers beside success.

        Raises LinkError, which says ``what``, for refusals and where no answer comes.
        """
        result, rest = None, []
        try:
            async with asyncio.timeout(self.answer_s):
                for _ in range(TRIES):
                    answered: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
                    call(*given, into(answered))
                    result, *rest = await answered
                    if result.name != "TIMEOUT":
                        break
                    if not self.system.is_connected():
                        raise LinkError(f"robot {self.robot}: {what}: it has fallen silent")
        except TimeoutError:
            raise LinkError(f"robot {self.robot}: {what}: no answer within {self.answer_s:g} s") from None
        if result is None or result.name != "SUCCESS":
            raise LinkError(f"robot {self.robot}: {what}: {worded(result)}{self.why()}")
        return tuple(rest[:-1])  # without the data that callbacks are handed

    async def command(self, what: str, number: int, params: Sequence[float] = ()) -> None:
        """A command of MAVLink (MAV_CMD) with its first parameters, the others 0; LinkError where it is refused."""
        from mavsdk.plugins.mavlink_direct import MavlinkMessage

        target = self.system.get_system_id()
        fields = {"target_system": target, "target_component": 1, "command": number, "confirmation": 0}
        fields |= {f"param{k}": value for k, value in enumerate([*params, *[0] * (7 - len(params))], start=1)}
        message = MavlinkMessage("COMMAND_LONG", 0, 0, target, 1, json.dumps(fields))
        (answer,) = await self.ask(what, self.plugin("mavlink_direct", "MavlinkDirect").send_command_async, message)
        result = json.loads(answer.fields_json).get("result")
        if result != 0:
            raise LinkError(f"robot {self.robot}: {what}: refused with result {result!r}{self.why()}")

    async def tell_item(self, rate_hz: float) -> None:
        """Ask it to say so often which mission item it flies to; those that cannot choose say it anyway."""
        with suppress(LinkError):
            await self.command("its progress", SET_MESSAGE_INTERVAL, [MISSION_CURRENT, 1e6 / rate_hz])


@functools.cache
def silence_mavsdk() -> None:
    """Keep MAVSDK from printing, since its errors are told by their callers.

    Once in a process: a second subscription frees the callback that threads of other connections may be in.
    """
    from mavsdk.logging import log_subscribe

    log_subscribe(lambda *_: True)


def into(future: asyncio.Future[Any]) -> Callable[..., None]:
    """A callback for MAVSDK's threads that puts its arguments into a future, the first time."""
    loop = future.get_loop()

    def take(arguments: tuple[Any, ...]) -> None:
        if not future.done():
            future.set_result(arguments)

    def called(*arguments: Any) -> None:
        if not loop.is_closed():
            loop.call_soon_threadsafe(take, arguments)

    return called


def worded(result: Any) -> str:
    """An enum's name as words."""
    return str(result.name).lower().replace("_", " ")
