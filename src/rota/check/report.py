"""The verdict on a plan: types, and JSON with a published schema."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields, is_dataclass
from html import escape
from typing import TYPE_CHECKING, Any, Literal

from rota.check.arrays import Floats, Ints
from rota.check.holding import Holding
from rota.check.late_report import Lateness
from rota.check.margin_report import Margin
from rota.model.plan import RunEnd
from rota.model.violation_kinds import ViolationKind

if TYPE_CHECKING:
    import pandas

Outcome = Literal["met", "violated", "not proven"]
LISTED_POINTS = 100
MOST_PER_ROBOT = 20  # violations of a kind that are told
APART = "m between centres"


@dataclass(frozen=True, kw_only=True)
class Violation:
    """One thing that is wrong: what (``kind``), who (robots or demand), where, when, and by how much.

    ``value`` is beyond ``limit``, both in ``unit``; ``place_m`` None: nowhere in particular; ``time_s`` None: at no
    particular time (or for ever).
    """

    kind: ViolationKind
    who: str
    place_m: tuple[float, float] | None
    time_s: float | None
    value: float
    limit: float
    unit: str

    def text(self) -> str:
        """One line for people."""
        where = "" if self.place_m is None else f" at ({self.place_m[0]:.3f}, {self.place_m[1]:.3f})"
        when = "" if self.time_s is None else f", t = {self.time_s:.3f} s"
        value = "never" if math.isinf(self.value) else f"{number_text(self.value)} {self.unit}"
        return f"{self.who}: {self.kind}{where}{when}: {value}, allowed {number_text(self.limit)} {self.unit}"


def violation(
    kind: ViolationKind,
    who: str,
    place_m: Sequence[float] | Floats | None,
    time_s: float | None,
    value: float,
    limit: float,
    unit: str,
) -> Violation:
    """A violation, from numbers of numpy or Python; counts stay whole numbers."""
    return Violation(
        kind=kind,
        who=who,
        place_m=None if place_m is None else (float(place_m[0]), float(place_m[1])),
        time_s=None if time_s is None else float(time_s),
        value=value if isinstance(value, int) else float(value),
        limit=limit if isinstance(limit, int) else float(limit),
        unit=unit,
    )


def few_of_each_kind(violations: Iterable[Violation]) -> list[Violation]:
    """The first ``MOST_PER_ROBOT`` of each kind, in their order."""
    counted: Counter[str] = Counter()
    few = []
    for one in violations:
        counted[one.kind] += 1
        if counted[one.kind] <= MOST_PER_ROBOT:
            few.append(one)
    return few


@dataclass(frozen=True, kw_only=True)
class DemandVerdict:
    """What became of one demand. Gaps in seconds (inf: some of it is never seen), areas in square metres.

    No point waits longer than ``worst_gap_s``; some point waits at least ``worst_gap_at_least_s``. ``excluded_places``
    are (x, y, area) of the largest parts that nobody can see. ``undecided_cells``: pieces shown neither met nor unmet.
    """

    name: str
    period_s: float
    demand: Literal["every_point", "visit"]
    area_m2: float
    worst_gap_s: float
    worst_gap_at_least_s: float
    unseen_area_m2: float
    excluded_area_m2: float
    excluded_places: tuple[tuple[float, float, float], ...]
    undecided_cells: int
    outcome: Outcome


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Report:
    """The independent verdict on a plan: "met" only when every demand is shown met and nothing is violated.

    ``holds_from_s``: all robots are in their loops from then on, and what is met is met in every period that begins
    later; of a recording, from when on it is judged. ``first_coverage_s``: by then all that is demanded has been seen
    once (an upper bound; None: some is never seen).
    ``unmet_points_m`` (n, 2) and ``unmet_demand`` (n,): corners and middle of every piece not shown met, and the
    index of its demand in ``demands``. ``shown_unmet_m`` (m, 2) and ``shown_unmet_demand`` (m,): places that were
    looked at by themselves and are unmet, while some of the pieces may be met all the same. ``run_end``: what the plan
    says of the end of a swarm's run; it is not judged.
    ``holding``: what a swarm has where it holds, and cannot reach; None of other plans.
    ``clock_margin_s``: by how much any two robots' clocks may differ before bodies touch (inf: by anything); None where
    that is not judged, which it is of robots that bounce. ``lower_bound_robots`` is the plan's own claim.
    ``cells_entered``: of a plan that is to cover its floor, how many cells robots enter and how many there are.
    ``not_judged``: what the plan says and the check leaves open, in words. ``lateness``: since the plan took over from
    another one; None where it does not. ``margins``: the thinnest reserves, where ``margins_of`` has been asked.
    """

    verdict: Outcome
    robots: int
    lower_bound_robots: int | None
    demands: tuple[DemandVerdict, ...]
    violations: tuple[Violation, ...]
    first_coverage_s: float | None
    holds_from_s: float
    unmet_points_m: Floats
    unmet_demand: Ints
    shown_unmet_m: Floats
    shown_unmet_demand: Ints
    run_end: RunEnd | None = None
    holding: Holding | None = None
    clock_margin_s: float | None = None
    cells_entered: tuple[int, int] | None = None
    not_judged: tuple[str, ...] = ()
    lateness: Lateness | None = None
    margins: tuple[Margin, ...] = ()

    @property
    def worst_ratio(self) -> float:
        """No gap is longer than so many times its period (inf: not shown of any number); 0 when nothing is asked."""
        return max((d.worst_gap_s / d.period_s for d in self.demands), default=0.0)

    @property
    def worst_ratio_at_least(self) -> float:
        """Some gap is at least so many times its period (inf: something is never seen); 0 when nothing is asked."""
        return max((d.worst_gap_at_least_s / d.period_s for d in self.demands), default=0.0)

    def __repr__(self) -> str:
        worst = f", worst gap {self.worst_ratio:.3f} of its period" if self.demands else ""
        return f"<Report {self.verdict}: {self.robots} robots{worst}, {len(self.violations)} violations>"

    def _repr_html_(self) -> str:
        gaps = [
            f"{d.name}: {d.outcome}, worst gap {number_text(d.worst_gap_s)}, period {number_text(d.period_s)} s"
            for d in self.demands
        ]
        lines = [repr(self)[1:-1], *gaps, *(violation.text() for violation in self.violations)]
        return f"<pre>{escape(chr(10).join(lines))}</pre>"

    def to_dataframe(self) -> pandas.DataFrame:
        """The demands as a pandas table, a row for each ``DemandVerdict``; ImportError without pandas."""
        import pandas

        return pandas.DataFrame([asdict(demand) for demand in self.demands])


def report_to_json(report: Report) -> dict[str, Any]:
    """The report as JSON values, by ``report_schema``: null for "never" and at most 100 unmet points."""
    holding, unmet = report.holding, zip(report.unmet_points_m, report.unmet_demand, strict=True)
    return {
        "rota_report": 1,
        "verdict": report.verdict,
        "robots": report.robots,
        "lower_bound_robots": report.lower_bound_robots,
        "cells": None
        if report.cells_entered is None
        else dict(zip(("entered", "of"), report.cells_entered, strict=True)),
        "not_judged": list(report.not_judged),
        "first_coverage_s": report.first_coverage_s,
        "holds_from_s": report.holds_from_s,
        "run_end": _plain(report.run_end),
        "holding": None if holding is None else _plain(holding) | {"unreached": _parts_to_json(holding.unreached)},
        "lateness": _plain(report.lateness),
        "margins": [_plain(one) | {"share": one.share, "text": one.text()} for one in report.margins],
        "clock_margin_s": _plain(report.clock_margin_s),
        "worst_ratio": _plain(report.worst_ratio),
        "worst_ratio_at_least": _plain(report.worst_ratio_at_least),
        "demands": [_plain(d) | {"excluded_places": _parts_to_json(d.excluded_places)} for d in report.demands],
        "violations": [_plain(one) | {"text": one.text()} for one in report.violations],
        "unmet_points": len(report.unmet_points_m),
        "unmet_points_m": [
            {"x": float(x), "y": float(y), "demand": report.demands[int(k)].name}
            for (x, y), k in itertools.islice(unmet, LISTED_POINTS)
        ],
    }


def _plain(value: Any) -> Any:
    """What a report holds as JSON values: by the names of fields, None, JSON's null, for numbers that JSON has not."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if is_dataclass(value):
        return {item.name: _plain(getattr(value, item.name)) for item in fields(value)}
    return [_plain(part) for part in value] if isinstance(value, tuple) else value


def _parts_to_json(parts: Iterable[tuple[float, float, float]]) -> list[dict[str, float]]:
    """Parts of the ground, by a place in each and its area."""
    return [{"x": x, "y": y, "area_m2": area_m2} for x, y, area_m2 in parts]


def number_text(value: float) -> str:
    """A number as text with three decimals, or nine digits where it is small; never: inf."""
    if math.isinf(value):
        return "never"
    return f"{value:.9g}" if abs(value) < 0.01 else f"{value:.3f}".rstrip("0").rstrip(".")
