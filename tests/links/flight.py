"""A vehicle that really flies the mission items it holds, at their speeds and with their holds: places on the globe."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from pyproj import Geod

GLOBE = Geod(ellps="WGS84")
WAYPOINT, LOITER, TAKEOFF, JUMP, SPEED = 16, 17, 22, 177, 178


@dataclass
class Flight:
    """From ``lat``, ``lon`` in degrees; jumps name items as they are sent, from 0."""

    lat: float
    lon: float
    height_m: float = 0.0
    speed_m_s: float = 1.0
    number: int = 0
    held_s: float = 0.0
    items: list[Any] = field(default_factory=list)

    def fly(self, items: list[Any], duration_s: float) -> None:
        """Go on for so long; items that are others than before are flown from their beginning."""
        if items is not self.items:
            self.items, self.number, self.held_s = items, 0, 0.0
        left_s = duration_s
        for _ in range(1000):
            if left_s <= 0 or self.number >= len(items):
                return
            item = items[self.number]
            if item.command == SPEED:
                self.speed_m_s = item.param2
            elif item.command == JUMP:
                self.number = int(item.param1)
                continue
            elif item.command == TAKEOFF:
                self.height_m = item.z
            else:
                left_s = self.go_to(item, left_s)
                if left_s <= 0 or item.command == LOITER:
                    return
            self.number, self.held_s = self.number + 1, 0.0

    def go_to(self, item: Any, left_s: float) -> float:
        """Fly towards an item's place and hold there; the seconds that are left of ``left_s`` afterwards."""
        lat, lon = item.x / 1e7, item.y / 1e7
        heading, _, away_m = GLOBE.inv(self.lon, self.lat, lon, lat)
        takes_s = away_m / self.speed_m_s
        if takes_s > left_s:
            self.lon, self.lat, _ = GLOBE.fwd(self.lon, self.lat, heading, left_s * self.speed_m_s)
            return 0.0
        self.lat, self.lon, self.height_m = lat, lon, item.z
        left_s -= takes_s
        holds_s = max(0.0, item.param1 - self.held_s)
        if holds_s > left_s:
            self.held_s += left_s
            return 0.0
        return left_s - holds_s
