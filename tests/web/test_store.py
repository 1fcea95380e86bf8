"""The database: revisions of missions, plans that know what they were made of, older tables, a disk without room."""

from __future__ import annotations

import json
import sqlite3
from pathlib import Path
from typing import Any

import pytest
from tests.files.two_robots import two_robots
from tests.web.serving import SQUARE, Json, job_when, kept, serving, started

from rota.check import check_plan
from rota.files.mission_changes import changes
from rota.files.plan_file import plan_from_text, plan_text
from rota.web.limits import Limits
from rota.web.store import database as tables
from rota.web.store.database import Database
from rota.web.store.jobs import interrupt_jobs, queued_jobs
from rota.web.store.plans import forget_lost_steps, keep_plan, list_plans
from rota.web.tasks.planning import new_plan

GATE = {"name": "gate", "period_s": 20, "ring": [[0, 0], [1, 0], [1, 1]]}
YARD: Json = {**SQUARE, "zones": [GATE], "obstacles": [[[2, 2], [3, 2], [3, 3]], [[4, 4], [5, 4], [5, 5]]]}


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"period_s": 20}, ["area period 60 → 20 s"]),
        ({"period_s": None}, ["area period 60 s → none"]),
        (
            {"fleet": {**SQUARE["fleet"], "speed_m_s": 0.5, "robots": 3}},
            ["fleet robots fewest → 3", "fleet speed 2 → 0.5 m/s"],
        ),
        ({"fleet": {**SQUARE["fleet"], "sensor": {"shape": "disc", "radius_m": 4}}}, ["fleet sensor radius 5 → 4 m"]),
        ({"fleet": {**SQUARE["fleet"], "start": {"points": [[1, 1]]}}}, ["fleet start points changed"]),
        ({"area": [[0, 0], [6, 0], [6, 5], [0, 5]]}, ["area shape"]),
        ({"zones": [{**GATE, "period_s": 10}]}, ["zone gate period 20 → 10 s"]),
        ({"zones": [{**GATE, "ring": [[0, 0], [2, 0], [1, 1]]}]}, ["zone gate shape"]),
        ({"zones": []}, ["zone gate taken away"]),
        ({"zones": [GATE, {"name": "quay", "ring": GATE["ring"]}]}, ["zone quay added"]),
        ({"obstacles": YARD["obstacles"][:1]}, ["1 obstacle taken away"]),
        ({"obstacles": [YARD["obstacles"][1], [[2, 2], [3, 2], [3, 4]]]}, ["1 obstacle changed"]),
        (
            {"obstacles": [*YARD["obstacles"], [[2, 4], [2, 5], [3, 5]], [[2, 4], [2, 5], [3, 6]]]},
            ["2 obstacles added"],
        ),
        # a plan holds as before
        ({"name": "other", "planner": "swarm", "swarm": {"controller": "settle"}, "patrol": {"effort": "high"}}, []),
        ({"zones": [{**GATE, "name": "door"}], "obstacles": YARD["obstacles"][::-1]}, []),
        ({"moving_obstacles": [], "origin": None, "period_s": 60.0}, []),
    ],
)
def test_what_has_changed_is_told_in_words(change: Json, told: list[str]) -> None:
    assert changes(YARD, {**YARD, **change}) == told


def test_a_planners_own_rules_and_the_content_of_files_are_changes_too() -> None:
    before = {"planner": "swarm", "swarm": {"effort": "quick", "spacing_m": 3}}
    after = {"planner": "swarm", "swarm": {"effort": "high", "spacing_m": 4}}
    assert changes(before, after, {"a.png": "1", "b.png": "1"}, {"a.png": "2"}) == [
        "swarm spacing 3 → 4 m",
        "file a.png has other content",
    ]


def test_a_plan_is_stale_while_its_mission_asks_for_something_else(tmp_path: Path) -> None:
    with serving(tmp_path) as client:
        plan = job_when(client, started(client, SQUARE), "done")["plan"]
        shown = client.get(f"/api/plans/{plan}").json()
        assert (shown["revision"], shown["stale"]) == (1, [])
        address = f"/api/missions/{shown['mission']}"
        changed = client.put(address, json={"document": {**SQUARE, "period_s": 20}, "revision": 1}).json()
        assert changed["revision"] == 2
        assert client.get("/api/plans").json()[0]["stale"] == ["area period 60 → 20 s"]
        for path, name in (("export/csv", "square-stale.csv"), ("plan.rota.json", "square-stale.rota.json"),
                           ("picture.png", "square-stale.png"), ("page.html", "square-stale.html")):  # fmt: skip
            assert f'filename="{name}"' in client.get(f"/api/plans/{plan}/{path}").headers["content-disposition"]
        taken = client.get(f"/api/plans/{plan}/plan.rota.json").content
        assert json.loads(taken)["mission_changes"] == ["area period 60 → 20 s"]
        client.put(address, json={"document": SQUARE})  # as it was
        assert client.get(f"/api/plans/{plan}").json()["stale"] == []
        held = client.get(f"/api/plans/{plan}/plan.rota.json").content
        assert "mission_changes" not in json.loads(held)
        assert plan_text(plan_from_text(taken, "taken")) == held.decode()
        assert 'filename="square.csv"' in client.get(f"/api/plans/{plan}/export/csv").headers["content-disposition"]
        client.delete(address)
        assert client.get(f"/api/plans/{plan}").json()["stale"] == []


def test_a_clock_that_is_set_back_turns_no_queue_round(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    years = iter(range(2030, 2000, -1))
    monkeypatch.setattr("rota.web.store.jobs.now", lambda: f"{next(years)}-01-01T00:00:00.000Z")
    with serving(tmp_path, Limits(planning_jobs=0)) as client:
        mission = kept(client, SQUARE)
        asked = [client.post("/api/jobs", json={"mission": mission}).json()["id"] for _ in range(3)]
        assert [job for job, _ in queued_jobs(Database(tmp_path))] == asked
        assert [job["id"] for job in client.get("/api/jobs").json()] == asked[::-1]


def test_what_was_made_from_an_older_revision_is_refused_and_a_save_may_be_sent_again(tmp_path: Path) -> None:
    with serving(tmp_path) as client:
        mission = kept(client, SQUARE)
        address = f"/api/missions/{mission}"
        other, mine = {**SQUARE, "period_s": 50}, {**SQUARE, "period_s": 40}
        assert client.put(address, json={"document": other, "revision": 1}).json()["revision"] == 2
        refused = client.put(address, json={"document": mine, "revision": 1})
        assert (refused.status_code, client.get(address).json()["document"]) == (409, other)
        assert "changed elsewhere" in refused.json()["error"]["message"]
        assert client.put(address, json={"document": other, "revision": 1}).json()["revision"] == 2
        job = client.post("/api/jobs", json={"mission": mission, "revision": 1})
        assert job.status_code == 409
        assert client.put(address, json={"document": mine, "revision": 2}).json()["revision"] == 3
        assert client.put(address, json={"document": mine, "revision": 0}).status_code == 400


def test_an_example_that_is_kept_unchanged_is_not_kept_again(tmp_path: Path) -> None:
    with serving(tmp_path) as client:
        first, again = (client.post("/api/missions", json={"example": "building"}).json() for _ in range(2))
        assert again == first
        client.put(f"/api/missions/{first['id']}", json={"document": {**first["document"], "period_s": 77}})
        assert client.post("/api/missions", json={"example": "building"}).json()["id"] != first["id"]
        assert len(client.get("/api/missions").json()) == 2


def test_tables_of_the_first_version_open_with_all_that_they_hold(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr(tables, "_STEPS", tables._STEPS[:1])
    monkeypatch.setattr(tables, "VERSION", 1)
    old = Database(tmp_path)
    document = json.dumps(SQUARE)
    moment = "2026-01-01T00:00:00.000Z"
    with old.transaction() as cursor:
        cursor.execute(
            "INSERT INTO missions VALUES ('m', 'square', 'patrol', ?, '{}', ?, ?)",
            (json.dumps({**SQUARE, "period_s": 20}), moment, moment),
        )
        cursor.execute(
            "INSERT INTO jobs (id, mission, mission_name, document, files, state, planner, seed, created_at)"
            " VALUES ('j', 'm', 'square', ?, '{}', 'done', 'patrol', 0, ?)",
            (document, moment),
        )
        cursor.execute(
            "INSERT INTO plans VALUES ('p', 'square', 'm', 'j', 'patrol', NULL, ?, 1, 1, '', 'met', 0, 0, 1, 0,"
            " '[]', 0, '', '')",
            (moment,),
        )
    old.close()
    monkeypatch.undo()
    with serving(tmp_path) as client:
        assert client.get("/api/missions/m").json()["revision"] == 1
        assert client.get("/api/jobs/j").json()["revision"] is None
        (plan,) = client.get("/api/plans").json()
        assert (plan["revision"], plan["stale"]) == (None, ["area period 60 → 20 s"])
    with sqlite3.connect(tmp_path / tables.FILE_NAME) as file:
        assert file.execute("PRAGMA user_version").fetchone()[0] == tables.VERSION


def test_a_plan_that_a_crash_left_on_the_way_is_listed_as_cut_short(tmp_path: Path) -> None:
    store, plan = Database(tmp_path), two_robots()
    report = check_plan(plan)
    assert report.verdict == "met"
    key = keep_plan(store, new_plan(plan, report, (), job="j", is_better=True), most=9)
    with store.transaction() as cursor:
        cursor.execute(
            "INSERT INTO jobs (id, mission_name, document, files, state, planner, seed, created_at, best_plan)"
            " VALUES ('j', 'two', '{}', '{}', 'running', 'patrol', 0, '', ?)",
            (key,),
        )
    assert interrupt_jobs(store) == 1
    forget_lost_steps(store)
    assert [(entry["id"], entry["partial"]) for entry in list_plans(store)] == [(key, True)]
    store.close()


def test_a_full_disk_is_called_so(tmp_path: Path, monkeypatch: Any) -> None:
    with serving(tmp_path) as client:
        mission = kept(client, SQUARE)
        connection = Database.connection

        def without_room(self: Database) -> sqlite3.Connection:
            found = connection(self)
            found.execute("PRAGMA max_page_count = 1")  # as many as there are already
            return found

        monkeypatch.setattr(Database, "connection", without_room)
        long = {**SQUARE, "description": "x" * 100_000}
        refused = client.put(f"/api/missions/{mission}", json={"document": long})
        assert refused.status_code == 507
        assert "full" in refused.json()["error"]["message"]
        monkeypatch.undo()
        client.app.state.rota.database.connection()
        assert client.get(f"/api/missions/{mission}").json()["revision"] == 1
