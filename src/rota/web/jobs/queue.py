"""The queue of planning jobs: at most so many run at once, each in a process of its own, in the order they came."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import deque
from collections.abc import Callable
from typing import Any

from rota.web.jobs.live import LiveJob
from rota.web.jobs.runner import JobRunner
from rota.web.limits import Limits
from rota.web.refusal import Json, Refusal, unkept
from rota.web.store.database import Database, now
from rota.web.store.jobs import (
    delete_job,
    interrupt_jobs,
    job_again,
    job_json,
    list_jobs,
    new_job,
    new_replan,
    queued_jobs,
    set_job,
)
from rota.web.store.plans import forget_lost_steps

log = logging.getLogger(__name__)


class JobQueue:
    """Starts jobs when their turn comes, and tells of them. All methods belong to the server's loop."""

    def __init__(self, database: Database, limits: Limits, *, prepares: bool) -> None:
        self._database, self._limits = database, limits
        self._waiting: deque[str] = deque()
        self._live: dict[str, LiveJob] = {}
        self._running: dict[str, asyncio.Task[None]] = {}
        self._runner = JobRunner(database, limits, prepares=prepares)
        self._closing = False

    async def open(self) -> None:
        """Go on with the queue of the last server; what ran then is marked as interrupted."""
        interrupted = await asyncio.to_thread(self._take_over)
        if interrupted:
            log.warning("%d jobs were interrupted when the last server ended", interrupted)
        for job, time_limit_s in await asyncio.to_thread(queued_jobs, self._database):
            self._enqueue(job, time_limit_s)
        if not self._running:
            await self._runner.prepare()

    def _take_over(self) -> int:
        interrupted = interrupt_jobs(self._database)
        forget_lost_steps(self._database)
        return interrupted

    async def add(self, mission: str, asked: Json) -> Json:
        """A new job; Refusal when there are too many, or no such mission."""
        return await self._add(new_job, mission, asked)

    async def replan(self, change: Json, asked: Json) -> Json:
        """A new job that replans; Refusal when there are too many, or no such plan."""
        return await self._add(new_replan, change, asked)

    async def again(self, job: str) -> Json:
        """A new job that asks the same once more."""
        return await self._add(job_again, job)

    async def _add(self, make: Callable[..., Json], *asked: Any) -> Json:
        job = await asyncio.to_thread(make, self._database, *asked, self._limits)
        self._enqueue(job["id"], job["time_limit_s"])
        return self.with_progress(job)

    def _enqueue(self, job: str, time_limit_s: float | None) -> None:
        self._live[job] = LiveJob(job, time_limit_s)
        self._waiting.append(job)
        self._start_what_may_run()

    def _start_what_may_run(self) -> None:
        while self._waiting and len(self._running) < self._limits.planning_jobs and not self._closing:
            job = self._waiting.popleft()
            self._running[job] = asyncio.create_task(self._run(job))
        for job in self._waiting:  # their places have changed
            self._live[job].tell()

    async def _run(self, job: str) -> None:
        """Run a job to its end, note a failure, and start what may run next."""
        live = self._live[job]
        try:
            await self._runner.run(live)
        except asyncio.CancelledError:
            raise
        except Exception as error:
            log.exception("job %s", job)
            message = str(unkept(error) or "a fault in Rota, not in the mission; the server's log has it")
            await asyncio.to_thread(set_job, self._database, job, state="failed", message=message, ended_at=now())
        finally:
            self._running.pop(job, None)
            self._live.pop(job, None)
            live.end()
            if not self._closing:
                self._start_what_may_run()
                if not self._running:  # otherwise it would take time from a plan
                    await self._runner.prepare()

    async def stop(self, job: str) -> Json:
        """Ask a job to stop with its best plan; one that waits is stopped at once."""
        kept = await asyncio.to_thread(job_json, self._database, job)
        live = self._live.get(job)
        if live is None:
            raise Refusal(409, f"the job is over: {kept['state']}")
        if job in self._waiting:
            self._waiting.remove(job)
            del self._live[job]
            await asyncio.to_thread(
                set_job, self._database, job, state="stopped", message="stopped while it waited", ended_at=now()
            )
            live.end()
            self._start_what_may_run()
        else:
            await self._runner.stop(live)
        return await self.show(job)

    async def delete(self, job: str) -> None:
        """Delete a job that is over."""
        await asyncio.to_thread(delete_job, self._database, job)

    async def show(self, job: str) -> Json:
        """A job with its progress."""
        return self.with_progress(await asyncio.to_thread(job_json, self._database, job))

    async def show_all(self) -> list[Json]:
        """All jobs with their progress, the newest first."""
        return [self.with_progress(job) for job in await asyncio.to_thread(list_jobs, self._database)]

    def with_progress(self, kept: Json) -> Json:
        """A job as it is kept, with what is known of it while it waits or runs."""
        live = self._live.get(kept["id"])
        if live is None:
            return kept
        place = self._waiting.index(kept["id"]) + 1 if kept["id"] in self._waiting else None
        return live.show(kept, place)

    def live(self, job: str) -> LiveJob | None:
        """A job that waits or runs; None for one that is over."""
        return self._live.get(job)

    async def close(self) -> None:
        """End all processes at once; what ran is marked as interrupted by the next server."""
        self._closing = True
        tasks = list(self._running.values())
        for task in tasks:
            task.cancel()
        for task in tasks:
            with contextlib.suppress(asyncio.CancelledError):
                await task
        await self._runner.close()
        await asyncio.to_thread(interrupt_jobs, self._database)
