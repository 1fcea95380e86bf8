"""The options that choose a link to robots, the commands' list of links, and what keeps a link from its robots."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from rota.command.terminal import say
from rota.exports import placed_plan
from rota.links.names import LINKS

if TYPE_CHECKING:
    from rota.links.link import Link
    from rota.model.plan import Plan

TROUBLE_S = 0.5  # between two looks at whether a link is in trouble

LinkName = Annotated[str, typer.Option("--link", metavar="LINK", help=f"One of {', '.join(LINKS)}; see below.")]
LinkSettings = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="A setting of the link; may be given often.")
]
ListSettings = Annotated[bool, typer.Option("--settings", help="Print the link's settings and end.")]
LinkOrigin = Annotated[
    str | None, typer.Option("--origin", metavar="LAT,LON", help="Where x = y = 0 lies, if the mission does not say.")
]
# \b keeps the lines as they are
LINKS_LIST = "\b\nLinks:\n" + "\n".join(f"  {name:<10}  {holds}" for name, (_, holds) in LINKS.items())


def chosen_link(name: str, plan: Plan, origin: str | None, settings: list[str] | None) -> Link:
    """The link that the options ask for, not yet open."""
    from rota.links.link_settings import make_link

    return make_link(name, plan if origin is None else placed_plan(plan, origin), settings or ())


@asynccontextmanager
async def open_link(link: Link) -> AsyncIterator[None]:
    """The link open within the block; what keeps it from its robots is told, and when that has passed.

    So is the text of a CancelledError.
    """

    async def tell() -> None:
        told = ""
        while True:
            await asyncio.sleep(TROUBLE_S)
            if link.trouble != told:
                say(f"{link.trouble}; trying again" if link.trouble else "connected again")
                told = link.trouble

    teller = asyncio.create_task(tell())
    try:
        await link.open()
        yield
    except asyncio.CancelledError as stop:
        # what was done about the robots, where the interrupt came at a bad moment
        for line in str(stop).splitlines():
            say(line)
        raise
    finally:
        teller.cancel()
        await link.close()
