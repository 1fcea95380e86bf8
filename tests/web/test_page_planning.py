"""From an empty page to a plan that is watched and taken away, and back after a reload."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import expect
from tests.web.conftest import open_page
from tests.web.drawing import COMPILING_MS, document, draw_polygon, draw_two, judged, new_mission, open_example, saved
from tests.web.planned import newly_planned, planned_mission

from rota import check_plan, read_plan

pytestmark = pytest.mark.browser

SQUARE = [(100, 500), (500, 500), (500, 100), (100, 100)]


@pytest.fixture
def planned(new_page: Any, page_server: Any) -> Any:
    """The page with a mission that has a plan."""
    page = open_page(new_page, page_server, f"#mission={planned_mission(page_server.url)}&tab=plan")
    expect(page.locator("#mission-name")).to_have_text("small")
    page.locator("#plans tbody tr").first.wait_for()
    return page


def test_draw_plan_watch_lose_export_reload(page: Any, page_server: Any, tmp_path: Path) -> None:
    new_mission(page)
    draw_polygon(page, "Area", *SQUARE)
    draw_two(page, "Zone", "Circle", (200, 200), (240, 200))
    assert "proved" in judged(page)
    page.get_by_role("button", name="On to planning").click()
    expect(page.locator("#tab-plan")).to_be_focused()
    page.get_by_label("Effort").select_option("quick")
    page.locator("#seed").fill("3")
    page.get_by_label("Time limit (s)").fill("100")
    page.get_by_role("button", name="Plan", exact=True).click()
    expect(page.locator("#plans tbody tr")).to_have_count(1, timeout=COMPILING_MS)
    # a plan of lanes may be there before the job has ended
    expect(page.locator("#earlier")).to_contain_text("seed 3", timeout=COMPILING_MS)
    drawn = document(page)
    row = page.locator("#plans tbody tr")
    expect(row).to_contain_text("met")
    robots = int(row.locator("td").nth(1).inner_text())
    row.get_by_role("button", name="Watch").click()
    expect(page.locator("#panel-watch")).to_be_visible()
    expect(page.locator("#player-controls")).to_contain_text(f"{robots} robot")
    page.locator("#player-controls").get_by_role("button", name="Lost").first.click()
    expect(page.locator("#player-controls")).to_contain_text(re.compile("without|lapse|late", re.IGNORECASE))
    page.locator("#tab-take").click()
    for mark, suffix in [("plan.rota.json", ".rota.json"), ("csv", ".csv"), ("picture.png", ".png")]:
        with page.expect_download(timeout=COMPILING_MS) as told:
            page.locator(f"[data-download='{mark}']").click()
        told.value.save_as(tmp_path / f"taken{suffix}")
    plan = read_plan(tmp_path / "taken.rota.json")
    assert len(plan.trajectories) == robots
    assert check_plan(plan).verdict == "met"
    assert (tmp_path / "taken.csv").read_text().splitlines()[0].startswith("robot")
    assert (tmp_path / "taken.png").read_bytes().startswith(b"\x89PNG")

    open_page(page, page_server, page.url.split("/")[-1])
    expect(page.locator("#panel-take")).to_be_visible()
    expect(page.locator("#downloads")).to_contain_text(f"{robots} robots")
    assert document(page) == drawn
    page.locator("#tab-watch").click()
    expect(page.locator("#player-controls")).to_contain_text(f"{robots} robot")
    page.locator("#tab-edit").click()
    expect(page.locator("#shape-list .card")).to_have_count(2)
    expect(page.locator(".shape-zone")).to_have_count(1)


@pytest.mark.slow  # every export of a plan
def test_every_format_is_taken_or_says_what_it_lacks(planned: Any, faults: Any, tmp_path: Path) -> None:
    page = planned
    faults.refusals_expected = True  # a mission without a place on the globe refuses some formats
    page.locator("#plans tbody").get_by_role("button", name="Watch").first.click()
    page.locator("#tab-take").click()
    takes = page.locator("#downloads [data-download]")
    names = [takes.nth(k).get_attribute("data-download") for k in range(takes.count())]
    formats = {
        entry["name"]: entry for entry in page.request.get(f"{page.url.split('#')[0]}api/about").json()["formats"]
    }
    assert set(formats) < set(names)
    page.locator("[data-download=kml]").click()
    expect(page.locator("#downloads li", has=page.locator("[data-download=kml]"))).to_contain_text("origin")
    page.locator("#origin").fill("54.36, 13.08")
    page.get_by_label("Start time").fill("2026-05-01T06:00:00")
    for name in ("page.html", "kml", "qgroundcontrol", "nav2"):
        with page.expect_download(timeout=COMPILING_MS) as told:
            page.locator(f"[data-download='{name}']").click()
        told.value.save_as(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 100
    assert "2026-05-01" in (tmp_path / "kml").read_text()
    page.locator("#origin").fill("north")
    page.locator("[data-download=gpx]").click()
    expect(page.locator("#downloads li", has=page.locator("[data-download=gpx]"))).to_contain_text("north")


@pytest.mark.slow  # plans twice
def test_plans_stand_side_by_side_and_jobs_run_again(new_page: Any, page_server: Any) -> None:
    mission = newly_planned(page_server.url, "twice")  # jobs of other tests are listed, too
    page = open_page(new_page, page_server, f"#mission={mission}&tab=plan")
    rows = page.locator("#plans tbody tr")
    page.get_by_text("Earlier jobs").click()
    # the newest job moves from the earlier ones to the first list when its plan is deleted: both are counted
    listed = page.locator("#jobs li, #earlier li")
    expect(page.locator("#earlier").get_by_role("button", name="Run again: twice").first).to_be_visible()
    plans, jobs = rows.count(), listed.count()
    page.locator("#earlier").get_by_role("button", name="Run again: twice").first.click()
    expect(rows).to_have_count(plans + 1, timeout=COMPILING_MS)
    rows.get_by_role("button", name="Delete").first.click()
    page.get_by_role("button", name="Keep").click()
    expect(page.locator("#confirm")).to_be_hidden()
    expect(rows).to_have_count(plans + 1)
    rows.get_by_role("button", name="Delete").first.click()
    page.locator("#confirm-yes").click()
    expect(rows).to_have_count(plans)
    page.locator("#earlier").get_by_role("button", name="Delete: twice").first.click()
    page.locator("#confirm-yes").click()
    expect(listed).to_have_count(jobs)


@pytest.mark.slow  # begins a long search
def test_a_plan_that_is_stopped_keeps_its_best(page: Any) -> None:
    open_example(page, "harbour")
    judged(page)
    page.locator("#tab-plan").click()
    page.get_by_label("Effort").select_option("high")
    saved(page)
    page.get_by_role("button", name="Plan", exact=True).click()
    # a plan of lanes comes first, and is drawn while better ones are looked for
    expect(page.locator("#jobs")).to_contain_text("best so far", timeout=COMPILING_MS)
    expect(page.locator("#player-controls button").first).to_be_attached()
    expect(page.locator("#jobs progress")).to_be_visible()
    page.get_by_role("button", name="Stop").click()
    expect(page.locator("#plans tbody tr")).to_have_count(1, timeout=COMPILING_MS)
    expect(page.locator("#earlier")).to_contain_text("stopped")


def test_a_plan_file_is_added_and_checked(planned: Any, tmp_path: Path, faults: Any) -> None:
    page = planned
    faults.refusals_expected = True
    page.locator("#plans tbody").get_by_role("button", name="Watch").first.click()
    page.locator("#tab-take").click()
    with page.expect_download(timeout=COMPILING_MS) as told:
        page.locator("[data-download='plan.rota.json']").click()
    path = tmp_path / "mine.rota.json"
    told.value.save_as(path)
    page.locator("#tab-plan").click()
    page.get_by_label("Add a plan file").set_input_files(path)
    expect(page.locator("#notices")).to_contain_text("mine.rota.json", timeout=COMPILING_MS)
    written = json.loads(path.read_text())
    written["robots"][0]["times_s"][1] = -5
    path.write_text(json.dumps(written))
    page.get_by_label("Add a plan file").set_input_files(path)
    expect(page.locator("#plans .fault")).to_contain_text("times_s")
