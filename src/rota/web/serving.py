"""The server from its start to its end: address, names, token, and what is said of them."""

from __future__ import annotations

import asyncio
import ipaddress
import os
import secrets
import socket
import sys
import threading
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import uvicorn

from rota.errors import RotaError
from rota.web.app import make_app
from rota.web.limits import Limits
from rota.web.patience import PatientProtocol
from rota.web.security import LOOPBACK, Guard
from rota.web.tiles import tiles_of

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


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches a server bound to this host."""
    if host.lower() == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _name(host: str) -> str:
    """A host as addresses write it."""
    return f"[{host}]" if ":" in host else host.lower()
