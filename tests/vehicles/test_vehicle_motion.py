"""Motion as trajectories, and the vehicles that are known."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from rota.errors import RotaError
from rota.vehicles.facts import Fact
from rota.vehicles.models import MODELS, model_of
from rota.vehicles.motion import Motion
from rota.vehicles.presets import VEHICLES, vehicle_named


def circle() -> Motion:
    """50 m of approach in 10 s, then 62.8 m round in 20 s, sampled often."""
    times_s = np.round(np.arange(0, 30.01, 0.05), 2)
    angle = np.pi * (times_s - 10) / 10
    x = np.where(times_s < 10, -50 + 5 * times_s + 10, 10 * np.cos(angle))
    y = np.where(times_s < 10, 0, 10 * np.sin(angle))
    places = np.column_stack([x, y, np.full(len(x), 7.0)])
    places[-1] = places[np.searchsorted(times_s, 10.0)]
    return Motion(
        robot="a", times_s=times_s, positions_m=places, loop_start_s=10.0, legs_s=np.array([20.0]), cut_m=np.zeros(1)
    )


@pytest.mark.parametrize("within_m", [0.5, 0.05, 0.005])
def test_trajectories_are_never_farther_off_than_they_may_be(within_m: float) -> None:
    motion = circle()
    made = motion.trajectory(flat=False, within_m=within_m)
    straight = np.column_stack([np.interp(motion.times_s, made.times_s, axis) for axis in made.positions_m.T])
    off_m = np.linalg.norm(straight - motion.positions_m, axis=1)
    assert off_m.max() <= within_m
    # a chord that spans so much of an angle is r (1 - cos(half of it)) off; Douglas & Peucker halve spans at worst
    fewest = np.pi / np.arccos(1 - within_m / 10)
    assert fewest < len(made.times_s) < 3 * fewest + 4
    assert (made.loop_start_s, made.loop_duration_s) == (10, 20)
    assert motion.trajectory(flat=True).positions_m.shape[1] == 2


def test_positions_are_asked_for_by_time_for_ever() -> None:
    motion = circle()
    at_m = motion.at(np.array([5.0, 15.0, 35.0, 10 + 20 * 1000 + 5.0]))
    np.testing.assert_allclose(at_m, [[-15, 0, 7], [0, 10, 7], [0, 10, 7], [0, 10, 7]], atol=1e-6)


def test_every_value_has_a_source_and_every_model_what_it_needs() -> None:
    for vehicle in VEHICLES.values():
        for field in dataclasses.fields(vehicle):
            fact = getattr(vehicle, field.name)
            if isinstance(fact, Fact):
                assert fact.value > 0, (vehicle.name, field.name)
                assert fact.parameter, (vehicle.name, field.name)
                assert fact.source, (vehicle.name, field.name)
    assert set(VEHICLES) == {
        "arducopter", "arducopter-tuned", "arducopter-targets", "px4", "dji", "arduplane", "agv", "turtlebot4", "none",
    }  # fmt: skip
    for name in MODELS:
        assert VEHICLES[name].formats
        model_of(VEHICLES[name])
    for name in VEHICLES.keys() - MODELS.keys():
        with pytest.raises(
            RotaError, match=f"{name}' is not allowed: what its firmware makes of a route is not modelled"
        ):
            model_of(VEHICLES[name])
    with pytest.raises(
        RotaError, match="--vehicle: 'arudcopter' is not one of 'arducopter', 'arducopter-tuned', 'arducopter-targets'"
    ):
        vehicle_named("arudcopter")
