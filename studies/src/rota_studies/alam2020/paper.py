"""What the paper prints (Alam & Bobadilla, Robotics 9(2):47, 2020), each number with its place."""

from __future__ import annotations

CITATION = (
    "T. Alam and L. Bobadilla, “Multi-Robot Coverage and Persistent Monitoring in Sensing-Constrained Environments”, "
    "*Robotics* 9(2):47, 2020, <https://doi.org/10.3390/robotics9020047>"
)

HEADINGS = 8
RUNS = 20
"""Section 5.1: "We ran 20 simulation tests for both environments"."""
TEAMS = (2, 3, 4, 5)
COVER_ANGLE_DEG = 135.0

CONTACTS_FIGURE_6 = 1
"""Below Figure 6: "only one robot-robot collision"."""

ROBOTS_FIGURE_9, COVERED_FIGURE_9 = 10, 0.98
"""Section 5.1: the heat map of "an almost complete (98%) environment coverage"."""

GROUPS = {10: (45.0, 47), 11: (90.0, 18)}
"""Section 5.2: bouncing angle and number of periodic groups of two robots for the target regions of each figure."""

ANGLES_DEG = (45.0, 90.0, 135.0)
"""Section 6: those that the experiments use; "135° and 45° angles provide better coverage" than 90° and 180°."""
