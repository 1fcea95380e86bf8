"""That NUMBA_BOUNDSCHECK does what .ci/run relies on: an index outside of an array raises, in the compiled code too."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np

from rota.check import tiling_kernels
from rota.check.arrays import Grid


def test_an_index_outside_raises() -> None:
    # numba reads the setting when it is loaded
    environment = {**os.environ, "NUMBA_BOUNDSCHECK": "1"}
    program = (
        "import numpy as np; from rota.check.tiling_kernels import half_widths;"
        "half_widths(np.array([0, 9]), np.zeros((4, 2)))"
    )
    ran = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, timeout=300)
    assert "IndexError" in ran.stderr, ran.stderr


def test_no_number_leads_out_of_the_grid() -> None:
    for far in (-1e300, -1.0, -1e-9, 0.0, 2.9, 3.0, 1e18, 1e300, np.inf, -np.inf, np.nan):
        assert 0 <= tiling_kernels.cell_along(far, 1.0, 3) <= 2
    # legs from one end of the numbers to the other are in no cell, or in cells of the grid
    grid = Grid(0.0, 0.0, 1.0, 3, 2)
    for end in (1e9, 1e18, 1e300, np.inf, np.nan):
        legs = np.array([[0.5, 0.5, end, 0.5], [-end, -end, end, end], [end, end, end, end]])
        _, offsets, index = tiling_kernels.rasterise(legs, 0.1, grid)
        assert len(offsets) == 7
        assert len(index) == offsets[-1]
        assert ((index >= 0) & (index < 3)).all()
