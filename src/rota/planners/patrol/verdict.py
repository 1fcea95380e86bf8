"""What the search reads of the verdict on a plan, and what it says of a plan that does not pass."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Protocol

from rota.model.arrays import Floats, Ints
from rota.model.mission import AREA
from rota.model.plan import Plan
from rota.model.violation_kinds import ViolationKind


class DemandOutcome(Protocol):
    """What the search reads of the verdict on one demand."""

    @property
    def name(self) -> str:
        """The zone's name, or "area"."""
        ...

    @property
    def period_s(self) -> float:
        """What is asked."""
        ...

    @property
    def worst_gap_s(self) -> float:
        """No point waits longer (inf: some of it is never seen, or so the verdict must assume)."""
        ...

    @property
    def worst_gap_at_least_s(self) -> float:
        """Some point waits as long (inf: it is never seen)."""
        ...


class Fault(Protocol):
    """What the search reads of something that is wrong with the routes themselves."""

    @property
    def kind(self) -> ViolationKind:
        """What it is: "bodies touch", say."""
        ...

    @property
    def who(self) -> str:
        """The robots, or the robot."""
        ...

    @property
    def place_m(self) -> tuple[float, float] | None:
        """Where it is (None: nowhere in particular)."""
        ...

    @property
    def time_s(self) -> float | None:
        """When it is (None: at no particular time)."""
        ...

    @property
    def value(self) -> float:
        """How much it is."""
        ...

    @property
    def limit(self) -> float:
        """How much is allowed."""
        ...

    @property
    def unit(self) -> str:
        """Of both."""
        ...


class Verdict(Protocol):
    """What the search reads of the verdict on a plan."""

    @property
    def verdict(self) -> str:
        """Whether every demand is "met"."""
        ...

    @property
    def demands(self) -> tuple[DemandOutcome, ...]:
        """One outcome per demand."""
        ...

    @property
    def violations(self) -> Sequence[Fault]:
        """What is wrong with the routes, and demands that are violated."""
        ...

    @property
    def unmet_points_m(self) -> Floats:
        """Places (n, 2) where the demand is not shown to be met."""
        ...

    @property
    def unmet_demand(self) -> Ints:
        """For each of these places the index of its demand."""
        ...

    @property
    def shown_unmet_m(self) -> Floats:
        """Places (m, 2) where it is shown not to be met."""
        ...

    @property
    def shown_unmet_demand(self) -> Ints:
        """For each of these places the index of its demand."""
        ...


Judge = Callable[[Plan], Verdict]


def robots_in_words(robots: int) -> str:
    """The number of robots, in words."""
    return "1 robot" if robots == 1 else f"{robots} robots"


def worst_demand(verdict: Verdict) -> DemandOutcome | None:
    """The demand that a plan misses most, or comes nearest to missing; None without demands."""
    return max(verdict.demands, key=lambda demand: demand.worst_gap_s / demand.period_s, default=None)


def demand_in_words(demand: DemandOutcome) -> str:
    """What a demand is about, in words: the area, or a zone by its name."""
    return "the area" if demand.name == AREA else repr(demand.name)


def never_seen(verdict: Verdict) -> int | None:
    """The index of the demand that a plan misses most, if some of its ground is shown never to be seen; else None."""
    worst = worst_demand(verdict)
    if worst is None or not math.isinf(worst.worst_gap_at_least_s):
        return None
    return next(k for k, demand in enumerate(verdict.demands) if demand is worst)


def worst_fault(verdict: Verdict) -> str:
    """Of what is wrong with the routes themselves that which is most beyond what is allowed, where, and of whom."""
    fault = max(verdict.violations, key=lambda fault: abs(fault.value - fault.limit), default=None)
    if fault is None:
        return "the check finds the routes themselves at fault"
    place = "" if fault.place_m is None else f" at ({fault.place_m[0]:.6g}, {fault.place_m[1]:.6g})"
    return f"{fault.who}: {fault.kind}{place}: {fault.value:.6g} {fault.unit}, allowed {fault.limit:.6g} {fault.unit}"


def worst_reached(verdict: Verdict) -> str:
    """The demand that a plan misses most, and by how much."""
    worst = worst_demand(verdict)
    if worst is None or worst.worst_gap_s <= worst.period_s:
        told = touching(verdict) or standing(verdict) or crowding(verdict) or excess_of_unseeable(verdict)
        return told or worst_fault(verdict)
    what, period_s = demand_in_words(worst), worst.period_s
    if math.isinf(worst.worst_gap_at_least_s):
        return f"some of {what} is never seen"
    if worst.worst_gap_at_least_s > period_s:
        gap_s = worst.worst_gap_at_least_s
        return f"in {what} the worst gap is {gap_s:.6g} s, {gap_s / period_s:.3f} times its period"
    return f"in {what} it is not proven that every gap is within its period of {period_s:.6g} s"


def excess_of_unseeable(verdict: Verdict) -> str | None:
    """How much more ground nobody can see than a plan may leave out; None when it is not more."""
    for fault in verdict.violations:
        if fault.kind == "unseeable":
            return f"nobody can see {fault.value:.6g} m2 of what is asked, and {fault.limit:.6g} m2 may be left out"
    return None


def crowding(verdict: Verdict) -> str | None:
    """Which charger has more robots at once than places; None when none has."""
    for fault in verdict.violations:
        if fault.kind == "charger too full":
            name, places = fault.who.split(":")[0], f"{fault.limit:.0f} place{'s'[: fault.limit != 1]}"
            return f"charger {name!r} has {places}, and {fault.value:.0f} robots are there at once: give it more places"
    return None


def standing(verdict: Verdict) -> str | None:
    """Where a robot would stand that cannot; None when none does."""
    for fault in verdict.violations:
        if fault.kind == "stands though it cannot" and fault.place_m is not None:
            x, y = fault.place_m
            return f"{fault.who} would stand at ({x:.6g}, {y:.6g}), where its standing_endurance_s is 0"
    return None


def touching(verdict: Verdict) -> str | None:
    """Which robots come nearest to each other, of all whose bodies touch, where and when; None when no bodies touch."""
    pairs = [fault for fault in verdict.violations if fault.kind == "bodies touch"]
    if not pairs:
        return None
    worst = min(pairs, key=lambda fault: fault.value / fault.limit)
    where = "" if worst.place_m is None else f" at ({worst.place_m[0]:.2f}, {worst.place_m[1]:.2f})"
    when = "" if worst.time_s is None else f", t = {worst.time_s:.2f} s"
    more = "" if len(pairs) == 1 else f"; {len(pairs) - 1} more pair{'s'[: len(pairs) > 2]} touch"
    return (
        f"no way was found to keep bodies apart: {' and '.join(worst.who.split(', '))} come within {worst.value:.3f} m"
        f"{where}{when}, where {worst.limit:.3f} m between their centres are needed{more}"
    )


def unmet_reason(plan: Plan, verdict: Verdict) -> str:
    """Why the best plan is none: the demand that it misses most, by how much, and the proved bound."""
    robots = robots_in_words(len(plan.trajectories))
    return (
        f"the best plan found, with {robots}, does not meet the demand: {worst_reached(verdict)};"
        f" proved: at least {robots_in_words(plan.lower_bound_robots or 0)}: {plan.lower_bound_reason}"
    )
