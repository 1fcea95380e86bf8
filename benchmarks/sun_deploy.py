"""Sensor deployment of Sun et al. 2019 on the reconstructed Figure 13: its swarms, and set covers beside them."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from typing import NamedTuple

from benchmarks.missions import EXAMPLES
from benchmarks.row import Options, Row
from benchmarks.sun_tables import TABLE_2
from rota.files.mission_file import read_mission
from rota_studies.sun2019_method.deploy import DeploySettings
from rota_studies.sun2019_stages.deploy import Deployment, deploy_sensors

SEEDS = range(5)
MOST_SENSORS, MOST_S, MOST_EXACT = 96, 60, 89


class Deployed(NamedTuple):
    """One deployment, and the processor seconds of all threads that it took."""

    deployment: Deployment
    cpu_s: float

    @property
    def sensors(self) -> int:
        """How many sensors there are."""
        return len(self.deployment.positions_m)

    @property
    def told(self) -> str:
        """Sensors in all, and in each zone."""
        return f"{self.sensors} ({'/'.join(str(len(zone.positions_m)) for zone in self.deployment.zones)})"


def sun_deploy(options: Options) -> Iterator[Row]:
    """The improved CCPSO2 with the settings of Table 2, the same without heuristic rules, greedy and exact cover."""
    deployed(DeploySettings(iterations=2, particles=2), 0)  # compiles
    with_rules = [deployed(TABLE_2, seed) for seed in SEEDS]
    without = [deployed(TABLE_2.without_rules(), seed) for seed in SEEDS]
    asked = f"at most {MOST_SENSORS} sensors (the paper: 96 as 10/15/71), < {MOST_S} s"
    reached = all(run.sensors <= MOST_SENSORS and run.cpu_s < MOST_S for run in with_rules)
    yield Row("Sun 2019, deployment, CCPSO2 with rules, Table 2", asked, swarms_told(with_rules), reached)
    fewer = all(one.sensors < other.sensors for one, other in zip(with_rules, without, strict=True))
    asked = "more sensors than with rules (the paper, Figure 6: 103 and 99)"
    yield Row("Sun 2019, deployment, CCPSO2 without rules, Table 2", asked, swarms_told(without), fewer)
    cover = deployed(DeploySettings(method="greedy"), 0)
    yield Row("Sun 2019, deployment, greedy cover", "", f"{cover.told} sensors; CPU {cover.cpu_s:.1f} s", None)
    cover = deployed(DeploySettings(method="exact"), 0)
    least = sum(one.least or 0 for zone in cover.deployment.zones for one in zone.covers)
    measured = f"{cover.told} sensors (bound {least} for its places); CPU {cover.cpu_s:.1f} s"
    reached = cover.sensors <= MOST_EXACT
    yield Row("Sun 2019, deployment, exact cover", f"at most {MOST_EXACT} sensors", measured, reached)


def deployed(settings: DeploySettings, seed: int) -> Deployed:
    """Deploy on Figure 13's map."""
    mission = read_mission(EXAMPLES / "sun2019-fig13.yaml").mission
    began_s = time.process_time()
    deployment = deploy_sensors(mission, settings, seed=seed)
    return Deployed(deployment, time.process_time() - began_s)


def swarms_told(runs: list[Deployed]) -> str:
    """Sensors of all seeds, and the median of the times."""
    cpu_s = statistics.median(run.cpu_s for run in runs)
    return f"{', '.join(run.told for run in runs)} sensors with {len(runs)} seeds; CPU {cpu_s:.1f} s"
