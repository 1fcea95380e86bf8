"""The settings of the planners in a mission file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from rota.files.planner_faults import MOST_ROBOTS
from rota.files.schema_block import Block, Duration, Length, LengthOrZero, NotNegative, Where
from rota.mission import (
    HEADINGS,
    METHODS,
    BounceCells,
    BounceMethod,
    BounceTask,
    Contact,
    ContactFree,
    Controller,
    Corners,
    DeploymentMethod,
    Device,
    FramePartition,
    FrameTour,
    Method,
    Purpose,
    SegmentRoutes,
    SetBoundary,
    VelocityChoice,
)
from rota.planner_settings import MOST_BOUNCE_STEPS, altitude_faults, angle_faults, physical_faults

MOST_SAMPLES, MOST_SWARM_STEPS = 1_000_000, 100_000_000  # more would take a year


class Sun2019Block(Block):
    """How the stages of the method sun2019 are done: ours by default, or the paper's."""

    deployment: DeploymentMethod = Field("best", description="of virtual sensors; ccpso2 is the paper's")
    tour: FrameTour = Field("local_search", description="past all sensors; genetic is the paper's")
    partition: FramePartition = Field("exact", description="of the tour among the robots; pso is the paper's")
    routes: SegmentRoutes = Field("shortened", description="printed, or repaired until all is seen, or shortened too")


class PatrolBlock(Block):
    """Settings of the patrol planner."""

    effort: Literal["quick", "normal", "high"] = "normal"
    method: Method = Field("tours", description="tours, or to compare with: a traditional method or Sun 2019's stages")
    period_margin: Annotated[NotNegative, Field(lt=1)] = Field(
        0.0, description="reserve: plan with periods shorter by this share"
    )
    range_margin_m: LengthOrZero = Field(0.0, description="reserve: plan with sensors that reach so much less far")
    sun2019: Sun2019Block | None = None

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """Settings of another method."""
        method = data.get("method", "tours")
        if data.get("sun2019") is not None and method in METHODS and method != "sun2019":
            yield ("sun2019",), f"settings of another method; method is {method}: remove this block"


class SwarmBlock(Block):
    """Settings of the swarm planner; defaults as in Chen et al. 2018."""

    controller: Controller = Field("settle", description="reciprocal is the paper's own")
    velocity: VelocityChoice = Field("centroid", description="of the set: exact, or the mean of random samples")
    samples: Annotated[int, Field(strict=True, ge=1, le=MOST_SAMPLES)] = 1000
    boundary: SetBoundary = Field("tangent", description="of the set: the circle at horizon_s, or its tangent")
    horizon_s: Duration = 1.0
    neighbours: Annotated[int, Field(strict=True, ge=0, le=MOST_ROBOTS)] = Field(
        4, description="the nearest that count"
    )
    neighbour_range_m: Length | None = Field(None, description="null: 2.04 times the largest sensor radius")
    wall_range_m: Length | None = Field(None, description="null: the robot's sensor radius")
    alpha: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=1)] = Field(
        1.0, description="how much to make way for moving obstacles (Eq. 15)"
    )
    filter: Annotated[bool, Field(strict=True)] = Field(True, description="no step may make bodies touch")
    time_step_s: Duration = 0.25
    stop_m: Annotated[LengthOrZero, Field(gt=0)] = Field(1e-5, description="stop when no robot moves farther in a step")
    most_steps: Annotated[int, Field(strict=True, ge=1, le=MOST_SWARM_STEPS)] = 4000
    thinning_m: LengthOrZero = Field(0.05, description="by which trajectories may be simplified")
    delay_steps: Annotated[int, Field(strict=True, ge=0, le=20)] = Field(0, description="age of what robots hear")
    messages_lost: Annotated[NotNegative, Field(lt=1)] = Field(0.0, description="share of messages that never arrive")
    device: Device = Field("cpu", description="cuda: decisions on an NVIDIA GPU, with the package numba-cuda")
    altitudes_m: tuple[Length, Length] | None = Field(
        None, description="of reciprocal: robots move in space, between the lowest and the highest altitude"
    )

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """Altitudes with what is for the plane only."""
        heights = data.get("altitudes_m")
        if heights is None or len(_numbers(heights)) != 2:
            return
        for where, value, allowed in altitude_faults(data):
            yield (where,), f"{value} is not allowed; {allowed}"


Angle = Annotated[float, Field(strict=True, allow_inf_nan=False)]


class BounceBlock(Block):
    """Settings of the bounce planner (Alam & Bobadilla 2020)."""

    task: BounceTask = Field("monitor", description="the zones for ever, or cover the area once")
    method: BounceMethod = Field("improved", description="as_printed is the paper's own")
    cell_m: Length | None = Field(None, description="side of a cell; null: that of the area's text map")
    headings: Annotated[int, Field(strict=True)] = Field(
        8, description=f"one of {', '.join(map(str, HEADINGS))}; beyond 8 angles vary a little"
    )
    bouncing_angles_deg: Annotated[list[Angle], Field(min_length=1)] = Field(
        [135.0], description="counterclockwise, one for all robots or one for each; multiples of 360 / headings"
    )
    start_headings_deg: Annotated[list[Angle], Field(min_length=1)] | None = Field(
        None, description="counterclockwise from x, one for all robots or one for each; null: as the planner likes"
    )
    corners: Corners = Field("blocked", description="a diagonal move beside an obstacle's corner: blocked, or pass")
    contact: Contact = Field("swept", description="swept distance of bodies, or the published definition on the grid")
    contact_free: ContactFree = Field("cycle", description="of robots that monitor: the cycle, or all the trajectory")
    purpose: Purpose = Field("periods", description="of robots that monitor: what the plan is best for")
    most_steps: Annotated[int, Field(strict=True, ge=1, le=MOST_BOUNCE_STEPS)] = Field(
        100_000, description="to cover the area"
    )
    cells: BounceCells = Field("grid", description="none: straight lines and exact contacts, without cell_m")
    turning_error_deg: Angle = Field(0.0, description="each turn is off by up to so much; simulated and told")
    clock_drift: Angle = Field(0.0, description="share by which each robot's clock may run fast or slow")
    clock_signal_s: Angle | None = Field(None, description="a common signal sets all clocks so often; null: once")
    cell_origin: tuple[Angle, Angle] | None = Field(
        None, description="a corner [x, y] of a cell in metres; null: the lower left one of the area's bounds"
    )

    @classmethod
    def faults(cls, data: dict[str, Any]) -> Iterator[tuple[Where, str]]:
        """A number of headings that the grid has no moves for, angles between two headings, what needs a grid."""
        for name, told, allowed in physical_faults(_numbers_only(data)):
            yield (name,), f"{told} is not allowed; {allowed}"
        headings = data.get("headings", 8)
        if not isinstance(headings, int) or isinstance(headings, bool):
            return
        if headings not in HEADINGS:
            yield ("headings",), f"{headings} is not allowed; one of {', '.join(map(str, HEADINGS))} is needed"
            return
        bouncing, starts = data.get("bouncing_angles_deg"), data.get("start_headings_deg")
        numbers = [_numbers(angles) for angles in ([135.0] if bouncing is None else bouncing, starts)]
        cells = "none" if data.get("cells") == "none" else "grid"
        for where, value, allowed in angle_faults(headings, *numbers, cells=cells):
            name, _, k = where.rstrip("]").partition("[")
            place: Where = (name,) if data.get(name) is None else (name, int(k))
            yield place, f"{value:.9g} is not allowed; it {allowed}"


PHYSICAL = ("turning_error_deg", "clock_drift", "clock_signal_s", "cell_m")


def _numbers_only(data: dict[str, Any]) -> dict[str, Any]:
    """The settings without those that should be numbers and are none, which the schema refuses."""
    return {name: value for name, value in data.items() if name not in PHYSICAL or _numbers([value])}


def _numbers(values: Any) -> list[float]:
    """A list of numbers as it is; empty for what the schema refuses."""
    ok = isinstance(values, list) and all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
    return values if ok else []
