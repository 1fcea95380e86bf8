"""What has changed in a mission since a plan was made of it, in words: "area period 180 → 60 s"."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rota.files.shape_schema import Area
from rota.model.field_values import Json
from rota.model.fields import UNITS, fields_of, unit_of
from rota.model.planner_registry import planner_names

# names change nothing of a plan; lists show the planner of each plan
_NO_CHANGE = ("rota", "name", "planner")
_SEARCH_ONLY = ("patrol",)  # its settings say how to search; what a plan of it must hold stands outside of them
_SHAPE = tuple(item.name for item in fields_of(Area))
_SINGLE = {"zones": "zone", "obstacles": "obstacle", "moving_obstacles": "moving obstacle", "lanes": "lane"}
_WORDS = {"period_s": "area period", "importance": "importance of the ground"}


def changes(
    before: Json,
    after: Json,
    files_before: Mapping[str, str] | None = None,
    files_after: Mapping[str, str] | None = None,
) -> list[str]:
    """What differs between two documents, and between the digests of their files; nothing where a plan still holds.

    What is missing counts as what is empty, null or 0. Entries of lists are matched by their names, others by what they
    are. The planner, its search settings, its effort and all names are left out.
    """
    planner = before.get("planner")
    skipped = {*_NO_CHANGE, *_SEARCH_ONLY, *(name for name in planner_names() if name != planner)}
    keys = [key for key in {**before, **after} if key not in skipped]
    told = [line for key in keys for line in _of_key(key, before.get(key), after.get(key))]
    old, new = files_before or {}, files_after or {}
    return told + [f"file {name} has other content" for name in old if name in new and old[name] != new[name]]


def _of_key(key: str, before: Any, after: Any) -> Iterator[str]:
    """The differences under a key of the document."""
    if key == "area":
        if not _same(before, after):
            yield "area shape"
    elif key in _SINGLE:
        yield from _of_entries(_SINGLE[key], _list(before), _list(after))
    else:
        yield from _of_value(_WORDS.get(key) or _words(key), _unit(key), before, after)


def _of_entries(single: str, before: list[Any], after: list[Any]) -> Iterator[str]:
    """Entries that were changed, taken away or added."""
    old, new = _without_renamed(_entries_by_name(before), _entries_by_name(after))
    for name in old:
        if name in new:
            yield from _of_entry(f"{single} {name}", old[name], new[name])
        else:
            yield f"{single} {name} taken away"
    yield from (f"{single} {name} added" for name in new if name not in old)
    gone, come = _nameless(before, after), _nameless(after, before)
    for count, what in ((min(gone, come), "changed"), (gone - come, "taken away"), (come - gone, "added")):
        if count > 0:
            yield f"{count} {single}{'s' * (count > 1)} {what}"


def _entries_by_name(entries: list[Any]) -> dict[str, Json]:
    """The entries that have a name of their own."""
    names = [entry["name"] for entry in entries if isinstance(entry, dict) and isinstance(entry.get("name"), str)]
    return {
        entry["name"]: entry
        for entry in entries
        if isinstance(entry, dict) and isinstance(entry.get("name"), str) and names.count(entry["name"]) == 1
    }


def _without_renamed(old: dict[str, Json], new: dict[str, Json]) -> tuple[dict[str, Json], dict[str, Json]]:
    """Both without the entries that have but another name."""
    bodies = {name: {**entry, "name": ""} for name, entry in new.items() if name not in old}
    for name in [name for name in old if name not in new]:
        same = next((other for other, body in bodies.items() if body == {**old[name], "name": ""}), None)
        if same is not None:
            del bodies[same]
            old, new = {k: v for k, v in old.items() if k != name}, {k: v for k, v in new.items() if k != same}
    return old, new


def _nameless(entries: list[Any], others: list[Any]) -> int:
    """How many entries without a name of their own are not among the others."""
    named = list(_entries_by_name(entries).values())
    return sum(entry not in named and entry not in others for entry in entries)


def _of_entry(what: str, before: Json, after: Json) -> Iterator[str]:
    """The differences of one zone or obstacle; all that says where it lies is its shape."""
    if any(not _same(before.get(key), after.get(key)) for key in _SHAPE):
        yield f"{what} shape"
    for key in (key for key in {**before, **after} if key not in (*_SHAPE, "name")):
        yield from _of_value(f"{what} {_words(key)}", _unit(key), before.get(key), after.get(key))


def _of_value(what: str, unit: str, before: Any, after: Any) -> Iterator[str]:
    """What differs between two values, in words; of blocks, what differs in them."""
    if _same(before, after):
        return
    if isinstance(before, dict | None) and isinstance(after, dict | None):
        old, new = before or {}, after or {}
        for key in (key for key in {**old, **new} if key != "effort"):
            yield from _of_value(f"{what} {_words(key)}", _unit(key), old.get(key), new.get(key))
    elif isinstance(before, dict | list) or isinstance(after, dict | list):
        yield f"{what} changed"
    else:
        was, is_now = (f"{_show(value)}{unit if _is_number(value) else ''}" for value in (before, after))
        both = _is_number(before) and _is_number(after)
        yield f"{what} {was.removesuffix(unit) if both else was} → {is_now}"


def _same(before: Any, after: Any) -> bool:
    return before == after or (not before and not after)


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _show(value: Any) -> str:
    if value is None:
        return "none"
    return f"{value:.6g}" if _is_number(value) else str(value)[:60]


def _unit(key: str) -> str:
    unit = unit_of(key)
    return unit if unit in ("", "°") else f" {unit}"


def _words(key: str) -> str:
    suffix = next((suffix for suffix in UNITS if key.endswith(suffix)), "")
    return key.removesuffix(suffix).replace("_", " ")
