"""The settings that Sun et al. 2019 print: Tables 2, 3 and 4, for its Figure 13."""

from __future__ import annotations

from rota_studies.sun2019_method.algorithms import TourSettings
from rota_studies.sun2019_method.deploy import DeploySettings
from rota_studies.sun2019_method.partition import PartitionSettings

TABLE_2 = DeploySettings(iterations=150, swarms=30, particles=50, sensors_max=160)
TABLE_3 = TourSettings(method="genetic", generations=10_000, population=600)
TABLE_4 = PartitionSettings(method="pso", times="routes", joining_legs=True, margin_s=0.5)
