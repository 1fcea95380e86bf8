"""The settings of the method as the paper's tables have them, for its own two maps; missions may say the same."""

from __future__ import annotations

from dataclasses import replace

from rota_studies.sun2019_method.mission_settings import SensorSettings, Sun2019

TABLE_7 = SensorSettings(iterations=200, swarms=40, particles=60, sensors_max=210)
"""Table 7: Figure 16's parameters."""

AS_PRINTED = Sun2019(
    deployment="ccpso2", tour="genetic", partition="pso", routes="printed", sensors=SensorSettings(sensors_max=160)
)
"""Section 5.1, Figure 13: Tables 2, 3 and 4, and routes as the paper has them, with nothing repaired."""

AS_PRINTED_FIGURE_16 = replace(AS_PRINTED, sensors=TABLE_7)
"""Section 5.3, Figure 16: Table 7 for the deployment, all else as in Section 5.1."""
