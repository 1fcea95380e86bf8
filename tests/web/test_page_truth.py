"""What the page says is of the mission that it shows: plans, verdicts, saves and progress."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.web.conftest import open_page
from tests.web.drawing import COMPILING_MS, document, judged, mission_id, open_example, saved
from tests.web.planned import SMALL, planned_mission

pytestmark = pytest.mark.browser


def kept(server: Any, changed: dict[str, Any] | None = None) -> str:
    """A mission on the server, by its id."""
    answer = httpx.post(f"{server.url}/api/missions", json={"document": {**SMALL, **(changed or {})}})
    return str(answer.raise_for_status().json()["id"])


def one_of(page: Any, held: list[Any], but: Any = None) -> Any:
    """The first request that was held, or comes yet, another than one that was answered."""
    for _ in range(1000):
        if found := [route for route in held if route is not but]:
            return found[-1]
        page.wait_for_timeout(20)
    raise AssertionError("nothing was asked")


@pytest.fixture
def planned(new_page: Any, page_server: Any) -> Iterator[Any]:
    """The page with the planned mission, which is in the end as it was."""
    mission = planned_mission(page_server.url)
    page = open_page(new_page, page_server, f"#mission={mission}")
    expect(page.locator("#mission-name")).to_have_text("small")
    yield page
    httpx.put(f"{page_server.url}/api/missions/{mission}", json={"document": SMALL}).raise_for_status()


@pytest.mark.slow  # plans, edits and looks
def test_a_plan_says_that_its_mission_has_changed_since_and_how(planned: Any) -> None:
    page = planned
    period = page.locator("#mission-form").get_by_label("Period (s)")
    period.fill("20")
    page.locator("#tab-watch").click()
    change = "area period 60 → 20 s"
    expect(page.locator("#watching")).to_contain_text(
        f"Stale: the mission has changed since this plan was made.{change}"
    )
    assert (
        page.locator("#player-controls .rota-verdict").evaluate("e => getComputedStyle(e).textDecorationLine")
        == "line-through"
    )
    page.locator("#tab-take").click()
    expect(page.locator("#downloads")).to_contain_text(change)
    expect(page.locator("#downloads > p").first).not_to_contain_text("met")
    with page.expect_download(timeout=COMPILING_MS) as told:
        page.locator("[data-download='csv']").click()
    assert told.value.suggested_filename == "small-stale.csv"
    page.locator("#tab-plan").click()
    row = page.locator("#plans tbody tr").first
    expect(row.locator(".state").first).to_have_text("stale")
    expect(page.locator("#plans tbody .why")).to_have_text(change)
    page.locator("#tab-edit").click()
    period.fill("60")  # as it was
    page.locator("#tab-plan").click()
    expect(row.locator(".state").first).to_have_text("met")
    page.locator("#tab-watch").click()
    expect(page.locator("#player-controls")).to_be_visible()
    expect(page.locator("#watching")).to_have_text("")


def test_no_plan_is_said_to_hold_while_an_edit_is_not_saved(planned: Any) -> None:
    page = planned
    held: list[Any] = []
    page.route(
        "**/api/missions/*", lambda route: held.append(route) if route.request.method == "PUT" else route.continue_()
    )
    page.locator("#mission-form").get_by_label("Period (s)").fill("25")
    page.locator("#tab-plan").click()
    expect(page.locator("#plans tbody tr .state").first).to_have_text("checking…")
    page.locator("#tab-watch").click()
    expect(page.locator("#watching")).to_contain_text("whether the plan still holds is known once it is saved")
    one_of(page, held).continue_()
    expect(page.locator("#watching")).to_contain_text("area period 60 → 25 s")
    page.unroute("**/api/missions/*")


@pytest.mark.slow  # opens mission after mission
def test_a_mission_that_has_a_plan_shows_it_when_it_is_opened(planned: Any, page_server: Any) -> None:
    page = planned
    page.locator("#tab-watch").click()
    expect(page.locator("#player-controls .rota-verdict")).to_have_text("met")
    page.locator("#tab-take").click()
    expect(page.locator("#downloads")).to_contain_text("Of the plan small")
    kept(page_server, {"name": "unplanned"})
    page.get_by_role("button", name="Missions…").click()
    page.locator("#missions").get_by_role("button", name="unplanned", exact=True).first.click()
    for tab in ("take", "watch"):
        page.locator(f"#tab-{tab}").click()
        expect(page.locator(f"#panel-{tab}")).to_contain_text("There is no plan yet")
    page.locator("#tab-plan").click()
    expect(page.locator("#plans")).to_contain_text("No plan of this mission yet")
    page.get_by_role("button", name="Missions…").click()
    page.locator("#missions").get_by_role("button", name="small", exact=True).first.click()
    expect(page.locator("#mission-name")).to_have_text("small")
    page.locator("#tab-take").click()
    expect(page.locator("#downloads")).to_contain_text("Of the plan small")


def test_the_verdict_of_one_mission_never_stands_beside_another(new_page: Any, page_server: Any) -> None:
    bad = kept(page_server, {"name": "bad", "fleet": {**SMALL["fleet"], "robots": 100_000}})  # type: ignore[dict-item]
    kept(page_server, {"name": "good"})
    page = open_page(new_page, page_server, f"#mission={bad}")
    assert "100000 is not allowed" in judged(page)
    held: list[Any] = []
    page.route("**/api/validate*", lambda route: held.append(route))
    page.get_by_role("button", name="Missions…").click()
    page.locator("#missions").get_by_role("button", name="good", exact=True).first.click()
    expect(page.locator("#mission-name")).to_have_text("good")
    expect(page.locator("#verdict")).to_have_text("Checking the mission…")
    assert page.locator("#fleet-form").inner_text().count("not allowed") == 0
    before = one_of(page, held)
    # an edit is under way when the answer to what stood before it comes
    page.evaluate(
        "() => { window.seen = []; const verdict = document.querySelector('#verdict');"
        " new MutationObserver(() => window.seen.push(verdict.textContent)).observe(verdict, { childList: true }); }"
    )
    page.locator("#mission-form").get_by_label("Period (s)").fill("0")
    before.fulfill(json={"faults": [], "warnings": [], "ground": None, "bound": {"robots": 77, "reason": "late"},
                          "compiling": False, "free_m2": 1.0, "asked_m2_s": 1.0})  # fmt: skip
    one_of(page, held, but=before).continue_()
    expect(page.locator("#verdict")).to_contain_text("Period: 0 is not allowed")
    page.unroute("**/api/validate*")
    assert not [text for text in page.evaluate("window.seen") if "77" in text]


@pytest.mark.slow  # two pages
def test_two_tabs_cannot_overwrite_each_other(new_page: Any, page_server: Any, faults: Any) -> None:
    faults.refusals_expected = True
    mission = kept(page_server, {"name": "shared"})
    page = open_page(new_page, page_server, f"#mission={mission}")
    other = page.context.new_page()
    open_page(other, page_server, f"#mission={mission}")
    for tab, value in ((other, "50"), (page, "40")):
        tab.locator("#mission-form").get_by_label("Period (s)").fill(value)
        if tab is other:
            saved(other)
    expect(page.locator("#conflict")).to_be_visible()
    expect(page.locator("#saved")).to_contain_text("NOT SAVED: changed elsewhere")
    assert document(other)["period_s"] == 50
    page.get_by_role("button", name="Keep mine").click()
    saved(page)
    expect(page.locator("#conflict")).to_be_hidden()
    assert document(page)["period_s"] == 40
    other.locator("#mission-form").get_by_label("Period (s)").fill("30")
    expect(other.locator("#conflict")).to_be_visible()
    other.get_by_role("button", name="Reload").click()
    saved(other)
    expect(other.locator("#mission-form").get_by_label("Period (s)")).to_have_value("40")
    other.locator("#mission-form").get_by_label("Period (s)").fill("35")
    saved(other)
    # who comes back with nothing of their own sees what is new
    page.evaluate("window.dispatchEvent(new Event('focus'))")
    expect(page.locator("#mission-form").get_by_label("Period (s)")).to_have_value("35")
    expect(page.locator("#notices")).to_contain_text("changed elsewhere")
    other.close()


def test_a_save_that_the_server_could_not_make_is_made_again(new_page: Any, page_server: Any, faults: Any) -> None:
    faults.refusals_expected = True
    page = open_page(new_page, page_server, f"#mission={kept(page_server)}")
    full = {"error": {"message": "the disk of the data folder is full", "faults": []}}
    page.route("**/api/missions/*", lambda route: route.fulfill(status=507, json=full), times=1)
    page.locator("#mission-form").get_by_label("Period (s)").fill("45")
    expect(page.locator("#saved")).to_contain_text("NOT SAVED: the disk of the data folder is full; it is tried again")
    saved(page)
    assert document(page)["period_s"] == 45


@pytest.mark.slow  # opens three examples
def test_an_example_opened_again_is_the_same_mission(page: Any) -> None:
    open_example(page, "coast")
    first = mission_id(page)
    open_example(page, "harbour")
    saved(page)
    open_example(page, "coast")
    assert mission_id(page) == first


@pytest.mark.slow  # watches a search
def test_planning_tells_of_itself_at_once_never_falls_back_and_shows_its_best_plan(
    new_page: Any, page_server: Any
) -> None:
    zones = [{"name": "gate", "period_s": 12, "ring": [[65, 45], [80, 45], [80, 60], [65, 60]]}]
    area = [[0, 0], [80, 0], [80, 60], [50, 60], [50, 40], [0, 40]]
    fleet = {**SMALL["fleet"], "sensor": {"shape": "disc", "radius_m": 5}}  # type: ignore[dict-item]
    yard = {"area": area, "zones": zones, "fleet": fleet, "patrol": {"effort": "quick"}}
    page = open_page(new_page, page_server, f"#mission={kept(page_server, yard)}&tab=plan")
    page.evaluate(
        "() => { window.shares = []; window.words = new Set(); const look = () => {"
        " const bar = document.querySelector('#jobs progress'), said = document.querySelector('#jobs [data-job]');"
        " if (bar?.hasAttribute('value')) window.shares.push(bar.value);"
        " if (said) window.words.add(said.textContent); };"
        " new MutationObserver(look).observe(document.querySelector('#jobs'),"
        " { childList: true, subtree: true, characterData: true }); }"
    )
    page.get_by_role("button", name="Plan", exact=True).click()
    expect(page.locator("#plans tbody tr")).to_have_count(1, timeout=COMPILING_MS)
    if page.locator("#jobs progress").count():
        expect(page.locator("#plans tbody tr")).to_contain_text("so far")
        page.locator("#tab-take").click()
        expect(page.locator("#downloads")).to_contain_text("the best plan so far")
        page.locator("#tab-plan").click()
    expect(page.locator("#jobs progress")).to_have_count(0, timeout=COMPILING_MS)
    shares = page.evaluate("window.shares")
    assert shares == sorted(shares)
    assert len(set(shares)) >= 2
    words = [told for told in page.evaluate("[...window.words]") if "Waiting" not in told]
    assert re.match(r"(starting|looking at the mission) · \d s", words[0])
    assert all(re.search(r"\d s", told) for told in words)


@pytest.mark.slow  # opens the page twice
def test_what_a_crash_interrupted_is_told_once(new_page: Any, page_server: Any) -> None:
    job = {
        "id": "0" * 16, "mission": None, "mission_name": "yard", "state": "interrupted", "planner": "patrol",
        "effort": None, "seed": 0, "time_limit_s": None, "revision": 1, "created_at": "", "started_at": None,
        "ended_at": None,
        "progress": {"fraction": 1, "doing": "", "elapsed_s": 3, "left_s": None}, "best": None,
        "message": "the server ended", "plan": None, "place_in_queue": None,
    }  # fmt: skip
    new_page.route("**/api/jobs", lambda route: route.fulfill(json=[job]))
    page = open_page(new_page, page_server)
    expect(page.locator("#notices")).to_contain_text("Planning of yard was interrupted")
    open_page(page, page_server)
    page.locator("#tab-plan").click()
    expect(page.locator("#jobs")).to_contain_text("interrupted")
    assert page.locator("#notices").inner_text() == ""


def listed(**values: Any) -> dict[str, Any]:
    """A plan as the server lists it."""
    return {
        "id": "1" * 16, "name": "still", "mission": None, "job": None, "planner": "swarm", "effort": None,
        "created_at": "", "robots": 3, "bound": None, "bound_reason": None, "verdict": "met", "worst_ratio": 0,
        "length_m": 0, "plan_s": 2.0, "partial": False, "facts": [], "revision": None, "stale": [], **values,
    }  # fmt: skip


def test_swarms_have_no_periods_and_robots_at_rest_no_length(new_page: Any, page_server: Any) -> None:
    long = {
        "planner": "patrol",
        "effort": "normal",
        "bound": 888,
        "worst_ratio": 0.999,
        "length_m": 88_888,
        "plan_s": 888,
    }
    plans = [listed(), listed(id="2" * 16, robots=999, partial=True, stale=["area period 180 → 60 s"] * 9, **long)]
    new_page.route("**/api/plans", lambda route: route.fulfill(json=plans))
    page = open_page(new_page, page_server, "#tab=plan")
    page.get_by_label("also those of other missions").check()
    row = page.locator("#plans tbody tr").first
    assert row.locator("td").all_inner_texts()[2:5] == ["–", "–", "–"]
    for width in (1400, 1280):  # nothing is cut off
        page.set_viewport_size({"width": width, "height": 800})
        assert page.locator("#plans .scroll").evaluate("e => e.scrollWidth - e.clientWidth") <= 1


def test_the_map_stays_where_it_is_from_step_to_step_and_long_names_keep_to_one_line(
    new_page: Any, page_server: Any
) -> None:
    name = "a name that goes on and on, as the names of missions do which come from files of others " * 2
    page = open_page(new_page, page_server, f"#mission={kept(page_server, {'name': name})}")
    expect(page.locator("#mission-name")).to_have_attribute("title", name)
    assert page.locator("header").bounding_box()["height"] < 60
    boxes = []
    for tab in ("edit", "plan", "watch", "take"):
        page.locator(f"#tab-{tab}").click()
        boxes.append(page.locator("#map").bounding_box())
    assert all(box == boxes[0] for box in boxes)
