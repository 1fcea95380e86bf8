"""Moving through the page: its start, Back, and undo where nothing is edited."""

from __future__ import annotations

from typing import Any

import pytest
from playwright.sync_api import expect
from tests.web.conftest import open_page
from tests.web.drawing import document, open_example, saved
from tests.web.planned import newly_planned

pytestmark = pytest.mark.browser


def test_a_page_that_starts_says_so_and_offers_nothing_yet(new_page: Any, page_server: Any) -> None:
    page, held = new_page, list[Any]()
    page.route("**/api/about", lambda route: held.append(route))
    page.goto("about:blank")
    page.goto(page_server.url)
    expect(page.locator("#verdict")).to_have_text("Rota starts…")
    expect(page.get_by_role("button", name="On to planning")).to_be_disabled()
    expect(page.get_by_role("button", name="Missions…")).to_be_disabled()
    for route in held:
        route.continue_()
    expect(page.get_by_role("button", name="On to planning")).to_be_enabled()
    expect(page.get_by_role("button", name="Missions…")).to_be_enabled()
    page.locator("body[data-ready=true]").wait_for()


@pytest.mark.slow  # opens two examples
def test_back_goes_to_the_tab_and_the_mission_before(page: Any) -> None:
    open_example(page, "harbour")
    saved(page)
    page.locator("#tab-plan").click()
    expect(page.locator("#panel-plan")).to_be_visible()
    page.go_back()
    expect(page.locator("#panel-edit")).to_be_visible()
    open_example(page, "coast")
    saved(page)
    page.go_back()
    expect(page.locator("#mission-name")).to_have_text("harbour")
    page.go_forward()
    expect(page.locator("#mission-name")).to_have_text("coast")
    expect(page.locator("#panel-edit")).to_be_visible()


@pytest.mark.slow  # plans, and edits at each tab
def test_undo_changes_nothing_that_is_not_seen(new_page: Any, page_server: Any) -> None:
    page = open_page(new_page, page_server, f"#mission={newly_planned(page_server.url)}")
    period = page.locator("#mission-form").get_by_label("Period (s)")
    period.fill("55")
    saved(page)
    page.locator("#tab-watch").click()
    expect(page.get_by_role("button", name="Undo", exact=True)).to_be_disabled()
    page.keyboard.press("Control+z")
    assert document(page)["period_s"] == 55
    # in Plan, the planner's own steps are undone where they are seen, and all others lead to Edit
    page.locator("#tab-plan").click()
    page.get_by_label("Effort").select_option("high")
    page.locator("#tab-plan").focus()
    page.keyboard.press("Control+z")
    expect(page.locator("#panel-plan")).to_be_visible()
    expect(page.get_by_label("Effort")).to_have_value("quick")
    page.keyboard.press("Control+z")
    expect(page.locator("#panel-edit")).to_be_visible()
    expect(period).to_have_value("60")
