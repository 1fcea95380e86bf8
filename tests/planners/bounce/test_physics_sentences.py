"""What is said of clocks: by hand, two that are half a percent off part by 0.01 s a second."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tests.planners.bounce.test_bounce_plans import ROOM, ZONES, mission_on

from rota.planners.bounce.physics_sentences import clocks_sentence
from rota.planning.make_plan import search_plan


@pytest.mark.parametrize(("margin_s", "told"), [(0.047, "use it up in 4.7 s"), (0.6, None)])
def test_a_margin_of_next_to_nothing_is_told_with_a_warning(margin_s: float, told: str | None) -> None:
    found = search_plan(mission_on(ROOM, 2, ZONES))
    sentence = clocks_sentence(found.plan, replace(found.report, clock_margin_s=margin_s))
    assert sentence is not None
    assert (told in sentence) if told else ("Careful" not in sentence)
