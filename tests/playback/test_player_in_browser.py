"""The player in a browser against Python, in pages that are opened from disk without a network."""

from __future__ import annotations

import gzip
import re
from base64 import b64decode
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from tests.browser import offline_page as offline_page, until
from tests.draw.conftest import loop
from tests.live.two_robots import two_robots
from tests.playback.container_reader import unpack
from tests.playback.plans import spreading, yard
from tests.playback.reference import ages_s
from tests.relieved import relieved

from rota import Plan, check_plan, replan
from rota.check.batteries import batteries_of
from rota.model.mission import MovingObstacle
from rota.playback.page import page_text
from rota.routes.flights import on_charger

if TYPE_CHECKING:
    from playwright.sync_api import Page

pytestmark = pytest.mark.browser

Open = Callable[[Plan], Any]
AGES = """([times, lost]) => {
  const { playback } = rotaPlayer;
  rotaPlayer.losses.lost = new Map(lost);
  return Promise.all(times.map(async (time) => {
    const { agesInto, stopsOf } = await import("rota/ages.js");
    return [...agesInto(playback, time, stopsOf(playback, new Map(lost)), new Float64Array(playback.entries))];
  }));
}"""


PLANS = ("yard", "lane", "drifting", "taken over", "floor")


@cache
def plans() -> dict[str, Plan]:
    """The plans of ``PLANS``, made once."""
    drifting = two_robots()
    ways = (drifting.trajectories[0], loop("b", [(99, 1), (70, 1), (70, 3), (99, 3)], 4.3))
    floor = spreading()
    cart = MovingObstacle(radius_m=0.5, times_s=(0, 8), positions_m=((1, 1), (19, 1)))
    return {
        "yard": yard(),
        "lane": two_robots(),
        "drifting": replace(drifting, trajectories=ways),
        "taken over": replan(drifting, at_s=33.0, lost=["b"], should_stop=lambda: True).plan,
        "floor": replace(floor, mission=replace(floor.mission, moving_obstacles=(cart,))),
    }


@pytest.fixture
def opened(offline_page: Page, tmp_path: Path) -> Open:
    """Opens the page of a plan from disk; returns the playback that it holds."""

    def open_page(plan: Plan) -> Any:
        file = tmp_path / "plan.html"
        file.write_text(page_text(plan, check_plan(plan), cells=2000), encoding="utf-8")
        offline_page.goto(file.as_uri())
        until(offline_page, "Boolean(window.rotaPlayer)")
        packed = offline_page.locator("#playback").text_content()
        return unpack(gzip.decompress(b64decode(packed or "")))

    return open_page


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in ("lane", "drifting", "floor"))) for name in PLANS]
)
def test_ages_in_the_browser_are_those_of_python(opened: Open, offline_page: Page, name: str) -> None:
    header, arrays = opened(plans()[name])
    end_s = header["clock"]["end_s"]
    times_s = [0.0, 1.7, 0.31 * end_s, end_s, 3.3 * end_s + 0.123]
    some = np.arange(0, len(arrays["cell_index"]), max(1, len(arrays["cell_index"]) // 300))
    some = np.union1d(some, np.flatnonzero(arrays["cell_index"] == 0xFFFFFFFF))
    thinned = only(arrays, some)
    for lost in ({}, {0: 0.4 * end_s}):
        told = offline_page.evaluate(AGES, [times_s, [[robot, when_s] for robot, when_s in lost.items()]])
        for time_s, ages in zip(times_s, told, strict=True):
            mine = np.array([np.inf if age is None else age for age in ages], np.float64)[some]
            assert mine == pytest.approx(ages_s(header, thinned, time_s, lost), abs=1e-6 * max(1.0, time_s)), time_s


def only(arrays: dict[str, Any], some: Any) -> dict[str, Any]:
    """The arrays of some entries alone."""
    rows = [np.arange(arrays["sight_offsets"][entry], arrays["sight_offsets"][entry + 1]) for entry in some]
    kept = np.concatenate(rows).astype(int)
    offsets = np.cumsum([0, *map(len, rows)])
    sights = {name: arrays[name][kept] for name in ("sight_robot", "sight_start_s", "sight_end_s", "sight_loops")}
    of_entries = {name: arrays[name][some] for name in ("cell_index", "cell_before_s") if name in arrays}
    return {**of_entries, "sight_offsets": offsets, **sights}


COLOUR = """([canvas, x, y]) => {
  rotaPlayer.draw();
  const stage = rotaPlayer._stage;
  const [px, py] = stage.toPixels(x, y);
  const context = stage.contexts[canvas];
  return [...context.getImageData(Math.round(px * stage.ratio), Math.round(py * stage.ratio), 1, 1).data];
}"""
AWAY_PX = """[0, 2].map((k) => {
  const { robots, playback, _stage: stage } = rotaPlayer;
  const [x, y] = playback.header.mission.chargers[0].at;
  return Math.hypot(robots.places[2 * k] - x, robots.places[2 * k + 1] - y) * stage.pixelsPerMetre;
})"""
CHARGES = """([times]) => {
  const { playback } = rotaPlayer;
  return times.map((time) => playback.robots.map((_, k) => [playback.charge(k, time), playback.chargerAt(k, time)]));
}"""


def test_batteries_in_the_browser_are_those_of_films_and_who_charges_stands_beside_its_charger(
    opened: Open, offline_page: Page
) -> None:
    plan = relieved(3)
    _, arrays = opened(plan)
    times_s = [0.0, 10, 170, 190, 330, 350, 479.9, 480, 650, 4800 + 190, 48000 + 330]
    told = np.array(offline_page.evaluate(CHARGES, [times_s]), np.float64)
    shares = [[battery.share_at(time_s) for battery in batteries_of(plan)] for time_s in times_s]  # type: ignore[union-attr]
    assert told[..., 0] == pytest.approx(np.array(shares), abs=1e-6)
    docked = np.array([on_charger(trajectory, np.array(times_s)) for trajectory in plan]).T
    assert ((told[..., 1] == 0) == docked).all()
    assert ((told[..., 1] == -1) == ~docked).all()
    # nobody is seen by who charges: at 250 s robots 1 and 3 do
    seen_by = arrays["sight_robot"][(arrays["sight_start_s"] <= 250) & (arrays["sight_end_s"] >= 250)]
    assert set(seen_by) == {1}
    offline_page.evaluate("rotaPlayer.seek(250)")
    rows = offline_page.locator(".rota-player tbody tr", has=offline_page.get_by_role("button", name="Lost"))
    texts: list[str] = []
    for _ in range(500):  # the table is told anew with the next picture, and may be so between two of its rows
        before, texts = texts, [rows.nth(k).locator("td").nth(2).text_content() or "" for k in range(3)]
        if before == texts and ", on " in texts[0]:
            break
        offline_page.wait_for_timeout(20)
    assert [", on " in text for text in texts] == [True, False, True]
    percents = [float(text.split(" ")[0]) for text in texts]
    # a flight takes 180 of 400 s, a second of charging gives back two: 70 s and 70 + 160 s on the pad fill it
    assert percents == pytest.approx([100 * (220 + 140) / 400, 100 * (400 - 90) / 400, 100], abs=0.5)
    away_px = offline_page.evaluate(AWAY_PX)
    assert away_px == pytest.approx([24, 24])
    assert offline_page.evaluate(COLOUR, ["shapes", 0.0, 0.0])[:3] == [34, 34, 34], "a bolt marks the charger"


def test_a_cross_stands_where_a_robot_was_lost_before_the_plan_took_over(opened: Open, offline_page: Page) -> None:
    before = two_robots()
    opened(replan(before, at_s=107.0, lost=["b"], should_stop=lambda: True).plan)
    assert offline_page.locator(".rota-player", has_text="0:00.0 is 1:47.0 of the plan before; lost: b.").count() == 1
    x, y = before["b"].at([107.0])[0]
    red, green, blue, alpha = offline_page.evaluate(COLOUR, ["shapes", float(x), float(y)])
    assert alpha > 200
    assert red > 2 * max(green, blue)


def test_a_lost_robot_shows_what_lapses_and_undo_takes_it_back(opened: Open, offline_page: Page) -> None:
    header, arrays = opened(two_robots())
    page = offline_page
    page.evaluate("rotaPlayer.seek(100)")
    page.get_by_role("button", name="Lost: b").click()
    lapses = page.evaluate("rotaPlayer.losses.zones")
    told = {header["demands"][zone["demand"]]["name"]: zone for zone in lapses}
    # alone, a passes the end of the lane every 40 s and the gate every 20 s; the zone left asks for 25 s
    assert set(told) == {"left"}
    period_s = 25.0
    ages, entries = (
        ages_s(header, arrays, 100.0),
        arrays["cell_demand"]
        == list(header["demands"]).index(next(demand for demand in header["demands"] if demand["name"] == "left")),
    )
    assert told["left"]["first"] == pytest.approx(first_lapse_s(header, arrays, entries, period_s), abs=0.051)
    assert told["left"]["area"] == pytest.approx(2.0, rel=0.3)
    assert ages[entries].max() < period_s
    assert page.get_by_role("heading", name="Lost robots").is_visible()
    page.get_by_role("button", name="left").last.click()
    assert page.evaluate("rotaPlayer.clock.time") == pytest.approx(told["left"]["first"])
    page.keyboard.press("Shift+ArrowRight")
    until(page, "document.querySelector('.rota-late-now').textContent.includes('of left')")
    page.get_by_role("button", name="Undo").click()
    assert page.evaluate("rotaPlayer.losses.zones") == []
    assert not page.get_by_role("heading", name="Lost robots").is_visible()


LAPSES = """async (from) => {
  const { lapsesFrom, stopsOf } = await import("rota/ages.js");
  const { playback } = rotaPlayer;
  return [...lapsesFrom(playback, from, stopsOf(playback, new Map([[0, from]])))];
}"""


def test_every_place_lapses_when_its_age_says_so(opened: Open, offline_page: Page) -> None:
    header, arrays = opened(plans()["drifting"])
    from_s, step_s = 130.0, 0.25
    told = np.array([np.inf if at is None else at for at in offline_page.evaluate(LAPSES, from_s)], np.float64)
    some = np.arange(0, len(told), max(1, len(told) // 50))
    periods_s = np.array([demand["period_s"] for demand in header["demands"]])[arrays["cell_demand"][some]]
    first_s = np.full(len(some), np.inf)
    for time_s in np.arange(from_s, from_s + 125.0, step_s):
        late = ages_s(header, only(arrays, some), float(time_s), {0: from_s}) > periods_s + 1e-3
        first_s[late] = np.minimum(first_s[late], time_s)
    told = told[some]
    assert 5 < np.isfinite(first_s).sum() < len(some)
    assert told[np.isfinite(first_s)] == pytest.approx(first_s[np.isfinite(first_s)], abs=step_s)
    assert (told[np.isinf(first_s)] > from_s + 125.0 - step_s).all()


def test_time_goes_round_where_all_loops_share_a_period(opened: Open, offline_page: Page) -> None:
    header, _ = opened(two_robots())
    clock = header["clock"]
    assert clock["repeat_s"] == pytest.approx(40.0)
    offline_page.evaluate(f"rotaPlayer.seek({clock['end_s'] - 0.2}); rotaPlayer.setSpeed(2); rotaPlayer.toggle()")
    until(offline_page, f"rotaPlayer.clock.time < {clock['end_s'] - 30.0}")
    assert offline_page.evaluate("rotaPlayer.clock.time") > clock["end_s"] - clock["repeat_s"]
    now_s = clock["end_s"] - 3.0
    before, after = offline_page.evaluate(AGES, [[now_s, now_s - clock["repeat_s"]], []])
    assert before == pytest.approx(after, abs=1e-6)


def first_lapse_s(header: Any, arrays: Any, entries: Any, period_s: float) -> float:
    """When the first of some entries is older than its period, without robot 1 from 100 s on, looked up in steps."""
    thinned = only(arrays, np.flatnonzero(entries))
    for time_s in np.arange(100.0, 160.0, 0.05):
        if (ages_s(header, thinned, float(time_s), {1: 100.0}) > period_s).any():
            return float(time_s)
    return np.inf


def test_the_controls_work_by_keyboard_and_name(opened: Open, offline_page: Page) -> None:
    header, _ = opened(yard())
    page = offline_page
    # all loops have begun, and what is ever seen was seen
    assert page.evaluate("rotaPlayer.clock.time") >= header["clock"]["from_s"]
    page.keyboard.press("Space")
    until(page, f"rotaPlayer.clock.time > {header['clock']['from_s'] + 0.5}")
    page.keyboard.press("Space")
    page.get_by_role("button", name="Play").wait_for()
    page.get_by_role("button", name="From the start").click()
    page.locator("body").press("ArrowRight")
    assert page.evaluate("rotaPlayer.clock.time") == pytest.approx(1.0)
    page.get_by_label("Time", exact=True).fill("50")
    assert page.evaluate("rotaPlayer.clock.time") == pytest.approx(50.0)
    page.get_by_label("Speed").select_option("100")
    assert page.evaluate("rotaPlayer.clock.speed") == 100
    page.get_by_label("Colours show").select_option("worst")
    page.get_by_label("Footprints").uncheck()
    assert page.evaluate("[rotaPlayer.mode, rotaPlayer.shown.footprints]") == ["worst", False]
    page.get_by_label("On the clock").check()
    now_s = "(Date.now() - new Date(document.querySelector('input[type=datetime-local]').value)) / 1000"
    until(page, f"Math.abs(rotaPlayer.clock.time - {now_s}) < 1")
    page.get_by_role("button", name="shed").click()
    assert "Zone shed, to be visited: at least once in 90 s" in page.locator(".rota-section").all_inner_texts()[2]


def test_a_click_on_the_map_finds_the_place_and_the_robot(opened: Open, offline_page: Page) -> None:
    header, _ = opened(yard())
    page = offline_page
    page.evaluate("rotaPlayer.seek(20)")
    until(page, "rotaPlayer.robots.places[8] !== 0")
    box = page.locator("#map").bounding_box()
    assert box
    page.evaluate("rotaPlayer.map.setView([40, 45], rotaPlayer.map.getZoom() + 0.5, { animate: false })")
    for x, y in ((0.0, 0.0), (100.0, 0.0), (33.0, 77.0)):
        leaflets = page.evaluate(f"(({{ x, y }}) => [x, y])(rotaPlayer.map.latLngToContainerPoint([{y}, {x}]))")
        assert page.evaluate(f"rotaPlayer._stage.toPixels({x}, {y})") == pytest.approx(leaflets, abs=1.0)
    page.evaluate("rotaPlayer.map.setView([52, 48], rotaPlayer.map.getZoom() - 0.5, { animate: false })")
    for (x, y), chosen in (((60.0, 90.0), "chosenEntry"), ((20.0, 50.0), "chosenRobot")):
        px, py = page.evaluate(f"rotaPlayer._stage.toPixels({x}, {y})")
        page.mouse.click(box["x"] + px, box["y"] + py)
        found = page.evaluate(f"rotaPlayer.{chosen}")
        assert found >= 0
        if chosen == "chosenRobot":
            assert header["robots"][found]["name"] == "robot-5"
        else:
            half = header["grid"]["cell_m"] / 2
            assert page.evaluate(f"rotaPlayer.playback.middleOf({found})") == pytest.approx([x, y], abs=half + 0.5)
    assert "Place (" in page.locator(".rota-player").inner_text()


def test_a_violation_leads_to_its_place_and_time(opened: Open, offline_page: Page) -> None:
    plan = yard()
    fast = replace(plan, mission=replace(plan.mission, fleet=replace(plan.mission.fleet, speed_m_s=9)))
    header, _ = opened(fast)
    wrong = next(v for v in header["report"]["violations"] if v["time_s"] and v["place_m"])
    offline_page.get_by_role("button", name=wrong["text"]).click()
    assert offline_page.evaluate("rotaPlayer.clock.time") == pytest.approx(wrong["time_s"])
    assert offline_page.evaluate("rotaPlayer._mark") == pytest.approx(wrong["place_m"])


def test_a_fleet_is_shown_where_it_really_is(opened: Open, offline_page: Page) -> None:
    _, arrays = opened(two_robots())
    page = offline_page
    ages = [None, *[5.0] * (len(arrays["cell_index"]) - 2), 99.0]  # the last entry is the zone to visit
    state = {"time_s": 77.0, "robots": [{"robot": 0, "x_m": 12.5, "y_m": 1.0, "lost": False}], "ages": ages}
    page.evaluate("(state) => rotaPlayer.showLive(state)", state)
    until(page, "document.querySelector('.rota-time').textContent === '1:17.0'")
    assert page.evaluate("[rotaPlayer.robots.places[0], rotaPlayer.robots.places[1]]") == [12.5, 1.0]
    assert page.get_by_label("Time", exact=True).is_disabled()
    assert "the visit of gate" in page.locator(".rota-late-now").inner_text()
    assert page.get_by_text("Live:").is_visible()
    page.evaluate("rotaPlayer.showLive(null)")
    until(page, "document.querySelector('.rota-late-now').textContent === 'Nothing is late now.'")
    assert not page.get_by_text("Live:").is_visible()
    page.get_by_role("button", name="Play").click()
    until(page, "rotaPlayer.clock.playing")


@pytest.mark.parametrize(("scheme", "width"), [pytest.param("light", 1400, marks=pytest.mark.slow), ("dark", 360)])
def test_everybody_can_use_it(opened: Open, offline_page: Page, scheme: Any, width: int) -> None:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    offline_page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
    offline_page.set_viewport_size({"width": width, "height": 900})
    opened(yard())
    offline_page.evaluate("rotaPlayer.choosePlace(0); rotaPlayer.toggleLoss(0)")
    found = axe.run(offline_page).response["violations"]
    assert [(wrong["id"], [node["html"] for node in wrong["nodes"]]) for wrong in found] == []
    assert offline_page.evaluate("document.documentElement.scrollWidth") <= width


def test_the_page_reads_without_scripts_and_no_name_becomes_markup(opened: Open, offline_page: Page) -> None:
    plan = yard()
    text = page_text(plan, check_plan(plan), cells=100)
    assert "</script><b>&pond" not in text
    assert "&lt;/script&gt;&lt;b&gt;&amp;pond" in text
    assert not re.search(r"(?:src|href)=|url\(|@import", re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL))
    opened(plan)
    assert offline_page.locator("b").count() == 0
    assert offline_page.get_by_role("button", name="</script><b>&pond").is_visible()
    context = offline_page.context.browser.new_context(java_script_enabled=False, offline=True)  # type: ignore[union-attr]
    page = context.new_page()
    page.goto(offline_page.url)
    words = page.locator("body").inner_text()
    assert "The map needs JavaScript" in words
    assert "5 robots; no plan with fewer than 2 exists, proved. Verdict: violated." in words
    assert "</script><b>&pond" in words
    context.close()
