"""What a MAVLink vehicle does by itself when the link is lost or it leaves its fence, read from its parameters.

ArduCopter: ArduCopter/Parameters.cpp and events.cpp (4.6) for FS_GCS_ENABLE, FS_OPTIONS, RTL_ALT, GUID_TIMEOUT;
AC_Fence.cpp for FENCE_ENABLE and FENCE_ACTION. PX4: commander_params.c and navigator/geofence_params.c.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Mapping, Sequence

from rota.links.mavlink_vehicle import MavlinkVehicle

ARDUPILOT_READ = (
    "FS_GCS_ENABLE", "FS_GCS_TIMEOUT", "FS_OPTIONS", "FENCE_ENABLE", "FENCE_ACTION", "RTL_ALT", "GUID_TIMEOUT",
    "WPNAV_ACCEL", "PSC_JERK_XY", "MIS_RESTART", "RALLY_LIMIT_KM", "RALLY_INCL_HOME", "SYSID_MYGCS",
)  # fmt: skip
PX4_READ = ("NAV_DLL_ACT", "COM_DL_LOSS_T", "GF_ACTION", "RTL_RETURN_ALT")
HEEDS = "SYSID_MYGCS"  # whose heartbeats count, Copter::failsafe_gcs_check
GOES_ON_IN_AUTO = 1 << 1  # of FS_OPTIONS: "Continue if in Auto on GCS failsafe"
ARDUPILOT_LOST = {
    1: "it returns to launch", 3: "it returns to launch by SmartRTL, its own way backwards, or else directly",
    4: "it returns to launch by SmartRTL, its own way backwards, or else lands", 5: "it lands where it is",
    6: "it returns to launch by its mission's landing sequence, or else directly", 7: "it brakes and lands",
}  # fmt: skip
ARDUPILOT_OUT = {
    0: "only says so", 1: "returns to launch, or lands", 2: "lands",
    3: "returns to launch by SmartRTL, or else directly",
    4: "brakes, or lands", 5: "returns to launch by SmartRTL, or else lands",
}  # fmt: skip
PX4_LOST = {1: "it holds", 2: "it returns to launch", 3: "it lands where it is", 5: "it stops its motors",
            6: "it stops its motors"}  # fmt: skip
PX4_OUT = {0: "does nothing", 1: "only says so", 2: "holds", 3: "returns to launch", 4: "stops its motors", 5: "lands"}
RETURNS = "returns to launch"
NEEDED_FOR_TARGETS = {"WPNAV_ACCEL": 500.0, "PSC_JERK_XY": 20.0}  # at least: with less a copter falls behind at corners
LONGEST_GUIDED_S = 0.5  # of GUID_TIMEOUT: it flies on by the last target for so long


async def read_parameters(vehicle: MavlinkVehicle, names: Iterable[str]) -> dict[str, float]:
    """Those of its parameters that it has."""
    found: dict[str, float] = {}
    for name in names:
        value = await asyncio.to_thread(_parameter, vehicle, name)
        if value is not None:
            found[name] = value
    return found


def _parameter(vehicle: MavlinkVehicle, name: str) -> float | None:
    """A parameter's value, whatever its type; None where the vehicle does not have it."""
    from mavsdk.plugins.param import ParamError

    param = vehicle.plugin("param", "Param")
    for read in (param.get_param_float, param.get_param_int):
        try:
            return float(read(name))
        except ParamError:
            continue
    return None


def told_of(
    vehicle: MavlinkVehicle, has: Mapping[str, float], *, by_targets: bool, rally_points: int, own_id: int
) -> tuple[str, ...]:
    """Sentences on what the vehicle does by itself. by_targets: it is driven by them, not by a mission of its own.

    rally_points: how many it holds. own_id: by which it knows this ground station.
    """
    if vehicle.autopilot == "px4":
        return _told_of_px4(has)
    told = _told_of_ardupilot(has, by_targets=by_targets, rally_points=rally_points, own_id=own_id)
    return (*told, *(_missing(has) if by_targets else ()))


def _told_of_ardupilot(has: Mapping[str, float], *, by_targets: bool, rally_points: int, own_id: int) -> Sequence[str]:
    """What an ArduPilot does when the link is lost and beyond its fence, by its parameters."""
    action = int(has.get("FS_GCS_ENABLE", 0))
    goes_on = int(has.get("FS_OPTIONS", 0)) & GOES_ON_IN_AUTO and not by_targets
    stops = f"it stops after {has.get('GUID_TIMEOUT', 3.0):g} s and hovers" if by_targets else "it flies its mission on"
    if action == 0 or goes_on:
        setting = "FS_GCS_ENABLE 0" if action == 0 else f"FS_OPTIONS {has['FS_OPTIONS']:.0f}"
        lost = f"{stops} ({setting})"
    elif has.get(HEEDS, 0) not in (0, own_id):
        heeded = f"ground station {has[HEEDS]:.0f} alone ({HEEDS}), this is {own_id} (--set system_id=)"
        lost = f"{stops}: FS_GCS_ENABLE {action} heeds {heeded}"
    else:
        after_s = has.get("FS_GCS_TIMEOUT", 5.0)
        does = ARDUPILOT_LOST.get(action, "it does what its version makes of that")
        lost = f"{stops}, and after {after_s:g} s {does} (FS_GCS_ENABLE {action})"
    told = [f"if this link is lost, {lost}"]
    if RETURNS in lost:
        told[0] += f", straight, at {has.get('RTL_ALT', 1500.0) / 100:g} m or higher{_rallies(has, rally_points)}"
    if int(has.get("FENCE_ENABLE", 0)) == 0:
        return [*told, "it does not heed its fence (FENCE_ENABLE 0)"]
    action = int(has.get("FENCE_ACTION", 1))
    return [*told, f"beyond its fence it {ARDUPILOT_OUT.get(action, 'does something')} (FENCE_ACTION {action})"]


def _rallies(has: Mapping[str, float], points: int) -> str:
    """Which of its rally points it returns to, by AP_Rally.cpp of ArduPilot 4.6; empty: to where it took off."""
    if not points:
        return ""
    limit_km = has.get("RALLY_LIMIT_KM", 0.3)
    near = f" within {limit_km * 1000:g} m" if limit_km > 0 else ""
    home = " and home" if has.get("RALLY_INCL_HOME", 1) else (", or else home" if near else "")
    return f", to the nearest of its {points} rally point{'s' * (points > 1)}{near}{home}"


def _missing(has: Mapping[str, float]) -> Sequence[str]:
    low = [f"{name} is {has[name]:g}, {least:g} is needed" for name, least in NEEDED_FOR_TARGETS.items()
           if name in has and has[name] < least]  # fmt: skip
    if has.get("GUID_TIMEOUT", LONGEST_GUIDED_S) > LONGEST_GUIDED_S:
        low.append(f"GUID_TIMEOUT is {has['GUID_TIMEOUT']:g}, {LONGEST_GUIDED_S:g} s is needed")
    return [f"for targets {'; '.join(low)}"] if low else ()


def _told_of_px4(has: Mapping[str, float]) -> tuple[str, ...]:
    """What a PX4 does when the link is lost and beyond its fence, by its parameters."""
    action = int(has.get("NAV_DLL_ACT", 0))
    after_s = has.get("COM_DL_LOSS_T", 10.0)
    does = PX4_LOST.get(action)
    lost = "it flies its mission on" if does is None else f"after {after_s:g} s {does}"
    told = f"if this link is lost, {lost} (NAV_DLL_ACT {action})"
    if RETURNS in lost:
        told += f", straight, at {has.get('RTL_RETURN_ALT', 60.0):g} m"
    out = int(has.get("GF_ACTION", 2))
    return told, f"beyond its fence it {PX4_OUT.get(out, 'does something')} (GF_ACTION {out})"
