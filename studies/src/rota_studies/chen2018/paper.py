"""What the paper prints (Chen et al., Sensors 18(6):1864, 2018), each number with its place; nothing here is ours."""

from __future__ import annotations

CITATION = (
    "R. Chen, N. Xu and J. Li, “A Self-Organized Reciprocal Decision Approach for Sensing Coverage with Multi-UAV "
    "Swarms”, *Sensors* 18(6):1864, 2018, <https://doi.org/10.3390/s18061864>"
)

# Table 2
STEP_S = 0.25
STOP_M = 1e-5
SIDE_M, START_SIDE_M = 250.0, 50.0
ROBOTS, ROBOTS_LARGE = 25, 1000
SPEED_M_S = 2.0
BODY_M, SENSOR_M, COMMUNICATION_M = 0.5, 25.0, 70.0
NEIGHBOURS, NEIGHBOUR_RANGE_M = 4, 51.0

SAMPLES = 1000
"""Algorithm 1, line 3."""
SAMPLES_ENOUGH = 200
"""Below Figure 11: "the error nearly reaches zero after 200 random points"."""

STEPS_FIGURE_12, STEPS_FIGURE_14, STEPS_FIGURE_21 = 574, 1248, 5226
OBSTACLE_SIDE_M = 10.0
"""Figure 14; where the obstacle stands is not printed."""
ROBOTS_AT_OBSTACLE = (1, 8, 16)
"""Figure 16: those within 25 m of the obstacle at any time."""
ROBOT_FIGURE_18 = 23
"""Whose trajectory the text tells to be smoother than with the other methods."""

LARGE_M, LARGE_START_M = (2000.0, 1000.0), (1000.0, 500.0)
"""Section 5.2; where obstacles stand, and where the start box is, is shown in Figure 21 and not told."""

GAZEBO_ROBOTS, GAZEBO_SIDE_M, GAZEBO_SENSOR_M = 16, 128.0, 30.0
GAZEBO_SPEED_M_S, GAZEBO_REST_S = 20.0, 10.0
"""Section 5.3, in ROS and Gazebo: square sensors, a steady state after 10 s; start, body and step are not told."""

TABLE_3_MS: dict[str, tuple[float, float, float, float]] = {
    "RD": (10.857, 20.280, 13.266, 14.807),
    "V-based": (591.148, 605.856, 632.880, 609.961),
    "VFA": (36.749, 48.072, 43.573, 42.798),
}
"""Milliseconds of one decision in Cases 1 to 3 and on average; which cases they are is not told."""
