"""Maps of Chen et al., Sensors 18(6):1864, 2018: sizes are the paper's, places are ours where it prints none."""

from __future__ import annotations

import math
from typing import Any, Literal

from shapely import MultiPolygon, box

from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, SquareSensor, StartBox
from rota.planners.swarm.planner_settings import SwarmSettings
from rota_studies.chen2018 import paper

LIKE: Any = {
    "speed_m_s": paper.SPEED_M_S,
    "sensor": DiscSensor(radius_m=paper.SENSOR_M),
    "body_radius_m": paper.BODY_M,
}
Start = Literal["centre", "between", "corner"]
LargeStart = Literal["corner", "left", "centre"]
STARTS: dict[Start, float] = {"centre": 0.4, "between": 0.2, "corner": 0.0}
"""Where the start box begins, as a share of the side in x and y."""

OBSTACLE_CENTRE_M = (125.0, 125.0)
"""Of Figure 14: in the middle of the area, so that robots from any start but the centre have to go round it."""
LARGE_STARTS_M: dict[LargeStart, tuple[float, float]] = {"corner": (0, 0), "left": (0, 250), "centre": (500, 250)}
"""Of Figure 21: where the start box begins. The paper shows it in a picture only; three places of ours."""
GAZEBO_START_M = 40.0
HILLS = ((0.25, 0.3, 26, 14), (0.7, 0.25, 20, 9), (0.55, 0.75, 30, 18), (0.15, 0.8, 18, 8), (0.9, 0.6, 16, 7))
"""Of Section 5.3: middles as shares of the side, widths and heights in metres. The paper shows mountains only."""
LARGE_OBSTACLES_M = ((500, 650, 700, 750), (1100, 700, 1150, 900), (1200, 200, 1300, 350), (1500, 600, 1600, 800))
"""Of Figure 21: x0, y0, x1, y1 of rectangles, outside the start box in the corner."""


def small(start: Start) -> Mission:
    """Section 5.1: 25 robots in a square of 250 m, from a box of 50 m whose place the paper does not print."""
    return square(paper.ROBOTS, start)


def square(robots: int, start: Start) -> Mission:
    """Robots as dense as in Table 2 in a square, from a box with a fifth of its side; metres."""
    side_m = paper.SIDE_M * math.sqrt(robots / paper.ROBOTS)
    box_m = paper.START_SIDE_M * side_m / paper.SIDE_M
    low_m = STARTS[start] * side_m
    return _mission(
        f"{robots} robots, {start}", (side_m, side_m), robots, (low_m, low_m), (low_m + box_m, low_m + box_m)
    )


def with_obstacle(start: Start) -> Mission:
    """Figure 14: the small case with a square obstacle of 10 m; not from the centre, where it stands."""
    x, y = OBSTACLE_CENTRE_M
    half_m = paper.OBSTACLE_SIDE_M / 2
    low_m = STARTS[start] * paper.SIDE_M
    return _mission(
        f"25 robots and an obstacle, {start}",
        (paper.SIDE_M, paper.SIDE_M),
        paper.ROBOTS,
        (low_m, low_m),
        (low_m + paper.START_SIDE_M, low_m + paper.START_SIDE_M),
        ((x - half_m, y - half_m, x + half_m, y + half_m),),
    )


def large(robots: int = paper.ROBOTS_LARGE, start: LargeStart = "corner") -> Mission:
    """Figure 21: 1,000 robots in 2,000 m x 1,000 m with obstacles, from a box of 1,000 m x 500 m somewhere."""
    x, y = LARGE_STARTS_M[start]
    high_m = (x + paper.LARGE_START_M[0], y + paper.LARGE_START_M[1])
    name = f"{robots:,} robots and obstacles, {start}"
    return _mission(name, paper.LARGE_M, robots, (x, y), high_m, LARGE_OBSTACLES_M)


def gazebo() -> Mission:
    """Section 5.3: 16 robots with square sensors in 128 m x 128 m, from a box in the middle whose size is ours."""
    like = LIKE | {"sensor": SquareSensor(side_m=paper.GAZEBO_SENSOR_M), "speed_m_s": paper.GAZEBO_SPEED_M_S}
    low_m, high_m = (0.5 * (paper.GAZEBO_SIDE_M + sign * GAZEBO_START_M) for sign in (-1, 1))
    robots = tuple(Robot(name=f"robot-{k + 1}", **like) for k in range(paper.GAZEBO_ROBOTS))
    return Mission(
        name="Section 5.3",
        area=MultiPolygon([box(0, 0, paper.GAZEBO_SIDE_M, paper.GAZEBO_SIDE_M)]),
        fleet=Fleet(robots=robots, start=StartBox(low_m=(low_m, low_m), high_m=(high_m, high_m)), **like),
        planning=SwarmSettings(),
    )


def hills_m(x: float, y: float) -> float:
    """Height in metres of our mountainous region at a place of Section 5.3: five round hills; the paper tells none."""
    side_m = paper.GAZEBO_SIDE_M
    return sum(
        height_m * math.exp(-((x - a * side_m) ** 2 + (y - b * side_m) ** 2) / width_m**2)
        for a, b, width_m, height_m in HILLS
    )


def _mission(
    name: str,
    size_m: tuple[float, float],
    robots: int,
    low_m: tuple[float, float],
    high_m: tuple[float, float],
    obstacles_m: tuple[tuple[float, float, float, float], ...] = (),
) -> Mission:
    """A mission of Table 2's robots, which start in the box low_m to high_m; obstacles_m: x0, y0, x1, y1."""
    return Mission(
        name=name,
        area=MultiPolygon([box(0, 0, *size_m)]),
        obstacles=tuple(Obstacle(shape=MultiPolygon([box(*corners)])) for corners in obstacles_m),
        fleet=Fleet(
            robots=tuple(Robot(name=f"robot-{k + 1}", **LIKE) for k in range(robots)),
            start=StartBox(low_m=low_m, high_m=high_m),
            **LIKE,
        ),
        planning=SwarmSettings(),
    )
