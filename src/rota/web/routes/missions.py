"""Missions: kept, read from files and examples, validated while they are edited."""

from __future__ import annotations

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from rota.web.documents import require_few_vertices
from rota.web.refusal import Json, Refusal, no_such
from rota.web.routes.answers import JsonAnswer, body_of, json_of, revision_of, same_answer, state_of, text_or_none
from rota.web.routes.downloads import download
from rota.web.routes.uploads import uploaded_files
from rota.web.store.missions import (
    change_mission,
    delete_mission,
    list_missions,
    mission_json,
    new_mission,
)
from rota.web.tasks.examples import example_names


async def examples(request: Request) -> Response:
    """All examples by name."""
    return JsonAnswer(await run_in_threadpool(example_names))


async def example(request: Request) -> Response:
    """An example as a document."""
    name = request.path_params["name"]
    if name not in {entry["name"] for entry in await run_in_threadpool(example_names)}:
        raise no_such("example", name)
    _, body = await state_of(request).pool.ask("example", name=name)
    return JsonAnswer(body)


async def read(request: Request) -> Response:
    """Uploaded files as a document to be edited; ``as`` tells what the features of GeoJSON files are."""
    state = state_of(request)
    upload = await uploaded_files(request, state.limits.upload_files)
    _, body = await state.pool.ask("read", upload=upload, roles=request.query_params.get("as"))
    return JsonAnswer(body)


async def list_all(request: Request) -> Response:
    """All missions."""
    return JsonAnswer(await run_in_threadpool(list_missions, state_of(request).database))


async def create(request: Request) -> Response:
    """Keep a mission: a document, perhaps with an upload, or an example."""
    state = state_of(request)
    asked = await json_of(request, "document", "upload", "example")
    name, upload = text_or_none(asked, "example"), text_or_none(asked, "upload")
    if (name is None) == ("document" not in asked):
        raise Refusal(400, "give exactly one of document and example")
    if name is not None:
        if name not in {entry["name"] for entry in await run_in_threadpool(example_names)}:
            raise no_such("example", name)
        answer, _ = await state.pool.ask("example", name=name, keep=True)
        made = await run_in_threadpool(mission_json, state.database, answer["mission"])
    else:
        document = _document(asked, state.limits.vertices)
        made = await run_in_threadpool(new_mission, state.database, document, upload=upload, most=state.limits.missions)
    return JsonAnswer(made, 201, headers={"location": f"/api/missions/{made['id']}"})


async def show(request: Request) -> Response:
    """One mission."""
    return JsonAnswer(await run_in_threadpool(mission_json, state_of(request).database, request.path_params["id"]))


async def change(request: Request) -> Response:
    """Replace a mission's document; 409 where somebody else changed it since the revision that is named."""
    state = state_of(request)
    asked = await json_of(request, "document", "upload", "name", "revision")
    document = _document(asked, state.limits.vertices)
    changed = await run_in_threadpool(
        change_mission, state.database, request.path_params["id"], document, upload=text_or_none(asked, "upload"),
        revision=revision_of(asked),
    )  # fmt: skip
    return JsonAnswer(changed)


async def delete(request: Request) -> Response:
    """Delete a mission."""
    await run_in_threadpool(delete_mission, state_of(request).database, request.path_params["id"])
    return Response(status_code=204)


async def as_yaml(request: Request) -> Response:
    """A mission as a file."""
    return await _as_file(request, "yaml")


async def as_zip(request: Request) -> Response:
    """A mission as an archive with the files that it names."""
    return await _as_file(request, "zip")


async def _as_file(request: Request, kind: str) -> Response:
    answer, body = await state_of(request).pool.ask("yaml", mission=request.path_params["id"], kind=kind)
    return download(body, answer["name"], answer["type"])


async def schema(request: Request) -> Response:
    """The JSON Schema of mission files."""
    return await same_answer(request, "schema")


async def validate(request: Request) -> Response:
    """What is wrong with a document; the newest request of a tab takes the place of those that wait."""
    body = await body_of(request)
    tab = request.query_params.get("tab")
    _, answer = await state_of(request).pool.ask("validate", body, replaces=tab and f"validate {tab[:80]}")
    return JsonAnswer(answer)


def _document(asked: Json, most_vertices: int) -> Json:
    document = asked.get("document")
    if not isinstance(document, dict):
        raise Refusal(400, "document: a mission as a JSON object is needed")
    require_few_vertices(document, most_vertices)
    return document


routes = [
    Route("/api/examples", examples, methods=["GET"]),
    Route("/api/examples/{name}", example, methods=["GET"]),
    Route("/api/missions/read", read, methods=["POST"]),
    Route("/api/missions", list_all, methods=["GET"]),
    Route("/api/missions", create, methods=["POST"]),
    Route("/api/missions/{id}", show, methods=["GET"]),
    Route("/api/missions/{id}", change, methods=["PUT"]),
    Route("/api/missions/{id}", delete, methods=["DELETE"]),
    Route("/api/missions/{id}/mission.yaml", as_yaml, methods=["GET"]),
    Route("/api/missions/{id}/mission.zip", as_zip, methods=["GET"]),
    Route("/api/schema/mission", schema, methods=["GET"]),
    Route("/api/validate", validate, methods=["POST"]),
]
