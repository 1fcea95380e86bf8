"""Live fleets: watched by a link, told as they go."""

from __future__ import annotations

from collections.abc import AsyncIterator

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from rota.web.jobs.live import Listener
from rota.web.jobs.watches import LiveWatch, notices_after
from rota.web.refusal import Json, Refusal
from rota.web.routes.answers import JsonAnswer, json_of, state_of, text_or_none
from rota.web.routes.jobs import event, event_stream, until_changed
from rota.web.routes.page import about_of
from rota.web.routes.plans import CELLS, MOST_CELLS
from rota.web.store.plans import plan_json

MOST_SETTINGS = 50


async def list_watches(request: Request) -> Response:
    """All live fleets."""
    return JsonAnswer(state_of(request).watches.show_all())


async def create(request: Request) -> Response:
    """Watch the fleet of a plan."""
    state = state_of(request)
    asked = await json_of(request, "plan", "link", "settings", "origin", "cells")
    plan, link = text_or_none(asked, "plan"), text_or_none(asked, "link") or "simulated"
    if plan is None:
        raise Refusal(400, "plan: is missing; the id of a plan is needed")
    known = {entry["name"] for entry in (await about_of(request))["links"]}
    if link not in known:
        raise Refusal(400, f"link: {link!r} is not known; {', '.join(sorted(known))} are")
    await run_in_threadpool(plan_json, state.database, plan)  # refuses one that there is not
    told = {
        "plan": plan,
        "link": link,
        "settings": _settings(asked.get("settings")),
        "cells": _cells(asked.get("cells")),
    }
    watch = state.watches.start({**told, "origin": text_or_none(asked, "origin")})
    return JsonAnswer(watch.show(), 201, headers={"location": f"/api/watches/{watch.id}"})


def _settings(given: object) -> list[str]:
    """A link's settings as KEY=VALUE, from such texts or from an object."""
    if isinstance(given, dict):
        given = [f"{key}={'none' if value is None else value}" for key, value in given.items()]
    listed = given if given is not None else []
    if not isinstance(listed, list) or len(listed) > MOST_SETTINGS or not all(isinstance(text, str) for text in listed):
        raise Refusal(400, "settings: texts KEY=VALUE, or an object of them, are needed")
    return listed


def _cells(given: object) -> int:
    if given is None:
        return CELLS
    if isinstance(given, bool) or not isinstance(given, int) or not 100 <= given <= MOST_CELLS:
        raise Refusal(400, f"cells: a whole number from 100 to {MOST_CELLS} is needed")
    return given


async def show(request: Request) -> Response:
    """One live fleet."""
    return JsonAnswer(state_of(request).watches.find(request.path_params["id"]).show())


async def stop(request: Request) -> Response:
    """End a watch."""
    watch = await state_of(request).watches.stop(request.path_params["id"])
    return JsonAnswer(watch.show())


async def events(request: Request) -> Response:
    """What a watch tells, as server-sent events."""
    return event_stream(_tell(state_of(request).watches.find(request.path_params["id"])))


async def _tell(watch: LiveWatch) -> AsyncIterator[str]:
    """Notices, the state whenever there is a new one, and the end."""
    listener, last, number = Listener(), None, 0
    watch.listeners.add(listener)
    try:
        while True:
            over = watch.over
            for count, notice in notices_after(watch, number):
                yield event("notice", notice)
                number = count
            if watch.last is not None and watch.last is not last:
                last = watch.last
                yield f"event: state\ndata: {last.decode()}\n\n"
            if over:
                ended: Json = watch.show()
                yield event("ended", ended)
                return
            if sign := await until_changed(listener):
                yield sign
    finally:
        watch.listeners.discard(listener)


routes = [
    Route("/api/watches", list_watches, methods=["GET"]),
    Route("/api/watches", create, methods=["POST"]),
    Route("/api/watches/{id}", show, methods=["GET"]),
    Route("/api/watches/{id}/events", events, methods=["GET"]),
    Route("/api/watches/{id}/stop", stop, methods=["POST"]),
]
