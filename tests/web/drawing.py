"""What hands do on the page: drawing on the map, waiting for what it says."""

from __future__ import annotations

import re
from typing import Any

from playwright.sync_api import expect

Point = tuple[float, float]
COMPILING_MS = 180_000  # a fresh clone compiles what it is first asked for


def click_map(page: Any, *places: Point) -> None:
    """Clicks on the map, in pixels from its corner."""
    box = page.locator("#map").bounding_box()
    for x, y in places:
        page.mouse.click(box["x"] + x, box["y"] + y)


def drag_map(page: Any, start: Point, end: Point) -> None:
    box = page.locator("#map").bounding_box()
    page.mouse.move(box["x"] + start[0], box["y"] + start[1])
    page.mouse.down()
    page.mouse.move(box["x"] + (start[0] + end[0]) / 2, box["y"] + (start[1] + end[1]) / 2)
    page.mouse.move(box["x"] + end[0], box["y"] + end[1])
    page.mouse.up()


def tool(page: Any, name: str, form: str | None = None) -> None:
    """Takes a drawing tool, and its form."""
    page.locator("#tools").get_by_role("button", name=name, exact=True).click()
    if form is not None:
        page.locator("#tools").get_by_label("Form").select_option(label=form)


def draw_polygon(page: Any, name: str, *corners: Point) -> None:
    tool(page, name, "Polygon")
    click_map(page, *corners)
    page.keyboard.press("Enter")


def draw_two(page: Any, name: str, form: str, first: Point, second: Point) -> None:
    """A rectangle by two corners, or a circle by centre and rim."""
    tool(page, name, form)
    click_map(page, first, second)


def new_mission(page: Any) -> None:
    page.get_by_role("button", name="Missions…").click()
    page.get_by_role("button", name="New, empty mission").click()
    expect(page.locator("#missions")).to_be_hidden()


def open_example(page: Any, name: str) -> None:
    page.get_by_role("button", name="Missions…").click()
    row = page.locator(f"[data-example={name}]")
    row.wait_for(state="attached")
    if not row.is_visible():
        page.get_by_text("more examples").click()
    row.click()
    expect(page.locator("#mission-name")).to_have_text(name)


def saved(page: Any) -> None:
    # an example is read by a worker, which may be compiling
    expect(page.locator("#saved")).to_have_text("✓ saved", timeout=COMPILING_MS)


def judged(page: Any) -> str:
    """What the server says of the mission as it is."""
    page.locator("#verdict:not([aria-busy])").wait_for(timeout=COMPILING_MS)
    return str(page.locator("#verdict").inner_text())


def mission_id(page: Any) -> str:
    saved(page)
    found = re.search(r"mission=([0-9a-f]+)", page.url)
    assert found is not None
    return found.group(1)


def changed_area(page: Any, before: Any) -> Any:
    """The area once the server has another one than before."""
    for _ in range(200):
        area = document(page)["area"]
        if area != before:
            return area
        page.wait_for_timeout(50)
    raise AssertionError(f"the area is still {before}")


def document(page: Any) -> dict[str, Any]:
    """The mission as the server has it."""
    answer = page.request.get(f"{page.url.split('#')[0]}api/missions/{mission_id(page)}")
    kept: dict[str, Any] = answer.json()["document"]
    return kept
