"""Effort quick with a tenth of its moves, for tests of what plans keep to, not of how few robots they need."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest

from rota.planners.patrol.bounds.best_bound import TOUR_STATES
from rota.planners.patrol.efforts import EFFORTS, shortening_attempts


@pytest.fixture(scope="module", autouse=True)
def short_searches() -> Iterator[None]:
    """Short annealings, and proofs that end early, for all tests of a module or a folder that imports this."""
    quick = EFFORTS["quick"]
    tenth = {
        name: replace(stage, moves=stage.moves // 10)
        for name in ("screening", "annealing", "alternation")
        for stage in [getattr(quick, name)]
    }
    shortening = replace(quick.shortening, attempts=shortening_attempts(200), rounds=4)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(EFFORTS, "quick", replace(quick, shortening=shortening, **tenth))
        patch.setitem(TOUR_STATES, "quick", 4)
        yield
