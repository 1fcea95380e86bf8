"""Wings in the check: where one that cannot stand does so, and for how long."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from tests.check.test_charging import mission

from rota.check import check_plan
from rota.model.battery_limits import BatteryLimits
from rota.model.plan import Charge, Plan, Trajectory

WING = BatteryLimits(endurance_s=100, standing_endurance_s=0, recharge_s=50, reserve_s=10)


def flown(*rows: tuple[float, float], docked_s: float = 20.0, loops: bool = True) -> Trajectory:
    """Docked at the pad at first, then at these times at these x."""
    times_s, xs_m = np.array([(0.0, 0.0), (docked_s, 0.0), *rows]).T
    charges = (Charge(charger="pad", from_s=0, until_s=docked_s),) if docked_s else ()
    return Trajectory(
        robot="a", times_s=times_s, positions_m=np.column_stack([xs_m, np.zeros(len(xs_m))]), charges=charges,
        loop_start_s=0.0 if loops else times_s[-1],
    )  # fmt: skip


@pytest.mark.parametrize(
    ("trajectory", "place_m", "time_s", "stands_s"),
    [
        (flown((30, 10), (33, 10), (35, 10), (45, 0)), (10, 0), 30, 5),  # two legs of one stay
        (flown((30, 10), (31, 10), (41, 0), (44, 0)), (10, 0), 30, 1),  # the first of two stays
        (flown((30, 10), (40, 0), (44, 0)), (0, 0), 40, 4),  # above the pad, and does not charge
        (flown((30, 10), loops=False), (10, 0), 30, 100),  # for ever
    ],
)
def test_where_a_wing_stands_is_told(
    trajectory: Trajectory, place_m: tuple[float, float], time_s: float, stands_s: float
) -> None:
    found = check_plan(Plan(mission=mission(WING), trajectories=(trajectory,))).violations
    (stands,) = [one for one in found if one.kind == "stands though it cannot"]
    assert (stands.who, stands.place_m, stands.time_s, stands.value) == ("a", place_m, time_s, stands_s)


def test_on_its_charger_a_wing_stands_and_others_do_anywhere() -> None:
    copter = BatteryLimits(endurance_s=100, recharge_s=50)
    for battery, rows in ((WING, [(30, 10), (40, 0)]), (copter, [(30, 10), (33, 10), (43, 0)])):
        plan = Plan(mission=mission(battery), trajectories=(flown(*rows),))
        assert check_plan(plan).verdict == "met"


@pytest.mark.parametrize("creeps_m", [1e-8, 1e-3])
def test_a_wing_that_creeps_stands(creeps_m: float) -> None:
    """To and fro on the spot, by turns with a moment at full speed: nothing flies at a thousandth of its speed."""
    rows = [(30.0, 10.0)]
    for k in range(4):
        time_s, x_m = rows[-1][0] + 2, 10 - creeps_m * (k % 2 == 0)
        rows += [(time_s, x_m), (time_s + 1e-6, x_m - 5e-7)]
    found = check_plan(Plan(mission=mission(WING), trajectories=(flown(*rows, (49, 0)),))).violations
    assert [(one.kind, one.time_s) for one in found] == [("stands though it cannot", 30)]


@pytest.mark.parametrize("row", [(30 + 1e-10, 10), (30 + 1e-10, 10 - 1e-10), (30 + 1e-10, 10 - 1e-13)])
def test_a_leg_of_a_moment_is_no_stay(row: tuple[float, float]) -> None:
    assert check_plan(Plan(mission=mission(WING), trajectories=(flown((30, 10), row, (41, 0)),))).verdict == "met"


@pytest.mark.parametrize("parts", [1, 500])
def test_loops_of_a_moment_hide_no_stay(parts: int) -> None:
    rows = [(30 + 1e-6 * k / parts, 10.0) for k in range(parts + 1)]
    way = dataclasses.replace(flown(*rows, loops=False), loop_start_s=30.0)
    kinds = [one.kind for one in check_plan(Plan(mission=mission(WING), trajectories=(way,))).violations]
    assert "stands though it cannot" in kinds


def test_a_wing_that_stays_on_its_charger_for_ever_does_not_stand_in_the_air() -> None:
    stays = Trajectory(
        robot="a", times_s=np.array([0.0, 20]), positions_m=np.zeros((2, 2)),
        charges=(Charge(charger="pad", from_s=0, until_s=20),), loop_start_s=20.0,
    )  # fmt: skip
    kinds = [one.kind for one in check_plan(Plan(mission=mission(WING), trajectories=(stays,))).violations]
    assert "stands though it cannot" not in kinds
