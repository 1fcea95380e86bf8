"""A mission file's fleet: what is given, what its vehicles have by default, and what does not go together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from rota.files.mission_schema import FleetBlock, RobotBlock, SensorBlock
from rota.files.motion_schema import DRIVING
from rota.files.schema_faults import Fault
from rota.files.yaml_text import Place
from rota.model.fleet import TURNS_ONE_WAY, DiscSensor, Fleet, Robot, Sensor, SquareSensor
from rota.model.motion_limits import AT_ONCE, MOTION_FIELDS, NEED_MASS, MotionLimits, driving_faults, motion_faults
from rota.model.refusals import shown
from rota.vehicles.facts import Vehicle
from rota.vehicles.presets import NONE, VEHICLES

FLEET: Place = ("fleet",)
TURNING = ("turn_rate_rad_s", "turn_radius_m")
AS_NOTHING = {"speed_m_s", "turn_radius_m", "vehicle"}  # of which null says no more than leaving them out
NOT_OF_VEHICLES = ("speed_m_s", *TURNING, "wind_m_s")  # from the fleet unless a robot's vehicle presets them


@dataclass(frozen=True, kw_only=True)
class Driving:
    """How a robot drives: the values of ``DRIVING``, None where there is none, and where in the file each stands."""

    values: dict[str, Any]
    places: dict[str, Place]

    @property
    def vehicle(self) -> Vehicle:
        """The vehicle that it is; the one without limits where none is named."""
        return VEHICLES[self.values["vehicle"] or NONE.name]

    @property
    def motion(self) -> MotionLimits:
        """Its limits of motion."""
        given = {name: self.values[name] for name in MOTION_FIELDS if self.values[name] is not None}
        return MotionLimits(**given)


def fleet_of(block: FleetBlock) -> Fleet:
    """The fleet, still without starts and entrances; ``fleet_faults`` finds nothing in the block."""
    driving = _driving(block, FLEET, None)
    fleet = Fleet(
        sensor=sensor_of(block.sensor),
        body_radius_m=block.body_radius_m,
        altitude_m=block.altitude_m,
        **_driven(driving),
    )
    if isinstance(block.robots, int):
        robots = [fleet.equal_robot(f"robot-{k + 1}") for k in range(block.robots)]
    elif isinstance(block.robots, list):
        robots = [_robot(fleet, robot, _driving(robot, FLEET, driving)) for robot in block.robots]
    else:
        return fleet
    return replace(fleet, robots=tuple(robots))


def _robot(fleet: Fleet, block: RobotBlock, driving: Driving) -> Robot:
    return Robot(
        name=block.name,
        sensor=sensor_of(block.sensor) if block.sensor is not None else fleet.sensor,
        body_radius_m=block.body_radius_m if block.body_radius_m is not None else fleet.body_radius_m,
        joins_s=block.joins_s,
        leaves_s=block.leaves_s,
        **_driven(driving),
    )


def _driven(driving: Driving) -> dict[str, Any]:
    """The fields of a fleet or a robot that say how it drives."""
    values = driving.values
    return {name: values[name] for name in ("speed_m_s", *TURNING)} | {"motion": driving.motion}


def sensor_of(block: SensorBlock) -> Sensor:
    """The sensor that a block describes."""
    if block.radius_m is not None:
        return DiscSensor(radius_m=block.radius_m, half_angle_deg=block.half_angle_deg)
    assert block.side_m is not None
    return SquareSensor(side_m=block.side_m)


def _driving(block: FleetBlock | RobotBlock, place: Place, common: Driving | None) -> Driving:
    """What a block gives, then what its vehicle has by default, then what the fleet has, ``common``.

    A robot that names a vehicle has nothing from the fleet's vehicle. Null says that there is no limit.
    """
    given = {
        name: getattr(block, name)
        for name in DRIVING
        if name in block.model_fields_set and (getattr(block, name) is not None or name not in AS_NOTHING)
    }
    vehicle = VEHICLES[given.get("vehicle") or NONE.name]
    values: dict[str, Any] = {name: None for name in DRIVING} | {"turn_radius_m": 0.0, "corner_m": 0.0, "wind_m_s": 0.0}
    places = {name: (*place, name) for name in DRIVING}
    if common is not None:
        kept = NOT_OF_VEHICLES if "vehicle" in given else DRIVING
        values |= {name: common.values[name] for name in kept}
        places |= {name: common.places[name] for name in kept}
    preset = vehicle.preset(DRIVING)
    for name, other in (TURNING, TURNING[::-1]):
        if given.get(name):
            preset.pop(other, None)
    values |= preset | given
    places |= {name: (*place, "vehicle") for name in preset} | {name: (*place, name) for name in given}
    if values["vehicle"] == NONE.name:
        values["vehicle"] = None
    if values["acceleration_m_s2"] is None:
        values |= {name: getattr(AT_ONCE, name) for name in NEED_MASS if not given.get(name)}
    values |= {name: 0.0 for name in ("corner_m", "wind_m_s") if values[name] is None}
    top = values["top_airspeed_m_s"]
    if "speed_m_s" in preset and "speed_m_s" not in given and top is not None and values["wind_m_s"] < top:
        values["speed_m_s"] = min(values["speed_m_s"], top - values["wind_m_s"])
    banks = VEHICLES[values["vehicle"] or NONE.name].preset(("turn_radius_m", "speed_m_s"))
    if len(banks) > 1 and places["turn_radius_m"][-1] == "vehicle":
        # banked as far as it may be, it turns on arcs that grow as the square of its speed
        values["turn_radius_m"] = banks["turn_radius_m"] * (values["speed_m_s"] / banks["speed_m_s"]) ** 2
    return Driving(values=values, places=places)


# ---------------------------------------------------------------- faults


def fleet_faults(block: FleetBlock) -> list[Fault]:
    """Names given twice, and speeds, turns, limits and vehicles that do not go together, each where it stands."""
    faults = list(_name_faults(block))
    faults += [fault for driving in _each(block) for fault in _driving_faults(driving)]
    return list(dict.fromkeys(faults))  # what robots have from their fleet is told once


def fleet_warnings(block: FleetBlock) -> list[Fault]:
    """Vehicles of which no source tells what their mass allows."""
    unknown = [
        one for one in _each(block) if one.vehicle.acceleration_unknown and one.values["acceleration_m_s2"] is None
    ]
    message = "no source tells its acceleration; without acceleration_m_s2 it is planned to change speed at once"
    return list(dict.fromkeys(Fault(one.places["vehicle"], message) for one in unknown))


def _each(block: FleetBlock) -> Iterator[Driving]:
    """How the fleet drives, and each of its listed robots."""
    common = _driving(block, FLEET, None)
    yield common
    for k, robot in enumerate(block.robots if isinstance(block.robots, list) else []):
        yield _driving(robot, (*FLEET, "robots", k), common)


def _name_faults(block: FleetBlock) -> Iterator[Fault]:
    names = [robot.name for robot in block.robots] if isinstance(block.robots, list) else []
    first = {name: k for k, name in reversed(list(enumerate(names)))}
    for k, name in enumerate(names):
        if first[name] < k:
            message = f"{name!r} is the name of another robot; names must be unique"
            yield Fault((*FLEET, "robots", k, "name"), message)


def _driving_faults(driving: Driving) -> Iterator[Fault]:
    """What does not go together of one robot, or of what a fleet has in common."""
    values, places, vehicle = driving.values, driving.places, driving.vehicle
    found = list(motion_faults(values)) or list(driving_faults(values))
    for name, allowed in found:
        yield Fault(places[name], f"{_named(name, places[name])}{shown(values[name])} is not allowed; it {allowed}")
    if values["turn_radius_m"] and values["turn_rate_rad_s"] is not None:
        yield Fault(places["turn_radius_m"], f"{shown(values['turn_radius_m'])} is not allowed; it {TURNS_ONE_WAY}")
    top = vehicle.top_speed_m_s
    if top is not None and values["speed_m_s"] > top.value:
        allowed = f"{vehicle.name} drives at most {top.value:.6g} m/s ({top.parameter}; {top.source})"
        yield Fault(places["speed_m_s"], f"{shown(values['speed_m_s'])} is not allowed; {allowed}")
    if not vehicle.flies:
        for name in ("climb_m_s", "descend_m_s", "top_airspeed_m_s"):
            if values[name] is not None:
                yield Fault(places[name], f"{vehicle.name} keeps to the floor: remove it")


def _named(name: str, place: Place) -> str:
    """A value's name where the place is another's, as a vehicle's is."""
    return "" if place[-1] == name else f"its {name} of "
