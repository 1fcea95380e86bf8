"""The controller that comes to rest: how much it covers, in how many steps, and without contact."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from shapely import MultiPolygon, box
from tests.planners.swarm.conftest import PAPER, in_box, scattered

from rota.planners.swarm.asked import ALL_NEIGHBOURS, run_mission
from rota.planners.swarm.metrics import covered_share
from rota.planners.swarm.settle_kernels import decide_settle
from rota.studies.chen2018.maps import square

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
    wished = np.array([[-6 + 0.46, 0.92], [6.0, 0.0]])
    length = np.hypot(*wished.T)[:, None]
    # friction of 25 m: 2e-5 of it for the first, which moves; 1e-4 for the second, which sets out from rest
    wished *= 1 - np.array([[0.0005], [0.0025]]) / length
    assert swarm.places_m == pytest.approx(np.array([[110, 100], [140, 100]]) + wished, abs=1e-9)


def test_friction_lets_overlaps_of_millimetres_stand_and_no_greater_ones() -> None:
    def step_m(overlap_m: float) -> float:
        apart = in_box([[100, 100], [150 - overlap_m, 100]], rule=ALL, decide=decide_settle, neighbour_range_m=50)
        return apart.step()

    assert step_m(0.008) == 0.0  # 0.3 of it is less than 2.5 mm
    assert step_m(0.009) == pytest.approx(0.3 * 0.009 - 0.0025, abs=1e-9)


@pytest.mark.parametrize("seed", [1, 2])
def test_49_robots_rest_whose_rows_buckle_slowly(seed: int) -> None:
    """Without friction these are not at rest after 4,000 steps, and cover 0.1 % of the area more at most."""
    run = run_mission(square(49, "between"), seed=seed)
    places = np.array([trajectory.positions_m[-1] for trajectory in run.plan])
    assert run.at_rest
    assert run.steps < 2000
    assert covered_share(places, np.full(49, 25.0), MultiPolygon([box(0, 0, 350, 350)])) > 0.784


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
