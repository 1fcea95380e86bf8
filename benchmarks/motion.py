"""Plans for robots with mass: robots, whether they are met as a real copter flies them, and what motion costs."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from ruamel.yaml import YAML

from benchmarks.missions import EXAMPLES
from benchmarks.planning import Planned, plan_and_check
from benchmarks.row import Options, Row
from benchmarks.shell import rota
from benchmarks.sun_cases import CASES, ROBOTS_IN_ALL, write_case

COPTERS = {"arducopter-tuned": 8, "arducopter": 11}
ACCELERATION_M_S2, CORNER_M = 3.0, 1.0
MOST_TIMES = 1.5


def motion(options: Options) -> Iterator[Row]:
    """The harbour for two copters as they fly it, then Sun's seven cases with and without mass."""
    for vehicle, most in COPTERS.items():
        yield from _harbour(vehicle, most, options)
    without = [plan_and_check(write_case(case, options.folder), options.folder) for case in CASES]
    with_mass = [plan_and_check(_with_mass(write_case(case, options.folder)), options.folder) for case in CASES]
    yield _sun(with_mass)
    yield _times("Sun's seven cases", sum(one.cpu_s for one in with_mass), sum(one.cpu_s for one in without))


def _harbour(vehicle: str, most: int, options: Options) -> Iterator[Row]:
    """The harbour planned for a copter, flown by its model, and the processor time beside one without mass."""
    mission = YAML(typ="safe").load((EXAMPLES / "harbour-copters.yaml").read_text())
    mission["fleet"]["vehicle"] = vehicle
    planned = _planned(mission, f"harbour-{vehicle}", options.folder)
    name = f"the harbour for {vehicle} at 8 m/s, quick"
    asked = f"{most} robots, met as flown (--executed waypoints)"
    if planned.report is None:
        yield Row(name, asked, planned.plan.failure(), False)
        return
    plan = options.folder / f"harbour-{vehicle}.rota.json"
    flown = rota("check", plan, "--executed", "waypoints", "--vehicle", vehicle, "--json")
    report = json.loads(flown.out)
    verdict, robots = report["report"]["verdict"], planned.report["robots"]
    factors = [robot["factor"] for robot in report["robots"]]
    slack = min(1 - demand["worst_gap_s"] / demand["period_s"] for demand in report["report"]["demands"])
    measured = f"{robots} robots, {planned.report['verdict']}; as flown {verdict}, {slack:.1%} of a period to spare;"
    measured += f" rounds {min(factors):.3f} to {max(factors):.3f} times the planned ones"
    yield Row(name, asked, measured, verdict == "met" and planned.met and robots <= most)
    mission["fleet"]["vehicle"] = "none"
    yield _times(name, planned.cpu_s, _planned(mission, "harbour-none", options.folder).cpu_s)


def _planned(mission: object, name: str, folder: Path) -> Planned:
    path = folder / f"{name}.json"
    path.write_text(json.dumps(mission))
    return plan_and_check(path, folder)


def _with_mass(case: Path) -> Path:
    """The case with an acceleration and corners that are cut."""
    mission = json.loads(case.read_text())
    mission["fleet"] |= {"acceleration_m_s2": ACCELERATION_M_S2, "corner_m": CORNER_M}
    path = case.with_name(f"mass-{case.name}")
    path.write_text(json.dumps(mission))
    return path


def _sun(planned: list[Planned]) -> Row:
    """Robots of all cases together."""
    met = [one.report["robots"] for one in planned if one.report is not None and one.met]
    name = f"Sun 2019, the seven cases with {ACCELERATION_M_S2:g} m/s2, corners cut by {CORNER_M:g} m, quick"
    each = " + ".join(map(str, met))
    measured = f"{sum(met)} robots ({each}) in {len(met)} of {len(planned)} cases met; {ROBOTS_IN_ALL} at once"
    return Row(name, "all met", measured, len(met) == len(planned))


def _times(name: str, with_s: float, without_s: float) -> Row:
    """Processor time to plan and check with motion, beside that without."""
    times = with_s / without_s
    measured = f"{times:.2f} times: {with_s:.0f} s beside {without_s:.0f} s"
    return Row(
        f"{name}: processor time beside none with mass", f"at most {MOST_TIMES:g} times", measured, times <= MOST_TIMES
    )
