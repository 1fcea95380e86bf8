"""Memory that a worker does not get: said as that, whichever library asked for it."""

from __future__ import annotations

from typing import Any

import pytest
from shapely.errors import GEOSException

from rota.web.tasks import planning
from rota.web.tasks.worker import _failure, _plan

REFUSED = [MemoryError("Allocation failed"), GEOSException("std::bad_alloc"), RuntimeError("can't start new thread")]


class Outbox:
    """What was sent."""

    def __init__(self) -> None:
        self.sent: list[Any] = []

    def send(self, message: Any) -> None:
        self.sent.append(message)


@pytest.mark.parametrize("error", REFUSED)
def test_memory_that_was_refused_is_said_to_be_that(error: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    assert _failure(error).status == 413
    assert _failure(ValueError("else")).status == 500

    def runs_out(*_: Any) -> Any:
        raise error

    class Inbox:
        def get(self) -> Any:
            return {"job": "1"}, b""

    monkeypatch.setattr(planning, "PlanningJob", runs_out)
    outbox: Any = Outbox()
    _plan(None, Inbox(), outbox, None)  # type: ignore[arg-type]
    assert outbox.sent[-1]["message"] == "planning needed more memory than is allowed"
