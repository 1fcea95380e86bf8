"""What can be wrong with a plan, by name: the check says it, planners and people read it."""

from __future__ import annotations

from typing import Literal

ViolationKind = Literal[
    # what is asked
    "gap", "unseeable", "holds too late", "claims that fewer robots cannot do",
    "claims that a cheaper fleet cannot do",
    # the fleet
    "no trajectory", "more robots than there are", "no start left", "start", "moves while away", "sees before it joins",
    "no way there from the entrances",
    # motion
    "outside area", "obstacle", "moving obstacle", "below altitudes", "above altitudes", "speed", "turn",
    "turn radius", "acceleration", "corner acceleration", "jerk",
    # along lanes
    "off the lanes", "against a one-way lane", "faster than its lane", "leaves a lane between its ends",
    # batteries
    "battery below its reserve", "takes more than it charges", "charges away from its charger", "charger too full",
    "battery fuller than what was driven leaves", "stands though it cannot", "leaves before it can land and climb",
    # robots together
    "bodies touch", "clocks may differ",
    # robots that bounce
    "too many cells to judge", "too many moves to judge", "no bouncing angle", "cells never entered", "off its cells",
    "along no heading", "drives through what blocks it", "faces another way than it drives",
    "turns by another angle", "turns where nothing is in the way", "waits where nothing is in the way",
    "rests where nothing is in the way",
]  # fmt: skip
