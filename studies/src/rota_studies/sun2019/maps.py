"""Maps of Sun et al., Sensors 19(9):1994, 2019, as far as they can be reconstructed: the paper has no coordinates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon

from rota.files.rings import circle_ring
from rota.model.mission import DiscSensor, Fleet, Mission, Obstacle, Zone

RECONSTRUCTED = "The map is a reconstruction: the paper prints no coordinates."


def figure_13() -> Mission:
    """Figure 13's square with two obstacles, two zones and the periods of Section 5.1 (8, 20 and 40 s); metres.

    The same as the mission file examples/sun2019-fig13.yaml, which says how it was reconstructed.
    """
    return Mission(
        name="sun2019-fig13",
        area=_rectangle(0, 0, 120, 120),
        obstacles=(Obstacle(shape=_rectangle(20, 75, 50, 100)), Obstacle(shape=_rectangle(75, 20, 105, 45))),
        zones=(
            Zone(name="zone-1", period_s=8, shape=_rectangle(70, 70, 100, 105)),
            Zone(name="zone-2", period_s=20, shape=_rectangle(15, 15, 60, 60)),
        ),
        period_s=40,
        fleet=Fleet(speed_m_s=20, sensor=DiscSensor(radius_m=5)),
    )


def with_periods(mission: Mission, periods_s: tuple[float, float, float]) -> Mission:
    """A map of two zones with other periods, in seconds: of zone 1, of zone 2 and of the rest; named after them."""
    zone_1, zone_2 = (replace(zone, period_s=s) for zone, s in zip(mission.zones, periods_s[:2], strict=True))
    name = "sun2019-" + "-".join(f"{period_s:g}" for period_s in periods_s)
    return replace(mission, name=name, zones=(zone_1, zone_2), period_s=periods_s[2])


def figure_8() -> Mission:
    """A map of two sub-regions, as Figure 8 has: Figure 13's with zone 2 alone. The paper's is not given."""
    whole = figure_13()
    return replace(whole, name="sun2019-fig8", zones=(replace(whole.zones[1], name="zone-1"),))


def figure_15() -> Mission:
    """Figure 15's pentagon with two obstacles, a hexagonal and a circular zone (45, 10 and 12 s); metres.

    The same as the mission file examples/sun2019-fig16.yaml, which says how it was reconstructed.
    """
    return Mission(
        name="sun2019-fig16",
        area=_regular_polygon(5, (72, 72), 72),
        obstacles=(Obstacle(shape=_rectangle(85, 90, 105, 110)), Obstacle(shape=_rectangle(45, 35, 65, 50))),
        zones=(
            Zone(name="zone-1", period_s=10, shape=_regular_polygon(6, (50, 85), 16)),
            Zone(name="zone-2", period_s=12, shape=MultiPolygon([Polygon(circle_ring((95, 60), 12))])),
        ),
        period_s=45,
        fleet=Fleet(speed_m_s=10, sensor=DiscSensor(radius_m=5)),
    )


def _rectangle(left_m: float, bottom_m: float, right_m: float, top_m: float) -> shapely.MultiPolygon:
    """A rectangle by its four sides in metres."""
    ring = [(left_m, bottom_m), (right_m, bottom_m), (right_m, top_m), (left_m, top_m)]
    return shapely.MultiPolygon([shapely.Polygon(ring)])


def _regular_polygon(corners: int, centre_m: tuple[float, float], circumradius_m: float) -> MultiPolygon:
    """One corner up."""
    turn = np.pi / 2 + 2 * np.pi * np.arange(corners) / corners
    ring = np.array(centre_m) + circumradius_m * np.column_stack([np.cos(turn), np.sin(turn)])
    return MultiPolygon([Polygon(ring)])
