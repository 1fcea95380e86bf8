"""Teams of bouncing robots: groups counted and found that monitor zones, and Algorithm 1 from many starts."""

from __future__ import annotations

import statistics
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from shapely import box

from benchmarks.bounce_joint_maps import cpu_s
from benchmarks.bounce_maps import ROOM_10, ROOM_15, cells_on
from benchmarks.missions import DATA, write_real_mission
from benchmarks.row import Options, Row
from benchmarks.shell import rota
from rota.files.text_map import text_map
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone
from rota.planners.bounce.bounce_map import make_team
from rota.planners.bounce.coverage import Coverage, cover
from rota.planners.bounce.group_count import count_groups
from rota.planners.bounce.limit_cycles import cycles_see, limit_cycles
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planning.make_plan import search_plan

REPEATS = 5
COUNT_S = {5: 0.5, 10: 10.0}
FIND_S = 0.1
BUILDING_S = {"periods": 5.0, "worst_gap": 20.0}
STEPS = {2: 1700, 3: 1212, 4: 717, 5: 438}
STARTS = 20
REGIONS = {"sw": (0, 0, 2, 2), "se": (8, 0, 10, 2), "nw": (0, 8, 2, 10), "ne": (8, 8, 10, 10)}


def bounce_monitoring(options: Options) -> Iterator[Row]:
    """Exact counts with the regions in the corners, for each bouncing angle; and one plan for 10 robots, checked."""
    cells = cells_on(ROOM_10)
    low, high = cells.centres_m < 2, cells.centres_m > 8
    inside = np.array([west & south for south in (low[:, 1], high[:, 1]) for west in (low[:, 0], high[:, 0])])
    for robots, asked_s in COUNT_S.items():
        for angle, bounce in ((135, 3), (90, 2), (45, 1)):

            def counted(bounce: int = bounce, robots: int = robots) -> int:
                cycles = limit_cycles(make_team(cells, [bounce] * robots))
                return count_groups(cycles, cycles_see(cycles, inside, cells.headings))

            groups = counted()  # compiles
            taken_s = statistics.median(cpu_s(counted) for _ in range(REPEATS))
            name = f"bounce, all groups of {robots} robots for 4 regions, {angle} degrees, 10 x 10 with obstacles"
            yield Row(name, f"< {asked_s} s, exact", f"{taken_s:.3f} s, {groups:,} groups", taken_s < asked_s)
    mission = corners_of_a_room()
    found = search_plan(mission)
    taken_s = statistics.median(cpu_s(lambda: search_plan(mission)) for _ in range(REPEATS))
    measured = f"{taken_s * 1e3:.0f} ms, {found.report.verdict}, worst gap {found.report.worst_ratio:.2f} of its period"
    reached = taken_s < FIND_S and found.report.verdict == "met"
    yield Row("bounce, a plan of 10 robots for 4 regions, with its check", f"< {FIND_S} s", measured, reached)
    for purpose, asked_s in BUILDING_S.items():
        yield in_a_building(purpose, asked_s, options)


def in_a_building(purpose: str, asked_s: float, options: Options) -> Row:
    """Three robots for three zones of a scanned building, from the shell with its table; processor time."""
    name = f"bounce, {purpose}, cumberland, cells of 0.5 m, 90 degrees, 3 robots for 3 zones, with the table"
    proof = ", proved" * (purpose == "worst_gap")
    asked = f"< {asked_s:g} s, met{proof}"
    if not DATA.is_dir():
        return Row(name, asked, "not measured: ../shared/data is missing", None)
    mission = write_real_mission(f"bounce-{purpose}", options.folder)
    rota("plan", mission, "-o", options.folder / "compiled.json")  # compiles
    run = rota("plan", mission, "-o", options.folder / "bounced.json")
    if run.code != 0:
        return Row(name, asked, run.failure(), False)
    lines = run.out.splitlines()
    gap = next(line for line in lines if line.startswith("Worst gap"))
    proved = any(line.endswith("the shortest of all groups, proved.") for line in lines)
    measured = f"{run.cpu_s:.1f} s, met{', proved' * proved}; {gap[0].lower()}{gap[1:-1]}"
    return Row(name, asked, measured, run.cpu_s < asked_s and (proved or not proof))


def corners_of_a_room() -> Mission:
    """Ten robots that turn by 135 degrees, and the corners of a room to visit."""
    area, walls = text_map(ROOM_10, 1.0)
    fleet = Fleet(speed_m_s=0.5, sensor=DiscSensor(radius_m=0.5), body_radius_m=0.2)
    return Mission(
        name="corners",
        area=area,
        obstacles=(Obstacle(shape=walls),),
        zones=tuple(Zone(name=name, shape=box(*at), period_s=200, demand="visit") for name, at in REGIONS.items()),
        fleet=Fleet(
            speed_m_s=0.5,
            sensor=fleet.sensor,
            body_radius_m=0.2,
            robots=tuple(fleet.equal_robot(f"robot-{k + 1}") for k in range(10)),
        ),
        planning=BounceSettings(cell_m=1.0),
    )


def bounce_coverage(options: Options) -> Iterator[Row]:
    """Both methods from 20 random starts for each number of robots; 135 degrees, as the paper's."""
    for told, method in (("Algorithm 1 as printed", "as_printed"), ("Algorithm 1 with turns that pay", "improved")):
        complete, means = 0, {}
        for size, text in (("10 x 10", ROOM_10), ("15 x 15", ROOM_15)):
            runs = {robots: covered(text, robots, method) for robots in STEPS}
            complete += sum(run.complete for each in runs.values() for run in each)
            means[size] = {robots: statistics.mean(run.steps for run in each) for robots, each in runs.items()}
        shown = "; ".join(f"{size}: {'/'.join(f'{mean:.0f}' for mean in of.values())}" for size, of in means.items())
        fewer = method == "as_printed" or all(means["10 x 10"][robots] < steps for robots, steps in STEPS.items())
        asked = "160 of 160" if method == "as_printed" else "160 of 160; fewer than 1700/1212/717/438 on 10 x 10"
        measured = f"{complete} of 160; mean steps for 2/3/4/5 robots {shown}"
        name = f"bounce, {told}, 10 x 10 and 15 x 15 with obstacles, 20 starts each"
        yield Row(name, asked, measured, complete == 160 and fewer)


def covered(text: str, robots: int, method: str) -> list[Coverage]:
    """Joint trajectories from random starts."""
    cells = cells_on(text)
    team = make_team(cells, [3] * robots)
    return [cover(cells, team, start.tolist(), method=method) for start in starts(cells.count, robots)]  # type: ignore[arg-type]


def starts(cells: int, robots: int) -> list[NDArray[np.int64]]:
    """Random states in different cells, one set for each seed."""
    found = []
    for seed in range(STARTS):
        rng = np.random.default_rng(seed)
        found.append(rng.choice(cells, robots, replace=False) * 8 + rng.integers(0, 8, robots))
    return found
