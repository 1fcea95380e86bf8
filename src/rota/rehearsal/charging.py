"""What became of batteries and chargers in one run, and in all of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from rota.check.tolerances import BATTERY_S
from rota.model.arrays import Flags, Floats
from rota.rehearsal.drive_kernels import Fills
from rota.rehearsal.estimates import Estimate, mean_over_runs, share_of_runs
from rota.rehearsal.kernels import Driven
from rota.rehearsal.scene import Scene

ROWS = ("stays_s", "stays", "noted", "stay")  # of what is told of batteries, all that is told of stays
HELD_S = 1.0  # so long a charger may have too many robots: by less one that leaves may be behind the clock of all


class Crowd(NamedTuple):
    """That more robots were at a charger than it has places for."""

    charger: int
    time_s: float
    robots: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Charging:
    """What became of batteries and chargers in a run; arrays are (k,), a value for each robot.

    least_s, least_at_s: the least that was left of each battery, seconds of driving, and when; inf: it has no limit.
    hurries_s, hurries_at_s: by how much it was ahead of all at most, since its battery did not let it wait, and when.
    reliefs: how often robots left a charger. crowd: the first time that a charger had too many; None: never.
    """

    least_s: Floats
    least_at_s: Floats
    hurries_s: Floats
    hurries_at_s: Floats
    reliefs: int
    crowd: Crowd | None


@dataclass(frozen=True, kw_only=True, eq=False)
class BatteryOutcome:
    """The battery of one robot over all runs, in seconds of driving.

    levels_s: (runs,) the least that was left in each run; least_s: its mean. below: the share of runs in which it fell
    below the reserve. worst_s: the least of all runs, in run worst_run after worst_at_s.
    """

    robot: str
    reserve_s: float
    endurance_s: float
    levels_s: Floats
    least_s: Estimate
    below: Estimate
    worst_s: float
    worst_run: int
    worst_at_s: float


@dataclass(frozen=True, kw_only=True, eq=False)
class ChargingOutcome:
    """Batteries, reliefs and chargers over all runs.

    spare_s: the least that any battery had beyond its reserve in a run, its mean. below: the share of runs in which one
    fell below its reserve; robots drive on in the rehearsal as if it had not. hurried: in which a robot could not wait
    any longer for those that were late. crowded: in which a charger had more robots than places. first_hurry,
    first_crowd: of the first such run who, when and what, in words; None where there is none. reliefs: how often robots
    left a charger in a run.
    """

    robots: tuple[BatteryOutcome, ...]
    spare_s: Estimate | None
    below: Estimate
    hurried: Estimate
    crowded: Estimate
    reliefs: Estimate
    first_hurry: str | None
    first_crowd: str | None


def full_batteries(scene: Scene) -> Fills:
    """All batteries full, less a take-off where plans begin in the air, and robots at the beginning of their plans."""
    ways, batteries = scene.plan.trajectories, scene.batteries
    levels_s = batteries.endurance_s - batteries.takeoff_s * (batteries.docks[batteries.firsts[:-1]] < 0)
    count, most = len(ways), sum(scene.most_charges(way) for way in ways)

    def zeros() -> Floats:
        return np.zeros(count)

    return Fills(
        leg=batteries.firsts[:-1].copy(), turned_s=zeros(), levels_s=levels_s, stood_s=zeros(),
        least_s=levels_s.copy(), least_at_s=zeros(), stay=np.full(count, -1), stays_s=np.empty((most, 2)),
        stays=np.empty((most, 2), np.int64), noted=np.zeros(1, np.int64), left=np.zeros(count, np.int64),
        hurries_s=zeros(), hurries_at_s=zeros(),
    )  # fmt: skip


def copy_of(fills: Fills) -> Fills:
    """The same, which can be changed."""
    copies: dict[str, Any] = {name: each.copy() for name, each in fills._asdict().items()}
    return Fills(**copies)


def each_at_its_own(fills: Sequence[Fills]) -> Fills:
    """How the battery of robot k is by fills[k], and all its stays until then."""
    robots = range(len(fills))
    rows = [np.flatnonzero(own.stays[: own.noted[0], 0] == k) for k, own in enumerate(fills)]
    firsts = np.concatenate([[0], np.cumsum([len(own) for own in rows])])
    joined = {
        name: np.array([getattr(fills[k], name)[k] for k in robots]) for name in Fills._fields if name not in ROWS
    }
    joined["stay"] = np.array([firsts[k + 1] - 1 if fills[k].stay[k] >= 0 else -1 for k in robots])
    return Fills(
        stays_s=np.concatenate([fills[k].stays_s[rows[k]] for k in robots]),
        stays=np.concatenate([fills[k].stays[rows[k]] for k in robots]),
        noted=firsts[-1:].copy(),
        **joined,
    )


def go_on_with(fills: Fills, scene: Scene) -> Fills:
    """The same batteries where robots go over to another plan, that of the scene, at its beginning."""
    if not scene.charges:
        return full_batteries(scene)
    most = sum(scene.most_charges(way) for way in scene.plan)
    return fills._replace(
        leg=scene.batteries.firsts[:-1].copy(),
        turned_s=np.zeros(len(fills.leg)),
        stays_s=np.concatenate([fills.stays_s, np.empty((most, 2))]),
        stays=np.concatenate([fills.stays, np.empty((most, 2), np.int64)]),
    )


def charging_of(scene: Scene, driven: Driven, fills: Fills) -> Charging:
    """What became of batteries and chargers in a run."""
    rows = int(fills.noted[0])
    crowds = [
        crowd
        for k, charger in enumerate(scene.plan.mission.chargers)
        if (crowd := _crowd(k, charger.places, fills.stays_s[:rows][fills.stays[:rows, 1] == k], driven.end_s))
    ]
    return Charging(
        least_s=fills.least_s,
        least_at_s=fills.least_at_s,
        hurries_s=fills.hurries_s,
        hurries_at_s=fills.hurries_at_s,
        reliefs=int(fills.left.sum()),
        crowd=min(crowds, key=lambda each: each.time_s, default=None),
    )


def _crowd(charger: int, places: int, stays_s: Floats, end_s: float) -> Crowd | None:
    """The first moment at which more robots are at a charger than it has places, for longer than ``HELD_S``.

    stays_s: (s, 2) from when until when each is there.
    """
    begins_s, ends_s = stays_s[:, 0], stays_s[:, 1] - HELD_S
    kept = (ends_s > begins_s) & (begins_s < end_s)
    times_s = np.concatenate([begins_s[kept], ends_s[kept]])
    steps = np.repeat([1, -1], np.count_nonzero(kept))
    order = np.lexsort((steps, times_s))
    present = np.cumsum(steps[order])
    if not (present > places).any():
        return None
    first = int(np.argmax(present > places))
    return Crowd(charger, float(times_s[order[first]]), int(present[first]))


def charging_outcome(scene: Scene, made: Sequence[Charging]) -> ChargingOutcome:
    """What batteries and chargers came to in all runs."""
    least_s = np.array([run.least_s for run in made])
    reserve_s, endurance_s = scene.batteries.reserve_s, scene.batteries.endurance_s
    spare_s, known = least_s - reserve_s, np.flatnonzero(np.isfinite(endurance_s))
    below: Flags = spare_s < -BATTERY_S
    hurries: Flags = np.array([run.hurries_s for run in made]) > HELD_S

    def share(runs: Flags) -> Estimate:
        return share_of_runs(int(np.count_nonzero(runs)), len(made))

    return ChargingOutcome(
        robots=tuple(_battery(scene, k, made, share(below[:, k])) for k in known.tolist()),
        spare_s=mean_over_runs(spare_s[:, known].min(axis=1).tolist()) if len(known) else None,
        below=share(np.any(below, axis=1)),
        hurried=share(np.any(hurries, axis=1)),
        crowded=share(np.array([run.crowd is not None for run in made])),
        reliefs=mean_over_runs([float(run.reliefs) for run in made], 0.0),
        first_hurry=_hurry_text(scene, made, hurries),
        first_crowd=_crowd_text(scene, made),
    )


def _battery(scene: Scene, k: int, made: Sequence[Charging], below: Estimate) -> BatteryOutcome:
    """The battery of the k-th robot over all runs."""
    levels_s = [float(run.least_s[k]) for run in made]
    worst = int(np.argmin(levels_s))
    return BatteryOutcome(
        robot=scene.plan.trajectories[k].robot,
        reserve_s=float(scene.batteries.reserve_s[k]),
        endurance_s=float(scene.batteries.endurance_s[k]),
        levels_s=np.array(levels_s),
        least_s=mean_over_runs(levels_s, -math.inf, float(scene.batteries.endurance_s[k])),
        below=below,
        worst_s=levels_s[worst],
        worst_run=worst,
        worst_at_s=float(made[worst].least_at_s[k]),
    )


def _hurry_text(scene: Scene, made: Sequence[Charging], hurries: Flags) -> str | None:
    """Who of the first run in which somebody could not wait any longer went on, and how long before the others."""
    if not hurries.any():
        return None
    number = int(np.argmax(hurries.any(axis=1)))
    run = made[number]
    k = int(np.argmax(run.hurries_s))
    return (
        f"{scene.plan.trajectories[k].robot} is {run.hurries_s[k]:.1f} s ahead of all others after"
        f" {run.hurries_at_s[k]:.1f} s of run {number}"
    )


def _crowd_text(scene: Scene, made: Sequence[Charging]) -> str | None:
    """Which charger of the first run in which one had too many robots had how many, and when."""
    for number, run in enumerate(made):
        if run.crowd is not None:
            charger = scene.plan.mission.chargers[run.crowd.charger]
            return (
                f"{run.crowd.robots} robots are at {charger.name}, which has {charger.places} places, after"
                f" {run.crowd.time_s:.1f} s of run {number}"
            )
    return None
