"""The winner of a race passes after the fewest tries, on any number of cores."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from functools import partial

import pytest

from rota.planners.patrol.methods.fewest.racing import race


@pytest.mark.parametrize(
    ("tries", "winner"),
    [
        ([[None, None, "a"], [None, "b"], [None, "c"]], "b"),  # after the fewest tries, the first of several
        ([[None, None], [None, None, None, "b"]], "b"),
        ([["a"], ["b"]], "a"),
        ([[None], []], None),
        ([], None),
    ],
)
@pytest.mark.parametrize("cores", [1, 2, 8])
def test_the_first_to_pass_wins_on_any_number_of_cores(
    monkeypatch: pytest.MonkeyPatch, tries: list[list[str | None]], winner: str | None, cores: int
) -> None:
    made: list[int] = []

    def run(number: int, should_stop: Callable[[], bool]) -> Iterator[str | None]:
        for result in tries[number]:
            time.sleep(0.002 * (len(tries) - number))  # the less promising are ahead of the others
            if should_stop():
                return
            made.append(number)
            yield result

    monkeypatch.setattr(os, "cpu_count", lambda: cores)
    found = race([partial(run, number) for number in range(len(tries))], lambda: False)
    assert found == winner
    if cores == 1 and winner == "b" and len(tries) == 3:
        assert made == [0, 0, 0, 1, 1, 2]  # the last one is beaten once it failed to pass at first


def test_a_race_that_is_stopped_has_no_winner() -> None:
    def run(should_stop: Callable[[], bool]) -> Iterator[str | None]:
        if not should_stop():
            yield "a"

    assert race([run], lambda: True) is None
