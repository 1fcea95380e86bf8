"""The commented mission that ``rota new`` writes: values of an example beside what each field is declared to mean."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import Any

from rota.files.blocks import Block
from rota.files.mission_schema import mission_block
from rota.files.mission_text import value_in_a_line
from rota.files.shape_schema import SHAPE_KEYS
from rota.model.fields import REQUIRED, Field, any_of
from rota.model.planner_registry import DEFAULT, planner_names

HEAD = """\
# A mission for Rota. Plan it with:   rota plan THIS_FILE
# Lengths are metres, times seconds, speeds metres per second. Paths of files start at the folder of this file.
# What stands behind a # may be said, too. rota schema mission says of all planners what they take.
"""
COMMENT_FROM, LATEST_COMMENT, LONGEST_LINE = 38, 78, 116
SHOWN: dict[str, Any] = {
    "rota": 1,
    "name": "my-mission",
    "coordinates": "metres",
    "area": [[0, 0], [80, 0], [80, 60], [50, 60], [50, 40], [0, 40]],
    "obstacles": [
        [[20, 12], [32, 12], [32, 20], [20, 20]],
        {"circle": {"centre": [60, 25], "radius_m": 3}, "blocks": "motion"},
    ],
    "zones": [
        {"name": "gate", "period_s": 20, "ring": [[65, 45], [80, 45], [80, 60], [65, 60]]},
        {"name": "tank", "period_s": 30, "circle": {"centre": [8, 8], "radius_m": 6}},
    ],
    "period_s": 60,
    "unseeable": "exclude",
    "fleet": {
        "robots": "fewest", "vehicle": "arducopter-tuned", "speed_m_s": 8, "sensor": {"shape": "disc", "radius_m": 8},
        "body_radius_m": 0, "altitude_m": 15,
    },
    "planner": DEFAULT,
    DEFAULT: {"effort": "normal", "method": "tours"},
}  # fmt: skip
# of fields that the example leaves out
INSTEAD: dict[str, Any] = {
    "outer": [[0, 0], [80, 0], [80, 60]], "holes": [[[9, 9], [12, 9], [12, 12]]],
    "circle": {"centre": [40, 30], "radius_m": 30}, "wkt": "POLYGON ((0 0, 80 0, 80 60, 0 0))",
    "geojson": "parcel.geojson", "feature": "north", "map": "depot.yaml", "inside": [3, 4], "unknown": "blocked",
    "close_gaps_m": 0.15, "text": "..#.", "cell_m": 0.5, "graph": "warehouse-lanes.json", "width_m": 2,
    "place": "gate", "lanes": [{"line_m": [[0, 0], [9, 0]], "one_way": True}],
    "origin": {"lat": 48.1, "lon": 11.5}, "entrances": [[2, 2]],
    "rally_points": [[2, 2]], "box": [[0, 0], [5, 5]], "points": [[1, 1], [2, 1]], "start": [1, 1], "name": "it",
    "side_m": 16, "half_angle_deg": 30,
    "importance": 1, "black": 0, "white": 10, "low_m": [0, 0], "step_m": [40, 30], "values": [[1, 2, 1], [1, 9, 1]],
    "leaves_s": 900, "endurance_s": 1200, "standing_endurance_s": 1500, "recharge_s": 2400, "swap_s": 90,
    "preset": "dji-mavic-3e", "capacity_wh": 77, "moving_w": 103, "standing_w": 122, "charging_w": 65, "takeoff_wh": 2,
    "reserve_percent": 20,
    "chargers": [{"name": "pad", "at": [2, 2], "places": 4}],
    "moving_obstacles": [{"radius_m": 1, "times_s": [0, 9], "positions_m": [[0, 0], [9, 0]]}],
}  # fmt: skip


def example_mission_text() -> str:
    """A valid mission file in YAML with every field of missions, zones, fleets and robots, and what each means."""
    return HEAD + "\n".join(_lines(mission_block({}), SHOWN, "")) + "\n"


def _lines(block: Block, shown: dict[str, Any], indent: str) -> Iterator[str]:
    """The lines of a block: fields with their values, those that are left out behind a #."""
    for item in sorted(block.fields, key=lambda each: each.name != "robots"):
        inner, value = _inner(item), shown.get(item.name)
        if item.name not in shown:
            if item.name not in planner_names():
                yield from _leave_out(item, indent)
            continue
        if isinstance(value, dict) and inner is not None and "shape" not in value:
            yield from ["", *_with_comment(f"{indent}{item.name}:", item.meaning)]
            yield from _lines(inner, value, indent + "  ")
            continue
        if isinstance(value, list) and isinstance(value[0], dict | list) and inner is not None and item.kind == "list":
            yield from ["", *_with_comment(f"{indent}{item.name}:", item.meaning)]
            yield from (f"{indent}  - {value_in_a_line(entry)}" for entry in value)
        else:
            yield from _with_comment(f"{indent}{item.name}: {value_in_a_line(value)}", _meaning(item))
        if inner is not None:
            yield from _choices(item, inner, indent + "  ", value)


def _choices(item: Field, inner: Block, indent: str, value: Any) -> Iterator[str]:
    """What a block may hold beside its value in the example, or in place of that, behind a #."""
    entries = value if item.kind == "list" else [value]
    known = set.intersection(*(set(entry if isinstance(entry, dict) else ()) for entry in entries))
    known |= set(SHAPE_KEYS if item.kind == "list" else ("ring",))
    if item.kind == "either" and not isinstance(value, dict):
        yield f"{indent}# {'of each in a list' if item.name == 'robots' else 'or a block of'}:"
    for each in inner.fields:
        if each.name not in known and not each.as_fleet:
            yield from _leave_out(each, indent)


def _leave_out(item: Field, indent: str) -> Iterator[str]:
    """A field behind a #, with its default or another value."""
    usual, inner = None if item.default is REQUIRED else item.default, _inner(item)
    value = INSTEAD.get(item.name, usual) if usual in (None, ()) else usual
    if inner is not None and inner.settings is not None:
        yield from _with_comment(f"{indent}# {item.name}:", inner.meaning.replace("``", ""))
    elif inner is not None and item.kind == "block" and not isinstance(value, dict):
        yield from _with_comment(f"{indent}# {item.name}:", _meaning(item))
        yield from _choices(item, inner, indent + "  ", value)
    else:
        yield from _with_comment(f"{indent}# {item.name}: {value_in_a_line(value)}", _meaning(item))
        yield from _choices(item, inner, indent + "  ", value) if inner is not None and item.kind == "either" else ()


def _meaning(item: Field) -> str:
    """What a field means, and what it may be where that is one of several words."""
    words = [str(option) for option in item.options]
    named = any_of(words) if len(words) > 1 and any(word not in item.meaning for word in words) else ""
    return ": ".join(part for part in (named, item.meaning) if part)


def _inner(item: Field) -> Block | None:
    """The block that a field is, may be, or has entries of."""
    for each in (item, *item.choices, *(one.item for one in (item, *item.choices) if one.item is not None)):
        for one in (each, *each.choices):
            if isinstance(one.block, Block):
                return one.block
    return None


def _with_comment(line: str, comment: str) -> list[str]:
    """A line with a comment behind it, in lines of its own where it is long."""
    if not comment:
        return [line]
    first = max(COMMENT_FROM, len(line) + 2)
    if first > LATEST_COMMENT:
        indent = line[: len(line) - len(line.lstrip(" "))]
        return [*(f"{indent}# {part}" for part in textwrap.wrap(comment, LONGEST_LINE - len(indent))), line]
    parts = textwrap.wrap(comment, LONGEST_LINE - first)
    return [line.ljust(first) + f"# {parts[0]}", *(" " * first + f"# {part}" for part in parts[1:])]
