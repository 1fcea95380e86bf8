"""Every tolerance of the check, in one place: what each one allows, and why it is not 0.

A plan that breaks a limit by no more than its tolerance keeps it. Tolerances that decide what counts as seen work the
other way: they withhold something from the plan, so that rounding never shows a demand met that is not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:  # kernels that import a tolerance are not compiled anew when missions get another field
    from rota.model.mission import Mission

FLOAT_EPS = float(np.finfo(np.float64).eps)  # float64 rounds a number by up to this share of it

# ------------------------------------------------------------ by how much a plan may break limits

TOUCH_M = 1e-6  # bodies may overlap each other, walls, borders and height limits, and miss a start or a cell, by this
PERIOD_TOLERANCE = 1e-9  # a gap may exceed its period by this share
SPEED_TOLERANCE = 1e-9  # a robot may exceed its speed, and its turn rate, by this share
TURN_TOLERANCE_RAD = 1e-9  # a turn may take no time up to this angle
RADIUS_TOLERANCE = 1e-9  # arcs may have a radius smaller than the turn radius by this share
TURN_OFF_SHARE = 5e-3  # legs may leave the curve that a robot drives by this share of its turn radius
ACCELERATION_TOLERANCE = 1e-6  # a robot may exceed its accelerations, and its jerk, by this share
BATTERY_S = 1e-6  # a battery may fall below its reserve by so many seconds of driving
OFF_M = 0.05  # a motion that keeps the limits may be off the plan by this, where the plan's velocity jumps
CLOCK_TOLERANCE = 1e-9  # the clocks' margin may fall short of what the mission asks by this share
BOUNCE_TOLERANCE_RAD = 1e-6  # a bounce, and the way a robot faces, may be off by this angle
MOST_EXCLUDED = 0.05  # a plan may leave out, as seen by nobody, up to this share of the demanded area

# ------------------------------------------------------------ numbers so near each other that they count as one

STILL_M = 1e-9  # a robot that moves by no more than this stands still
SLOW_SHARE = 1e-3  # a robot that is slower than this share of its speed stands, if it cannot or takes more then
SLOW_TIME = 1e-2  # but not while such legs take no more than this share of its time: then it gets up speed
STRAIGHT_RAD = 1e-3  # legs whose turns are rounding, and add up to no more than this, go straight on
SAME_TIME = 1e-9  # times that differ by this share of them, or by this many seconds below 1 s, are one moment
SAME_TURN = 1e-9  # numbers of turns of a loop that differ by this are one number
SAME_RATIO = 1e-9  # the durations of two loops have the ratio p / q if they miss it by no more than this share
SAME_STEP = 1e-14  # likewise of loops on a grid, where p and q may be large: rounding alone may lie between
SLIVER_M = 1e-3  # ground that no body covers is none where it is thinner than twice that: walls and arcs are rounded
SAME_CORNER_M = 1e-7  # corners of walls nearer to each other than this are one corner, and no slit lies between them
CONVEX_SHARE = 1e-12  # a polygon whose hull is larger by no more than this share is convex
SAME_CELL = 1e-9  # lattices begin and end at a line that is missed by no more than this share of a cell

NO_LENGTH = 1e-300  # lengths and squared lengths below this are 0, since a division by them would overflow
PARALLEL = 1e-12  # velocities in m/s with a smaller cross product are parallel
STILL_M2_S2 = 1e-24  # a relative velocity whose square is no larger is none
ALONG_WALL = 1e-5  # a bouncing robot that comes nearer to a wall by less than this share of its way goes along it

# ------------------------------------------------------------ margins on the safe side

ROUNDING = 1e-9  # lengths that are computed in two ways are compared with this share to spare
INSIDE = 1 - 1e-6  # corners of a piece are asked this share of the way from its middle, off walls and borders
AHEAD_M = 1e-4  # a body that a wall stops would be in the wall this much farther on
CONE_M = 1e-12  # a piece that touches a wall's line is treated as this far in front of it, so that it sees one side
NO_WAY_THROUGH_M = 1e-12  # nobody sees through a gap of this width; ends of sides so near to a line lie on it
EDGE_RAD = 1e-9  # directions that differ by no more than this are one
GRID_MARGIN_M = 1e-6  # what is near a cell of a grid is looked for this much farther out than it matters
SLIVER_SHARE = 1e-9  # pieces may leave out this share of a region, and a strip of 8 slack_of along its border
SPOT_M = 2e-6  # a piece as small is met where its middle is: how bodies may touch decides the rest; see MOST_FINER
SLACK_M = 1e-9  # see slack_of
SLACK_ROUNDINGS = 64  # see slack_of


def slack_of(mission: Mission) -> float:
    """The metres by which pieces and walls are made thinner: 1e-9, or more where float64 needs it far from the origin.

    A piece that touches a wall is not hidden by it; a sight line that touches a wall passes.
    """
    far = float(np.abs(mission.area.bounds).max())
    return max(SLACK_M, SLACK_ROUNDINGS * FLOAT_EPS * far)
