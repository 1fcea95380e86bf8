"""What `rota fly` asks of a plan whose robots charge, and of where they are, before they start."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rota.errors import LinkError, RotaError

if TYPE_CHECKING:
    from rota.links.link import Link
    from rota.model.plan import Plan
    from rota.routes.route import Route

FAR_FROM_CHARGER_M = 5.0  # from the charger on which its plan begins: what places are told wrong by


def require_reliefs(plan: Plan, made: Link, link: str, hands_off: bool) -> None:
    """Raise RotaError for a plan whose robots charge, where they cannot be relieved."""
    from rota.routes.flights import recharges

    if not recharges(plan):
        return
    if not made.relieves:
        raise RotaError(
            f"the plan's robots charge, and on the link {link} they cannot be sent back and relieved: rota export"
            " writes their single flights, with a table of when each starts"
        )
    if hands_off:
        raise RotaError("--hands-off: the plan's robots charge; somebody has to tell them when to leave their chargers")


def routes_off_chargers(link: Link, plan: Plan, routes: Sequence[Route]) -> list[Route]:
    """The routes of robots that do not begin on their chargers; LinkError where one that does is not there."""
    import numpy as np

    from rota.routes.flights import on_charger

    docked = {way.robot for way in plan if on_charger(way, np.zeros(1))[0]}
    for route in routes:
        report = link.latest(route.robot)
        off_m = 0.0 if report is None else math.dist(report.position_m[:2], route.start_m[:2])
        if route.robot in docked and off_m > FAR_FROM_CHARGER_M:
            raise LinkError(
                f"robot {route.robot}: it is {off_m:.0f} m from the charger on which the plan begins for it; at most"
                f" {FAR_FROM_CHARGER_M:g} m are allowed"
            )
    return [route for route in routes if route.robot not in docked]
