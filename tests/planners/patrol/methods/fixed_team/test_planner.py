"""What a search for a fixed team's least ratio does with each ratio that it tries."""

from __future__ import annotations

from tests.planners.patrol.searching import YARD, search_on

from rota.planners.patrol.annealing.schedule import share_of_moves
from rota.planners.patrol.initial.allocation import period_groupings
from rota.planners.patrol.methods.fixed_team.planner import searching_longer_periods


def test_each_ratio_is_tried_once_with_all_moves() -> None:
    usual = search_on(YARD)
    tours = period_groupings(usual.problem, 1)[0].tours
    longer = searching_longer_periods(usual)
    assert share_of_moves(longer, tours) == 1.0 > share_of_moves(usual, tours)
    assert longer.settings.screening.allocations == usual.settings.fixed_team.screened
