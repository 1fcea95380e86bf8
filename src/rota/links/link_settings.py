"""Settings of links, as `--set KEY=VALUE` gives them, and links made of them."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from typing import Any

from rota.errors import RotaError
from rota.links.link import Link
from rota.links.names import LINKS
from rota.model.plan import Plan
from rota.model.planner_settings import Setting, Settings, settings_of


def make_link(name: str, plan: Plan, given: Iterable[str] = ()) -> Link:
    """The link called ``name`` to the robots of a plan, not yet open; ``given``: its settings as KEY=VALUE.

    Raises RotaError for an unknown link, unknown keys, values that a setting does not take, and a library that is not
    installed.
    """
    module = import_module(LINKS[_link_name(name)][0])
    link: Link = module.link_to(plan, parsed_settings(module.SETTINGS, given))
    return link


def settings_help(name: str) -> str:
    """A line for each setting of a link: its key, default and meaning."""
    block = import_module(LINKS[_link_name(name)][0]).SETTINGS
    lines = (f"  {f'{item.name}={_written(item.default)}':<24}  {item.meaning}" for item in settings_of(block))
    return "\n".join((f"Settings of the link {name}:", *lines))


def _link_name(name: str) -> str:
    if name not in LINKS:
        raise RotaError(f"--link: {name!r} is not one of {', '.join(map(repr, LINKS))}")
    return name


def parsed_settings(block: type[Settings], given: Iterable[str]) -> Settings:
    """The settings that KEY=VALUE texts give; a value is read as its setting's kind, ``none`` as null."""
    known = {item.name: item for item in settings_of(block)}
    values: dict[str, Any] = {}
    for text in given:
        key, equals, value = text.partition("=")
        if not equals or key not in known:
            raise RotaError(f"--set: {text!r} is not allowed; KEY=VALUE is needed, with KEY one of {', '.join(known)}")
        if key in values:
            raise RotaError(f"--set: {key} is given twice")
        values[key] = _value(known[key], value)
    return block(**values)


def _value(item: Setting, text: str) -> Any:
    """A setting's value as its text says; text that is none is left to the settings to refuse."""
    if item.optional and text == "none":
        return None
    try:
        if item.kind == "number":
            return float(text)
        if item.kind == "whole":
            return int(text)
        if item.kind == "truth":
            return {"true": True, "false": False}.get(text, text)
    except ValueError:
        pass  # the settings say what is wrong with it
    return text


def _written(value: Any) -> str:
    return "none" if value is None else str(value).lower() if isinstance(value, bool) else str(value)
