"""What the page says when something goes wrong."""

from __future__ import annotations

import math
import re
import signal
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.web.conftest import open_page
from tests.web.drawing import (
    click_map,
    document,
    draw_polygon,
    judged,
    mission_id,
    new_mission,
    open_example,
    saved,
    tool,
)
from tests.web.serving import Server

pytestmark = pytest.mark.browser


@pytest.fixture
def page(used_page: Any) -> Any:
    """The page, which tests of this file take over from each other."""
    return used_page


SQUARE = [(100, 500), (500, 500), (500, 100), (100, 100)]


@pytest.mark.slow  # opens file after file
def test_bad_files_are_refused_in_plain_words(page: Any, faults: Any, tmp_path: Path) -> None:
    faults.refusals_expected = True
    page.get_by_role("button", name="Missions…").click()
    bad = tmp_path / "broken.yaml"
    told = page.locator("#missions .fault")
    bad.write_text("rota: 1\nname: [x\n")
    page.locator("#mission-files").set_input_files(bad)
    expect(told).to_contain_text("broken.yaml:3:1: not YAML")
    bad.write_bytes(b"\xff\xfe\x00 no text")
    page.locator("#mission-files").set_input_files(bad)
    expect(told).to_contain_text("UTF-8")
    (tmp_path / "large.png").write_bytes(bytes(65 * 2**20))
    page.locator("#mission-files").set_input_files(tmp_path / "large.png")
    expect(told).to_contain_text("large.png")
    # a mission whose values are wrong is opened, so that they can be mended
    bad.write_text(
        "rota: 1\nname: x\narea: [[0, 0], [9, 0], [9, 9]]\nfleet: {speed_m_s: quick, sensor: {shape: disc}}\n"
    )
    page.locator("#mission-files").set_input_files(bad)
    expect(page.locator("#missions")).to_be_hidden()
    assert "Fleet, speed: " in judged(page)
    page.locator("#verdict").get_by_role("button", name="Fleet, sensor, radius").click()
    page.keyboard.type("3")
    page.locator("#fleet-form").get_by_label("Speed (m/s)").fill("1")
    page.locator("#mission-form").get_by_label("Period (s)").fill("60")
    expect(page.locator("#verdict")).to_contain_text("proved")


def test_a_mission_with_faults_is_not_planned(page: Any, page_server: Any) -> None:
    new_mission(page)
    draw_polygon(page, "Area", *SQUARE)
    page.locator("#fleet-form").get_by_label("Speed (m/s)").fill("0")
    assert "Fleet, speed: " in judged(page)
    page.locator("#tab-plan").click()
    expect(page.locator("#hindrance")).to_contain_text("Fleet, speed: ")
    plan = page.get_by_role("button", name="Plan", exact=True)
    expect(plan).to_have_attribute("aria-disabled", "true")
    plan.click(force=True)
    page.locator("#hindrance").get_by_role("button").first.click()
    expect(page.locator("#fleet-form").get_by_label("Speed (m/s)")).to_be_focused()
    with httpx.Client(base_url=page_server.url) as client:
        assert mission_id(page) not in {job["mission"] for job in client.get("/api/jobs").json()}


@pytest.mark.slow  # a long way through the page
def test_starts_that_no_plan_can_do_with_are_told_and_mended_by_a_dock(page: Any) -> None:
    open_example(page, "harbour")
    judged(page)
    tool(page, "Start", "Point")
    click_map(page, (400, 300))
    expect(page.locator("#verdict")).to_contain_text("Starts: 1 start is given, and at least 4 robots are needed")
    page.locator("#tab-plan").click()
    expect(page.locator("#hindrance")).to_contain_text("Starts: 1 start is given")
    page.locator("#hindrance").get_by_role("button", name="All start here (dock)").click()
    expect(page.locator("#hindrance")).to_be_hidden()
    expect(page.get_by_role("button", name="Plan", exact=True)).to_have_attribute("aria-disabled", "false")
    (x0, y0), (x1, y1) = document(page)["fleet"]["start"]["box"]
    assert (x1 - x0) * math.cos(math.radians(y0)) == pytest.approx(y1 - y0, rel=0.01)  # a square of metres, in degrees
    page.locator("#tab-edit").click()
    page.keyboard.press("Control+z")
    assert "points" in document(page)["fleet"]["start"]
    tool(page, "Start", "Dock: all start here")
    click_map(page, (300, 300))
    assert "box" in document(page)["fleet"]["start"]
    # outside of the area, and faster than anything
    tool(page, "Start", "Point")
    click_map(page, (880, 30))
    expect(page.locator("#verdict")).to_contain_text(re.compile("Start 1: .* outside the area"))
    page.locator("#fleet-form").get_by_label("Speed (m/s)").fill("5000")
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+z")
    page.locator("#fleet-form").get_by_label("Speed (m/s)").fill("5000")
    expect(page.locator("#verdict")).to_contain_text("Fleet, speed: 5,000 m/s is 18,000 km/h")


REFUSALS = {429: "Too many plans are waiting", 413: "too large", 503: "Try again", 401: "token", 500: "status 500"}


def refusing(status: int) -> Any:
    return lambda route: route.fulfill(status=status, body="<html>no json</html>")


def test_refusals_without_words_have_the_pages_own(page: Any, faults: Any) -> None:
    faults.refusals_expected = True
    open_example(page, "coast")
    saved(page)
    page.locator("#tab-plan").click()
    for status, words in REFUSALS.items():
        page.route("**/api/jobs", refusing(status))
        page.get_by_role("button", name="Plan", exact=True).click()
        expect(page.locator("#jobs .fault").first).to_contain_text(words)
        expect(page.get_by_role("button", name="Plan", exact=True)).to_be_enabled()
        page.unroute("**/api/jobs")


def test_a_deleted_mission_in_the_address_is_told(new_page: Any, page_server: Any, faults: Any) -> None:
    faults.refusals_expected = True
    page = open_page(new_page, page_server, "#mission=0123456789abcdef")
    expect(page.locator("#notices")).to_contain_text("cannot be opened")


@pytest.mark.slow  # starts two servers of its own
def test_edits_outlive_a_server_that_dies(chromium: Any, tmp_path: Path) -> None:
    server = Server(tmp_path / "data")
    context = chromium.new_context(viewport={"width": 1280, "height": 800})
    try:
        page = context.new_page()
        open_page(page, server)
        new_mission(page)
        draw_polygon(page, "Area", *SQUARE)
        before = document(page)
        server.end(signal.SIGKILL)
        page.locator("#mission-form").get_by_label("Name").fill("kept")
        expect(page.locator("#banner")).to_be_visible()
        expect(page.locator("#saved")).to_contain_text("NOT SAVED")
        server = Server(tmp_path / "data", port=server.port)
        page.get_by_role("button", name="Try now").click()
        expect(page.locator("#banner")).to_be_hidden()
        saved(page)
        assert document(page) == {**before, "name": "kept"}
    finally:
        context.close()
        server.end()
