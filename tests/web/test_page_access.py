"""The page for everybody: axe-core's rules, small screens, large letters, the keyboard."""

from __future__ import annotations

from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect
from tests.web.drawing import judged, open_example, saved

pytestmark = pytest.mark.browser

TABS = ["edit", "plan", "watch", "take"]
OF_COLOURS = {"runOnly": ["color-contrast", "link-in-text-block"]}


def violations(page: Any, options: dict[str, list[str]] | None = None) -> list[str]:
    found = Axe().run(page, options=options or {"resultTypes": ["violations"]}).response["violations"]
    return [
        f"{rule['id']}: {node['html'][:160]} {node['failureSummary'][:200]}" for rule in found for node in rule["nodes"]
    ]


@pytest.mark.slow  # reads every tab in both colours
@pytest.mark.parametrize("width", [1280, 360])
def test_axe_finds_nothing(page: Any, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 780})
    open_example(page, "harbour")
    judged(page)
    page.locator(".card[data-kind=zone]").first.get_by_role("button", name="gate", exact=True).click()
    page.locator("summary", has_text="Coordinates").last.click()
    found = {}
    for tab in TABS:
        page.locator(f"#tab-{tab}").click()
        for colours in ("dark", "light"):
            page.emulate_media(color_scheme=colours)
            expect(page.locator("body")).to_have_attribute("data-theme", colours)
            # what is no rule about colours is the same in both
            found[tab, colours] = violations(page, OF_COLOURS if colours == "dark" else None)
    page.get_by_role("button", name="Missions…").click()
    page.locator("[data-example=harbour-copters]").wait_for()
    found["missions", "light"] = violations(page)
    assert found == {name: [] for name in found}


@pytest.mark.slow  # looks at every tab
def test_nothing_is_wider_than_a_phone_or_400_percent(page: Any) -> None:
    width = 320  # what 1280 px are at 400 %; phones have 360
    page.set_viewport_size({"width": width, "height": 256})
    open_example(page, "harbour")
    saved(page)
    for tab in TABS:
        page.locator(f"#tab-{tab}").click()
        assert page.evaluate("document.documentElement.scrollWidth") <= width, tab


@pytest.mark.slow  # opens the page twice
def test_the_switch_of_colours_is_kept(page: Any) -> None:
    page.emulate_media(color_scheme="light")
    page.get_by_role("button", name="Dark colours").click()
    expect(page.locator("body")).to_have_attribute("data-theme", "dark")
    page.reload()
    expect(page.locator("body")).to_have_attribute("data-theme", "dark")
    page.get_by_role("button", name="Light colours").click()
    expect(page.locator("body")).to_have_attribute("data-theme", "light")


def test_tabs_go_by_arrow_keys_and_focus_is_seen(page: Any) -> None:
    page.locator("#tab-edit").focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator("#tab-plan")).to_be_focused()
    expect(page.locator("#panel-plan")).to_be_visible()
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("ArrowLeft")
    expect(page.locator("#tab-take")).to_be_focused()
    outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
    assert outline != "none"
