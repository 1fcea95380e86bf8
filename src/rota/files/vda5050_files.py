"""Plan -> VDA 5050 orders as files: for each robot its order and the updates that follow, a message a line."""

from __future__ import annotations

import json
import os
import uuid
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from itertools import pairwise
from pathlib import Path
from typing import ClassVar

import numpy as np

from rota.errors import PlanError
from rota.files.robot_files import write_robot_files
from rota.files.timed_places import START, instant_text, require_dated
from rota.files.vda5050_orders import NumberedStops, Vehicle, Window, base_end, order_messages
from rota.files.vda5050_versions import SPOKEN, Protocol, WaitAction, protocol_of, wait_action_given
from rota.model.fleet import Robot
from rota.model.plan import Floats, Plan, Trajectory
from rota.model.planner_settings import Settings, setting
from rota.routes.driven_route import DURATION_S, from_start, rounds_within
from rota.routes.flights import Flight
from rota.routes.route import Route, route_of

SUFFIX = ".orders.jsonl"


@dataclass(frozen=True, kw_only=True)
class OrderSettings(Settings):
    """Settings of the export."""

    place: ClassVar[str] = "--set"
    duration_s: float = setting(DURATION_S, "how long the orders go on: whole rounds that end within it", above=0)
    manufacturer: str = setting("rota", "the vehicles' manufacturer, which their topics and orders name")
    version: str = setting("2.1.0", f"of VDA 5050, as the vehicles write it: {SPOKEN}")
    wait_action: str = setting("wait:duration", "the action that waits, and its parameter that takes seconds")
    charging: bool = setting(True, "flights end with the action startCharging")

    def __post_init__(self) -> None:
        super().__post_init__()
        if protocol_of(self.version) is None:
            raise PlanError(f"--set.version: {self.version!r} is not allowed; {SPOKEN} are spoken")
        if self.wait.parameter is None:
            raise PlanError(
                f"--set.wait_action: {self.wait_action!r} waits for a trigger, which nobody gives to orders from files;"
                " NAME:PARAMETER is needed"
            )

    @property
    def wait(self) -> WaitAction:
        """The action that waits."""
        return wait_action_given(self.wait_action, "--set.wait_action")


def write_vda5050_orders(
    plan: Plan,
    folder: str | os.PathLike[str],
    start: datetime = START,
    *,
    settings: OrderSettings | None = None,
    flights: Sequence[Flight] = (),
) -> tuple[Path, ...]:
    """Write one ``ROBOT.orders.jsonl`` per robot into ``folder`` (made if missing); returns their paths.

    Each line is a message for the topic ``order`` of the vehicle whose serial number is the robot's name: the order
    first, then updates that release the loop again and again, until as many whole rounds are released as end within
    the settings' duration, one at least. A message's timestamp is when it is to be sent: ``start`` for the order; for
    an update the instant at which the robot has as many stops ahead as one order releases.

    flights: those of the plan's robots that charge, in its order, where it is a ``plan_of_flights``. The orders of each
    are for the vehicle of the flight's robot, due from when it first starts on; where batteries are not swapped, the
    vehicle begins to charge at its end.

    Raises PlanError for plans with heights, of which VDA 5050 knows nothing, for names that it does not take and for
    dates after the year 9999; RotaError when the folder cannot be written to. Nothing is written on errors of the plan.
    """
    settings = settings or OrderSettings()
    swapping = {charger.name for charger in plan.mission.chargers if charger.swap_s is not None}
    own = dict(zip((each.robot for each in plan if each.charges), flights, strict=True)) if flights else {}

    def text_of(each: Trajectory) -> str:
        robot = plan.mission.fleet.robot(each.robot)
        return orders_text(each, settings, start, robot, own.get(each.robot), swapping)

    return write_robot_files(plan, folder, SUFFIX, text_of)


def orders_text(
    trajectory: Trajectory,
    settings: OrderSettings,
    start: datetime,
    robot: Robot,
    flight: Flight | None = None,
    swapping: Collection[str] = (),
) -> str:
    """One robot's messages. The order's id comes from what is ordered, so that another plan is another order.

    flight: of which the trajectory is; swapping: the chargers at which nothing is charged.
    """
    if trajectory.positions_m.shape[1] == 3:
        raise PlanError(f"robot {trajectory.robot}: its positions have heights, of which VDA 5050 knows nothing")
    vehicle = Vehicle(
        serial_number=flight.robot if flight else trajectory.robot,
        manufacturer=settings.manufacturer,
        protocol=Protocol(version=settings.version),
        wait=settings.wait,
    )
    route, window = route_of(trajectory, 0.0), Window()
    start += timedelta(seconds=flight.starts_s if flight else 0.0)
    arrivals_s = _arrivals_s(route, rounds_within(route, settings.duration_s))
    require_dated(trajectory.robot, start, float(arrivals_s[-1]))
    charges = flight is not None and settings.charging and flight.charger not in swapping
    stops = NumberedStops(route, robot.turn_rate_rad_s, charges)
    ordered = (stops.once, stops.every_round, *([trajectory.robot] if flight else []))
    order_id = str(uuid.uuid5(uuid.NAMESPACE_OID, repr(ordered)))

    def timestamp(first: int) -> str:
        return instant_text(start + timedelta(seconds=float(arrivals_s[max(first - window.released, 0)])))

    lines: list[str] = []
    for message in order_messages(stops, vehicle, order_id, window=window, timestamp=timestamp):
        lines.append(json.dumps(message, allow_nan=False, separators=(",", ":")) + "\n")
        if base_end(message) >= len(arrivals_s) - 1:
            break
    return "".join(lines)


def _arrivals_s(route: Route, rounds: int) -> Floats:
    """(n,) seconds after the start at which the robot is at each stop, up to the end of so many rounds."""
    stops = [*from_start(route), *(route.every_round * rounds)]
    legs_s = [before.hold_s + stop.drive_s(before.place_m) for before, stop in pairwise(stops)]
    return np.concatenate([[0.0], np.cumsum(legs_s)])
