"""Take the pictures of the page in a real browser: ``python -m docs.page_pictures`` writes docs/page-*.png.

It starts the server with a data folder of its own, edits the harbour, plans it and watches the plan.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from playwright.sync_api import Page, sync_playwright
from tests.web.conftest import open_page
from tests.web.drawing import COMPILING_MS, judged, open_example
from tests.web.serving import Server

FOLDER = Path(__file__).parent
SIZE = {"width": 1280, "height": 760}
WATCHED_S = 3


def main() -> None:
    """Write the pictures."""
    with tempfile.TemporaryDirectory() as data, sync_playwright() as playwright:
        server = Server(Path(data) / "data")
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport=SIZE)
        page.set_default_timeout(COMPILING_MS)
        try:
            open_page(page, server)
            picture_of_editing(page)
            picture_of_watching(page)
        finally:
            browser.close()
            server.end()


def picture_of_editing(page: Page) -> None:
    """The harbour with one zone chosen."""
    open_example(page, "harbour-copters")
    judged(page)
    page.locator(".card[data-kind=zone]").nth(2).get_by_role("button", name="container yard", exact=True).click()
    judged(page)
    page.locator("#panel-edit").evaluate("panel => panel.scrollTo(0, 0)")
    page.screenshot(path=FOLDER / "page-edit.png")


def picture_of_watching(page: Page) -> None:
    """Its plan, a while after it began to be played."""
    page.locator("#tab-plan").click()
    page.get_by_label("Effort").select_option("quick")
    page.get_by_role("button", name="Plan", exact=True).click()
    ended = page.locator("#plans tbody tr").filter(has_not_text="so far")
    ended.get_by_role("button", name="Watch").click()
    page.locator("#player-controls button").first.wait_for()
    page.wait_for_timeout(WATCHED_S * 1000)
    page.screenshot(path=FOLDER / "page-watch.png")


if __name__ == "__main__":
    main()
