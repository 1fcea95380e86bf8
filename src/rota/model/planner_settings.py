"""Settings of planners: each declared once, as a field that says what it means, its default and what it takes.

Files, their JSON Schemas and the dataclass itself refuse by these declarations.
"""

from __future__ import annotations

import dataclasses
import math
import types
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from numbers import Integral, Real
from typing import Any, ClassVar, Literal, NamedTuple, Protocol, Self, Union, get_args, get_origin, get_type_hints

from rota.errors import MissionError
from rota.model.refusals import Where, path_of, refusal

Corners = Literal["blocked", "pass"]
Contact = Literal["swept", "grid"]
ContactFree = Literal["cycle", "trajectory"]
Bounds = tuple[float | None, float | None]

# what a mission file may say: generous for anything that moves on this planet, and no square, sum or quotient of it
# overflows or is lost
LENGTH, LENGTH_OR_ZERO, DURATION = (1e-3, 1e7), (0.0, 1e7), (1e-3, 1e9)


class Fault(NamedTuple):
    """What is wrong with a value, as pydantic names it: its kind, and the numbers that the kind speaks of."""

    kind: str
    given: dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Setting:
    """One setting: its type, default and meaning, and what it takes.

    options: of text. least, above, most, below: bounds that always hold, with or without the bound itself. written:
    the least and the most that a mission file may say, None: no other than these. optional: null is a value. empty: a
    mission file may say null for the default. newer: plan files of older versions lack it. spared: plan files lack it
    while it is at its default. word: of a list, a text that may stand in its place; in Python that is the empty tuple.
    whole: of a list, whether its numbers are whole.
    """

    name: str
    kind: Literal["number", "whole", "truth", "text", "option", "pair", "list", "block"]
    default: Any
    meaning: str
    optional: bool
    options: tuple[str, ...] = ()
    block: type[Settings] | None = None
    least: float | None = None
    above: float | None = None
    most: float | None = None
    below: float | None = None
    written: Bounds | None = None
    empty: bool = False
    newer: bool = False
    spared: bool = False
    word: str | None = None
    whole: bool = False

    def bounds(self, in_mission_file: bool) -> dict[str, float]:
        """What numbers must keep to, by pydantic's names: ge, gt, le, lt."""
        least, above, most, below = self.least, self.above, self.most, self.below
        if in_mission_file and self.written is not None:
            low, high = self.written
            least, most = low if low is not None else least, high if high is not None else most
            above = None if low else above
        if least is not None and least == above:
            least = None
        named = {"ge": least, "gt": above, "le": most, "lt": below}
        return {name: bound for name, bound in named.items() if bound is not None}

    def faults(self, value: Any, in_mission_file: bool = False) -> Iterator[tuple[Where, Any, Fault]]:
        """What is wrong with a value, its part at fault and where in it that is; nothing if all is well."""
        if value is None and (self.optional or (self.empty and in_mission_file)):
            return
        if self.kind == "option":
            if not isinstance(value, str) or value not in self.options:
                yield (), value, Fault("literal_error", {"expected": _any_of(self.options)})
        elif self.kind == "truth":
            if not isinstance(value, bool):
                yield (), value, Fault("bool_type", {})
        elif self.kind == "text":
            if not isinstance(value, str):
                yield (), value, Fault("string_type", {})
        elif self.kind in ("pair", "list"):
            yield from self._list_faults(value, in_mission_file)
        elif self.kind != "block" and (fault := self._number_fault(value, in_mission_file)):
            yield (), value, fault

    def _list_faults(self, value: Any, in_mission_file: bool) -> Iterator[tuple[Where, Any, Fault]]:
        if self.word is not None and (value == self.word or value == ()):
            return
        if not isinstance(value, list | tuple):
            yield (), value, Fault("tuple_type" if self.kind == "pair" else "list_type", {})
        elif self.kind == "pair" and len(value) > 2:
            yield (), list(value), Fault("too_long", {"field_type": "Tuple", "max_length": 2})
        elif self.kind == "pair" and len(value) < 2:
            message = f"{list(value)} is too short; 2 numbers are needed"
            yield (), list(value), Fault("fault", {"message": message})
        elif not value:
            yield (), [], Fault("too_short", {})
        else:
            for k, number in enumerate(value):
                if fault := self._number_fault(number, in_mission_file):
                    yield (k,), number, fault

    def _number_fault(self, value: Any, in_mission_file: bool) -> Fault | None:
        whole = self.kind == "whole" or self.whole
        is_number: bool = isinstance(value, Integral if whole else Real) and not isinstance(value, bool)
        if not is_number:
            return Fault("int_type" if whole else "float_type", {})
        if not -math.inf < value < math.inf:
            return Fault("finite_number", {})
        for name, bound in self.bounds(in_mission_file).items():
            ok = {"ge": value >= bound, "gt": value > bound, "le": value <= bound, "lt": value < bound}[name]
            if not ok:
                kind = {"ge": "greater_than_equal", "gt": "greater_than", "le": "less_than_equal", "lt": "less_than"}
                return Fault(kind[name], {name: bound})
        return None


def _any_of(options: tuple[str, ...]) -> str:
    return ", ".join(options[:-1]) + f" or {options[-1]}" if len(options) > 1 else options[0]


def setting(default: Any, meaning: str = "", **takes: Any) -> Any:
    """A field of a settings dataclass: its default, what it means, and what it takes, as ``Setting`` has it."""
    metadata = {"meaning": meaning, **takes}
    if isinstance(default, type):
        return field(default_factory=default, metadata=metadata)
    return field(default=default, metadata=metadata)


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Base of a block of settings: a frozen dataclass with ``setting`` for each field.

    ``place``: where the block stands in a mission file. Raises MissionError for a value that a field does not take, and
    for what ``contradictions`` finds.
    """

    place: ClassVar[str]

    def __post_init__(self) -> None:
        values: dict[str, Any] = {}
        for item in settings_of(type(self)):
            value = self.value_of(item.name)
            for where, part, fault in item.faults(value):
                message = refusal(fault.kind, part, fault.given, fault.given.get("message", ""))
                raise MissionError(f"{self.place}.{path_of((item.name, *where))}: {message}")
            if item.kind in ("pair", "list") and value is not None:
                value = () if item.word is not None and value == item.word else value
                value = tuple(int(number) if item.whole else float(number) for number in value)
                object.__setattr__(self, item.name, value)
            values[item.name] = value
        for where, message in self.contradictions(values):
            raise MissionError(f"{self.place}.{path_of(where)}: {message}")

    @classmethod
    def contradictions(cls, values: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """Values that each are allowed but not together: the place within the block, and what is wrong.

        values: those that are given, each in its bounds; what is not given has its default.
        """
        yield from ()

    @classmethod
    def unused(cls, values: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """Values that a mission file gives although others make them useless; likewise."""
        yield from ()

    @classmethod
    def refused(cls, data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """What such settings cannot use of a mission as a file has it, faults and all: the place, what is wrong."""
        yield from ()

    @classmethod
    def method_blocks(cls) -> Mapping[str, type[Settings]]:
        """The settings that methods have of their own, by the methods' names, which their blocks in files have too."""
        return {}

    def value_of(self, name: str) -> Any:
        """A value by its name in files."""
        return getattr(self, name)


_DECLARED: dict[type[Settings], tuple[Setting, ...]] = {}  # types of dataclasses are no keys of a cache to mypy


def settings_of(block: type[Settings]) -> tuple[Setting, ...]:
    """The settings of a block, in their order."""
    if block not in _DECLARED:
        _DECLARED[block] = _settings_of(block)
    return _DECLARED[block]


def _settings_of(block: type[Settings]) -> tuple[Setting, ...]:
    """The fields that are declared by ``setting``, then the blocks of methods."""
    hints = get_type_hints(block)
    blocks = [
        Setting(name=name, kind="block", block=of_method, default=None, meaning="", optional=False, newer=True)
        for name, of_method in block.method_blocks().items()
    ]
    own = (_declared(each, hints[each.name]) for each in dataclasses.fields(block) if each.metadata)
    return *own, *blocks


def _declared(declared: dataclasses.Field[Any], hint: Any) -> Setting:
    optional = get_origin(hint) in (Union, types.UnionType) and type(None) in get_args(hint)
    if optional:
        (hint,) = (part for part in get_args(hint) if part is not type(None))
    described: dict[str, Any] = {"name": declared.name, "optional": optional, **declared.metadata}
    described["default"] = declared.default
    if isinstance(hint, type) and issubclass(hint, Settings):
        return Setting(kind="block", block=hint, **{**described, "default": None})
    if get_origin(hint) is Literal:
        return Setting(kind="option", options=get_args(hint), **described)
    if get_origin(hint) is tuple:
        return Setting(kind="list" if Ellipsis in get_args(hint) else "pair", whole=int in get_args(hint), **described)
    kinds: dict[Any, Literal["truth", "whole", "number", "text"]] = {
        bool: "truth",
        int: "whole",
        float: "number",
        str: "text",
    }
    return Setting(kind=kinds[hint], **described)


@dataclass(frozen=True, kw_only=True)
class Bouncing:
    """How robots with a bump sensor and a clock move, which the check judges their plans by.

    They drive straight and turn where something is in the way, each by its bouncing angle. ``BounceSettings`` of the
    planner bounce defines every field; ``covers``: all cells are to be entered once. cell_m 0: there are no cells.
    """

    covers: bool
    cell_m: float
    headings: int
    bouncing_angles_deg: tuple[float, ...]
    corners: Corners
    contact: Contact
    contact_free: ContactFree
    clock_drift: float
    clock_signal_s: float | None
    clock_margin_s: float
    cell_origin: tuple[float, float] | None

    def angles_of(self, robots: int) -> tuple[float, ...]:
        """The bouncing angle in degrees of each of so many robots: one for all of them, or one for each."""
        return self.bouncing_angles_deg * (robots if len(self.bouncing_angles_deg) == 1 else 1)

    def first_corner_m(self, bounds_m: tuple[float, float, float, float]) -> tuple[float, float]:
        """The lower left corner of the first cell: that of the area's bounds (x0, y0, x1, y1).

        With ``cell_origin``, a corner of a cell, it is up to a cell below and to the left of the bounds.
        """
        x0, y0, _, _ = bounds_m
        if self.cell_origin is None:
            return x0, y0
        left, below = (math.ceil((self.cell_origin[k] - low) / self.cell_m - 1e-9) for k, low in enumerate((x0, y0)))
        return self.cell_origin[0] - left * self.cell_m, self.cell_origin[1] - below * self.cell_m


class Planned(Protocol):
    """A mission, as its settings see it."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def planning(self) -> PlannerSettings:
        """The settings of its planner."""


@dataclass(frozen=True, kw_only=True)
class PlannerSettings(Settings):
    """Base of every planner's settings: what files, the check and drawings must know of its missions.

    ``planner``: its name. ``makes_runs``: robots move step by step in a run that can be stopped, kept and gone on with.
    ``heeds_moving_obstacles``: missions may have some. ``heeds_entrances``: fleets may have some.
    ``heeds_importance``: ground and zones may have one. ``heeds_motion``: robots may have limits of motion.
    ``robots_come_and_go``: robots may join and leave.
    ``altitudes_m``: robots move in space, each in a band of altitudes. ``bouncing``: robots move as they do that
    bounce. Defaults say that nothing of that is so.
    """

    planner: ClassVar[str]
    makes_runs: ClassVar[bool] = False
    heeds_moving_obstacles: ClassVar[bool] = False
    heeds_entrances: ClassVar[bool] = False
    heeds_importance: ClassVar[bool] = False
    heeds_motion: ClassVar[bool] = False
    robots_come_and_go: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        cls.place = cls.planner

    @classmethod
    def of(cls, mission: Planned) -> Self:
        """The settings of a mission of this planner; TypeError for a mission of another one."""
        settings = mission.planning
        if not isinstance(settings, cls):
            raise TypeError(f"mission {mission.name} is planned by {settings.planner}, not by {cls.planner}")
        return settings

    @classmethod
    def written(cls, values: Mapping[str, Any], typed_cell_m: float | None) -> Self:
        """The settings that a file gives; typed_cell_m: side of a cell of the area's text map, if any."""
        return cls(**values)

    def with_method(self, method: str) -> Self:
        """The same settings for another method of a planner that has several."""
        return dataclasses.replace(self, **{"method": method})

    @property
    def asks_periods(self) -> bool:
        """Whether the mission must ask for some ground to be seen again and again."""
        return True

    @property
    def effort(self) -> str | None:
        """How much work planning may be, by name, if that can be chosen."""
        return None

    @property
    def method(self) -> str | None:
        """By which of the planner's methods, if it has several."""
        return None

    @property
    def most_steps(self) -> int | None:
        """After how many steps a run ends at the latest; None: it does not step."""
        return None

    @property
    def altitudes_m(self) -> tuple[float, ...] | None:
        """In which bands of altitudes robots move, if not in the plane: the lowest and the highest of each, rising."""
        return None

    @property
    def bouncing(self) -> Bouncing | None:
        """By which rules robots bounce, if they do."""
        return None
