"""Missions and uploads in the database: documents as people drew them, with the files that they name."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from typing import Any

from rota.model.planner_registry import DEFAULT
from rota.web.refusal import Json, Refusal, no_such
from rota.web.store.database import (
    Database,
    contents_of,
    digest_of,
    forget_unused_files,
    keep_files,
    new_id,
    now,
    row_of,
    sizes_of,
)

KEPT_UPLOADS = 50  # an upload that no mission was made of is forgotten after so many others


def keep_upload(database: Database, contents: Mapping[str, bytes]) -> str:
    """Keep uploaded files until a mission is made of them; returns the upload's id."""
    upload = new_id()
    with database.transaction() as cursor:
        files = keep_files(cursor, contents)
        cursor.execute("INSERT INTO uploads VALUES (?, ?, ?)", (upload, now(), json.dumps(files)))
        cursor.execute(
            "DELETE FROM uploads WHERE id NOT IN (SELECT id FROM uploads ORDER BY created_at DESC, rowid DESC LIMIT ?)",
            (KEPT_UPLOADS,),
        )
    return upload


def upload_contents(database: Database, upload: str) -> dict[str, bytes]:
    """The files of an upload; Refusal for one that there is not (any more)."""
    connection = database.connection()
    return contents_of(connection, _files_of_upload(connection, upload))


def _files_of_upload(connection: sqlite3.Connection, upload: str) -> dict[str, str]:
    files: dict[str, str] = json.loads(row_of(connection, "upload", upload)["files"])
    return files


def new_mission(
    database: Database, document: Json, *, upload: str | None = None, contents: Mapping[str, bytes] | None = None,
    most: int,
) -> Json:  # fmt: skip
    """Keep a new mission, with the files of an upload or those given; returns it as the interface shows it."""
    mission, moment = new_id(), now()
    with database.transaction() as cursor:
        if cursor.execute("SELECT count(*) FROM missions").fetchone()[0] >= most:
            raise Refusal(409, f"{most:,} missions are kept at most; delete some first")
        files = {} if upload is None else _files_of_upload(cursor, upload)
        files |= keep_files(cursor, contents or {})
        cursor.execute(
            "INSERT INTO missions (id, name, planner, document, files, created_at, changed_at)"
            " VALUES (?, ?, ?, ?, ?, ?, ?)",
            (mission, name_of(document), planner_of(document), text_of(document), json.dumps(files), moment, moment),
        )
    return mission_json(database, mission)


def same_mission(database: Database, document: Json, contents: Mapping[str, bytes]) -> str | None:
    """The newest mission that has this document and these files; None for none."""
    digests = json.dumps({name: digest_of(content) for name, content in contents.items()})
    sql = "SELECT id FROM missions WHERE document = ? AND files = ? ORDER BY changed_at DESC, rowid DESC"
    row = database.connection().execute(sql, (text_of(document), digests)).fetchone()
    return None if row is None else row[0]


def change_mission(
    database: Database, mission: str, document: Json, *, upload: str | None = None, revision: int | None = None
) -> Json:
    """Replace a mission's document; the files of an upload come to those it has. Each change counts its revision up.

    revision: the one that the document was made from; Refusal 409 where the mission has changed since. None: whichever.
    What is there already is no change, so that a save can be sent again when its answer was lost.
    """
    with database.transaction() as cursor:
        row = row_of(cursor, "mission", mission)
        kept, text = json.loads(row["files"]), text_of(document)
        files = kept if upload is None else kept | _files_of_upload(cursor, upload)
        if text != row["document"] or files != kept:
            require_revision(row, revision)
            cursor.execute(
                "UPDATE missions SET name = ?, planner = ?, document = ?, files = ?, changed_at = ?,"
                " revision = revision + 1 WHERE id = ?",
                (name_of(document), planner_of(document), text, json.dumps(files), now(), mission),
            )
    return mission_json(database, mission)


def require_revision(row: sqlite3.Row, revision: int | None) -> None:
    """Refuse what was made from another revision of a mission than the one that is kept."""
    if revision is not None and revision != row["revision"]:
        told = f"the mission was changed elsewhere: its revision is {row['revision']}, not {revision}"
        raise Refusal(409, told)


def delete_mission(database: Database, mission: str) -> None:
    """Delete a mission; its plans and jobs stay."""
    with database.transaction() as cursor:
        if not cursor.execute("DELETE FROM missions WHERE id = ?", (mission,)).rowcount:
            raise no_such("mission", mission)
        clean_files(cursor)


def clean_files(cursor: sqlite3.Connection) -> None:
    """Delete files that no mission, upload or job names."""
    rows = cursor.execute("SELECT files FROM missions UNION SELECT files FROM uploads UNION SELECT files FROM jobs")
    forget_unused_files(cursor, {digest for row in rows.fetchall() for digest in json.loads(row[0]).values()})


def list_missions(database: Database) -> list[Json]:
    """All missions, the one changed last first."""
    rows = database.connection().execute(
        "SELECT id, name, revision, changed_at, planner FROM missions ORDER BY changed_at DESC, rowid DESC"
    )
    return [dict(row) for row in rows]


def mission_json(database: Database, mission: str) -> Json:
    """A mission as the interface shows it; Refusal for one that there is not."""
    connection = database.connection()
    row = row_of(connection, "mission", mission)
    sizes = sizes_of(connection, json.loads(row["files"]))
    return {
        "id": row["id"],
        "revision": row["revision"],
        "name": row["name"],
        "planner": row["planner"],
        "document": json.loads(row["document"]),
        "attachments": [{"name": name, "size": size} for name, size in sizes.items()],
        "created_at": row["created_at"],
        "changed_at": row["changed_at"],
    }


def mission_source(database: Database, mission: str, revision: int | None = None) -> tuple[Json, dict[str, str], int]:
    """A mission's document, the digests of its files by name, and its revision; Refusal 409 for one of another."""
    row = row_of(database.connection(), "mission", mission)
    require_revision(row, revision)
    return json.loads(row["document"]), json.loads(row["files"]), row["revision"]


def mission_files(database: Database, mission: str) -> dict[str, bytes]:
    """What a mission's files hold, by name."""
    connection = database.connection()
    return contents_of(connection, json.loads(row_of(connection, "mission", mission)["files"]))


def name_of(document: Json) -> str:
    """A mission's name for lists; drafts may lack one."""
    name = document.get("name")
    return name[:200] if isinstance(name, str) and name.strip() else "unnamed"


def planner_of(document: Json) -> str:
    """The planner that a document names, whatever it is; the default where it names none."""
    planner: Any = document.get("planner", DEFAULT)
    return planner[:80] if isinstance(planner, str) else "?"


def text_of(document: Json) -> str:
    """A document as it is kept."""
    return json.dumps(document, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
