"""What the page says when something goes wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import expect
from tests.web.conftest import Server, open_page
from tests.web.drawing import document, draw_polygon, judged, new_mission, open_example, saved

pytestmark = pytest.mark.browser

SQUARE = [(100, 500), (500, 500), (500, 100), (100, 100)]


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
    assert "fleet.speed_m_s" in judged(page)
    page.get_by_role("button", name="fleet.sensor.radius_m").click()
    page.keyboard.type("3")
    page.locator("#fleet-form").get_by_label("Speed (m/s)").fill("1")
    page.locator("#mission-form").get_by_label("Period (s)").fill("60")
    expect(page.locator("#verdict")).to_contain_text("proved")


def test_a_mission_with_faults_is_not_planned(page: Any, faults: Any) -> None:
    faults.refusals_expected = True
    new_mission(page)
    draw_polygon(page, "Area", *SQUARE)
    page.locator("#fleet-form").get_by_label("Speed (m/s)").fill("0")
    assert "speed_m_s" in judged(page)
    page.locator("#tab-plan").click()
    page.get_by_role("button", name="Plan", exact=True).click()
    expect(page.locator("#jobs .fault").first).to_contain_text("speed_m_s")


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


def test_a_deleted_mission_in_the_address_is_told(page: Any, page_server: Any, faults: Any) -> None:
    faults.refusals_expected = True
    open_page(page, page_server, "#mission=0123456789abcdef")
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
        server.kill()
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
        server.close()
