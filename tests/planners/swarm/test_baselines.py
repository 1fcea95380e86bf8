"""The methods to compare with: cases worked by hand, and where they come to rest."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from scipy.spatial.distance import pdist
from tests.planners.swarm.conftest import PAPER, in_box, scattered

from rota.planners.swarm.baseline_kernels import OVER_RELAXATION, decide_virtual_force, decide_voronoi
from rota.planners.swarm.planner import ALL_NEIGHBOURS

ALL = PAPER._replace(neighbours=ALL_NEIGHBOURS)


def test_lloyd_s_step_leads_past_the_centroid_of_the_cell_within_the_disc() -> None:
    places = scattered(20, 60, 190, 5, 11)
    swarm = in_box(places, rule=ALL, decide=decide_voronoi, neighbour_range_m=50, speed_m_s=1000)
    swarm.step()
    cells = shapely.get_parts(
        shapely.voronoi_polygons(shapely.multipoints(places), extend_to=shapely.box(0, 0, 250, 250))
    )
    for place, moved in zip(places, swarm.places_m, strict=True):
        cell = next(cell for cell in cells if cell.contains(shapely.Point(place)))
        expected = cell.intersection(shapely.Point(place).buffer(25, quad_segs=2048)).centroid
        assert moved == pytest.approx(place + OVER_RELAXATION * ([expected.x, expected.y] - place), abs=1e-4)


def test_unlike_sensors_meet_where_both_discs_have_the_same_power() -> None:
    # 10 m apart, radii 10 and 6: x^2 - 100 = (10 - x)^2 - 36 gives x = 8.2
    swarm = in_box(
        [[100, 100], [110, 100]], rule=ALL, decide=decide_voronoi, sensor_m=np.array([10, 6]), speed_m_s=1000,
        neighbour_range_m=16, safe=False,
    )  # fmt: skip
    swarm.step()
    for centre, radius, half in ((100, 10, shapely.box(0, 0, 108.2, 250)), (110, 6, shapely.box(108.2, 0, 250, 250))):
        expected = shapely.Point(centre, 100).buffer(radius, quad_segs=2048).intersection(half).centroid
        assert min(abs(swarm.places_m[:, 0] - centre - OVER_RELAXATION * (expected.x - centre))) < 1e-4


def test_a_push_is_a_share_of_the_overlap() -> None:
    swarm = in_box(
        [[120, 100], [130, 100]], rule=ALL, decide=decide_virtual_force, neighbour_range_m=50, speed_m_s=1000
    )
    swarm.step()
    assert swarm.places_m == pytest.approx(np.array([[110, 100], [140, 100]]))  # a quarter of 40 m
    swarm = in_box([[120, 100], [130, 100]], rule=ALL, decide=decide_virtual_force, neighbour_range_m=50)
    swarm.step()
    assert swarm.places_m == pytest.approx(np.array([[119.5, 100], [130.5, 100]]))  # 2 m/s for 0.25 s


@pytest.mark.parametrize(("decide", "least"), [(decide_voronoi, 0.772), (decide_virtual_force, 0.776)])
def test_they_cover_what_well_made_ones_do(decide, least: float) -> None:
    """25 robots from the centre; the most possible is 25 pi 25^2 / 250^2 = 0.785."""
    swarm = in_box(scattered(25, 100, 150, 1.1, 12), rule=ALL, decide=decide, neighbour_range_m=50)
    nearest = math.inf
    for _ in range(1500):
        swarm.step()
        nearest = min(nearest, pdist(swarm.places_m).min())
    discs = shapely.buffer(shapely.points(swarm.places_m), 25, quad_segs=32)
    covered = shapely.union_all(discs).intersection(shapely.box(0, 0, 250, 250)).area / 250**2
    assert least < covered < 0.7854
    assert nearest >= 1
