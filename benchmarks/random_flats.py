"""Random flats of 3 to 6 rooms with doors and furniture, where three robots that bounce visit three zones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import shapely
from shapely import Polygon, box

from benchmarks.bounce_joint_maps import cpu_s
from benchmarks.row import Options, Row
from rota.check import check_plan
from rota.errors import MissionError, NoPlanFound
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.model.plan import Plan
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planning.make_plan import search_plan

FLATS = 20
PURPOSES = ("periods", "worst_gap", "basin")
ANGLES_DEG = (135.0, 90.0, 45.0)
WALL_M, DOOR_M, PERIOD_S = 0.1, 0.9, 900.0
Room = tuple[float, float, float, float]


def random_flat(seed: int, purpose: str) -> Mission:
    """A flat of 8 to 12 m by 6 to 9 m, cut into rooms by walls with a door each; a zone in each of three rooms."""
    rng = np.random.default_rng(seed)
    wide_m, deep_m = (round(float(rng.uniform(*span)), 1) for span in ((8, 12), (6, 9)))
    rooms: list[Room] = [(0.0, 0.0, wide_m, deep_m)]
    walls: list[Polygon] = []
    for _ in range(int(rng.integers(2, 6))):
        rooms.sort(key=lambda room: -(room[2] - room[0]) * (room[3] - room[1]))
        x0, y0, x1, y1 = rooms.pop(0)
        upright = x1 - x0 > y1 - y0
        low, high, begin, end = (x0, x1, y0, y1) if upright else (y0, y1, x0, x1)
        at = round(low + float(rng.uniform(0.4, 0.6)) * (high - low), 1)
        door = round(float(rng.uniform(begin + 0.3, end - 0.3 - DOOR_M)), 1)
        for first, last in ((begin, door), (door + DOOR_M, end)):
            walls.append(box(at, first, at + WALL_M, last) if upright else box(first, at, last, at + WALL_M))
        rooms += (
            [(x0, y0, at, y1), (at + WALL_M, y0, x1, y1)] if upright else [(x0, y0, x1, at), (x0, at + WALL_M, x1, y1)]
        )
    return _mission(seed, purpose, (wide_m, deep_m), rooms, shapely.union_all(walls), rng)


def _mission(
    seed: int, purpose: str, size_m: tuple[float, float], rooms: list[Room], walls: object, rng: np.random.Generator
) -> Mission:
    """The mission in these rooms."""
    one = Fleet(speed_m_s=0.3, sensor=DiscSensor(radius_m=0.3), body_radius_m=0.17, turn_rate_rad_s=1.7)
    zones = []
    for k in rng.choice(len(rooms), 3, replace=False).tolist():
        x0, y0, x1, y1 = rooms[k]
        zones.append(Zone(name=f"room{k}", shape=box(x0, y0, x1, y1), period_s=PERIOD_S, demand="visit"))
    return Mission(
        name=f"flat{seed}",
        area=box(0, 0, *size_m),
        obstacles=(Obstacle(shape=walls),),  # type: ignore[arg-type]
        zones=tuple(zones),
        fleet=replace(one, robots=tuple(one.equal_robot(f"robot-{k + 1}") for k in range(3))),
        planning=BounceSettings(
            cell_m=0.3,
            bouncing_angles_deg=(float(rng.choice(ANGLES_DEG)),),
            purpose=purpose,  # type: ignore[arg-type]
        ),
    )


def bounce_flats(options: Options) -> Iterator[Row]:
    """Twenty random flats, three robots, each purpose: no plan that the check refuses."""
    outcomes: Counter[str] = Counter()

    def plan_all() -> None:
        for purpose in PURPOSES:
            for seed in range(FLATS):
                outcomes[_outcome(random_flat(seed, purpose))] += 1

    taken_s = cpu_s(plan_all)
    refused = outcomes["refused by the check"]
    told = ", ".join(f"{count} {outcome}" for outcome, count in sorted(outcomes.items()))
    asked = f"0 of {FLATS * len(PURPOSES)} refused by the check"
    name = f"bounce, {FLATS} random flats of 3 to 6 rooms, 3 robots, {len(PURPOSES)} purposes"
    yield Row(name, asked, f"{refused} refused; {told}; {taken_s / sum(outcomes.values()):.1f} s each", refused == 0)


def _outcome(mission: Mission) -> str:
    """What became of a mission, in a few words."""
    try:
        search_plan(mission)
    except MissionError:
        return "without a cycle through each room"
    except NoPlanFound as failure:
        if not isinstance(failure.best, Plan):
            return "without a team"
        return "refused by the check" if check_plan(failure.best).violations else "too late"
    return "met"
