"""Shapes on the map while plans come and go."""

from __future__ import annotations

from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.web.conftest import open_page
from tests.web.drawing import click_map, document, draw_two, saved, tool
from tests.web.planned import SMALL, newly_planned

pytestmark = pytest.mark.browser

TOOLS = [("Zone", "Circle"), ("Start", "Point"), ("Obstacle", "Rectangle"), ("Entrance", "Point"), ("Start", "Box")]


@pytest.fixture
def watching(new_page: Any, page_server: Any) -> Any:
    """The page with a mission whose plan is watched."""
    page = open_page(new_page, page_server, f"#mission={newly_planned(page_server.url)}&tab=plan")
    page.locator("#plans tbody").get_by_role("button", name="Watch").first.click()
    expect(page.locator("#player-controls")).to_contain_text("robot")
    return page


@pytest.mark.slow  # draws with every tool and looks at every tab
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
        page.evaluate("() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)))")
        drawn = shapes.count()
        for tab in ("plan", "watch", "plan", "take") if form == "Point" else ("watch",):
            page.locator(f"#tab-{tab}").click()
            expect(shapes).to_have_count(0)
        page.locator("#tab-edit").click()
        expect(shapes).to_have_count(drawn)
        saved(page)


@pytest.mark.slow  # 300 shapes
def test_hundreds_of_obstacles_leave_the_fleet_at_hand(new_page: Any, page_server: Any) -> None:
    huts = [
        {"name": f"hut {k + 1}", "ring": [[x, y], [x + 5, y], [x + 5, y + 5], [x, y + 5]]}
        for k, (x, y) in enumerate((10 * column + 3, 10 * row + 3) for row in range(15) for column in range(20))
    ]
    area = [[0, 0], [200, 0], [200, 150], [0, 150]]
    with httpx.Client(base_url=page_server.url) as client:
        asked = {"document": {**SMALL, "name": "huts", "area": area, "obstacles": huts}}
        mission = client.post("/api/missions", json=asked).raise_for_status().json()["id"]
    page = open_page(new_page, page_server, f"#mission={mission}")
    expect(page.locator("#shape-list .card")).to_have_count(301)
    assert page.locator("#panel-edit").evaluate("(panel) => panel.scrollHeight") < 1600
    # the chosen one is shown in the list
    page.locator("path.shape-obstacle").nth(250).click(force=True)
    chosen = page.locator(".card[data-chosen=true]")
    expect(chosen).to_contain_text("hut 251")
    inside = "(card) => card.offsetTop - card.parentElement.offsetTop - card.parentElement.scrollTop"
    assert -5 <= chosen.evaluate(inside) < 300
    page.get_by_label("Find shapes").fill("hut 29")
    expect(page.locator("#shape-list .card:visible")).to_have_count(12)  # 29, 290 to 299, and the chosen one
    page.get_by_role("button", name="Delete hut 29", exact=True).click()
    assert [hut["name"] for hut in document(page)["obstacles"]] == [
        hut["name"] for hut in huts if hut["name"] != "hut 29"
    ]
    page.get_by_label("Find shapes").fill("")
    # keys have moved by one: each card still tells of its own shape
    page.get_by_role("button", name="hut 100", exact=True).click()
    expect(page.locator(".card[data-chosen=true]")).to_contain_text("hut 100")
    page.locator(".card[data-chosen=true]").get_by_label("Blocks").select_option("sight")
    assert [hut["name"] for hut in document(page)["obstacles"] if hut.get("blocks") == "sight"] == ["hut 100"]
    page.locator(".card[data-chosen=true]").get_by_label("Blocks").select_option("nothing")
    (silent,) = [hut for hut in document(page)["obstacles"] if "asks" in hut]
    assert (silent["name"], silent["blocks"], silent["asks"]) == ("hut 100", "motion", "nothing")
    page.locator(".card[data-chosen=true]").get_by_label("Blocks").select_option("motion")
    assert not any("asks" in hut for hut in document(page)["obstacles"])
