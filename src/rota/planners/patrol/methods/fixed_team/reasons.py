"""Why a team of a given size has no plan, in words."""

from __future__ import annotations

from rota.planners.patrol.context import Context
from rota.planners.patrol.verdict import Verdict, demand_in_words, robots_in_words, touching, worst_demand


def too_few(context: Context, robots: int, detail: str, *, least_ratio: float = 0.0) -> str:
    """That so many robots do not meet the demand, whether that is proved, the detail, and what is proved.

    least_ratio: what is proved of the worst ratio of gap to period with so many robots; 0: nothing.
    """
    if context.bound.robots > robots:
        opening = f"{robots_in_words(robots)} cannot meet the demand"
    else:
        opening = f"no plan was found with which {robots_in_words(robots)} meet the demand"
    proved = f"proved: at least {robots_in_words(max(context.bound.robots, 1))} ({context.bound.reason})"
    if least_ratio > 0:
        proved += f", and with {robots_in_words(robots)} no worst gap below {least_ratio:.3f} times its period"
    return f"{opening}: {detail}; {proved}"


def best_ratio(verdict: Verdict, ratio: float, *, reserve: bool) -> str:
    """What the plan with the smallest worst ratio misses most, or which bodies touch in it.

    ratio: of its worst gap to the period that is asked. reserve: whether that period is shorter than the mission's.
    """
    crowded = touching(verdict)
    if ratio <= 1 and crowded is not None:
        return crowded
    worst = worst_demand(verdict)
    assert worst is not None
    return (
        f"at best, in {demand_in_words(worst)}, the worst gap is {worst.worst_gap_s:.6g} s, {ratio:.3f} times its"
        f" period{' less the reserve' if reserve else ''}"
    )


def apart(components: int) -> str:
    """That each component of the standing space needs a robot of its own."""
    return (
        f"the ground falls into {components} parts between which no robot can travel, and each must be watched by a"
        " robot of its own"
    )
