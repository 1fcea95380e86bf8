"""Arguments of other types are refused by their names, before anything is done."""

from __future__ import annotations

import inspect
import pickle
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

import rota
from rota.argument_types import with_types_required

MISSION = rota.Mission(
    name="yard",
    area=shapely.box(0, 0, 20, 10),
    period_s=60,
    fleet=rota.Fleet(robots=1, speed_m_s=5, sensor=rota.DiscSensor(radius_m=4)),
)
LOOP = rota.Trajectory(robot="robot-1", times_s=[0, 4, 8], positions_m=[[5, 5], [15, 5], [5, 5]])
PLAN = rota.Plan(mission=MISSION, trajectories=(LOOP,))
FUNCTIONS = [name for name in rota.__all__ if inspect.isfunction(getattr(rota, name))]


def refused(message: str, name: str, *args: Any, **kwargs: Any) -> None:
    """The public function refuses these arguments with this message, as a TypeError and as an error of Rota's."""
    with pytest.raises(rota.ArgumentError) as caught:
        getattr(rota, name)(*args, **kwargs)
    assert str(caught.value) == message
    assert isinstance(caught.value, TypeError)
    assert isinstance(caught.value, rota.RotaError)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_refuses_what_its_first_argument_cannot_be(name: str) -> None:
    signature = inspect.signature(getattr(rota, name))
    first, *others = signature.parameters.values()
    required = {other.name: 1 for other in others if other.default is inspect.Parameter.empty}
    with pytest.raises(rota.ArgumentError, match=f"^{first.name}: 3.5 is not allowed; .* is needed$"):
        getattr(rota, name)(3.5, **required)


def test_messages_say_what_to_give() -> None:
    read = rota.read_mission(Path(__file__).parents[1] / "examples" / "harbour.yaml")
    refused("mission: a ReadMission is not allowed; a rota.Mission is needed; its .mission is one", "make_plan", read)
    needed = "a rota.Plan is needed; rota.read_plan(...) reads one from a file"
    refused(f"plan: 'a.rota.json' is not allowed; {needed}", "check_plan", "a.rota.json")
    refused("plan: a Mission is not allowed; a rota.Plan is needed", "check_plan", MISSION)
    refused("seed: 1.5 is not allowed; a whole number is needed", "make_plan", MISSION, seed=1.5)
    refused("seed: True is not allowed; a whole number is needed", "make_plan", MISSION, seed=True)
    refused("time_limit_s: '3' is not allowed; a number is needed", "make_plan", MISSION, time_limit_s="3")
    refused("progress: 3 is not allowed; what can be called is needed", "make_plan", MISSION, progress=3)
    refused("lost: 'robot-1' is not allowed; a list of text is needed", "replan", PLAN, at_s=1, lost="robot-1")
    refused("late: ['robot-1'] is not allowed; a mapping is needed", "replan", PLAN, at_s=1, late=["robot-1"])
    refused("hands_off: 1 is not allowed; True or False is needed", "rehearse", PLAN, hands_off=1)
    refused("path: 3 is not allowed; text or a path is needed", "read_plan", 3)
    refused("ax: 3 is not allowed; an Axes of matplotlib is needed", "draw_plan", PLAN, ax=3)


def test_values_out_of_range_are_refused_too() -> None:
    for finest_m in (0, -1, float("nan"), float("inf")):
        with pytest.raises(rota.MissionError, match=r"finest_m: .* is not allowed; must be a finite number"):
            rota.check_plan(PLAN, finest_m=finest_m)
    with pytest.raises(rota.MissionError, match="seed: -1 is not allowed; must be at least 0"):
        rota.make_plan(MISSION, seed=-1)
    for points in (3, "a", [1, 2], [[0, 0, 0]], [[float("nan"), 0]], [["x", 0]]):
        with pytest.raises(rota.MissionError, match=r"points_m: .*an array of \(n, 2\) are needed"):
            rota.worst_gaps_s(PLAN, points)  # type: ignore[arg-type]
    assert rota.worst_gaps_s(PLAN, []).shape == (0,)  # type: ignore[arg-type]


def test_what_numpy_calls_numbers_is_taken_and_unknown_types_are_not_looked_at() -> None:
    def take(
        count: int, share: float, names: Iterable[str], values: Mapping[str, float] | None, flag: bool, other: Unknown  # noqa: F821
    ) -> tuple[Any, ...]:  # fmt: skip
        return count, share, names, values, flag, other

    given = (np.int64(3), np.float32(2), {"a", "b"}, None, np.bool_(True), object())
    checked = with_types_required(take)
    assert checked(*given) == given
    assert checked(3, 2, iter("ab"), {}, False, 3)[0] == 3
    with pytest.raises(rota.ArgumentError, match=r"names: \['a', 3\] is not allowed"):
        checked(3, 2, ["a", 3], None, True, None)
    with pytest.raises(TypeError, match="missing 5 required positional arguments"):
        checked(3)


def test_functions_are_found_again_where_they_are_sent_to_another_process() -> None:
    for name in FUNCTIONS:
        assert pickle.loads(pickle.dumps(getattr(rota, name))) is getattr(rota, name)
