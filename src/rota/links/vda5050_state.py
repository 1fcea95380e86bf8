"""What VDA 5050 vehicles send, read with bounds: of messages that are not as section 6.10 has them, nothing is used."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, TypeVar

from rota.files.vda5050_orders import MOST_SEQUENCE
from rota.files.vda5050_versions import TRIGGERED, Protocol, WaitAction, protocol_of

MOST_BYTES = 1 << 20  # of a message: some ten thousand nodes
MOST_TEXT = 200  # letters of a description that are kept
LARGEST = 1e9
LOST = ("CONNECTIONBROKEN", "CONNECTION_BROKEN")  # versions 2 and 3
CONNECTIONS = ("ONLINE", "OFFLINE", "HIBERNATING", *LOST)
STOPPING = ("FATAL", "CRITICAL")  # levels of errors with which a vehicle cannot go on
# names of actions that wait, and of their parameters that hold seconds, as vehicles of several makers have them
WAITS, DURATIONS = ("wait", "noop", "delay"), ("duration", "time", "waittime", "seconds")

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
    """An error that a vehicle reports. about: what it refers to, values by their keys, such as ``orderId``."""

    kind: str
    is_fatal: bool
    description: str
    about: frozenset[tuple[str, str]]

    def text(self) -> str:
        """The error in words."""
        return f"{self.kind}: {self.description}" if self.description else self.kind


@dataclass(frozen=True, kw_only=True)
class VehicleState:
    """A state message. battery: 0 to 1; charging: whether it is being filled. place_m: None where that is not known.

    actions: the status of each, of instant actions as well.
    """

    unix_s: float
    order_id: str
    update: int
    last_sequence: int
    nodes: tuple[Part, ...]
    edges: tuple[Part, ...]
    place_m: tuple[float, float] | None
    map_id: str
    battery: float
    charging: bool
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


def version_of(read: Json) -> str:
    """The version of VDA 5050 that a message says it is of, whether it is spoken or not."""
    return _get(read, "version", str)[:MOST_TEXT]


def connection_of(read: Json) -> str:
    """Whether a vehicle is ONLINE, OFFLINE, HIBERNATING, CONNECTIONBROKEN or CONNECTION_BROKEN."""
    state = _get(read, "connectionState", str)
    if state not in CONNECTIONS:
        raise Malformed("connectionState is none that there is")
    return state


def wait_action_of(read: Json) -> WaitAction | None:
    """The action by which a vehicle waits at nodes, as far as its factsheet tells one that is known."""
    features = _dict(read.get("protocolFeatures", {}))
    listed = features.get("mobileRobotActions", features.get("agvActions", []))
    actions = {}
    for each in map(_dict, listed if isinstance(listed, list) else ()):
        scopes = each.get("actionScopes")
        actions[_get(each, "actionType", str)] = (each, scopes if isinstance(scopes, list) else [])
    _, scopes = actions.get(TRIGGERED, (None, []))
    if "NODE" in scopes and "trigger" in actions:
        return WaitAction(name=TRIGGERED, parameter=None)
    for name, (each, scopes) in actions.items():
        parameters = each.get("actionParameters", [])
        if name.lower() not in WAITS or "NODE" not in scopes or not isinstance(parameters, list):
            continue
        for parameter in map(_dict, parameters):
            key, kind = _get(parameter, "key", str), parameter.get("valueDataType")
            if key.lower() in DURATIONS and kind in ("NUMBER", "FLOAT", "INTEGER"):
                return WaitAction(name=name, parameter=key, whole=kind == "INTEGER")
    return None


def place_of(read: Json, protocol: Protocol) -> tuple[tuple[float, float] | None, str]:
    """Where a state or a visualization says that the vehicle is, and on which map."""
    told = read.get("mobileRobotPosition" if protocol.is_3 else "agvPosition")
    if told is None:
        return None, ""
    position = _dict(told)
    map_id = _get(position, "mapId", str)
    if not _get(position, "localized" if protocol.is_3 else "positionInitialized", bool):
        return None, map_id
    return (_number(position, "x", -LARGEST, LARGEST), _number(position, "y", -LARGEST, LARGEST)), map_id


def instant_of(read: Json) -> float:
    """When a message was sent, in Unix seconds by the vehicle's clock."""
    return _unix_s(_get(read, "timestamp", str))


def state_of(read: Json) -> VehicleState:
    """A state message of a vehicle; raises Malformed for all else."""
    protocol = protocol_of(version_of(read))
    if protocol is None:
        raise Malformed("a version that is not spoken")
    place, map_id = place_of(read, protocol)
    power, charge = ("powerSupply", "stateOfCharge") if protocol.is_3 else ("batteryState", "batteryCharge")
    instant = _get(read, "instantActionStates", list) if protocol.is_3 else []
    return VehicleState(
        unix_s=instant_of(read),
        order_id=_get(read, "orderId", str),
        update=_whole(read, "orderUpdateId"),
        last_sequence=_whole(read, "lastNodeSequenceId"),
        nodes=_parts(read, "nodeStates", "nodeId"),
        edges=_parts(read, "edgeStates", "edgeId"),
        place_m=place,
        map_id=map_id,
        battery=_number(_dict(read.get(power)), charge, 0, 100) / 100,
        charging=_dict(read.get(power)).get("charging") is True,
        paused=_get(read, "paused", bool) if "paused" in read else False,
        is_automatic=_get(read, "operatingMode", str) == "AUTOMATIC",
        errors=tuple(map(_error, _get(read, "errors", list))),
        actions={
            _get(_dict(each), "actionId", str): _get(each, "actionStatus", str)
            for each in [*_get(read, "actionStates", list), *instant]
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
    """An error of a state message; Malformed where it is none."""
    references = _dict(read).get("errorReferences", [])
    if not isinstance(references, list):
        raise Malformed("errorReferences is no list")
    return VehicleError(
        kind=_get(read, "errorType", str)[:MOST_TEXT],
        is_fatal=_get(read, "errorLevel", str) in STOPPING,
        description=_get(read, "errorDescription", str)[:MOST_TEXT] if "errorDescription" in read else "",
        about=frozenset(
            (_get(_dict(each), "referenceKey", str), _get(each, "referenceValue", str)) for each in references
        ),
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
