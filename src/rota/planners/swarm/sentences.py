"""What is said of robots that spread and hold, for people."""

from __future__ import annotations

import numpy as np

from rota.plan import Plan
from rota.plan_summary import range_at_the_end, rounded


def holding_sentence(plan: Plan) -> str:
    """When robots that spread come to hold, how far they have gone by then, and whether they were cut off."""
    ways_m = [float(np.linalg.norm(np.diff(t.positions_m, axis=0), axis=1).sum()) for t in plan]
    n, last_s = len(plan.trajectories), max((trajectory.loop_start_s for trajectory in plan), default=0.0)
    robots = f"{n} robot" + ("s hold" if n != 1 else " holds")
    gone = f"{rounded(min(ways_m))} to {rounded(max(ways_m))} m" if n > 1 else f"{rounded(ways_m[0])} m"
    held = f"{robots} {rounded(last_s)} s after setting out, having gone {gone}"
    if plan.run_end is None or plan.run_end.at_rest:
        return f"{held}."
    return f"{held}: the run was {plan.run_end.text()}."


def covered_sentence(plan: Plan) -> str:
    """How much of the free space the holding robots have in range, and what footprints that share nothing would."""
    seen, free, sum_m2 = range_at_the_end(plan)
    share, most = seen.area / free.area, min(1.0, sum_m2 / free.area)
    return f"They then have {share:.1%} of the area in range; footprints without overlap would have {most:.1%}."
