"""Teams that keep most of their visits when turns are off: how they are ranked, and that a choice is no worse."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from tests.planners.bounce.test_bounce_plans import ROOM, ZONES, mission_on

from rota.check import check_plan
from rota.errors import MissionError
from rota.planners.bounce import robust_team
from rota.planners.bounce.inexact_plan import Inexact, Kept, with_errors
from rota.planners.bounce.inexact_turns import Estimate
from rota.planners.bounce.planner_settings import BounceSettings
from rota.planning.make_plan import make_plan


def left_of(share: float, half_s: float) -> Inexact:
    sure = Estimate(value=share, error=0.0)
    kept = (Kept(name="z", exact=sure, inexact=sure), Kept(name="y", exact=sure, inexact=Estimate(value=1.0, error=0)))
    return Inexact(error_deg=1, runs=9, lasting_s=9e3, kept=kept, met_s=(half_s / 2, half_s, 2 * half_s))


def test_who_is_watched_as_well_is_ranked_by_the_time_to_the_first_contact() -> None:
    found = {0: left_of(0.9, 100), 1: left_of(0.89, 300), 2: left_of(0.5, math.inf), 3: left_of(0.885, 200)}
    assert robust_team.rank(found) == [1, 3, 0, 2]


@pytest.mark.slow  # plays out many teams
def test_the_chosen_team_keeps_no_less_than_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robust_team, "CANDIDATES", 6)
    mission = mission_on(ROOM, 2, ZONES, turning_error_deg=1.0, bouncing_angles_deg=(90,))
    robust = make_plan(replace(mission, planning=replace(BounceSettings.of(mission), purpose="robust")))
    assert check_plan(robust).verdict == "met"
    first, chosen = (with_errors(plan, most_runs=200) for plan in (make_plan(mission), robust))
    assert chosen.least_share >= first.least_share - 0.03
    assert chosen.met_s is not None
    assert first.met_s is not None
    better_watched = chosen.least_share > first.least_share + 0.02
    assert better_watched or chosen.met_s[1] >= 0.8 * first.met_s[1]
    assert make_plan(robust.mission) == robust


def test_the_paper_s_own_algorithm_knows_no_errors() -> None:
    with pytest.raises(MissionError, match="robust is not allowed; Algorithm 2 as printed knows no errors"):
        BounceSettings(cell_m=1, method="as_printed", purpose="robust")
