"""Kinds of robots that share a place at a charger in time."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import MultiPolygon, box

from rota import DiscSensor, Fleet, Mission, PatrolSettings, Plan, Trajectory, Zone, check_plan, make_plan
from rota.model.battery_limits import BatteryLimits
from rota.model.mission import Charger, Kind
from rota.model.plan import Charge
from rota.planners.patrol.kinds.parts import later_with_room, turns_beside

PAD = Charger(name="pad", at=(50, 5), places=1)
ZONES = tuple(
    Zone(name=name, period_s=60, shape=MultiPolygon([box(x, 0, x + 40, 10)]), sensors=(name,))
    for name, x in (("thermal", 0), ("rgb", 60))
)


def mission_of(*recharge: float) -> Mission:
    """Two zones, each for a kind of its own, with a charger of one place between them."""
    kinds = tuple(
        Kind(name=f"{zone.name} kind", cost=1, sensor=DiscSensor(radius_m=6, name=zone.name), speed_m_s=speed_m_s,
             battery=BatteryLimits(endurance_s=endurance_s, recharge_s=share * endurance_s))
        for zone, speed_m_s, endurance_s, share in zip(ZONES, (6, 8), (300, 410), recharge, strict=True)
    )  # fmt: skip
    return Mission(
        name="two kinds", area=MultiPolygon([box(0, 0, 100, 10)]), zones=ZONES, chargers=(PAD,),
        fleet=Fleet(speed_m_s=6, sensor=DiscSensor(radius_m=6), kinds=kinds), planning=PatrolSettings(effort="quick"),
    )  # fmt: skip


def round_of(name: str, lasts_s: float, *stays_s: tuple[float, float]) -> Trajectory:
    """A robot that stands on the pad all the time, and charges in these spans of each round."""
    times_s = np.unique(np.concatenate([[0.0, lasts_s], *stays_s]))
    charges = tuple(Charge(charger="pad", from_s=a, until_s=b) for a, b in stays_s)
    return Trajectory(robot=name, times_s=times_s, positions_m=np.tile([50.0, 5.0], (len(times_s), 1)), charges=charges)


def test_two_kinds_charge_at_one_place_one_after_the_other() -> None:
    plan = make_plan(mission_of(0.1, 0.15))
    assert check_plan(plan).verdict == "met"
    assert {way.robot.split("-")[0] for way in plan} == {"thermal kind", "rgb kind"}


@pytest.mark.parametrize(
    ("mine", "theirs", "has_room"),
    [
        (round_of("thermal kind-1", 10, (0, 4)), round_of("rgb kind-1", 10, (1, 6)), True),
        (round_of("thermal kind-1", 10, (0, 5)), round_of("rgb kind-1", 10, (1, 6)), True),
        (round_of("thermal kind-1", 10, (0, 5)), round_of("rgb kind-1", 10, (1, 6.5)), False),
        # twice in each round of the other one, 7 s apart and 13 s
        (round_of("thermal kind-1", 20, (2, 5), (9, 12)), round_of("rgb kind-1", 10, (1, 4)), True),
        (round_of("thermal kind-1", 20, (2, 5), (9, 12)), round_of("rgb kind-1", 10, (1, 6)), False),
    ],
)
def test_a_plan_begins_when_there_is_room_beside_others(mine: Trajectory, theirs: Trajectory, has_room: bool) -> None:
    mission = mission_of(0.2, 0.3)
    later = later_with_room(Plan(mission=mission, trajectories=(mine,)), [theirs], [PAD])
    assert (later is not None) == has_room
    if later is not None:
        moments_s = np.arange(0.05, 60, 0.1)
        both = [
            sum((moments_s % way.loop_duration_s >= stay.from_s) & (moments_s % way.loop_duration_s < stay.until_s)
                for stay in way.charges)
            for way in (*later, theirs)
        ]  # fmt: skip
        assert max(both[0] + both[1]) == 1


def test_turns_beside_others_repeat_together_with_them() -> None:
    plan = Plan(mission=mission_of(0.2, 0.3), trajectories=(round_of("thermal kind-1", 12, (0, 5)),))
    assert turns_beside(plan).tolist() == pytest.approx([3, 4, 6, 8, 9, 12, 16, 18, 24, 36, 48])
