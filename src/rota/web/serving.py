"""The server from its start to its end: address, names, token, and what is said of them."""

from __future__ import annotations

import asyncio
import os
import secrets
import socket
import sys
import threading
import time
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from rota.errors import RotaError
from rota.planning.robot_processes import is_loopback
from rota.web.app import make_app
from rota.web.limits import Limits
from rota.web.security import LOOPBACK, Guard
from rota.web.tiles import tiles_of

# for the first lines of a request, from its first byte or from connecting on, and for all of it
HEAD_S, BODY_S = 15.0, 120.0
Say = Callable[[str], None]
MOST_CONNECTIONS = 1000
HTTP_PORT, ANY_HOST = 80, ("0.0.0.0", "::")
IDLE_S = 20  # how long a connection may say nothing between two requests


@dataclass(frozen=True, kw_only=True)
class Serving:
    """A server that is to be run. ``port`` 0: any free one. ``limits`` None: the usual ones."""

    data: Path
    host: str = "127.0.0.1"
    port: int = 8321
    tile_url: str | None = None
    tile_attribution: str | None = None
    processes: int = 1
    limits: Limits | None = None

    def run(self, say: Say, *, open_page: bool = False) -> None:
        """Serve until Ctrl-C or SIGTERM. RotaError for an address, folder or tile address that cannot be used."""
        tiles = tiles_of(self.tile_url, self.tile_attribution)
        listening = self._listening()
        address = listening.getsockname()
        port = address[1]
        token = None if is_loopback(self.host) else secrets.token_urlsafe(24)
        names = {*LOOPBACK, _name(self.host), _name(address[0])} | ({socket.gethostname().lower()} if token else set())
        hosts = {f"{name}:{port}" for name in names} | (names if port == HTTP_PORT else set())  # browsers leave out 80
        guard = Guard(hosts=frozenset(hosts), token=token, any_address=f":{port}" if self.host in ANY_HOST else None)
        limits = self.limits or Limits(planning_jobs=self.processes)
        app = make_app(self.data, guard, limits, tiles)
        shown = _name(address[0] if self.host not in ANY_HOST else socket.gethostname())
        page = f"http://{shown}:{port}/" + (f"?token={token}" if token else "")
        config = uvicorn.Config(
            app, log_level="warning", access_log=False, server_header=False, date_header=False, proxy_headers=False,
            limit_concurrency=MOST_CONNECTIONS, timeout_keep_alive=IDLE_S, timeout_graceful_shutdown=2,
            h11_max_incomplete_event_size=64 * 1024, http=PatientProtocol, ws="none", lifespan="on",
        )  # fmt: skip

        def note_start() -> None:
            say(f"The page: {page}")
            say(f"What you make is kept in {self.data}; Ctrl-C ends the server.")
            if token is not None:
                say("Everybody who has this address can use the page; nothing that is sent is encrypted.")
            if open_page:
                show(page)

        server = _Server(config)
        server.told = note_start
        try:
            asyncio.run(server.serve(sockets=[listening]))
        except KeyboardInterrupt:
            pass
        finally:
            listening.close()

    def _listening(self) -> socket.socket:
        """The socket, bound."""
        try:
            found = socket.getaddrinfo(self.host, self.port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
            family, kind, protocol, _, address = found[0]
            listening = socket.socket(family, kind, protocol)
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listening.bind(address)
        except (OSError, UnicodeError) as error:
            raise RotaError(f"--host, --port: cannot listen at {self.host}:{self.port}: {error}") from None
        return listening


class _Server(uvicorn.Server):
    """uvicorn's server, which tells when it listens."""

    told: Callable[[], None]

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, and say so."""
        await super().startup(sockets)
        if self.started and not self.should_exit:
            self.told()


def show(page: str) -> None:
    """Open an address in the user's browser, where there is a screen for one."""
    has_screen = sys.platform in ("win32", "darwin") or any(
        os.environ.get(key) for key in ("DISPLAY", "WAYLAND_DISPLAY")
    )
    if has_screen:
        threading.Thread(target=webbrowser.open, args=(page,), daemon=True).start()


def _name(host: str) -> str:
    """A host as addresses write it."""
    return f"[{host}]" if ":" in host else host.lower()


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
