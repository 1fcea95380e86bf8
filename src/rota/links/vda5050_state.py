"""What VDA 5050 vehicles send, read with bounds: of messages that are not as section 6.10 has them, nothing is used."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, TypeVar

from rota.files.vda5050_orders import MOST_SEQUENCE

MOST_BYTES = 1 << 20  # of a message: some ten thousand nodes
MOST_TEXT = 200  # letters of a description that are kept
LARGEST = 1e9

Json = dict[str, Any]
Value = TypeVar("Value")


class Malformed(Exception):  # noqa: N818 (it is counted, and told as an example)
    """A message that is not what it has to be, and why."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """A node or an edge that is still ahead of a vehicle."""

    name: str
    sequence: int
    released: bool


@dataclass(frozen=True, kw_only=True)
class VehicleError:
    """An error that a vehicle reports; orders: the ids of the orders and actions that it names."""

    kind: str
    is_fatal: bool
    description: str
    about: frozenset[str]

    def text(self) -> str:
        """The error in words."""
        return f"{self.kind}: {self.description}" if self.description else self.kind


@dataclass(frozen=True, kw_only=True)
class VehicleState:
    """A state message. battery: 0 to 1. place_m: None where the vehicle does not know where it is."""

    unix_s: float
    order_id: str
    update: int
    last_sequence: int
    nodes: tuple[Part, ...]
    edges: tuple[Part, ...]
    place_m: tuple[float, float] | None
    map_id: str
    battery: float
    paused: bool
    is_automatic: bool
    errors: tuple[VehicleError, ...]
    actions: Mapping[str, str]


def message_of(payload: object) -> Json:
    """The JSON object of a message; raises Malformed for anything else, also for NaN and for what is very large."""
    if not isinstance(payload, bytes | bytearray) or len(payload) > MOST_BYTES:
        raise Malformed("no bytes, or too many")
    try:
        read = json.loads(payload, parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        raise Malformed("no JSON") from error
    if not isinstance(read, dict):
        raise Malformed("no object of JSON")
    return read


def _refuse(name: str) -> float:
    raise Malformed(f"{name} is no number of JSON")


def connection_of(payload: object) -> str:
    """Whether a vehicle is ONLINE, OFFLINE or CONNECTIONBROKEN."""
    state = _get(message_of(payload), "connectionState", str)
    if state not in ("ONLINE", "OFFLINE", "CONNECTIONBROKEN"):
        raise Malformed("connectionState is none that there is")
    return state


def state_of(payload: object, serial_number: str) -> VehicleState:
    """A state message of a vehicle; raises Malformed for all else."""
    read = message_of(payload)
    if read.get("serialNumber") != serial_number or not _get(read, "version", str).startswith("2."):
        raise Malformed("another serial number or version than its topic's")
    place, map_id = None, ""
    if (position := read.get("agvPosition")) is not None:
        position = _dict(position)
        map_id = _get(position, "mapId", str)
        if _get(position, "positionInitialized", bool):
            place = (_number(position, "x", -LARGEST, LARGEST), _number(position, "y", -LARGEST, LARGEST))
    return VehicleState(
        unix_s=_unix_s(_get(read, "timestamp", str)),
        order_id=_get(read, "orderId", str),
        update=_whole(read, "orderUpdateId"),
        last_sequence=_whole(read, "lastNodeSequenceId"),
        nodes=_parts(read, "nodeStates", "nodeId"),
        edges=_parts(read, "edgeStates", "edgeId"),
        place_m=place,
        map_id=map_id,
        battery=_number(_dict(read.get("batteryState")), "batteryCharge", 0, 100) / 100,
        paused=_get(read, "paused", bool) if "paused" in read else False,
        is_automatic=_get(read, "operatingMode", str) == "AUTOMATIC",
        errors=tuple(map(_error, _get(read, "errors", list))),
        actions={
            _get(_dict(each), "actionId", str): _get(each, "actionStatus", str)
            for each in _get(read, "actionStates", list)
        },
    )


def _parts(read: Json, key: str, name: str) -> tuple[Part, ...]:
    return tuple(
        Part(
            name=_get(_dict(each), name, str),
            sequence=_whole(each, "sequenceId"),
            released=_get(each, "released", bool),
        )
        for each in _get(read, key, list)
    )


def _error(read: Any) -> VehicleError:
    references = _dict(read).get("errorReferences", [])
    if not isinstance(references, list):
        raise Malformed("errorReferences is no list")
    return VehicleError(
        kind=_get(read, "errorType", str)[:MOST_TEXT],
        is_fatal=_get(read, "errorLevel", str) == "FATAL",
        description=_get(read, "errorDescription", str)[:MOST_TEXT] if "errorDescription" in read else "",
        about=frozenset(_get(_dict(each), "referenceValue", str) for each in references),
    )


def _dict(value: Any) -> Json:
    if not isinstance(value, dict):
        raise Malformed("a part is no object of JSON")
    return value


def _get(read: Json, key: str, kind: type[Value]) -> Value:
    value = read.get(key)
    if not isinstance(value, kind):
        raise Malformed(f"{key} is missing, or of another type")
    return value


def _number(read: Json, key: str, low: float, high: float) -> float:
    value = read.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise Malformed(f"{key} is no number from {low:g} to {high:g}")
    return float(value)


def _whole(read: Json, key: str) -> int:
    value = read.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= MOST_SEQUENCE:
        raise Malformed(f"{key} is no whole number that is allowed")
    return value


def _unix_s(text: str) -> float:
    try:
        instant = datetime.fromisoformat(text)
        unix_s = (instant if instant.tzinfo else instant.replace(tzinfo=UTC)).timestamp()
    except (ValueError, OverflowError) as error:
        raise Malformed("timestamp is no instant") from error
    if not math.isfinite(unix_s):
        raise Malformed("timestamp is no instant")
    return unix_s
