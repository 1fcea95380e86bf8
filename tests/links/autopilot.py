"""A scripted autopilot on loopback, written with pymavlink: it flies nothing, and fails as it is told to."""

from __future__ import annotations

import heapq
import math
import select
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

from pymavlink.dialects.v20 import common as mav
from tests.links.flight import Flight

HEARTBEAT_S, REQUEST_S = 0.1, 0.15
HOME_MM = 475_000  # over sea
MISSION_MODES = (4 << 16 | 4 << 24, 3)  # of PX4; of ArduPilot's copters
PX4_HOLD = 4 << 16 | 3 << 24
PX4_CRUISES_M_S = 5.0  # MPC_XY_CRUISE: by which it goes on after it has left its mission (issue 16031), before 1.14
MISSION, FENCE, RALLY = mav.MAV_MISSION_TYPE_MISSION, mav.MAV_MISSION_TYPE_FENCE, mav.MAV_MISSION_TYPE_RALLY
CAPABILITIES = (
    mav.MAV_PROTOCOL_CAPABILITY_MISSION_INT
    | mav.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    | mav.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | mav.MAV_PROTOCOL_CAPABILITY_MAVLINK2
)


@dataclass(frozen=True, kw_only=True)
class Script:
    """What is special about a vehicle. drop: every so-maniest message either way is lost. delay_s: of each answer.

    rejects_item: the number of the item that it refuses. silent_after_item: the one after which nothing comes any more.
    keeps_items: it takes no more than so many and says that all is well. alters_item: the one that it stores with
    another place. denies: commands that it refuses. flies: whether it flies what it holds, once it is told to.
    """

    kind: int = mav.MAV_TYPE_QUADROTOR
    firmware: int = mav.MAV_AUTOPILOT_PX4
    drop: int = 0
    delay_s: float = 0.0
    rejects_item: int | None = None
    silent_after_item: int | None = None
    keeps_items: int | None = None
    alters_item: int | None = None
    denies: frozenset[int] = frozenset()
    position: tuple[int, int, int] = (481000000, 115000000, 25000)
    battery_percent: int = 80
    flies: bool = False


@dataclass
class Autopilot:
    """One vehicle. ``items`` by kind of mission are what it holds; ``commands`` what it was told."""

    port: int
    script: Script
    items: dict[int, list[Any]] = field(default_factory=lambda: {MISSION: [], FENCE: [], RALLY: []})
    commands: list[int] = field(default_factory=list)
    modes: list[int] = field(default_factory=list)
    speeds_m_s: list[float] = field(default_factory=list)
    paused: bool = False
    stands: bool = False
    targets: list[tuple[float, Any]] = field(default_factory=list)
    params: dict[str, float] = field(default_factory=dict)
    in_air: bool = False
    silent: bool = False
    heard_from: set[int] = field(default_factory=set)
    asked_for: set[int] = field(default_factory=set)
    _asker: tuple[int, int] = (0, 0)
    _incoming: list[Any] = field(default_factory=list)
    _expected: tuple[int, int] = (0, 0)
    _asks_again_s: float = math.inf
    _counted: int = 0
    _delayed: list[tuple[float, int, bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.link = mav.MAVLink(None, srcSystem=1, srcComponent=1)
        self.link.robust_parsing = True
        lat, lon, height_mm = self.script.position
        self.flight, self._flown_s = Flight(lat / 1e7, lon / 1e7, height_mm / 1000), time.monotonic()

    # ------------------------------------------------------------ sending

    def _is_lost(self) -> bool:
        self._counted += 1
        return bool(self.script.drop) and self._counted % self.script.drop == 0

    def send(self, message: Any, *, at_once: bool = False) -> None:
        packed = message.pack(self.link)
        if self.silent or (not at_once and self._is_lost()):
            return
        heapq.heappush(
            self._delayed, (time.monotonic() + (0 if at_once else self.script.delay_s), self._counted, packed)
        )

    def send_due(self) -> None:
        while self._delayed and self._delayed[0][0] <= time.monotonic():
            self.socket.sendto(heapq.heappop(self._delayed)[2], ("127.0.0.1", self.port))

    def beat(self) -> None:
        script, flight = self.script, self.flight
        before_s, self._flown_s = self._flown_s, time.monotonic()
        if script.flies and self.modes and self.modes[-1] in MISSION_MODES and not self.paused:
            flight.fly(self.items[MISSION], self._flown_s - before_s)
        lat, lon, height_mm = round(flight.lat * 1e7), round(flight.lon * 1e7), round(flight.height_m * 1000)
        mode = self.modes[-1] if self.modes else 0
        armed = mav.MAV_MODE_FLAG_SAFETY_ARMED if mav.MAV_CMD_COMPONENT_ARM_DISARM in self.commands else 0
        base = mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | armed
        self.send(
            self.link.heartbeat_encode(script.kind, script.firmware, base, mode, mav.MAV_STATE_ACTIVE, 3), at_once=True
        )
        self.send(
            self.link.global_position_int_encode(0, lat, lon, HOME_MM + height_mm, height_mm, 0, 0, 0, 0), at_once=True
        )
        self.send(self.link.mission_current_encode(flight.number), at_once=True)
        state = mav.MAV_LANDED_STATE_IN_AIR if self.in_air else mav.MAV_LANDED_STATE_ON_GROUND
        self.send(self.link.extended_sys_state_encode(0, state), at_once=True)
        home = (round(script.position[0]), round(script.position[1]), HOME_MM)
        self.send(self.link.home_position_encode(*home, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0), at_once=True)
        if (
            script.firmware == mav.MAV_AUTOPILOT_ARDUPILOTMEGA
            and mav.MAVLINK_MSG_ID_BATTERY_STATUS not in self.asked_for
        ):
            return  # of its battery it tells who has asked
        cells, more = [4000, 4000, 4000] + [65535] * 7, [0] * 4
        told = (0, 0, 0, 2500, cells, 100, 0, 0, script.battery_percent, 0, 1, more, 0, 0)
        self.send(self.link.battery_status_encode(*told), at_once=True)
        load = (0, 0, 0, 500, 12000, 100, script.battery_percent, 0, 0, 0, 0, 0, 0)
        self.send(self.link.sys_status_encode(*load), at_once=True)

    # ------------------------------------------------------------ answering

    def read(self) -> None:
        data, _ = self.socket.recvfrom(65536)
        for message in self.link.parse_buffer(data) or ():
            if not self.silent and not self._is_lost():
                self._asker = (message.get_srcSystem(), message.get_srcComponent())
                self.heard_from.add(message.get_srcSystem())
                answer = getattr(self, f"on_{message.get_type().lower()}", None)
                if answer is not None:
                    answer(message)

    def on_command_long(self, message: Any) -> None:
        command = message.command
        self.commands.append(command)
        px4 = self.script.firmware == mav.MAV_AUTOPILOT_PX4
        if px4 and command in (mav.MAV_CMD_NAV_TAKEOFF, mav.MAV_CMD_NAV_LAND, mav.MAV_CMD_DO_REPOSITION):
            self.modes.append(PX4_HOLD)  # once it is there
        if command == mav.MAV_CMD_DO_SET_MODE:
            main, sub = int(message.param2), int(message.param3)
            if px4 and main << 16 | sub << 24 == MISSION_MODES[0]:
                self.flight.speed_m_s = PX4_CRUISES_M_S
            self.modes.append(main << 16 | sub << 24 if px4 else main)
        if command not in self.script.denies:
            self.obey(command, message)
        denied = command in self.script.denies
        result = mav.MAV_RESULT_DENIED if denied else mav.MAV_RESULT_ACCEPTED
        self.send(self.link.command_ack_encode(command, result, 0, 0, *self._asker))
        if command == mav.MAV_CMD_REQUEST_MESSAGE and int(message.param1) == mav.MAVLINK_MSG_ID_AUTOPILOT_VERSION:
            self.send(self.link.autopilot_version_encode(CAPABILITIES, 0, 0, 0, 0, [0] * 8, [0] * 8, [0] * 8, 0, 0, 1))

    on_command_int = on_command_long

    def obey(self, command: int, message: Any) -> None:
        """Change what it does; it is at once where it is told to go."""
        flight = self.flight
        if command == mav.MAV_CMD_DO_CHANGE_SPEED:
            self.speeds_m_s.append(message.param2)
            flight.speed_m_s = message.param2
        elif command == mav.MAV_CMD_DO_PAUSE_CONTINUE:
            self.paused = message.param1 == 0
        elif command == mav.MAV_CMD_SET_MESSAGE_INTERVAL:
            self.asked_for.add(int(message.param1))
        elif command == mav.MAV_CMD_NAV_TAKEOFF:
            px4 = self.script.firmware == mav.MAV_AUTOPILOT_PX4
            self.in_air, flight.height_m = True, self.params["MIS_TAKEOFF_ALT"] if px4 else message.param7
        elif command == mav.MAV_CMD_NAV_LAND:
            self.in_air, flight.height_m = False, 0.0
        elif command == mav.MAV_CMD_DO_REPOSITION:
            flight.lat, flight.lon, flight.height_m = message.x / 1e7, message.y / 1e7, message.z - HOME_MM / 1000
        elif command == mav.MAV_CMD_REQUEST_MESSAGE and int(message.param1) == mav.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN:
            self.send(self.link.gps_global_origin_encode(*self.script.position[:2], HOME_MM, 0))
        elif command == mav.MAV_CMD_DO_SET_MISSION_CURRENT:
            flight.number, flight.items = int(message.param1), self.items[MISSION]

    def on_set_position_target_local_ned(self, target: Any) -> None:
        """Be at once where it is told to be, places counted as ArduPilot does."""
        self.targets.append((time.monotonic(), target))
        if self.stands:
            return
        lat0, lon0 = self.script.position[0] / 1e7, self.script.position[1] / 1e7
        flight, metres = self.flight, 111318.84502145034
        flight.lat = lat0 + target.x / metres
        flight.lon = lon0 + target.y / metres / math.cos(math.radians((flight.lat + lat0) / 2))
        flight.height_m = -target.z

    def on_mission_set_current(self, message: Any) -> None:
        self.flight.number, self.flight.items = message.seq, self.items[MISSION]

    def on_set_mode(self, message: Any) -> None:
        self.modes.append(message.custom_mode)

    def on_param_request_read(self, message: Any) -> None:
        value = self.params.get(message.param_id, 0.0)
        self.send(self.link.param_value_encode(message.param_id.encode(), value, mav.MAV_PARAM_TYPE_REAL32, 1, 0))

    def on_param_set(self, message: Any) -> None:
        self.params[message.param_id] = message.param_value
        self.on_param_request_read(message)

    def on_mission_count(self, message: Any) -> None:
        self._incoming, self._expected = [], (message.mission_type, message.count)
        if message.count == 0:
            self._accept(message.mission_type)
        else:
            self._request(0)

    def ask_again(self) -> None:
        """Request an item once more that has not come in time, as the protocol has it."""
        if self._asks_again_s <= time.monotonic():
            self._request(len(self._incoming))

    def _request(self, number: int) -> None:
        self._asks_again_s = time.monotonic() + REQUEST_S + self.script.delay_s
        self.send(self.link.mission_request_int_encode(*self._asker, number, self._expected[0]))

    def _acknowledge(self, kind: int, result: int = mav.MAV_MISSION_ACCEPTED) -> None:
        self._asks_again_s = math.inf
        self.send(self.link.mission_ack_encode(*self._asker, result, kind))

    def _accept(self, kind: int) -> None:
        self.items[kind] = self._incoming
        self._acknowledge(kind)

    def on_mission_item_int(self, message: Any) -> None:
        (kind, count), script = self._expected, self.script
        if message.seq == len(self._incoming) - 1:
            return self._request(len(self._incoming)) if len(self._incoming) < count else self._acknowledge(kind)
        if message.seq != len(self._incoming) or message.mission_type != kind:
            return None
        if kind == MISSION and message.seq == script.rejects_item:
            return self._acknowledge(kind, mav.MAV_MISSION_INVALID_PARAM1)
        if kind == MISSION and message.seq == script.alters_item:
            message.x += 1000
        is_ardupilot = self.script.firmware == mav.MAV_AUTOPILOT_ARDUPILOTMEGA
        if is_ardupilot and kind == MISSION and (fault := stored_by_ardupilot(message)):
            return self._acknowledge(kind, fault)
        self._incoming.append(message)
        if kind == MISSION and message.seq == script.silent_after_item:
            # what it has so far is what it would fly
            self.items[kind], self.silent = self._incoming, True
            return None
        kept = script.keeps_items if kind == MISSION and script.keeps_items is not None else count
        if len(self._incoming) == min(count, kept):
            return self._accept(kind)
        return self._request(len(self._incoming))

    def on_mission_clear_all(self, message: Any) -> None:
        for kind in (
            (MISSION, FENCE, RALLY) if message.mission_type == mav.MAV_MISSION_TYPE_ALL else (message.mission_type,)
        ):
            self.items[kind] = []
        self._acknowledge(message.mission_type)

    def on_mission_request_list(self, message: Any) -> None:
        kind = message.mission_type
        self.send(self.link.mission_count_encode(*self._asker, len(self.items.get(kind, [])), kind))

    def on_mission_request_int(self, message: Any) -> None:
        item = self.items[message.mission_type][message.seq]
        fields = [getattr(item, name) for name in ("frame", "command", "current", "autocontinue")]
        params = [getattr(item, name) for name in ("param1", "param2", "param3", "param4", "x", "y", "z")]
        self.send(self.link.mission_item_int_encode(*self._asker, message.seq, *fields, *params, message.mission_type))


def stored_by_ardupilot(item: Any) -> int:
    """Let a mission item become what ArduPilot keeps of it, as its AP_Mission.cpp does; the result where it refuses."""
    open_heading = (mav.MAV_CMD_NAV_WAYPOINT, mav.MAV_CMD_NAV_TAKEOFF)
    params = [item.param1, item.param2, item.param3, item.param4]
    for number, value in enumerate(params):
        if math.isnan(value) and not (number == 3 and item.command in open_heading):
            return int(mav.MAV_MISSION_INVALID_PARAM1) + number
    if item.command in (mav.MAV_CMD_NAV_WAYPOINT, mav.MAV_CMD_NAV_TAKEOFF):
        item.param1, item.param2, item.param3, item.param4 = float(int(item.param1) % 65536), 0.0, 0.0, 0.0
    if item.command != mav.MAV_CMD_DO_CHANGE_SPEED:
        item.z = int(item.z * 100) / 100
    return 0


def free_ports(count: int) -> list[int]:
    """UDP ports of loopback that nobody listens on now."""
    with ExitStack() as stack:
        probes = [stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(count)]
        for probe in probes:
            probe.bind(("127.0.0.1", 0))
        return [probe.getsockname()[1] for probe in probes]


@contextmanager
def flying(*scripts: Script) -> Iterator[list[Autopilot]]:
    """Vehicles that beat until the block ends; each talks to a free port of its own."""
    vehicles = [Autopilot(port, script) for port, script in zip(free_ports(len(scripts)), scripts, strict=True)]
    done = threading.Event()
    by_socket = {vehicle.socket: vehicle for vehicle in vehicles}

    def serve() -> None:
        next_beat = 0.0
        while not done.is_set():
            if time.monotonic() >= next_beat:
                next_beat = time.monotonic() + HEARTBEAT_S
                for vehicle in vehicles:
                    vehicle.beat()
            for ready in select.select(list(by_socket), [], [], 0.01)[0]:
                by_socket[ready].read()
            for vehicle in vehicles:
                vehicle.ask_again()
                vehicle.send_due()

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield vehicles
    finally:
        done.set()
        thread.join(timeout=10)
        for vehicle in vehicles:
            vehicle.socket.close()


def copters(count: int, **special: Script) -> list[Script]:
    """So many plain PX4 copters, some with a script: ``v1=Script(...)`` is the second's."""
    return [special.get(f"v{k}", replace(Script())) for k in range(count)]
