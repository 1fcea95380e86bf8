"""The keys of a mission file that say how fast robots change speed and direction; fleet and robots have them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field

from rota.files.schema_block import Block, LengthOrZero, NotNegative, Rate
from rota.model.motion_limits import MOTION_FIELDS
from rota.vehicles.presets import VEHICLES

DRIVING = ("speed_m_s", "turn_rate_rad_s", "turn_radius_m", *MOTION_FIELDS)  # what vehicles preset

if TYPE_CHECKING:
    VehicleName = str
else:
    VehicleName = Literal[tuple(VEHICLES)]  # the presets are the one place that names them
ON_THE_FLOOR = [each.name for each in VEHICLES.values() if not each.flies]
PRESETS: Any = {name: each.preset(DRIVING) for name, each in VEHICLES.items()}
WITH_SPEED: list[Any] = [each.name for each in VEHICLES.values() if each.speed_m_s is not None]


class MotionBlock(Block):
    """Limits of motion, and the vehicle that has those which are not given."""

    vehicle: VehicleName | None = Field(
        None,
        description="presets speeds, turns and motion that are not given; none: changes speed at once",
        json_schema_extra={"presets": PRESETS},
    )
    acceleration_m_s2: Rate | None = Field(None, description="along the way; null: speeds change at once")
    corner_acceleration_m_s2: Rate | None = Field(None, description="round a corner; null: as along the way")
    jerk_m_s3: Rate | None = Field(None, description="how fast the acceleration changes; null: at once")
    corner_m: LengthOrZero | None = Field(None, description="how far corners may be cut; 0 or null: robots stop there")
    climb_m_s: Rate | None = None
    descend_m_s: Rate | None = None
    top_airspeed_m_s: Rate | None = Field(None, description="through the air, whatever the wind; null: no such limit")
    wind_m_s: NotNegative | None = Field(None, description="from wherever it blows; it takes from top_airspeed_m_s")
