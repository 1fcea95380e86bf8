"""Robots that sense their neighbours, spread and hold (Chen, Xu, Li, Sensors 18(6):1864, 2018, and better)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rota.errors import MissionError
from rota.planners.swarm.planner_settings import SwarmSettings
from rota.planning.planner import Answer, Planner, Request

if TYPE_CHECKING:
    from rota.model.mission import Mission
    from rota.planning.planner import Report
    from rota.planning.robot_processes import ProcessSettings, RobotProcesses


class SwarmPlanner(Planner):
    """The door of the planner swarm; the compiled loops are loaded only when they are needed."""

    settings = SwarmSettings
    plans_near_origin = True

    def plan(self, request: Request) -> Answer:
        """A plan in which the mission's robots spread and then hold; see ``planner.run_mission``.

        The robots know nothing of demands, so the judge is not asked here: whether what they cover meets one, the check
        finds out afterwards. All cores are used, and the plan is the same on any number of them.
        """
        from rota.engines.workers import cores
        from rota.planners.swarm.planner import run_mission

        if request.observe is not None and request.mission.planning.altitudes_m is not None:
            raise MissionError("swarm.altitudes_m: swarms in space are not measured step by step")
        run = run_mission(
            request.mission,
            seed=request.seed,
            progress=request.progress,
            should_stop=request.should_stop,
            threads=cores(),
            observed=request.observe is not None,
            resume=request.checkpoint,
        )
        if request.observe is not None and run.history is not None:
            request.observe(run.history)
        end = run.plan.run_end
        return Answer(plan=run.plan, checkpoint=run.state if end is not None and end.goes_on else None)

    def sentences(self, answer: Answer, report: Report) -> Iterator[str | None]:
        """When robots hold, or charge in turns, how much they have in range, and the worst gap."""
        from rota.planners.swarm.sentences import covered_sentence, holding_sentence, loop_sentences, reach_sentences
        from rota.planning.plan_summary import ratio_sentence

        yield from answer.facts
        if answer.plan.mission.chargers:
            yield from (*loop_sentences(answer.plan, report), *reach_sentences(answer.plan))
        else:
            yield from (holding_sentence(answer.plan), covered_sentence(answer.plan), *reach_sentences(answer.plan))
        yield ratio_sentence(answer.plan, report)

    def compiled_packages(self, mission: Mission) -> tuple[str, ...]:
        """The controllers."""
        return ("planners/swarm",)

    def small_mission(self) -> Mission:
        """Four robots in a yard with a shed."""
        import shapely

        from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Robot

        sensor = DiscSensor(radius_m=5)
        robots = tuple(
            Robot(name=f"robot-{k}", speed_m_s=1, sensor=sensor, body_radius_m=0.3, start=(2.0 + 1.5 * k, 2.0))
            for k in range(4)
        )
        return Mission(
            name="yard",
            area=shapely.MultiPolygon([shapely.box(0, 0, 20, 20)]),
            obstacles=(Obstacle(shape=shapely.MultiPolygon([shapely.box(8, 8, 12, 12)])),),
            period_s=None,
            fleet=Fleet(speed_m_s=1, sensor=sensor, body_radius_m=0.3, robots=robots),
            planning=SwarmSettings(most_steps=200),
        )

    def robot_processes(self, mission: Mission, settings: ProcessSettings) -> RobotProcesses:
        """The mission's robots as processes of their own, which decide by the controller of the simulation."""
        from rota.planners.swarm.nodes.processes import SwarmProcesses

        return SwarmProcesses(mission, settings)
