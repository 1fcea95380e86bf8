"""The page itself, what it loads, and what it is told of this Rota."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from rota.web.refusal import Json
from rota.web.routes.answers import JsonAnswer, same_answer, state_of

STATIC = Path(__file__).parent.parent / "static"


async def index(request: Request) -> Response:
    """The page."""
    return FileResponse(STATIC / "index.html")


async def about(request: Request) -> Response:
    """Version, planners, formats, limits."""
    return JsonAnswer(await about_of(request))


async def openapi(request: Request) -> Response:
    """The interface as an OpenAPI document."""
    return await same_answer(request, "openapi")


async def docs(request: Request) -> Response:
    """The interface as a page."""
    return FileResponse(STATIC / "docs.html")


async def about_of(request: Request) -> Json:
    """What GET /api/about answers; a worker is asked once."""
    state = state_of(request)
    if "about" not in state.kept:
        _, body = await state.pool.ask("about")
        limits = dataclasses.asdict(state.limits)
        tiles = {"tile_url": None, "tile_attribution": ""}
        if state.tiles is not None:
            tiles = {"tile_url": state.tiles.url, "tile_attribution": state.tiles.attribution}
        state.kept["about"] = {**json.loads(body), "limits": limits, **tiles}
    return state.kept["about"]


routes = [
    Route("/", index, methods=["GET"]),
    Route("/openapi.json", openapi, methods=["GET"]),
    Route("/docs", docs, methods=["GET"]),
    Route("/api/about", about, methods=["GET"]),
]
mounts = [Mount("/static", StaticFiles(directory=STATIC))]
