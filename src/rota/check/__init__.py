"""The independent verdict on a plan; shares no code with the planners."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from rota.check.margin_report import Margin
from rota.check.report import DemandVerdict, Report, Violation, report_to_json
from rota.check.report_schema import report_schema
from rota.check.report_table import met_text, report_table

if TYPE_CHECKING:
    from rota.check.late_report import ForEver, LateSample
    from rota.model.mission import Mission
    from rota.model.plan import Floats, Plan

__all__ = [
    "DemandVerdict",
    "Margin",
    "Report",
    "Violation",
    "check_plan",
    "compiled_packages",
    "get_ready",
    "load",
    "margins_of",
    "met_text",
    "report_schema",
    "report_table",
    "report_to_json",
    "sample_lateness",
    "sample_loops",
    "violations_on_the_way",
    "worst_gaps_s",
]


def check_plan(plan: Plan, *, finest_m: float = 0.01, on_the_way: Callable[[], None] | None = None) -> Report:
    """The independent verdict on a plan: "met" only when it is shown for every demanded point and for ever.

    finest_m: size in metres below which pieces are not cut any more; what is then still open is "not proven". The
    excluded part (what nobody can see from where a body can stand) is rounded outwards to about that size. A plan
    without trajectories sees nothing. on_the_way: called now and then; what it raises ends the check without a verdict.
    """
    from rota.check.judge import check_plan as judge  # loads the compiled loops only when they are needed
    from rota.compiled.compiled_cache import mention_compiling

    mention_compiling(*compiled_packages(plan.mission))
    return judge(plan, finest_m=finest_m, on_the_way=on_the_way)


def violations_on_the_way(plan: Plan) -> list[Violation]:
    """What ``check_plan`` finds wrong with how robots drive, whatever they see from there: a part of its verdict."""
    from rota.check.judge import violations_on_the_way as found

    return found(plan)


def sample_lateness(plan: Plan, most_points: int = 400) -> LateSample:
    """How late some points of a plan that takes over from another one are, to compare plans with within moments.

    ``check_plan`` judges all ground between them; most_points: of each demand. Only for a plan with a seam.
    """
    from rota.check.late_samples import sample_lateness as sample

    return sample(plan, most_points)


def sample_loops(plan: Plan, most_points: int = 400) -> tuple[ForEver, ...]:
    """What some points say of each demand of a plan for ever, to compare plans with within moments."""
    from rota.check.late_samples import sample_loops as sample

    return sample(plan, most_points)


def compiled_packages(mission: Mission) -> tuple[str, ...]:
    """The package whose loops ``check_plan`` of a mission's plans runs: none where no period asks for every point.

    Of swarms it runs them in any case, to tell what they hold.
    """
    every_point = any(zone.period_s is not None and zone.demand == "every_point" for zone in mission.zones)
    return ("check",) if every_point or mission.period_s is not None or mission.planning.makes_runs else ()


def margins_of(plan: Plan, report: Report) -> tuple[Margin, ...]:
    """The thinnest reserve of each kind of a plan that its report says is met, the thinnest first; of others none.

    How much of a period is left is proved, by the report. Where, and by how much less far robots may see, is what was
    found at some 2,000 places.
    """
    from rota.check.margins import margins_of as margins

    return margins(plan, report)


def worst_gaps_s(plan: Plan, points_m: Floats) -> Floats:
    """The longest time, in seconds, that each point of (n, 2) metres is unseen, once robots are in their loops.

    (n,); inf: never seen. Sight is exact, and so are these at the points; ``check_plan`` judges all between them.
    MissionError for what is no array of such points, all finite.
    """
    import numpy as np

    from rota.check.revisits import worst_gaps_s as gaps_s
    from rota.errors import MissionError

    try:
        places_m = np.ascontiguousarray(points_m, dtype=np.float64)
    except (TypeError, ValueError):
        places_m = np.full(1, np.nan)
    if not (places_m.size == 0 or places_m.shape[1:] == (2,)) or not np.isfinite(places_m).all():
        raise MissionError(f"points_m: {points_m!r} is not allowed; finite numbers in an array of (n, 2) are needed")
    return gaps_s(plan, places_m.reshape(-1, 2))


def load() -> None:
    """Load what ``check_plan`` runs on: in one thread, before others load the same libraries.

    Python fails now and then where one thread loads a package that another one has loaded in part (KeyError).
    """
    import rota.check.judge  # noqa: F401


def get_ready(mission: Mission) -> None:
    """Work out what ``check_plan`` asks of a mission over ragged ground alone, before there is a plan to check.

    Nothing has to call it: the first check is sooner done where somebody has, from a thread of its own.
    """
    from rota.check.tiled_ground import get_ready as ready

    ready(mission)
