"""Claims without a figure: robots that come and go, late news, unlike robots, moving obstacles, tuning, cost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rota.check import check_plan
from rota.mission import DiscSensor, Mission, MovingObstacle, Robot
from rota.papers.chen2018 import maps, paper
from rota.papers.chen2018.decision_times import decision_us
from rota.papers.chen2018.runs import EXACT, FILTERED, Runs, covered_in
from rota.papers.chen2018.small_figures import plus_minus
from rota.papers.chen2018.verdicts import holds_if
from rota.papers.section import Section, Verdict
from rota.papers.tables import Table, joined
from rota.planners.swarm.planner import SwarmRun, run_mission
from rota.planners.swarm.planner_settings import SwarmSettings

CHANGE_S = 50.0
"""When robots leave or join: in the middle of their way."""
COMING, NEIGHBOURS = 5, (2, 3, 4, 6, 8)
CROSSING = MovingObstacle(
    radius_m=3.0, times_s=(0.0, 250.0, 400.0), positions_m=((-10.0, 130.0), (-10.0, 130.0), (260.0, 130.0))
)
"""Sets out when nearly all robots are at rest, and crosses the area at 1.8 m/s."""


@dataclass(frozen=True, kw_only=True)
class Tried:
    """What runs of one kind came to, seed by seed: steps of those that rest, percent covered, contacts of bodies."""

    what: str
    rested: list[int]
    covered: list[float]
    touched: int

    @property
    def row(self) -> tuple[str, ...]:
        """Its row in the table."""
        return (
            self.what,
            f"{len(self.rested)} of {len(self.covered)}",
            plus_minus(self.rested, ",.0f"),
            plus_minus(self.covered, ".2f"),
            f"{self.touched} of {len(self.covered)}",
        )

    @property
    def rests(self) -> bool:
        """Whether every run comes to rest."""
        return len(self.rested) == len(self.covered)


def figure_24_section(runs: Runs) -> Section:
    """What is claimed and has no figure."""
    tried = {name: _tried(runs, name, *made) for name, made in experiments(runs).items()}
    small, large = (
        decision_us(mission, EXACT.settings, runs.seed, steps)
        for mission, steps in (
            (maps.small("between"), runs.settings.timed_steps),
            (maps.large(runs.settings.large_robots), 60),
        )
    )
    table = Table(
        title=f"RD, {runs.settings.claim_seeds} seeds, from the box between centre and corner",
        head=("what", "at rest", "steps", "covered %", "runs in which bodies touch"),
        rows=tuple(tries.row for tries in tried.values()),
    )
    return Section(
        figure=24,
        heading="claims without a figure",
        pictures=(),
        caption=f"Robots leave or join {CHANGE_S:g} s after the start; those that leave stay as bodies, those that "
        f"join stand "
        "until then, and only those that take part count as cover. Contact is what Rota's check says of the plan, with "
        f"walls and the obstacle; the obstacle of {CROSSING.radius_m:g} m crosses from 250 s to 400 s.",
        paper="“Any UAV can join in or quit the swarm without influencing the others' decisions” (Section 2); "
        "robots are "
        "asynchronous (5.2) and may be unlike (abstract); moving obstacles are avoided (Eq. 15); nothing is to be "
        "tuned "
        "(Section 6); a KD-tree makes decisions cheap (4.3).",
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
            made[f"{count} neighbours"] = (lambda _: plain, replace(bare, neighbours=count))
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


def _tried(runs: Runs, what: str, make: Callable[[int], Mission], settings: SwarmSettings) -> Tried:
    """What an experiment came to over all seeds."""
    outcomes = []
    for k in range(runs.settings.claim_seeds):
        runs.stop_if_asked()
        runs.tell(f"{what}, seed {runs.seed + k}")
        mission = replace(make(runs.seed + k), planning=replace(settings, most_steps=runs.settings.steps))
        outcomes.append(run_mission(mission, seed=runs.seed + k))
    runs.stop_if_asked()
    return Tried(
        what=what,
        rested=[run.steps for run in outcomes if run.at_rest],
        covered=[100 * _covered(run) for run in outcomes],
        touched=sum(bool(check_plan(run.plan).violations) for run in outcomes),
    )


def _covered(run: SwarmRun) -> float:
    """Share in range, in the end, of those that have not left."""
    mission = run.plan.mission
    present = [k for k, robot in enumerate(mission.fleet.robots or ()) if robot.leaves_s is None]
    places = np.array([run.plan.trajectories[k].positions_m[-1] for k in present])
    return covered_in(_with(mission, lambda k, robot: robot if k in present else None), places)


def _verdicts(tried: dict[str, Tried], small_us: float, large_us: float, large: int) -> tuple[Verdict, ...]:
    """The verdicts on joining, news, the filter and decisions by the experiments and decision times."""

    def told(*names: str) -> str:
        return "; ".join(
            f"{name}: at rest in {len(tries.rested)} of {len(tries.covered)} runs, {np.mean(tries.covered):.1f} % "
            f"covered, contact in {tries.touched}"
            for name, tries in ((name, tried[name]) for name in names)
        )

    coming = ("5 of 25 leave, filter", "5 of 25 join, filter")
    late = ("news a step late", "news a step late, a tenth lost")
    crossing = ("moving obstacle, α = 1", "moving obstacle, α = 2", "moving obstacle, filter")
    counts = {
        count: tried["all 25 robots" if count == paper.NEIGHBOURS else f"{count} neighbours"] for count in NEIGHBOURS
    }
    means = {count: float(np.mean(attempts.covered)) for count, attempts in counts.items()}
    return (
        Verdict(
            "Any UAV can join or quit without influencing the others", "2",
            holds_if(all(tried[name].rests for name in coming)),
            f"In the sense that nothing is to be told to the others. {told(*coming)}; 20 robots from the start cover "
            f"{np.mean(tried['20 robots'].covered):.1f} %.",
        ),
        Verdict(
            "UAVs are asynchronous", "5.2", "cannot be told",
            f"Here, as by Eq. 11, all decide at once; old news stand in for it. {told(*late)}.",
        ),
        Verdict(
            "The method suits unlike sensors", "Abstract, 6",
            holds_if(tried["unlike robots"].rests and not tried["unlike robots"].touched),
            f"{told('unlike robots')}. Its sets do not know radii, so that a small sensor takes as much room as a "
            f"large one.",
        ),
        Verdict(
            "It suits sensors whose range changes with height", "Abstract, 6", "cannot be told",
            "The paper's model is plane. `examples/swarm-space.yaml` extends it, and all robots climb.",
        ),
        Verdict(
            "Moving obstacles are avoided (Eq. 15)", "3.3.2",
            "holds" if not tried[crossing[0]].touched + tried[crossing[1]].touched else "does not "
            "hold", told(*crossing) + ".",
        ),
        Verdict(
            "No parameters are to be tuned by experiment", "6",
            "does not hold" if max(means.values()) - min(means.values()) > 1 else "holds",
            f"The number of neighbours is one: "
            f"{joined([f'{mean:.1f} % covered with {count}' for count, mean in means.items()])}.",
        ),
        Verdict(
            "A decision is cheap with any number of UAVs (KD-tree)", "4.3, 5.2",
            holds_if(large_us < 3 * small_us),
            f"{small_us:.2f} µs with 25 robots, {large_us:.2f} µs with {large:,}, by a grid in place of the tree.",
        ),
    )  # fmt: skip
