"""What `rota fly` asks of robots that charge before they start."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest
from tests.relieved import relieved

from rota.command.fly_reliefs import routes_off_chargers
from rota.errors import LinkError
from rota.links.link import Link, Report
from rota.routes.route import route_of


def link_with(x_m: float) -> Link:
    """A link whose robots all say that they are so far east of the pad."""
    told = SimpleNamespace(latest=lambda robot: Report(robot=robot, time_s=0.0, position_m=(x_m, 0.0, 0.0)))
    return cast("Link", told)


def test_who_begins_on_a_charger_does_not_gather_in_the_air() -> None:
    """Of three robots the second one waits on the pad, the first takes off, and the third is under way."""
    plan = relieved(3)
    routes = [route_of(way, 0.0) for way in plan]
    assert [route.robot for route in routes_off_chargers(link_with(4.0), plan, routes)] == ["robot-1", "robot-3"]


def test_who_is_not_on_the_charger_where_its_plan_begins_is_named() -> None:
    plan = relieved(3)
    with pytest.raises(
        LinkError, match="robot robot-2: it is 50 m from the charger on which the plan begins for it; at"
    ):
        routes_off_chargers(link_with(50.0), plan, [route_of(way, 0.0) for way in plan])
