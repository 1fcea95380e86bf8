"""What the server answers when it does not do what was asked: a status, a message, and faults with their fields."""

from __future__ import annotations

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


def not_found(what: str, key: str) -> Refusal:
    """404, with what there is none of."""
    return Refusal(404, f"there is no {what} {key[:80]!r}")
