"""Plans for hundreds and thousands of robots in the open: how near to the bound, and cost against robots."""

from __future__ import annotations

import functools
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.planning import Planned, plan_and_check, told
from benchmarks.row import Options, Row
from benchmarks.shell import rota
from benchmarks.warm_cache import measured_warm

FIELD_M = (746.0, 1105.0)
FLEET = {"speed_m_s": 5, "sensor": {"shape": "disc", "radius_m": 4}}
PERIOD_S = 60.0
ZONES = (
    {"name": "gate", "period_s": 30, "ring": [[100, 150], [220, 150], [220, 260], [100, 260]]},
    {"name": "depot", "period_s": 40, "circle": {"centre": [500, 500], "radius_m": 70}},
    {"name": "meadow", "period_s": 120, "ring": [[250, 750], [600, 720], [640, 900], [300, 960]]},
)
# 10 km2, of which a robot sees 5,000 m2 in a period: 2,000 robots
LARGE_M, LARGE_PERIOD_S = (4000.0, 2500.0), 100.0
LARGE_FLEET = {"speed_m_s": 5, "sensor": {"shape": "disc", "radius_m": 5}}
SCALES = (0.5, 0.7, 1.0, 1.4)  # of the field's sides, for cost against robots
MOST_RATIO = 1.15
MOST_EXPONENT = 1.1
PATIENCE_S = 1800.0


def many_robots(options: Options) -> Iterator[Row]:
    """The field, the field with zones, ten square kilometres, and growth."""
    folder = options.folder
    plain = field_mission(folder, "field", FIELD_M)
    before = "no plan after 15 min before rows of lanes"
    yield _row(f"746 m x 1,105 m, r = 4 m, 60 s ({before})", _planned(plain, folder), 120.0, 4e9)
    zoned = field_mission(folder, "field-zones", FIELD_M, zones=ZONES)
    yield _row("the same with 3 zones of 30, 40 and 120 s", _planned(zoned, folder), 120.0, 4e9)
    large = field_mission(folder, "ten-km2", LARGE_M, period_s=LARGE_PERIOD_S, fleet=LARGE_FLEET)
    yield _row("10 km2, r = 5 m, 100 s: 2,000 robots", _planned(large, folder), 600.0, 4e9)
    sizes = [(scale * FIELD_M[0], scale * FIELD_M[1]) for scale in SCALES]
    scaled = [field_mission(folder, f"field-{scale:g}", size) for scale, size in zip(SCALES, sizes, strict=True)]
    yield growth_row([planned_alone(mission) for mission in scaled])


def planned_alone(mission: Path) -> tuple[int | None, float]:
    """The robots of a mission's plan, which the planner has had checked; None without one; and processor time."""
    plan_file = mission.with_suffix(".rota.json")
    run = rota("plan", mission, "--effort", "quick", "-o", plan_file, patience_s=PATIENCE_S)
    return (len(json.loads(plan_file.read_text())["robots"]) if run.code == 0 else None), run.cpu_s


def field_mission(
    folder: Path,
    name: str,
    size_m: tuple[float, float],
    *,
    zones: Sequence[dict[str, Any]] = (),
    period_s: float = PERIOD_S,
    fleet: dict[str, Any] = FLEET,
) -> Path:
    """The file of a mission over an open rectangle."""
    wide_m, high_m = size_m
    mission = {
        "rota": 1, "name": name, "area": [[0, 0], [wide_m, 0], [wide_m, high_m], [0, high_m]], "zones": list(zones),
        "period_s": period_s, "fleet": fleet,
    }  # fmt: skip
    path = folder / f"{name}.json"
    path.write_text(json.dumps(mission))
    return path


@functools.cache
def _planned(mission: Path, folder: Path) -> Planned:
    """Plan and check a mission, once."""
    (found,) = measured_warm(
        lambda: plan_and_check(mission, folder, patience_s=PATIENCE_S), lambda run: run.wall_s, repeats=1
    )
    return found


def _row(name: str, found: Planned, seconds: float, size: float) -> Row:
    # processor time, which is more than an idle machine's wall time, and the same on a busy one
    asked = f"met, at most {MOST_RATIO:g} x the bound, CPU < {seconds:.0f} s to plan, < {size / 1e9:.0f} GB"
    if found.report is None:
        return Row(name, asked, told([found]), False)
    ratio = found.report["robots"] / found.report["lower_bound_robots"]
    measured = f"{told([found])}; {ratio:.3f} x the bound; CPU {found.plan.cpu_s:.0f} s to plan"
    reached = found.met and ratio <= MOST_RATIO and found.plan.cpu_s < seconds and found.peak_bytes < size
    return Row(name, asked, measured, reached)


def growth_row(found: Sequence[tuple[int | None, float]]) -> Row:
    """The exponent by which processor time grows with robots, a slope of logarithms, of (robots, seconds) of plans."""
    name, asked = f"growth of planning over {len(found)} sizes of the field", f"exponent at most {MOST_EXPONENT}"
    known = [(robots, cpu_s) for robots, cpu_s in found if robots is not None]
    if len(known) < len(found):
        return Row(name, asked, "not known: a plan is missing", False)
    exponent = float(np.polyfit(*np.log(known).T, 1)[0])
    each = ", ".join(f"{robots:,} robots {cpu_s:.0f} s" for robots, cpu_s in known)
    return Row(name, asked, f"exponent {exponent:.2f} (CPU: {each})", exponent <= MOST_EXPONENT)
