"""A plan rehearsed: many runs, side by side."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass

import numpy as np

from rota.engines.placing import answer_of, submit_with
from rota.engines.workers import workers
from rota.errors import MissionError
from rota.model.arrays import Floats, Ints
from rota.model.plan import Plan
from rota.model.refusals import require
from rota.rehearsal import kernels
from rota.rehearsal.charging import Charging, charging_of, charging_outcome
from rota.rehearsal.conditions import MOST_RUNS, Conditions
from rota.rehearsal.contacts import Contact, contacts_of
from rota.rehearsal.estimates import mean_over_runs, share_of_runs
from rota.rehearsal.least_times import require_headway
from rota.rehearsal.outcome import ContactOutcome, DemandOutcome, Rehearsal
from rota.rehearsal.scene import HOUR_S, Scene, scene_of
from rota.rehearsal.stages import drive_in_stages, join

PARTS = 48  # into which what is looked at is cut
BATCH = 4  # runs done by one worker, one after another: sums over runs are then the same for any number of workers
IN_PROCESSES = 5  # batches from which on robots are replanned in processes, which take seconds to begin, not threads
LATE_S = 1e-6  # by which a place may be later than its period and on time


def rehearse(
    plan: Plan,
    *,
    hours: float = 24.0,
    failures_per_hour: float = 0.0,
    speed_noise: float = 0.0,
    wind_m_s: float = 0.0,
    wind_from_deg: float | None = None,
    late_relief_s: float = 0.0,
    hands_off: bool = False,
    replan: bool = False,
    runs: int = 100,
    seed: int = 0,
    executor: Executor | None = None,
    progress: Callable[[float, str], None] = lambda share, doing: None,
) -> Rehearsal:
    """Drive a plan in many runs in which things go wrong, and tell what share of what is asked was within its period.

    hours: how long each run is looked at, from when all robots are on their loops by plan. failures_per_hour: of each
    robot, by chance; it then stands where it is and sees nothing. speed_noise: the standard deviation of a robot's
    speed, as a share of it. wind_m_s: against which robots drive slower over the ground; wind_from_deg: where it comes
    from, 0 north, 90 east; None: in each run from another direction. late_relief_s: by how much robots leave chargers
    late, in the mean; exponential. hands_off: nobody keeps robots in phase, as ``rota fly`` does otherwise. replan:
    15 s after a failure a plan for those that remain takes over. Where nothing is left to chance all runs are the same,
    and one is made. executor: workers to share runs out to; None: the cores of this machine. The outcome is the same.
    progress: told a share in 0..1.

    Raises MissionError for values out of range, and RotaError for wind against which a robot does not get on, for runs
    that are too long for so many robots, for late reliefs where nobody charges, and for plans without robots or
    demands.
    """
    conditions = Conditions(
        hours=hours, failures_per_hour=failures_per_hour, speed_noise=speed_noise, wind_m_s=wind_m_s,
        wind_from_deg=wind_from_deg, late_relief_s=late_relief_s, hands_off=hands_off, replan=replan,
    )  # fmt: skip
    require(isinstance(runs, int) and 1 <= runs <= MOST_RUNS, "runs", runs, f"must be 1 to {MOST_RUNS}")
    require(isinstance(seed, int) and seed >= 0, "seed", seed, "must be a whole number of at least 0")
    require_headway(plan, wind_m_s)
    if late_relief_s and not any(way.charges for way in plan):
        raise MissionError(f"late_relief_s: {late_relief_s:g} is not allowed; nobody charges in this plan")
    scene = scene_of(plan, conditions)
    batches = _batches(scene, seed, 1 if conditions.certain else runs, executor, progress)
    return _outcome(scene, seed, batches)


def _batches(
    scene: Scene, seed: int, runs: int, executor: Executor | None, progress: Callable[[float, str], None]
) -> list[Batch]:
    """What became of all runs, in their order."""
    firsts = range(0, runs, BATCH)
    asked = scene.conditions
    if executor is None and asked.replan and asked.failures_per_hour and len(firsts) >= IN_PROCESSES:
        with workers(None) as executor:
            return _batches(scene, seed, runs, executor, progress)
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        futures: list[Future[Batch]] = []
        for first in firsts:
            numbers = range(first, min(first + BATCH, runs))
            if executor is None:
                futures.append(threads.submit(rehearse_batch, scene, seed, numbers))
            else:
                futures.append(submit_with(executor, scene, rehearse_batch, seed, numbers))
        try:
            for done, _ in enumerate(as_completed(futures), 1):
                progress(done / len(futures), "rehearsing")
            return [answer_of(future) for future in futures]
        finally:
            for future in futures:
                future.cancel()


def rehearse_batch(scene: Scene, seed: int, numbers: Sequence[int]) -> Batch:
    """The runs of these numbers, and the seconds (n,) that each place was late in all of them."""
    runs, late_s = [], np.zeros(len(scene.asked.demand))
    for number in numbers:
        run, late, _ = rehearse_once(scene, seed, number)
        runs.append(run)
        late_s += late
    return runs, late_s


def _outcome(scene: Scene, seed: int, batches: Sequence[Batch]) -> Rehearsal:
    """What all runs come to."""
    runs = [run for batch, _ in batches for run in batch]
    late_s = np.sum([late for _, late in batches], axis=0)
    available = 1 - np.stack([run.late_shares for run in runs], axis=1)
    areas_m2 = np.array([each.region.area for each in scene.demands])
    weights = areas_m2 / areas_m2.sum()
    parts = available.shape[2]
    return Rehearsal(
        conditions=scene.conditions,
        seed=seed,
        runs=len(runs),
        robots=len(scene.plan.trajectories),
        relieve_nobody=int(scene.relieves_nobody.sum()),
        available=mean_over_runs((weights @ available.mean(axis=2)).tolist(), 0.0, 1.0),
        failed=mean_over_runs([float(run.failed) for run in runs], 0.0),
        demands=tuple(_demand(scene, k, runs, available[k].mean(axis=1)) for k in range(len(scene.demands))),
        contacts=_contacts(scene, runs) if scene.pairs else None,
        charging=charging_outcome(scene, [run.charging for run in runs if run.charging is not None])
        if scene.charges
        else None,
        takeovers=mean_over_runs([float(run.takeovers) for run in runs], 0.0) if scene.conditions.replan else None,
        refusal=next((f"run {k}: {run.refusal}" for k, run in enumerate(runs) if run.refusal is not None), None),
        parts_h=np.linspace(0.0, scene.conditions.hours, parts + 1),
        parts_available=available,
        parts_weights=weights,
        places_m=_places_m(scene),
        places_demand=scene.asked.demand,
        places_available=1 - late_s / (len(runs) * scene.conditions.hours * HOUR_S),
    )


def _demand(scene: Scene, k: int, runs: Sequence[Run], available: Floats) -> DemandOutcome:
    """What became of one demand; available: (runs,)."""
    asked = scene.demands[k]
    gaps_s = np.array([run.worst_gaps_s[k] for run in runs])
    late_s = np.maximum(gaps_s - asked.period_s, 0.0)
    worst = int(gaps_s.argmax())
    x, y = _places_m(scene)[runs[worst].worst_places[k]]
    return DemandOutcome(
        name=asked.name,
        period_s=asked.period_s,
        demand=asked.demand,
        places=int(np.count_nonzero(scene.asked.demand == k)),
        available=mean_over_runs(available.tolist(), 0.0, 1.0),
        late_s=mean_over_runs(late_s.tolist(), 0.0),
        worst_gap_s=float(gaps_s[worst]),
        worst_run=worst,
        worst_place_m=(float(x), float(y)),
        on_time=share_of_runs(int(np.count_nonzero(late_s <= LATE_S)), len(runs)),
    )


def _contacts(scene: Scene, runs: Sequence[Run]) -> ContactOutcome:
    """In how many runs bodies touched, and the first time."""
    found = [(number, contact) for number, run in enumerate(runs) for contact in run.contacts]
    kinds = [{number for number, contact in found if contact.stands == stands} for stands in (False, True)]
    first = None
    if found:
        number, contact = min(found, key=lambda each: (each[1].stands, each[0], each[1].time_s))
        names = " and ".join(scene.plan.trajectories[robot].robot for robot in contact.robots)
        x, y = contact.place_m
        one = ", one of which had failed," if contact.stands else ""
        first = f"{names}{one} touch at ({x:.2f}, {y:.2f}) after {contact.time_s:.1f} s of run {number}"
    driving, standing = (share_of_runs(len(kind), len(runs)) for kind in kinds)
    return ContactOutcome(driving=driving, standing=standing, first=first)


def _places_m(scene: Scene) -> Floats:
    """All places (n, 2), those that stand for visits last."""
    visits = [each.region.representative_point() for each in scene.demands if each.demand == "visit"]
    return np.vstack([scene.points_m, *([[place.x, place.y]] for place in visits)])


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """What became of one run.

    late_shares: (d, PARTS) for each demand the share of it that was late, in each part of the time. worst_gaps_s,
    worst_places: (d,) the longest time that some place was unseen, and which. failed: how many robots did.
    contacts: of bodies. charging: None where nobody charges. takeovers: how many plans took over; refusal: why none did
    at last, None: where none was asked for or was refused.
    """

    late_shares: Floats
    worst_gaps_s: Floats
    worst_places: Ints
    failed: int
    contacts: tuple[Contact, ...]
    charging: Charging | None
    takeovers: int
    refusal: str | None


Batch = tuple[list[Run], Floats]


def rehearse_once(scene: Scene, seed: int, number: int) -> tuple[Run, Floats, Floats]:
    """The run of this number, and of each place (n,) the seconds beyond its period and the longest gap."""
    stages, refusal = drive_in_stages(scene, seed, number)
    sights, driven = join(stages)
    count, demands = len(scene.asked.demand), len(scene.demands)
    late, late_s, worst_s = np.zeros((demands, PARTS)), np.zeros(count), np.zeros(count)
    kernels.watch_places(sights, driven, scene.asked, late, late_s, worst_s)
    order = np.lexsort((-worst_s, scene.asked.demand))
    worst_places = order[np.searchsorted(scene.asked.demand[order], np.arange(demands))]
    run = Run(
        late_shares=late * PARTS / (scene.end_s - scene.begin_s),
        worst_gaps_s=worst_s[worst_places],
        worst_places=worst_places,
        failed=int(np.count_nonzero(stages[0].driven.fails_s < scene.end_s)),
        contacts=tuple(
            contact
            for stage in stages
            for contact in contacts_of(stage.scene.plan, stage.scene.pairs, stage.driven, stage.until_s)
        ),
        charging=charging_of(scene, driven, stages[-1].fills) if scene.charges else None,
        takeovers=len(stages) - 1,
        refusal=refusal,
    )
    return run, late_s, worst_s
