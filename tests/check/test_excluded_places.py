"""The parts that nobody can see are told apart as scipy's image labels do."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from rota.check.findings import Findings


@pytest.mark.parametrize("seed", range(5))
def test_parts_agree_with_image_labels(seed: int) -> None:
    rng = np.random.default_rng(seed)
    raster = rng.random((30, 40)) < 0.2
    raster[0, 0] = True
    labels, n = ndimage.label(raster, structure=np.ones((3, 3)))
    cells = np.argwhere(raster)
    areas_m2 = rng.random(len(cells))
    # the same cell twice: pieces may be finer than the bins that join them
    rows = np.column_stack([cells + 0.25, areas_m2, np.ones(len(cells))])
    finer = rows + np.array([0.5, 0.5, 0.0, 0.0])
    findings = Findings(excluded=[rows, finer])
    expected = np.sort(2 * ndimage.sum_labels(areas_m2, labels[raster], np.arange(1, n + 1)))[::-1][:8]
    places = findings.excluded_places()
    np.testing.assert_allclose([area for _, _, area in places], expected)
    for x, y, area in places:
        part = labels[int(x), int(y)]
        assert area == pytest.approx(2 * areas_m2[labels[raster] == part].sum())


def test_parts_of_nothing() -> None:
    assert Findings().excluded_places() == []
    (only,) = Findings(excluded=[np.array([[3.0, 4.0, 0.5, 0.1]])]).excluded_places()
    assert only == (3.0, 4.0, 0.5)
