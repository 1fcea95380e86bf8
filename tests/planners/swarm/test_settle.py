"""The controller that comes to rest: how much it covers, in how many steps, and without contact."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from shapely import MultiPolygon, box
from tests.planners.swarm.conftest import PAPER, in_box, scattered

from rota.planners.swarm.asked import ALL_NEIGHBOURS
from rota.planners.swarm.metrics import covered_share
from rota.planners.swarm.settle_kernels import decide_settle

ALL = PAPER._replace(neighbours=ALL_NEIGHBOURS)
SQUARE = MultiPolygon([box(0, 0, 250, 250)])


def test_two_discs_come_apart_until_they_touch_and_rest_there() -> None:
    swarm = in_box([[115, 100], [135, 100]], rule=ALL, decide=decide_settle, neighbour_range_m=50)
    moved = [swarm.step() for _ in range(400)]
    assert moved[-1] <= 1e-5
    # momentum may carry them on, never back into overlap
    assert pdist(swarm.places_m)[0] >= 50 - 1e-3
    assert swarm.places_m[:, 1] == pytest.approx([100, 100])
    assert swarm.places_m.mean(axis=0) == pytest.approx([125, 100])


def test_a_step_is_a_share_of_the_overlap_and_of_the_step_before() -> None:
    swarm = in_box(
        [[110, 100], [140, 100]], rule=ALL, decide=decide_settle, neighbour_range_m=50, speed_m_s=100,
        velocities_m_s=np.array([[2.0, 4.0], [0.0, 0.0]]),
    )  # fmt: skip
    swarm.step()
    # 20 m of overlap: 6 m each; and 0.92 of 0.25 s at (2, 4) m/s
    assert swarm.places_m == pytest.approx(np.array([[110 - 6 + 0.46, 100.92], [146, 100]]))


@pytest.mark.parametrize(("low", "most_steps"), [(100.0, 1000), (1.0, 1600)], ids=["centre", "corner"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_25_robots_cover_nearly_all_that_discs_can_and_rest(low: float, most_steps: int, seed: int) -> None:
    """At least 77 % each (78.54 % is the most), within 2,000 steps, bodies apart: what the area's gradient reaches."""
    swarm = in_box(scattered(25, low, low + 50, 1.02, seed), rule=ALL, decide=decide_settle, neighbour_range_m=50)
    nearest = np.inf
    while swarm.steps < most_steps:
        moved = swarm.step()
        nearest = min(nearest, pdist(swarm.places_m).min())
        if moved <= 1e-5:
            break
    assert moved <= 1e-5
    assert nearest >= 1
    assert 0.77 < covered_share(swarm.places_m, np.full(25, 25.0), SQUARE) < 0.7854
