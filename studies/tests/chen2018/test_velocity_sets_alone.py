"""Sets of velocities by themselves: centroids in closed form, and Algorithm 1's means against them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rota.errors import MissionError
from rota_studies.chen2018.velocity_set import VelocitySet

QUARTER = np.array([(-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)])


def test_the_centroid_of_a_quarter_disc_is_its_closed_form() -> None:
    centroid = VelocitySet(QUARTER, 2.0).centroid()
    assert centroid == pytest.approx([4 * 2 / (3 * math.pi)] * 2, abs=1e-12)
    assert VelocitySet(np.empty((0, 3)), 2.0).centroid() == pytest.approx([0, 0], abs=1e-12)


def test_means_of_random_velocities_scatter_as_a_mean_does() -> None:
    velocities = VelocitySet(QUARTER, 2.0)
    # E x^2 over the quarter disc is r^2 / 4; a sample lies in it with probability (pi r^2 / 4) / (2 r)^2
    variance = 2 * (2.0**2 / 4 - (4 * 2 / (3 * math.pi)) ** 2)
    for samples in (500, 5000):
        means = velocities.sampled_centroids(samples, tries=400, seed=5)
        away2 = ((means - velocities.centroid()) ** 2).sum(axis=1).mean()
        assert away2 == pytest.approx(variance / (samples * math.pi / 16), rel=0.2)


@pytest.mark.parametrize("samples", [5, 20])
def test_a_set_is_missed_as_often_as_no_sample_falls_into_it(samples: int) -> None:
    means = VelocitySet(QUARTER, 2.0).sampled_centroids(samples, tries=4000, seed=1)
    assert np.isnan(means[:, 0]).mean() == pytest.approx((1 - math.pi / 16) ** samples, abs=0.025)


def test_an_empty_set_has_no_centroid_and_no_mean() -> None:
    apart = VelocitySet(np.array([(1.0, 0.0, -0.5), (-1.0, 0.0, -0.5)]), 2.0)
    assert apart.centroid() is None
    assert np.isnan(apart.sampled_centroids(1000, tries=3, seed=0)).all()
    assert VelocitySet(np.array([(1.0, 0.0, -2.5)]), 2.0).centroid() is None


@pytest.mark.parametrize(
    ("half_planes", "speed", "message"),
    [(QUARTER, 0.0, "speed_m_s: 0.0"), (np.zeros((60, 3)), 1.0, "at most 59"), ([(1, 0, math.nan)], 1.0, "all finite")],
)
def test_what_is_no_set_is_refused(half_planes: object, speed: float, message: str) -> None:
    with pytest.raises(MissionError, match=message):
        VelocitySet(np.array(half_planes), speed)
