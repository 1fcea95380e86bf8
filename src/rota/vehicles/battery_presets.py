"""Batteries of robots that one can buy, by their names: what makers publish, and nothing that they do not."""

from __future__ import annotations

from dataclasses import dataclass

from rota.vehicles.facts import Fact

MINUTE_S, HOUR_S = 60.0, 3600.0


@dataclass(frozen=True, kw_only=True)
class BatteryPreset:
    """A robot's battery as its maker tells it. None: not published.

    told: the robot, in words. moving_s, standing_s: how long it lasts; 0: it cannot stand. charging_s: from empty to
    full.
    """

    name: str
    told: str
    capacity_wh: Fact
    moving_s: Fact
    standing_s: Fact | None = None
    charging_s: Fact | None = None


def _fact(value: float, source: str, parameter: str) -> Fact:
    """A figure by its name at its source."""
    return Fact(value=value, parameter=parameter, source=source)


_M3E = "enterprise.dji.com/mavic-3-enterprise/specs"
_M350 = "enterprise.dji.com/matrice-350-rtk/specs"
_EVO = "autelrobotics.com/productdetail/evo-max-4t"
_DELTAQUAD = "DeltaQuad Operations Manual, Version 2, Vehicle specifications"
_CRAZYFLIE = "Bitcraze, Crazyflie 2.1 datasheet"
_MEDION = "MEDION, user manual of MD 19601, as at notice-facile.com"
_TURTLEBOT3 = "ROBOTIS e-Manual, TurtleBot3, Specifications, Burger"
_TURTLEBOT4 = "TurtleBot 4 User Manual, Features"

_ALL = (
    BatteryPreset(
        name="dji-mavic-3e",
        told="DJI Mavic 3 Enterprise, a quadcopter for mapping",
        capacity_wh=_fact(77.0, _M3E, "Energy 77 Wh"),
        moving_s=_fact(45 * MINUTE_S, _M3E, "Max Flight Time 45 min"),
        standing_s=_fact(38 * MINUTE_S, _M3E, "Max Hovering Time 38 min"),
    ),
    BatteryPreset(
        name="dji-matrice-350-rtk",
        told="DJI Matrice 350 RTK, a large quadcopter, with two batteries",
        capacity_wh=_fact(2 * 263.2, _M350, "Energy 263.2 Wh, twice"),
        moving_s=_fact(55 * MINUTE_S, _M350, "Max Flight Time 55 min"),
    ),
    BatteryPreset(
        name="autel-evo-max-4t",
        told="Autel EVO Max 4T V2, a quadcopter for inspection",
        capacity_wh=_fact(136.5, _EVO, "Energy 136.5 Wh"),
        moving_s=_fact(42 * MINUTE_S, _EVO, "Max Flight Time 42 min"),
        standing_s=_fact(37 * MINUTE_S, _EVO, "Max Hover Time 37 min"),
    ),
    BatteryPreset(
        name="deltaquad-pro-v2",
        told="DeltaQuad Pro V2, a wing that takes off and lands by rotors, as heavy as it may be",
        capacity_wh=_fact(23 * 4 * 3.7, _DELTAQUAD, "LiPo of 4 cells, of 3.7 V, and 23 Ah"),
        moving_s=_fact(110 * MINUTE_S, _DELTAQUAD, "Maximum flight time at max payload 1 h 50 min, with 90 % of it"),
        standing_s=_fact(0.0, _DELTAQUAD, "Stall speed 13 m/s, and no time of hovering"),
        charging_s=_fact(6 * HOUR_S, _DELTAQUAD, "Charging the LiPo, from empty in 6 h"),
    ),
    BatteryPreset(
        name="crazyflie-2.1",
        told="Bitcraze Crazyflie 2.1, a quadcopter of 27 g",
        capacity_wh=_fact(0.25 * 3.7, _CRAZYFLIE, "250 mAh LiPo, of 3.7 V"),
        moving_s=_fact(7 * MINUTE_S, _CRAZYFLIE, "Flight time with stock battery 7 min"),
        charging_s=_fact(40 * MINUTE_S, _CRAZYFLIE, "Charging time with stock battery 40 min"),
    ),
    BatteryPreset(
        name="medion-md-19601",
        told="MEDION MD 19601, a vacuum cleaner, at its highest power",
        capacity_wh=_fact(2.4 * 14.4, _MEDION, "Lithium-ion battery 14.4 V, 2400 mAh"),
        moving_s=_fact(HOUR_S, _MEDION, "Battery life 60 min at the highest power level"),
        charging_s=_fact(5 * HOUR_S, _MEDION, "Charging time 300 min"),
    ),
    BatteryPreset(
        name="turtlebot3-burger",
        told="ROBOTIS TurtleBot3 Burger, on the floor",
        capacity_wh=_fact(19.98, _TURTLEBOT3, "Battery 19.98 Wh"),
        moving_s=_fact(2.5 * HOUR_S, _TURTLEBOT3, "Expected operating time 2 h 30 min"),
        charging_s=_fact(2.5 * HOUR_S, _TURTLEBOT3, "Expected charging time 2 h 30 min"),
    ),
    BatteryPreset(
        name="turtlebot4",
        told="Clearpath TurtleBot 4, on the base of a vacuum cleaner",
        capacity_wh=_fact(26.0, _TURTLEBOT4, "Battery 26 Wh"),
        moving_s=_fact(2.5 * HOUR_S, _TURTLEBOT4, "Operation time 2 h 30 min, the least"),
        charging_s=_fact(2.5 * HOUR_S, _TURTLEBOT4, "Charging time 2 h 30 min"),
    ),
)
BATTERIES = {each.name: each for each in _ALL}
