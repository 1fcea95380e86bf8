"""How long robots take at least for what they planned: what their speed and the wind allow."""

from __future__ import annotations

import numpy as np

from rota.errors import MissionError
from rota.model.arrays import Floats
from rota.model.fleet import Robot
from rota.model.plan import Plan
from rota.model.trajectory import Trajectory
from rota.vehicles.motion import Wind


def least_times_s(plan: Plan, wind: Wind, tick_s: float, ticks: int) -> Floats:
    """How long each robot takes at least for what its plan has in each tick, (k, ticks) seconds."""
    planned_s: Floats = tick_s * np.arange(ticks + 1, dtype=np.float64)
    rows = [_spent_s(way, plan.mission.fleet.robot(way.robot), wind, planned_s) for way in plan]
    return np.diff(np.array(rows).reshape(-1, ticks + 1), axis=1)


def round_shares(plan: Plan, wind: Wind) -> Floats:
    """What share of a round's planned time each robot takes for it at least, (k,); 0 for one that stays."""
    shares = []
    for way in plan:
        legs_s = _legs_s(way, plan.mission.fleet.robot(way.robot), wind)[way.loop_index :]
        shares.append(legs_s.sum() / way.loop_duration_s if way.loop_duration_s else 0.0)
    return np.array(shares, np.float64)


def require_headway(plan: Plan, wind_m_s: float) -> None:
    """Raise MissionError for robots that do not get on against such wind."""
    for way in plan:
        robot = plan.mission.fleet.robot(way.robot)
        if wind_m_s >= _airspeed_m_s(robot) and way.loop_duration_s:
            raise MissionError(
                f"wind_m_s: {wind_m_s:g} is not allowed; {way.robot} makes {_airspeed_m_s(robot):g} m/s through the air"
                " and does not get on against so much"
            )


def _airspeed_m_s(robot: Robot) -> float:
    top_m_s = robot.motion.top_airspeed_m_s
    return robot.speed_m_s if top_m_s is None else top_m_s


def _spent_s(way: Trajectory, robot: Robot, wind: Wind, planned_s: Floats) -> Floats:
    """How much of the least time has gone by at each of the plan's times (n,)."""
    spent_s = np.concatenate([[0.0], np.cumsum(_legs_s(way, robot, wind))])
    loop_s = way.loop_duration_s
    if loop_s == 0:
        return np.asarray(np.interp(planned_s, way.times_s, spent_s))
    rounds = np.maximum(np.floor((planned_s - way.loop_start_s) / loop_s), 0.0)
    once_s = np.interp(planned_s - rounds * loop_s, way.times_s, spent_s)
    return np.asarray(once_s + rounds * (spent_s[-1] - spent_s[way.loop_index]))


def _legs_s(way: Trajectory, robot: Robot, wind: Wind) -> Floats:
    """How long each leg takes at least, (n - 1,).

    Robots that change speed at once make up for lost time on legs that they planned to drive slower than they can, and
    leave waits out. Those with a mass do not, nor do those that need the time to turn where they stand. How long a
    charge takes is the battery's.
    """
    planned_s = np.diff(way.times_s)
    flat_m = np.diff(way.positions_m[:, :2], axis=0)
    lengths_m = np.hypot(*flat_m.T)
    if robot.motion.has_mass:
        legs_s = planned_s
    else:
        legs_s = np.minimum(planned_s, lengths_m / robot.ground_speed_m_s)
        if robot.turn_rate_rad_s is not None:
            legs_s = np.where(lengths_m > 0, legs_s, planned_s)
    for charge in way.charges:
        docked = (way.times_s[:-1] >= charge.from_s) & (way.times_s[1:] <= charge.until_s)
        legs_s = np.where(docked, 0.0, legs_s)
    if not wind.speed_m_s:
        return legs_s
    toward = np.array(wind.toward_m_s)
    along_m_s = np.divide(flat_m @ toward, lengths_m, out=np.zeros(len(lengths_m)), where=lengths_m > 0)
    across2 = wind.speed_m_s**2 - along_m_s**2
    in_wind_m_s = along_m_s + np.sqrt(np.maximum(_airspeed_m_s(robot) ** 2 - across2, 0.0))
    return np.asarray(np.maximum(legs_s, lengths_m / in_wind_m_s))
