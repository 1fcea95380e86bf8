"""``bouncing_angles_deg: any``: plans with each angle that robots may turn by, the best of them, and which work."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from rota.errors import MissionError, NoPlanFound
from rota.model.plan import Plan
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planners.bounce.rattles import rattling_robots
from rota.planners.bounce.robust_team import most_robust
from rota.planning.planner import Answer, Request

IN_PLANE_DEG = (60.0, 80.0, 90.0, 100.0, 112.5, 120.0, 135.0, 140.0, 150.0)


@dataclass(frozen=True, kw_only=True)
class _Tried:
    """What an angle came to: an answer with its worst ratio, and its robots on rattles; or why there is none."""

    angle_deg: float
    answer: Answer | None = None
    ratio: float = 0.0
    why: str = ""

    @property
    def rattles(self) -> int:
        """How many robots rattle."""
        return 0 if self.answer is None else len(rattling_robots(self.answer.plan))

    @property
    def worth(self) -> tuple[int, int, float]:
        """Robots, rattles among them, and for what is covered once the time; the least is best."""
        assert self.answer is not None
        plan = self.answer.plan
        covers = BounceSettings.of(plan.mission).task == "cover"
        rattles = 0 if BounceSettings.of(plan.mission).purpose == "robust" else self.rattles
        return len(plan.trajectories), rattles, max(t.times_s[-1] for t in plan) if covers else 0.0


def angles_to_try(settings: BounceSettings) -> tuple[float, ...]:
    """The bouncing angles in degrees: all of a grid's, or some without a grid."""
    if settings.cells == "none":
        return IN_PLANE_DEG
    return tuple(360 * k / settings.headings for k in range(1, settings.headings))


def plan_any_angle(request: Request, plan_one: Callable[[Request], Answer]) -> Answer:
    """The best plan of all angles, its mission with that angle, and a sentence on all of them.

    Fewest robots count first, then fewest rattles among them, then the shortest worst gap where the mission asks for
    that; otherwise what is kept when turns are off (``most_robust``), or the time that covering takes. Raises
    NoPlanFound, which names what each angle lacks, where none works.
    """
    settings = BounceSettings.of(request.mission)
    angles = angles_to_try(settings)
    tried: list[_Tried] = []
    for k, angle_deg in enumerate(angles):
        if k and request.should_stop() and any(one.answer for one in tried):
            break

        def tell(share: float, doing: str, k: int = k) -> None:
            request.progress((k + share) / len(angles), f"{angles[k]:g} degrees: {doing}")

        tell(0.0, "planning")
        mission = replace(request.mission, planning=replace(settings, bouncing_angles_deg=(angle_deg,)))
        tried.append(_one(replace(request, mission=mission, progress=tell), angle_deg, plan_one))
    works = [one for one in tried if one.answer is not None]
    if not works:
        reasons = "; ".join(f"{one.angle_deg:g}: {one.why}" for one in tried)
        raise NoPlanFound(f"no bouncing angle works, of {len(tried)} degrees tried: {reasons}")
    best = _best(works, settings, request)
    assert best.answer is not None
    return replace(best.answer, facts=(_sentence(best, tried), *best.answer.facts))


def _one(request: Request, angle_deg: float, plan_one: Callable[[Request], Answer]) -> _Tried:
    """What one angle comes to: its plan counts if the check says that it is met."""
    try:
        answer = plan_one(request)
    except (MissionError, NoPlanFound) as error:
        return _Tried(angle_deg=angle_deg, why=str(error).split("; ")[0])  # without what else might do
    report = request.judge(answer.plan)
    if report.verdict != "met":
        return _Tried(angle_deg=angle_deg, why=f"its worst gap is {report.worst_ratio_at_least:.2f} of its period")
    return _Tried(angle_deg=angle_deg, answer=answer, ratio=report.worst_ratio)


def _best(works: list[_Tried], settings: BounceSettings, request: Request) -> _Tried:
    """The best of the angles that work."""
    least = min(one.worth for one in works)
    best = [one for one in works if one.worth == least]
    if settings.task == "monitor" and settings.purpose == "worst_gap":
        return min(best, key=lambda one: one.ratio)
    plans: list[Plan] = [one.answer.plan for one in best if one.answer is not None]
    return best[most_robust(plans, request)]


def _sentence(best: _Tried, tried: list[_Tried]) -> str:
    """Which angles work, and what those that do not lack."""
    works = ", ".join(
        f"{one.angle_deg:g}" + f" ({one.rattles} rattling)" * (one.rattles > 0) for one in tried if one.answer
    )
    text = f"Robots turn by {best.angle_deg:g} degrees. Of all bouncing angles tried these work: {works}."
    fails = [f"{one.angle_deg:g} ({one.why})" for one in tried if one.answer is None]
    return text + (f" These do not: {', '.join(fails)}." if fails else "")
