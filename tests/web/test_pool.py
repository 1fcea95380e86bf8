"""Warm workers: what waits is bounded, the newest request of a tab wins, and what hangs or dies is replaced."""

from __future__ import annotations

import asyncio
import json
import os
import signal
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from tests.web.serving import SQUARE

from rota.web.limits import Limits
from rota.web.refusal import Refusal
from rota.web.workers.pool import Pool

DOCUMENT = json.dumps({"document": {**SQUARE, "name": ""}}).encode()


def with_pool(tmp_path: Path, use: Callable[[Pool], Awaitable[Any]], **limits: Any) -> Any:
    """What is done with a pool of one process."""

    async def run() -> Any:
        pool = Pool(1, str(tmp_path), Limits(**limits))
        try:
            return await use(pool)
        finally:
            await pool.close()

    return asyncio.run(run())


def statuses(answers: list[Any]) -> list[int]:
    return [answer.status if isinstance(answer, Refusal) else 200 for answer in answers]


def test_of_requests_of_one_tab_that_wait_only_the_newest_is_answered(tmp_path: Path) -> None:
    async def use(pool: Pool) -> list[Any]:
        asked = [pool.ask("validate", DOCUMENT, replaces=tab) for tab in ("a", "a", "a", "b", "a")]
        return await asyncio.gather(*asked, return_exceptions=True)

    assert statuses(with_pool(tmp_path, use)) == [200, 409, 409, 200, 200]  # the first waits for nobody


def test_no_more_wait_than_may(tmp_path: Path) -> None:
    async def use(pool: Pool) -> list[Any]:
        return await asyncio.gather(*(pool.ask("validate", DOCUMENT) for _ in range(4)), return_exceptions=True)

    assert statuses(with_pool(tmp_path, use, waiting_tasks=2)) == [200, 200, 200, 429]


def test_what_takes_too_long_or_dies_is_told_and_the_next_one_is_answered(tmp_path: Path) -> None:
    async def use(pool: Pool) -> list[Any]:
        answers: list[Any] = [await _refused(pool.ask("validate", DOCUMENT, within_s=0.01))]
        asked = asyncio.create_task(_refused(pool.ask("validate", DOCUMENT)))
        while not pool.processes:
            await asyncio.sleep(0.01)
        os.kill(pool.processes[0], signal.SIGKILL)
        return [*answers, await asked, await pool.ask("validate", DOCUMENT)]

    late, dead, (_, body) = with_pool(tmp_path, use)
    assert (late.status, dead.status) == (503, 503)
    assert "longer" in late.message
    assert [fault["path"] for fault in json.loads(body)["faults"]] == [["name"]]


async def _refused(asked: Awaitable[Any]) -> Refusal:
    try:
        await asked
    except Refusal as refusal:
        return refusal
    raise AssertionError("it was answered")
