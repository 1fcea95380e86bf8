"""The settings of the method as the paper's tables have them, for its own two maps."""

from __future__ import annotations

from dataclasses import replace

from rota.planners.patrol.methods.sun2019.deploy_settings import TABLE_2, DeploySettings
from rota.planners.patrol.methods.sun2019.frame_settings import TABLE_3, TABLE_4
from rota.planners.patrol.methods.sun2019.route_settings import RouteSettings
from rota.planners.patrol.methods.sun2019.settings import MethodSettings

TABLE_7 = DeploySettings(iterations=200, swarms=40, particles=60, sensors_max=210)
"""Table 7: Figure 16's parameters."""

AS_PRINTED = MethodSettings(
    deployments=(TABLE_2,), tour=TABLE_3, partition=TABLE_4, route=RouteSettings(routes="printed")
)
"""Section 5.1, Figure 13: Tables 2, 3 and 4, and routes as the paper has them, with nothing repaired."""

AS_PRINTED_FIGURE_16 = replace(AS_PRINTED, deployments=(TABLE_7,))
"""Section 5.3, Figure 16: Table 7 for the deployment, all else as in Section 5.1."""
