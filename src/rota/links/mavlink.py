"""The link to MAVLink vehicles by MAVSDK; needs the extra ``mavlink``."""

from __future__ import annotations

from rota.files.geodesy import projection_of
from rota.links.expected_lags import expected_lags
from rota.links.extras import required
from rota.links.mavlink_flight_link import MavlinkFlightLink
from rota.links.mavlink_link import MavlinkLink, MavlinkSettings
from rota.links.mavlink_target_link import MavlinkTargetLink
from rota.model.plan import Plan
from rota.routes.flights import recharges

SETTINGS = MavlinkSettings


def link_to(plan: Plan, settings: MavlinkSettings) -> MavlinkLink:
    """A vehicle for each robot of the plan, in its order, driven in the way that the settings say."""
    required("mavsdk", "mavlink")
    projection = projection_of(plan.mission, "MAVLink")
    # curves of a plan's own, and reliefs, are flown by targets; waypoints are made for missions
    told = recharges(plan) or any(each.accelerations_m_s2 is not None and each.waypoints is None for each in plan)
    if settings.way == "targets" or (settings.way == "auto" and told):
        return MavlinkTargetLink(plan, projection, settings)
    if recharges(plan):
        return MavlinkFlightLink(plan, projection, settings)
    top_m_s = {way.robot: plan.mission.fleet.robot(way.robot).speed_m_s for way in plan}
    return MavlinkLink(top_m_s, plan.mission.area.bounds, projection, settings, expected_lags(plan))
