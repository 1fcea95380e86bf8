"""The motion models by the vehicles that have one."""

from __future__ import annotations

from rota.errors import RotaError
from rota.vehicles.ardupilot_auto import ArduPilotAuto
from rota.vehicles.facts import Vehicle
from rota.vehicles.motion import MotionModel
from rota.vehicles.presets import ON_MISSIONS

MODELS = dict.fromkeys(ON_MISSIONS, ArduPilotAuto)


def model_of(vehicle: Vehicle) -> MotionModel:
    """The motion model of a vehicle; raises RotaError for one without."""
    if vehicle.name not in MODELS:
        raise RotaError(
            f"--vehicle: {vehicle.name!r} is not allowed: what its firmware makes of a route is not modelled yet; it is"
            f" for {', '.join(MODELS)}"
        )
    return MODELS[vehicle.name](vehicle)
