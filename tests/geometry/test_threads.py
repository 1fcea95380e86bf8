"""Parts of one piece of work on all cores."""

from __future__ import annotations

import threading

import pytest

from rota.geometry.threads import side_by_side


def test_answers_come_in_the_order_of_the_parts_and_a_lone_part_needs_no_thread() -> None:
    later = threading.Event()

    def square(part: int) -> int:
        if part == 0:
            assert later.wait(5)  # the first is done last
        else:
            later.set()
        return part * part

    assert side_by_side(square, range(4)) == [0, 1, 4, 9]
    assert side_by_side(lambda _: threading.current_thread(), [0]) == [threading.current_thread()]
    assert side_by_side(square, []) == []


def test_what_goes_wrong_in_one_part_is_told() -> None:
    with pytest.raises(ZeroDivisionError):
        side_by_side(lambda part: 1 / part, [1, 0, 2])
