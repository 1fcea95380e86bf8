"""Shapes on the map while plans come and go."""

from __future__ import annotations

from typing import Any

import pytest
from playwright.sync_api import expect
from tests.web.conftest import open_page
from tests.web.drawing import click_map, draw_two, saved, tool
from tests.web.planned import newly_planned

pytestmark = pytest.mark.browser

TOOLS = [("Zone", "Circle"), ("Start", "Point"), ("Obstacle", "Rectangle"), ("Entrance", "Point"), ("Start", "Box")]


@pytest.fixture
def watching(page: Any, page_server: Any) -> Any:
    """The page with a mission whose plan is watched."""
    open_page(page, page_server, f"#mission={newly_planned(page_server.url)}&tab=plan")
    page.locator("#plans tbody").get_by_role("button", name="Watch").first.click()
    expect(page.locator("#player-controls")).to_contain_text("robot")
    return page


def test_shapes_stay_on_the_map_when_a_plan_was_looked_at_whatever_is_chosen(watching: Any) -> None:
    page = watching
    shapes = page.locator("#map .shape, #map .start-mark")
    for name, form in TOOLS:
        page.locator("#tab-edit").click()
        if form == "Point":
            tool(page, name, form)
            click_map(page, (300, 300))
        else:
            draw_two(page, name, form, (280, 280), (320, 320))
        expect(page.locator(f".card[data-kind={name.lower()}][data-chosen=true]")).to_have_count(1)
        drawn = shapes.count()
        for tab in ("plan", "watch", "plan", "take"):
            page.locator(f"#tab-{tab}").click()
            expect(shapes).to_have_count(0)
        page.locator("#tab-edit").click()
        expect(shapes).to_have_count(drawn)
        saved(page)
