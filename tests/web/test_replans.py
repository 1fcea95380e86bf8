"""Replanning over HTTP and on the page: a robot is lost at the moment shown, and a plan for those that remain plays."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import expect
from starlette.testclient import TestClient
from tests.replanning.relays import relay
from tests.replanning.rings import ring_plan
from tests.web.conftest import open_page
from tests.web.drawing import COMPILING_MS
from tests.web.serving import job_when, serving

from rota import check_plan
from rota.files.plan_file import plan_from_text, plan_text

PAIR = plan_text(ring_plan(45, {"a": 0.0, "b": 20.0})).encode()


def given_plan(client: Any, plan: bytes = PAIR) -> str:
    """The id of a plan: of two robots on a ring, of whom one is enough, unless another is given."""
    return str(client.post("/api/plans", files={"plan": ("given.rota.json", plan)}).raise_for_status().json()["id"])


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with serving(tmp_path_factory.mktemp("replans")) as made:
        yield made


def test_a_replan_is_a_job_whose_plan_takes_over_and_can_be_run_again(client: TestClient) -> None:
    plan = given_plan(client)
    job = client.post(f"/api/plans/{plan}/replan", json={"at_s": 100, "lost": ["b"]}).json()
    assert job["change"] == {"plan": plan, "at_s": 100.0, "lost": ["b"]}
    ended = job_when(client, job["id"], "done")
    shown = client.get(f"/api/plans/{ended['plan']}").json()
    assert (shown["robots"], shown["verdict"], shown["change"]) == (1, "met", job["change"])
    assert shown["report"]["lateness"]["holds_again_s"] == 0
    made = plan_from_text(client.get(f"/api/plans/{ended['plan']}/plan.rota.json").content, "it")
    assert made.seam is not None
    assert (made.seam.at_s, made.seam.lost, check_plan(made).verdict) == (100, ("b",), "met")
    again = client.post(f"/api/jobs/{job['id']}/again").json()
    assert again["change"] == job["change"]
    assert job_when(client, again["id"], "done")["plan"] is not None


def test_a_robot_that_charges_is_replaced_by_one_to_spare(client: TestClient) -> None:
    plan = given_plan(client, plan_text(relay(spare=True)).encode())
    job = client.post(f"/api/plans/{plan}/replan", json={"at_s": 130, "lost": ["b"]}).json()
    ended = job_when(client, job["id"], "done")
    made = plan_from_text(client.get(f"/api/plans/{ended['plan']}/plan.rota.json").content, "it")
    assert (len(made), check_plan(made).verdict) == (3, "met")
    assert 0 < made["a"].battery < 1


@pytest.mark.parametrize(
    ("asked", "status", "word"),
    [
        ({"at_s": -1, "lost": ["b"]}, 400, "at_s"),
        ({"at_s": True, "lost": ["b"]}, 400, "at_s"),
        ({"at_s": 1, "lost": []}, 400, "lost"),
        ({"at_s": 1, "lost": "b"}, 400, "lost"),
        ({"at_s": 1, "lost": ["c"]}, 422, "robot 'c' is not in the plan; the plan has a, b"),
        ({"at_s": 1, "lost": ["a", "b"]}, 422, "no robot remains"),
        ({"at_s": 1, "lost": ["b"], "colour": 1}, 400, "colour"),
    ],
)
def test_a_change_that_cannot_be_is_refused(client: TestClient, asked: Any, status: int, word: str) -> None:
    answer = client.post(f"/api/plans/{given_plan(client)}/replan", json=asked)
    assert answer.status_code == status
    assert word in answer.json()["error"]["message"]


def test_there_is_no_replan_of_a_plan_that_is_not_there(client: TestClient) -> None:
    assert client.post(f"/api/plans/{'0' * 16}/replan", json={"at_s": 1, "lost": ["b"]}).status_code == 404


@pytest.mark.slow  # a search and a replan in a browser
@pytest.mark.browser
def test_the_page_replans_from_the_moment_at_which_a_robot_is_lost(new_page: Any, page_server: Any) -> None:
    with page_server.client() as client:
        plan = given_plan(client)
    page = open_page(new_page, page_server, f"#plan={plan}&tab=watch")
    controls = page.locator("#player-controls")
    page.get_by_label("Time", exact=True).fill("60")
    controls.get_by_role("button", name="Lost: b").click()
    controls.get_by_role("button", name="Replan for those that remain").click()
    change = controls.locator("details", has_text="The change")
    expect(change).to_contain_text("0:00.0 is 1:00.0 of the plan before; lost: b.", timeout=COMPILING_MS)
    expect(change).to_contain_text("Every period holds throughout.")
    expect(controls).to_contain_text("1 robot")
    page.locator("#tab-plan").click()
    page.get_by_label("also those of other missions").check()
    row = page.locator("#plans tbody tr", has_text="from 60 s on without b")
    expect(row).to_have_attribute("data-chosen", "true", timeout=COMPILING_MS)
