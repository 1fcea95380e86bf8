"""Fleets of several kinds of robots: what they cost, beside the best single kind."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from shapely import MultiPolygon, box

from benchmarks.row import Options, Row
from rota import DiscSensor, Fleet, Kind, Mission, PatrolSettings, Zone, make_plan
from rota.check import check_plan
from rota.check.report import Report
from rota.files.mission_file import read_mission
from rota.model.plan import Plan
from rota.planning.make_plan import search_plan

FARM = Path(__file__).parents[1] / "examples" / "farm.yaml"
MISSIONS = 12


def kinds(_: Options) -> Iterator[Row]:
    """The farm, and random fields with two kinds of robots."""
    plan = make_plan(read_mission(FARM).mission.with_effort("quick"))
    bound = plan.lower_bound_cost or 0.0
    yield Row("the farm: quads at 1, wings at 3", "no cost asked", f"{cost_of(plan):g} (bound {bound:g})", None)
    yield farm_at_normal_row()
    yield mixed_row()


def farm_at_normal_row() -> Row:
    """Seconds of processor time until the farm has its first plan at effort normal, and until it has its last."""
    began_s, first_s = time.process_time(), list[float]()

    def note(_: Plan, report: Report) -> None:
        if report.verdict == "met":
            first_s.append(time.process_time() - began_s)

    search_plan(read_mission(FARM).mission.with_effort("normal"), on_better=note)
    told = f"first plan after {first_s[0]:.1f} s, the last after {time.process_time() - began_s:.0f} s"
    return Row("the farm at effort normal", "first plan in 5 s", told, first_s[0] <= 5.0)


def mixed_row() -> Row:
    """Mixed fleets beside the cheapest fleet of one kind alone, and the bound."""
    mixed = alone = bound = 0.0
    met = better = 0
    for seed in range(MISSIONS):
        mission = field(seed)
        plan = make_plan(mission)
        met += check_plan(plan).verdict == "met"
        single = min(cost_of(make_plan(with_kinds(mission, kind))) for kind in mission.fleet.kinds)
        mixed, alone, bound = mixed + cost_of(plan), alone + single, bound + (plan.lower_bound_cost or 0.0)
        better += cost_of(plan) < single * (1 - 1e-9)
    measured = (
        f"{met} met; cost {mixed:.1f} in sum, one kind alone {alone:.1f}, bound {bound:.1f}; cheaper on {better} of"
        f" {MISSIONS}"
    )
    return Row(f"{MISSIONS} random fields, two kinds of robots", "never dearer than one kind", measured, mixed <= alone)


def cost_of(plan: Plan) -> float:
    """What a plan's robots cost."""
    return sum(plan.mission.fleet.kind_of(way.robot).cost for way in plan)


def field(seed: int) -> Mission:
    """A field with up to two urgent zones, and two kinds of robots whose costs are about what they see."""
    chance = np.random.default_rng(seed)
    width_m, height_m = chance.uniform(200, 500, 2)
    zones = []
    for k in range(int(chance.integers(0, 3))):
        x, y = chance.uniform(0, width_m - 60), chance.uniform(0, height_m - 60)
        shape = MultiPolygon([box(x, y, x + 50, y + 50)])
        zones.append(Zone(name=f"zone {k}", period_s=float(chance.choice([30, 60, 90])), shape=shape))
    better = chance.uniform(1.2, 3, 2)
    slow = Kind(name="slow", cost=1)
    fast = Kind(
        name="fast",
        cost=float(np.prod(better) * chance.uniform(0.7, 1.3)),
        speed_m_s=8 * better[0],
        sensor=DiscSensor(radius_m=15 * better[1]),
    )
    period_s = width_m * height_m / (240 * chance.uniform(1.5, 4))
    mission = Mission(
        name="field",
        area=MultiPolygon([box(0, 0, width_m, height_m)]),
        zones=tuple(zones),
        period_s=period_s,
        fleet=Fleet(speed_m_s=8, sensor=DiscSensor(radius_m=15)),
        planning=PatrolSettings(effort="quick"),
    )
    return with_kinds(mission, slow, fast)


def with_kinds(mission: Mission, *kinds: Kind) -> Mission:
    """The mission with a fleet of these kinds."""
    return replace(mission, fleet=replace(mission.fleet, kinds=kinds))
