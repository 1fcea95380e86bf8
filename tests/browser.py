"""Debian's chromium for tests marked ``browser``; they are skipped where it or playwright is missing."""

from __future__ import annotations

import asyncio
import shutil
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

OF_THIS_PAGE = ("file:", "data:", "blob:")


# the shell without windows takes half of the time of the whole browser, which does where that is missing
PROGRAMS = ("chromium-headless-shell", "chromium")


@pytest.fixture(scope="session")
def started_chromium() -> Iterator[tuple[Browser, asyncio.AbstractEventLoop]]:
    """One browser for all tests of a process, and the event loop that playwright leaves running meanwhile."""
    sync_api = pytest.importorskip("playwright.sync_api")
    found = next(filter(None, map(shutil.which, PROGRAMS)), None)
    if found is None:
        pytest.skip("chromium is not installed")
    with sync_api.sync_playwright() as playwright:
        # as root, chromium runs without its sandbox only
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        loop = asyncio.get_running_loop()
        asyncio._set_running_loop(None)
        yield browser, loop
        asyncio._set_running_loop(loop)
        browser.close()


@pytest.fixture
def chromium(started_chromium: tuple[Browser, asyncio.AbstractEventLoop]) -> Iterator[Browser]:
    """The browser; other tests run event loops of their own, so playwright's is the running one for this test alone."""
    browser, loop = started_chromium
    asyncio._set_running_loop(loop)
    yield browser
    asyncio._set_running_loop(None)


@pytest.fixture
def offline_page(chromium: Browser) -> Iterator[Page]:
    """A fresh page without a network; in the end nothing may have been asked of one, and no script may have failed."""
    # with less motion a plan is not played at once, so that tests find it where they put it
    context = chromium.new_context(offline=True, viewport={"width": 1200, "height": 900}, reduced_motion="reduce")
    page = context.new_page()
    faults: list[str] = []
    page.on("console", lambda message: faults.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("request", lambda request: None if request.url.startswith(OF_THIS_PAGE) else faults.append(request.url))
    yield page
    context.close()
    assert faults == []


def until(page: Page, expression: str, within_s: float = 20.0) -> None:
    """Wait until an expression of JavaScript is true; playwright's own wait needs eval, which pages forbid."""
    ends = time.monotonic() + within_s
    while not page.evaluate(expression):
        if time.monotonic() > ends:
            raise AssertionError(f"{expression} did not become true within {within_s:g} s")
        page.wait_for_timeout(20)
