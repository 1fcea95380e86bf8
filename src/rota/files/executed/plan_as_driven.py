"""The plan as a format drives it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from rota.files.executed.bags import as_bag
from rota.files.executed.flights_as_driven import Flown, fly_single_flights, with_stays
from rota.files.executed.mavlink import as_qgroundcontrol, as_waypoints
from rota.files.executed.timed_files import as_csv, as_geojson, as_gpx, as_kml
from rota.files.executed.written_routes import as_dji_waylines, as_nav2_waypoints, as_vda5050_orders
from rota.model.mission import Mission
from rota.model.plan import Plan, Trajectory

Driven = Callable[[Plan], tuple[Trajectory, ...]]


def _each(drives: Callable[[Plan, Trajectory], Trajectory]) -> Driven:
    return lambda plan: tuple(drives(plan, trajectory) for trajectory in plan)


DRIVEN: dict[str, Driven] = {
    "geojson": as_geojson,
    "csv": as_csv,
    "kml": as_kml,
    "gpx": as_gpx,
    "qgroundcontrol": _each(partial(as_qgroundcontrol, autopilot="ardupilot")),
    "qgroundcontrol-px4": _each(partial(as_qgroundcontrol, autopilot="px4")),
    "waypoints": _each(as_waypoints),
    "dji-wpml": _each(as_dji_waylines),
    "nav2": _each(as_nav2_waypoints),
    "vda5050": _each(as_vda5050_orders),
    "rosbag2": partial(as_bag, storage="mcap"),
    "rosbag2-sqlite3": partial(as_bag, storage="sqlite3"),
    "rosbag1": partial(as_bag, storage="rosbag1"),
}


def plan_as_driven(plan: Plan, name: str) -> Plan:
    """The plan with the trajectories that a format's files make, for names in ``DRIVEN``.

    Raises PlanError for what the format cannot say, as its export does. Vehicles are taken to drive each leg at the
    speed that they are told, to wait as long as they are told, and to lose no time where they speed up and brake; where
    the plan has them do so, they lose what they lose by plan. The plan's mission has no limits of motion then.
    """
    made = replace(plan, mission=_at_once(plan), trajectories=DRIVEN[name](plan))
    return replace(made, trajectories=tuple(with_stays(*pair) for pair in zip(plan, made, strict=True)))


def flights_as_driven(plan: Plan, name: str) -> tuple[Plan, tuple[Flown, ...]]:
    """The same of a plan whose robots charge, by the files of its single flights; and these flights."""
    made, flown = fly_single_flights(plan, DRIVEN[name])
    return replace(made, mission=_at_once(plan)), flown


def _at_once(plan: Plan) -> Mission:
    """The plan's mission without limits of motion."""
    return replace(plan.mission, fleet=plan.mission.fleet.changing_speed_at_once())
