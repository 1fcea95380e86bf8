"""Files that are opened on the page: maps, GeoJSON, plans."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import expect
from tests.web.drawing import COMPILING_MS, judged, open_example, saved

pytestmark = pytest.mark.browser

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


@pytest.mark.parametrize("opened", ["example", "ros map"])
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
