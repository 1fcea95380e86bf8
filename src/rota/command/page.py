"""`rota page`: a plan as one page that plays it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rota.check import compiled_packages
from rota.command.arguments import PlanPath, read_plan_argument, require_target
from rota.compiled.compiled_cache import mention_compiling


def page(
    plan: PlanPath,
    output: Annotated[str, typer.Option("-o", "--output", metavar="PAGE", help="The file to write, .html.")],
) -> None:
    """Write a plan as a page that plays it in any browser."""
    from rota.check import check_plan
    from rota.files.atomic_write import require_suffix
    from rota.playback.page import write_page

    require_suffix(Path(output), (".html",), "a page")
    require_target(output, source=plan)
    answer = read_plan_argument(plan)
    mention_compiling(*compiled_packages(answer.mission))
    write_page(answer, check_plan(answer), output)
    typer.echo(output)
