"""Missions built round a plan that is known to meet them, so that a proved bound above its robots would be false.

Loops are drawn first, then zones on the ground that they see; periods are the gaps that the check measures.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon, affinity, box

from benchmarks.random_missions import between, ground, obstacles, star, to_centimetres
from benchmarks.row import Options, Row
from rota.check import check_plan
from rota.errors import RotaError
from rota.geometry.free_space import standing_space
from rota.geometry.shortest_path import ShortestPaths
from rota.model.mission import DiscSensor, Fleet, Mission, Sensor, SquareSensor, Zone
from rota.model.plan import Plan, Trajectory
from rota.planners.patrol.bounds.best_bound import prove_bound
from rota.planners.patrol.ground.problem import set_up_problem
from rota.planners.patrol.planner_settings import PatrolSettings

Floats = NDArray[np.float64]

DRAWS = 200  # of one seed, until some zone is seen again and again
LOOSER = 1 + 1e-6  # times the measured gap: a period that the check passes
SHORTEST_S = 0.05  # a period where a robot stands and looks for ever
LEAST_WAY = 0.2  # of a sight's reach: a shorter loop is none


def known_plan(seed: int) -> Plan:
    """A plan whose mission it meets by the check, always the same; RuntimeError when none was drawn."""
    rng = np.random.default_rng(seed)
    for _ in range(DRAWS):
        try:
            drawn = _drawn(rng, f"known-{seed}")
            plan = None if drawn is None else _tightened(drawn)
        except RotaError:  # a zone beside the ground, say
            continue
        if plan is not None and check_plan(plan).verdict == "met":
            return plan
    raise RuntimeError(f"seed {seed}: no plan in {DRAWS} draws")


def known_turning_plan(seed: int) -> Plan | None:
    """The same plan with robots that stop to turn on the spot, and the longer periods that it then meets.

    None where the check does not pass it, since robots no longer keep apart, say.
    """
    plan = known_plan(seed)
    rate_rad_s = between(np.random.default_rng(seed), 0.1, 4)
    fleet = replace(plan.mission.fleet, turn_rate_rad_s=rate_rad_s)
    slower = [_stopping(trajectory, rate_rad_s) for trajectory in plan.trajectories]
    plan = replace(plan, mission=replace(plan.mission, fleet=fleet), trajectories=tuple(slower))
    tightened = _tightened(plan)
    return tightened if tightened is not None and check_plan(tightened).verdict == "met" else None


def _stopping(trajectory: Trajectory, rate_rad_s: float) -> Trajectory:
    """A closed way, driven at full speed between corners, with a stop at each for as long as turning takes."""
    if len(trajectory.times_s) < 3:
        return trajectory
    legs = np.diff(trajectory.positions_m, axis=0)
    headings = np.arctan2(legs[:, 1], legs[:, 0])
    turns = np.abs((np.diff(headings, append=headings[:1]) + np.pi) % (2 * np.pi) - np.pi)  # at the end of each leg
    stops_s = turns / rate_rad_s / (1 - 1e-9)
    arrives_s = np.cumsum(np.diff(trajectory.times_s)) + np.append(0.0, np.cumsum(stops_s)[:-1])
    times_s = np.append(0.0, np.column_stack([arrives_s, arrives_s + stops_s]).ravel())
    positions_m = np.vstack([trajectory.positions_m[:1], np.repeat(trajectory.positions_m[1:], 2, axis=0)])
    kept = np.append(True, np.diff(times_s) > 1e-9)
    return Trajectory(robot=trajectory.robot, times_s=times_s[kept], positions_m=positions_m[kept])


def _drawn(rng: np.random.Generator, name: str) -> Plan | None:
    """Loops and zones beside them, whose periods are far too long; None where no loop found room."""
    area, reach_m, speed_m_s = ground(rng), between(rng, 2, 8), between(rng, 0.5, 8)
    body_m = between(rng, 0.05, 0.3) if rng.random() < 0.3 else 0.0
    disc = rng.random() < 0.7
    sensor: Sensor = DiscSensor(radius_m=reach_m) if disc else SquareSensor(side_m=round(1.6 * reach_m, 2))
    fleet = Fleet(speed_m_s=speed_m_s, sensor=sensor, body_radius_m=body_m)
    mission = Mission(
        name=name,
        area=area,
        obstacles=obstacles(rng, area, clear_m=max(0.5, 6 * body_m)),
        zones=(Zone(name="all", shape=area, period_s=None),),
        period_s=1e6,
        fleet=fleet,
        planning=PatrolSettings(effort="quick"),
    )
    paths = ShortestPaths(standing_space(mission, body_m))
    trajectories: list[Trajectory] = []
    for _ in range(int(rng.integers(1, 4))):
        trajectories += _one_loop(rng, paths, reach_m, speed_m_s, len(trajectories))
    if not trajectories:
        return None
    zones = [_zone(rng, trajectories, reach_m, k) for k in range(int(rng.integers(1, 5)))]
    # the area asks nothing itself: seldom do so few loops see all of it
    mission = replace(mission, zones=tuple(zones), period_s=1e6 if rng.random() < 0.2 else None)
    return Plan(mission=mission, trajectories=tuple(trajectories))


def _one_loop(
    rng: np.random.Generator, paths: ShortestPaths, reach_m: float, speed_m_s: float, before: int
) -> list[Trajectory]:
    """One to three robots evenly spaced on a closed way past some places, or one that stands."""
    low, high = (
        np.min([part.bounds[:2] for part in paths.parts], axis=0),
        np.max([part.bounds[2:] for part in paths.parts], axis=0),
    )
    places = rng.uniform(low, high, (200, 2))
    parts = paths.part_of(places)
    inside = places[parts == parts[parts >= 0][0]] if (parts >= 0).any() else places[:0]
    if not len(inside):
        return []
    if rng.random() < 0.3 or len(inside) < 3:
        return [Trajectory(robot=f"robot-{before + 1}", times_s=[0.0], positions_m=inside[:1])]
    # places near each other now and then: short loops have short periods
    some = inside[np.argsort(np.hypot(*(inside - inside[0]).T))[: int(rng.integers(3, 40))]]
    corners = some[rng.permutation(len(some))[: int(rng.integers(2, 6))]]
    ring = paths.paths_along(np.vstack([corners, corners[:1]]))
    long_m = float(np.hypot(*np.diff(ring, axis=0).T).sum())
    if long_m < LEAST_WAY * reach_m:
        return []
    robots = int(rng.integers(1, 4))
    return [_on_the_way(ring, k * long_m / robots, speed_m_s, f"robot-{before + k + 1}") for k in range(robots)]


def _on_the_way(ring: Floats, begin_m: float, speed_m_s: float, robot: str) -> Trajectory:
    """A robot that drives round a closed ring (n, 2) at full speed, beginning so many metres along it."""
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(ring, axis=0).T)))
    at = np.unique(np.append((along - begin_m) % along[-1], 0.0))
    at = np.append(at[np.append(True, np.diff(at) > 1e-9)], along[-1])
    where = (at + begin_m) % along[-1]
    positions = np.column_stack([np.interp(where, along, ring[:, axis]) for axis in (0, 1)])
    positions[-1] = positions[0]
    return Trajectory(robot=robot, times_s=at / speed_m_s / (1 - 1e-9), positions_m=positions)


def _zone(rng: np.random.Generator, trajectories: list[Trajectory], reach_m: float, k: int) -> Zone:
    """A zone on a way or beside it, from a centimetre to twice the reach across."""
    one = trajectories[int(rng.integers(len(trajectories)))]
    x, y = one.positions_m[int(rng.integers(len(one.positions_m)))]
    visit = rng.random() < 0.25
    across_m = round(float(reach_m * 10 ** rng.uniform(-2.5, 0.3)), 2) + 0.01
    apart_m = 0.0 if visit else rng.uniform(0, 0.8) * reach_m
    angle = rng.uniform(0, 2 * np.pi)
    shape: Polygon = box(0, 0, across_m, across_m) if rng.random() < 0.5 else star(rng, 5, 0.4 * across_m, across_m)
    shape = affinity.translate(shape, x + apart_m * np.cos(angle), y + apart_m * np.sin(angle))
    if visit:  # the way leads through its middle
        shape = affinity.translate(shape, x - shape.centroid.x, y - shape.centroid.y)
    demand = "visit" if visit else "every_point"
    return Zone(name=f"zone-{k + 1}", shape=MultiPolygon([to_centimetres(shape)]), period_s=1e6, demand=demand)


def _tightened(plan: Plan) -> Plan | None:
    """The plan of a mission with periods as short as it keeps them; None where it sees nothing again and again."""
    mission = plan.mission
    # each zone alone: in one mission, ground in several of them is asked for but once
    gaps_s = {
        zone.name: _gap_s(replace(plan, mission=replace(mission, zones=(zone,), period_s=None)))
        for zone in mission.zones
    }
    if mission.period_s is not None:
        gaps_s["area"] = _gap_s(replace(plan, mission=replace(mission, zones=())))
    kept = {name: max(SHORTEST_S, LOOSER * gap_s) for name, gap_s in gaps_s.items() if np.isfinite(gap_s)}
    zones = tuple(replace(zone, period_s=kept[zone.name]) for zone in mission.zones if zone.name in kept)
    if not kept:
        return None
    return replace(plan, mission=replace(mission, zones=zones, period_s=kept.get("area")))


def _gap_s(plan: Plan) -> float:
    """The longest time that the only demand of a plan's mission waits, proved."""
    return max((demand.worst_gap_s for demand in check_plan(plan).demands), default=np.inf)


def bound_of(plan: Plan) -> int:
    """The proved lower bound for the plan's mission."""
    return prove_bound(set_up_problem(plan.mission)).robots


def known_plans(options: Options) -> Iterator[Row]:
    """A row for each bound that is above its known plan, and one for all."""
    above: Counter[int] = Counter()
    began_s = time.process_time()
    seeds = range(options.first_seed, options.first_seed + options.missions)
    drawn = ((seed, plan) for seed in seeds for plan in (known_plan(seed), known_turning_plan(seed)))
    for seed, plan in drawn:
        if plan is None:
            continue
        robots, bound = len(plan.trajectories), bound_of(plan)
        above[robots - bound] += 1
        if bound > robots:
            measured = f"{robots} robots meet it, bound {bound}"
            yield Row(f"mission {seed} round a known plan", "bound at most the plan's robots", measured, False)
    told = ", ".join(f"{count} at +{robots}" for robots, count in sorted(above.items()))
    name = f"proved bounds of {above.total():,} missions round known plans, seeds {seeds[0]} to {seeds[-1]}"
    measured = f"{told} (robots of the plan beyond the bound); CPU {time.process_time() - began_s:.0f} s"
    yield Row(name, "none above the plan's robots", measured, min(above) >= 0)
