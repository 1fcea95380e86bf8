"""Warm worker processes for short tasks: one task at a time each, a bounded queue before them, a time limit."""

from __future__ import annotations

import asyncio
import logging
from typing import Any

from rota.web.limits import Limits
from rota.web.refusal import Json, Refusal
from rota.web.workers.process import WorkerGone, WorkerProcess

log = logging.getLogger(__name__)
PREPARE_S = 300.0
Answer = tuple[Json, bytes]


class Pool:
    """``size`` processes that read, check, draw and export for the server, started when they are first needed."""

    def __init__(self, size: int, data: str, limits: Limits) -> None:
        self._limits, self._data = limits, data
        self._free = asyncio.Semaphore(size)
        self._idle: list[WorkerProcess] = []
        self._busy: set[WorkerProcess] = set()
        self._waiting = 0
        self._newest: dict[str, int] = {}
        self._count = 0
        self._preparing: asyncio.Task[None] | None = None

    @property
    def processes(self) -> list[int]:
        """The numbers of the processes that work on something just now."""
        return [worker.pid for worker in self._busy]

    async def ask(
        self,
        task: str,
        content: bytes = b"",
        *,
        replaces: str | None = None,
        within_s: float | None = None,
        **given: Any,
    ) -> Answer:
        """What a worker answers to a task.

        replaces: of tasks with the same word that wait here, only the newest is done. within_s: how long it may take.
        Refusal 429 when too many wait, 409 when a newer one took its place, 503 when it took too long or the process
        died, and whatever the worker refuses.
        """
        if self._waiting >= self._limits.waiting_tasks:
            raise Refusal(429, "the server has too much to do just now; try again in a moment")
        self._count += 1
        number = self._count
        if replaces is not None:
            self._newest[replaces] = number
        self._waiting += 1
        try:
            await self._free.acquire()
        finally:
            self._waiting -= 1
        try:
            if replaces is not None and self._newest[replaces] != number:
                raise Refusal(409, "a newer request took the place of this one")
            return await self._ask({"task": task, **given}, content, within_s or self._limits.task_time_s)
        finally:
            self._free.release()
            if replaces is not None and self._newest.get(replaces) == number:
                del self._newest[replaces]

    async def _ask(self, message: Json, content: bytes, within_s: float) -> Answer:
        """The answer of a worker; Refusal when it takes too long, dies or refuses."""
        worker = await self._worker()
        self._busy.add(worker)
        well = False
        try:
            async with asyncio.timeout(within_s):
                await worker.send(message, content)
                answer, body = await worker.receive()
            well = True
        except TimeoutError:
            raise Refusal(503, f"this took longer than {within_s:.0f} s and was given up") from None
        except WorkerGone:
            log.warning("a worker died at the task %s", message["task"])
            raise Refusal(503, "the process that worked on this ended; it may have needed too much memory") from None
        finally:
            self._busy.discard(worker)
            if well:
                self._idle.append(worker)
            else:
                await worker.kill()
        if "refused" in answer:
            told = answer["refused"]
            raise Refusal(told["status"], told["message"], told["faults"])
        return answer, body

    async def _worker(self) -> WorkerProcess:
        while self._idle:
            worker = self._idle.pop()
            if worker.alive:
                return worker
        return await self._start()

    async def _start(self) -> WorkerProcess:
        return await WorkerProcess.start(self._limits.for_workers("tasks", self._data))

    async def prepare(self) -> None:
        """Start a process ahead, which loads what it needs while nobody waits for it yet."""
        self._preparing = asyncio.create_task(self._prepare())

    async def _prepare(self) -> None:
        try:
            await self.ask("prepare", within_s=PREPARE_S)
        except Refusal as refusal:
            log.warning("preparing: %s", refusal)

    async def close(self) -> None:
        """End all processes."""
        if self._preparing is not None:
            self._preparing.cancel()
        workers, self._idle = [*self._idle, *self._busy], []
        await asyncio.gather(*(worker.kill() for worker in workers))
