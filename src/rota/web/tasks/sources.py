"""Which of some uploaded files is the mission, and a mission for those that are none: a parcel's outline, a map."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field
from typing import Any

from rota.files.occupancy_map import free_place
from rota.files.yaml_text import parse_text
from rota.web.refusal import Json, Refusal
from rota.web.tasks.context import lay_out
from rota.web.tasks.features import GUESSED, features_of, list_features, mission_of

_GEOJSON = ("FeatureCollection", "Feature", "Polygon", "MultiPolygon", "GeometryCollection")
_PICTURES = (".png", ".pgm", ".bmp", ".jpg", ".jpeg", ".gif", ".tif", ".tiff")
_IMAGE_LINE = re.compile(rb"(?m)^image:[ \t]*(?P<quote>[\"']?)(?P<path>[^\"'#\r\n]*?)(?P=quote)[ \t]*(#.*)?\r?$")


@dataclass(frozen=True, kw_only=True)
class Source:
    """A mission's document as it was written, the files that go with it by name, and what its author should know.

    features: of GeoJSON files, when their author has to say what each is.
    """

    document: Json
    files: dict[str, bytes]
    warnings: list[str] = field(default_factory=list)
    features: list[Json] = field(default_factory=list)


def source_of(contents: dict[str, bytes], *, first: str | None = None, roles: str | None = None) -> Source:
    """The mission among files; one is made for GeoJSON or a ROS map. Refusal where neither is possible.

    first: the file that is the mission, where that is known. roles: of the features of GeoJSON files (``features``).
    """
    if first is not None:
        return _mission(first, _parse(first, contents[first]), contents)
    values = {name: _parse(name, content) for name, content in contents.items() if _is_text(name)}
    kinds = {name: _kind(value) for name, value in values.items()}
    named = {kind: [name for name in kinds if kinds[name] == kind] for kind in ("mission", "map", "geojson", "plan")}
    if len(named["mission"]) > 1:
        raise Refusal(400, f"these are several missions: {', '.join(named['mission'])}; give one")
    if named["mission"]:
        return _mission(named["mission"][0], values[named["mission"][0]], contents)
    if len(named["map"]) > 1:
        raise Refusal(400, f"these are several maps: {', '.join(named['map'])}; give one with its picture")
    if named["map"]:
        return _of_map(named["map"][0], contents)
    if named["geojson"]:
        return _of_geojson(named["geojson"], contents, roles)
    if named["plan"]:
        raise Refusal(400, f"{named['plan'][0]} is a plan, not a mission; add it to the plans")
    pictures = [name for name in contents if name.lower().endswith(_PICTURES)]
    if pictures:
        raise Refusal(400, f"{pictures[0]}: a map's picture comes with its .yaml file; give both together")
    raise Refusal(400, "none of the files is a mission (.yaml, .json), GeoJSON, or a ROS map (.yaml and picture)")


def _is_text(name: str) -> bool:
    return name.lower().endswith((".yaml", ".yml", ".json", ".geojson"))


def _parse(name: str, content: bytes) -> Any:
    """A file's values; MissionError with line and column for one that is broken."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise Refusal(422, f"{name}: byte {error.start} is not UTF-8; save the file as UTF-8") from None
    if name.lower().endswith(("json",)) and len(content) > 2**16:
        try:  # large GeoJSON goes the quick way; its own reader tells what is wrong with it
            return json.loads(text)
        except (ValueError, RecursionError):
            raise Refusal(422, f"{name}: is not JSON, or nested too deep") from None
    return parse_text(text, name, "a mission, GeoJSON or a ROS map").value


def _kind(value: Any) -> str:
    """What a file of YAML or JSON is, by its keys."""
    if not isinstance(value, dict):
        return "other"
    if "rota" in value or ("area" in value and "fleet" in value):
        return "mission"
    if "rota_plan" in value:
        return "plan"
    if "image" in value and "resolution" in value:
        return "map"
    return "geojson" if value.get("type") in _GEOJSON else "other"


def _mission(name: str, value: Any, contents: dict[str, bytes]) -> Source:
    """A mission whose files are looked for by their last names, since browsers drop folders."""
    if not isinstance(value, dict):
        raise Refusal(422, f"{name}: holds no mission; keys and values are needed")
    others = {other: content for other, content in contents.items() if other != name}
    blocks = [value.get("area"), value.get("importance"), *_list_at(value, "obstacles"), *_list_at(value, "zones")]
    for block in blocks:
        for key in ("geojson", "map"):
            if isinstance(block, dict) and isinstance(block.get(key), str):
                last = block[key].replace("\\", "/").rsplit("/", 1)[-1]
                block[key] = last if last in others else block[key]
    files = {other: _with_image(content, others) for other, content in others.items()}
    text = str(blocks)
    used = {other for other in files if repr(other) in text}
    used |= {other for other in files for sheet in used if other.encode() in files[sheet]}
    return Source(document=value, files=files, warnings=_warnings_of_unused(contents, {name, *used}))


def _list_at(value: Json, key: str) -> list[Any]:
    found = value.get(key)
    return found if isinstance(found, list) else []


def _with_image(content: bytes, others: dict[str, bytes]) -> bytes:
    """A ROS map that names its picture by the last part of its path, where that was uploaded too."""
    found = _IMAGE_LINE.search(content) if len(content) < 2**16 else None
    if found is None:
        return content
    last = found["path"].replace(b"\\", b"/").rsplit(b"/", 1)[-1]
    if last.decode("utf-8", "replace") not in others:
        return content
    return content[: found.start("path")] + last + content[found.end("path") :]


def _of_map(name: str, contents: dict[str, bytes]) -> Source:
    """A mission in the largest free part of a ROS map."""
    files = {other: _with_image(content, contents) for other, content in contents.items()}
    with lay_out(files) as folder:
        x, y = free_place(folder / name, confine_to=folder)
    document = {
        "rota": 1,
        "name": _stem(name),
        "area": {"map": name, "inside": [round(x, 3), round(y, 3)]},
        "period_s": 300,
        "fleet": {
            "robots": "fewest",
            "speed_m_s": 0.5,
            "sensor": {"shape": "disc", "radius_m": 3},
            "body_radius_m": 0.2,
        },
        "planner": "patrol",
    }
    used = {name, *(other for other in files if other.encode() in files[name])}
    return Source(document=document, files=files, warnings=[GUESSED, *_warnings_of_unused(contents, used)])


def _of_geojson(names: list[str], contents: dict[str, bytes], roles: str | None) -> Source:
    """A mission of the features of GeoJSON files."""
    found = features_of(contents, names)
    document, files = mission_of(found, roles)
    unused = _warnings_of_unused(contents, {*names})
    choices = list_features(found) if roles is None and len(found.features) > 1 else []
    return Source(document=document, files=files, warnings=[GUESSED, *found.warnings, *unused], features=choices)


def _warnings_of_unused(contents: dict[str, bytes], used: set[str]) -> list[str]:
    """A warning of each file that nothing is made of."""
    return [f"{name} is not used: the mission does not name it" for name in sorted(set(contents) - used)]


def _stem(name: str) -> str:
    return name.rsplit(".", 1)[0]
