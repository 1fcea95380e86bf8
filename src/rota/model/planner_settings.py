"""Settings of planners: blocks of fields, each declared once; and what every planner's settings tell of its missions.

Files, their JSON Schemas and the dataclass itself refuse by these declarations.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal, Protocol, Self

from rota.errors import MissionError
from rota.model.field_values import check_fields
from rota.model.fields import Field as Setting, field_of as setting, fields_of as settings_of
from rota.model.limits import DURATION, LENGTH, LENGTH_OR_ZERO
from rota.model.refusals import Where, path_of

__all__ = ["DURATION", "LENGTH", "LENGTH_OR_ZERO", "Bouncing", "PlannerSettings", "Setting", "Settings", "setting"]
__all__ += ["settings_of"]

Corners = Literal["blocked", "pass"]
Contact = Literal["swept", "grid"]
ContactFree = Literal["cycle", "trajectory"]


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Base of a block of settings: a frozen dataclass with ``setting`` for each field.

    ``place``: where the block stands in a mission file. ``elsewhere``: who brings what is not known here, told with
    what is; empty where nobody does. Raises MissionError for a value that a field does not take, and
    for what ``contradictions`` finds.
    """

    place: ClassVar[str]
    elsewhere: ClassVar[str] = ""

    def __post_init__(self) -> None:
        check_fields(self, f"{self.place}.")
        values = {item.name: self.value_of(item.name) for item in settings_of(type(self))}
        for where, message in self.contradictions(values):
            raise MissionError(f"{self.place}.{path_of(where)}: {message}")

    @classmethod
    def contradictions(cls, values: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """Values that each are allowed but not together: the place within the block, and what is wrong.

        values: those that are given, each in its bounds; what is not given has its default.
        """
        yield from ()

    @classmethod
    def useless_values(cls, values: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """Values that a mission file gives although others make them useless; likewise."""
        yield from ()

    @classmethod
    def refusals(cls, data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """What such settings cannot use of a mission as a file has it, faults and all: the place, what is wrong."""
        yield from ()

    @classmethod
    def method_blocks(cls) -> Mapping[str, type[Settings]]:
        """The settings that methods have of their own, by the methods' names, which their blocks in files have too."""
        return {}

    def value_of(self, name: str) -> Any:
        """A value by its name in files."""
        return getattr(self, name)


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
    ``heeds_lanes``: missions may have some. ``heeds_batteries``: robots may have to charge.
    ``heeds_kinds``: fleets may have kinds, and zones name the sensors that count.
    ``heeds_importance``: ground and zones may have one. ``heeds_motion``: robots may have limits of motion.
    ``robots_come_and_go``: robots may join and leave.
    ``altitudes_m``: robots move in space, each in a band of altitudes. ``bouncing``: robots move as they do that
    bounce. Defaults say that nothing of that is so.
    """

    planner: ClassVar[str]
    makes_runs: ClassVar[bool] = False
    heeds_moving_obstacles: ClassVar[bool] = False
    heeds_entrances: ClassVar[bool] = False
    heeds_lanes: ClassVar[bool] = False
    heeds_batteries: ClassVar[bool] = False
    heeds_kinds: ClassVar[bool] = False
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
    def from_file(cls, values: Mapping[str, Any], typed_cell_m: float | None) -> Self:
        """The settings that a file gives; typed_cell_m: side of a cell of the area's text map, if any."""
        return cls(**values)

    def with_method(self, method: str) -> Self:
        """The same settings for another method of a planner that has several."""
        return replace(self, **{"method": method})

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
