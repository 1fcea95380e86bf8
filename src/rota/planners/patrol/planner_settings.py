"""Settings of the planner patrol, and what it refuses of a mission."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

from rota.errors import MissionError
from rota.model.motion_limits import MOTION_FIELDS
from rota.model.planner_settings import LENGTH_OR_ZERO, PlannerSettings, Settings, setting
from rota.model.refusals import (
    Where,
    every_choice_of_robots,
    every_motion,
    fleet_blocks,
    inner,
    robot_count,
    show_value,
)
from rota.planners.patrol.method_table import METHOD_SETTINGS, METHODS
from rota.planners.patrol.tolerances import BESIDE_M
from rota.vehicles.presets import ON_MISSIONS, VEHICLES

Effort = Literal["quick", "normal", "high"]
if TYPE_CHECKING:
    Method = str
else:
    Method = Literal[tuple(METHODS)]  # the table is the one place that names them
Preference = Literal["shortest", "fewest_turns"]

# a plan file of 100,000 robots is some 300 MB, and its check takes minutes; a patrol plans robot by robot
MOST_PATROLLING = 10_000


@dataclass(frozen=True, kw_only=True)
class PatrolSettings(PlannerSettings):
    """Settings of the ``patrol`` planner; ``effort`` bounds the work by iterations, never by the clock.

    ``method``: "tours", or one of the traditional methods of Sun et al. 2019, Figure 3, to compare with: "parallel" and
    "sequential" scanning, area "decomposition"; or "sun2019", the paper's stages, by default each done by an algorithm
    of ours. ``method_settings``: those that the method has of its own (``method_table``), in files a block with its
    name; None: its defaults, if it has any. A reserve against wind and poor localisation: the plan keeps periods
    shorter by the share ``period_margin``, and with sensors whose reach in every direction is shorter by
    ``range_margin_m``. ``prefer``: what the slack of the periods is spent on where the robots are "fewest" and the
    method is "tours".
    """

    planner: ClassVar[str] = "patrol"
    heeds_importance: ClassVar[bool] = True
    heeds_entrances: ClassVar[bool] = True
    heeds_lanes: ClassVar[bool] = True
    heeds_batteries: ClassVar[bool] = True
    heeds_kinds: ClassVar[bool] = True
    heeds_motion: ClassVar[bool] = True
    effort: Effort = setting("normal", "how much work planning may be")
    method: Method = setting("tours", "all but tours are to compare with: traditional methods, and Sun 2019's stages")
    period_margin: float = setting(
        0.0, "reserve: plan with periods shorter by this share", least=0, below=1, newer=True
    )
    range_margin_m: float = setting(
        0.0, "reserve: plan with sensors that reach so much less far", least=0, written=LENGTH_OR_ZERO, newer=True
    )
    prefer: Preference = setting(
        "shortest", "of plans with as few robots: the shortest loops, or those with the fewest_turns", newer=True
    )
    method_settings: Settings | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        block, given = self.method_blocks().get(self.method), self.method_settings
        if block is not None and given is None:
            object.__setattr__(self, "method_settings", block())
        elif given is not None and (block is None or not isinstance(given, block)):
            raise MissionError(f"patrol.method_settings: {type(given).__name__} is not of method {self.method}")

    @classmethod
    def method_blocks(cls) -> Mapping[str, type[Settings]]:
        """Loaded by the names in the table of methods."""
        places = {method: where.split(":") for method, where in METHOD_SETTINGS.items()}
        return {method: getattr(import_module(module), block) for method, (module, block) in places.items()}

    @classmethod
    def from_file(cls, values: Mapping[str, Any], typed_cell_m: float | None) -> Self:
        """The settings that a file gives, without blocks of other methods, which plan files have."""
        blocks, method = cls.method_blocks(), values.get("method", cls.method)
        own = {name: value for name, value in values.items() if name not in blocks}
        return cls(**own, method_settings=values.get(method) if method in blocks else None)

    def value_of(self, name: str) -> Any:
        """A value by its name in files: plan files have the block of every method, as they had from the beginning."""
        blocks = self.method_blocks()
        if name not in blocks:
            return getattr(self, name)
        return self.method_settings if name == self.method else blocks[name]()

    def with_method(self, method: str) -> Self:
        """The same settings for another method, without what is of this method alone."""
        return self if method == self.method else replace(self, method=method, method_settings=None)

    @classmethod
    def useless_values(cls, values: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """Settings of another method."""
        method = values.get("method", "tours")
        for other in METHOD_SETTINGS:
            if values.get(other) is not None and method != other:
                yield (other,), f"settings of another method; method is {method}: remove this block"

    @classmethod
    def refusals(cls, data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """Too many robots, and what sensors must have."""
        count = robot_count(data)
        if count is not None and count > MOST_PATROLLING:
            message = f"{count} is not allowed; the patrol planner plans for at most {MOST_PATROLLING}"
            yield ("fleet", "robots"), message
        for method, block in cls.method_blocks().items():
            if inner(data, "patrol", "method") == method:
                yield from block.refusals(data)
        if not isinstance(data.get("importance"), int | float | None):
            message = "patrol compares whole zones by their importance: give a number, or importance for zones"
            yield ("importance",), message
        yield from lane_refusals(data)
        yield from charging_refusals(data)
        yield from _kinds_on_lanes(data)
        yield from _ways_to_turn(data)
        yield from _starts_of_autopilots(data)
        yield from _too_much_reserve(data)


def _starts_of_autopilots(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Starts of vehicles whose firmware is modelled: they fly to a corner of their loop by themselves."""
    for where, block in fleet_blocks(data):
        name = inner(block, "vehicle") or inner(data, "fleet", "vehicle")
        if isinstance(name, str) and name in VEHICLES and VEHICLES[name].formats and inner(block, "start") is not None:
            yield (
                (*where, "start"),
                f"patrol begins loops of {name} at their corners, where autopilots go first: remove it",
            )


def _kinds_on_lanes(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Robots of different kinds, and zones that name sensors, where robots keep to lanes."""
    if data.get("lanes") or inner(data, "area", "graph") is not None:
        yield from every_choice_of_robots(data, "on lanes all robots are planned for as if they were alike: remove it")


def _ways_to_turn(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """A fleet of which some robots take time to turn on the spot and others turn on arcs."""
    blocks = fleet_blocks(data)
    if inner(data, "fleet", "kinds"):  # each is planned by itself
        return
    if all(inner(block, "turn_rate_rad_s") is None for _, block in blocks):
        return
    for where, block in blocks:
        if inner(block, "turn_radius_m"):
            message = "patrol plans for robots that all turn on the spot or all on arcs: remove it, or turn_rate_rad_s"
            yield (*where, "turn_radius_m"), message


def _too_much_reserve(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """A reserve of range that leaves a sensor nothing to see with."""
    margin_m = inner(data, "patrol", "range_margin_m")
    reaches_m = [reach for _, block in fleet_blocks(data) if (reach := _reach_m(inner(block, "sensor"))) is not None]
    if not isinstance(margin_m, int | float) or not margin_m > 0 or not reaches_m:
        return
    if margin_m > min(reaches_m) - BESIDE_M:
        message = (
            f"{show_value(margin_m)} is not allowed; it must be less than the sensor's reach, {min(reaches_m):.6g} m"
        )
        yield ("patrol", "range_margin_m"), message


def _reach_m(sensor: Any) -> float | None:
    """How far a sensor as written sees in every direction; None where it is none."""
    size = inner(sensor, "radius_m") if inner(sensor, "shape") == "disc" else inner(sensor, "side_m")
    if not isinstance(size, int | float):
        return None
    return size if inner(sensor, "shape") == "disc" else size / 2


def charging_refusals(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Copters on missions of their own, and lanes, where robots have an endurance."""
    fleet, (_, *listed) = inner(data, "fleet"), fleet_blocks(data)
    refused: dict[Where, str] = {}
    for where, block in listed or [(("fleet",), fleet)]:
        told = where if inner(block, "vehicle") is not None else ("fleet",)
        told_by = next((name for name in ("endurance_s", "battery") if inner(block, name) or inner(fleet, name)), None)
        if told_by is None:
            continue
        if (inner(block, "vehicle") or inner(fleet, "vehicle")) in ON_MISSIONS:
            refused[(*told, "vehicle")] = (
                "robots that charge are not planned for as their firmware flies missions: write arducopter-targets,"
                " whose timed targets rota fly sends"
            )
        if data.get("lanes") or inner(data, "area", "graph") is not None:
            refused["fleet", told_by] = "on lanes no charging is planned: remove it"
    yield from refused.items()


def lane_refusals(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Limits of motion and turning, starts, demands other than visits, and other methods, on lanes or in a graph."""
    is_graph = inner(data, "area", "graph") is not None
    if not (is_graph or data.get("lanes")):
        return
    driving_fields = (*MOTION_FIELDS, "turn_rate_rad_s", "turn_radius_m")
    yield from every_motion(data, driving_fields, "on lanes robots turn and change their speed at once: remove it")
    for where, block in fleet_blocks(data):
        for name in ("start", "entrances"):
            if inner(block, name) is not None:
                yield (*where, name), "on lanes robots begin where their rounds do: remove it"
    if inner(data, "patrol", "method") not in (None, "tours"):
        yield ("patrol", "method"), "on lanes only tours are planned"
    if inner(data, "patrol", "prefer") not in (None, "shortest"):
        yield ("patrol", "prefer"), "on lanes only the shortest rounds are looked for"
    if not is_graph and data.get("period_s") is not None:
        yield ("period_s",), "on lanes robots come to places: remove it, and give zones with demand: visit"
    zones = data.get("zones")
    for k, zone in enumerate(zones if isinstance(zones, list) else []):
        demand = inner(zone, "demand") or ("visit" if inner(zone, "place") is not None else "every_point")
        if inner(zone, "period_s") is not None and demand != "visit":
            yield ("zones", k, "demand"), "on lanes robots come to places: write demand: visit"
