"""Planning jobs: started, followed, stopped, run again."""

from __future__ import annotations

import asyncio
import json
import math
from collections.abc import AsyncIterator

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse
from starlette.routing import Route

from rota.web.jobs.live import Listener
from rota.web.jobs.queue import JobQueue
from rota.web.refusal import Json, Refusal
from rota.web.routes.answers import JsonAnswer, json_of, revision_of, state_of, text_or_none
from rota.web.routes.page import about_of
from rota.web.store.missions import mission_source
from rota.web.store.plans import plan_json

ALIVE_EVERY_S = 15.0  # a comment so often keeps what lies between from closing the stream
BETWEEN_S = 0.2  # at most five events a second
MOST_SEED = 2**63 - 1


async def create(request: Request) -> Response:
    """Put a job into the queue."""
    state = state_of(request)
    asked = await json_of(request, "mission", "planner", "effort", "seed", "time_limit_s", "revision")
    mission = text_or_none(asked, "mission")
    if mission is None:
        raise Refusal(400, "mission: is missing; the id of a mission is needed")
    told = {
        "planner": text_or_none(asked, "planner"),
        "effort": text_or_none(asked, "effort"),
        "seed": _seed(asked.get("seed")),
        "time_limit_s": _time_limit_s(asked.get("time_limit_s"), state.limits.job_time_s),
        "revision": revision_of(asked),
    }
    await _require_known(request, told)
    await run_in_threadpool(
        mission_source, state.database, mission, revision_of(asked)
    )  # refuses one that there is not
    await state.pool.ask("require_plannable", mission=mission, planner=told["planner"], effort=told["effort"])
    job = await state.jobs.add(mission, told)
    return JsonAnswer(job, 201, headers={"location": f"/api/jobs/{job['id']}"})


async def replan(request: Request) -> Response:
    """Put a job into the queue that replans from a moment of a plan on."""
    state, plan = state_of(request), request.path_params["id"]
    await run_in_threadpool(plan_json, state.database, plan)  # refuses one that there is not
    asked = await json_of(request, "at_s", "lost", "seed", "time_limit_s")
    at_s, lost = asked.get("at_s"), asked.get("lost")
    if isinstance(at_s, bool) or not isinstance(at_s, int | float) or not math.isfinite(at_s) or at_s < 0:
        raise Refusal(400, "at_s: a number of seconds, 0 or more, is needed")
    if not isinstance(lost, list) or not lost or not all(isinstance(name, str) for name in lost):
        raise Refusal(400, "lost: a list of the names of robots is needed")
    change = {"plan": plan, "at_s": float(at_s), "lost": lost}
    told = {
        "seed": _seed(asked.get("seed")),
        "time_limit_s": _time_limit_s(asked.get("time_limit_s"), state.limits.job_time_s),
    }
    await state.pool.ask("require_change", **change)
    job = await state.jobs.replan(change, told)
    return JsonAnswer(job, 201, headers={"location": f"/api/jobs/{job['id']}"})


async def _require_known(request: Request, told: Json) -> None:
    """Refuse planners and efforts that there are not."""
    about = await about_of(request)
    efforts = {planner["name"]: planner["efforts"] for planner in about["planners"]}
    if told["planner"] is not None and told["planner"] not in efforts:
        raise Refusal(400, f"planner: {told['planner']!r} is not known; {', '.join(efforts)} are")
    known = {effort for each in efforts.values() for effort in each or ()}
    if told["effort"] is not None and told["effort"] not in known:
        raise Refusal(400, f"effort: {told['effort']!r} is not known; {', '.join(sorted(known))} are")


def _seed(given: object) -> int:
    if given is None:
        return 0
    if isinstance(given, bool) or not isinstance(given, int) or not 0 <= given <= MOST_SEED:
        raise Refusal(400, f"seed: a whole number from 0 to {MOST_SEED} is needed")
    return given


def _time_limit_s(given: object, most_s: float) -> float | None:
    if given is None:
        return None
    if isinstance(given, bool) or not isinstance(given, int | float) or not math.isfinite(given) or not given > 0:
        raise Refusal(400, "time_limit_s: a number of seconds greater than 0 is needed")
    return min(float(given), most_s)


async def list_jobs(request: Request) -> Response:
    """All jobs."""
    return JsonAnswer(await state_of(request).jobs.show_all())


async def show(request: Request) -> Response:
    """One job."""
    return JsonAnswer(await state_of(request).jobs.show(request.path_params["id"]))


async def stop(request: Request) -> Response:
    """Stop a job with its best plan so far."""
    return JsonAnswer(await state_of(request).jobs.stop(request.path_params["id"]))


async def again(request: Request) -> Response:
    """Ask the same once more."""
    job = await state_of(request).jobs.again(request.path_params["id"])
    return JsonAnswer(job, 201, headers={"location": f"/api/jobs/{job['id']}"})


async def delete(request: Request) -> Response:
    """Delete a job that is over."""
    await state_of(request).jobs.delete(request.path_params["id"])
    return Response(status_code=204)


async def events(request: Request) -> Response:
    """A job's changes as server-sent events."""
    jobs, job = state_of(request).jobs, request.path_params["id"]
    await jobs.show(job)  # refuses one that there is not
    return event_stream(_tell(jobs, job))


def event_stream(events: AsyncIterator[str]) -> Response:
    """Server-sent events; nothing on the way may keep them back."""
    return StreamingResponse(
        events, media_type="text/event-stream", headers={"cache-control": "no-store", "x-accel-buffering": "no"}
    )


async def _tell(jobs: JobQueue, job: str) -> AsyncIterator[str]:
    """The job now, at each change, and when it is over; before it, each better plan."""
    live, listener = jobs.live(job), Listener()
    if live is not None:
        live.listeners.add(listener)
    try:
        shown = None
        while True:
            over = live is None or live.over
            while listener.better:
                yield event("better", listener.better.popleft())
            now = await jobs.show(job)
            if now != shown:
                yield event("job", now)
                shown = now
            if over:
                return
            if sign := await until_changed(listener):
                yield sign
    finally:
        if live is not None:
            live.listeners.discard(listener)


async def until_changed(listener: Listener) -> str:
    """Wait for news, or for so long that the line needs a sign of life; that sign, or nothing."""
    sign = ""
    try:
        async with asyncio.timeout(ALIVE_EVERY_S):
            await listener.changed.wait()
    except TimeoutError:
        sign = ": still here\n\n"
    await asyncio.sleep(BETWEEN_S)
    listener.changed.clear()
    return sign


def event(name: str, data: Json) -> str:
    """One server-sent event."""
    return f"event: {name}\ndata: {json.dumps(data, allow_nan=False)}\n\n"


routes = [
    Route("/api/jobs", create, methods=["POST"]),
    Route("/api/jobs", list_jobs, methods=["GET"]),
    Route("/api/plans/{id}/replan", replan, methods=["POST"]),
    Route("/api/jobs/{id}", show, methods=["GET"]),
    Route("/api/jobs/{id}", delete, methods=["DELETE"]),
    Route("/api/jobs/{id}/events", events, methods=["GET"]),
    Route("/api/jobs/{id}/stop", stop, methods=["POST"]),
    Route("/api/jobs/{id}/again", again, methods=["POST"]),
]
