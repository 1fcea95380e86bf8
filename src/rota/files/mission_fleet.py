"""A mission file's fleet: what is given, what its vehicles have by default, and what does not go together."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from rota.files.blocks import Fault, make
from rota.files.mission_schema import DRIVING
from rota.files.yaml_text import Place
from rota.model.battery_limits import BATTERY_FIELDS, battery_faults
from rota.model.fields import REQUIRED, fields_of, flat_fields_of
from rota.model.fleet import KINDS_NEED_FEWEST, NO_POINTS_FOR_KINDS, TURNS_ONE_WAY, Abilities, Fleet, Kind, Robot
from rota.model.motion_limits import AT_ONCE, NEED_MASS, driving_faults, motion_faults
from rota.model.refusals import refusal, show_value
from rota.vehicles.battery_data import seconds_of
from rota.vehicles.facts import Vehicle
from rota.vehicles.presets import NONE, VEHICLES

FLEET: Place = ("fleet",)
TURNING = ("turn_rate_rad_s", "turn_radius_m")
ABLE = flat_fields_of(Abilities)
# of which null says no more than leaving them out
AS_NOTHING = {item.name for item in ABLE if not (item.optional or item.empty)} | {"vehicle"}
# from the fleet unless a robot's vehicle presets them
NOT_OF_VEHICLES = (*(item.name for item in fields_of(Abilities) if not item.flat), "wind_m_s", *BATTERY_FIELDS)
USUAL_ALTITUDE_M: float = next(item.default for item in fields_of(Fleet) if item.name == "altitude_m")
Values = dict[str, Any]  # of a block of the file, those that are given, by their names


@dataclass(frozen=True, kw_only=True)
class Driving:
    """What a robot can do: the values of ``DRIVING``, None where there is none, and where in the file each stands.

    said: which of them the block gives itself, or its fleet. altitude_m: how high its fleet flies.
    """

    values: dict[str, Any]
    places: dict[str, Place]
    said: frozenset[str]
    altitude_m: float

    @property
    def vehicle(self) -> Vehicle:
        """The vehicle that it is; the one without limits where none is named."""
        return VEHICLES[self.values["vehicle"] or NONE.name]


def listed_robots(block: Values) -> tuple[Values, ...]:
    """The robots of a fleet's block that are listed."""
    robots = block.get("robots")
    return robots if isinstance(robots, tuple) else ()


def fleet_of(block: Values) -> Fleet:
    """The fleet, still without starts and entrances; ``fleet_faults`` finds nothing in the block."""
    common = _driving(block, FLEET, None)
    robots: Any = block.get("robots", "fewest")
    if isinstance(robots, tuple):
        robots = [_able(Robot, robot, common) for robot in robots]
    kinds = [_able(Kind, kind, common) for kind in block.get("kinds", ())]
    return make(Fleet, **{**_without_places(block), "robots": robots, "kinds": kinds}, **common.values)


def _able(made: type[Any], block: Values, common: Driving) -> Any:
    """A listed robot or a kind, with what it has from its fleet."""
    return make(made, **_without_places(block), **_driving(block, FLEET, common).values)


def _without_places(block: Values) -> Values:
    """What a block gives beside what robots can do, without places, which are not in metres yet."""
    return {
        name: value
        for name, value in block.items()
        if name not in (*DRIVING, "battery", "start", "entrances", "rally_points")
    }


def _driving(block: Values, place: Place, common: Driving | None) -> Driving:
    """What a block gives, then what its vehicle or its battery has by default, then what the fleet has, ``common``.

    A robot that names a vehicle has nothing from the fleet's vehicle, and one that has a ``battery`` nothing from the
    fleet's. Null says that there is no limit.
    """
    said = {name: block[name] for name in DRIVING if name in block}
    given = {name: value for name, value in said.items() if value is not None or name not in AS_NOTHING}
    vehicle = VEHICLES[given.get("vehicle") or NONE.name]
    values: Values = {item.name: None if item.default is REQUIRED else item.default for item in ABLE}
    places = {name: (*place, name) for name in DRIVING}
    if common is not None:
        kept: Iterable[str] = NOT_OF_VEHICLES if "vehicle" in given else DRIVING
        kept = [name for name in kept if not (block.get("battery") and name in BATTERY_FIELDS)]
        values |= {name: common.values[name] for name in kept}
        places |= {name: common.places[name] for name in kept}
    preset = vehicle.preset(DRIVING)
    for name, other in (TURNING, TURNING[::-1]):
        if given.get(name):
            preset.pop(other, None)
    battery = seconds_of(block["battery"]) if block.get("battery") else {}
    values |= preset | {name: seconds.value for name, seconds in battery.items()} | given
    places |= {name: (*place, "vehicle") for name in preset}
    places |= {name: (*place, "battery", seconds.key) for name, seconds in battery.items()}
    places |= {name: (*place, name) for name in given}
    if values["vehicle"] == NONE.name:
        values["vehicle"] = None
    if values["acceleration_m_s2"] is None:
        values |= {name: getattr(AT_ONCE, name) for name in NEED_MASS if not given.get(name)}
    values |= {item.name: item.default for item in ABLE if item.empty and values[item.name] is None}
    top = values["top_airspeed_m_s"]
    if "speed_m_s" in preset and "speed_m_s" not in given and top is not None and values["wind_m_s"] < top:
        values["speed_m_s"] = min(values["speed_m_s"], top - values["wind_m_s"])
    banks = VEHICLES[values["vehicle"] or NONE.name].preset(("turn_radius_m", "speed_m_s"))
    if len(banks) > 1 and places["turn_radius_m"][-1] == "vehicle":
        # banked as far as it may be, it turns on arcs that grow as the square of its speed
        values["turn_radius_m"] = banks["turn_radius_m"] * (values["speed_m_s"] / banks["speed_m_s"]) ** 2
    told = frozenset(given) | (common.said if common is not None else frozenset())
    altitude_m = block.get("altitude_m", USUAL_ALTITUDE_M) if common is None else common.altitude_m
    firmware = VEHICLES[values["vehicle"] or NONE.name]
    for name, takes_s in (("landing_s", firmware.landing_s), ("climbing_s", firmware.climbing_s)):
        if name not in told:
            values[name] = takes_s(altitude_m) if values["endurance_s"] is not None else 0.0
            places[name] = (*place, "vehicle") if values[name] and "vehicle" in given else places[name]
    return Driving(values=values, places=places, said=told, altitude_m=altitude_m)


# ---------------------------------------------------------------- faults


def fleet_faults(block: Values) -> list[Fault]:
    """Names given twice, and speeds, turns, limits and vehicles that do not go together, each where it stands."""
    faults = list(_name_faults(block))
    faults += [fault for driving in _each(block) for fault in _driving_faults(driving)]
    return list(dict.fromkeys(faults))  # what robots have from their fleet is told once


def fleet_warnings(block: Values) -> list[Fault]:
    """Vehicles of which no source tells what their mass allows, and wind that changes nothing."""
    unknown = [
        one for one in _each(block) if one.vehicle.acceleration_unknown and one.values["acceleration_m_s2"] is None
    ]
    message = "no source tells its acceleration; without acceleration_m_s2 it is planned to change speed at once"
    found = [Fault(one.places["vehicle"], message) for one in unknown]
    idle = "changes nothing without top_airspeed_m_s, the speed through the air that it is taken from"
    for one in _each(block):
        if one.values["wind_m_s"] and one.values["top_airspeed_m_s"] is None:
            found.append(Fault(one.places["wind_m_s"], f"{_whose('wind_m_s', one.places['wind_m_s'])}{idle}"))
    return list(dict.fromkeys(found))


def _each(block: Values) -> Iterator[Driving]:
    """How the fleet drives, and each of its listed robots."""
    common = _driving(block, FLEET, None)
    yield common
    for key, listed in _lists(block):
        for k, one in enumerate(listed):
            yield _driving(one, (*FLEET, key, k), common)


def _lists(block: Values) -> tuple[tuple[str, tuple[Values, ...]], ...]:
    """What a fleet's block lists one by one: robots, and kinds of them."""
    return ("robots", listed_robots(block)), ("kinds", block.get("kinds", ()))


def _name_faults(block: Values) -> Iterator[Fault]:
    """Names given twice, and kinds beside a number of robots or points to start at."""
    for key, listed in _lists(block):
        names = [one["name"] for one in listed]
        first = {name: k for k, name in reversed(list(enumerate(names)))}
        for k, name in enumerate(names):
            if first[name] < k:
                message = f"{name!r} is the name of another {key[:-1]}; names must be unique"
                yield Fault((*FLEET, key, k, "name"), message)
    if block.get("kinds") and block.get("robots", "fewest") != "fewest":
        yield Fault((*FLEET, "robots"), f"given beside kinds; {KINDS_NEED_FEWEST}")
    if block.get("kinds") and getattr(block.get("start"), "points", None):
        yield Fault((*FLEET, "start"), NO_POINTS_FOR_KINDS)


def _driving_faults(driving: Driving) -> Iterator[Fault]:
    """What does not go together of one robot, or of what a fleet has in common."""
    values, places, vehicle = driving.values, driving.places, driving.vehicle
    for item in ABLE:
        for _, _, wrong in item.faults(values[item.name], True) if "battery" in places[item.name] else ():
            message = refusal(wrong.kind, values[item.name], wrong.given)
            yield Fault(places[item.name], f"{_whose(item.name, places[item.name])}{message}")
    found = list(motion_faults(values)) or list(driving_faults(values))
    found += battery_faults(values)
    for name, allowed in found:
        yield Fault(
            places[name],
            f"{_whose(name, places[name])}{show_value(values[name])} is not allowed; it {allowed}",
        )
    if values["turn_radius_m"] and values["turn_rate_rad_s"] is not None:
        yield Fault(
            places["turn_radius_m"], f"{show_value(values['turn_radius_m'])} is not allowed; it {TURNS_ONE_WAY}"
        )
    top = vehicle.top_speed_m_s
    if top is not None and values["speed_m_s"] > top.value:
        allowed = f"{vehicle.name} drives at most {top.value:.6g} m/s ({top.parameter}; {top.source})"
        yield Fault(places["speed_m_s"], f"{show_value(values['speed_m_s'])} is not allowed; {allowed}")
    if vehicle.formats and vehicle.jerk_m_s3 is not None and values["jerk_m_s3"] is not None:
        own = f"its firmware's ({vehicle.jerk_m_s3.parameter}) in the mean, and at corners exceeds it"
        message = f"is not allowed; {vehicle.name} keeps {own}: leave it out, or the vehicle"
        yield Fault(places["jerk_m_s3"], f"{show_value(values['jerk_m_s3'])} {message}")
    if not vehicle.flies:
        for name in ("climb_m_s", "descend_m_s", "top_airspeed_m_s"):
            if values[name] is not None:
                yield Fault(places[name], f"{vehicle.name} keeps to the floor: remove it")


def _whose(name: str, place: Place) -> str:
    """A value's name where the place is another's, as a vehicle's is."""
    return "" if place[-1] == name else f"its {name} of "
