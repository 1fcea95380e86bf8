"""One user of a folder: a second one is refused, and the folder is free again whenever the first one ends."""

from __future__ import annotations

import sqlite3
from pathlib import Path

from rota.errors import RotaError

LOCK_NAME = "in-use.sqlite3"


class SoleUser:
    """Holds a folder until ``close`` or the end of the process, however it ends.

    A lock of SQLite does it, since that works on every system. Raises RotaError for a folder that another one holds.
    """

    def __init__(self, folder: Path, *, kept: str, in_use: str) -> None:
        """kept: what the folder is for; in_use: what to say of one that another holds."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._connection = sqlite3.connect(
                folder / LOCK_NAME, timeout=0, isolation_level=None, check_same_thread=False
            )
        except (OSError, sqlite3.Error) as error:
            raise RotaError(f"{folder}: cannot be used to keep {kept}: {error}") from error
        try:
            self._connection.execute("BEGIN EXCLUSIVE")
        except sqlite3.Error as error:
            self._connection.close()
            reason = in_use if "locked" in str(error) else error
            raise RotaError(f"{folder}: {reason}") from None

    def close(self) -> None:
        """Let others have the folder."""
        self._connection.close()
