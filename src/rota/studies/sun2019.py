"""Maps of Sun et al., Sensors 19(9):1994, 2019, as far as they can be reconstructed: the paper has no coordinates."""

from __future__ import annotations

import shapely

from rota.mission import DiscSensor, Fleet, Mission, Obstacle, Zone


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


def _rectangle(left_m: float, bottom_m: float, right_m: float, top_m: float) -> shapely.MultiPolygon:
    ring = [(left_m, bottom_m), (right_m, bottom_m), (right_m, top_m), (left_m, top_m)]
    return shapely.MultiPolygon([shapely.Polygon(ring)])
