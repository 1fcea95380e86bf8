"""Commands by their names: those of this package, then those that other distributions offer by an entry point."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

import typer
from typer.core import TyperGroup
from typer.main import get_command, get_group

from rota.errors import RotaError
from rota.model.refusals import refusal

ENTRY_POINTS = "rota.commands"  # the group by which other distributions offer theirs, each a typer.Typer
# a command of a distribution that is made beside this one: how to get it
BESIDE = {
    "study": "not installed; it is the distribution rota-studies, which `pip install ./studies` installs in a"
    " checkout of Rota"
}


class Commands(TyperGroup):
    """The group of all commands; what others offer is looked for only when it is asked for, and loaded by its name."""

    def list_commands(self, ctx: Any) -> list[str]:
        """The names: this package's in their order, then others by name."""
        own = super().list_commands(ctx)
        return [*own, *sorted({*offered_commands(), *BESIDE} - set(own))]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of this name; None where there is none."""
        return super().get_command(ctx, cmd_name) or command_elsewhere(cmd_name)

    def invoke(self, ctx: Any) -> Any:
        """Run the command that is asked for. RotaError for values of options of another type, or out of range."""
        try:
            return super().invoke(ctx)
        except typer.BadParameter as bad:
            # pydantic's, by which typer reads values
            faults: list[dict[str, Any]] = getattr(bad.__cause__, "errors", list)()
            kinds = [each["type"].replace("_parsing", "_type") for each in faults]
            told = [refusal(kind, each["input"], each.get("ctx", {})) for kind, each in zip(kinds, faults, strict=True)]
            if bad.param is None or not any(told):
                raise  # typer's own words name the value
            raise RotaError(f"{bad.param.opts[0]}: {told[0]}") from None


@cache
def offered_commands() -> dict[str, str]:
    """Names and places of the commands that other distributions offer."""
    from importlib.metadata import entry_points

    return {point.name: point.value for point in entry_points(group=ENTRY_POINTS)}


def command_elsewhere(name: str) -> Any:
    """The command that another distribution offers; one that tells why it cannot run; None for an unknown name."""
    where = offered_commands().get(name)
    if where is None:
        return _refusing(name, BESIDE[name]) if name in BESIDE else None
    module, _, attribute = where.partition(":")
    try:
        return get_group(getattr(import_module(module), attribute))
    except Exception as error:
        return _refusing(name, f"cannot be loaded from {where}: {error}")


def _refusing(name: str, message: str) -> Any:
    """A command that ends with this error, whatever it is given."""

    def refuse() -> None:
        raise RotaError(f"{name}: {message}")

    app = typer.Typer(add_completion=False, rich_markup_mode=None)
    whatever = {"allow_extra_args": True, "ignore_unknown_options": True}
    app.command(help=message, short_help=f"See rota {name} -h: it is not there.", context_settings=whatever)(refuse)
    return get_command(app)
