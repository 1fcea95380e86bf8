"""How far a robot may be from where it is believed, and why bodies keep apart though nobody knows where others are.

Every robot decides at its own times, by news of others that are late, of which many may be lost. It goes on with what
it decided until the hold it told of is over; then it stands. It decides again no sooner than that.

Assumption. While a robot moves, whoever decides has news of it that are no older than D (``silent_s``), whatever delays
and losses together do. Clocks differ by no more than E (``clock_error_s``). Where each robot goes by its own clock
(``own_clocks``), news are dated by the promptest ones (``clocks.py``): too late by no more than E, if some news of each
robot that is heard are read so soon after they are told that drift since then adds up to no more than E with that.

What robots promise. (a) A robot goes no faster than it told. Its speed grows by at most ``MOST_SPEED_GAIN`` of the top
speed from one hold to the next. It is 0 from the end of a hold to the next decision. (b) A robot stands and tells so
for D before its first motion, and before it goes on after it told nothing for more than D / 2. (c) One that was never
heard stands at its start.

Reach. News told at t' with velocity v hold until e = t' + hold. By them the robot is at c = p + v (t - t') at a time t
up to e, and at c = p + v hold later, but for what it has decided since. Up to a time T > t it gets no farther from c
than s = |v| (e - t) + the integral of min(top, |v| + k gain) over the holds k = 1, 2, ... from e to T; the first term
is 0 for t > e. That is ``reach_m``. Clocks widen it: T by E, and s by E times the top speed.

Claim. Bodies that are apart in the beginning never touch.

Proof. Let A decide at t for its hold h, B be any other robot, and s its reach up to t + h. A keeps to the half-planes
of the last filter (``filter_kernels``, "Old news"): v . u <= max(d - s - r_A - r_B, 0) / 2 h for the direction u from A
to every place y within s of c, where d is the distance from A to c; and v = 0 where s >= d. Either

1. d - s > r_A + r_B. After a time q <= h, A is at least (d - s) - q v . u >= r_A + r_B away from each y: it keeps clear
   of all that B may reach, wherever B is by then. Or
2. v . u <= 0 for all u. Then A never lessens its distance to B, wherever B is: seen from A at x + q v, the rate towards
   y is (y - x) . v - q |v|^2 <= 0.

Let bodies touch first at a time t*, and let A have decided last at t_A and B at t_B >= t_A. If one of them is in case
1, it is clear at t* of all that the other may reach: a contradiction. If both are in case 2, their distance has not
become less since t_B, when they did not touch: a contradiction. A robot that stands is in case 2. That B is within s of
c is the assumption as long as B moves; for silent robots it is as follows.

The silent. By the assumption a robot that was silent for D stopped within D after its last telling. It counts as a body
anywhere within its reach up to then, for ever, and as nobody's neighbour. Its start is kept clear, too, so that it can
join there again once whoever stood there has gone. That nobody died there whom it never heard is up to who starts it.

A radio range. A robot does not receive what was told farther than R from where it reads it. The assumption then holds
for news from within R only: who has no news of a robot from the last D may just be too far away from it. A hold is at
most D / 4. Bodies keep apart if R >= r_A + r_B + (top_A + top_B) 5 D / 4 for any two robots; ``least_radio_m`` is that.

Proof. Let bodies touch first at t*. One of them moves then, say A, so that t* <= t_A + D / 4. Had A at t_A no news of B
told in the D before, then something B told at a t' >= t_A - D was read at a t'' <= t_A, and B at t' was farther than R
from A at t''. Until t* A went no farther than top_A (t* - t'') and B no farther than top_B (t* - t'), each no farther
than its top speed times 5 D / 4. So they are farther apart than r_A + r_B: a contradiction. Hence A has such news, and
what was proved above holds for A at t_A. In case 1 it is clear of B. In case 2 it does not lessen its distance, so that
B moves at t* as well; then B, too, has news of A, and the proof above holds for both. Robots that left the range stay
bodies where they may have been at last: that keeps ground clear for nothing, and nobody from keeping apart.
"""

from __future__ import annotations

import math

import numpy as np

from rota.model.arrays import Floats
from rota.planners.swarm.delayed_news_kernels import MOST_SPEED_GAIN
from rota.planners.swarm.nodes.telling import ROUNDED, Telling

STEPS_TO_TOP = math.ceil(1 / MOST_SPEED_GAIN)
RADIO_SILENCES = 1.25  # D and a hold, in D


def least_radio_m(bodies_m: Floats, speeds_m_s: Floats, silent_s: float) -> float:
    """The radio range from which on no two robots of these radii (n,) and top speeds (n,) touch; 0 for a single one."""
    ways_m = np.sort(bodies_m + speeds_m_s * ROUNDED * RADIO_SILENCES * silent_s)
    return float(ways_m[-2:].sum()) if len(ways_m) > 1 else 0.0


def reach_m(telling: Telling, from_ns: int, until_ns: int) -> float:
    """How far a robot may get, from a time to another, from where its telling has it at the first; see above."""
    top, speed = telling.speed_m_s * ROUNDED, math.hypot(telling.vx, telling.vy)
    hold_s = telling.hold_ns * 1e-9
    way_m = speed * max(telling.end_ns - max(from_ns, telling.told_ns), 0) * 1e-9
    left_s = max(until_ns - telling.end_ns, 0) * 1e-9
    for k in range(1, STEPS_TO_TOP + 1):
        part_s = min(left_s, hold_s)
        way_m += min(top, speed + k * MOST_SPEED_GAIN * top) * part_s
        left_s -= part_s
        if left_s <= 0.0:
            return way_m
    return way_m + top * left_s


def silent_reach_m(telling: Telling, silent_ns: int) -> float:
    """How far from the end of what it told a robot may stand that told nothing more for so long."""
    told_m = math.hypot(telling.vx, telling.vy) * telling.hold_ns * 1e-9
    return max(told_m, reach_m(telling, telling.end_ns, telling.told_ns + silent_ns))
