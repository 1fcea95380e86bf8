# mypy: disable-error-code="no-any-return"
"""Compiled dry friction of robots that settle: it ends each motion in finite time.

All lengths of a step are shares of ``friction_unit_m``.
"""

from __future__ import annotations

import math
from typing import Any

from rota.compiled.kernel import allocation_free

STEPS_FOR_SENSOR = 64.0  # a robot that needs more of them for its sensor's radius has less friction, else none starts
PATIENCE, FRICTION_GROWTH = 2.0, 4.0  # longest ways on the map, twice each, and by how much it grows in each more
KINETIC_FRICTION, STATIC_FRICTION = 2.5e-5, 1.25e-4  # measured: swarms rest in half the steps and cover as much
STATIC_BELOW = 5e-4  # friction grows from the kinetic to the static one as steps shrink from here to 0
LEAST_STEP = 1e-5  # what is left of a step below this is none: with late news, robots creep on for ever by less
LATE_FRICTION = 7.0  # times as much with late news, which drive robots to and fro


@allocation_free
def friction_unit_m(sensor_m: float, most_m: float, snapshot: Any) -> float:
    """The length that friction is a share of: the sensor's radius, or less where a step is much shorter than that.

    most_m: the longest step that the robot can make. Friction is small beside both: a share of the radius alone held
    robots whose steps are short where they stood. It is greater with late news, and grows when robots could have driven
    ``PATIENCE`` times through the whole map since anything changed but themselves: so whatever goes to and fro ends.
    """
    rule, far_m = snapshot.rule, snapshot.grid.place_graph.way_m
    unit_m = min(sensor_m, STEPS_FOR_SENSOR * most_m)
    if rule.late:
        unit_m *= LATE_FRICTION
    impatience = (snapshot.step - rule.last_change) * most_m / far_m - PATIENCE
    return unit_m * FRICTION_GROWTH**impatience if impatience > 0.0 else unit_m


@allocation_free
def rub(dx: float, dy: float, last_m: float, unit_m: float) -> tuple[float, float]:
    """What friction leaves of a step (dx, dy) after a step of last_m: (0, 0) of one hardly longer than friction.

    unit_m: by ``friction_unit_m``.
    """
    slowness = max(0.0, 1.0 - last_m / (STATIC_BELOW * unit_m))
    friction_m = unit_m * (KINETIC_FRICTION + (STATIC_FRICTION - KINETIC_FRICTION) * slowness)
    length = math.sqrt(dx * dx + dy * dy)
    left = 1.0 - friction_m / length if length > friction_m + LEAST_STEP * unit_m else 0.0
    return left * dx, left * dy
