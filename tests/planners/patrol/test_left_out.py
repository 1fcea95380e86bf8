"""What plans leave out is told before the search."""

from __future__ import annotations

from dataclasses import replace

from shapely import box
from tests.planners.patrol.ground.test_unseeable import BLOCK, field

from rota.planners.patrol.left_out import sentence_of_what_is_left_out


def test_what_is_left_out_is_told_with_its_share_and_place() -> None:
    mission = field(box(30, 10, 50, 30))
    words = "about 100.00 m2 (1.7% of what is asked) cannot be seen from anywhere a robot can stand, for instance round"
    assert sentence_of_what_is_left_out(mission) == f"{words} (40.00, 20.00); it is left out"


def test_nothing_is_told_where_all_is_seen_and_where_planning_ends_anyway() -> None:
    small, large = field(box(30, 10, 40, 20)), field(BLOCK)
    assert sentence_of_what_is_left_out(small) is None
    assert sentence_of_what_is_left_out(large) is None
    assert sentence_of_what_is_left_out(replace(field(box(30, 10, 50, 30)), unseeable="refuse")) is None
