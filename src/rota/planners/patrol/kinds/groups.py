"""The robots of a fleet in groups that are alike, and what ground each group can serve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from rota.geometry.free_space import DemandedRegion
from rota.model.fleet import ABILITIES
from rota.model.mission import Fleet, Mission, Robot, Sensor, inner_reach_m


@dataclass(frozen=True, kw_only=True)
class Group:
    """Robots that are alike: as many of a kind as are needed, ``most`` at most, or those ``robots`` that are listed."""

    name: str
    robot: Robot
    cost: float = 1.0
    most: int | None = None
    robots: tuple[Robot, ...] = ()

    @property
    def swath_m2_s(self) -> float:
        """Ground per second that one of them sees on perfect lanes."""
        return 2 * inner_reach_m(self.robot.sensor) * self.robot.ground_speed_m_s

    def serves(self, region: DemandedRegion) -> bool:
        """Whether what it sees counts for a region."""
        return counts(self.robot.sensor, region.sensors)

    def fleet_of(self, fleet: Fleet) -> Fleet:
        """The fleet with this group alone."""
        able = {name: getattr(self.robot, name) for name in ABILITIES}
        return replace(fleet, kinds=(), robots=self.robots or None, **able)


def counts(sensor: Sensor, names: Sequence[str]) -> bool:
    """Whether what a sensor sees counts where these are named; where none is named, all count."""
    return not names or sensor.name in names


def groups_of(fleet: Fleet) -> list[Group]:
    """The kinds of a fleet, or its listed robots in groups that can do the same, in the order of the fleet."""
    if fleet.kinds:
        return [
            Group(name=kind.name, robot=kind.robot(f"{kind.name}-1"), cost=kind.cost, most=kind.most)
            for kind in fleet.kinds
        ]
    alike: dict[tuple[object, ...], list[Robot]] = {}
    for robot in fleet.unlike_robots:
        alike.setdefault(tuple(getattr(robot, name) for name in ABILITIES), []).append(robot)
    listed = fleet.robots is not None
    return [Group(name=each[0].name, robot=each[0], robots=tuple(each) if listed else ()) for each in alike.values()]


def differs(mission: Mission) -> bool:
    """Whether it matters which of its robots does what."""
    fleet = mission.fleet
    if fleet.kinds or len(groups_of(fleet)) > 1:
        return True
    return not all(counts(fleet.unlike_robots[0].sensor, zone.sensors) for zone in mission.zones)
