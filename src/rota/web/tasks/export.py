"""Plans as the files that `rota export` writes; several files come in an archive."""

from __future__ import annotations

import io
import re
import tempfile
import zipfile
from importlib import import_module
from pathlib import Path

from rota.errors import RotaError
from rota.exports import FORMATS, Export, export_of
from rota.model.planner_settings import Settings, settings_of
from rota.web.refusal import Json, Refusal
from rota.web.tasks.context import Context
from rota.web.tasks.show import kept_plan

# one file of text by its format's name; of others the file says it
SUFFIXES = {"geojson": ".geojson", "csv": ".csv", "kml": ".kml", "gpx": ".gpx", "rosbag1": ".bag"}
TYPES = {
    ".geojson": "application/geo+json",
    ".csv": "text/csv",
    ".kml": "application/vnd.google-earth.kml+xml",
    ".gpx": "application/gpx+xml",
}
_OPTION = re.compile(r"--(origin|start-time|set)\b")


def formats_json() -> list[Json]:
    """Each format's name, what it holds, the suffix of its download, and what it can be told (``needs_origin``: of a
    mission without one)."""
    return [
        {
            "name": name,
            "what": kind.holds,
            "suffix": SUFFIXES.get(name, ".zip"),
            "needs_origin": kind.takes_origin and kind.text is None,
            "takes_origin": kind.takes_origin,
            "has_clock": kind.has_clock,
            "in_phase": kind.in_phase,
            "settings": settings_json(_type_at(*kind.settings)) if kind.settings else [],
        }
        for name, kind in FORMATS.items()
    ]


def _type_at(module: str, name: str) -> type[Settings]:
    block: type[Settings] = getattr(import_module(module), name)
    return block


def settings_json(block: type[Settings]) -> list[Json]:
    """The settings of a format or a link: name, what it means, default."""
    return [{"name": item.name, "what": item.meaning, "default": item.default} for item in settings_of(block)]


def export(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """A plan in a format; the message tells format, origin, start_time, settings, and a mark for the file's name."""
    plan = kept_plan(context, given)
    to: str = given["format"]
    try:
        made = export_of(plan, to, origin=given["origin"], start_time=given["start_time"], settings=given["settings"])
        suffix, content = _content(made, to)
    except RotaError as error:
        raise Refusal(422, _OPTION.sub(lambda option: option[1].replace("-", "_"), str(error))) from None
    name = f"{plan.mission.name}{given['mark']}{'' if suffix == SUFFIXES.get(to) else f'-{to}'}{suffix}"
    return {"name": name, "type": TYPES.get(suffix, "application/octet-stream")}, content


def _content(made: Export, to: str) -> tuple[str, bytes]:
    """The suffix and the bytes of the download."""
    if made.kind.is_text:
        return SUFFIXES[to], made.text().encode()
    with tempfile.TemporaryDirectory(prefix="rota-") as folder:
        path = Path(folder) / f"plan{SUFFIXES.get(to, '')}"
        paths = made.write(str(path))
        if to in SUFFIXES:
            return SUFFIXES[to], path.read_bytes()
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted({file for top in paths for file in _files(Path(top))} | set(_files(path))):
                archive.write(file, file.relative_to(path))
        return ".zip", packed.getvalue()


def _files(path: Path) -> list[Path]:
    """A file, or all files below a folder."""
    return [path] if path.is_file() else [file for file in path.rglob("*") if file.is_file()]
