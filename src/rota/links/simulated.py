"""Vehicles in this process: the link that needs nothing, for trying a plan and what watches it.

They drive their routes at paces of their own, are held up, report late or not at all, run down and fail, all from a
seed. Their clock goes on while reports are taken, in real time, scaled, or as fast as they are taken.
"""

from __future__ import annotations

import asyncio
import heapq
import math
import time
from collections.abc import AsyncGenerator, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, get_args

import numpy as np

from rota.errors import LinkError, RotaError
from rota.links.inbox import Bounds
from rota.links.link import Mode, Order, Report
from rota.links.reporting import ReportingLink
from rota.links.vehicles import HOME_SPEED_M_S, Pads, Vehicle, Vehicles, drive_home, drive_of
from rota.model.battery_limits import BatteryLimits
from rota.model.plan import Plan
from rota.model.planner_settings import Settings, setting
from rota.routes.route import Place3, Route, route_of

FaultKind = Literal["refuses", "half", "silent", "wrong-type", "dies", "stuck", "nan", "future"]
LATER_FAULTS = ("dies", "stuck", "nan", "future")
FAULTS = "ROBOT:refuses, :half, :silent, :wrong-type, :dies@S, :stuck@S, :nan@S or :future@S, with + between"
SILENCE_S = 5.0  # in which a link gives up


@dataclass(frozen=True, kw_only=True)
class SimulatedSettings(Settings):
    """Settings of the link ``simulated``."""

    place: ClassVar[str] = "simulated"
    seed: int = setting(0, "the same seed and orders give the same reports", least=0)
    clock: float = setting(1.0, "simulated seconds in a second; 0: as fast as reports are taken", least=0, most=1e6)
    rate_hz: float = setting(5.0, "reports of each vehicle in a second", above=0, most=1000)
    slower: float = setting(0.0, "share by which each vehicle is slower than it is told", least=0, most=0.9)
    speed_noise: float = setting(0.02, "standard deviation of a vehicle's pace, as a share", least=0, most=1)
    stop_noise_s: float = setting(0.0, "time lost at each stop, about so much more or less often", least=0, most=1e4)
    position_noise_m: float = setting(0.1, "standard deviation of reported places, each axis", least=0, most=1e6)
    delay_s: float = setting(0.1, "mean time that a report takes", least=0, most=1e4)
    lost: float = setting(0.0, "share of reports that never arrive", least=0, most=1)
    battery_s: float | None = setting(
        None, "how long a battery lasts; none: as the plan says, or for ever", above=0, most=1e10
    )
    slower_charging: float = setting(0.0, "share by which batteries fill slower than planned", least=0, most=0.99)
    holdups_per_h: float = setting(0.0, "how often a vehicle is held up", least=0, most=1e5)
    holdup_s: float = setting(10.0, "mean time that it is held up for", least=0, most=1e6)
    failures_per_h: float = setting(0.0, "how often a vehicle dies, silent from then on", least=0, most=1e5)
    faults: str = setting("", f"of single vehicles: {FAULTS}")


SETTINGS = SimulatedSettings


@dataclass(frozen=True, kw_only=True)
class Fault:
    """What is wrong with a vehicle, from ``from_s`` on."""

    kind: FaultKind
    from_s: float = 0.0


def link_to(plan: Plan, settings: SimulatedSettings) -> SimulatedLink:
    """Simulated vehicles for all robots of a plan, each where its robot begins."""
    altitude_m = plan.mission.fleet.altitude_m
    homes = {trajectory.robot: route_of(trajectory, altitude_m).start_m for trajectory in plan}
    top_m_s = {trajectory.robot: plan.mission.fleet.robot(trajectory.robot).speed_m_s for trajectory in plan}
    batteries = [plan.mission.fleet.robot(way.robot).battery for way in plan]
    return SimulatedLink(homes, plan.mission.area.bounds, top_m_s, settings, batteries, _pads(plan, settings))


def _pads(plan: Plan, settings: SimulatedSettings) -> Pads | None:
    """The plan's chargers; one that swaps batteries fills them evenly over that time."""
    if not plan.mission.chargers:
        return None
    robots, chargers = [plan.mission.fleet.robot(way.robot) for way in plan], plan.mission.chargers
    lasts_s = [[pad.swap_s or robot.battery.recharge_s or math.inf for pad in chargers] for robot in robots]
    places_m = np.array([pad.at for pad in chargers], np.float64)
    fills = (1 - settings.slower_charging) / np.array(lasts_s, np.float64)
    landing_s, climbing_s = (
        np.array([getattr(robot.battery, name) for robot in robots], np.float64) for name in ("landing_s", "climbing_s")
    )
    return Pads(places_m, fills, landing_s, climbing_s)


class SimulatedLink(ReportingLink):
    """A Link to vehicles that stand at ``homes`` until they are told otherwise; see the module."""

    takes_fences = True
    drives_along = True
    keeps_phase = True
    relieves = True
    in_process = True
    heard_by_one = True
    begun_s = 0.0

    def __init__(
        self,
        homes: dict[str, Place3],
        bounds_m: Bounds,
        top_m_s: dict[str, float],
        settings: SimulatedSettings,
        batteries: Sequence[BatteryLimits],
        pads: Pads | None,
    ) -> None:
        super().__init__(tuple(homes), bounds_m)
        self._number = {name: k for k, name in enumerate(homes)}
        self._settings = settings
        self._faults = parsed_faults(settings.faults, self._names)
        self._rng = np.random.default_rng(settings.seed)
        lasts_s = np.array([settings.battery_s or battery.endurance_s or math.inf for battery in batteries])
        self._fleet = Vehicles(
            vehicles=[Vehicle(home_m=home, top_m_s=top_m_s[name]) for name, home in homes.items()],
            rng=self._rng,
            slower=settings.slower,
            stop_noise_s=settings.stop_noise_s,
            speed_noise=settings.speed_noise,
            battery_s=lasts_s,
            takeoffs=np.array([battery.departure_s for battery in batteries]) / lasts_s,
            pads=pads,
        )
        self._dies_s = self._death_times()
        self._on_the_way: list[tuple[float, int, int, Report]] = []
        self._sent, self._steps = 0, 0
        self._closed = False

    def _death_times(self) -> np.ndarray:
        per_s = self._settings.failures_per_h / 3600
        drawn_s = self._rng.standard_exponential(len(self._names))
        dies_s = drawn_s / per_s if per_s > 0 else np.full(len(self._names), math.inf)
        for name, fault in self._faults.items():
            if fault.kind == "dies":
                dies_s[self._number[name]] = fault.from_s
        return dies_s

    @property
    def time_s(self) -> float:
        """The simulated time."""
        return self._fleet.time_s

    # ------------------------------------------------------------ orders

    async def open(self) -> None:
        """Raises LinkError for vehicles whose fault is to be of the wrong type."""
        for name, fault in self._faults.items():
            if fault.kind == "wrong-type":
                raise LinkError(f"robot {name}: it is a vehicle of another type, a simulated boat; a drone is needed")

    async def send_route(self, route: Route) -> None:
        """Raises LinkError where the vehicle refuses or does not answer."""
        vehicle, kind = self._vehicle(route.robot), self._fault_kind(route.robot)
        if kind == "refuses":
            raise LinkError(f"robot {route.robot}: it refuses its route")
        if kind == "half":
            route = replace(route, approach=(), loop=route.loop[: max(1, len(route.loop) // 2)], planned=None)
        vehicle.route, vehicle.mode = route, "ready"
        self._fleet.give(self._number[route.robot], drive_of(route))

    async def differences(self, route: Route) -> tuple[str, ...]:
        """Read back and compare, stop by stop."""
        held = self._vehicle(route.robot).route
        if held is None:
            return ("it holds no route",)
        stops, sent = ((*each.once, *each.every_round) for each in (held, route))
        if len(stops) != len(sent):
            return (f"it holds {len(stops)} stops of {len(sent)}",)
        pairs = enumerate(zip(stops, sent, strict=True), start=1)
        found = [f"stop {k}: it holds {have}; {was} was sent" for k, (have, was) in pairs if have != was]
        return (*found, *(() if held.fence == route.fence else ("it holds another fence",)))

    async def clear_route(self, robot: str) -> None:
        """Take the route away; a vehicle on its way stops."""
        vehicle = self._vehicle(robot)
        vehicle.route, vehicle.mode = None, "idle"
        self._fleet.running[self._number[robot]] = False
        self._fleet.give(self._number[robot], None)

    async def start(self, robot: str) -> None:
        """Raises LinkError for a vehicle without a route."""
        vehicle = self._vehicle(robot)
        if vehicle.route is None:
            raise LinkError(f"robot {robot}: it has no route to start")
        vehicle.mode = "running"
        self._fleet.running[self._number[robot]] = True

    async def keep(self, order: Order) -> None:
        """Faster or slower legs, shorter waits, or a stop where it is; on its charger it stays until it is to leave."""
        self._vehicle(order.robot)
        if order.dock is not None:
            self._fleet.dock(self._number[order.robot], order.dock.leaves)
        else:
            self._fleet.keep(self._number[order.robot], order.late_s, order.rate)

    async def pause(self, robot: str) -> None:
        """It stands until it is started again."""
        self._vehicle(robot).mode = "paused"
        self._fleet.running[self._number[robot]] = False

    async def come_home(self, robot: str) -> None:
        """Straight to where it stood at first, at the loop's speed."""
        k, vehicle = self._number[robot], self._vehicle(robot)
        stops = (*vehicle.route.every_round, *vehicle.route.once) if vehicle.route else ()
        speed_m_s = next((stop.speed_m_s for stop in stops if stop.speed_m_s is not None), HOME_SPEED_M_S)
        self._fleet.give(k, drive_home(self._fleet.place_m(k), vehicle.home_m, speed_m_s))
        vehicle.route, vehicle.mode = None, "returning"
        self._fleet.running[k] = True

    async def close(self) -> None:
        """The vehicles are gone."""
        self._closed = True

    def _fault_kind(self, robot: str) -> FaultKind | None:
        return self._faults[robot].kind if robot in self._faults else None

    def _vehicle(self, robot: str) -> Vehicle:
        """The vehicle; LinkError for an unknown one, and where it does not answer."""
        if robot not in self._number:
            raise LinkError(f"robot {robot}: nothing is known of it; the link reaches {', '.join(self._names)}")
        if self._fault_kind(robot) == "silent" or self._dies_s[self._number[robot]] <= self.time_s:
            raise LinkError(f"robot {robot}: it has not answered for {SILENCE_S:g} s")
        return self._fleet.vehicles[self._number[robot]]

    # ------------------------------------------------------------ reports

    async def reports(self) -> AsyncGenerator[Report, None]:
        """All reports in the order of arrival; taking them lets the simulated time pass."""
        clock = self._settings.clock
        began_s, from_s = time.monotonic(), self.time_s
        while not self._closed:
            self.step()
            for report in self._inbox.take_all():
                yield report
            due_s = began_s + (self.time_s - from_s) / clock if clock > 0 else 0.0
            await asyncio.sleep(max(0.0, due_s - time.monotonic()))

    def step(self) -> None:
        """Let the simulated time pass until all report again, and let what is due arrive."""
        self._steps += 1
        until_s, step_s = self._steps / self._settings.rate_hz, 1 / self._settings.rate_hz
        fleet, settings, count = self._fleet, self._settings, len(self._names)
        held_up = self._rng.random(count) < settings.holdups_per_h / 3600 * step_s
        held_s = self._rng.standard_exponential(count) * settings.holdup_s
        fleet.held_until_s = np.where(held_up, fleet.time_s + held_s, fleet.held_until_s)
        for name, fault in self._faults.items():
            if fault.kind == "stuck" and fault.from_s <= fleet.time_s:
                fleet.held_until_s[self._number[name]] = math.inf
        fleet.step(until_s)
        for vehicle_k in np.flatnonzero(fleet.running):
            vehicle = fleet.vehicles[vehicle_k]
            if fleet.battery[vehicle_k] <= 0 or self._dies_s[vehicle_k] <= fleet.time_s:
                vehicle.mode = "failed"
                fleet.running[vehicle_k] = False
            elif vehicle.mode == "returning" and fleet.has_arrived(int(vehicle_k)):
                vehicle.mode = "idle"
                fleet.running[vehicle_k] = False
        self._send_reports()
        while self._on_the_way and self._on_the_way[0][0] <= fleet.time_s:
            report = heapq.heappop(self._on_the_way)[3]
            self._inbox.offer(
                now_s=fleet.time_s,
                robot=report.robot,
                time_s=report.time_s,
                position_m=report.position_m,
                battery=report.battery,
                mode=report.mode,
            )

    def _send_reports(self) -> None:
        """Offer each vehicle's report, late, noisy, lost or at fault as the settings say."""
        fleet, count = self._fleet, len(self._names)
        noise_m = self._rng.standard_normal((count, 3)) * self._settings.position_noise_m
        arrives = self._rng.random(count) >= self._settings.lost
        delays_s = (0.5 + self._rng.random(count)) * self._settings.delay_s
        told_m = (fleet.positions_m + noise_m).tolist()
        for k in np.flatnonzero(arrives & (self._dies_s > fleet.time_s)).tolist():
            name = self._names[k]
            x, y, height = told_m[k]
            mode: Mode = fleet.vehicles[k].mode
            charge = float(fleet.battery[k])
            report = Report(robot=name, time_s=fleet.time_s, position_m=(x, y, height), battery=charge, mode=mode)
            fault = self._faults.get(name)
            if fault is not None and fault.from_s <= fleet.time_s:
                report = _spoilt(report, fault.kind)
            self._sent += 1
            heapq.heappush(self._on_the_way, (fleet.time_s + delays_s[k], self._sent, k, report))


def _spoilt(report: Report, kind: FaultKind) -> Report:
    """What a vehicle with a fault sends in place of a report."""
    if kind == "nan":
        return replace(report, position_m=(math.nan, math.nan, math.nan))
    return replace(report, time_s=report.time_s + 3600) if kind == "future" else report


def parsed_faults(text: str, robots: tuple[str, ...]) -> dict[str, Fault]:
    """What the setting ``faults`` says; RotaError for unknown robots and faults."""
    faults: dict[str, Fault] = {}
    for part in text.split("+") if text else ():
        robot, _, rest = part.rpartition(":")
        kind, at, seconds = rest.partition("@")
        known = [name for name in get_args(FaultKind) if name == kind]
        try:
            from_s = float(seconds) if at else 0.0
        except ValueError:
            from_s = math.nan
        if robot not in robots or not known or not 0 <= from_s < math.inf or bool(at) != (kind in LATER_FAULTS):
            raise RotaError(f"simulated.faults: {part!r} is not allowed; {FAULTS} is needed, of {', '.join(robots)}")
        faults[robot] = Fault(kind=known[0], from_s=from_s)
    return faults
