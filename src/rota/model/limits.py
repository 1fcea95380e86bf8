"""How large what is read, planned and checked may be: beyond it float64 tells places and times no longer apart."""

from __future__ import annotations

LARGEST_M = 1e8  # coordinates and lengths; float64 then still holds places to 1.5e-8 m
LONGEST_S = 1e10  # times, periods and durations; some 300 years
SHORTEST_LOOP_S = 1e-6  # a robot that repeats takes at least so long
KEPT_SHARE = 0.05  # of what a robot needs to come to its charger: so much more is left when it waits no longer
FAR_FROM_AREA_M = 1e6  # that a plan's positions may be away from the mission's area along each axis

# what a mission file may say: generous for anything that moves on this planet, and no square, sum or quotient of it
# overflows or is lost; farther than 1e7 m no projection holds, and sums of squares lose the millimetres
LENGTH, LENGTH_OR_ZERO, COORDINATE = (1e-3, 1e7), (0.0, 1e7), (-1e7, 1e7)
DURATION, MOMENT = (1e-3, 1e9), (0.0, 1e9)
RATE = (1e-6, 1e6)  # metres or radians per second
