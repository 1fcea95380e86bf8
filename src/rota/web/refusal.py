"""What the server answers when it does not do what was asked: a status, a message, and faults with their fields."""

from __future__ import annotations

import errno
from collections.abc import Sequence
from typing import Any

from rota.errors import RotaError

Json = dict[str, Any]


class Refusal(RotaError):  # noqa: N818 (it is an answer, not a fault)
    """A request that is not fulfilled. ``status``: of HTTP; ``faults``: {field, path, message} of what is wrong."""

    def __init__(self, status: int, message: str, faults: Sequence[Json] = ()) -> None:
        self.status, self.message, self.faults = status, message, list(faults)
        super().__init__(message)

    def to_json(self) -> Json:
        """The body of the answer."""
        return {"error": {"message": self.message, "faults": self.faults}}


def unkept(error: Exception) -> Refusal | None:
    """507 where the disk of the data folder has no room, 503 where it cannot be written; None for other faults."""
    code = getattr(error, "sqlite_errorname", "")
    if code.startswith("SQLITE_FULL") or (isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT)):
        return Refusal(507, "the disk of the data folder is full: nothing more can be saved until there is room")
    if code.startswith(("SQLITE_IOERR", "SQLITE_READONLY", "SQLITE_BUSY", "SQLITE_CANTOPEN")):
        return Refusal(503, f"the data folder cannot be written just now ({error}); see that its disk can")
    return None


def no_such(what: str, key: str) -> Refusal:
    """404, with what there is none of."""
    return Refusal(404, f"there is no {what} {key[:80]!r}")
