"""Connections that take too long to say what they want are closed, so that slow clients cannot hold all of them."""

from __future__ import annotations

import asyncio
import time

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

# for the first lines of a request, from its first byte or from connecting on, and for all of it
HEAD_S, BODY_S = 15.0, 120.0


class PatientProtocol(H11Protocol):
    """uvicorn's protocol, which by itself waits for ever for the rest of a request that has begun."""

    head_s, body_s = HEAD_S, BODY_S
    _timer: asyncio.TimerHandle | None = None
    _since_s = 0.0

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Somebody connects, and should say something soon."""
        super().connection_made(transport)
        self._begin()

    def data_received(self, data: bytes) -> None:
        """Part of a request, or all of it."""
        super().data_received(data)
        if self.conn.their_state not in (h11.IDLE, h11.SEND_BODY):
            self._cancel()
        elif self._timer is None:
            self._begin()

    def connection_lost(self, exc: Exception | None) -> None:
        """Nothing more comes."""
        self._cancel()
        super().connection_lost(exc)

    def _begin(self) -> None:
        self._since_s = time.monotonic()
        self._timer = self.loop.call_later(self.head_s, self._look)

    def _cancel(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _look(self) -> None:
        """The head should be here by now, and the body in time."""
        left_s = self.body_s - (time.monotonic() - self._since_s)
        if self.conn.their_state is h11.SEND_BODY and left_s > 0:
            self._timer = self.loop.call_later(left_s, self._look)
            return
        self._timer = None
        self.transport.abort()
