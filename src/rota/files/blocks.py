"""Blocks of files, mappings with known keys made of declared fields; read with every fault told at its place."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple, TypeVar

from rota.errors import RotaError
from rota.files.yaml_text import Document, Place
from rota.model.field_values import tuples_of
from rota.model.fields import REQUIRED, Field, fields_of, flat_fields_of
from rota.model.planner_settings import Settings
from rota.model.refusals import Where, refusal

Made = TypeVar("Made")
Form = Literal["mission", "plan"]
Rules = Callable[[dict[str, Any]], Iterable[tuple[Where, str]]]


class Fault(NamedTuple):
    """What is wrong, what is allowed, and where; ``at_key``: the key itself is at fault, not its value."""

    place: Place
    message: str
    at_key: bool = False


@dataclass(frozen=True, kw_only=True)
class Block:
    """A mapping as one form of file has it: its fields, with the bounds that hold there.

    rules: contradictions between the raw values, each as the field at fault and what is wrong with it. makes: what is
    made of the values; None: they stay as they are, by their names. settings: the type whose contradictions are told.
    elsewhere: who brings keys that are not known. says: what its JSON Schema says besides. is_open: other keys are
    passed over.
    """

    name: str
    meaning: str
    fields: tuple[Field, ...]
    rules: Rules = lambda data: ()
    makes: Callable[..., Any] | None = None
    settings: type[Settings] | None = None
    elsewhere: str = ""
    says: Mapping[str, Any] = field(default_factory=dict)
    is_open: bool = False


Blocks = Mapping[Any, "Block | Field"]


def block_of(kind: type[Any], form: Form, blocks: Blocks | None = None, **more: Any) -> Block:
    """The block of a dataclass with declared fields. blocks: those of other dataclasses that are not just so."""
    meaning = (kind.__doc__ or "").partition("\n")[0]
    told: dict[str, Any] = {"name": kind.__name__, "meaning": meaning, "fields": fields_in(kind, form, blocks)}
    if issubclass(kind, Settings):
        told |= {"settings": kind if form == "mission" else None, "elsewhere": kind.elsewhere}
    return Block(**told | more)


def fields_in(kind: type[Any], form: Form, blocks: Blocks | None = None) -> tuple[Field, ...]:
    """The fields of a dataclass as a form of file has them."""
    return tuple(field_in(each, form, blocks) for each in flat_fields_of(kind))


def field_in(item: Field, form: Form, blocks: Blocks | None = None) -> Field:
    """A field as a form of file has it: by its name there, with the bounds and the default that hold there."""
    known, written = blocks or {}, form == "mission"
    if isinstance(named := known.get(item.name), Field):
        return named
    item = item.in_files or item
    if item.kind == "either" and all(hasattr(each.block, "tag") for each in item.choices):
        item = replace(item, kind="block", block=_tagged_block(item.choices, form), choices=())
    elif item.kind in ("block", "other") and item.block in known:
        found = known[item.block]
        if isinstance(found, Field):
            return replace(found, name=item.key or item.name, meaning=item.meaning)
        item = replace(item, block=found)
    elif item.kind == "block" and isinstance(item.block, type):
        makes = item.block if issubclass(item.block, Settings) else None
        own = written and makes is not None
        item = replace(item, block=block_of(item.block, form, known, makes=makes), empty=own)
    elsewhere = written and (item.as_fleet or item.preset)
    bounds, null = item.bounds(written), item.takes_null(written) or elsewhere
    required = item.default is REQUIRED and not elsewhere if written else not (item.newer or item.spared)
    return replace(
        item,
        name=item.key or item.name,
        default=None if null and written else item.default,
        optional=null,
        empty=null and not item.optional,
        needed=required,
        least=bounds.get("ge"),
        above=bounds.get("gt"),
        most=bounds.get("le"),
        below=bounds.get("lt"),
        written=None,
        item=item.item and field_in(item.item, form, known),
        choices=tuple(field_in(each, form, known) for each in item.choices),
    )


def _tagged_block(kinds: Iterable[Field], form: Form) -> Block:
    """The block of dataclasses that a key tells apart, as ``shape`` does sensors: the fields of all of them."""
    named = {kind.block.tag[1]: kind.block for kind in kinds}
    key = next(kind.tag[0] for kind in named.values())
    own = {name: fields_in(kind, form) for name, kind in named.items()}
    needed = {name: [item.name for item in items if item.needed] for name, items in own.items()}
    each = {item.name: item for items in own.values() for item in items}
    foreign = {name: [other for other in each if other not in {item.name for item in own[name]}] for name in own}

    def rules(data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """What one of them lacks, and what belongs to another."""
        name = data.get(key)
        if not isinstance(name, str) or name not in named:
            return
        for item in needed[name]:
            if data.get(item) is None:
                yield (item,), f"is missing; a {name} sensor needs it, in metres"
        for item in foreign[name]:
            if data.get(item) is not None:
                instead = (
                    f"it has {needed[name][0]}" if any(item in names for names in needed.values()) else "remove it"
                )
                yield (item,), f"does not belong to a {name} sensor; {instead}"

    def make_tagged(**values: Any) -> Any:
        """The one that the key names."""
        kind = named[values.pop(key)]
        return kind(**{name: value for name, value in values.items() if value is not None})

    tag = Field(name=key, kind="option", options=tuple(named), needed=True)
    free = [replace(item, needed=False, optional=True, default=None) for item in each.values()]
    return Block(
        name="sensor",
        meaning="What a robot sees round itself.",
        fields=(tag, *free),
        rules=rules,
        makes=make_tagged,
        says={
            "oneOf": [
                {
                    "properties": {key: {"const": name}, **{other: {"type": "null"} for other in foreign[name]}},
                    "required": needed[name],
                }
                for name in named
            ]
        },
    )


# ---------------------------------------------------------------- reading


def read_block(block: Block, data: Any) -> tuple[Any, list[Fault]]:
    """What a block of a parsed file comes to, and all faults in it; None where it is no mapping, or makes nothing."""
    faults: list[Fault] = []
    return _block_value(block, data, (), faults), faults


def read_field(item: Field, data: Any) -> tuple[Any, list[Fault]]:
    """A value as its field reads it, None where it is at fault, and all faults in it."""
    faults: list[Fault] = []
    value = _value(item, data, (), faults)
    return None if faults else value, faults


def _block_value(block: Block, data: Any, place: Place, faults: list[Fault]) -> Any:
    """The values of a block by their names, or what it makes of them. Adds to ``faults``."""
    if not isinstance(data, dict):
        faults.append(Fault(place, refusal("model_type", data, {})))
        return None
    before = len(faults)
    values: dict[str, Any] = {}
    unclear = False
    for item in block.fields:
        if item.name in data:
            so_far = len(faults)
            value = _value(item, data[item.name], (*place, item.name), faults)
            unclear |= len(faults) > so_far and item.kind == "option"
            if block.settings is not None and value is not None and item.kind in ("pair", "list"):
                value = value and data[item.name]  # as it is written, for what is said of it
            if len(faults) == so_far and not (block.settings and value is None and item.empty):
                values[item.name] = value
        elif item.needed:
            faults.append(Fault((*place, item.name), refusal("missing", None, {})))
    known = list(dict.fromkeys(item.name for item in block.fields))
    for key in data if not block.is_open else ():
        if key not in known:
            hint = nearest_key(str(key), known)
            if block.elsewhere:  # where a near name may be none that is meant
                hint = f"known here: {', '.join(known)}; {block.elsewhere}"
            faults.append(Fault((*place, key), f"unknown key; {hint}", at_key=True))
    told = list(block.rules(data))
    if block.settings is not None and not unclear:
        told += [*block.settings.contradictions(values), *block.settings.useless_values(values)]
    faults += [Fault((*place, *where), message) for where, message in told]
    if block.makes is None or len(faults) > before:
        return values
    return _make(block.makes, values, place, faults)


def _make(makes: Callable[..., Any], values: dict[str, Any], place: Place, faults: list[Fault]) -> Any:
    """What is made of values; None where they make nothing. Adds to ``faults``."""
    try:
        return makes(**values)
    except RotaError as error:
        faults += [Fault(place, message) for message in getattr(error, "faults", (str(error),))]
        return None


def _value(item: Field, value: Any, place: Place, faults: list[Fault]) -> Any:
    """A value of a field. Adds to ``faults``."""
    if value is None and item.optional:
        return None
    if item.kind == "either":
        chosen = item.choice(value)
        if chosen is None:
            faults.append(Fault(place, refusal("wrong_kind", value, {}, item.needs or f"{item.noun} is needed")))
            return None
        item = chosen
    if item.kind == "block":
        return _block_value(item.block, value, place, faults)
    inside = item.item
    so_far = len(faults)
    if inside is not None and inside.kind in ("block", "either", "list"):
        found: list[tuple[Where, Any, Any]] = [((), value, fault)] if (fault := item.fault(value)) is not None else []
        entries = [] if found else [_value(inside, entry, (*place, k), faults) for k, entry in enumerate(value)]
    else:
        found, entries = list(item.faults(value)), value
    faults += [
        Fault((*place, *where), refusal(w.kind, part, w.given, w.given.get("expected", ""))) for where, part, w in found
    ]
    if len(faults) > so_far:
        return None
    if item.check is not None and (wrong := item.check(entries)) is not None:
        faults.append(Fault(place, wrong))
        return None
    if (reads := item.reads) is not None:
        return _make(lambda given: reads(given), {"given": entries}, place, faults)
    return () if item.word is not None and value == item.word else tuples_of(item, entries)


def nearest_key(key: str, known: list[str]) -> str:
    """A hint for an unknown key: the nearest known one, or all that are known."""
    near = difflib.get_close_matches(key, known, n=1)
    return f"did you mean {near[0]!r}?" if near else f"known here: {', '.join(known)}"


def lines_of_faults(document: Document, faults: Iterable[Fault]) -> list[str]:
    """One line ``file:line:column: path.to.field: message`` per fault, in the file's order, none twice."""
    ordered = sorted(faults, key=lambda fault: document.position(fault.place, key=fault.at_key))
    return list(dict.fromkeys(document.line(fault.place, fault.message, key=fault.at_key) for fault in ordered))


def make(kind: type[Made], /, **values: Any) -> Made:
    """A dataclass of the values that a file gives; a robot that does not say something has the usual value of it."""
    told = dict(values)
    for item in fields_of(kind):
        if item.flat:
            inner = [each.name for each in fields_of(item.block) if each.name in told]
            told[item.name] = item.block(**{name: told.pop(name) for name in inner})
        elif item.key and item.key in told:
            told[item.name] = told.pop(item.key)
        elif item.as_fleet:
            told.setdefault(item.name, item.default)
    return kind(**told)
