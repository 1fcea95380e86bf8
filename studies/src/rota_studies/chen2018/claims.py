"""Claims without a figure: robots that come and go, late news, unlike robots, moving obstacles, tuning, cost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rota.check import check_plan
from rota.model.mission import DiscSensor, Mission, MovingObstacle, Robot
from rota.planners.swarm.planner import SwarmRun, run_mission
from rota.planners.swarm.planner_settings import SwarmSettings
from rota_studies.chen2018 import maps, paper
from rota_studies.chen2018.decision_times import decision_us
from rota_studies.chen2018.runs import EXACT, FILTERED, Runs, covered_in, what
from rota_studies.plain import changes
from rota_studies.records import plan_digest
from rota_studies.section import Section
from rota_studies.tables import Table, joined, plus_minus
from rota_studies.verdict import Outcome, Verdict, always, compared, mostly

CHANGE_S = 50.0
"""When robots leave or join: in the middle of their way."""
COMING, NEIGHBOURS = 5, (2, 3, 4, 6, 8)
MOST_SLOWER = 3.0  # times, up to which a decision among many robots counts as cheap
CROSSING = MovingObstacle(
    radius_m=3.0, times_s=(0.0, 250.0, 400.0), positions_m=((-10.0, 130.0), (-10.0, 130.0), (260.0, 130.0))
)
"""Sets out when nearly all robots are at rest, and crosses the area at 1.8 m/s."""


@dataclass(frozen=True, kw_only=True)
class Tried:
    """What a run came to: steps, whether it is at rest, percent covered in the end, and whether bodies touch."""

    steps: int
    at_rest: bool
    covered: float
    touched: bool
    digest: str


def _row(what_is_run: str, tries: list[Tried]) -> tuple[str, ...]:
    """The row of runs of one kind in the table."""
    rested = [one.steps for one in tries if one.at_rest]
    return (
        what_is_run,
        f"{len(rested)} of {len(tries)}",
        plus_minus(rested, ",.0f"),
        plus_minus([one.covered for one in tries], ".2f"),
        f"{sum(one.touched for one in tries)} of {len(tries)}",
    )


def figure_24_section(runs: Runs) -> Section:
    """What is claimed and has no figure."""
    tried = {name: _tried(runs, name, *made) for name, made in experiments(runs).items()}
    small, large = (
        _decision_us(runs, mission, steps)
        for mission, steps in (
            (maps.small("between"), runs.settings.timed_steps),
            (maps.large(runs.settings.large_robots), 60),
        )
    )
    table = Table(
        title=f"RD, {runs.settings.claim_seeds} seeds, from the box between centre and corner",
        head=("what", "at rest", "steps", "covered %", "runs in which bodies touch"),
        rows=tuple(_row(name, tries) for name, tries in tried.items()),
    )
    return Section(
        figure=24,
        heading="claims without a figure",
        pictures=(),
        caption=f"Robots leave or join {CHANGE_S:g} s after the start; those that leave stay as bodies, those that "
        "join stand until then, and only those that take part count as cover. Contact is what Rota's check says of the "
        f"plan, with walls and the obstacle; the obstacle of {CROSSING.radius_m:g} m crosses from 250 s to 400 s.",
        paper="“Any UAV can join in or quit the swarm without influencing the others' decisions” (Section 2); robots "
        "are asynchronous (5.2) and may be unlike (abstract); moving obstacles are avoided (Eq. 15); nothing is to be "
        "tuned (Section 6); a KD-tree makes decisions cheap (4.3).",
        ours=f"One decision takes {small:.2f} µs with 25 robots and {large:.2f} µs with "
        f"{runs.settings.large_robots:,}, with a grid of cells in place of the KD-tree.",
        tables=(table,),
        extra=True,
        verdicts=_verdicts(tried, small, large, runs.settings.large_robots),
    )  # fmt: skip


Made = tuple[Callable[[int], Mission], SwarmSettings]


def experiments(runs: Runs) -> dict[str, Made]:
    """What is run, by name: a mission for each seed, and the settings."""
    plain, bare, safe = maps.small("between"), EXACT.settings, FILTERED.settings
    made: dict[str, Made] = {
        "all 25 robots": (lambda _: plain, bare),
        "20 robots": (lambda _: _with(plain, lambda k, robot: robot if k >= COMING else None), bare),
        "5 of 25 leave, filter": (lambda _: _coming(plain, {"leaves_s": CHANGE_S}), safe),
        "5 of 25 join, filter": (lambda _: _coming(plain, {"joins_s": CHANGE_S}), safe),
        "news a step late": (lambda _: plain, replace(bare, delay_steps=1)),
        "news a step late, a tenth lost": (lambda _: plain, replace(bare, delay_steps=1, messages_lost=0.1)),
        "unlike robots": (lambda seed: unlike(plain, seed), bare),
        "moving obstacle, α = 1": (lambda _: replace(plain, moving_obstacles=(CROSSING,)), bare),
        "moving obstacle, α = 2": (lambda _: replace(plain, moving_obstacles=(CROSSING,)), replace(bare, alpha=2.0)),
        "moving obstacle, filter": (lambda _: replace(plain, moving_obstacles=(CROSSING,)), safe),
    }
    for count in NEIGHBOURS:
        if count != paper.NEIGHBOURS:
            made[_of_neighbours(count)] = (lambda _: plain, replace(bare, neighbours=count))
    return made


def _with(mission: Mission, change: Callable[[int, Robot], Robot | None]) -> Mission:
    """The mission with its robots changed one by one; None leaves a robot out."""
    robots = [change(k, robot) for k, robot in enumerate(mission.fleet.robots or ())]
    kept = tuple(robot for robot in robots if robot is not None)
    return replace(mission, fleet=replace(mission.fleet, robots=kept))


def _coming(mission: Mission, times: dict[str, Any]) -> Mission:
    """The mission in which the first COMING robots join or leave at these times."""
    return _with(mission, lambda k, robot: replace(robot, **times) if k < COMING else robot)


def unlike(mission: Mission, seed: int) -> Mission:
    """The same robots with sensors of 15 m to 30 m, bodies of 0.3 m to 0.8 m and speeds of 1 m/s to 3 m/s."""
    rng = np.random.default_rng([seed, 24])

    def changed(_: int, robot: Robot) -> Robot:
        sensor_m, body_m, speed_m_s = rng.uniform((15.0, 0.3, 1.0), (30.0, 0.8, 3.0)).tolist()
        return replace(robot, sensor=DiscSensor(radius_m=sensor_m), body_radius_m=body_m, speed_m_s=speed_m_s)

    return _with(mission, changed)


def _tried(runs: Runs, name: str, make: Callable[[int], Mission], settings: SwarmSettings) -> list[Tried]:
    """What an experiment came to, seed by seed."""

    def run(mission: Mission, seed: int) -> Tried:
        runs.now(f"{name}, seed {seed}")
        found = run_mission(mission, seed=seed, should_stop=runs.should_stop)
        runs.stop_if_asked()
        touched = bool(check_plan(found.plan).violations)
        return Tried(
            steps=found.steps, at_rest=found.at_rest, covered=100 * _covered(found), touched=touched,
            digest=plan_digest(found.plan),
        )  # fmt: skip

    tries = []
    for seed in runs.some(runs.settings.claim_seeds):
        mission = replace(make(seed), planning=replace(settings, most_steps=runs.settings.steps))
        told = {"what": name, **what(mission), "settings": changes(mission.planning), "seed": seed}
        tries.append(runs.records.get(Tried, told, lambda mission=mission, seed=seed: run(mission, seed)))  # type: ignore[misc]
    return tries


def _decision_us(runs: Runs, mission: Mission, steps: int) -> float:
    """Microseconds of a decision by RD. Measured."""

    def make() -> float:
        runs.now(f"timing {mission.name}")
        return decision_us(mission, EXACT.settings, runs.seed, steps)

    run = {"what": "decision time", **what(mission, EXACT), "steps": steps, "seed": runs.seed}
    return runs.records.get(float, run, make)


def _covered(run: SwarmRun) -> float:
    """Share in range, in the end, of those that have not left."""
    mission = run.plan.mission
    present = [k for k, robot in enumerate(mission.fleet.robots or ()) if robot.leaves_s is None]
    places = np.array([run.plan.trajectories[k].positions_m[-1] for k in present])
    return covered_in(_with(mission, lambda k, robot: robot if k in present else None), places)


def _verdicts(tried: dict[str, list[Tried]], small_us: float, large_us: float, large: int) -> tuple[Verdict, ...]:
    """The verdicts on joining, news, the filter and decisions by the experiments and decision times."""

    def told(*names: str) -> str:
        return "; ".join(
            f"{name}: at rest in {sum(one.at_rest for one in tries)} of {len(tries)} runs, "
            f"{np.mean([one.covered for one in tries]):.1f} % covered, contact in {sum(one.touched for one in tries)}"
            for name, tries in ((name, tried[name]) for name in names)
        )

    def covered(name: str) -> list[float]:
        return [one.covered for one in tried[name]]

    coming = ("5 of 25 leave, filter", "5 of 25 join, filter")
    late = ("news a step late", "news a step late, a tenth lost")
    crossing = ("moving obstacle, α = 1", "moving obstacle, α = 2", "moving obstacle, filter")
    counts = {count: _of_neighbours(count) for count in NEIGHBOURS}
    means = {count: float(np.mean(covered(name))) for count, name in counts.items()}
    best, worst = (counts[choose(means, key=means.__getitem__)] for choose in (max, min))
    tuned = compared([a - b for a, b in zip(covered(best), covered(worst), strict=True)], unit=" points")
    settled = mostly([all(tried[name][k].at_rest for name in coming) for k in range(len(tried[coming[0]]))])
    unlike_ones = mostly([one.at_rest and not one.touched for one in tried["unlike robots"]])
    clear = always([not one.touched for name in crossing[:2] for one in tried[name]])
    against: dict[Outcome, Outcome] = {"holds": "does not hold", "cannot be told": "cannot be told"}
    return (
        Verdict(
            "Any UAV can join or quit without influencing the others", "2", settled.outcome,
            f"In the sense that nothing is to be told to the others: at rest after both in {settled.told}. "
            f"{told(*coming)}; 20 robots from the start cover {np.mean(covered('20 robots')):.1f} %.",
        ),
        Verdict(
            "UAVs are asynchronous", "5.2", "cannot be told",
            f"Here, as by Eq. 11, all decide at once; old news stand in for it. {told(*late)}.",
        ),
        Verdict(
            "The method suits unlike sensors", "Abstract, 6", unlike_ones.outcome,
            f"At rest without contact in {unlike_ones.told}. {told('unlike robots')}. Its sets do not know radii, so "
            "that a small sensor takes as much room as a large one.",
        ),
        Verdict(
            "It suits sensors whose range changes with height", "Abstract, 6", "cannot be told",
            "The paper's model is plane. `examples/swarm-space.yaml` extends it, and all robots climb.",
        ),
        Verdict(
            "Moving obstacles are avoided (Eq. 15)", "3.3.2", clear.outcome,
            f"No contact in {clear.told} without a filter. {told(*crossing)}.",
        ),
        Verdict(
            "No parameters are to be tuned by experiment", "6", against.get(tuned.outcome, "cannot be told"),
            "The number of neighbours is one: "
            f"{joined([f'{mean:.1f} % covered with {count}' for count, mean in means.items()])}. The best beside the "
            f"worst: {tuned.told}.",
        ),
        Verdict(
            "A decision is cheap with any number of UAVs (KD-tree)", "4.3, 5.2",
            "holds" if large_us < MOST_SLOWER * small_us else "does not hold",
            f"{small_us:.2f} µs with 25 robots, {large_us:.2f} µs with {large:,}, by a grid in place of the tree: "
            f"measured, and less than {MOST_SLOWER:g} times as long.",
        ),
    )  # fmt: skip


def _of_neighbours(count: int) -> str:
    """The name of the experiment with so many neighbours."""
    return "all 25 robots" if count == paper.NEIGHBOURS else f"{count} neighbours"
