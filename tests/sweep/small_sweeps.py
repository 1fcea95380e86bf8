"""A mission that is planned in a moment, and sweeps of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

YARD = """\
rota: 1
name: yard
area: [[0, 0], [30, 0], [30, 20], [0, 20]]
period_s: 60
zones:
  - {name: gate, period_s: 40, ring: [[0, 0], [8, 0], [8, 8], [0, 8]]}
fleet: {speed_m_s: 4, sensor: {shape: disc, radius_m: 5}}
patrol: {effort: quick, method: sequential}
"""


def write_sweep(folder: Path, **values: Any) -> Path:
    """A sweep of the yard in the folder, with these values in place of its own."""
    (folder / "yard.yaml").write_text(YARD)
    path = folder / "sweep.json"
    path.write_text(json.dumps({"rota_sweep": 1, "name": "yards", "missions": ["yard.yaml"], **values}))
    return path
