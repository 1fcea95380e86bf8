"""Files that people give, as documents that the page edits: missions, parcels and maps."""

from __future__ import annotations

import io
import json
import zipfile
from typing import Any

from rota.web.refusal import Json, Refusal
from rota.web.store.missions import keep_upload, mission_files, mission_json, new_mission, same_mission, upload_contents
from rota.web.tasks.context import Context
from rota.web.tasks.examples import examples_folder
from rota.web.tasks.inlined import Inlined, inline
from rota.web.tasks.sources import source_of


def read_upload(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """What POST /api/missions/read answers; ``upload`` names the files."""
    contents = upload_contents(context.database, given["upload"])
    source = source_of(contents, roles=given["roles"])
    read = inline(context, source)
    choices = {"features": source.features} if source.features else {}
    # what the mission needs of the files, with paths in them that lead to each other
    return {}, _encode({**_show(read), **choices, "upload": keep_upload(context.database, read.files)})


def read_example(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """What GET /api/examples/NAME answers; with ``keep`` the message has the id of a mission that is it."""
    folder = examples_folder()
    text = (folder / f"{given['name']}.yaml").read_bytes()
    named = {path.name: path.read_bytes() for path in folder.iterdir() if path.name.encode() in text}
    for name in [name for name in named if name.endswith(".yaml")]:  # a map names its picture
        named |= {path.name: path.read_bytes() for path in folder.iterdir() if path.name.encode() in named[name]}
    source = source_of({**named, f"{given['name']}.yaml": text}, first=f"{given['name']}.yaml")
    if given.get("keep"):
        kept = inline(context, source)
        known = same_mission(context.database, kept.document, kept.files)  # as it was opened before
        if known is None:
            made = new_mission(context.database, kept.document, contents=kept.files, most=context.missions)
        return {"mission": known or made["id"]}, b""
    return {}, _encode(_show(inline(context, source)))


def _show(read: Inlined) -> Json:
    attachments = [{"name": name, "size": len(content)} for name, content in read.files.items()]
    return {"document": read.document, "attachments": attachments, "warnings": read.warnings}


def _encode(value: Any) -> bytes:
    try:
        return json.dumps(value, allow_nan=False).encode()
    except ValueError:
        raise Refusal(422, "the mission holds a number that is not finite, such as .inf or .nan") from None


def mission_yaml(context: Context, given: Json, body: bytes) -> tuple[Json, bytes]:
    """A mission's file (``kind`` yaml), or an archive of it and its attachments (zip)."""
    from rota.files.mission_text import mission_text

    kept = mission_json(context.database, given["mission"])
    text = mission_text(kept["document"]).encode()
    stem = "".join(letter if letter.isalnum() or letter in "-_" else "-" for letter in kept["name"])[:60]
    if given["kind"] == "yaml":
        return {"name": f"{stem}.yaml", "type": "application/yaml"}, text
    packed = io.BytesIO()
    files = mission_files(context.database, given["mission"])
    own = f"{stem}.yaml" if f"{stem}.yaml" not in files else f"{stem}-mission.yaml"  # a map may have the name
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in {own: text, **files}.items():
            archive.writestr(name, content)
    return {"name": f"{stem}.zip", "type": "application/zip"}, packed.getvalue()
