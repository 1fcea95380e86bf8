"""Planning jobs in the database: what was asked, how far it came, and what came of it."""

from __future__ import annotations

import json
import sqlite3
from typing import Any

from rota.model.planner_registry import planner_names
from rota.web.limits import Limits
from rota.web.refusal import Json, Refusal
from rota.web.store.database import Database, contents_of, new_id, now, row_of
from rota.web.store.missions import clean_files, mission_source, name_of, planner_of, text_of
from rota.web.store.plans import plan_source

OPEN = ("queued", "running")  # the states of jobs that are not over


def new_job(database: Database, mission: str, asked: Json, limits: Limits) -> Json:
    """Keep a new job for a mission as it is now, to be run when its turn comes.

    asked: planner, effort, seed, time_limit_s, and the mission's revision that is meant, each as given or None. Refusal
    429 when the queue is full, 409 when the mission has another revision.
    """
    document, files, revision = mission_source(database, mission, asked.get("revision"))
    document = document_for_planner(document, asked.get("planner"))
    planner = planner_of(document)
    asked = {**asked, "planner": planner, "revision": revision}
    return _insert(database, mission, document, json.dumps(files), asked, limits)


def new_replan(database: Database, change: Json, asked: Json, limits: Limits) -> Json:
    """Keep a new job that replans: change has the plan, the moment at_s of its clock and the robots that are lost.

    asked: seed, time_limit_s, each as given or None. Refusal 404 for a plan that there is not, 429 for a full queue.
    """
    row = plan_source(database, change["plan"])
    document = json.loads(row["document"] or json.dumps({"name": row["name"]}))
    same = {key: row[key] for key in ("planner", "effort", "revision")}
    asked = {**asked, **same, "change": json.dumps(change)}
    return _insert(database, row["mission"], document, row["files"] or "{}", asked, limits)


def document_for_planner(document: Json, planner: str | None) -> Json:
    """The document for the planner that is asked for, without the settings of others; None: the mission's own."""
    if planner is None or planner == planner_of(document):
        return document
    return {**{key: value for key, value in document.items() if key not in planner_names()}, "planner": planner}


def job_again(database: Database, job: str, limits: Limits) -> Json:
    """A new job that asks what another one asked, of the mission as it was then."""
    row = row_of(database.connection(), "job", job)
    asked = {key: row[key] for key in ("planner", "effort", "seed", "time_limit_s", "revision", "change")}
    return _insert(database, row["mission"], json.loads(row["document"]), row["files"], asked, limits)


def _insert(database: Database, mission: str | None, document: Json, files: str, asked: Json, limits: Limits) -> Json:
    """Add a job to the queue; Refusal when too many wait or are kept."""
    job = new_id()
    with database.transaction() as cursor:
        count = cursor.execute("SELECT count(*) FROM jobs WHERE state = 'queued'").fetchone()[0]
        if count >= limits.queued_jobs:
            raise Refusal(429, f"{count} jobs wait already; try again when some are done, or stop some")
        if cursor.execute("SELECT count(*) FROM jobs").fetchone()[0] >= limits.jobs:
            raise Refusal(409, f"{limits.jobs:,} jobs are kept at most; delete some first")
        cursor.execute(
            "INSERT INTO jobs (id, mission, mission_name, document, files, state, planner, effort, seed, time_limit_s,"
            " revision, change, created_at) VALUES (?, ?, ?, ?, ?, 'queued', ?, ?, ?, ?, ?, ?, ?)",
            (
                job, mission, name_of(document), text_of(document), files, asked["planner"],
                asked.get("effort") or _effort_of(document), asked.get("seed") or 0, asked.get("time_limit_s"),
                asked["revision"], asked.get("change"), now(),
            ),
        )  # fmt: skip
    return job_json(database, job)


def _effort_of(document: Json) -> str | None:
    """The effort that a mission asks for itself, if its planner has such a setting."""
    settings = document.get(planner_of(document))
    effort = settings.get("effort") if isinstance(settings, dict) else None
    return effort if isinstance(effort, str) else None


def job_source(database: Database, job: str) -> tuple[Json, dict[str, bytes], Json]:
    """What a worker plans: the document, the files that it names, and the job."""
    connection = database.connection()
    row = row_of(connection, "job", job)
    return json.loads(row["document"]), contents_of(connection, json.loads(row["files"])), _show(row)


def job_json(database: Database, job: str) -> Json:
    """A job as the interface shows it, without what is known of it only while it runs."""
    return _show(row_of(database.connection(), "job", job))


def list_jobs(database: Database) -> list[Json]:
    """All jobs, the newest first."""
    rows = database.connection().execute("SELECT * FROM jobs ORDER BY rowid DESC")
    return [_show(row) for row in rows]


def queued_jobs(database: Database) -> list[tuple[str, float | None]]:
    """The jobs that wait, in their turn, each with its time limit in seconds."""
    sql = "SELECT id, time_limit_s FROM jobs WHERE state = 'queued' ORDER BY rowid"
    return [(row[0], row[1]) for row in database.connection().execute(sql)]


def set_job(database: Database, job: str, **values: Any) -> None:
    """Change columns of a job; one that was deleted meanwhile stays away."""
    columns = ", ".join(f"{name} = ?" for name in values)
    with database.transaction() as cursor:
        cursor.execute(f"UPDATE jobs SET {columns} WHERE id = ?", (*values.values(), job))


def interrupt_jobs(database: Database) -> int:
    """Mark the jobs that ran when the last server ended, however it did; returns how many. The queue stays."""
    message = "the server ended while this job ran; it can be run again"
    with database.transaction() as cursor:
        sql = (
            "UPDATE jobs SET state = 'interrupted', message = ?, ended_at = ?, plan = best_plan WHERE state = 'running'"
        )
        return cursor.execute(sql, (message, now())).rowcount


def delete_job(database: Database, job: str) -> None:
    """Delete a job that is over; its plan stays, the lesser ones on the way go."""
    with database.transaction() as cursor:
        row = row_of(cursor, "job", job)
        if row["state"] in OPEN:
            raise Refusal(409, "the job is not over; stop it first")
        cursor.execute("DELETE FROM plans WHERE job = ? AND id IS NOT ?", (job, row["plan"]))
        cursor.execute("DELETE FROM jobs WHERE id = ?", (job,))
        clean_files(cursor)


def _show(row: sqlite3.Row) -> Json:
    """A row of the table of jobs as the page is told of it."""
    best = None
    if row["best_robots"] is not None:
        best = {"robots": row["best_robots"], "met": bool(row["best_met"]), "plan": row["best_plan"]}
    same = ("id", "mission", "mission_name", "state", "planner", "effort", "seed", "time_limit_s", "revision",
            "created_at")  # fmt: skip
    over = row["state"] not in OPEN
    return {
        **{key: row[key] for key in same},
        "change": None if row["change"] is None else json.loads(row["change"]),
        "started_at": row["started_at"],
        "ended_at": row["ended_at"],
        "progress": {"fraction": 1.0 if over else 0.0, "doing": "", "elapsed_s": row["elapsed_s"], "left_s": None},
        "best": best,
        "message": row["message"],
        "plan": row["plan"],
        "place_in_queue": None,
    }
