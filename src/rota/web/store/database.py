"""The database of the page: one SQLite file with a write-ahead log, its tables, and transactions on it."""

from __future__ import annotations

import hashlib
import secrets
import sqlite3
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

from rota.errors import RotaError
from rota.web.refusal import no_such

FILE_NAME = "rota.sqlite3"
BUSY_S = 20.0  # how long one process waits while another writes

_FIRST_TABLES = """
CREATE TABLE files (digest TEXT PRIMARY KEY, content BLOB NOT NULL) WITHOUT ROWID;
CREATE TABLE uploads (id TEXT PRIMARY KEY, created_at TEXT NOT NULL, files TEXT NOT NULL);
CREATE TABLE missions (
    id TEXT PRIMARY KEY, name TEXT NOT NULL, planner TEXT NOT NULL, document TEXT NOT NULL, files TEXT NOT NULL,
    created_at TEXT NOT NULL, changed_at TEXT NOT NULL
);
CREATE TABLE jobs (
    id TEXT PRIMARY KEY, mission TEXT, mission_name TEXT NOT NULL, document TEXT NOT NULL, files TEXT NOT NULL,
    state TEXT NOT NULL, planner TEXT NOT NULL, effort TEXT, seed INTEGER NOT NULL, time_limit_s REAL,
    created_at TEXT NOT NULL, started_at TEXT, ended_at TEXT, elapsed_s REAL NOT NULL DEFAULT 0,
    message TEXT, best_robots INTEGER, best_met INTEGER, best_plan TEXT, plan TEXT
);
CREATE INDEX jobs_by_state ON jobs (state);
CREATE TABLE plans (
    id TEXT PRIMARY KEY, name TEXT NOT NULL, mission TEXT, job TEXT, planner TEXT NOT NULL, effort TEXT,
    created_at TEXT NOT NULL, robots INTEGER NOT NULL, bound INTEGER, bound_reason TEXT, verdict TEXT NOT NULL,
    worst_ratio REAL, length_m REAL NOT NULL, plan_s REAL, partial INTEGER NOT NULL, facts TEXT NOT NULL,
    is_better INTEGER NOT NULL, report BLOB NOT NULL, content BLOB NOT NULL
);
CREATE INDEX plans_by_job ON plans (job);
CREATE TABLE made (
    plan TEXT NOT NULL REFERENCES plans (id) ON DELETE CASCADE, what TEXT NOT NULL, content BLOB NOT NULL,
    PRIMARY KEY (plan, what)
);
"""
# a plan keeps what it was made of, so that it can be told when its mission has changed since
_REVISIONS = """
ALTER TABLE missions ADD COLUMN revision INTEGER NOT NULL DEFAULT 1;
ALTER TABLE jobs ADD COLUMN revision INTEGER;
ALTER TABLE plans ADD COLUMN revision INTEGER;
ALTER TABLE plans ADD COLUMN document TEXT;
ALTER TABLE plans ADD COLUMN files TEXT;
UPDATE plans SET document = (SELECT document FROM jobs WHERE jobs.id = plans.job),
    files = (SELECT files FROM jobs WHERE jobs.id = plans.job);
"""
# a plan may take over from another one: who is lost there, and when, as JSON
_CHANGES = """
ALTER TABLE jobs ADD COLUMN change TEXT;
ALTER TABLE plans ADD COLUMN change TEXT;
"""
_STEPS = (_FIRST_TABLES, _REVISIONS, _CHANGES)  # each makes the tables of one version of those of the version before
VERSION = len(_STEPS)  # of the tables, kept in SQLite's user_version


class Database:
    """The database in a folder; safe in several threads and processes, each thread with a connection of its own.

    Raises RotaError for a folder or file that cannot be used, and for tables that a later version of Rota wrote.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._threads = threading.local()
        self._open: list[sqlite3.Connection] = []
        self._closing = threading.Lock()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._make_tables()
        except (OSError, sqlite3.Error) as error:
            raise RotaError(f"{folder}: cannot be used to keep missions and plans: {error}") from error

    def _make_tables(self) -> None:
        """Make the tables of a new database, bring those of an earlier version up to date; refuse a later version."""
        with self.transaction() as cursor:
            version = cursor.execute("PRAGMA user_version").fetchone()[0]
            if version > VERSION:
                raise RotaError(f"{self.folder}: was written by a later version of Rota; use that one")
            for step in _STEPS[version:]:
                for statement in filter(str.strip, step.split(";")):
                    cursor.execute(statement)
            cursor.execute(f"PRAGMA user_version = {VERSION}")

    def connection(self) -> sqlite3.Connection:
        """This thread's connection; each statement outside a transaction is one by itself."""
        known: sqlite3.Connection | None = getattr(self._threads, "connection", None)
        if known is None:
            known = sqlite3.connect(
                self.folder / FILE_NAME, timeout=BUSY_S, isolation_level=None, check_same_thread=False
            )
            known.row_factory = sqlite3.Row
            known.execute("PRAGMA journal_mode = WAL")
            known.execute("PRAGMA synchronous = FULL")
            known.execute("PRAGMA foreign_keys = ON")
            self._threads.connection = known
            with self._closing:
                self._open.append(known)
        return known

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """All that is written in the block, or nothing of it."""
        connection = self.connection()
        connection.execute("BEGIN IMMEDIATE")
        try:
            yield connection
        except BaseException:
            if connection.in_transaction:  # of a full disk SQLite takes it back by itself
                connection.execute("ROLLBACK")
            raise
        connection.execute("COMMIT")

    def close(self) -> None:
        """Close the connections of all threads; nobody may use the database any more."""
        with self._closing:
            for connection in self._open:
                connection.close()
            self._open.clear()


def now() -> str:
    """The time in UTC, ISO 8601, with milliseconds."""
    return datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def new_id() -> str:
    """An identifier that nobody guesses and that fits into an address."""
    return secrets.token_hex(8)


Files = Mapping[str, str]  # digests by name


def row_of(connection: sqlite3.Connection, kind: str, key: str, columns: str = "*") -> sqlite3.Row:
    """The row of a mission, an upload, a job or a plan; Refusal for one that there is not."""
    row: sqlite3.Row | None = connection.execute(f"SELECT {columns} FROM {kind}s WHERE id = ?", (key,)).fetchone()
    if row is None:
        raise no_such(kind, key)
    return row


def digest_of(content: bytes) -> str:
    """What a file is kept by."""
    return hashlib.sha256(content).hexdigest()


def keep_files(cursor: sqlite3.Connection, contents: Mapping[str, bytes]) -> dict[str, str]:
    """Keep files by what they hold, each once however often it is used; returns the digests by name."""
    digests = {name: digest_of(content) for name, content in contents.items()}
    cursor.executemany(
        "INSERT OR IGNORE INTO files VALUES (?, ?)", [(digests[name], contents[name]) for name in contents]
    )
    return digests


def contents_of(connection: sqlite3.Connection, files: Files) -> dict[str, bytes]:
    """What files hold, by name."""
    found: dict[str, bytes] = {}
    for name, digest in files.items():
        row = connection.execute("SELECT content FROM files WHERE digest = ?", (digest,)).fetchone()
        if row is not None:
            found[name] = row[0]
    return found


def sizes_of(connection: sqlite3.Connection, files: Files) -> dict[str, int]:
    """How many bytes files have, by name."""
    sql = "SELECT length(content) FROM files WHERE digest = ?"
    return {name: connection.execute(sql, (digest,)).fetchone()[0] for name, digest in files.items()}


def forget_unused_files(cursor: sqlite3.Connection, kept: Iterable[str]) -> None:
    """Delete the files whose digests nobody names any more."""
    cursor.execute("CREATE TEMP TABLE IF NOT EXISTS kept (digest TEXT PRIMARY KEY)")
    cursor.execute("DELETE FROM kept")
    cursor.executemany("INSERT OR IGNORE INTO kept VALUES (?)", [(digest,) for digest in kept])
    cursor.execute("DELETE FROM files WHERE digest NOT IN (SELECT digest FROM kept)")
