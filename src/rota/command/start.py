"""`rota new` and `rota schema`: an example to start from, and what files may hold."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from rota.command.terminal import STANDARD_STREAM
from rota.errors import RotaError

SchemaName = Literal["mission", "plan", "report", "sweep"]


def new(
    mission: Annotated[Path, typer.Argument(metavar="MISSION", help="The file to write; - stdout.")] = Path(
        "mission.yaml"
    ),
) -> None:
    """Write a commented example mission to start from."""
    from rota.files.atomic_write import write_atomically
    from rota.files.example_mission import example_mission_text

    if str(mission) == STANDARD_STREAM:
        typer.echo(example_mission_text(), nl=False)
        return
    if os.path.lexists(mission):
        raise RotaError(f"{mission}: exists already and is not overwritten; name another file")
    write_atomically(mission, example_mission_text())
    typer.echo(f"{mission}: edit it, then: rota plan {mission}")


def schema(
    name: Annotated[SchemaName, typer.Argument(metavar="NAME", help="mission, plan, report or sweep.")],
) -> None:
    """Print the JSON Schema of a file format."""
    typer.echo(json.dumps(_schema_maker(name)(), indent=1))


def _schema_maker(name: SchemaName) -> Callable[[], dict[str, Any]]:
    """The function that makes the JSON Schema of this name."""
    if name == "mission":
        from rota.files.mission_file import mission_schema

        return mission_schema
    if name == "plan":
        from rota.files.plan_schema import plan_schema

        return plan_schema
    if name == "sweep":
        from rota.files.sweep_file import sweep_schema

        return sweep_schema
    from rota.check import report_schema

    return report_schema
