"""A crowd of pyrvo: ``python peer_crowd.py PROBLEM.json`` makes a step for every line it reads, and prints CPU seconds.

Runs in an environment of its own, in which that package is installed and Rota is not. The first line it prints is the
package's version.
"""

from __future__ import annotations

import json
import math
import random
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pyrvo


def crowd_of(problem: dict[str, Any]) -> pyrvo.RVOSimulator:
    """Agents at random places of a square, each of which prefers to go on at full speed in a direction of its own."""
    crowd = pyrvo.RVOSimulator(
        problem["time_step_s"], problem["range_m"], problem["neighbours"], 1.0, 1.0, problem["body_m"],
        problem["speed_m_s"],
    )  # fmt: skip
    random_from = random.Random(0)
    for k in range(problem["robots"]):
        crowd.add_agent(tuple(random_from.uniform(1, problem["side_m"] - 1) for _ in range(2)))
        angle = random_from.uniform(0, 2 * math.pi)
        speed = problem["speed_m_s"]
        crowd.set_agent_pref_velocity(k, (speed * math.cos(angle), speed * math.sin(angle)))
    return crowd


if __name__ == "__main__":
    crowd = crowd_of(json.loads(Path(sys.argv[1]).read_text()))
    print(version("pyrvo"), flush=True)
    for _ in sys.stdin:
        began_s = time.process_time()
        crowd.do_step()
        print(time.process_time() - began_s, flush=True)
