"""Trajectories of accelerated legs, and what plans and trajectories refuse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

from rota.errors import ArgumentError, PlanError
from rota.model.mission import DiscSensor, Fleet, Mission
from rota.model.plan import Plan, Trajectory

MISSION = Mission(
    name="yard",
    area=shapely.box(0, 0, 20, 10),
    period_s=60,
    fleet=Fleet(speed_m_s=5, sensor=DiscSensor(radius_m=4)),
)
LOOP: dict[str, Any] = {"robot": "a", "times_s": [0, 1, 2], "positions_m": [[0, 0], [1, 0], [0, 0]]}


def test_a_leg_from_rest_to_rest_of_its_end_is_a_parabola_in_time() -> None:
    there_and_back = {"times_s": [0, 2, 4], "positions_m": [[0, 0], [4, 0], [0, 0]], "accelerations_m_s2": [2, -2]}
    trajectory = Trajectory(robot="a", **there_and_back)
    assert trajectory.bends.tolist() == [1, -1]
    at_s = np.array([0.5, 1, 2, 3, 5])
    assert trajectory.at(at_s)[:, 0] == pytest.approx([0.25, 1, 4, 1, 1])  # a t^2 / 2; 4 - 4 u + u^2 on the way back
    assert trajectory.at(1).tolist() == [1, 0]


@pytest.mark.parametrize("asked", ["soon", None, [0, "soon"], float("nan"), [0, float("inf")]])
def test_what_is_no_time_has_no_place(asked: object) -> None:
    with pytest.raises(ArgumentError, match=r"^times_s: .* is not allowed; finite numbers of seconds are needed$"):
        Trajectory(**LOOP).at(asked)


def test_a_leg_that_would_begin_backwards_is_refused() -> None:
    with pytest.raises(PlanError, match=r"accelerations_m_s2\[0\] = 2.1; on this leg at most 2 m/s2"):
        Trajectory(robot="a", times_s=[0, 2], positions_m=[[0, 0], [4, 0]], accelerations_m_s2=[2.1], loop_start_s=2)
    with pytest.raises(PlanError, match="one per leg"):
        Trajectory(robot="a", times_s=[0, 2], positions_m=[[0, 0], [4, 0]], accelerations_m_s2=[0, 0], loop_start_s=2)


def test_far_away_a_leg_may_begin_at_rest_as_rounding_leaves_it() -> None:
    """At the northings of UTM, where places are told to 1e-9 m: from rest at 0.999 m/s2, over 2 to 8 cm."""
    for k in range(200):
        lasts_s = 0.2 + k / 1000
        far_m = 5.5e6 + k
        places_m = np.array([[5e5, far_m], [5e5, far_m + 0.999 * lasts_s**2 / 2]])
        told = {"positions_m": places_m, "accelerations_m_s2": [0.999], "loop_start_s": lasts_s}
        trajectory = Trajectory(robot="a", times_s=[0, lasts_s], **told)
        assert trajectory.bends[0] == pytest.approx(1, abs=1e-7)
        with pytest.raises(PlanError, match="backwards"):
            Trajectory(robot="a", times_s=[0, lasts_s * (1 + 1e-6)], **told | {"loop_start_s": lasts_s * (1 + 1e-6)})


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"robot": 3}, "robot: 3 is not allowed; text is needed"),
        ({"times_s": "x"}, "robot a: times_s: 'x' is not allowed; numbers are needed"),
        ({"positions_m": [[0, 0], [1]]}, "robot a: positions_m: [[0, 0], [1]] is not allowed; numbers are needed"),
        ({"headings_rad": {}}, "robot a: headings_rad: {} is not allowed; numbers are needed"),
        ({"loop_start_s": None}, "robot a: loop_start_s: None is not allowed; a number is needed"),
        ({"charges": 3}, "robot a: charges: 3 is not allowed; a Charge is needed"),
        ({"battery": "full"}, "robot a: battery = 'full'; 0 (empty) to 1 (full) is needed"),
    ],
)
def test_a_trajectory_refuses_what_is_of_another_type(given: dict[str, Any], message: str) -> None:
    with pytest.raises(PlanError) as caught:
        Trajectory(**LOOP | given)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"mission": None}, "mission: None is not allowed; a Mission is needed"),
        ({"trajectories": 3}, "trajectories: 3 is not allowed; a Trajectory is needed"),
        ({"trajectories": ["a"]}, "trajectories: 'a' is not allowed; a Trajectory is needed"),
        ({"seed": 1.5}, "seed: 1.5 is not allowed; a whole number is needed"),
        ({"lower_bound_robots": -1}, "lower_bound_robots: -1 is not allowed; it must be at least 0"),
        ({"lower_bound_reason": 3}, "lower_bound_reason: 3 is not allowed; text is needed"),
        ({"seam": 3}, "seam: 3 is not allowed; a Seam is needed"),
        ({"run_end": "rest"}, "run_end: 'rest' is not allowed; a RunEnd is needed"),
    ],
)
def test_a_plan_refuses_what_is_of_another_type(given: dict[str, Any], message: str) -> None:
    with pytest.raises(PlanError) as caught:
        Plan(**{"mission": MISSION, "trajectories": (Trajectory(**LOOP),)} | given)
    assert str(caught.value).startswith(message)


def test_a_plan_takes_a_list_of_trajectories_and_numbers_of_numpy() -> None:
    plan = Plan(mission=MISSION, trajectories=[Trajectory(**LOOP)], seed=np.int64(3), lower_bound_robots=np.int32(1))  # type: ignore[arg-type]
    assert plan == Plan(mission=MISSION, trajectories=(Trajectory(**LOOP),), seed=3, lower_bound_robots=1)


def test_a_plan_has_robots_by_name_and_its_trajectories() -> None:
    plan = Plan(mission=MISSION, trajectories=(Trajectory(**LOOP),))
    assert ("a" in plan, plan["a"] in plan, "b" in plan, 0 in plan) == (True, True, False, False)
