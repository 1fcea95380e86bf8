"""`rota serve`: the page on this machine, and for others who have the token."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from rota.command.terminal import say
from rota.errors import RotaError


def serve(
    port: Annotated[int, typer.Option(min=0, max=65535, metavar="PORT", help="0: any free one.")] = 8321,
    host: Annotated[
        str, typer.Option(metavar="HOST", help="Other than this machine's own: everybody needs the token it prints.")
    ] = "127.0.0.1",
    data: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Where missions, plans and jobs are kept.")
    ] = None,
    tile_url: Annotated[
        str | None, typer.Option(metavar="URL", help="Map tiles, with {z}, {x} and {y}; default none.")
    ] = None,
    tile_attribution: Annotated[
        str | None, typer.Option(metavar="TEXT", help="Whose tiles they are; default for OpenStreetMap.")
    ] = None,
    processes: Annotated[
        int | None, typer.Option(min=1, max=64, metavar="NUMBER", help="Plans at once; default half of the cores.")
    ] = None,
    open_page: Annotated[bool, typer.Option("--open/--no-open", help="Show the page in the browser.")] = True,
) -> None:
    """Open the page: draw a mission, plan it, watch it."""
    try:
        from rota.web.serving import Serving
    except ImportError as error:
        raise RotaError(f"{error.name or error} is missing; pip install 'rota[web]'") from None
    serving = Serving(
        data=data or default_folder(),
        host=host,
        port=port,
        tile_url=tile_url,
        tile_attribution=tile_attribution,
        processes=processes or max(1, (os.cpu_count() or 1) // 2),
    )
    serving.run(say, open_page=open_page)


def default_folder() -> Path:
    """The folder rota-data where this user's programs keep what is theirs."""
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Application Support"
    else:
        base = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")
    return base / "rota-data"
