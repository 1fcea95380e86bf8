"""Decisions on a GPU: refused where there is none, and on numba's simulator of one the same as on the processor.

The simulator runs the kernels' Python as it stands; that they compile for a GPU it does not show.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tests.planners.swarm.conftest import PAPER, in_box, scattered

from rota.errors import MissionError
from rota.planners.swarm.planner import DECIDE
from rota.planners.swarm.rollout import Swarm
from rota.planners.swarm.state import Hearing

PROJECT = Path(__file__).parents[3]
ROBOTS, STEPS = 14, 3


def has_gpu() -> bool:
    try:
        from numba import cuda

        return bool(cuda.is_available())
    except ImportError:
        return False


def test_without_a_gpu_the_error_says_what_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    if has_gpu():
        monkeypatch.setattr("numba.cuda.is_available", lambda: False)
    words = r"swarm.device: cuda is not possible here: .*an NVIDIA GPU .*numba-cuda are needed, or device: cpu"
    with pytest.raises(MissionError, match=words):
        in_box([[10, 10]], device="cuda")


def swarm(controller: str, device: str) -> Swarm:
    places = scattered(ROBOTS, 1, 14, 1.01, seed=3)
    speeds = np.random.default_rng(3).uniform(-1, 1, places.shape)
    return in_box(places, (60, 60), rule=PAPER, decide=DECIDE[controller], velocities_m_s=speeds, device=device)


def places_on_cuda() -> dict[str, list[list[float]]]:
    """What a process with the simulator comes to; also that messages are refused there."""
    found = {}
    for controller in DECIDE:
        there = swarm(controller, "cuda")
        for _ in range(STEPS):
            there.step()
        found[controller] = there.places_m.tolist()
    with pytest.raises(MissionError, match="cuda is for robots that know all at once"):
        in_box([[10, 10]], device="cuda", hearing=Hearing(delay_steps=1, lost=0.0))
    with pytest.raises(MissionError, match="neighbours: 33 is not allowed on the device cuda; at most 32"):
        in_box([[10, 10]], device="cuda", rule=PAPER._replace(neighbours=33))
    return found


@pytest.mark.slow  # numba's simulator runs uncompiled
def test_the_simulated_gpu_decides_as_the_processor_does() -> None:
    module = "tests.planners.swarm.test_cuda_step"
    program = f"import json; from {module} import places_on_cuda; print(json.dumps(places_on_cuda()))"
    # the simulator's arrays are Python objects, which compiled functions do not take
    environment = {**os.environ, "NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-W", "ignore", "-c", program]
    ran = subprocess.run(command, cwd=PROJECT, env=environment, capture_output=True, text=True, timeout=300)
    assert ran.returncode == 0, ran.stderr
    for controller, places in json.loads(ran.stdout).items():
        here = swarm(controller, "cpu")
        before = here.places_m
        for _ in range(STEPS):
            here.step()
        assert np.array(places) == pytest.approx(here.places_m, abs=1e-9)
        assert np.abs(here.places_m - before).max() > 0.1


@pytest.mark.skipif(not has_gpu(), reason="there is no GPU")
@pytest.mark.parametrize("controller", DECIDE)
def test_a_step_on_the_gpu_agrees_with_one_on_the_processor(controller: str) -> None:
    there, here = swarm(controller, "cuda"), swarm(controller, "cpu")
    there.step()
    here.step()
    assert there.places_m == pytest.approx(here.places_m, abs=1e-9)
