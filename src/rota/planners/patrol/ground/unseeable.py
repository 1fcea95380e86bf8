"""Ground that nobody can see: a little of it is left out, if the mission allows that; more ends the planning."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from rota.errors import NoPlanFound
from rota.geometry.free_space import DemandedRegion
from rota.mission import Mission
from rota.planners.patrol.ground.samples import SamplePoints

Ints = NDArray[np.int64]

MOST_EXCLUDED = 0.05  # of the demanded area: beyond it, planning always stops


def refuse_unseeable(
    mission: Mission, points: SamplePoints, hopeless: Ints, regions: tuple[DemandedRegion, ...]
) -> None:
    """Raise NoPlanFound when the points that nobody can see are refused by the mission, or are too much of it."""
    asked_shapes = [region.shape for region in regions if region.demand == "every_point"]
    inside = hopeless[points.shrink_m[hopeless] > 0]  # the lattice; border points stand for no ground of their own
    # squares of the lattice stick out of narrow ground: only what lies on demanded ground is lost
    half_m = np.sqrt(points.area_m2[inside]) / 2
    x, y = points.xy_m[inside].T
    squares = shapely.union_all(shapely.box(x - half_m, y - half_m, x + half_m, y + half_m))
    lost_m2 = float(shapely.area(shapely.intersection(squares, shapely.union_all(asked_shapes))))
    asked_m2 = sum(shape.area for shape in asked_shapes)
    share = lost_m2 / asked_m2 if asked_m2 > 0 else 0.0
    if share <= MOST_EXCLUDED and (mission.unseeable == "exclude" or not len(hopeless)):
        return
    blobs = shapely.get_parts(
        shapely.union_all(
            shapely.buffer(shapely.points(points.xy_m[hopeless]), 1e-9 + np.sqrt(points.area_m2[hopeless]))
        )
    )
    blobs = sorted(blobs, key=lambda blob: -float(blob.area))[:5]
    places = ", ".join(f"({blob.centroid.x:.2f}, {blob.centroid.y:.2f})" for blob in blobs)
    allowed = "unseeable: refuse allows none" if mission.unseeable == "refuse" else f"{MOST_EXCLUDED:.0%} is allowed"
    where = "a robot can stand" if mission.fleet.entrances is None else "a robot can come to from fleet.entrances"
    lost = f"about {lost_m2:.2f} m2 ({share:.1%}" if lost_m2 >= 0.01 else "less than 0.01 m2 (0.0%"
    raise NoPlanFound(
        f"{lost} of what is asked) cannot be seen from anywhere {where}, for instance round {places}; {allowed}"
    )
