"""Where robots come in on a ROS map: inside, unless the mission says otherwise."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from tests.files.test_occupancy_map import write_map
from tests.short_searches import short_searches as short_searches

from rota import check_plan, make_plan
from rota.files.mission_file import ReadMission, read_mission
from rota.files.plan_file import plan_from_text, plan_text
from rota.planners.patrol.pockets import pockets_sentence

CELL_M, GAP_M, BODY_M = 0.1, 0.2, 0.2
HALL, GAP, POCKET = (0.1, 0.1, 6.1, 4.1), (6.1, 2.0, 6.3, 2.0 + GAP_M), (6.3, 1.6, 7.1, 2.4)  # x0, y0, x1, y1
MISSION = """\
rota: 1
name: floor
area: {{map: room.yaml, inside: {inside}}}
period_s: 100
fleet: {{speed_m_s: 0.5, sensor: {{shape: disc, radius_m: 2}}, body_radius_m: 0.2{more}}}
patrol: {{effort: quick}}
"""


def floor(folder: Path, inside: str = "[1, 1]", more: str = "") -> ReadMission:
    """A hall of 6 m x 4 m, and a pocket of 0.8 m x 0.8 m behind a gap that is half as wide as a body."""
    pixels = np.zeros((42, 72), dtype=np.uint8)
    for x0, y0, x1, y1 in (HALL, GAP, POCKET):
        pixels[round(y0 / CELL_M) : round(y1 / CELL_M), round(x0 / CELL_M) : round(x1 / CELL_M)] = 254
    write_map(folder, pixels[::-1], resolution=CELL_M)
    path = folder / "mission.yaml"
    path.write_text(MISSION.format(inside=inside, more=more))
    return read_mission(path)


@pytest.mark.parametrize(
    ("inside", "more", "entrances"),
    [
        ("[1, 1]", "", ((1, 1),)),
        ("[6.7, 2]", "", ((6.7, 2),)),
        ("[1, 1]", ", entrances: null", None),
        ("[1, 1]", ", entrances: [[5, 2]]", ((5, 2),)),
        ("[1, 1]", ", start: {points: [[3, 3], [2, 2]]}", ((1, 1),)),
        ("[1, 1]", ", robots: [{name: a, start: [3, 3]}, {name: b, start: [6.7, 2]}]", ((1, 1), (6.7, 2))),
        ("[1, 1]", ", start: {box: [[3, 3], [4, 4]]}", ((1, 1),)),
    ],
)
def test_robots_come_in_at_inside_unless_it_is_told(
    tmp_path: Path, inside: str, more: str, entrances: tuple[tuple[float, float], ...] | None
) -> None:
    read = floor(tmp_path, inside, more)
    assert read.warnings == ()
    if entrances is None:
        assert read.mission.fleet.entrances is None
    else:
        np.testing.assert_allclose(read.mission.fleet.entrances, entrances)


def test_where_no_body_fits_they_come_in_at_the_nearest_place_of_the_largest_part(tmp_path: Path) -> None:
    room_m = 1.01 * BODY_M
    in_the_mouth = (6.1 - math.sqrt(room_m**2 - (GAP_M / 2) ** 2), 2.1)
    for inside, place in (("[6.25, 2.1]", in_the_mouth), ("[6.4, 1.7]", (6.1 - room_m, 1.7))):
        read = floor(tmp_path, inside)
        np.testing.assert_allclose(read.mission.fleet.entrances, [place], atol=1e-3)
        (warning,) = read.warnings
        assert f"area.inside: no body fits there; robots come in at [{place[0]:.3f}" in warning


def test_a_swarm_on_a_map_is_wherever_it_fits(tmp_path: Path) -> None:
    floor(tmp_path)
    path = tmp_path / "mission.yaml"
    text = path.read_text().replace("patrol: {effort: quick}", "planner: swarm").replace("period_s: 100\n", "")
    path.write_text(text.replace("body_radius_m: 0.2", "robots: 3, start: {box: [[1, 1], [5, 3]]}"))
    assert read_mission(path).mission.fleet.entrances is None


def test_nobody_lives_in_a_pocket_unless_robots_may_be_anywhere(tmp_path: Path) -> None:
    behind = make_plan(floor(tmp_path).mission)
    assert len(behind.trajectories) == 1
    assert pockets_sentence(behind) is None
    report = check_plan(plan_from_text(plan_text(behind), "plan"))
    assert report.verdict == "met"
    # from (6.1 - 0.2, y) the gap shows a trapezium of the pocket: its sides go through the corners of the gap
    hidden_m2 = 0.8 * 0.8 - seen_through_the_gap_m2()
    assert report.demands[0].excluded_area_m2 == pytest.approx(hidden_m2, abs=0.05)
    anywhere = make_plan(floor(tmp_path, more=", entrances: null").mission)
    assert len(anywhere.trajectories) == 2
    assert "1 robot is where no way leads to from the rest, for instance at (6." in (pockets_sentence(anywhere) or "")


def seen_through_the_gap_m2() -> float:
    """By a look from everywhere to everywhere, in cells of 2 cm and steps of 2 cm."""
    x, y = (v.ravel() for v in np.meshgrid(np.arange(6.31, 7.1, 0.02), np.arange(1.61, 2.4, 0.02)))
    seen = np.zeros(len(x), dtype=bool)
    for from_x in np.linspace(4.5, 6.1 - BODY_M, 15):
        for from_y in np.linspace(0.3, 3.9, 181):
            at = [from_y + (y - from_y) * (wall - from_x) / (x - from_x) for wall in (6.1, 6.3)]
            free = np.all([(height >= 2.0) & (height <= 2.0 + GAP_M) for height in at], axis=0)
            seen |= free & (np.hypot(x - from_x, y - from_y) <= 2)
    return float(seen.sum()) * 0.02**2
