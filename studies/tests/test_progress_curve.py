"""The best state so far: what counts as better."""

from __future__ import annotations

from rota.planning.progress import SearchState
from rota_studies.progress_curve import progress_curve


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
