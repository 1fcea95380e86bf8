"""Plans: listed, added, played, and taken away as files."""

from __future__ import annotations

import gzip
import json
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from rota.web.refusal import Json, no_such
from rota.web.routes.answers import JsonAnswer, asked_number, state_of
from rota.web.routes.downloads import download
from rota.web.routes.page import about_of
from rota.web.routes.uploads import uploaded_contents
from rota.web.store.plans import (
    delete_plan,
    keep_made,
    list_plans,
    packed_plan,
    plan_json,
    plan_report,
    what_is_kept,
)

MOST_CELLS = 200_000
CELLS = 20_000


async def list_all(request: Request) -> Response:
    """All plans."""
    return JsonAnswer(await run_in_threadpool(list_plans, state_of(request).database))


async def add(request: Request) -> Response:
    """Check and keep a plan file."""
    state = state_of(request)
    contents = await uploaded_contents(request, 1)
    ((name, content),) = contents.items()
    answer, _ = await state.pool.ask("keep_plan", content, name=name)
    plan = await run_in_threadpool(plan_json, state.database, answer["plan"])
    return JsonAnswer(plan, 201, headers={"location": f"/api/plans/{plan['id']}"})


async def show(request: Request) -> Response:
    """A plan with the check's report."""
    return JsonAnswer(await run_in_threadpool(_with_report, request))


def _with_report(request: Request) -> Json:
    database, plan = state_of(request).database, request.path_params["id"]
    return {**plan_json(database, plan), "report": json.loads(plan_report(database, plan))}


async def delete(request: Request) -> Response:
    """Delete a plan."""
    await run_in_threadpool(delete_plan, state_of(request).database, request.path_params["id"])
    return Response(status_code=204)


async def playback(request: Request) -> Response:
    """What the page plays; made once and kept."""
    cells = asked_number(request, "cells", 100, MOST_CELLS) or CELLS
    body = await _make(request, f"playback {cells}", "playback", cells=cells)
    headers = {"vary": "accept-encoding"}
    if "gzip" in request.headers.get("accept-encoding", ""):
        headers["content-encoding"] = "gzip"
    else:
        body = await run_in_threadpool(gzip.decompress, body)
    return Response(body, media_type="application/octet-stream", headers=headers)


async def plan_file(request: Request) -> Response:
    """The plan file; of a plan whose mission has changed it says what did."""
    database, plan = state_of(request).database, request.path_params["id"]
    shown = await run_in_threadpool(plan_json, database, plan)
    packed = await run_in_threadpool(packed_plan, database, plan)
    text = await run_in_threadpool(gzip.decompress, packed)
    if shown["stale"]:
        text = b'{"mission_changes": ' + json.dumps(shown["stale"]).encode() + b",\n " + text.removeprefix(b"{")
    return download(text, f"{shown['name']}{_mark(shown)}.rota.json", "application/json")


async def picture(request: Request) -> Response:
    """The plan as a picture."""
    return download(await _make(request, "picture", "picture"), await _file_name(request, ".png"), "image/png")


async def page(request: Request) -> Response:
    """The plan as one page that plays it."""
    return download(await _make(request, "page", "page"), await _file_name(request, ".html"), "text/html")


async def export(request: Request) -> Response:
    """The plan as maps and robots read it."""
    state, asked = state_of(request), request.query_params
    to = request.path_params["format"]
    if to not in {known["name"] for known in (await about_of(request))["formats"]}:
        raise no_such("format", to)
    plan = request.path_params["id"]
    shown = await run_in_threadpool(plan_json, state.database, plan)  # refuses one that there is not
    answer, body = await state.pool.ask(
        "export", plan=plan, format=to, mark=_mark(shown), origin=asked.get("origin") or None,
        start_time=asked.get("start_time") or None, settings=asked.getlist("set"),
    )  # fmt: skip
    return download(body, answer["name"], answer["type"])


async def _file_name(request: Request, suffix: str) -> str:
    shown = await run_in_threadpool(plan_json, state_of(request).database, request.path_params["id"])
    return f"{shown['name']}{_mark(shown)}{suffix}"


def _mark(shown: Json) -> str:
    """What names of files say of a plan: that its mission has changed since."""
    return "-stale" if shown["stale"] else ""


async def _make(request: Request, key: str, task: str, **given: Any) -> bytes:
    """What a worker makes of the plan, or made before."""
    state, plan = state_of(request), request.path_params["id"]
    await run_in_threadpool(plan_json, state.database, plan)  # refuses one that there is not
    known = await run_in_threadpool(what_is_kept, state.database, plan, key)
    if known is not None:
        return known
    _, body = await state.pool.ask(task, plan=plan, **given)
    await run_in_threadpool(keep_made, state.database, plan, key, body)
    return body


routes = [
    Route("/api/plans", list_all, methods=["GET"]),
    Route("/api/plans", add, methods=["POST"]),
    Route("/api/plans/{id}", show, methods=["GET"]),
    Route("/api/plans/{id}", delete, methods=["DELETE"]),
    Route("/api/plans/{id}/playback", playback, methods=["GET"]),
    Route("/api/plans/{id}/plan.rota.json", plan_file, methods=["GET"]),
    Route("/api/plans/{id}/picture.png", picture, methods=["GET"]),
    Route("/api/plans/{id}/page.html", page, methods=["GET"]),
    Route("/api/plans/{id}/export/{format}", export, methods=["GET"]),
]
