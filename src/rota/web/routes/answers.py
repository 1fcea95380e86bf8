"""Bodies in and out: JSON read within limits, answers as JSON, refusals with their status."""

from __future__ import annotations

import json
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import Response

from rota.web.documents import document_from
from rota.web.refusal import Json, Refusal
from rota.web.state import State


class JsonAnswer(Response):
    """A value, or JSON text that is there already, as JSON in UTF-8."""

    media_type = "application/json"

    def render(self, content: Any) -> bytes:
        """The body."""
        if isinstance(content, bytes):
            return content
        return json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


def state_of(request: Request) -> State:
    """What the server works with."""
    state: State = request.app.state.rota
    return state


async def same_answer(request: Request, task: str) -> Response:
    """What a worker answers to a task that always has the same answer; none is asked again."""
    state = state_of(request)
    if task not in state.kept:
        _, body = await state.pool.ask(task)
        state.kept[task] = json.loads(body)
    return JsonAnswer(state.kept[task])


async def body_of(request: Request) -> bytes:
    """The body of a request with JSON; Refusal 415 for another kind of content, which other sites could send."""
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind != "application/json":
        raise Refusal(415, f"content-type {kind[:80]!r} is not allowed here; application/json is needed")
    return await request.body()


async def json_of(request: Request, *fields: str) -> Json:
    """The body as a JSON object that has no other fields than these."""
    body = await body_of(request)
    value = await run_in_threadpool(document_from, body)
    unknown = sorted(set(value) - set(fields))
    if unknown:
        raise Refusal(400, f"{unknown[0][:80]!r} is not known; {', '.join(fields)} are")
    return value


def text_or_none(value: Json, field: str, longest: int = 200) -> str | None:
    """A text of the body, or None where it is missing or null."""
    given = value.get(field)
    if given is not None and (not isinstance(given, str) or len(given) > longest):
        raise Refusal(400, f"{field}: a text of at most {longest} letters is needed")
    return given


def revision_of(value: Json) -> int | None:
    """The revision of a mission that a body means, or None where it means whichever there is."""
    given = value.get("revision")
    if given is not None and (isinstance(given, bool) or not isinstance(given, int) or given < 1):
        raise Refusal(400, "revision: a whole number from 1 on is needed")
    return given


def asked_number(request: Request, name: str, least: int, most: int) -> int | None:
    """A whole number of the address, or None where it is missing."""
    given = request.query_params.get(name)
    if given is None:
        return None
    if not given.isascii() or not given.isdigit() or len(given) > 12 or not least <= int(given) <= most:
        raise Refusal(400, f"{name}: {given[:40]!r} is not allowed; a whole number from {least} to {most} is needed")
    return int(given)
