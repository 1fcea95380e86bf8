"""What a mission file's ``battery`` says as data sheets do, in watts or by a preset, and the seconds that it comes to.

Plans know batteries by the seconds that they last. A battery of C Wh lasts for C / P hours at P watts; what is told in
watt-hours or percent of it is that share of its seconds of driving.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from rota.model.fields import any_of, field_of
from rota.model.refusals import Where
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
    """A battery by its data sheet: a preset, or what it holds and what is used of it."""

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


class Seconds(NamedTuple):
    """Seconds of a battery, and the key that they follow from."""

    value: float
    key: str


def seconds_of(data: dict[str, Any]) -> dict[str, Seconds]:
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


def battery_rules(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """A preset beside what it has itself, and neither a preset nor what takes its place."""
    if data.get("preset") is not None:
        for name in POWERS:
            if data.get(name) is not None:
                yield (name,), "given beside preset, which says it: remove one of them"
        return
    for name in POWERS[:2]:
        if data.get(name) is None:
            yield (name,), f"is missing; give it, or a preset: {any_of(BATTERIES)}"


def seconds_beside_watts(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    """Seconds of a battery that its block ``battery`` gives as well, of a fleet, a robot or a kind."""
    battery = data["battery"] if isinstance(data.get("battery"), dict) else {}
    for name, keys in TOLD_BY.items():
        told = next((key for key in keys if battery.get(key) is not None), None)
        if told and data.get(name) is not None:
            yield (name,), f"given beside battery.{told}, of which it follows: remove one of them"
