"""Planning jobs over HTTP: their course, their queue, their end, and what is left when something breaks."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient
from tests.files.two_robots import two_robots
from tests.web.serving import SQUARE, YARD, Json, Server, job_when, job_with_plan, kept, serving, started

from rota.check import check_plan
from rota.files.plan_file import plan_from_text, plan_text
from rota.web.limits import Limits


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with serving(tmp_path_factory.mktemp("jobs"), Limits(planning_jobs=1, queued_jobs=2, stop_grace_s=60)) as made:
        yield made


def events_of(text: str) -> list[tuple[str, Any]]:
    """The events of a stream that has ended."""
    events = []
    for block in text.split("\n\n"):
        fields = dict(line.split(": ", 1) for line in block.splitlines() if not line.startswith(":"))
        if fields:
            events.append((fields["event"], json.loads(fields["data"])))
    return events


def test_a_job_plans_tells_its_progress_and_leaves_a_plan_that_the_check_passes(client: TestClient) -> None:
    job = started(client, SQUARE, seed=3)
    told = events_of(client.get(f"/api/jobs/{job}/events").text)
    states = [data["state"] for name, data in told if name == "job"]
    assert states[-1] == "done"
    assert sorted(states, key=["queued", "running", "done"].index) == states
    better = [data for name, data in told if name == "better"]
    assert better[-1]["met"] is True
    ended = client.get(f"/api/jobs/{job}").json()
    assert (ended["best"]["robots"], ended["best"]["met"], ended["seed"]) == (1, True, 3)
    assert ended["best"]["plan"] == ended["plan"]
    plan = plan_from_text(client.get(f"/api/plans/{ended['plan']}/plan.rota.json").content, "it")
    assert check_plan(plan).verdict == "met"
    assert (plan.seed, len(plan.trajectories)) == (3, 1)
    assert [entry["id"] for entry in client.get("/api/plans").json()] == [ended["plan"]]  # none of those on the way
    step = better[-1]["plan"]
    assert client.get(f"/api/plans/{step}/playback").status_code == 200  # a page may still be loading it
    job_when(client, started(client, SQUARE, seed=4), "done")
    assert client.get(f"/api/plans/{step}").status_code == 404


@pytest.mark.slow  # searches until a plan is there to stop at
def test_stop_keeps_the_best_plan_so_far_and_the_queue_moves_up(client: TestClient) -> None:
    first = started(client, YARD)
    job_with_plan(client, first)
    second, third = started(client, SQUARE), started(client, SQUARE)
    assert [client.get(f"/api/jobs/{job}").json()["place_in_queue"] for job in (first, second, third)] == [None, 1, 2]
    refused = client.post("/api/jobs", json={"mission": kept(client, SQUARE)})
    assert refused.status_code == 429
    assert client.delete(f"/api/jobs/{first}").status_code == 409
    assert client.post(f"/api/jobs/{third}/stop").json()["state"] == "stopped"
    client.post(f"/api/jobs/{first}/stop")
    stopped = job_when(client, first, "stopped")
    shown = client.get(f"/api/plans/{stopped['plan']}").json()
    assert shown["robots"] == stopped["best"]["robots"] == shown["report"]["robots"]
    assert job_when(client, second, "done")["plan"] is not None
    assert client.post(f"/api/jobs/{first}/stop").status_code == 409
    again = client.post(f"/api/jobs/{third}/again").json()
    assert (again["mission"], again["seed"]) == (client.get(f"/api/jobs/{third}").json()["mission"], 0)
    client.post(f"/api/jobs/{again['id']}/stop")
    job_when(client, again["id"], "stopped", "done")
    assert client.delete(f"/api/jobs/{first}").status_code == 204
    assert client.get(f"/api/plans/{stopped['plan']}").status_code == 200


@pytest.mark.slow  # starts processes anew
def test_a_worker_that_dies_fails_its_job_and_no_other(tmp_path: Path) -> None:
    with serving(tmp_path, usual=True) as client:
        job = started(client, YARD)
        best = job_with_plan(client, job)["best"]
        (child,) = planning_processes()
        os.kill(child, signal.SIGKILL)
        failed = job_when(client, job, "failed")
        assert "ended" in failed["message"]
        assert failed["plan"] is not None
        assert failed["best"]["robots"] <= best["robots"]
        assert client.get("/api/missions").status_code == 200


def planning_processes() -> list[int]:
    """Our children that plan."""
    found = []
    for status in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = status.read_bytes().decode().split("\0")
            parent = int((status.parent / "stat").read_text().rsplit(")", 1)[1].split()[1])
        except OSError:
            continue
        if parent == os.getpid() and '"role": "planning"' in "".join(words):
            found.append(int(status.parent.name))
    return found


@pytest.mark.parametrize(
    ("asked", "status", "word"),
    [
        ({"mission": "0" * 16}, 404, "no mission"),
        ({"mission": None}, 400, "mission"),
        ({"planner": "walk"}, 400, "planner"),
        ({"effort": "huge"}, 400, "effort"),
        ({"seed": -1}, 400, "seed"),
        ({"seed": True}, 400, "seed"),
        ({"time_limit_s": 0}, 400, "time_limit_s"),
        ({"colour": "red"}, 400, "colour"),
        ({"planner": "swarm"}, 422, "faults"),
    ],
)
def test_a_job_that_makes_no_sense_is_refused(client: TestClient, asked: Json, status: int, word: str) -> None:
    answer = client.post("/api/jobs", json={"mission": kept(client, SQUARE), **asked})
    assert answer.status_code == status
    assert word in answer.json()["error"]["message"]


def test_a_mission_with_faults_is_not_planned_and_all_of_them_are_told(client: TestClient) -> None:
    answer = client.post("/api/jobs", json={"mission": kept(client, {**SQUARE, "period_s": -1, "name": ""})})
    assert answer.status_code == 422
    assert [fault["path"] for fault in answer.json()["error"]["faults"]] == [["name"], ["period_s"]]


def test_a_job_with_fewer_starts_than_robots_are_surely_needed_is_refused_as_in_the_form(client: TestClient) -> None:
    job_when(client, started(client, SQUARE), "done")  # before loops are compiled, nothing is proved
    yard = {**YARD, "fleet": {**YARD["fleet"], "start": {"points": [[1, 1]]}}}
    answer = client.post("/api/jobs", json={"mission": kept(client, yard)})
    assert answer.status_code == 422
    (fault,) = answer.json()["error"]["faults"]
    assert fault["path"] == ["fleet", "start"]
    assert fault["message"].startswith("1 start is given, and at least ")


@pytest.mark.slow  # fills memory
def test_a_job_that_takes_too_much_memory_is_ended(tmp_path: Path) -> None:
    with serving(tmp_path, Limits(job_memory_bytes=100 * 2**20), usual=True) as client:
        failed = job_when(client, started(client, YARD), "failed")
        assert "memory" in failed["message"]


@pytest.mark.slow  # waits out the grace
def test_a_job_that_heeds_no_stop_is_killed_with_its_best_plan(tmp_path: Path) -> None:
    with serving(tmp_path, Limits(stop_grace_s=0.0)) as client:
        job = started(client, YARD)
        job_with_plan(client, job)
        client.post(f"/api/jobs/{job}/stop")
        stopped = job_when(client, job, "stopped")
        assert client.get(f"/api/plans/{stopped['plan']}").json()["robots"] == stopped["best"]["robots"]


@pytest.mark.slow  # starts two servers
def test_everything_saved_is_back_after_kill_9_and_interrupted_jobs_can_be_run_again(tmp_path: Path) -> None:
    server = Server(tmp_path / "data", "--processes", "1")
    with server.client() as client:
        file = ("two.rota.json", plan_text(two_robots()).encode())
        uploaded = client.post("/api/plans", files={"plan": file}).json()["id"]
        running, waiting = started(client, YARD), started(client, SQUARE)
        best = job_with_plan(client, running)["best"]
        missions, plans = client.get("/api/missions").json(), client.get("/api/plans").json()
    server.end(signal.SIGKILL)
    server = Server(tmp_path / "data", "--processes", "1")
    try:
        with server.client() as client:
            assert client.get("/api/missions").json() == missions
            interrupted = client.get(f"/api/jobs/{running}").json()
            assert interrupted["state"] == "interrupted"
            assert interrupted["best"]["robots"] <= best["robots"]
            kept_plans = {entry["id"] for entry in client.get("/api/plans").json()}
            assert [entry["id"] for entry in plans] == [uploaded]
            assert kept_plans == {uploaded, interrupted["plan"]}
            assert client.get(f"/api/plans/{interrupted['plan']}/plan.rota.json").status_code == 200
            job_when(client, waiting, "running", "done")  # the queue goes on by itself
            assert client.post(f"/api/jobs/{running}/again").json()["mission_name"] == "yard"
    finally:
        assert server.end() == 0


def test_a_second_server_on_the_same_folder_is_refused(tmp_path: Path) -> None:
    server = Server(tmp_path / "data")
    try:
        with pytest.raises(AssertionError, match="another rota serve uses this folder"):
            Server(tmp_path / "data")
        with server.client() as client:
            assert client.get("/api/missions").status_code == 200
    finally:
        assert server.end() == 0
