"""What docs/usage.md says of fields, made of their declarations: ``python -m docs.field_tables`` writes it anew."""

from __future__ import annotations

import re
from pathlib import Path

from rota.files.example_mission import example_mission_text
from rota.files.mission_schema import DRIVING
from rota.model.batteries import Charger
from rota.model.battery_limits import BatteryLimits
from rota.model.fields import any_of, fields_of
from rota.model.fleet import Abilities, Kind
from rota.model.mission import DiscSensor, Zone
from rota.model.motion_limits import MotionLimits
from rota.vehicles.battery_data import BatteryData
from rota.vehicles.battery_presets import BATTERIES
from rota.vehicles.facts import Fact, Vehicle
from rota.vehicles.presets import VEHICLES

PAGE = Path(__file__).with_name("usage.md")
PART = re.compile(r"(<!-- (\w+): python -m docs\.field_tables -->\n).*?(<!-- end -->)", re.S)


def with_fields(page: str) -> str:
    """The page's text with its parts about fields as they are declared."""
    parts = {
        "mission": mission_part, "motion": motion_part, "batteries": batteries_part, "presets": presets_part,
        "kinds": kinds_part, "vehicles": vehicles_part,
    }  # fmt: skip
    return PART.sub(lambda found: found[1] + "\n" + parts[found[2]]() + "\n" + found[3], page)


def mission_part() -> str:
    """What `rota new` writes."""
    return f"```yaml\n{example_mission_text()}```\n"


def motion_part() -> str:
    """A row for each limit of motion."""
    vehicles = any_of(f"`{name}`" for name in VEHICLES)
    rows = [
        f"| `{item.name}` | {item.unit} | {vehicles if item.name == 'vehicle' else ''}{'; ' * (item.name == 'vehicle')}"
        f"{item.meaning} |"
        for item in fields_of(MotionLimits)
    ]
    return "\n".join(["| key | unit | meaning |", "|---|---|---|", *rows, ""])


def batteries_part() -> str:
    """A row for each field of batteries, by data sheets and in seconds, then of chargers."""
    rows = [
        f"| `{prefix}{item.name}` | {item.unit} | {item.meaning} |"
        for prefix, block in (("fleet.battery.", BatteryData), ("fleet.", BatteryLimits), ("chargers[].", Charger))
        for item in fields_of(block)
    ]
    return "\n".join(["| key | unit | meaning |", "|---|---|---|", *rows, ""])


def presets_part() -> str:
    """A row for each preset of a battery, with where its figures are from."""
    rows = []
    for each in BATTERIES.values():
        facts = [each.capacity_wh, each.moving_s, each.standing_s, each.charging_s]
        cells = [f"{each.capacity_wh.value:g}", *("" if fact is None else f"{fact.value:g}" for fact in facts[1:])]
        told = "; ".join(fact.parameter for fact in facts if fact is not None)
        rows.append(f"| `{each.name}` | {each.told} | {' | '.join(cells)} | {each.capacity_wh.source}: {told} |")
    head = ["| preset | robot | Wh | moving s | standing s | charging s | from |", "|---|---|---|---|---|---|---|"]
    return "\n".join([*head, *rows, ""])


def kinds_part() -> str:
    """A row for each field of kinds that robots do not have, and for those by which sensors count."""
    able = {item.name for item in fields_of(Abilities)}
    told = [("fleet.kinds[].", item) for item in fields_of(Kind) if item.name not in able]
    told += [("fleet.sensor.", item) for item in fields_of(DiscSensor) if item.name == "name"]
    told += [("zones[].", item) for item in fields_of(Zone) if item.name == "sensors"]
    rows = [f"| `{prefix}{item.name}` | {item.meaning} |" for prefix, item in told]
    return "\n".join(["| key | meaning |", "|---|---|", *rows, ""])


def vehicles_part() -> str:
    """A row for each vehicle that presets something, with where its values are from."""
    told = [name for name in DRIVING if any(name in each.preset(DRIVING) for each in VEHICLES.values())]
    head = ["vehicle", *(f"`{name}`" for name in told), "at most", "from"]
    rows = [_vehicle_row(each, told) for each in VEHICLES.values() if each.preset(DRIVING)]
    return "\n".join([f"| {' | '.join(head)} |", "|---" * len(head) + "|", *rows, ""])


def _vehicle_row(vehicle: Vehicle, told: list[str]) -> str:
    """What a vehicle presets, its greatest speed, and the sources of these values."""
    preset, top = vehicle.preset(told), vehicle.top_speed_m_s
    sources: dict[str, list[str]] = {}
    for name in (*preset, "top_speed_m_s"):
        if isinstance(fact := getattr(vehicle, name), Fact) and fact.parameter not in sources.get(fact.source, []):
            sources.setdefault(fact.source, []).append(fact.parameter)
    cells = [f"{preset[name]:g}" if name in preset else "" for name in told] + [f"{top.value:g} m/s" if top else ""]
    origins = "; ".join(f"{source}: {', '.join(names)}" for source, names in sources.items())
    return f"| `{vehicle.name}` | {' | '.join(cells)} | {origins} |"


def main() -> None:
    """Write the page."""
    PAGE.write_text(with_fields(PAGE.read_text()))


if __name__ == "__main__":
    main()
