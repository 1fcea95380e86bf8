"""One robot's loop over the polygons of the lawn-mowing benchmark, beside the shortest tours published with it.

Fekete, Krupke, Perk, Rieck, Scheffer, The Lawn Mowing Problem: From Algebra to Algorithms (ESA 2023): a disc of radius
0.5 passes over every point of a polygon, which its centre may leave. Their tours took integer programs up to 300 s.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import shapely

from benchmarks.missions import DATA
from benchmarks.row import Options, Row
from rota.errors import NoPlanFound
from rota.model.mission import DiscSensor, Fleet, Mission, Zone
from rota.model.polygons import polygons_of
from rota.planners.patrol.planner_settings import PatrolSettings
from rota.planning.make_plan import search_plan

INSTANCES = DATA / "lawn" / "instances.json"
SCALE_M = 10.0  # metres in a unit of length of theirs
RADIUS = 0.5
SPARE = 1.5  # times the published length: what the period leaves; the loop is as short as can be found


class Mown(NamedTuple):
    """A loop over one instance: its length as a share of the shortest published, and processor seconds."""

    kind: str
    ratio: float
    cpu_s: float


def lawn_mowing(options: Options) -> Iterator[Row]:
    """The loops' lengths as shares of the published ones, by kind of polygon, and what they take."""
    name = "lawn mowing, one robot, quick: length / best published"
    if not INSTANCES.is_file():
        yield Row(name, "none above 1.000", "not measured: ../shared/data is missing", None)
        return
    instances = json.loads(INSTANCES.read_text())
    most = min(options.missions, len(instances))
    chosen = [instances[k] for k in np.linspace(0, len(instances) - 1, most).round().astype(int)]
    mown = [one for instance in chosen if (one := mow(instance)) is not None]
    for kind in sorted({one.kind for one in mown}):
        ratios = np.array([one.ratio for one in mown if one.kind == kind])
        measured = f"{ratios.min():.3f} to {ratios.max():.3f}, mean {ratios.mean():.3f}, of {len(ratios)}"
        yield Row(f"{name}, {kind}", "none above 1.000", measured, bool(ratios.max() <= 1))
    ratios, cpu_s = np.array([one.ratio for one in mown]), np.array([one.cpu_s for one in mown])
    above = int((ratios > 1).sum())
    measured = (
        f"mean {ratios.mean():.3f}, {above} above 1.000; {np.median(cpu_s):.0f} s of processor time each (median),"
        f" {cpu_s.max():.0f} s at most; {len(chosen) - len(mown)} without a plan"
    )
    yield Row(f"{name}, {len(chosen)} of {len(instances)} instances", "none above 1.000", measured, above == 0)


def mow(instance: Mapping[str, Any]) -> Mown | None:
    """The loop over one instance; None where no plan passes."""
    mission, began_s = mission_of(instance), time.process_time()
    try:
        plan = search_plan(mission).plan
    except NoPlanFound:
        return None
    cpu_s = time.process_time() - began_s
    (trajectory,) = plan
    driven_m = float(np.hypot(*np.diff(trajectory.positions_m, axis=0).T).sum())
    return Mown(instance["kind"], driven_m / (SCALE_M * instance["best_length"]), cpu_s)


def mission_of(instance: Mapping[str, Any]) -> Mission:
    """The polygon as a zone, with the ground about it that the robot may drive on."""
    ground = polygons_of(shapely.Polygon(*(
        (SCALE_M * np.array(instance["outer"]), [SCALE_M * np.array(hole) for hole in instance["holes"]])
    )))  # fmt: skip
    radius_m = SCALE_M * RADIUS
    period_s = SPARE * SCALE_M * instance["best_length"]
    return Mission(
        name=instance["instance"], area=polygons_of(ground.buffer(radius_m)), period_s=None,
        zones=(Zone(name="lawn", shape=ground, period_s=period_s),),
        fleet=Fleet(robots=1, speed_m_s=1.0, sensor=DiscSensor(radius_m=radius_m)),
        planning=PatrolSettings(effort="quick"),
    )  # fmt: skip
