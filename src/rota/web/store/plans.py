"""Plans in the database: packed plan files with what lists show of them, and what was made of them for the page."""

from __future__ import annotations

import gzip
import json
import sqlite3
from dataclasses import dataclass
from typing import Any

from rota.files.mission_changes import changes
from rota.web.refusal import Json, Refusal, no_such
from rota.web.store.database import Database, new_id, now, row_of

MOST_MADE = 6  # playbacks and pictures kept of a plan
# a list of plans is read often: it leaves out the report and the plan itself
_SHOWN = (
    "id", "name", "mission", "job", "planner", "effort", "created_at", "robots", "bound", "bound_reason", "verdict",
    "worst_ratio", "length_m", "plan_s", "partial", "facts", "revision", "change",
)  # fmt: skip
# with what tells whether its mission has changed since; the documents where they differ only, for they may be long
_LISTED = (
    f"SELECT {', '.join(f'plans.{name}' for name in _SHOWN)}, plans.files AS made_files, missions.files AS now_files,"
    " CASE WHEN plans.document IS NOT missions.document THEN plans.document END AS made_document,"
    " CASE WHEN plans.document IS NOT missions.document THEN missions.document END AS now_document"
    " FROM plans LEFT JOIN missions ON missions.id = plans.mission"
)
_COLUMNS = (*_SHOWN[:-2], "is_better", "report", "content")


@dataclass(frozen=True, kw_only=True)
class NewPlan:
    """A plan to be kept: what lists show, the report as JSON, and the text of the plan file.

    partial: it does not meet its demand, or the search for it was cut short. is_better: it is a step of a job that goes
    on; lists leave it out, and the job's last plan takes its place.
    """

    name: str
    planner: str
    effort: str | None
    robots: int
    bound: int | None
    bound_reason: str | None
    verdict: str
    worst_ratio: float | None
    length_m: float
    partial: bool
    facts: tuple[str, ...]
    report: Json
    text: str
    mission: str | None = None
    job: str | None = None
    plan_s: float | None = None
    is_better: bool = False


def keep_plan(database: Database, plan: NewPlan, *, most: int) -> str:
    """Keep a plan; returns its id. Refusal when there are too many."""
    key = new_id()
    report = gzip.compress(json.dumps(plan.report, allow_nan=False).encode(), 6)
    content = gzip.compress(plan.text.encode(), 6)
    with database.transaction() as cursor:
        if cursor.execute("SELECT count(*) FROM plans WHERE NOT is_better").fetchone()[0] >= most:
            raise Refusal(409, f"{most:,} plans are kept at most; delete some first")
        row = (
            key, plan.name[:200], plan.mission, plan.job, plan.planner, plan.effort, now(), plan.robots, plan.bound,
            plan.bound_reason, plan.verdict, plan.worst_ratio, plan.length_m, plan.plan_s, plan.partial,
            json.dumps(plan.facts), plan.is_better, report, content,
        )  # fmt: skip
        cursor.execute(f"INSERT INTO plans ({', '.join(_COLUMNS)}) VALUES ({', '.join('?' * len(row))})", row)
        cursor.execute(
            "UPDATE plans SET (revision, document, files, change)"
            " = (SELECT revision, document, files, change FROM jobs WHERE id = job) WHERE id = ?",
            (key,),
        )
    return key


def finish_plan(database: Database, plan: str) -> None:
    """Make a plan on the way the plan that lists show, since its job was cut short with it."""
    with database.transaction() as cursor:
        cursor.execute("UPDATE plans SET is_better = 0, partial = 1 WHERE id = ?", (plan,))


def forget_steps(database: Database, job: str, *, but: int) -> None:
    """Delete the plans that a job found on its way, except the last ``but`` of them."""
    with database.transaction() as cursor:
        cursor.execute(
            "DELETE FROM plans WHERE job = ? AND is_better AND id NOT IN"
            " (SELECT id FROM plans WHERE job = ? AND is_better ORDER BY created_at DESC, rowid DESC LIMIT ?)",
            (job, job, but),
        )


def forget_old_steps(database: Database) -> None:
    """Delete the plans that jobs which have ended found on their way: until now a page may have been loading one."""
    with database.transaction() as cursor:
        cursor.execute("DELETE FROM plans WHERE is_better AND job NOT IN (SELECT id FROM jobs WHERE ended_at IS NULL)")


def forget_lost_steps(database: Database) -> None:
    """Delete plans found on the way that no job names any more, and list those that an interrupted job ended with."""
    with database.transaction() as cursor:
        cursor.execute(
            "UPDATE plans SET is_better = 0, partial = 1"
            " WHERE is_better AND id IN (SELECT plan FROM jobs WHERE plan IS NOT NULL)"
        )
        cursor.execute("DELETE FROM plans WHERE is_better")


def list_plans(database: Database) -> list[Json]:
    """All plans but those on the way of jobs, the newest first."""
    sql = f"{_LISTED} WHERE NOT is_better ORDER BY plans.created_at DESC, plans.rowid DESC"
    return [_show(row) for row in database.connection().execute(sql)]


def plan_json(database: Database, plan: str) -> Json:
    """A plan as lists show it."""
    row = database.connection().execute(f"{_LISTED} WHERE plans.id = ?", (plan,)).fetchone()
    if row is None:
        raise no_such("plan", plan)
    return _show(row)


def plan_report(database: Database, plan: str) -> bytes:
    """The check's report on a plan, as JSON text."""
    return gzip.decompress(row_of(database.connection(), "plan", plan, "report")[0])


def plan_text(database: Database, plan: str) -> bytes:
    """The text of the plan file."""
    return gzip.decompress(packed_plan(database, plan))


def packed_plan(database: Database, plan: str) -> bytes:
    """The text of the plan file packed by gzip."""
    packed: bytes = row_of(database.connection(), "plan", plan, "content")[0]
    return packed


def plan_source(database: Database, plan: str) -> sqlite3.Row:
    """What a job takes over from a plan: name, mission, planner, effort, revision, document and files."""
    columns = "name, mission, planner, effort, revision, document, files"
    return row_of(database.connection(), "plan", plan, columns)


def delete_plan(database: Database, plan: str) -> None:
    """Delete a plan and what was made of it."""
    with database.transaction() as cursor:
        if not cursor.execute("DELETE FROM plans WHERE id = ?", (plan,)).rowcount:
            raise no_such("plan", plan)
        cursor.execute("UPDATE jobs SET plan = NULL WHERE plan = ?", (plan,))
        cursor.execute("UPDATE jobs SET best_plan = NULL WHERE best_plan = ?", (plan,))


def what_is_kept(database: Database, plan: str, what: str) -> bytes | None:
    """What was made of a plan before, such as its playback; None when it was not."""
    sql = "SELECT content FROM made WHERE plan = ? AND what = ?"
    row = database.connection().execute(sql, (plan, what)).fetchone()
    return None if row is None else row[0]


def keep_made(database: Database, plan: str, what: str, content: bytes) -> None:
    """Keep what was made of a plan, in place of the oldest when there are many; nothing for a plan that is gone."""
    with database.transaction() as cursor:
        if cursor.execute("SELECT 1 FROM plans WHERE id = ?", (plan,)).fetchone() is None:
            return
        cursor.execute("INSERT OR REPLACE INTO made VALUES (?, ?, ?)", (plan, what, content))
        cursor.execute(
            "DELETE FROM made WHERE plan = ? AND rowid NOT IN"
            " (SELECT rowid FROM made WHERE plan = ? ORDER BY rowid DESC LIMIT ?)",
            (plan, plan, MOST_MADE),
        )


def _show(row: sqlite3.Row) -> Json:
    values: dict[str, Any] = {name: row[name] for name in _SHOWN}
    change = None if row["change"] is None else json.loads(row["change"])
    told = {"partial": bool(row["partial"]), "facts": json.loads(row["facts"]), "change": change}
    return {**values, **told, "stale": _stale(row)}


def _stale(row: sqlite3.Row) -> list[str]:
    """What has changed in the plan's mission since; nothing where that is gone, or not known."""
    if row["made_files"] is None or row["now_files"] is None:
        return []
    made, now = (json.loads(row[name] or "{}") for name in ("made_document", "now_document"))
    return changes(made, now, json.loads(row["made_files"]), json.loads(row["now_files"]))
