"""A running page, one for all tests of a process, and a real browser; without chromium these tests are left out."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
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


@contextmanager
def new_tab(chromium: Any) -> Iterator[Any]:
    """A tab in a fresh context, where nothing is open."""
    sync_api = pytest.importorskip("playwright.sync_api")
    context = chromium.new_context(
        viewport={"width": 1280, "height": 800}, accept_downloads=True, reduced_motion="reduce"
    )
    context.set_default_timeout(HAND_MS)
    sync_api.expect.set_options(timeout=HAND_MS)
    yield context.new_page()
    context.close()


@contextmanager
def faultless(page: Any, faults: Faults) -> Iterator[None]:
    """A tab must make no error and ask nobody but its server."""
    heard = {
        "console": faults.heard,
        "pageerror": lambda error: faults.errors.append(str(error)),
        "request": faults.asked,
    }
    for event, hear in heard.items():
        page.on(event, hear)
    yield
    for event, hear in heard.items():
        page.remove_listener(event, hear)
    assert faults.errors == []
    assert faults.strangers == []


@pytest.fixture
def new_page(chromium: Any, faults: Faults) -> Iterator[Any]:
    """A tab of its own, which must make no error."""
    with new_tab(chromium) as page, faultless(page, faults):
        yield page


@pytest.fixture
def page(new_page: Any, page_server: Server) -> Any:
    """The page, open and ready."""
    return open_page(new_page, page_server)


@pytest.fixture(scope="module")
def used_tab(started_chromium: Any, page_server: Server) -> Iterator[Any]:
    """The page in a tab that the tests of a module use one after the other, as people do."""
    browser, loop = started_chromium
    asyncio._set_running_loop(loop)
    with new_tab(browser) as page:
        open_page(page, page_server)
        asyncio._set_running_loop(None)
        yield page
        asyncio._set_running_loop(loop)
    asyncio._set_running_loop(None)


@pytest.fixture
def used_page(chromium: Any, used_tab: Any, faults: Faults) -> Iterator[Any]:
    """The page as the test before has left it, for tests that begin with a new mission; to open it takes a second."""
    with faultless(used_tab, faults):
        yield used_tab
        used_tab.unroute_all()


def open_page(page: Any, server: Server, address: str = "") -> Any:
    page.goto("about:blank")  # an address that differs in what follows # alone would load nothing
    page.goto(f"{server.url}/{address}")
    page.locator("body[data-ready=true]").wait_for(timeout=START_MS)
    return page
