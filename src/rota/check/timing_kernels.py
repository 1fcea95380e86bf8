# mypy: disallow-untyped-decorators=False, disallow-untyped-defs=False
"""Compiled loops that turn a share of a leg's way into the time at which its robot has done it."""

from __future__ import annotations

import math

from rota.compiled.kernel import allocation_free


@allocation_free
def time_along(begin_s, end_s, bend, share):
    """The time in seconds at which a robot has done the share, 0..1, of a leg from begin_s to end_s.

    Of the share u of the leg's time it has done the share u + bend u (u - 1) of its way, bend from -1 to 1; see
    ``Trajectory.bends``. This is the inverse, in the form whose sums do not cancel. Where the robot is at rest on one
    end, a rounding of the share there by e is one of the time by its square root.
    """
    if share <= 0:
        return begin_s
    if share >= 1:
        return end_s
    if bend != 0:
        first = 1 - bend  # the speed as the leg begins, as a share of its mean
        share = min(1.0, 2 * share / (first + math.sqrt(max(0.0, first * first + 4 * bend * share))))
    return begin_s + share * (end_s - begin_s)
