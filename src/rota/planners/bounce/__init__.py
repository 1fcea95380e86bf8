"""Robots with a bump sensor and a clock (Alam & Bobadilla, Robotics 9(2):47, 2020, and better)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rota.planners.bounce.planner_settings import BounceSettings
from rota.planning.planner import Answer, Planner, Request

if TYPE_CHECKING:
    from rota.model.mission import Mission
    from rota.model.plan import Plan
    from rota.planning.planner import Report


class BouncePlanner(Planner):
    """The door of the planner bounce; the compiled loops are loaded only when they are needed."""

    settings = BounceSettings

    def plan(self, request: Request) -> Answer:
        """A plan by which bouncing robots monitor the mission's zones, or cover its area; see ``planner``.

        Raises NoPlanFound, with the best there is, when cells stay uncovered or no team watches all zones.
        """
        from rota.planners.bounce.planner import plan_bounce

        if not BounceSettings.of(request.mission).bouncing_angles_deg:
            from rota.planners.bounce.any_angle import plan_any_angle

            return plan_any_angle(request, plan_bounce)
        return plan_bounce(request)

    def sentences(self, answer: Answer, report: Report) -> Iterator[str | None]:
        """The table of robots and loops, what the search found, and what is left of the plan when turns are inexact."""
        from rota.planners.bounce.physics_sentences import clocks_sentence, errors_sentence
        from rota.planners.bounce.sentences import rattling_sentence, swept_sentence
        from rota.planning.plan_summary import approach_sentence, ratio_sentence, robots_table

        plan = answer.plan
        if report.demands:
            yield robots_table(plan)
        yield from answer.facts
        if BounceSettings.of(plan.mission).task == "cover":
            yield swept_sentence(plan)
        else:
            yield from (ratio_sentence(plan, report), rattling_sentence(plan), approach_sentence(plan))
        yield from (clocks_sentence(plan, report), errors_sentence(plan))

    def covering_time(self, plan: Plan) -> str | None:
        """By when simulated robots that turn at every contact have entered all cells, in 10, 50 and 90 % of runs."""
        from rota.planners.bounce.physics_sentences import covering_sentence

        return covering_sentence(plan)

    def compiled_packages(self, mission: Mission) -> tuple[str, ...]:
        """Cells, cycles and groups."""
        return ("planners/bounce",)

    def small_mission(self) -> Mission:
        """Two robots that watch a door and a window."""
        import shapely

        from rota.model.mission import DiscSensor, Fleet, Mission, Robot, Zone

        sensor = DiscSensor(radius_m=0.25)
        robots = tuple(
            Robot(name=f"robot-{k}", speed_m_s=0.2, sensor=sensor, body_radius_m=0.17, turn_rate_rad_s=1.5)
            for k in range(2)
        )
        door, window = (shapely.MultiPolygon([shapely.box(*b)]) for b in ((0, 2.5, 1, 3), (3, 0, 4, 0.5)))
        return Mission(
            name="room",
            area=shapely.MultiPolygon([shapely.box(0, 0, 5, 3.5)]),
            zones=(
                Zone(name="door", shape=door, period_s=240, demand="visit"),
                Zone(name="window", shape=window, period_s=220, demand="visit"),
            ),
            period_s=None,
            fleet=Fleet(speed_m_s=0.2, sensor=sensor, body_radius_m=0.17, turn_rate_rad_s=1.5, robots=robots),
            planning=BounceSettings(cell_m=0.5, bouncing_angles_deg=(135.0,)),
        )
