"""Settings of the planner bounce, and what it refuses of a mission."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Self

from rota.errors import MissionError
from rota.model.limits import LARGEST_M
from rota.model.planner_settings import LENGTH, Bouncing, Contact, ContactFree, Corners, PlannerSettings, setting
from rota.model.refusals import Where, every_stated, fleet_blocks, inner, listed_robots, robot_count, show_value

BounceTask = Literal["monitor", "cover"]
BounceMethod = Literal["improved", "as_printed"]
BounceCells = Literal["grid", "none"]
Purpose = Literal["periods", "worst_gap", "basin", "robust"]
HEADINGS = (4, 8, 12, 16, 20, 24, 32)

OF_TASK = {"purpose": "monitor", "contact_free": "monitor", "most_steps": "cover"}
GRID_ONLY = {
    "task": "monitor",
    "method": "improved",
    "headings": 8,
    "start_headings_deg": None,
    "corners": "blocked",
    "contact": "swept",
    "contact_free": "cycle",
    "most_steps": 100_000,
}


@dataclass(frozen=True, kw_only=True)
class BounceSettings(PlannerSettings):
    """Settings of the ``bounce`` planner (Alam & Bobadilla 2020): robots with a bump sensor and a clock on a grid.

    Cells are ``cell_m`` wide, the first one's corner at the lower left of the area's bounds, or one has ``cell_origin``
    (x, y) for a corner; a cell is free when a body can stand at its centre. Of ``headings`` (a multiple of 4) each has
    a move to a cell near by. 4 or 8 are equally spaced; of more the moves are a little off, so that no turn has quite
    the same angle, and (2, 1) and longer ones pass over cells that do not count as entered. What is blocked stays, and
    turns counterclockwise by its bouncing angle: ``bouncing_angles_deg`` has one for all robots or one for each,
    multiples of the heading step; "any", in Python (), tries all and takes the best. ``start_headings_deg``: likewise;
    None: the planner chooses.

    ``task``: "monitor" the zones by cycles without contact (Algorithm 2), or "cover" the area once (Algorithm 1).
    ``method``: "improved" takes products of single cycles and searches among jumps; "as_printed" is the paper's own.
    ``corners``: whether a diagonal move is "blocked" by an obstacle in a cell beside it, or may "pass". ``contact``
    between robots: on the published "grid" (same target cell, or moves with equal midpoints), or by "swept" distance
    besides, as bodies need that are wider than the grid allows. ``contact_free``: the "cycle" only, or the whole
    "trajectory" from the start. ``purpose``, of plans that monitor: zones' "periods" met, the shortest "worst_gap"
    in its share of a period, the largest "basin" of attraction, or "robust": most of the visits kept, and bodies apart
    for longest, when turns are off by ``turning_error_deg``. ``most_steps``: at most as many to cover the area.

    ``cells`` "none": no grid; robots that monitor follow attracting limit cycles of straight lines and exact contacts,
    from starts that the planner chooses; ``cell_m`` is 0 then, and so is every setting that only a grid has at its
    default. ``turning_error_deg``: each turn is off by up to so much, uniformly; the plan stays, and what becomes of it
    is simulated and told (of 1 degree where none is stated). ``clock_drift``: the share by which each robot's clock may
    run fast or slow. A common signal sets all clocks every ``clock_signal_s``, None: at the start only; with both,
    plans that monitor keep bodies apart however far clocks drift from each other in between, by up to 2 * clock_drift *
    clock_signal_s.

    All robots keep in step: a step lasts as long as the move, or turn, of the robot that needs longest for it.
    """

    planner: ClassVar[str] = "bounce"
    cell_m: float = setting(
        0.0, "side of a cell; null: that of the area's text map", least=0, most=LARGEST_M, written=LENGTH, empty=True
    )
    task: BounceTask = setting("monitor", "the zones for ever, or cover the area once")
    method: BounceMethod = setting("improved", "as_printed is the paper's own")
    headings: int = setting(8, f"one of {', '.join(map(str, HEADINGS))}; beyond 8 angles vary a little")
    bouncing_angles_deg: tuple[float, ...] = setting(
        (135.0,),
        "counterclockwise, one for all robots or one for each; multiples of 360 / headings; any: all are tried",
        word="any",
    )
    start_headings_deg: tuple[float, ...] | None = setting(
        None, "counterclockwise from x, one for all robots or one for each; null: as the planner likes"
    )
    corners: Corners = setting("blocked", "a diagonal move beside an obstacle's corner: blocked, or pass")
    contact: Contact = setting("swept", "swept distance of bodies, or the published definition on the grid")
    contact_free: ContactFree = setting("cycle", "of robots that monitor: the cycle, or all the trajectory")
    purpose: Purpose = setting("periods", "of robots that monitor: what the plan is best for")
    most_steps: int = setting(100_000, "to cover the area", least=1, most=10_000_000)
    cells: BounceCells = setting("grid", "none: straight lines and exact contacts, without cell_m", newer=True)
    turning_error_deg: float = setting(
        0.0, "each turn is off by up to so much; simulated and told", least=0, most=180, newer=True
    )
    clock_drift: float = setting(
        0.0, "share by which each robot's clock may run fast or slow", least=0, most=0.1, newer=True
    )
    clock_signal_s: float | None = setting(
        None, "a common signal sets all clocks so often; null: once", above=0, newer=True
    )
    cell_origin: tuple[float, float] | None = setting(
        None, "a corner [x, y] of a cell in metres; null: the lower left one of the area's bounds", newer=True
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.cells == "grid" and self.cell_m == 0:
            raise MissionError(f"bounce.cell_m: {CELL_MISSING}")

    @property
    def clock_margin_s(self) -> float:
        """How far two robots' clocks may drift apart before the next signal; 0 where no signal or no drift is given."""
        return 2 * self.clock_drift * (self.clock_signal_s or 0.0)

    @property
    def asks_periods(self) -> bool:
        """Whether the mission must ask for some ground to be seen again and again."""
        return self.task == "monitor"

    @property
    def bouncing(self) -> Bouncing:
        """By which rules robots bounce."""
        return Bouncing(
            covers=self.task == "cover",
            cell_m=self.cell_m,
            headings=self.headings,
            bouncing_angles_deg=self.bouncing_angles_deg,
            corners=self.corners,
            contact=self.contact,
            contact_free=self.contact_free,
            clock_drift=self.clock_drift,
            clock_signal_s=self.clock_signal_s,
            clock_margin_s=self.clock_margin_s,
            cell_origin=self.cell_origin,
        )

    @classmethod
    def from_file(cls, values: Mapping[str, Any], typed_cell_m: float | None) -> Self:
        """The settings that a mission file gives; without a side of a cell, that of the area's text map."""
        cell_m = values.get("cell_m") or (typed_cell_m if values.get("cells") != "none" else None) or 0.0
        return cls(**{**values, "cell_m": cell_m})

    @classmethod
    def contradictions(cls, values: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """A number of headings that the grid has no moves for, angles between two headings, what needs a grid."""
        signal_s = values.get("clock_signal_s")
        if signal_s is not None and values.get("task", "monitor") == "cover":
            allowed = "robots that cover turn at each other by plan, which no margin can keep apart"
            yield ("clock_signal_s",), f"{show_value(signal_s)} is not allowed; {allowed}"
        if values.get("cells", "grid") == "none":
            yield from _of_a_grid_only(values)
        elif values.get("purpose") == "robust" and values.get("method", "improved") == "as_printed":
            yield (
                ("purpose",),
                "robust is not allowed; Algorithm 2 as printed knows no errors: periods, worst_gap or basin",
            )
        headings = values.get("headings", 8)
        if headings not in HEADINGS:
            message = f"{headings} is not allowed; one of {', '.join(map(str, HEADINGS))} is needed"
            yield ("headings",), message
        else:
            yield from _angle_faults(headings, values)

    @classmethod
    def useless_values(cls, values: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """Settings of the other task."""
        for name, only in OF_TASK.items():
            if values.get(name) is not None and values.get("task", "monitor") != only:
                yield (name,), f"is for task: {only} only: remove it"

    @classmethod
    def refusals(cls, data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """Starts in a box, angles for other robots, and demands that the robots' task does not know."""
        if inner(data, "fleet", "start", "box") is not None:
            yield ("fleet", "start", "box"), "bouncing robots start at points: give points, or remove it"
        for where, block in fleet_blocks(data):
            if inner(block, "turn_radius_m"):
                yield (*where, "turn_radius_m"), "bouncing robots turn on the spot: remove it"
        if inner(data, "bounce", "cells") == "none":
            yield from _starts_without_cells(data)
        elif inner(data, "bounce", "cell_m") is None and inner(data, "area", "text") is None:
            yield ("bounce", "cell_m"), CELL_MISSING
        task, count = inner(data, "bounce", "task") or "monitor", robot_count(data)
        if task == "cover" and count is None:
            yield ("fleet", "robots"), "a number of robots, or a list of them, is needed to cover an area"
        if count is None and inner(data, "fleet", "start", "points") is not None:
            message = "bouncing robots as few as possible begin where the planner likes: remove it"
            yield ("fleet", "start"), message
        for name in ("bouncing_angles_deg", "start_headings_deg"):
            angles = inner(data, "bounce", name)
            if isinstance(angles, list | tuple) and angles and len(angles) not in (1, count):
                each = f" or one for each of {count}" if count is not None else ""
                yield ("bounce", name), f"{len(angles)} angles are not allowed; one for all robots{each} is needed"
        if task == "monitor":
            yield from _demands_that_nobody_meets(data)
        elif task == "cover":
            message = "covering happens once: remove the period, or write bounce.task: monitor"
            yield from every_stated(data, "period_s", message)


CELL_MISSING = "is missing; give the side of a cell in metres"


def _of_a_grid_only(values: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Settings of cells where there are none."""
    if values.get("cell_m"):
        message = f"{show_value(values['cell_m'])} is not allowed; with cells: none there are no cells; leave it out"
        yield ("cell_m",), message
    for name, only in GRID_ONLY.items():
        if values.get(name, only) != only:
            allowed = "with cells: none " + ("leave it out" if only is None else f"only {only}")
            value = values[name]
            yield (name,), f"{list(value) if isinstance(value, tuple) else value} is not allowed; {allowed}"
    if values.get("purpose", "periods") == "basin":
        yield ("purpose",), "basin is not allowed; with cells: none only periods, worst_gap or robust"


def _angle_faults(headings: int, values: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Angles that are no multiples of the heading step; without cells any bouncing angle will do."""
    bouncing, starts = values.get("bouncing_angles_deg", (135.0,)), values.get("start_headings_deg")
    given = "bouncing_angles_deg" in values
    if values.get("cells", "grid") == "none":
        for k, angle in enumerate(bouncing):
            if not 0 < angle < 360:
                message = f"{angle:.9g} is not allowed; it must lie between 0 and 360 degrees"
                yield ("bouncing_angles_deg", k), message
        return
    step_deg = 360 / headings
    multiple = f"must be a multiple of the heading step, 360 / {headings} = {step_deg:.9g} degrees"
    for k, angle in enumerate(bouncing):
        if not (0 < angle < 360 and _is_multiple(angle, step_deg)):
            message = f"{angle:.9g} is not allowed; it {multiple}, from that to below 360"
            yield ("bouncing_angles_deg", k) if given else ("bouncing_angles_deg",), message
    for k, angle in enumerate(starts or ()):
        if not _is_multiple(angle, step_deg):
            yield ("start_headings_deg", k), f"{angle:.9g} is not allowed; it {multiple}"


def _is_multiple(angle: float, step: float) -> bool:
    """Whether an angle is a multiple of a step, to within a millionth of the step."""
    return abs(angle / step - round(angle / step)) < 1e-6


def _starts_without_cells(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Every start that is given, which robots without cells do not heed."""
    message = "with bounce.cells: none robots begin where the planner likes: remove it"
    if inner(data, "fleet", "start") is not None:
        yield ("fleet", "start"), message
    for k, robot in enumerate(listed_robots(data)):
        if inner(robot, "start") is not None:
            yield ("fleet", "robots", k, "start"), message


def _demands_that_nobody_meets(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """Demands that robots which monitor cannot meet."""
    if data.get("period_s") is not None:
        yield ("period_s",), "bouncing robots monitor zones, not the area: remove it"
    zones = data.get("zones")
    for k, zone in enumerate(zones if isinstance(zones, list) else []):
        has_demand = inner(zone, "period_s") is not None or inner(zone, "geojson") is not None
        if has_demand and (inner(zone, "demand") or "every_point") == "every_point":
            message = "every_point is not allowed: bouncing robots visit zones; write demand: visit"
            yield ("zones", k, "demand"), message
