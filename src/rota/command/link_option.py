"""The options that choose a link to robots, and the commands' list of links."""

from __future__ import annotations

from typing import Annotated

import typer

from rota.links.names import LINKS

LinkName = Annotated[str, typer.Option("--link", metavar="LINK", help=f"One of {', '.join(LINKS)}; see below.")]
LinkSettings = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="A setting of the link; may be given often.")
]
ListSettings = Annotated[bool, typer.Option("--settings", help="Print the link's settings and end.")]
# \b keeps the lines as they are
LINKS_LIST = "\b\nLinks:\n" + "\n".join(f"  {name:<10}  {holds}" for name, (_, holds) in LINKS.items())
