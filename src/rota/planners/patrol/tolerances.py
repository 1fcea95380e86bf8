"""Every tolerance of patrol, in one place: what counts as nothing, as equal or as touching, and what rounding may take.

The check shares none of them: its own are in ``rota.check.tolerances``.
"""

from __future__ import annotations

ROUNDING = 1e-6  # share by which sums of many numbers may be off: what has to hold is made to hold by as much more
SURELY = 1 + ROUNDING  # what a bound must see exceeded is taken as longer by this, so that rounding never raises it
SLOWER = 1 - ROUNDING  # of full speed, so that rounding of times never shows as speeding

TO_SPARE = 1e-3  # share by which limits are kept better than asked, so that nobody who looks closely sees more
SAME_ROUND = 1e-10  # share by which a round may be shorter than it can be driven, or longer than its period
BISECTIONS = 40  # of an interval, until what is left of it is rounding
TIE = 1e-9  # share by which a few operations on numbers of one size are off: less is no difference

HAIR_M = 1e-6  # shorter legs, which times tell with too few digits, and gaps, slivers and differences are none
SLIVER_M2 = 1e-6  # ground with less area is what rounding leaves of cuts
BESIDE_M = 1e-3  # what is only to lie surely beside something lies so far beside it
CUT_M = 1e-5  # lengths and gaps that cuts of shapes leave are shorter
ON_LINE_M = 1e-7  # a place so near to a wall, a border or a route lies on it
INSIDE_M = 1e-8  # a place so far inside of a border is surely inside, give or take rounding
SAME_PLACE_M = 1e-9  # places so near to each other are one, but for rounding
STRAIGHT = 1e-6  # sine of half an angle below which a vertex is no corner
OFF_M = 0.05  # that legs may be off a motion that keeps the limits, as the check allows
SHORTEST_S = 1e-6  # waits and changes of speed that take less are not told
SAME_TIME_S = 1e-9  # moments so near to each other are one
OUT_OF_REACH = 1.01  # of the reach: nobody sees farther; views end in a polygon round their circle
