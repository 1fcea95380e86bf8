"""Maps of Chen et al., Sensors 18(6):1864, 2018: sizes are the paper's, places are ours where it prints none."""

from __future__ import annotations

import math
from typing import Any, Literal

from shapely import MultiPolygon, box

from rota.mission import DiscSensor, Fleet, Mission, Obstacle, Robot, StartBox, SwarmSettings
from rota.studies.chen2018 import paper

LIKE: Any = {
    "speed_m_s": paper.SPEED_M_S,
    "sensor": DiscSensor(radius_m=paper.SENSOR_M),
    "body_radius_m": paper.BODY_M,
}
Start = Literal["centre", "between", "corner"]
STARTS: dict[Start, float] = {"centre": 0.4, "between": 0.2, "corner": 0.0}
"""Where the start box begins, as a share of the side in x and y."""

OBSTACLE_CENTRE_M = (125.0, 125.0)
"""Of Figure 14: in the middle of the area, so that robots from any start but the centre have to go round it."""
LARGE_OBSTACLES_M = ((500, 650, 700, 750), (1100, 700, 1150, 900), (1200, 200, 1300, 350), (1500, 600, 1600, 800))
"""Of Figure 21: x0, y0, x1, y1 of rectangles outside the start box."""


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


def large(robots: int = paper.ROBOTS_LARGE) -> Mission:
    """Figure 21: 1,000 robots in 2,000 m x 1,000 m with obstacles, from a box of 1,000 m x 500 m in a corner."""
    return _mission(
        f"{robots:,} robots and obstacles", paper.LARGE_M, robots, (0.0, 0.0), paper.LARGE_START_M, LARGE_OBSTACLES_M
    )


def _mission(
    name: str,
    size_m: tuple[float, float],
    robots: int,
    low_m: tuple[float, float],
    high_m: tuple[float, float],
    obstacles_m: tuple[tuple[float, float, float, float], ...] = (),
) -> Mission:
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
