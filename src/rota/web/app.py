"""The server: its routes behind its guard, and what starts and ends with it."""

from __future__ import annotations

import logging
import sqlite3
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from rota.files.sole_user import SoleUser
from rota.web.jobs.queue import JobQueue
from rota.web.jobs.watches import WatchDesk
from rota.web.limits import Limits
from rota.web.refusal import Refusal, unkept
from rota.web.routes import jobs, missions, page, plans, watches
from rota.web.routes.answers import JsonAnswer
from rota.web.security import Guard, Security
from rota.web.state import State
from rota.web.store.database import Database
from rota.web.tiles import Tiles
from rota.web.workers.pool import Pool

log = logging.getLogger(__name__)
POOL_SIZE = 2


def make_app(
    data: Path, guard: Guard, limits: Limits | None = None, tiles: Tiles | None = None, *, prepares: bool = True
) -> Starlette:
    """The server of a data folder, which it holds from now until it ends.

    Raises RotaError for a folder that another server uses, or that cannot be used.

    prepares: load what planning and validating need ahead of the first request.
    """
    given = limits or Limits()
    in_use = "another rota serve uses this folder; end it, or give another --data"
    sole = SoleUser(data, kept="missions and plans", in_use=in_use)
    database = Database(data)

    @asynccontextmanager
    async def life(app: Starlette) -> AsyncIterator[None]:
        pool = Pool(POOL_SIZE, str(data), given)
        queue = JobQueue(database, given, prepares=prepares)
        desk = WatchDesk(str(data), given)
        app.state.rota = State(database=database, pool=pool, jobs=queue, watches=desk, limits=given, tiles=tiles)
        try:
            await queue.open()
            if prepares:
                await pool.prepare()
            yield
        finally:
            await desk.close()
            await queue.close()
            await pool.close()
            database.close()
            sole.close()

    return Starlette(
        routes=[*all_routes(), *page.mounts],
        middleware=[
            Middleware(
                Security,
                guard=guard,
                tiles=tiles,
                json_bytes=given.document_bytes,
                upload_bytes=given.upload_bytes,
            )
        ],
        exception_handlers={
            Refusal: _refuse,
            HTTPException: _http_error,
            sqlite3.Error: _unkept,
            OSError: _unkept,
            Exception: _fault,
        },
        lifespan=life,
    )


def all_routes() -> list[Route]:
    """Every route but the files of the page."""
    return [*page.routes, *missions.routes, *jobs.routes, *plans.routes, *watches.routes]


async def _refuse(request: Request, error: Exception) -> Response:
    assert isinstance(error, Refusal)
    headers = {"retry-after": "5"} if error.status in (429, 503) else None
    return JsonAnswer(error.to_json(), error.status, headers=headers)


async def _http_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    message = {404: "there is nothing at this address", 405: "this is not possible at this address"}
    refusal = Refusal(error.status_code, message.get(error.status_code, error.detail))
    return JsonAnswer(refusal.to_json(), error.status_code, headers=error.headers)


async def _unkept(request: Request, error: Exception) -> Response:
    refusal = unkept(error)
    if refusal is None:
        raise error
    log.error("%s: %s", refusal, error)
    return await _refuse(request, refusal)


async def _fault(request: Request, error: Exception) -> Response:
    refusal = Refusal(500, "a fault in Rota, not in what was sent; the server's log has it")
    return JsonAnswer(refusal.to_json(), 500)
