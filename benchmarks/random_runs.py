"""Random small missions, planned in several processes; each plan is checked once more, as read back.

Ctrl-C stops the planners; what is done until then is told.
"""

from __future__ import annotations

import signal
import sys
import threading
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, wait
from typing import NamedTuple

from benchmarks.random_missions import described, random_mission
from benchmarks.row import Options, Row
from rota.check import check_plan
from rota.engines.processes import WorkerDied
from rota.engines.workers import workers
from rota.errors import NoPlanFound, RotaError
from rota.files.plan_file import plan_from_text, plan_text
from rota.model.mission import Mission
from rota.model.plan import Plan
from rota.planning.make_plan import search_plan

PATIENCE_S = 600.0  # for one mission: a search that takes longer is stopped, and counts as failed


class Outcome(NamedTuple):
    """What became of one mission. ``failure``: why it counts as failed; None: its plan passed.

    given: the mission says how many robots there are; otherwise they are as few as were found.
    """

    seed: int
    seconds: float
    failure: str | None
    kind: str
    robots: int = 0
    bound: int = 0
    given: bool = False


def random_missions(options: Options) -> Iterator[Row]:
    """A row for each failure as soon as it is known, then one for all that were planned."""
    done: list[Outcome] = []
    started_s = time.perf_counter()
    for outcome in outcomes(options):
        done.append(outcome)
        if outcome.failure is not None:
            name = f"random mission {outcome.seed}: {outcome.kind}"
            yield Row(name, "met", f"{outcome.failure} ({outcome.seconds:.1f} s)", False)
        tell_progress(done, options.missions)
    yield summary(done, options, time.perf_counter() - started_s)


def tell_progress(done: list[Outcome], missions: int) -> None:
    """A line on stderr that is written over, on a terminal only."""
    if sys.stderr.isatty():
        failed = sum(outcome.failure is not None for outcome in done)
        print(f"\r{len(done)} of {missions} planned, {failed} failed ", end="", file=sys.stderr, flush=True)


def summary(done: list[Outcome], options: Options, wall_s: float) -> Row:
    """How many of how many passed, their robots against the bounds, and what they took."""
    last = options.first_seed + options.missions - 1
    name = f"random small missions, seeds {options.first_seed} to {last}, {options.effort}"
    if not done:
        return Row(name, "every plan passes the check", "none was planned", None)
    passed = [outcome for outcome in done if outcome.failure is None]
    slowest = max(done, key=lambda outcome: outcome.seconds)
    free = [outcome for outcome in passed if not outcome.given]
    above = Counter(outcome.robots - outcome.bound for outcome in free)
    farthest = max(free, key=lambda outcome: outcome.robots - outcome.bound, default=None)
    far = "" if farthest is None else f", seed {farthest.seed} farthest"
    stopped = "" if len(done) == options.missions else f" (of {options.missions}; interrupted)"
    measured = (
        f"{len(passed)} of {len(done)}{stopped} passed, {100 * len(passed) / len(done):.1f} %; "
        f"where robots may be few {sum(outcome.robots for outcome in free)} robots "
        f"(bounds {sum(outcome.bound for outcome in free)}; "
        + ", ".join(f"{count} at +{robots}" for robots, count in sorted(above.items()))
        + f"{far}); {sum(outcome.seconds for outcome in done) / len(done):.1f} s each, "
        f"seed {slowest.seed} slowest with {slowest.seconds:.1f} s, {wall_s:.0f} s in all"
    )
    return Row(name, "every plan passes the check", measured, len(passed) == len(done) == options.missions)


def outcomes(options: Options) -> Iterator[Outcome]:
    """What becomes of each mission, as it becomes known; fewer than asked for after Ctrl-C."""
    seeds = range(options.first_seed, options.first_seed + options.missions)
    stop = threading.Event()
    before = signal.signal(signal.SIGINT, lambda _signal, _frame: stop.set())
    try:
        with workers(None, options.processes) as executor:
            running = {executor.submit(planned, seed, options.effort): seed for seed in seeds}
            while running and not stop.is_set():
                ready, _ = wait(running, timeout=0.1, return_when=FIRST_COMPLETED)
                for future in ready:
                    seed = running.pop(future)
                    try:
                        yield future.result()
                    except WorkerDied as died:
                        yield Outcome(seed, 0.0, str(died), described(random_mission(seed)))
    finally:
        signal.signal(signal.SIGINT, before)


def planned(seed: int, effort: str) -> Outcome:
    """Plan the mission of this seed, and check the plan as it reads back from its file's text."""
    mission = random_mission(seed).with_effort(effort)
    started_s = time.perf_counter()
    plan, failure = _plan_or_failure(mission)
    seconds = time.perf_counter() - started_s
    if plan is not None:
        failure = fault(plan)
    return Outcome(
        seed=seed,
        seconds=seconds,
        failure=failure,
        kind=described(mission),
        robots=0 if plan is None else len(plan.trajectories),
        bound=0 if plan is None or plan.lower_bound_robots is None else plan.lower_bound_robots,
        given=mission.fleet.robots is not None,
    )


def _plan_or_failure(mission: Mission) -> tuple[Plan | None, str | None]:
    try:
        found = search_plan(mission, time_limit_s=PATIENCE_S)
    except NoPlanFound as failure:
        best = failure.best
        robots = f" (best: {len(best.trajectories)} robots)" if isinstance(best, Plan) else ""
        return None, f"no plan: {failure}{robots}"
    except RotaError as failure:
        return None, f"refused: {failure}"
    except Exception as error:  # whatever it is, it is a finding, and the others go on
        place = traceback.extract_tb(error.__traceback__)[-1]
        return None, f"{type(error).__name__} in {place.name}, line {place.lineno}: {error}"
    return found.plan, f"took longer than {PATIENCE_S:.0f} s" if found.stopped_early else None


def fault(plan: Plan) -> str | None:
    """What is wrong with a plan that was given as good, by the check of its file's text; None: nothing."""
    read = plan_from_text(plan_text(plan).encode(), "plan")
    report = check_plan(read)
    if report.verdict != "met":
        return f"the check says {report.verdict!r} of the plan as written"
    fleet = read.mission.fleet.robots
    if fleet is not None and [one.robot for one in read] != [robot.name for robot in fleet]:
        return f"{len(fleet)} robots were given and {len(read.trajectories)} have a route"
    # a bound above the robots of a plan that is met is a violation by itself
    return "no lower bound is told" if read.lower_bound_robots is None else None
