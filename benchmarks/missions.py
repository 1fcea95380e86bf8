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
BOUNCING = """\
rota: 1
name: bounce-{purpose}
area: {{{{map: "{{data}}/maps/cumberland.yaml", inside: [20, 20]}}}}
zones:
  - {{{{name: west, period_s: 1200, demand: visit, ring: [[6.5, 11.5], [9.5, 11.5], [9.5, 14.5], [6.5, 14.5]]}}}}
  - {{{{name: middle, period_s: 1200, demand: visit, ring: [[25.5, 15], [28.5, 15], [28.5, 18], [25.5, 18]]}}}}
  - {{{{name: east, period_s: 1200, demand: visit, ring: [[40.5, 26.5], [43.5, 26.5], [43.5, 29.5], [40.5, 29.5]]}}}}
fleet:
  robots: 3
  speed_m_s: 0.2
  sensor: {{{{shape: disc, radius_m: 0.25}}}}
  body_radius_m: 0.17
  turn_rate_rad_s: 1.5
planner: bounce
bounce: {{{{cell_m: 0.5, bouncing_angles_deg: [90], purpose: {purpose}}}}}
"""
REAL_INPUTS = {
    "parcel-nl": PARCEL_NL,
    "cumberland": CUMBERLAND,
    **{f"bounce-{purpose}": BOUNCING.format(purpose=purpose) for purpose in ("periods", "worst_gap")},
}


def example_missions() -> list[Path]:
    """The mission files in examples/ (not the description of the building's map, and not the sweep)."""
    return sorted(path for path in EXAMPLES.glob("*.yaml") if not path.stem.endswith(("_map", "sweep")))


def write_real_mission(name: str, folder: Path) -> Path:
    """Write the mission of this name into ``folder``; it names its input by an absolute path."""
    path = folder / f"{name}.yaml"
    path.write_text(REAL_INPUTS[name].format(data=DATA.as_posix()))
    return path
