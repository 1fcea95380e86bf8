"""ArduCopters driven by timed targets: place, velocity and acceleration, ten times a second, in their mode GUIDED.

Each has a moment of its plan, its phase, which goes on as the clock of all does, faster or slower where it has to
make up or lose time. It waits for a vehicle that falls back, and for one that is not heard: that stops by itself,
by GUID_TIMEOUT, and goes on from the nearest place of its way, never by a jump to the clock.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rota.files.geodesy import Projection
from rota.links.air_lead import LATER_S, AirLead
from rota.links.link import Report
from rota.links.mavlink_vehicle import MavlinkVehicle
from rota.links.rounded_track import RoundedTrack
from rota.model.fleet import Robot
from rota.vehicles.presets import ARDUCOPTER

EVERY_S = 0.1
LOCAL_NED, PLACE_SPEED_AND_ACCELERATION = 1, 3072  # MAV_FRAME; the mask that leaves out yaw and yaw rate
METRES_PER_1E7 = 0.011131884502145034  # LOCATION_SCALING_FACTOR, AP_Common/Location.h: as ArduPilot itself counts
SILENT_S = 1.0  # after which a vehicle's phase stands still
LOOK_BACK_S, LOOK_AHEAD_S = 15.0, 2.0  # of the phase, in which a vehicle that is heard again is looked for on its way
CATCH_UP_S = 5.0  # in which it is to make up what it is late by
MOST_PACE = 1.3  # of the plan's, however much room there is
AIR_SHARE = 0.9  # of the airspeed that the wind leaves: the rest holds the way
DELAY_S = 0.4  # by which a report is older than the target that it belongs to
LEAN_DEG = 30.0  # at which a copter flies at its top airspeed: ANGLE_MAX, by default
NEAR_M, FAR_M = 2.0, 6.0  # beside its target by more: its phase goes on more slowly; by so much: not at all


def top_airspeed_m_s(robot: Robot) -> float:
    """Through the air: as its mission tells, or else as an ArduCopter's."""
    top, usual = robot.motion.top_airspeed_m_s, ARDUCOPTER.top_airspeed_m_s
    assert usual is not None
    return usual.value if top is None else top


def most_pace(track: RoundedTrack, robot: Robot, acceleration_m_s2: float) -> float:
    """The share of the plan's pace at which a robot can be driven at most: by its corners, and by the air."""
    paces = [MOST_PACE]
    if track.hardest.acceleration_m_s2 > 0:
        paces.append(math.sqrt(acceleration_m_s2 / track.hardest.acceleration_m_s2))
    if track.top_m_s > 0:
        paces.append(AIR_SHARE * (top_airspeed_m_s(robot) - robot.motion.wind_m_s) / track.top_m_s)
    return min(paces)


@dataclass(kw_only=True)
class Target:
    """One vehicle's. origin: degrees and height over sea of its local frame. height_m: where the way has none.

    most: the pace that it can be driven at, as a share of the plan's. lead: against the air.
    """

    vehicle: MavlinkVehicle
    track: RoundedTrack
    projection: Projection
    origin: tuple[float, float, float]
    height_m: float
    ramp_m_s2: float
    most: float
    lead: AirLead
    latest: Callable[[], Report | None]
    phase_s: float = 0.0
    pace: float = 0.0
    wanted: float = 1.0
    lost: bool = False
    _at_s: float = field(default_factory=time.monotonic)

    def keep(self, late_s: float, rate: float) -> None:
        """Gain ``late_s`` on a clock that goes at ``rate``, or lose as much."""
        self.wanted = min(max(0.0, rate * (1 + late_s / CATCH_UP_S)), self.most)

    def step(self, now_s: float) -> dict[str, float] | None:
        """Let the phase go on; the fields of the target to be sent. None: the vehicle is not heard."""
        passed_s, self._at_s = now_s - self._at_s, now_s
        report = self.latest()
        if report is None or now_s - self.vehicle.heard_s > SILENT_S:
            self.lost, self.pace = True, 0.0
            self.lead.begin()
            return None
        if self.lost:
            self.lost = False
            self._find(report)
        here = self.track.at(self.phase_s)
        speed = float(np.linalg.norm(here.velocity_m_s))
        off_m = math.dist(here.place_m[:2], report.position_m[:2]) - speed * self.pace * DELAY_S
        heeded = min(max((FAR_M - off_m) / (FAR_M - NEAR_M), 0.0), 1.0)
        most = self.ramp_m_s2 / max(speed, 1.0) * passed_s
        change = min(max(self.wanted * heeded - self.pace, -most), most)
        self.phase_s += (self.pace + change / 2) * passed_s
        self.pace += change
        return self._fields(passed_s, change / passed_s if passed_s > 0 else 0.0)

    def _find(self, report: Report) -> None:
        """Go on from where it is: the moment whose place is nearest."""
        place = np.array(report.position_m[: len(self.track.at(0.0).place_m)])
        self.phase_s = self.track.nearest_s(place, self.phase_s - LOOK_BACK_S, self.phase_s + LOOK_AHEAD_S)

    def _fields(self, passed_s: float, pace_change: float) -> dict[str, float]:
        """The fields of the message with the target of this moment."""
        here, then = self.track.at(self.phase_s), self.track.at(self.phase_s + LATER_S * self.pace)
        place, velocity, acceleration = here
        lead, along = self.lead, velocity * pace_change
        turned = (then.acceleration_m_s2 - acceleration)[:2] * self.pace**2
        lead.step(passed_s, then.velocity_m_s[:2] * (self.pace + LATER_S * pace_change), turned)
        east, north, up = _beside(velocity * self.pace, lead.velocity_m_s)
        a_east, a_north, a_up = _beside(acceleration * self.pace**2 + along, lead.acceleration_m_s2)
        x, y, _ = _beside(place, lead.off_m)
        (lon,), (lat,) = self.projection.to_degrees([x], [y])
        lat0, lon0, sea_m = self.origin
        per_degree = METRES_PER_1E7 * 1e7
        height_m = float(place[2]) if len(place) == 3 else self.height_m
        return {
            "x": (float(lat) - lat0) * per_degree,
            "y": (float(lon) - lon0) * per_degree * math.cos(math.radians((float(lat) + lat0) / 2)),
            "z": sea_m - (self.vehicle.home_height_m + height_m),
            "vx": north, "vy": east, "vz": -up, "afx": a_north, "afy": a_east, "afz": -a_up,
        }  # fmt: skip


def _beside(vector: np.ndarray, by: np.ndarray) -> tuple[float, float, float]:
    """A vector (2,) or (3,) with a horizontal one added, in space."""
    x, y, *z = vector.tolist()
    return x + float(by[0]), y + float(by[1]), z[0] if z else 0.0


class TargetStream:
    """A thread that sends all vehicles their targets: what the program does beside must not hold them up."""

    def __init__(self) -> None:
        self._targets: dict[str, Target] = {}
        self._sending = threading.Lock()  # a target sent after a robot was told of a place would call it off
        self._done = threading.Event()
        self._thread: threading.Thread | None = None

    def give(self, robot: str, target: Target) -> None:
        """Begin to drive a robot."""
        self._targets = {**self._targets, robot: target}
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, daemon=True)
            self._thread.start()

    def take(self, robot: str) -> Target | None:
        """Stop driving a robot; what it was driven by. Nothing is sent to it afterwards."""
        with self._sending:
            found = self._targets.get(robot)
            self._targets = {name: target for name, target in self._targets.items() if name != robot}
        return found

    def target(self, robot: str) -> Target | None:
        """What a robot is driven by; None where it is not."""
        return self._targets.get(robot)

    def end(self) -> None:
        """Send no more."""
        self._done.set()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        next_s = time.monotonic()
        while not self._done.is_set():
            for robot in tuple(self._targets):
                with self._sending:
                    self._drive(robot)
            next_s = max(next_s + EVERY_S, time.monotonic())
            self._done.wait(next_s - time.monotonic())

    def _drive(self, robot: str) -> None:
        """Send a robot its next target, unless it is driven no more."""
        target = self._targets.get(robot)
        fields = None if target is None else target.step(time.monotonic())
        if target is not None and fields is not None:
            send(target.vehicle, fields)


def send(vehicle: MavlinkVehicle, fields: dict[str, float]) -> None:
    """Send a target; one that does not get out is followed by the next."""
    from mavsdk.plugins.mavlink_direct import MavlinkDirectError, MavlinkMessage

    system = vehicle.system.get_system_id()
    told = {
        "time_boot_ms": 0, "target_system": system, "target_component": 1, "coordinate_frame": LOCAL_NED,
        "type_mask": PLACE_SPEED_AND_ACCELERATION, **fields, "yaw": 0.0, "yaw_rate": 0.0,
    }  # fmt: skip
    message = MavlinkMessage("SET_POSITION_TARGET_LOCAL_NED", 0, 0, system, 1, json.dumps(told))
    try:
        vehicle.plugin("mavlink_direct", "MavlinkDirect").send_message(message)
    except MavlinkDirectError:
        return
