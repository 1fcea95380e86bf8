"""A new ability, as docs/contributing.md adds one, is heeded by every planner, by the bound and by the check."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from textwrap import indent
from typing import Any

import pytest
from shapely import box
from tests.test_docs import python_of, recipe

from rota import DiscSensor, Fleet, Mission, prove_bound

Told = dict[str, tuple[float, int, str, list[str]]]

SOURCE = Path(__file__).parents[1] / "src"
FLEET = {"robots": 2, "speed_m_s": 2, "sensor": {"shape": "disc", "radius_m": 5}, "body_radius_m": 0.5}
POST = {"name": "post", "ring": [[10, 10], [20, 10], [20, 20], [10, 20]], "demand": "visit", "period_s": 600}
START = {"box": [[2, 2], [8, 8]]}
MISSIONS: dict[str, dict[str, Any]] = {
    "patrol": {"period_s": 42, "fleet": {**FLEET, "robots": "fewest"}, "patrol": {"effort": "quick"}},
    "begun": {"period_s": 90, "fleet": {**FLEET, "robots": "fewest", "start": START}, "patrol": {"effort": "quick"}},
    "swarm": {"fleet": {**FLEET, "start": START}, "swarm": {"most_steps": 4}},
    "bounce": {"zones": [POST], "fleet": {**FLEET, "robots": 1}, "bounce": {"cell_m": 1, "bouncing_angles_deg": [90]}},
}
PLANS = """
import json, sys
from dataclasses import replace
from pathlib import Path
import numpy as np
import rota
told = {}
for path in map(Path, sys.argv[1:]):
    plan = rota.make_plan(rota.read_mission(path).mission, seed=0)
    fastest = max(float((np.hypot(*np.diff(way.positions_m, axis=0).T) / np.diff(way.times_s)).max()) for way in plan)
    ways = tuple(replace(way, times_s=way.times_s / 1.5, loop_start_s=way.loop_start_s / 1.5) for way in plan)
    hurried = rota.check_plan(replace(plan, trajectories=ways))
    bound = rota.prove_bound(plan.mission)[0] if path.stem == "patrol" else 0
    told[path.stem] = [fastest, bound, rota.check_plan(plan).verdict, [fault.kind for fault in hurried.violations]]
print(json.dumps(told))
"""


def with_payloads(folder: Path) -> Path:
    """A copy of Rota with the ability that the page adds; all but the two modules that it changes stay compiled."""
    shutil.copytree(SOURCE / "rota", folder / "rota")
    field, made_of_it, judged = python_of(recipe("Add an ability"))
    fleet, motion = folder / "rota/model/fleet.py", folder / "rota/check/motion.py"
    text = fleet.read_text()
    begin = text.index("    @property\n    def ground_speed_m_s")
    end = text.index("    @property", begin + 1)
    text = text[:begin] + indent(made_of_it, "    ") + "\n" + text[end:]
    last = "    motion: MotionLimits = field_of(AT_ONCE, flat=True)\n"
    fleet.write_text(text.replace(last, last + indent(field, "    "), 1))
    motion.write_text(motion.read_text().replace("    top_m_s = robot.speed_m_s\n", indent(judged, "    "), 1))
    return folder


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> Told:
    """Of each mission with a payload: the fastest leg, the bound, the verdict, and that on the plan driven faster."""
    folder = tmp_path_factory.mktemp("payloads")
    names = []
    for name, mission in MISSIONS.items():
        planner = name if name in ("swarm", "bounce") else "patrol"
        whole = {"rota": 1, "name": name, "area": [[0, 0], [30, 0], [30, 30], [0, 30]], "planner": planner, **mission}
        whole["fleet"] = {**mission["fleet"], "payload_kg": 3}
        names.append(str(folder / f"{name}.json"))
        Path(names[-1]).write_text(json.dumps(whole))
    environment = {**os.environ, "PYTHONPATH": str(with_payloads(folder))}
    ran = subprocess.run([sys.executable, "-c", PLANS, *names], env=environment, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    read: Told = json.loads(ran.stdout)
    return read


@pytest.mark.parametrize("name", MISSIONS)
def test_robots_with_a_payload_are_planned_as_slower_ones_and_judged_as_such(told: Told, name: str) -> None:
    fastest, _, verdict, faults = told[name]
    assert fastest <= 1.8 * (1 + 1e-9)
    assert verdict in ("met", "nothing asked")
    assert "speed" in faults or 1.5 * fastest <= 1.8
    assert 1.5 * fastest > 1.8 or name == "swarm"  # in its first steps a swarm is slow


def test_the_bound_is_that_of_slower_robots(told: Told) -> None:
    sensor = DiscSensor(radius_m=5)
    slower, faster = (
        prove_bound(
            Mission(name="yard", area=box(0, 0, 30, 30), period_s=42, fleet=Fleet(speed_m_s=speed, sensor=sensor))
        )[0]
        for speed in (1.8, 2)
    )
    assert told["patrol"][1] == slower > faster
