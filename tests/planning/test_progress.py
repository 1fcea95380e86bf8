"""The share done and the time left."""

from __future__ import annotations

import pytest

from rota.planning.progress import SearchState, SteadyProgress, rank


def test_the_share_done_never_falls_and_ends_at_one() -> None:
    progress = SteadyProgress()
    assert [progress.tell(share, k) for k, share in enumerate([0.1, 0.95, 0.93, 0.95, 1.2])] == [
        0.1,
        0.95,
        0.95,
        0.95,
        1,
    ]


def test_the_time_left_follows_from_the_rate_so_far_and_is_unknown_once_that_is_refuted() -> None:
    progress = SteadyProgress()
    assert progress.left_s(5.0) is None
    progress.tell(0.01, 10.0)
    assert progress.left_s(10.0) is None  # so little tells nothing
    progress.tell(0.25, 20.0)
    assert [progress.left_s(at_s) for at_s in (20.0, 50.0, 79.0)] == pytest.approx([60.0, 30.0, 1.0])
    assert progress.left_s(81.0) is None  # it takes longer than foretold
    progress.tell(0.2, 90.0)
    assert progress.left_s(90.0) is None  # what begins again tells nothing
    progress.tell(0.5, 100.0)
    assert progress.left_s(100.0) == pytest.approx(100.0)


def test_a_time_limit_bounds_the_time_left() -> None:
    progress = SteadyProgress(time_limit_s=30.0)
    progress.tell(0.1, 10.0)
    assert progress.left_s(12.0) == pytest.approx(18.0)


def test_a_plan_that_can_be_driven_comes_before_one_that_sees_more() -> None:
    def state(unseen_share: float, late_share: float, **more: bool) -> SearchState:
        return SearchState(stage="checked", robots=2, unseen_share=unseen_share, late_share=late_share, **more)

    ordered = [
        state(0.0, 0.0, met=True),
        state(0.0, 0.4),
        state(0.3, 0.2),
        state(0.0, 0.1, drivable=False),
    ]
    assert sorted(reversed(ordered), key=rank) == ordered
