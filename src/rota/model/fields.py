"""Fields of missions, plans and settings: each declared once, with its default, its limits and what it means.

Readers, writers, JSON Schemas, the page's form, the reference and the dataclass itself go by these declarations.
"""

from __future__ import annotations

import dataclasses
import math
import sys
import types
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import chain
from numbers import Integral, Real
from typing import Any, Final, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

from rota.model.refusals import Where

Bounds = tuple[float | None, float | None]
Count = tuple[int, int | None]
Kind = Literal["number", "whole", "truth", "text", "option", "pair", "list", "block", "either", "other"]

UNITS = {
    "_m_s3": "m/s³", "_m_s2": "m/s²", "_m_s": "m/s", "_rad_s": "rad/s",
    "_deg": "°", "_s": "s", "_m2": "m²", "_m": "m", "_wh": "Wh", "_w": "W", "_percent": "%",
}  # fmt: skip


class Unsaid(Enum):
    """What stands in place of a value that is not given: a robot's that its fleet has; one that has no default."""

    AS_FLEET = "as the fleet has it"
    REQUIRED = "has no default"

    def __repr__(self) -> str:
        return self.name


AS_FLEET: Final = Unsaid.AS_FLEET
REQUIRED: Final = Unsaid.REQUIRED


class Fault(NamedTuple):
    """What is wrong with a value: its kind, and the numbers that the kind speaks of, as ``refusal`` words them."""

    kind: str
    given: dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Field:
    """One field: its type, default and meaning, and what it takes.

    options: of text. elsewhere: who brings other options. least, above, most, below: bounds that always hold, with or
    without the bound itself. written: the least and the most that a mission file may say, None: no other than these.
    count: how many entries a list has, None: one or more; how many letters a text. optional: null is a value. empty: a
    mission file may say null for the default. newer: plan files of older versions lack it. spared: plan files lack it
    while it, or all fields named here, are at their defaults. word: of a list, a text that may stand in its place; in
    Python that is the empty tuple. null_word: a text that stands for None in files.
    item: what the entries of a list are. choices: of "either". block: a dataclass of such fields. flat: its fields
    stand beside the others. key: its name in files. title: its name in forms, where that is not its own. as_fleet: a
    robot has its fleet's value where it has none of its own. preset: a vehicle may have it where a mission file does
    not say it. in_files: the field as files have it, where that is
    another type. needed: in a file. needs, of "either": its choices in words. check, of points: what is wrong with
    them all. reads: what is made of a value that a file gives. says: what its JSON Schema says besides.
    """

    name: str
    kind: Kind
    default: Any = REQUIRED
    meaning: str = ""
    optional: bool = False
    options: tuple[Any, ...] = ()
    elsewhere: str = ""
    block: Any = None
    item: Field | None = None
    choices: tuple[Field, ...] = ()
    least: float | None = None
    above: float | None = None
    most: float | None = None
    below: float | None = None
    written: Bounds | None = None
    count: Count | None = None
    empty: bool = False
    newer: bool = False
    spared: bool | tuple[str, ...] = False
    word: str | None = None
    null_word: str | None = None
    flat: bool = False
    key: str = ""
    title: str = ""
    as_fleet: bool = False
    preset: bool = False
    in_files: Field | None = None
    needed: bool = False
    needs: str = ""
    check: Callable[[Any], str | None] | None = None
    reads: Callable[[Any], Any] | None = None
    says: Mapping[str, Any] = field(default_factory=dict)

    @property
    def unit(self) -> str:
        """The unit that its name ends with; empty where it has none."""
        return unit_of(self.name)

    def bounds(self, in_mission_file: bool) -> dict[str, float]:
        """What numbers must keep to: ge, gt, le, lt."""
        least, above, most, below = self.least, self.above, self.most, self.below
        if in_mission_file and self.written is not None:
            low, high = self.written
            least, most = low if low is not None else least, high if high is not None else most
            above = None if low else above
        if least is not None and least == above:
            least = None
        named = {"ge": least, "gt": above, "le": most, "lt": below}
        return {name: bound for name, bound in named.items() if bound is not None}

    def takes_null(self, in_mission_file: bool) -> bool:
        """Whether null stands for a value, or for the default."""
        return self.optional or (in_mission_file and self.empty)

    def faults(self, value: Any, in_mission_file: bool = False) -> Iterator[tuple[Where, Any, Fault]]:
        """What is wrong with a value in Python, or of elementary types in a file: where in it, its part, and what."""
        if value is None and self.takes_null(in_mission_file):
            return
        fault = self.fault(value, in_mission_file)
        if fault is not None:
            yield (), value, fault
        elif self.item is not None and not (self.word is not None and value in (self.word, ())):
            if self.item.are_plainly_right(value, in_mission_file):
                return
            for k, entry in enumerate(value):
                for where, part, wrong in self.item.faults(entry, in_mission_file):
                    yield (k, *where), part, wrong

    def fault(self, value: Any, in_mission_file: bool = False) -> Fault | None:
        """What is wrong with a value as such, whatever its entries are."""
        if self.kind in ("number", "whole"):
            return self._number_fault(value, in_mission_file)
        if self.kind == "option":
            known = any(value == option and type(value) is type(option) for option in self.options)
            told = {"expected": any_of(self.options), "elsewhere": self.elsewhere}
            return None if known else Fault("literal_error", told)
        if self.kind == "truth":
            return None if isinstance(value, bool) else Fault("bool_type", {})
        if self.kind == "text":
            few = self.count is not None and isinstance(value, str) and len(value) < self.count[0]
            return Fault("too_short", {}) if few else None if isinstance(value, str) else Fault("string_type", {})
        if self.kind in ("pair", "list"):
            return self._count_fault(value)
        if self.kind == "either":
            chosen = self.choice(value)
            return self._wrong_kind() if chosen is None else chosen.fault(value, in_mission_file)
        return self._wrong_kind() if self.kind == "block" and not isinstance(value, self.block) else None

    def _wrong_kind(self) -> Fault:
        return Fault("wrong_kind", {"expected": f"{self.noun} is needed"})

    def choice(self, value: Any) -> Field | None:
        """Which of its choices a value has the form of; mappings are blocks in files."""
        for each in self.choices:
            number = isinstance(value, Integral if each.kind == "whole" else Real) and not isinstance(value, bool)
            forms = {
                "number": number,
                "whole": number,
                "text": isinstance(value, str),
                "option": isinstance(value, str) and value in each.options,
                "list": isinstance(value, list | tuple),
                "pair": isinstance(value, list | tuple),
                "block": isinstance(value, Mapping) or (isinstance(each.block, type) and isinstance(value, each.block)),
            }
            if forms.get(each.kind, False):
                return each
        return None

    @property
    def noun(self) -> str:
        """What it is, for people who write Python."""
        if self.choices:
            return any_of(each.noun for each in self.choices)
        nouns = {"number": "a number", "whole": "a whole number", "text": "text", "list": "a list", "pair": "a pair"}
        return nouns.get(self.kind) or (any_of(self.options) if self.options else str(self.block.__name__))

    def _count_fault(self, value: Any) -> Fault | None:
        """What is wrong with how many entries a list has, or with its being none."""
        if self.word is not None and value in (self.word, ()):
            return None
        if not isinstance(value, list | tuple):
            numbers = self.item is not None and self.item.kind == "number"
            return Fault("tuple_type" if self.kind == "pair" and numbers else "list_type", {})
        least, most = self.count or (1, None)
        if most is not None and len(value) > most:
            return Fault("too_long", {"max_length": most, "actual_length": len(value), "exact": self.kind == "pair"})
        if len(value) < least:
            pair = self.kind == "pair"
            return Fault("too_short", {"min_length": least, "exact": pair} if pair or least > 1 else {})
        return None

    def _number_fault(self, value: Any, in_mission_file: bool) -> Fault | None:
        """What is wrong with a number: its type, or a bound that it breaks."""
        whole = self.kind == "whole"
        is_number: bool = isinstance(value, Integral if whole else Real) and not isinstance(value, bool)
        if not is_number:
            return Fault("int_type" if whole else "float_type", {})
        if not (abs(value) < math.inf and (whole or hasattr(value, "dtype") or abs(value) <= sys.float_info.max)):
            return Fault("finite_number", {})
        for name, bound in self.bounds(in_mission_file).items():
            if not _KEPT[name](value, bound):
                return Fault(_BROKEN[name], {name: bound})
        return None

    def are_plainly_right(self, values: Collection[Any], in_mission_file: bool) -> bool:
        """Whether all values can be seen to be right without a look at each; False where that is not clear."""
        kinds = set(map(type, values))
        if self.kind == "number" and kinds <= {float, int}:
            try:
                finite = all(map(math.isfinite, values))
            except OverflowError:
                return False
            if not finite:
                return False
            ends = (min(values), max(values)) if values else ()
            return all(_KEPT[name](end, bound) for name, bound in self.bounds(in_mission_file).items() for end in ends)
        if self.item is not None and kinds <= {list, tuple} and self.word is None:
            least, most = self.count or (1, None)
            counts = set(map(len, values))
            if any(count < least or (most is not None and count > most) for count in counts):
                return False
            return self.item.are_plainly_right(list(chain.from_iterable(values)), in_mission_file)
        return False


_KEPT: dict[str, Callable[[Any, float], bool]] = {
    "ge": lambda value, bound: value >= bound,
    "gt": lambda value, bound: value > bound,
    "le": lambda value, bound: value <= bound,
    "lt": lambda value, bound: value < bound,
}
_BROKEN = {"ge": "greater_than_equal", "gt": "greater_than", "le": "less_than_equal", "lt": "less_than"}


def any_of(options: Iterable[Any]) -> str:
    """The options in words: a, b or c."""
    *most, last = map(str, options)
    return ", ".join(most) + f" or {last}" if most else last


def unit_of(name: str) -> str:
    """The unit that a field's name ends with; empty where it has none."""
    return next((unit for suffix, unit in UNITS.items() if name.endswith(suffix)), "")


# ---------------------------------------------------------------- declaring


def field_of(default: Any = REQUIRED, meaning: str = "", **takes: Any) -> Any:
    """A field of a dataclass: its default, what it means, and what it takes, as ``Field`` has it.

    default: a class or a function makes it anew each time. count: of lists inside each other one for each, the outer
    one first. form: its type in files, where that is not the type that it is annotated with.
    """
    metadata = {"meaning": meaning, **takes}
    if isinstance(default, type | types.FunctionType):
        return field(default_factory=default, metadata=metadata)
    return field(metadata=metadata) if default is REQUIRED else field(default=default, metadata=metadata)


_DECLARED: dict[type[Any], tuple[Field, ...]] = {}


def fields_of(block: type[Any]) -> tuple[Field, ...]:
    """The declared fields of a dataclass, in their order; of settings, then the blocks of methods."""
    if block not in _DECLARED:
        hints = get_type_hints(block)
        _DECLARED[block] = tuple(
            _field(each.name, hints[each.name], _default(each), dict(each.metadata))
            for each in dataclasses.fields(block)
            if "meaning" in each.metadata
        ) + tuple(
            Field(name=name, kind="block", block=inner, default=inner(), newer=True)
            for name, inner in getattr(block, "method_blocks", dict)().items()
        )
    return _DECLARED[block]


def _default(declared: dataclasses.Field[Any]) -> Any:
    """The default of a field; None where a function makes it."""
    factory = declared.default_factory
    if factory is dataclasses.MISSING:
        return REQUIRED if declared.default is dataclasses.MISSING else declared.default
    return factory() if isinstance(factory, type) else None


def flat_fields_of(block: type[Any]) -> tuple[Field, ...]:
    """The fields as files have them: those of flat blocks in the block's place."""
    found: list[Field] = []
    for each in fields_of(block):
        group: dict[str, Any] = {"says": {"group": each.name}, "as_fleet": each.as_fleet}
        found += (replace(one, **group) for one in fields_of(each.block)) if each.flat else (each,)
    return tuple(found)


def _field(name: str, hint: Any, default: Any, takes: dict[str, Any]) -> Field:
    """A field by its annotation and metadata, with what it holds inside."""
    parts = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
    hints = [part for part in parts if part is not type(None)]
    form = takes.pop("form", None)
    in_files = None if form is None else _field(name, form, default, dict(takes))
    counts: tuple[Count, ...] = takes.pop("count", ())
    told: dict[str, Any] = {"name": name, "default": default, "optional": len(hints) < len(parts), **takes}
    told["in_files"] = in_files
    inside: dict[str, Any] = {key: takes[key] for key in ("check", *_OF_NUMBERS) if key in takes}
    if len(hints) > 1:
        choices = tuple(_field(name, each, REQUIRED, {**inside, "count": counts}) for each in hints)
        return Field(kind="either", choices=choices, **told)
    (hint,) = hints
    if get_origin(hint) is Literal:
        return Field(kind="option", options=get_args(hint), **told)
    if get_origin(hint) is tuple:
        entries = [each for each in get_args(hint) if each is not Ellipsis]
        if get_origin(entries[0]) is tuple and Ellipsis not in get_args(entries[0]):
            inside["check"] = None  # it is one of lists of points
        else:
            told["check"] = None
        item = _field(name, entries[0], REQUIRED, {**inside, "count": counts[1:]})
        if Ellipsis in get_args(hint):
            return Field(kind="list", item=item, count=counts[0] if counts else None, **told)
        return Field(kind="pair", item=item, count=(len(entries), len(entries)), **told)
    if hint in _ELEMENTARY:
        return Field(kind=_ELEMENTARY[hint], count=counts[0] if counts else None, **told)
    if dataclasses.is_dataclass(hint):
        return Field(kind="block", block=hint, **told)
    return Field(kind="other", block=hint, count=counts[0] if counts else None, **told)


_OF_NUMBERS = ("least", "above", "most", "below", "written")
_ELEMENTARY: dict[Any, Kind] = {bool: "truth", int: "whole", float: "number", str: "text"}
