"""What is told of how late places are where a plan takes over from another one: types, text and JSON."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

NUMBER_OR_NEVER = {"type": ["number", "null"]}


@dataclass(frozen=True, kw_only=True)
class LateDemand:
    """How late one demand is after the change. Seconds; inf: for ever.

    No point of it waits longer than its period and ``worst_s``; some point waits ``worst_at_least_s`` longer, from
    ``time_s`` on at ``place_m`` (None: nothing is late).
    """

    name: str
    worst_s: float
    worst_at_least_s: float
    place_m: tuple[float, float] | None
    time_s: float | None


class ForEver(NamedTuple):
    """Of one demand: square metres that are never seen, and the longest gap of the others over its period."""

    name: str
    unseen_m2: float
    ratio: float


@dataclass(frozen=True, kw_only=True)
class LateSample:
    """What some points say of a plan that takes over from another one; no more than that of the ground between.

    for_ever: of each demand, what its loops come to. worst_s: how late some point is after the change. late_m2_s: of
    all ground, times seconds late, until all has been seen in the loops. last_s: the last moment then at which some
    point is late. Of points that are never seen any more it says only for how much ground they stand.
    """

    for_ever: tuple[ForEver, ...]
    worst_s: float
    late_m2_s: float
    last_s: float


@dataclass(frozen=True, kw_only=True)
class Lateness:
    """How late places are from the moment on at which a plan takes over from another one, which is 0 of its clock.

    at_s: the moment in the clock of the plan before. ``lost``: the robots that are there no more. late_m2_s: of all
    ground, square metres times seconds late, of a sample; inf: for ever. ``holds_again_s``: no place is late any more
    from then on; None: that is not shown of any moment, or some place is late for ever.
    """

    at_s: float
    lost: tuple[str, ...]
    late_m2_s: float
    holds_again_s: float | None
    demands: tuple[LateDemand, ...]

    @property
    def worst(self) -> LateDemand | None:
        """The demand that is late by most; None where nothing is asked."""
        return max(self.demands, key=lambda one: (one.worst_s, one.worst_at_least_s), default=None)

    def lines(self) -> list[str]:
        """What people are told, line by line."""
        who = f" ({', '.join(self.lost)} lost)" if self.lost else ""
        head, worst = f"since the change at t = {_text(self.at_s)} s of the plan before{who}: ", self.worst
        if worst is None or worst.worst_s <= 0:
            return [f"{head}nothing is late"]
        low, high = _text(worst.worst_at_least_s), _text(worst.worst_s)
        late = "some ground is late for ever" if math.isinf(worst.worst_at_least_s) else f"at most {high} s late"
        if math.isfinite(worst.worst_at_least_s) and low != high:
            late = f"{low} to {high} s late at most" if math.isfinite(worst.worst_s) else f"{low} s late or more"
        where = "" if worst.place_m is None else f" at ({worst.place_m[0]:.2f}, {worst.place_m[1]:.2f})"
        lines = [f"{head}{late}, in {worst.name}{where}"]
        if math.isfinite(self.late_m2_s):
            lines.append(f"late in all: about {_text(self.late_m2_s)} m2 s of ground and time")
        again = "not shown" if self.holds_again_s is None else f"from t = {_text(self.holds_again_s)} s on"
        return [*lines, f"every period holds again: {again}"]


def lateness_properties() -> tuple[dict[str, Any], dict[str, Any]]:
    """JSON schemas by name: of a ``Lateness``, and of each of its demands."""
    place = {"type": ["array", "null"], "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
    demand = {
        "name": {"type": "string"},
        "worst_s": {**NUMBER_OR_NEVER, "description": "no point is later by more; null: not shown"},
        "worst_at_least_s": {**NUMBER_OR_NEVER, "description": "some point is so late; null: for ever"},
        "place_m": place,
        "time_s": {**NUMBER_OR_NEVER, "description": "from when on that point is not seen"},
    }
    return {
        "at_s": {"type": "number", "minimum": 0, "description": "the moment in the clock of the plan before"},
        "lost": {"type": "array", "items": {"type": "string"}},
        "late_m2_s": {**NUMBER_OR_NEVER, "description": "ground times seconds late, of a sample; null: for ever"},
        "holds_again_s": {**NUMBER_OR_NEVER, "description": "no place is late from then on; null: not shown"},
    }, demand


def _text(value: float) -> str:
    return "never" if math.isinf(value) else f"{value:.3f}".rstrip("0").rstrip(".")
