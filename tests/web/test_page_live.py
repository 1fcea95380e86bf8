"""A fleet watched live on the page, and missions on map tiles."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.web.conftest import HAND_MS, open_page
from tests.web.drawing import COMPILING_MS, document, draw_two, judged, new_mission, open_example, saved
from tests.web.planned import planned_mission
from tests.web.serving import Server

pytestmark = [pytest.mark.browser, pytest.mark.slow]  # fleets that fly in real time, and a server with tiles

TILES = "http://tiles.invalid"
DOT = (
    b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR\x00\x00\x00\x01\x00\x00\x00\x01\x08\x06\x00\x00\x00\x1f\x15\xc4\x89"
    b"\x00\x00\x00\rIDATx\x9cc\xf8\xff\xff?\x00\x05\xfe\x02\xfe\xa75\x81\x84\x00\x00\x00\x00IEND\xaeB`\x82"
)


def test_a_simulated_fleet_is_watched_until_it_is_ended(new_page: Any, page_server: Any) -> None:
    mission = planned_mission(page_server.url)
    page = open_page(new_page, page_server, f"#mission={mission}&tab=plan")
    page.locator("#plans tbody").get_by_role("button", name="Watch").first.click()
    page.get_by_text("A live fleet on this plan").click()
    page.get_by_text("Settings of the link").click()
    page.locator("[data-setting=clock]").fill("4")
    page.get_by_role("button", name="Watch the fleet").click()
    expect(page.locator("#live")).to_contain_text("1 of 1 robots heard", timeout=COMPILING_MS)
    expect(page.locator("#live tbody tr")).to_have_count(1)
    page.get_by_role("button", name="End the watch").click()
    expect(page.locator("#live")).to_contain_text("The watch has ended", timeout=COMPILING_MS)
    with httpx.Client(base_url=page_server.url) as client:
        assert {watch["state"] for watch in client.get("/api/watches").json()} <= {"ended"}


def test_a_link_that_does_not_take_its_settings_says_so(new_page: Any, page_server: Any, faults: Any) -> None:
    faults.refusals_expected = True
    mission = planned_mission(page_server.url)
    page = open_page(new_page, page_server, f"#mission={mission}&tab=plan")
    page.locator("#plans tbody").get_by_role("button", name="Watch").first.click()
    page.get_by_text("A live fleet on this plan").click()
    page.get_by_text("Settings of the link").click()
    page.locator("[data-setting=rate_hz]").fill("often")
    page.get_by_role("button", name="Watch the fleet").click()
    expect(page.locator("#live")).to_contain_text(re.compile("often"), timeout=COMPILING_MS)
    expect(page.get_by_role("button", name="Watch the fleet")).to_be_visible()


@pytest.fixture(scope="module")
def tiled_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    tiles = ["--tile-url", TILES + "/{z}/{x}/{y}.png", "--tile-attribution", "© OpenStreetMap contributors <b>"]
    server = Server(tmp_path_factory.mktemp("tiled") / "data", *tiles)
    yield server
    server.end()


def test_missions_on_the_globe_lie_on_tiles(chromium: Any, tiled_server: Server) -> None:
    context = chromium.new_context(viewport={"width": 1280, "height": 800})
    context.set_default_timeout(HAND_MS)
    expect.set_options(timeout=HAND_MS)
    asked: list[str] = []
    page = context.new_page()
    page.route(
        TILES + "/**",
        lambda route: (asked.append(route.request.url), route.fulfill(body=DOT, content_type="image/png")),
    )
    open_page(page, tiled_server)
    # a new mission begins on the map, wherever somebody goes
    expect(page.locator(".leaflet-tile").first).to_be_attached()
    assert asked
    attribution = page.locator(".attribution")
    expect(attribution).to_have_text("© OpenStreetMap contributors <b>")
    expect(attribution.get_by_role("link")).to_have_attribute("href", "https://www.openstreetmap.org/copyright")
    page.get_by_label("Go to").fill("nowhere")
    page.keyboard.press("Enter")
    expect(page.locator("#go-to-fault")).to_contain_text("Latitude, longitude")
    page.get_by_label("Go to").fill("54°21'36\"N 13°4'48\"E")
    page.keyboard.press("Enter")
    draw_two(page, "Area", "Rectangle", (300, 300), (500, 500))
    kept = document(page)
    assert kept["coordinates"] == "wgs84"
    box = page.locator("#map").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    expect(page.locator("#readout")).to_have_text(re.compile(r"^54\.36\d+° N, 13\.0[78]\d+° E"))
    for lon, lat in kept["area"]:
        assert lon == pytest.approx(13.08, abs=0.02)
        assert lat == pytest.approx(54.36, abs=0.02)
    judged(page)
    new_mission(page)  # begins where one looked last
    draw_two(page, "Area", "Rectangle", (300, 300), (500, 500))
    assert document(page)["area"] == kept["area"]
    open_example(page, "harbour")
    before = document(page)["zones"]
    judged(page)
    draw_two(page, "Zone", "Rectangle", (300, 300), (330, 330))
    judged(page)
    saved(page)
    zones = document(page)["zones"]
    assert zones[:-1] == before
    for lon, lat in zones[-1]["ring"]:
        assert 13.080 < lon < 13.088
        assert 54.360 < lat < 54.364
    context.close()
