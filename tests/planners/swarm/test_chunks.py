"""Parts of a swarm that several threads work on."""

from __future__ import annotations

import threading

import pytest

from rota.planners.swarm.chunks import TRY_AGAIN, Chunks


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_every_robot_is_in_one_part_and_results_are_in_order(threads: int) -> None:
    chunks = Chunks(101, threads, 10)
    for _ in range(5):
        found = chunks.run(lambda begin, end, part: (part, begin, end))
        assert [part for part, _, _ in found] == list(range(len(chunks)))
        assert [robot for _, begin, end in found for robot in range(begin, end)] == list(range(101))


def test_few_robots_are_not_worth_a_thread() -> None:
    assert len(Chunks(19, 4, 10)) == 1
    assert len(Chunks(20, 4, 10)) == 2
    assert len(Chunks(0, 4, 10)) == 1


def test_what_a_job_raises_is_raised() -> None:
    def job(begin: int, end: int, part: int) -> None:
        if part == 3:
            raise ValueError(f"robots {begin} to {end}")

    chunks = Chunks(80, 2, 10)
    for _ in range(3):
        with pytest.raises(ValueError, match="robots 30 to 40"):
            chunks.run(job)


def test_threads_that_bring_nothing_are_left_until_they_are_tried_again() -> None:
    """Each part of a shared run waits for another thread here, so that alone is faster."""
    chunks, ours, used = Chunks(80, 2, 10), threading.get_ident(), []
    done = threading.Barrier(2, timeout=20)

    def job(begin: int, end: int, part: int) -> int:
        if shared:
            done.wait()
        return threading.get_ident()

    for k in range(TRY_AGAIN + 2):
        shared = k in (0, TRY_AGAIN - 1)
        used.append(any(thread != ours for thread in chunks.run(job)))
    assert [k for k, others in enumerate(used) if others] == [0, TRY_AGAIN - 1]
