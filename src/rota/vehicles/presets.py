"""Vehicles by their names, as they come from their makers, and copters that are tuned."""

from __future__ import annotations

from dataclasses import replace

from rota.errors import RotaError
from rota.model.field_values import in_file_form
from rota.model.motion_limits import MotionLimits
from rota.vehicles.facts import Fact, Vehicle

_COPTER_4_6 = "ArduCopter 4.6, default"  # AC_WPNav.cpp, ArduCopter/config.h and ardupilot.org/copter/docs/parameters
_MEASURED = "flights of ArduPilot's simulated quadcopter near sea level, measured"
_TWICE = "AC_WPNav.cpp of ArduCopter 4.6: the default, 0, is twice WPNAV_ACCEL"
_STORAGE = "ArduPilot 4.6, StorageManager.cpp, a Copter's areas on boards with 16 KiB"
_PX4 = "PX4 Autopilot, multicopter_autonomous_params.c, default"
_PX4_LIMITS = "PX4 Autopilot, multicopter_position_control_limits_params.c, default"
_PX4_LAND = "PX4 Autopilot, multicopter_takeoff_land_params.c, default"
_DJI = "DJI Mobile SDK, DJIWaypoint and DJIWaypointV2"

ARDUCOPTER = Vehicle(
    name="arducopter",
    told="an ArduCopter by default parameters",
    formats=("qgroundcontrol", "waypoints"),
    speed_m_s=Fact(value=10.0, parameter="WPNAV_SPEED", source=_COPTER_4_6),
    acceleration_m_s2=Fact(value=2.5, parameter="WPNAV_ACCEL", source=_COPTER_4_6),
    corner_acceleration_m_s2=Fact(value=5.0, parameter="WPNAV_ACCEL_C", source=_TWICE),
    jerk_m_s3=Fact(value=1.0, parameter="WPNAV_JERK", source=_COPTER_4_6),
    corner_m=Fact(value=2.0, parameter="WPNAV_RADIUS", source=_COPTER_4_6),
    climb_m_s=Fact(value=2.5, parameter="WPNAV_SPEED_UP", source=_COPTER_4_6),
    descend_m_s=Fact(value=1.5, parameter="WPNAV_SPEED_DN", source=_COPTER_4_6),
    climb_m_s2=Fact(value=1.0, parameter="WPNAV_ACCEL_Z", source=_COPTER_4_6),
    arms_s=Fact(value=5.0, parameter="arming, and until it has left the ground", source=_MEASURED),
    land_m_s=Fact(value=0.5, parameter="LAND_SPEED", source=_COPTER_4_6),
    land_m=Fact(value=10.0, parameter="LAND_ALT_LOW", source=_COPTER_4_6),
    lean_deg=Fact(value=30.0, parameter="ANGLE_MAX", source=_COPTER_4_6),
    top_airspeed_m_s=Fact(
        value=10.0,
        parameter="at ANGLE_MAX",
        source=_MEASURED,
    ),
    most_items=Fact(value=650, parameter="(2422 + 2132 + 5204 - 4) bytes / 15", source=_STORAGE),
    most_fence_points=Fact(value=70, parameter="(48 + 256 + 256) bytes / 8", source=_STORAGE),
)
_RANGE = "the documented range's greatest, ardupilot.org/copter/docs/parameters"
ARDUCOPTER_TUNED = replace(
    ARDUCOPTER,
    name="arducopter-tuned",
    told="an ArduCopter with WPNAV_ACCEL 500 and WPNAV_JERK 5",
    acceleration_m_s2=Fact(value=5.0, parameter="WPNAV_ACCEL", source=_RANGE),
    corner_acceleration_m_s2=Fact(value=10.0, parameter="WPNAV_ACCEL_C", source=_TWICE),
    jerk_m_s3=Fact(value=5.0, parameter="WPNAV_JERK", source="a quarter of " + _RANGE),
)
_TARGETS = "rota fly's timed targets, as they ask of a copter (--set acceleration_m_s2=, corner_m=)"
_TO_SPARE = _TARGETS + ", less what is left to make up time"
ARDUCOPTER_TARGETS = replace(
    ARDUCOPTER,
    name="arducopter-targets",
    told="an ArduCopter driven by timed targets",
    formats=(),
    speed_m_s=Fact(value=8.0, parameter="nine tenths of the airspeed", source=_TO_SPARE),
    corner_acceleration_m_s2=Fact(value=2.5, parameter="acceleration_m_s2", source=_TO_SPARE),
    acceleration_m_s2=Fact(value=2.5, parameter="acceleration_m_s2", source=_TO_SPARE),
    jerk_m_s3=None,
    corner_m=Fact(value=1.5, parameter="corner_m", source=_TARGETS),
)
PX4 = Vehicle(
    name="px4",
    told="a PX4 multicopter by default parameters",
    speed_m_s=Fact(value=5.0, parameter="MPC_XY_CRUISE", source=_PX4),
    top_speed_m_s=Fact(
        value=12.0,
        parameter="MPC_XY_VEL_MAX",
        source=_PX4_LIMITS,
    ),
    acceleration_m_s2=Fact(value=3.0, parameter="MPC_ACC_HOR", source=_PX4),
    jerk_m_s3=Fact(value=4.0, parameter="MPC_JERK_AUTO", source=_PX4),
    corner_m=Fact(value=2.0, parameter="NAV_ACC_RAD", source="PX4 Autopilot, init.d/rc.mc_defaults"),
    climb_m_s=Fact(value=3.0, parameter="MPC_Z_V_AUTO_UP", source=_PX4),
    descend_m_s=Fact(value=1.5, parameter="MPC_Z_V_AUTO_DN", source=_PX4),
    # _updateTrajConstraints of FlightTaskAutoLineSmoothVel.cpp, later FlightTaskAuto.cpp
    climb_slowly_m_s=Fact(value=1.5, parameter="MPC_TKO_SPEED", source=_PX4_LAND),
    climb_slowly_m=Fact(value=10.0, parameter="MPC_LAND_ALT1", source=_PX4_LAND),
    ramp_s=Fact(value=3.0, parameter="MPC_TKO_RAMP_T", source=_PX4_LAND),
    arms_s=Fact(value=5.0, parameter="arming, and until it has left the ground", source="as an ArduCopter"),
    land_m_s=Fact(value=0.7, parameter="MPC_LAND_SPEED", source=_PX4_LAND),
    land_m=Fact(value=5.0, parameter="MPC_LAND_ALT2", source=_PX4_LAND),
    slow_m=Fact(value=10.0, parameter="MPC_LAND_ALT1", source=_PX4_LAND),
)
DJI = Vehicle(
    name="dji",
    told="a DJI aircraft on a wayline",
    acceleration_unknown=True,
    speed_m_s=Fact(value=15.0, parameter="autoFlightSpeed, the greatest", source=_DJI),
    top_speed_m_s=Fact(value=15.0, parameter="autoFlightSpeed, the greatest", source=_DJI),
    corner_m=Fact(value=0.2, parameter="cornerRadiusInMeters", source=_DJI),
)
_PLANE_4_6 = "ArduPlane 4.6, default"  # ArduPlane/config.h and AP_TECS.cpp
ARDUPLANE = Vehicle(
    name="arduplane",
    told="an ArduPlane by default parameters",
    speed_m_s=Fact(value=12.0, parameter="AIRSPEED_CRUISE", source=_PLANE_4_6),
    turn_radius_m=Fact(
        value=round(12.0**2 / 9.80665, 2),
        parameter="AIRSPEED_CRUISE, ROLL_LIMIT_DEG 45",
        source="a level turn's radius, the speed squared over g and the bank's tangent",
    ),
    climb_m_s=Fact(value=5.0, parameter="TECS_CLMB_MAX", source=_PLANE_4_6),
    descend_m_s=Fact(value=5.0, parameter="TECS_SINK_MAX", source=_PLANE_4_6),
    lean_deg=Fact(value=45.0, parameter="ROLL_LIMIT_DEG", source=_PLANE_4_6),
    top_airspeed_m_s=Fact(value=22.0, parameter="AIRSPEED_MAX", source=_PLANE_4_6),
)
_AGV = "vda-5050-lib.js, VirtualAgvAdapterOptions, default"
AGV = Vehicle(
    name="agv",
    told="a virtual AGV of Siemens' vda-5050-lib, which changes speed at once",
    flies=False,
    speed_m_s=Fact(value=2.0, parameter="vehicleSpeed", source=_AGV),
    top_speed_m_s=Fact(value=2.0, parameter="vehicleSpeed", source=_AGV),
)
_TURTLEBOT4 = "turtlebot4_navigation/config/nav2.yaml, FollowPath"
_CREATE3 = "iRobot Create 3 documentation, safety: its base"
TURTLEBOT4 = Vehicle(
    name="turtlebot4",
    told="a TurtleBot 4 under Nav2",
    flies=False,
    speed_m_s=Fact(value=0.26, parameter="max_vel_x", source=_TURTLEBOT4),
    top_speed_m_s=Fact(value=0.46, parameter="max_speed with safety_override full", source=_CREATE3),
    turn_rate_rad_s=Fact(value=1.0, parameter="max_vel_theta", source=_TURTLEBOT4),
    # Nav2's acc_lim_x, 2.5, is beyond what its base does
    acceleration_m_s2=Fact(value=0.9, parameter="wheel_accel_limit", source=_CREATE3),
)
NONE = Vehicle(name="none", told="a robot that changes speed at once")

VEHICLES = {
    each.name: each
    for each in (
        ARDUCOPTER,
        ARDUCOPTER_TUNED,
        ARDUCOPTER_TARGETS,
        PX4,
        DJI,
        ARDUPLANE,
        AGV,
        TURTLEBOT4,
        NONE,
    )
}

ON_MISSIONS = (ARDUCOPTER.name, ARDUCOPTER_TUNED.name)  # planned for as their firmware flies missions: models.MODELS


def vehicle_named(name: str, where: str = "--vehicle") -> Vehicle:
    """The vehicle of a name; raises RotaError for others, which says ``where`` it was given."""
    if name not in VEHICLES:
        raise RotaError(f"{where}: {name!r} is not one of {', '.join(map(repr, VEHICLES))}")
    return VEHICLES[name]


def vehicle_within(motion: MotionLimits) -> Vehicle:
    """The vehicle whose presets these limits are, with the values that they give otherwise."""
    assert motion.vehicle is not None, "limits of no vehicle"
    vehicle = vehicle_named(motion.vehicle, "vehicle")
    given = {name: value for name, value in in_file_form(motion).items() if name != "vehicle"}
    return replace(
        vehicle,
        **{
            name: replace(fact, value=value, source="as the mission gives it")
            for name, value in given.items()
            if (fact := getattr(vehicle, name, None)) is not None and fact.value != value
        },
    )
