"""Drawing and changing missions by mouse and by keyboard."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import expect
from tests.web.conftest import open_page
from tests.web.drawing import (
    COMPILING_MS,
    changed_area,
    click_map,
    document,
    drag_map,
    draw_polygon,
    draw_two,
    judged,
    mission_id,
    new_mission,
    open_example,
    saved,
    tool,
)

from rota import read_mission

pytestmark = pytest.mark.browser


@pytest.fixture
def page(used_page: Any) -> Any:
    """The page, which tests of this file take over from each other."""
    return used_page


SQUARE = [(100, 500), (500, 500), (500, 100), (100, 100)]
EXAMPLES = Path(__file__).parents[2] / "examples"


def test_what_is_drawn_is_kept_and_undone(page: Any, page_server: Any) -> None:
    new_mission(page)
    assert "Draw the area" in judged(page)
    expect(page.locator("#saved")).to_have_text("nothing to save yet")
    page.locator("#fleet-form").get_by_label("Sensor's radius (m)").fill("10")  # so that one robot cannot do
    draw_polygon(page, "Area", *SQUARE)
    draw_two(page, "Zone", "Circle", (200, 200), (240, 200))
    draw_two(page, "Obstacle", "Rectangle", (300, 300), (400, 400))
    tool(page, "Start", "Point")
    click_map(page, (450, 450))
    tool(page, "Entrance", "Point")
    click_map(page, (120, 480))
    tool(page, "Entrance", "Point")
    click_map(page, (480, 120))
    assert "Starts: 1 start is given, and at least 2 robots are needed" in judged(page)
    kept = document(page)
    side = kept["area"][1][0] - kept["area"][0][0]
    assert len(kept["area"]) == 4
    assert side > 100
    # pixels are so many metres: the circle's radius is a tenth of the square's side, the rectangle's side a quarter
    assert kept["zones"][0]["circle"]["radius_m"] == pytest.approx(side / 10, abs=0.01)
    assert kept["obstacles"][0][2][0] - kept["obstacles"][0][0][0] == pytest.approx(side / 4, abs=0.01)
    assert len(kept["fleet"]["start"]["points"]) == 1
    assert len(kept["fleet"]["entrances"]) == 2
    assert kept["fleet"]["entrances"][1][0] - kept["fleet"]["entrances"][0][0] == pytest.approx(0.9 * side, rel=0.01)

    page.keyboard.press("Control+z")
    page.keyboard.press("Control+z")
    assert "entrances" not in document(page)["fleet"]
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+z")
    assert document(page)["obstacles"] == []
    assert "start" not in document(page)["fleet"]
    for _ in range(3):
        page.keyboard.press("Control+Shift+z")
    page.get_by_role("button", name="Redo").click()
    assert document(page) == kept
    expect(page.get_by_role("button", name="Redo")).to_be_disabled()

    open_page(page, page_server, page.url.split("/")[-1])
    assert document(page) == kept
    expect(page.locator("#shape-list .card")).to_have_count(5)


def test_shapes_are_changed_moved_and_deleted_by_mouse(page: Any) -> None:
    new_mission(page)
    draw_polygon(page, "Area", *SQUARE)
    before = document(page)["area"]
    drag_map(page, SQUARE[2], (560, 60))
    moved = changed_area(page, before)
    assert moved[2][0] > before[2][0]
    assert moved[2][1] > before[2][1]
    assert moved[:2] == before[:2]
    # the handle in the middle of an edge makes a corner of it
    drag_map(page, (300, 500), (300, 560))
    cornered = changed_area(page, moved)
    assert len(cornered) == 5
    page.get_by_role("button", name="Move", exact=True).click()
    drag_map(page, (300, 300), (330, 300))
    shifted = changed_area(page, cornered)
    step = shifted[0][0] - cornered[0][0]
    assert step > 1
    assert [x - step for x, _ in shifted] == pytest.approx([x for x, _ in cornered], abs=0.01)
    assert [y for _, y in shifted] == pytest.approx([y for _, y in cornered], abs=0.01)
    page.get_by_role("button", name="Delete Area").first.click()
    assert document(page)["area"] == []
    page.get_by_role("button", name="Undo").last.click()
    assert document(page)["area"] == shifted


def test_a_shape_is_dragged_on_while_the_server_answers(page: Any) -> None:
    asked: list[Any] = []
    page.route("**/api/validate?*", lambda route: asked.append(route), times=2)  # empty mission, then square
    new_mission(page)
    draw_polygon(page, "Area", *SQUARE)
    before = document(page)["area"]
    box = page.locator("#map").bounding_box()
    x, y = box["x"] + SQUARE[2][0], box["y"] + SQUARE[2][1]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y - 20)
    asked[-1].continue_()
    assert judged(page) != ""
    page.mouse.move(x + 60, y - 40)
    page.mouse.up()
    assert changed_area(page, before)[2][0] > before[2][0]


def test_drawing_can_be_given_up_and_corners_taken_back(page: Any) -> None:
    new_mission(page)
    tool(page, "Area", "Polygon")
    click_map(page, (100, 100), (200, 100), (300, 300))
    page.keyboard.press("Backspace")
    click_map(page, (200, 250), (100, 250))
    page.get_by_role("button", name="Close the polygon").click()
    assert len(document(page)["area"]) == 4
    tool(page, "Zone")
    click_map(page, (120, 120))
    page.keyboard.press("Escape")
    expect(page.get_by_role("button", name="Zone", exact=True)).to_have_attribute("aria-pressed", "false")
    assert document(page)["zones"] == []


def test_a_mission_is_drawn_without_a_mouse(page: Any) -> None:
    new_mission(page)
    page.get_by_text("Without a mouse").focus()
    page.keyboard.press("Enter")
    page.get_by_label("What to add").focus()
    page.get_by_role("button", name="Add by numbers").press("Enter")
    corners = [(0, 0), (60, 0), (60, 40), (0, 40)]
    for k, (x, y) in enumerate(corners, start=1):
        page.get_by_label(f"Corner {k}, x (m, east)").fill(str(x))
        page.get_by_label(f"Corner {k}, y (m, north)").fill(str(y))
    assert document(page)["area"] == [list(corner) for corner in corners]
    page.get_by_label("Add after corner 2").press("Enter")
    assert document(page)["area"][2] == [60, 20]
    page.get_by_label("Delete corner 3").press("Enter")
    page.get_by_label("What to add").select_option("zone")
    page.get_by_label("Its form").select_option("circle")
    page.get_by_role("button", name="Add by numbers").press("Enter")
    page.get_by_label("Centre 1, x").fill("30")
    page.get_by_label("Centre 1, y").fill("20")
    page.get_by_label("Radius in metres").fill("5.5")
    assert document(page)["zones"][0]["circle"] == {"centre": [30, 20], "radius_m": 5.5}
    assert "proved" in judged(page)


def test_numbers_of_zones_and_fleet_are_set_beside_the_map(page: Any) -> None:
    new_mission(page)
    draw_polygon(page, "Area", *SQUARE)
    draw_two(page, "Zone", "Rectangle", (150, 150), (250, 250))
    zone = page.locator(".card[data-kind=zone]")
    zone.get_by_label("Name").fill("gate")
    zone.get_by_label("Period (s)").fill("45")
    zone.get_by_label("Asked").select_option("visit")
    page.locator("#mission-form").get_by_label("Name").fill("yard")
    page.locator("#mission-form").get_by_label("Period (s)").fill("")
    fleet = page.locator("#fleet-form")
    fleet.get_by_label("Speed (m/s)").fill("2.5")
    fleet.get_by_label("Sensor", exact=True).select_option("square")
    fleet.get_by_label("Sensor's side (m)").fill("12")
    fleet.get_by_text("Body, turning, altitude").click()
    fleet.get_by_label("Turn rate (rad/s)").fill("0.8")
    fleet.get_by_label("Robots", exact=True).select_option("list")
    fleet.get_by_label("Name").nth(1).fill("second")
    fleet.get_by_label("Delete robot 3").click()
    kept = document(page)
    assert kept["name"] == "yard"
    assert kept["period_s"] is None
    assert {key: kept["zones"][0][key] for key in ("name", "period_s", "demand")} == {
        "name": "gate",
        "period_s": 45,
        "demand": "visit",
    }
    assert kept["fleet"]["speed_m_s"] == 2.5
    assert kept["fleet"]["sensor"] == {"shape": "square", "side_m": 12}
    assert kept["fleet"]["turn_rate_rad_s"] == 0.8
    assert [robot["name"] for robot in kept["fleet"]["robots"]] == ["robot-1", "second"]
    page.locator("#tab-plan").click()
    page.get_by_role("combobox", name="Planner", exact=True).select_option("swarm")
    page.get_by_label("Controller").select_option("voronoi")
    page.get_by_role("combobox", name="Planner", exact=True).select_option("patrol")
    page.get_by_label("Effort").select_option("high")
    kept = document(page)
    assert (kept["planner"], kept["patrol"]["effort"]) == ("patrol", "high")
    assert "swarm" not in kept


def test_kinds_of_robots_are_given_what_differs_and_what_one_costs(page: Any) -> None:
    new_mission(page)
    draw_polygon(page, "Area", *SQUARE)
    fleet = page.locator("#fleet-form")
    fleet.get_by_label("Robots", exact=True).select_option("kinds")
    cards = fleet.locator(".card")
    cards.nth(0).get_by_label("Name").fill("scout")
    cards.nth(0).get_by_label("Cost").fill("2.5")
    cards.nth(0).get_by_label("Most").fill("3")
    cards.nth(0).get_by_label("Speed (m/s)").fill("7")
    cards.nth(0).get_by_label("Sensor", exact=True).select_option("square")
    cards.nth(0).get_by_label("Sensor's side (m)").fill("12")
    cards.nth(1).get_by_label("Turn rate (rad/s)").fill("0.5")
    fleet.get_by_role("button", name="Add a kind").click()
    fleet.get_by_label("Delete kind 2").click()
    scout = {"name": "scout", "cost": 2.5, "most": 3, "speed_m_s": 7, "sensor": {"shape": "square", "side_m": 12}}
    assert document(page)["fleet"]["kinds"] == [scout, {"name": "kind-1", "cost": 1}]
    assert "robots" not in document(page)["fleet"]
    cards.nth(1).get_by_label("Cost").fill("-1")
    expect(cards.nth(1)).to_contain_text("-1 is not allowed; it must be greater than 0")
    cards.nth(1).get_by_label("Cost").fill("4")
    fleet.get_by_label("Robots", exact=True).select_option("fewest")
    assert "kinds" not in document(page)["fleet"]
    fleet.get_by_label("Robots", exact=True).select_option("kinds")
    assert document(page)["fleet"]["kinds"] == [scout, {"name": "kind-1", "cost": 4}]
    assert "proved" in judged(page)
    new_mission(page)  # which knows nothing of the kinds of another
    fleet.get_by_label("Robots", exact=True).select_option("kinds")
    assert document(page)["fleet"]["kinds"] == [{"name": "kind-1", "cost": 1}, {"name": "kind-2", "cost": 2}]


def test_batteries_and_chargers_are_given(page: Any) -> None:
    new_mission(page)
    draw_polygon(page, "Area", *SQUARE)
    fleet = page.locator("#fleet-form")
    fleet.get_by_label("Vehicle", exact=True).select_option("")  # patrol lets charge who changes speed at once
    fleet.get_by_text("Battery", exact=True).click()
    fleet.get_by_label("Endurance (s)").fill("600")
    fleet.get_by_label("Take-off and landing (s)").fill("30")
    assert "need at least one charger" in judged(page)
    tool(page, "Charger", "Point")
    click_map(page, (150, 450))
    charger = page.locator(".card[data-kind=charger]")
    charger.get_by_label("Places").fill("3")
    charger.get_by_label("Swaps batteries in (s)").fill("90")
    kept = document(page)
    assert {key: kept["fleet"][key] for key in ("endurance_s", "takeoff_s")} == {"endurance_s": 600, "takeoff_s": 30}
    assert {key: kept["chargers"][0][key] for key in ("name", "places", "swap_s")} == {
        "name": "charger 1", "places": 3, "swap_s": 90,
    }  # fmt: skip
    assert "proved" in judged(page)
    fleet.get_by_label("Given", exact=True).select_option("watts")
    fleet.get_by_label("Take-off and landing (Wh)").fill("1.5")
    expect(fleet).to_contain_text("is missing; give it, or a preset")
    fleet.get_by_label("Given", exact=True).select_option("dji-mavic-3e")
    fleet.get_by_label("Reserve (%)").fill("20")
    kept = document(page)["fleet"]
    assert kept["battery"] == {"preset": "dji-mavic-3e", "takeoff_wh": 1.5, "reserve_percent": 20}
    assert "endurance_s" not in kept
    assert "proved" in judged(page)
    fleet.get_by_label("Given", exact=True).select_option("")
    assert "battery" not in document(page)["fleet"]
    charger.get_by_label("Delete charger 1").click()
    assert document(page)["chargers"] == []
    assert "proved" in judged(page)


@pytest.mark.slow  # fills a long form
def test_kinds_and_single_robots_have_batteries_of_their_own(new_page: Any, page_server: Any) -> None:
    page = open_page(new_page, page_server)
    new_mission(page)
    draw_polygon(page, "Area", *SQUARE)
    tool(page, "Charger", "Point")
    click_map(page, (150, 450))
    fleet = page.locator("#fleet-form")
    fleet.get_by_label("Vehicle", exact=True).select_option("")
    fleet.get_by_label("Robots", exact=True).select_option("kinds")
    scout, heavy = (fleet.locator(".card").nth(k) for k in (0, 1))
    scout.get_by_text("Battery", exact=True).click()
    scout.get_by_label("Endurance (s)").fill("600")
    expect(scout.get_by_label("Reserve (s)")).to_have_attribute("placeholder", "as the fleet")
    scout.get_by_label("Recharging (s)").fill("900")
    scout.get_by_label("Given", exact=True).select_option("deltaquad-pro-v2")
    scout.get_by_label("Reserve (%)").fill("20")  # it stays unfolded, and nobody else's is
    expect(heavy.get_by_label("Given", exact=True)).to_be_hidden()
    heavy.get_by_text("Battery", exact=True).click()
    heavy.get_by_label("Given", exact=True).select_option("watts")
    heavy.get_by_label("Capacity (Wh)").fill("77")
    heavy.get_by_label("Moving (W)").fill("0")
    heavy.get_by_label("Charging (W)").fill("70")
    expect(heavy).to_contain_text("0 is not allowed; it must be greater than 0")
    heavy.get_by_text("Battery", exact=True).click()
    moving = heavy.get_by_label("Moving (W)")
    expect(moving).to_be_hidden()
    page.locator("#verdict").get_by_role("button", name="Kind 2, battery, moving: 0 is not").click()
    expect(moving).to_be_focused()
    moving.fill("103")
    kinds = [
        {"name": "kind-1", "cost": 1, "battery": {"preset": "deltaquad-pro-v2", "reserve_percent": 20}},
        {"name": "kind-2", "cost": 2, "battery": {"capacity_wh": 77, "moving_w": 103, "charging_w": 70}},
    ]
    assert document(page)["fleet"]["kinds"] == kinds
    assert "proved" in judged(page)
    fleet.get_by_label("Robots", exact=True).select_option("list")
    first = fleet.locator(".card").first
    first.get_by_text("Battery", exact=True).click()
    first.get_by_label("Endurance (s)").fill("600")
    first.get_by_label("Recharging (s)").fill("900")
    assert document(page)["fleet"]["robots"][0] == {"name": "robot-1", "endurance_s": 600, "recharge_s": 900}
    first.get_by_label("Given", exact=True).select_option("dji-mavic-3e")
    expect(first).to_contain_text("that each departure from a charger costs")
    assert document(page)["fleet"]["robots"][0] == {"name": "robot-1", "battery": {"preset": "dji-mavic-3e"}}


def test_a_vehicle_says_what_it_does_where_nothing_is_given(page: Any) -> None:
    new_mission(page)
    draw_polygon(page, "Area", *SQUARE)
    fleet = page.locator("#fleet-form")
    fleet.get_by_label("Vehicle", exact=True).select_option("px4")
    assert {key: document(page)["fleet"].get(key) for key in ("vehicle", "speed_m_s")} == {
        "vehicle": "px4",
        "speed_m_s": None,
    }
    # MPC_XY_CRUISE and MPC_ACC_HOR
    expect(fleet.get_by_label("Speed (m/s)")).to_have_attribute("placeholder", "5, as px4")
    fleet.get_by_text("Motion and wind").click()
    acceleration = fleet.get_by_label("Acceleration (m/s²)")
    expect(acceleration).to_have_attribute("placeholder", "3, as px4")
    acceleration.fill("1.5")
    assert document(page)["fleet"]["acceleration_m_s2"] == 1.5
    fleet.get_by_label("Corners cut by (m)").fill("1000")
    told = judged(page)
    assert "Fleet, corners cut by: 1000 is not allowed" in told
    fleet.get_by_label("Corners cut by (m)").fill("")
    fleet.get_by_label("Vehicle", exact=True).select_option("")
    kept = document(page)["fleet"]
    assert kept["speed_m_s"] == 8
    assert "vehicle" not in kept
    fleet.get_by_label("Vehicle", exact=True).select_option("arducopter")
    page.locator("#tab-plan").click()
    page.get_by_role("combobox", name="Planner", exact=True).select_option("swarm")
    kept = document(page)["fleet"]
    assert kept["speed_m_s"] == 10  # WPNAV_SPEED
    assert "vehicle" not in kept
    assert "acceleration_m_s2" not in kept


def test_faults_are_told_at_the_field_on_the_shape_and_in_the_list(new_page: Any, page_server: Any) -> None:
    page = open_page(new_page, page_server)
    new_mission(page)
    draw_polygon(page, "Area", *SQUARE)
    draw_two(page, "Zone", "Circle", (200, 200), (240, 200))
    page.locator("#fleet-form").get_by_label("Speed (m/s)").fill("-1")
    speed = page.locator("#fleet-form").get_by_label("Speed (m/s)")
    expect(speed).to_have_attribute("aria-invalid", "true")
    told = judged(page)
    assert "Fleet, speed: " in told
    page.locator("#tab-plan").click()
    page.locator("#tab-edit").click()
    page.locator("#verdict").get_by_role("button", name="Fleet, speed").click()
    expect(speed).to_be_focused()
    speed.fill("5")
    expect(speed).to_have_attribute("aria-invalid", "false")
    # a ring that crosses itself is marked on the map
    page.locator(".card[data-kind=area]").get_by_role("button", name="Area", exact=True).click()
    page.locator("summary", has_text="Coordinates").last.click()
    first = page.get_by_label("Corner 1, x (m, east)")
    first.fill("1000")
    expect(page.locator(".shape-area.shape-fault")).to_have_count(1)
    page.keyboard.press("Control+z")
    expect(page.locator(".shape-area.shape-fault")).to_have_count(0)
    assert "proved" in judged(page)


def test_a_mission_in_metres_goes_on_the_globe_and_back(page: Any) -> None:
    new_mission(page)
    draw_polygon(page, "Area", *SQUARE)
    before = document(page)["area"]
    page.get_by_text("Coordinates, hidden ground").click()
    coordinates = page.get_by_label("Coordinates", exact=True)
    coordinates.select_option("wgs84")
    expect(page.locator("#mission-form")).to_contain_text("Where on the globe")
    page.get_by_label("Origin: latitude").fill("54.36")
    page.get_by_label("Origin: longitude").fill("13.08")
    coordinates.select_option("wgs84")
    kept = document(page)
    assert kept["coordinates"] == "wgs84"
    assert kept["area"][0] == pytest.approx([13.08, 54.36], abs=0.01)
    assert "proved" in judged(page)
    coordinates.select_option("metres")
    # the origin is the area's middle now: shapes are where they were, counted from there
    after = document(page)["area"]
    for corner, was in zip(after, before, strict=True):
        assert corner[0] - after[0][0] == pytest.approx(was[0] - before[0][0], abs=0.02)
        assert corner[1] - after[0][1] == pytest.approx(was[1] - before[0][1], abs=0.02)


@pytest.mark.slow  # opens file after file
def test_examples_and_files_are_read(new_page: Any, page_server: Any, tmp_path: Path) -> None:
    page = open_page(new_page, page_server)
    open_example(page, "harbour")
    assert "At least 4 robots, proved" in judged(page)
    expect(page.locator(".card[data-kind=zone]")).to_have_count(3)
    # a map comes as two files; its shapes are shown, not edited
    page.get_by_role("button", name="Missions…").click()
    files = ["building.yaml", "building_map.yaml", "building_map.png"]
    page.locator("#mission-files").set_input_files([EXAMPLES / name for name in files])
    expect(page.locator("#mission-name")).to_have_text("building")
    expect(page.locator(".shape-area.shape-resolved")).to_have_count(1)
    expect(page.locator(".card[data-kind=area]")).to_contain_text("building_map.yaml")
    assert "proved" in judged(page)
    # a file that fits becomes shapes of the mission
    page.get_by_role("button", name="Missions…").click()
    page.locator("#mission-files").set_input_files([EXAMPLES / "parcel.yaml", EXAMPLES / "parcel.geojson"])
    expect(page.locator("#mission-name")).to_have_text("parcel")
    assert len(document(page)["obstacles"]) == 1
    page.get_by_role("button", name="Missions…").click()
    with page.expect_download(timeout=COMPILING_MS) as told:
        page.get_by_role("button", name="Save this mission as a file").click()
    taken = tmp_path / told.value.suggested_filename
    told.value.save_as(taken)
    mission, whole = read_mission(taken).mission, read_mission(EXAMPLES / "parcel.yaml").mission
    assert mission.name == "parcel"
    assert mission.area.symmetric_difference(whole.area).area < 0.01
    deletes = page.get_by_role("button", name="Delete building")  # another test may have opened one as well
    deletes.first.wait_for()
    buildings = deletes.count()
    deletes.first.click()
    page.get_by_role("button", name="Delete", exact=True).last.click()
    expect(deletes).to_have_count(buildings - 1)
    page.locator("#missions .grow", has_text="harbour").first.click()
    expect(page.locator("#mission-name")).to_have_text("harbour")
    saved(page)
    assert mission_id(page)
