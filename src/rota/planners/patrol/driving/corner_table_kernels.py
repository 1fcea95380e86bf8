# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False, disallow-untyped-calls=False
"""What rounded corners add to a way, in a table that annealing looks them up in (compiled)."""

from __future__ import annotations

import math

import numpy as np

from rota.compiled.kernel import kernel
from rota.planners.patrol.driving.rounded_kernels import between_s, fastest_round, rounding

ANGLES, LENGTHS = 33, 64  # rows and columns
SMALLEST_TURN = 1e-5  # the first row's


@kernel(noinline=True)
def corner_table(longest_m, pace_m_s, limits):
    """What corners add, as metres at a pace, by their sharpness and the legs beside them: (ANGLES, LENGTHS).

    Of a corner between two legs each has its share. Row j is for half an angle with the sine j / (ANGLES - 1), the
    first for the smallest turn there is; column i for a leg of (i / (LENGTHS - 1))^2 ``longest_m``. It is what a leg
    between two corners alike adds to their half; less than 0 for legs that are faster than the pace.
    """
    table = np.zeros((ANGLES, LENGTHS))
    for j in range(ANGLES):
        sine = max(SMALLEST_TURN, j / (ANGLES - 1))
        for i in range(1, LENGTHS):
            leg_m = longest_m * (i / (LENGTHS - 1)) ** 2
            speed = fastest_round(sine, leg_m, limits)
            whole_s, half_m, _ = rounding(speed, sine, limits)
            whole_s += between_s(speed, speed, max(0.0, leg_m - 2 * half_m), limits)
            whole_s += 2 * math.asin(min(1.0, sine)) * limits.turn_s
            table[j, i] = (whole_s * pace_m_s - leg_m) / 2
    return table
