"""What is kept of stages and plans that were made: driven, judged by the check, and reduced to what figures need."""

from __future__ import annotations

import numpy as np

from rota.check import check_plan
from rota.compare import MethodOutcome
from rota.draw.gap_map import gap_map
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory
from rota_studies.records import drawn_ways, plan_digest
from rota_studies.sun2019.loops import loops_of
from rota_studies.sun2019.results import Found, Printed, sensors_of, way_of
from rota_studies.sun2019_method.partition import CostedPartition
from rota_studies.sun2019_stages.stages import Stages

LATE_CELLS = 60_000  # half a metre each on Figure 13's map


def printed_of(mission: Mission, stages: Stages, *, seed: int, drawn: bool) -> Printed:
    """What the stages came to, driven and judged; ground in one part."""
    plan = driven(mission, stages, seed=seed)
    report, gaps = check_plan(plan), gap_map(plan, cells=LATE_CELLS)
    deployment, (part,), (partition,) = stages.framed.deployment, stages.framed.parts, stages.partitions
    assert isinstance(partition, CostedPartition)
    zone_of = deployment.zone_of[part.sensors]
    along = zone_of[part.frame.order]
    # zones were deployed from the smallest period up: a segment counts for the first of those whose sensors it holds
    of = [deployment.zones[int(along[partition.places(k, len(along))].min())].name for k in range(len(partition.first))]
    return Printed(
        sensors=sensors_of(deployment),
        way=way_of(part.frame, zone_of, len(deployment.zones)),
        partition=partition,
        segment_zones=tuple(of),
        verdict=report.verdict,
        asked_m2=sum(demand.area_m2 for demand in report.demands),
        unseen_m2=sum(demand.unseen_area_m2 for demand in report.demands),
        late_m2=float(gaps.late.sum()) * gaps.cell_map.cell_m**2,
        digest=plan_digest(plan),
        routes=drawn_ways(plan) if drawn else None,
    )


def found_of(outcome: MethodOutcome, *, drawn: bool) -> Found:
    """What is kept of a method's plan."""
    plan = outcome.plan
    return Found(
        met=outcome.met,
        robots=outcome.robots,
        loops_m=outcome.loops_m,
        worst_ratio=outcome.worst_ratio,
        lower_bound_robots=outcome.lower_bound_robots,
        loops=() if plan is None else loops_of(plan),
        digest=None if plan is None else plan_digest(plan),
        reason=outcome.reason,
        ways=drawn_ways(plan) if drawn and plan is not None else None,
    )


def driven(mission: Mission, stages: Stages, *, seed: int) -> Plan:
    """The segments' routes driven by a robot each, at full speed and for ever; nothing is mended."""
    trajectories = []
    for k, segment in enumerate(stages.segments):
        ring_m = np.vstack([segment.route_m, segment.route_m[:1]])
        legs_m = np.hypot(*np.diff(ring_m, axis=0).T)
        moved = np.append(True, legs_m > 0)
        times_s = np.append(0.0, np.cumsum(legs_m))[moved] / mission.fleet.speed_m_s
        trajectories.append(Trajectory(robot=f"robot-{k + 1}", times_s=times_s, positions_m=ring_m[moved]))
    return Plan(mission=mission, trajectories=tuple(trajectories), seed=seed)
