"""Batteries as data sheets have them, in watts or by a preset, and the seconds that they come to.

Plans know batteries by the seconds that they last. A battery of C Wh lasts for C / P hours at P watts; what is told in
watt-hours or percent of it is that share of its seconds of driving.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from rota.errors import MissionError
from rota.model.battery_limits import ENDLESS, BatteryLimits, battery_faults
from rota.model.field_values import check_fields
from rota.model.fields import any_of, field_of
from rota.model.refusals import Where, path_of, require, show_value
from rota.vehicles.battery_presets import BATTERIES, HOUR_S

MOST_WH, MOST_W = 1e9, 1e9
POWERS = ("capacity_wh", "moving_w", "standing_w")  # of which a preset has its own
# by what of the block each of a battery's seconds is given; none may be given twice
TOLD_BY = {
    "endurance_s": ("preset", "moving_w"),
    "standing_endurance_s": ("preset", "standing_w"),
    "recharge_s": ("charging_w",),
    "reserve_s": ("reserve_percent",),
    "takeoff_s": ("takeoff_wh",),
}


@dataclass(frozen=True, kw_only=True)
class BatteryData:
    """A battery by its data sheet: a preset of a device, or what the battery holds and what is used of it.

    Energy in watt-hours, powers in watts. ``preset`` is one of ``battery_presets.BATTERIES`` and takes the place of
    ``capacity_wh``, ``moving_w`` and ``standing_w``; without one the first two are needed. Mission files have the same
    fields in ``battery``. ``limits`` is what a fleet, a robot or a kind takes::

        Fleet(speed_m_s=5, sensor=..., battery=BatteryData(capacity_wh=77, moving_w=103, charging_w=65).limits())

    Raises MissionError, with the field and what is allowed, for values that are not or that contradict each other.
    """

    preset: str | None = field_of(None, "a device with what its maker publishes")
    capacity_wh: float | None = field_of(None, "what a full battery holds", above=0, most=MOST_WH)
    moving_w: float | None = field_of(None, "used while it drives or flies along", above=0, most=MOST_W)
    standing_w: float | None = field_of(
        None,
        "used while it stands or hovers; null: as while it moves, or as standing_endurance_s says",
        above=0,
        most=MOST_W,
    )
    charging_w: float | None = field_of(
        None,
        "that comes into it at a charger; null: recharge_s or a preset tells how long it takes",
        above=0,
        most=MOST_W,
    )
    takeoff_wh: float | None = field_of(
        None,
        "that each departure from a charger costs, with its climb and its landing",
        title="take-off and landing",
        least=0,
        most=MOST_WH,
    )
    reserve_percent: float | None = field_of(None, "of it that must always be left", least=0, below=100)

    def __post_init__(self) -> None:
        check_fields(self, "battery.")
        known = self.preset is None or self.preset in BATTERIES
        require(known, "battery.preset", self.preset, f"{any_of(BATTERIES)} is needed")
        for where, message in battery_rules(vars(self)):
            raise MissionError(f"battery.{path_of(where)}: {message}")

    def limits(self, **seconds: float) -> BatteryLimits:
        """The same battery in seconds of driving, as plans know it: C Wh last for C / P hours at P watts.

        seconds: fields of ``BatteryLimits`` that the data sheet does not tell, such as ``recharge_s``, also in place of
        a preset's, or ``standing_endurance_s=0`` for a wing. Raises MissionError where they are told twice, and where
        nothing of the battery is left beside its reserve and a take-off.
        """
        for where, message in seconds_beside_watts({"battery": vars(self), **seconds}):
            raise MissionError(f"{path_of(where)}: {message}")
        found = {name: each for name, each in seconds_of(vars(self)).items() if name not in seconds}
        values = vars(ENDLESS) | {name: each.value for name, each in found.items()} | seconds
        for name, allowed in battery_faults(values):
            told = f"battery.{found[name].key}: its {name} of " if name in found else f"{name}: "
            raise MissionError(f"{told}{show_value(values[name])} is not allowed; it {allowed}")
        return BatteryLimits(**values)


class Seconds(NamedTuple):
    """Seconds of a battery, and the key that they follow from."""

    value: float
    key: str


def seconds_of(data: Mapping[str, Any]) -> dict[str, Seconds]:
    """What a block of ``BatteryData`` without faults comes to, by the names of ``BatteryLimits``."""
    preset = BATTERIES.get(data.get("preset") or "")
    known: dict[str, Any] = {name: value for name, value in data.items() if value is not None}
    capacity_wh = preset.capacity_wh.value if preset else known["capacity_wh"]
    moving_s = preset.moving_s.value if preset else HOUR_S * capacity_wh / known["moving_w"]
    found = {"endurance_s": Seconds(moving_s, "preset" if preset else "moving_w")}
    published = {"standing_endurance_s": preset.standing_s, "recharge_s": preset.charging_s} if preset else {}
    found |= {name: Seconds(fact.value, "preset") for name, fact in published.items() if fact is not None}
    for name, key in (("standing_endurance_s", "standing_w"), ("recharge_s", "charging_w")):
        if key in known:
            found[name] = Seconds(HOUR_S * capacity_wh / known[key], key)
    if "takeoff_wh" in known:
        found["takeoff_s"] = Seconds(moving_s * known["takeoff_wh"] / capacity_wh, "takeoff_wh")
    if "reserve_percent" in known:
        found["reserve_s"] = Seconds(moving_s * known["reserve_percent"] / 100, "reserve_percent")
    return found


def battery_rules(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """A preset beside what it has itself, and neither a preset nor what takes its place."""
    if data.get("preset") is not None:
        for name in POWERS:
            if data.get(name) is not None:
                yield (name,), "given beside preset, which says it: remove one of them"
        return
    for name in POWERS[:2]:
        if data.get(name) is None:
            yield (name,), f"is missing; give it, or a preset: {any_of(BATTERIES)}"


def seconds_beside_watts(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Seconds of a battery that its block ``battery`` gives as well, of a fleet, a robot or a kind."""
    battery = data["battery"] if isinstance(data.get("battery"), dict) else {}
    for name, keys in TOLD_BY.items():
        told = next((key for key in keys if battery.get(key) is not None), None)
        if told and data.get(name) is not None:
            yield (name,), f"given beside battery.{told}, of which it follows: remove one of them"
