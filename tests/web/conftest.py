"""A running page, one for all tests of a process, and a real browser; without chromium these tests are left out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import urlsplit

import pytest
from tests.web.serving import Server

HAND_MS = 20_000  # for what hands do; the machine may be busy
START_MS = 90_000  # until a new server's processes have loaded what the page asks first


@dataclass
class Faults:
    """What a page must not do: errors in its console, and requests that leave the machine."""

    host: str
    errors: list[str] = field(default_factory=list)
    strangers: list[str] = field(default_factory=list)
    refusals_expected: bool = False  # chromium writes each answer of 400 and more into the console

    def heard(self, message: Any) -> None:
        refused = message.text.startswith("Failed to load resource")
        if message.type in ("error", "warning") and not (refused and self.refusals_expected):
            self.errors.append(f"{message.text} ({message.location})")

    def asked(self, request: Any) -> None:
        parts = urlsplit(request.url)
        if parts.scheme in ("http", "https", "ws", "wss") and parts.netloc != self.host:
            self.strangers.append(request.url)


@pytest.fixture(scope="session")
def page_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    server = Server(tmp_path_factory.mktemp("page") / "data")
    yield server
    server.end()


@pytest.fixture
def faults(page_server: Server) -> Faults:
    return Faults(urlsplit(page_server.url).netloc)


@pytest.fixture
def new_page(chromium: Any, page_server: Server, faults: Faults) -> Iterator[Any]:
    """A tab in a fresh context, where nothing is open; it must make no error and ask nobody but its server."""
    sync_api = pytest.importorskip("playwright.sync_api")
    context = chromium.new_context(
        viewport={"width": 1280, "height": 800}, accept_downloads=True, reduced_motion="reduce"
    )
    context.set_default_timeout(HAND_MS)
    sync_api.expect.set_options(timeout=HAND_MS)
    page = context.new_page()
    page.on("console", faults.heard)
    page.on("pageerror", lambda error: faults.errors.append(str(error)))
    page.on("request", faults.asked)
    yield page
    context.close()
    assert faults.errors == []
    assert faults.strangers == []


@pytest.fixture
def page(new_page: Any, page_server: Server) -> Any:
    """The page, open and ready."""
    return open_page(new_page, page_server)


def open_page(page: Any, server: Server, address: str = "") -> Any:
    page.goto("about:blank")  # an address that differs in what follows # alone would load nothing
    page.goto(f"{server.url}/{address}")
    page.locator("body[data-ready=true]").wait_for(timeout=START_MS)
    return page
