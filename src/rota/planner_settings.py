"""Settings of the planners, one frozen dataclass each, and the values that they take."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, ClassVar, Literal, get_args

from rota.errors import MissionError
from rota.limits import LARGEST_M

Effort = Literal["quick", "normal", "high"]
Method = Literal["tours", "parallel", "sequential", "decomposition", "sun2019"]
METHODS: tuple[Method, ...] = get_args(Method)
DeploymentMethod = Literal["best", "greedy", "exact", "ccpso2"]
FrameTour = Literal["local_search", "genetic"]
FramePartition = Literal["exact", "pso"]
SegmentRoutes = Literal["shortened", "repaired", "printed"]
Controller = Literal["settle", "reciprocal", "voronoi", "virtual_force"]
Device = Literal["cpu", "cuda"]
VelocityChoice = Literal["centroid", "sampled"]
SetBoundary = Literal["tangent", "circle"]
BounceTask = Literal["monitor", "cover"]
BounceMethod = Literal["improved", "as_printed"]
Corners = Literal["blocked", "pass"]
Contact = Literal["swept", "grid"]
ContactFree = Literal["cycle", "trajectory"]
BounceCells = Literal["grid", "none"]
Purpose = Literal["periods", "worst_gap", "basin"]
HEADINGS = (4, 8, 12, 16, 20, 24, 32)
MOST_BOUNCE_STEPS = 10_000_000


def require(ok: bool, where: str, value: object, allowed: str) -> None:
    """Raise MissionError that names the place, the value and what is allowed, unless all is well."""
    if not ok:
        raise MissionError(f"{where}: {value!r} is not allowed; {allowed}")


def require_positive(where: str, value: float, most: float = sys.float_info.max) -> None:
    """Raise MissionError for what is not a finite number greater than 0, and at most ``most``."""
    allowed = f" and at most {most:g}" if most < sys.float_info.max else ""
    require(0 < value <= most, where, value, "must be a finite number greater than 0" + allowed)


def require_text(where: str, name: str) -> None:
    """Raise MissionError for a name that is empty, or that no file can hold since half a character is in it."""
    require(bool(name), where, name, "must not be empty")
    halves = [letter for letter in name if 0xD800 <= ord(letter) <= 0xDFFF]
    require(not halves, where, name, "must be text; lone surrogates are half a character each")


@dataclass(frozen=True, kw_only=True)
class Sun2019:
    """How the stages of the method ``sun2019`` are done: by ours, which take fewest robots, unless others are named.

    ``deployment`` of virtual sensors: "best" of set covers and swarms, as many as the effort allows; "greedy" or
    "exact" set cover; "ccpso2", the paper's swarms. ``tour``, the frame past them: "local_search" or the paper's
    "genetic" algorithm. ``partition`` of the frame: "exact", or the paper's particle swarms, "pso". ``routes`` round
    the segments: "repaired" until all is seen, by robots as many as that takes; "shortened" besides where they are too
    long; "printed": cut to the free space and no more, which mostly leaves ground unseen.
    """

    deployment: DeploymentMethod = "best"
    tour: FrameTour = "local_search"
    partition: FramePartition = "exact"
    routes: SegmentRoutes = "shortened"

    def __post_init__(self) -> None:
        choices = {
            "deployment": DeploymentMethod,
            "tour": FrameTour,
            "partition": FramePartition,
            "routes": SegmentRoutes,
        }
        for name, known in choices.items():
            require(getattr(self, name) in get_args(known), f"patrol.sun2019.{name}", getattr(self, name),
                     ", ".join(get_args(known)))  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class PatrolSettings:
    """Settings of the ``patrol`` planner; ``effort`` bounds the work by iterations, never by the clock.

    ``method``: "tours", or one of the traditional methods of Sun et al. 2019, Figure 3, to compare with: "parallel" and
    "sequential" scanning, area "decomposition"; or "sun2019", the paper's stages, by default each done by an algorithm
    of ours; ``sun2019`` chooses the paper's. A reserve against wind and poor localisation: the plan keeps periods
    shorter by the share ``period_margin``, and with sensors whose reach in every direction is shorter by
    ``range_margin_m``.
    """

    planner: ClassVar[str] = "patrol"
    effort: Effort = "normal"
    method: Method = "tours"
    period_margin: float = 0.0
    range_margin_m: float = 0.0
    sun2019: Sun2019 = field(default_factory=Sun2019)

    def __post_init__(self) -> None:
        require(self.effort in ("quick", "normal", "high"), "patrol.effort", self.effort, "quick, normal or high")
        require(self.method in METHODS, "patrol.method", self.method, ", ".join(METHODS))
        ok = 0 <= self.period_margin < 1
        require(ok, "patrol.period_margin", self.period_margin, "must be a share, 0 or more and below 1")
        ok = math.isfinite(self.range_margin_m) and self.range_margin_m >= 0
        require(ok, "patrol.range_margin_m", self.range_margin_m, "must be a finite number, 0 or more")


MOST_DELAY = 20  # steps; robots with older news of each other could only stand


@dataclass(frozen=True, kw_only=True)
class SwarmSettings:
    """Settings of the ``swarm`` planner; defaults are those of Chen et al. 2018, Table 2, where it has any.

    ``controller``: "settle", which covers most, also from heaps in corners and through doors; "reciprocal", the paper's
    own; or what the paper compares with: range-limited "voronoi" cells, "virtual_force". Of "reciprocal": ``velocity``,
    the set's exact centroid or the mean of ``samples`` random ones (Algorithm 1); ``boundary`` of the set, the tangent
    or the circle at ``horizon_s``; the ``neighbours`` nearest count that are within ``neighbour_range_m`` (None: 2.04
    times the largest sensor radius, as in the paper); ``alpha`` of Eq. 15, how much a robot makes way for what moves
    and does not.

    ``wall_range_m``: walls farther off do not count (None: the robot's sensor radius). ``filter``: no step may make
    bodies touch, or touch a wall. Steps take ``time_step_s``, until no robot moves by more than ``stop_m`` in one
    ("settle": in two), or for ``most_steps``. Thinning moves trajectories by no more than ``thinning_m`` at any time.

    What robots know of each other: messages arrive ``delay_steps`` late, and ``messages_lost`` of them never do (at
    most 8 in a row), so that the last one that came counts.

    A robot with a square sensor spreads as if it had the disc within; the check and all measures take the square.

    ``device``: what decides, "cpu" or, with an NVIDIA GPU and the package numba-cuda, "cuda"; to within rounding.

    ``altitudes_m``: robots move in three dimensions between two altitudes over the ground, which the middles of their
    bodies never leave. For "reciprocal" by the exact centroid only, with robots that know all at once; ``filter`` then
    keeps balls apart. Robots whose footprint grows with height climb as far as it does. None: they move in the plane.
    """

    planner: ClassVar[str] = "swarm"
    controller: Controller = "settle"
    velocity: VelocityChoice = "centroid"
    samples: int = 1000
    boundary: SetBoundary = "tangent"
    horizon_s: float = 1.0
    neighbours: int = 4
    neighbour_range_m: float | None = None
    wall_range_m: float | None = None
    alpha: float = 1.0
    filter: bool = True
    time_step_s: float = 0.25
    stop_m: float = 1e-5
    most_steps: int = 4000
    thinning_m: float = 0.05
    delay_steps: int = 0
    messages_lost: float = 0.0
    device: Device = "cpu"
    altitudes_m: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        choices = {"controller": Controller, "velocity": VelocityChoice, "boundary": SetBoundary, "device": Device}
        for name, known in choices.items():
            value = getattr(self, name)
            require(value in get_args(known), f"swarm.{name}", value, ", ".join(get_args(known)))
        for name in ("horizon_s", "time_step_s", "stop_m"):
            require_positive(f"swarm.{name}", getattr(self, name))
        for name in ("neighbour_range_m", "wall_range_m"):
            if getattr(self, name) is not None:
                require_positive(f"swarm.{name}", getattr(self, name))
        require(self.samples >= 1, "swarm.samples", self.samples, "must be at least 1")
        require(self.neighbours >= 0, "swarm.neighbours", self.neighbours, "must be 0 or more")
        require(self.most_steps >= 1, "swarm.most_steps", self.most_steps, "must be at least 1")
        ok = math.isfinite(self.alpha) and self.alpha >= 1
        require(ok, "swarm.alpha", self.alpha, "must be a finite number, 1 or more")
        ok = math.isfinite(self.thinning_m) and self.thinning_m >= 0
        require(ok, "swarm.thinning_m", self.thinning_m, "must be a finite number, 0 or more")
        require(0 <= self.delay_steps <= MOST_DELAY, "swarm.delay_steps", self.delay_steps, f"0 to {MOST_DELAY}")
        ok = 0 <= self.messages_lost < 1
        require(ok, "swarm.messages_lost", self.messages_lost, "must be a share from 0 on, less than 1")
        if self.altitudes_m is not None:
            object.__setattr__(self, "altitudes_m", tuple(float(height) for height in self.altitudes_m))
            for where, value, allowed in altitude_faults(asdict(self)):
                raise MissionError(f"swarm.{where}: {value!r} is not allowed; {allowed}")


PLANE_ONLY = {"velocity": "centroid", "boundary": "tangent", "delay_steps": 0, "messages_lost": 0.0, "device": "cpu"}


def altitude_faults(settings: Mapping[str, Any]) -> Iterator[tuple[str, object, str]]:
    """What is wrong with the settings of a swarm that has altitudes_m: the field, its value and what is allowed."""
    heights = settings["altitudes_m"]
    ok = len(heights) == 2 and all(math.isfinite(height) for height in heights) and 0 < heights[0] <= heights[1]
    if not ok:
        yield "altitudes_m", list(heights), "give the lowest and the highest altitude, metres above 0"
    controller = settings.get("controller", "settle")
    if controller != "reciprocal":
        yield "controller", controller, "robots with altitudes_m are moved by reciprocal only"
    for name, only in PLANE_ONLY.items():
        if settings.get(name, only) != only:
            yield name, settings[name], f"with altitudes_m only {only}"


@dataclass(frozen=True, kw_only=True)
class BounceSettings:
    """Settings of the ``bounce`` planner (Alam & Bobadilla 2020): robots with a bump sensor and a clock on a grid.

    Cells are ``cell_m`` wide, the first one's corner at the lower left of the area's bounds, or one has ``cell_origin``
    (x, y) for a corner; a cell is free when a body can stand at its centre. Of ``headings`` (a multiple of 4) each has
    a move to a cell near by. 4 or 8 are equally spaced; of more the moves are a little off, so that no turn has quite
    the same angle, and (2, 1) and longer ones pass over cells that do not count as entered. What is blocked stays, and
    turns counterclockwise by its bouncing angle: ``bouncing_angles_deg`` has one for all robots or one for each,
    multiples of the heading step. ``start_headings_deg``: likewise; None: the planner chooses.

    ``task``: "monitor" the zones by cycles without contact (Algorithm 2), or "cover" the area once (Algorithm 1).
    ``method``: "improved" takes products of single cycles and searches among jumps; "as_printed" is the paper's own.
    ``corners``: whether a diagonal move is "blocked" by an obstacle in a cell beside it, or may "pass". ``contact``
    between robots: on the published "grid" (same target cell, or moves with equal midpoints), or by "swept" distance
    besides, as bodies need that are wider than the grid allows. ``contact_free``: the "cycle" only, or the whole
    "trajectory" from the start. ``purpose``, of plans that monitor: zones' "periods" met, the shortest "worst_gap"
    in its share of a period, or the largest "basin" of attraction. ``most_steps``: at most as many to cover the area.

    ``cells`` "none": no grid; robots that monitor follow attracting limit cycles of straight lines and exact contacts,
    from starts that the planner chooses; ``cell_m`` is 0 then, and so is every setting that only a grid has at its
    default. ``turning_error_deg``: each turn is off by up to so much, uniformly; the plan stays, and what becomes of it
    is simulated and told. ``clock_drift``: the share by which each robot's clock may run fast or slow. A common signal
    sets all clocks every ``clock_signal_s``, None: at the start only; with both, plans that monitor keep bodies apart
    however far clocks drift from each other in between, by up to 2 * clock_drift * clock_signal_s.

    All robots keep in step: a step lasts as long as the move, or turn, of the robot that needs longest for it.
    """

    planner: ClassVar[str] = "bounce"
    cell_m: float = 0.0
    task: BounceTask = "monitor"
    method: BounceMethod = "improved"
    headings: int = 8
    bouncing_angles_deg: tuple[float, ...] = (135.0,)
    start_headings_deg: tuple[float, ...] | None = None
    corners: Corners = "blocked"
    contact: Contact = "swept"
    contact_free: ContactFree = "cycle"
    purpose: Purpose = "periods"
    most_steps: int = 100_000
    cells: BounceCells = "grid"
    turning_error_deg: float = 0.0
    clock_drift: float = 0.0
    clock_signal_s: float | None = None
    cell_origin: tuple[float, float] | None = None

    @property
    def clock_margin_s(self) -> float:
        """How far two robots' clocks may drift apart before the next signal; 0 where no signal or no drift is given."""
        return 2 * self.clock_drift * (self.clock_signal_s or 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "bouncing_angles_deg", tuple(float(angle) for angle in self.bouncing_angles_deg))
        if self.start_headings_deg is not None:
            object.__setattr__(self, "start_headings_deg", tuple(float(angle) for angle in self.start_headings_deg))
        if self.cells == "grid":
            require_positive("bounce.cell_m", self.cell_m, LARGEST_M)
        if self.cell_origin is not None:
            object.__setattr__(self, "cell_origin", tuple(float(value) for value in self.cell_origin))
            ok = len(self.cell_origin) == 2 and all(math.isfinite(value) for value in self.cell_origin)
            require(ok, "bounce.cell_origin", list(self.cell_origin), "must be a point [x, y] in metres")
        choices = {
            "cells": BounceCells,
            "task": BounceTask,
            "method": BounceMethod,
            "corners": Corners,
            "contact": Contact,
            "contact_free": ContactFree,
            "purpose": Purpose,
        }
        for name, known in choices.items():
            value = getattr(self, name)
            require(value in get_args(known), f"bounce.{name}", value, ", ".join(get_args(known)))
        ok = self.headings in HEADINGS
        require(ok, "bounce.headings", self.headings, f"must be one of {', '.join(map(str, HEADINGS))}")
        require(bool(self.bouncing_angles_deg), "bounce.bouncing_angles_deg", [], "one angle at least is needed")
        angles = angle_faults(self.headings, self.bouncing_angles_deg, self.start_headings_deg, cells=self.cells)
        for where, value, allowed in angles:
            raise MissionError(f"bounce.{where}: {value:.9g} is not allowed; {allowed}")
        for where, told, allowed in physical_faults(asdict(self)):
            raise MissionError(f"bounce.{where}: {told!r} is not allowed; {allowed}")
        ok = 1 <= self.most_steps <= MOST_BOUNCE_STEPS
        require(ok, "bounce.most_steps", self.most_steps, f"must be 1 to {MOST_BOUNCE_STEPS}")


MOST_TURNING_ERROR_DEG, MOST_CLOCK_DRIFT = 180.0, 0.1
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


def physical_faults(settings: Mapping[str, Any]) -> Iterator[tuple[str, object, str]]:
    """What is wrong with errors, clocks, and settings of a grid without one: the field, its value, what is allowed."""
    error, drift, signal_s = (settings.get(name) for name in ("turning_error_deg", "clock_drift", "clock_signal_s"))
    if error is not None and not (math.isfinite(error) and 0 <= error <= MOST_TURNING_ERROR_DEG):
        yield "turning_error_deg", error, f"must lie in 0..{MOST_TURNING_ERROR_DEG:g} degrees"
    if drift is not None and not (math.isfinite(drift) and 0 <= drift <= MOST_CLOCK_DRIFT):
        yield "clock_drift", drift, f"must be a share, 0 to {MOST_CLOCK_DRIFT:g}"
    if signal_s is not None and not (math.isfinite(signal_s) and signal_s > 0):
        yield "clock_signal_s", signal_s, "must be a finite number greater than 0"
    elif signal_s is not None and settings.get("task", "monitor") == "cover":
        yield "clock_signal_s", signal_s, "robots that cover turn at each other by plan, which no margin can keep apart"
    if settings.get("cells", "grid") != "none":
        return
    if settings.get("cell_m"):
        yield "cell_m", settings["cell_m"], "with cells: none there are no cells; leave it out"
    for name, only in GRID_ONLY.items():
        if settings.get(name, only) != only:
            yield name, settings[name], "with cells: none " + ("leave it out" if only is None else f"only {only}")
    if settings.get("purpose", "periods") == "basin":
        yield "purpose", "basin", "with cells: none only periods or worst_gap"


def angle_faults(
    headings: int, bouncing_deg: Sequence[float], starts_deg: Sequence[float] | None, *, cells: str = "grid"
) -> Iterator[tuple[str, float, str]]:
    """Angles that are no multiples of the heading step: the field at fault, the value and what is allowed.

    Without cells there are no heading steps, and any angle between 0 and 360 will do.
    """
    if cells == "none":
        for k, angle in enumerate(bouncing_deg):
            if not 0 < angle < 360:
                yield f"bouncing_angles_deg[{k}]", angle, "must lie between 0 and 360 degrees"
        return
    step_deg = 360 / headings
    for k, angle in enumerate(bouncing_deg):
        if not (0 < angle < 360 and _is_multiple(angle, step_deg)):
            multiple = f"a multiple of the heading step, 360 / {headings} = {step_deg:.9g} degrees"
            allowed = f"must be {multiple}, from that to below 360"
            yield f"bouncing_angles_deg[{k}]", angle, allowed
    for k, angle in enumerate(starts_deg or ()):
        if not _is_multiple(angle, step_deg):
            allowed = f"must be a multiple of the heading step, 360 / {headings} = {step_deg:.9g} degrees"
            yield f"start_headings_deg[{k}]", angle, allowed


def _is_multiple(angle: float, step: float) -> bool:
    return math.isfinite(angle) and abs(angle / step - round(angle / step)) < 1e-6
