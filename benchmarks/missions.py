"""Mission files over the real inputs, which lie beside the project and are no part of it."""

from __future__ import annotations

from pathlib import Path

PROJECT = Path(__file__).parents[1]
EXAMPLES = PROJECT / "examples"
DATA = PROJECT.parent / "shared" / "data"

PARCEL_NL = """\
rota: 1
name: parcel-nl
coordinates: wgs84
area: {{geojson: "{data}/parcel-nl.geojson"}}
period_s: 120
fleet:
  speed_m_s: 8
  sensor: {{shape: disc, radius_m: 8}}
"""
CUMBERLAND = """\
rota: 1
name: cumberland
area: {{map: "{data}/maps/cumberland.yaml", inside: [44, 7]}}
period_s: 300
fleet:
  speed_m_s: 0.6
  sensor: {{shape: disc, radius_m: 2}}
  body_radius_m: 0.2
"""
REAL_INPUTS = {"parcel-nl": PARCEL_NL, "cumberland": CUMBERLAND}


def example_missions() -> list[Path]:
    """The mission files in examples/ (not the description of the building's map)."""
    return sorted(path for path in EXAMPLES.glob("*.yaml") if not path.stem.endswith("_map"))


def write_real_mission(name: str, folder: Path) -> Path:
    """Write the mission of this name into ``folder``; it names its input by an absolute path."""
    path = folder / f"{name}.yaml"
    path.write_text(REAL_INPUTS[name].format(data=DATA.as_posix()))
    return path
