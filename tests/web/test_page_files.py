"""Files that are opened on the page: maps, GeoJSON, plans."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.web.drawing import COMPILING_MS, document, judged, open_example, saved
from tests.web.planned import planned_mission

pytestmark = pytest.mark.browser


@pytest.fixture
def page(used_page: Any) -> Any:
    """The page, which tests of this file take over from each other."""
    return used_page


EXAMPLES = Path(__file__).parents[2] / "examples"

LISTEN = """() => {
  window.told = [];
  const tell = () => window.told.push(document.body.innerText);
  new MutationObserver(tell).observe(document.body, { subtree: true, childList: true, characterData: true });
}"""


def give(page: Any, *files: Path) -> None:
    page.get_by_role("button", name="Missions…").click()
    page.locator("#mission-files").set_input_files(files)
    expect(page.locator("#missions")).to_be_hidden()


def fills_the_map(page: Any) -> bool:
    """Whether the area takes most of the map, along one side at least."""
    room, shown = page.locator("#map").bounding_box(), page.locator(".shape-area").first.bounding_box()
    return max(shown["width"] / room["width"], shown["height"] / room["height"]) > 0.7


@pytest.mark.parametrize("opened", ["example", pytest.param("ros map", marks=pytest.mark.slow)])
def test_a_scanned_floor_opens_at_its_size_and_without_a_fault(page: Any, opened: str) -> None:
    page.evaluate(LISTEN)
    if opened == "example":
        open_example(page, "building")
    else:
        give(page, EXAMPLES / "building_map.yaml", EXAMPLES / "building_map.png")
    expect(page.locator(".shape-area.shape-resolved")).to_have_count(1, timeout=COMPILING_MS)
    assert fills_the_map(page)
    saved(page)
    assert "fault" not in judged(page)
    assert fills_the_map(page)
    told = "\n".join(page.evaluate("() => window.told"))
    assert "no such file" not in told
    assert "keeps this mission" not in told
    assert "rota-" not in told


def square(west: float, south: float, side: float, **properties: Any) -> dict[str, Any]:
    ring = [[west, south], [west + side, south], [west + side, south + side], [west, south + side], [west, south]]
    return {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}}


def test_each_feature_of_geojson_is_taken_as_what_it_is(page: Any, tmp_path: Path) -> None:
    port, quay = square(13.08, 54.36, 0.004, name="port"), square(13.081, 54.3605, 0.001, name="quay")
    gate = square(13.083, 54.363, 0.0005, name="gate")
    files = [tmp_path / "a.geojson", tmp_path / "b.geojson"]
    files[0].write_text(json.dumps({"type": "FeatureCollection", "features": [quay, gate]}))
    files[1].write_text(json.dumps(port))
    page.get_by_role("button", name="Missions…").click()
    page.locator("#mission-files").set_input_files(files)
    dialog = page.locator("#features")
    expect(dialog.locator("legend strong")).to_have_text(["quay", "gate", "port"])
    expect(dialog.get_by_role("radio", name="Area", checked=True)).to_have_count(3)
    dialog.get_by_role("button", name="others obstacles").click()
    expect(dialog.locator("path.shape-obstacle")).to_have_count(2)
    dialog.get_by_role("group", name="gate").get_by_label("Zone").check()
    expect(dialog.locator("path.shape-zone")).to_have_count(1)
    # a click on the picture goes from one to the next: an obstacle is left out then, and the area after that
    dialog.locator("path.shape-obstacle").click()
    expect(dialog.locator("path.shape-none")).to_have_count(1)
    dialog.get_by_role("group", name="quay").get_by_label("Obstacle").check()
    dialog.get_by_role("button", name="Open", exact=True).click()
    expect(page.locator("#missions")).to_be_hidden()
    expect(page.locator(".card[data-kind=obstacle]").get_by_role("button", name="quay", exact=True)).to_be_visible()
    kept = document(page)
    assert kept["area"]["ring"] == port["geometry"]["coordinates"][0][:-1]
    assert kept["obstacles"] == [{"ring": quay["geometry"]["coordinates"][0][:-1], "name": "quay"}]
    assert [zone["name"] for zone in kept["zones"]] == ["gate"]
    # the name is changed like any other
    page.locator(".card[data-kind=obstacle]").get_by_role("button", name="quay", exact=True).click()
    page.locator(".card[data-kind=obstacle]").get_by_label("Name").fill("pier")
    assert document(page)["obstacles"][0]["name"] == "pier"
    expect(page.locator(".card[data-kind=obstacle]").get_by_role("button", name="pier", exact=True)).to_be_visible()


def test_a_plan_is_added_to_the_plans_wherever_it_is_given(page: Any, page_server: Any, tmp_path: Path) -> None:
    mission = planned_mission(page_server.url)
    with httpx.Client(base_url=page_server.url) as client:
        (plan,) = [plan for plan in client.get("/api/plans").json() if plan["mission"] == mission]
        text = client.get(f"/api/plans/{plan['id']}/plan.rota.json").text
    given = tmp_path / "renamed.json"
    given.write_text(text)
    page.get_by_role("button", name="Missions…").click()
    page.locator("#mission-files").set_input_files(given)
    expect(page.locator("#missions")).to_be_hidden()
    expect(page.locator("#panel-plan")).to_be_visible()
    expect(page.locator("#notices")).to_contain_text("renamed.json: 1 robot")
