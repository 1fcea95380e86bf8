"""Loops that hardly leave their place, by hand; and that they are not chosen where another loop serves."""

from __future__ import annotations

import numpy as np
import pytest
from tests.planners.bounce.test_bounce_plans import mission_on, visit

from rota.check import check_plan
from rota.planners.bounce.cells import make_cells
from rota.planners.bounce.group_search import best_group
from rota.planners.bounce.planner import bouncing_robots, watch_of
from rota.planners.bounce.rattles import is_rattle, rattling_nodes, rattling_robots
from rota.planners.bounce.sentences import rattling_sentence
from rota.planning.make_plan import make_plan

YARD = """
..#....
..#....
..#....
.......
#..#..."""
CORNERS = """
#..#..
####.#
......
....#."""


@pytest.mark.parametrize(
    ("places", "rattles"),
    [
        ([(0, 0), (0, 0)], True),
        ([(0, 0), (0.35, 0), (0.35, 0.35), (0, 0)], True),  # within two widths of 0.34 m
        ([(0, 0), (4, 0), (0, 0)], True),  # between two walls
        ([(0, 0), (3, 3), (1, 1), (0, 0)], True),
        ([(0, 0), (0.5, 0), (0.5, 0.5), (0, 0.5)], False),  # its diagonal is 0.71 m
        ([(0, 0), (4, 0), (4, 0.1), (0, 0)], False),
    ],
)
def test_a_rattle_stays_within_two_widths_or_on_a_line(places: list[tuple[float, float]], rattles: bool) -> None:
    assert is_rattle(np.array(places, float), 0.17) is rattles


@pytest.mark.parametrize("purpose", ["periods", "basin"])
def test_a_rattle_is_not_chosen_where_another_loop_serves(purpose: str) -> None:
    zones = (visit("west", 200, 0, 0, 4, 5), visit("east", 200, 3, 0, 7, 5))
    mission = mission_on(YARD, 1, zones, bouncing_angles_deg=(90,), purpose=purpose)
    bouncing = bouncing_robots(mission, make_cells(mission))
    watch = watch_of(bouncing)
    first = best_group(watch, enough=1.0).group
    assert first is not None
    assert rattling_nodes(watch.cycles, bouncing.cells, 0.3)[list(first.nodes)].all()
    plan = make_plan(mission)
    assert check_plan(plan).verdict == "met"
    assert not rattling_robots(plan)
    places = plan.trajectories[0].positions_m
    assert np.ptp(places, axis=0).min() > 0


def test_fewer_rattles_buy_no_longer_gap_where_some_stay() -> None:
    zones = (visit("north", 400, 2, 3, 3, 4), visit("middle", 400, 2, 1, 3, 2))
    mission = mission_on(CORNERS, 2, zones, bouncing_angles_deg=(90,))
    bouncing = bouncing_robots(mission, make_cells(mission))
    watch = watch_of(bouncing)
    rattling = rattling_nodes(watch.cycles, bouncing.cells, 0.3)
    fewer = best_group(watch, enough=1.0, last=rattling).group
    assert best_group(watch, enough=1.0, allowed=~rattling).group is None
    assert fewer is not None
    assert rattling[list(fewer.nodes)].sum() == 1
    plan = make_plan(mission)
    assert len(rattling_robots(plan)) == 2
    assert check_plan(plan).worst_ratio < 0.5 * fewer.ratio


def test_a_rattle_of_several_cells_is_told() -> None:
    zones = (visit("west", 60, 0, 0, 1, 1), visit("east", 60, 5, 0, 6, 1))
    plan = make_plan(mission_on("......", 1, zones, bouncing_angles_deg=(180,)))
    assert rattling_robots(plan) == {"robot-1": pytest.approx(5.0)}
    told = rattling_sentence(plan)
    assert told is not None
    assert told.startswith("robot-1 over 5 m rattles to and fro for ever")
