"""Circuits that come past places which others are for, so that these are launched less often."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota import DiscSensor, Fleet, Mission, PatrolSettings, Zone, check_plan, make_plan
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger
from rota.planners.patrol.circuits.ground import Circuit, visits_s
from rota.planners.patrol.circuits.launches import launches_between
from rota.planners.patrol.driving.timed_line import TimedLine, steady

PAD = Charger(name="pad", at=(3, 0), places=9)


def place(x: float, half_m: float = 1e-3) -> MultiPolygon:
    return MultiPolygon([box(x - half_m, -half_m, x + half_m, half_m)])


def there_and_back(x: float) -> TimedLine:
    """From the pad to a place on the line and back, at 1 m/s."""
    return steady(np.array([0.0, 3 - x, 2 * (3 - x)]), np.array([[3.0, 0], [x, 0], [3, 0]]))


def circuit(x: float, most_s: float) -> Circuit:
    return Circuit(charger=PAD, line=there_and_back(x), most_s=most_s, used_s=2 * (3 - x), place=place(x))


def test_a_place_is_visited_on_the_way_there_and_back_and_once_where_a_robot_turns() -> None:
    line = there_and_back(1.0)
    assert visits_s(line, place(2, 0.1)) == pytest.approx(np.array([[0.9, 1.1], [2.9, 3.1]]))
    assert visits_s(line, place(1, 0.1)) == pytest.approx(np.array([[1.9, 2.1]]))
    assert visits_s(line, place(3, 0.1)) == pytest.approx(np.array([[0, 0.1], [3.9, 4]]))
    assert visits_s(line, place(0, 0.1)).shape == (0, 2)
    stays = steady(np.array([0.0, 5]), np.array([[3.0, 0], [3, 0]]))
    assert visits_s(stays, place(3)) == pytest.approx(np.array([[0, 5]]))


def test_launches_fill_the_gaps_between_visits_on_the_way() -> None:
    """The far place every 10 s: robots are at the near one after 1 and 3 s, and 8 s later, of which 4 may pass."""
    found = launches_between([circuit(2, 4), circuit(1, 10)], 10)
    assert found.circuits.tolist() == [1, 0]
    assert found.begins_s == pytest.approx([0, 6], abs=1e-6)
    # every 20 s the far place takes two launches, and every 3 s the near one takes two more after each
    found = launches_between([circuit(2, 3), circuit(1, 10)], 20)
    assert found.circuits.tolist() == [1, 0, 0, 1, 0, 0]
    assert np.diff(found.begins_s)[[0, 2, 3]] == pytest.approx([4.667, 2.667, 4.667], abs=1e-3)


@pytest.mark.parametrize(
    ("pad_x", "periods_s", "recharge_s"),
    [
        pytest.param(3, {2: 4, 1: 10}, 3.5, id="the near place is on the way to the far one"),
        pytest.param(
            1, {1: 2, 0: 10}, 3.5, id="the near place is that of the pad, which the way takes just as long as"
        ),
    ],
)
def test_one_robot_does_for_two_places(pad_x: float, periods_s: dict[int, int], recharge_s: float) -> None:
    mission = Mission(
        name="line",
        area=MultiPolygon([box(-1, -1, 4, 1)]),
        zones=tuple(
            Zone(name=f"place {x}", shape=place(x), period_s=period_s, demand="visit")
            for x, period_s in periods_s.items()
        ),
        fleet=Fleet(
            speed_m_s=1, sensor=DiscSensor(radius_m=0.1), battery=BatteryLimits(endurance_s=7, recharge_s=recharge_s)
        ),
        chargers=(Charger(name="pad", at=(pad_x, 0), places=9),),
        planning=PatrolSettings(effort="quick"),
    )
    plan = make_plan(mission)
    assert (len(plan), check_plan(plan).verdict) == (1, "met")
