"""The share done and the time left; the best state so far: what counts as better."""

from __future__ import annotations

import pytest

from rota.planning.progress import SearchState, SteadyProgress, progress_curve


def searched(robots: int, unseen: float, late: float = 0.0) -> SearchState:
    return SearchState(stage="searched", robots=robots, unseen_share=unseen, late_share=late)


def checked(robots: int, unseen: float, *, met: bool) -> SearchState:
    return SearchState(stage="checked", robots=robots, unseen_share=unseen, late_share=0.0, met=met)


def test_less_unseen_and_late_is_better_until_something_is_met_then_fewer_robots() -> None:
    states = [
        searched(4, 0.2),
        searched(4, 0.0, late=0.9),
        searched(4, 0.1),
        searched(3, 0.1),
        checked(4, 0.05, met=False),
        checked(5, 0.0, met=True),
        searched(4, 0.0),
        checked(4, 0.0, met=True),
        checked(4, 0.0, met=True),
        searched(3, 0.0),
    ]
    points = progress_curve((float(k), state) for k, state in enumerate(states))
    assert [states.index(point.best) for point in points] == [0, 0, 2, 3, 4, 5, 5, 7, 7, 7]
    assert [point.state for point in points] == states


def test_threads_may_tell_out_of_order() -> None:
    late, early = searched(2, 0.3), searched(2, 0.5)
    points = progress_curve([(2.0, late), (1.0, early)])
    assert [(point.time_s, point.best) for point in points] == [(1.0, early), (2.0, late)]
    assert progress_curve([]) == ()


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
