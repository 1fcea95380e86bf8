"""Settings of the planner swarm, and what it refuses of a mission."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from rota.model.planner_settings import DURATION, LENGTH, LENGTH_OR_ZERO, PlannerSettings, setting
from rota.model.refusals import (
    Where,
    every_change_of_presence,
    every_stated,
    fleet_blocks,
    inner,
    robot_count,
    show_value,
)

Controller = Literal["settle", "reciprocal", "voronoi", "virtual_force"]
Device = Literal["cpu", "cuda"]
VelocityChoice = Literal["centroid", "sampled"]
SetBoundary = Literal["tangent", "circle"]

MOST_DELAY = 20  # steps; robots with older news of each other could only stand
MOST_SAMPLES, MOST_STEPS, MOST_NEIGHBOURS = 1e6, 1e8, 1e5  # more would take a year
PLANE_ONLY = {"velocity": "centroid", "boundary": "tangent", "delay_steps": 0, "messages_lost": 0.0, "device": "cpu"}
HEEDING_IMPORTANCE = ("settle", "voronoi")
IN_SPACE = ("settle", "reciprocal")
OF_RECIPROCAL = ("velocity", "samples", "boundary", "horizon_s", "neighbours", "neighbour_range_m", "alpha")
FOR_CHARGING = {"altitudes_m": None, "delay_steps": 0, "messages_lost": 0.0, "device": "cpu", "filter": True}
NEEDED = {"samples": ("velocity", "sampled"), "horizon_s": ("boundary", "circle")}


@dataclass(frozen=True, kw_only=True)
class SwarmSettings(PlannerSettings):
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

    ``altitudes_m``: robots move in three dimensions, each in a band between two altitudes over the ground, which the
    middle of its body never leaves: the lowest and the highest altitude of each band, from below. Robots are dealt out
    to the bands in turn. For "settle", and "reciprocal" by the exact centroid, with robots that know all at once;
    ``filter`` then keeps balls apart. Robots whose footprint grows with height climb as far as it does. None: they move
    in the plane.
    """

    planner: ClassVar[str] = "swarm"
    makes_runs: ClassVar[bool] = True
    heeds_moving_obstacles: ClassVar[bool] = True
    heeds_importance: ClassVar[bool] = True
    robots_come_and_go: ClassVar[bool] = True
    heeds_batteries: ClassVar[bool] = True
    controller: Controller = setting("settle", "reciprocal is the paper's own")
    velocity: VelocityChoice = setting("centroid", "of the set: exact, or the mean of random samples")
    samples: int = setting(1000, least=1, written=(None, MOST_SAMPLES))
    boundary: SetBoundary = setting("tangent", "of the set: the circle at horizon_s, or its tangent")
    horizon_s: float = setting(1.0, above=0, written=DURATION)
    neighbours: int = setting(4, "the nearest that count", least=0, written=(None, MOST_NEIGHBOURS))
    neighbour_range_m: float | None = setting(
        None, "null: 2.04 times the largest sensor radius", above=0, written=LENGTH
    )
    wall_range_m: float | None = setting(None, "null: the robot's sensor radius", above=0, written=LENGTH)
    alpha: float = setting(1.0, "how much to make way for moving obstacles (Eq. 15)", least=1)
    filter: bool = setting(True, "no step may make bodies touch")
    time_step_s: float = setting(0.25, above=0, written=DURATION)
    stop_m: float = setting(1e-5, "stop when no robot moves farther in a step", above=0, written=LENGTH_OR_ZERO)
    most_steps: int = setting(4000, least=1, written=(None, MOST_STEPS))
    thinning_m: float = setting(0.05, "by which trajectories may be simplified", least=0, written=LENGTH_OR_ZERO)
    delay_steps: int = setting(0, "age of what robots hear", least=0, most=MOST_DELAY, newer=True)
    messages_lost: float = setting(0.0, "share of messages that never arrive", least=0, below=1, newer=True)
    device: Device = setting("cpu", "cuda: decisions on an NVIDIA GPU, with the package numba-cuda", newer=True)
    altitudes_m: tuple[float, ...] | None = setting(
        None,
        "of settle and reciprocal: robots move in space, in bands: the lowest and the highest altitude of each",
        above=0,
        written=LENGTH,
        newer=True,
    )

    @property
    def asks_periods(self) -> bool:
        """Whether the mission must ask for some ground to be seen again and again; a swarm may just spread."""
        return False

    @classmethod
    def contradictions(cls, values: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """Altitudes that fall, and what is for the plane only."""
        heights = values.get("altitudes_m")
        if heights is None:
            return
        if len(heights) % 2 or list(heights) != sorted(heights):
            message = (
                f"{list(heights)} is not allowed; give the lowest and the highest altitude of each band, from below,"
                " metres above 0"
            )
            yield ("altitudes_m",), message
        controller = values.get("controller", "settle")
        if controller not in IN_SPACE:
            message = f"{controller} is not allowed; robots with altitudes_m are moved by {' or '.join(IN_SPACE)} only"
            yield ("controller",), message
        for name, only in PLANE_ONLY.items():
            if values.get(name, only) != only:
                yield (name,), f"{values[name]} is not allowed; with altitudes_m only {only}"

    @classmethod
    def useless_values(cls, values: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """Settings that another controller, or another choice of it, would use."""
        for name in (name for name in values if values[name] is not None):
            if name in OF_RECIPROCAL and values.get("controller", "settle") != "reciprocal":
                yield (name,), "only the controller reciprocal uses it: remove it, or choose that controller"
            elif name in NEEDED and values.get(NEEDED[name][0]) != NEEDED[name][1]:
                yield (name,), f"is for {NEEDED[name][0]}: {NEEDED[name][1]} only: remove it"

    @classmethod
    def refusals(cls, data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
        """As few robots as possible, time for turns, and in space squares, periods and what changes with time."""
        if robot_count(data) is None and inner(data, "fleet", "robots") in (None, "fewest"):
            yield (
                ("fleet", "robots"),
                "fewest is not allowed: a swarm needs a number of robots, or a list of them",
            )
        flying = inner(data, "swarm", "altitudes_m") is not None
        for where, block in fleet_blocks(data):
            if flying and inner(block, "sensor", "shape") == "square":
                message = "square is not allowed: a swarm with altitudes_m has discs; give disc"
                yield (*where, "sensor", "shape"), message
            if inner(block, "turn_rate_rad_s") is not None:
                yield (*where, "turn_rate_rad_s"), "robots of a swarm turn at once: remove it"
            if inner(block, "turn_radius_m"):
                yield (*where, "turn_radius_m"), "robots of a swarm turn at once: remove it"
        controller = inner(data, "swarm", "controller") or "settle"
        if controller not in HEEDING_IMPORTANCE:
            heeding = " and ".join(HEEDING_IMPORTANCE)
            message = f"the controller {controller} heeds none; {heeding} do: remove it, or choose one of them"
            yield from every_stated(data, "importance", message)
        if data.get("chargers"):
            yield from _charging_refusals(data)
        if not flying:
            return
        if data.get("moving_obstacles"):
            yield ("moving_obstacles",), "a swarm with altitudes_m has no use for moving_obstacles: remove them"
        yield from every_change_of_presence(data, "robots with altitudes_m neither join nor leave: remove it")
        yield from every_stated(
            data,
            "period_s",
            "a swarm with altitudes_m is asked no periods, since footprints grow with height: remove it",
        )


def _charging_refusals(data: Mapping[str, Any]) -> Iterator[tuple[Where, str]]:
    """What a swarm whose robots charge cannot have: its rounds are planned in the plane, with all that robots know."""
    for name, only in FOR_CHARGING.items():
        value = inner(data, "swarm", name)
        if value is not None and value != only:
            told = "leave it out" if only is None else f"only {str(only).lower()}"
            yield ("swarm", name), f"{show_value(value)} is not allowed for robots that charge; {told}"
    if data.get("moving_obstacles"):
        yield ("moving_obstacles",), "robots of a swarm that charge do not heed them: remove them, or the chargers"
    yield from every_change_of_presence(data, "robots of a swarm that charges neither join nor leave: remove it")
    for where, block in fleet_blocks(data):
        if inner(block, "standing_endurance_s") == 0:
            yield (*where, "standing_endurance_s"), "0 is not allowed: a swarm stands where it has spread to"
