"""One planning job in its process: started, listened to, asked to stop, and ended when it does not."""

from __future__ import annotations

import asyncio
import logging
import time

from rota.web.jobs.live import LiveJob
from rota.web.limits import Limits
from rota.web.refusal import Json
from rota.web.store.database import Database, now
from rota.web.store.jobs import set_job
from rota.web.store.plans import finish_plan
from rota.web.workers.process import WorkerGone, WorkerProcess

log = logging.getLogger(__name__)


class JobRunner:
    """Runs jobs, each in a fresh process. One process is kept ready, so that a job need not wait for its start."""

    def __init__(self, database: Database, limits: Limits, *, prepares: bool) -> None:
        self._prepares = prepares
        self._database, self._limits = database, limits
        self._workers: dict[str, WorkerProcess] = {}
        self._ready: WorkerProcess | None = None

    async def prepare(self) -> None:
        """Start a process ahead of the next job, which then need not wait for what planning loads."""
        if self._prepares and (self._ready is None or not self._ready.alive):
            self._ready = await self._start()
            await self._ready.send({"task": "prepare"})

    async def _start(self) -> WorkerProcess:
        return await WorkerProcess.start(self._limits.for_workers("planning", str(self._database.folder)))

    async def run(self, live: LiveJob) -> None:
        """Run a job to its end, and keep what became of it."""
        live.begin()
        await asyncio.to_thread(set_job, self._database, live.job, state="running", started_at=now())
        live.tell()
        worker, self._ready = self._ready, None
        if worker is None or not worker.alive:
            worker = await self._start()
        self._workers[live.job] = worker
        try:
            if live.stopping:
                await worker.send({"stop": True})
            ended = await self._follow(live, worker)
        finally:
            del self._workers[live.job]
            await asyncio.shield(worker.kill())
        await asyncio.to_thread(self._keep_end, live, ended)

    async def _follow(self, live: LiveJob, worker: WorkerProcess) -> Json:
        """What the process tells until it ends, by itself, by the time limit, or because it did not heed a stop."""
        guard = asyncio.create_task(self._guard(live, worker))
        try:
            await worker.send({"job": live.job})
            while True:
                told, _ = await worker.receive()
                if told["event"] == "progress":
                    live.progress(told["fraction"], told["doing"])
                elif told["event"] == "better":
                    live.note_better({key: told[key] for key in ("plan", "robots", "met")})
                    await asyncio.to_thread(self._keep_best, live)
                else:
                    return told
        except WorkerGone:
            if live.killed_because is not None:
                return live.killed_because
            log.warning("the process of job %s ended before its plan", live.job)
            message = "the process that planned ended; it may have needed more memory than is allowed"
            return {"outcome": "failed", "message": message}
        finally:
            guard.cancel()

    async def _guard(self, live: LiveJob, worker: WorkerProcess) -> None:
        """Ask a job to stop at its time limit; kill it a while after it was asked to, and note why."""
        limit_s, grace_s = self._limits.job_time_s, self._limits.stop_grace_s
        asked_s: float | None = None
        while asked_s is None or time.monotonic() - asked_s < grace_s:
            if asked_s is None and live.stopping:
                asked_s = time.monotonic()
            elif asked_s is None and live.elapsed_s >= limit_s:
                asked_s = time.monotonic()
                await worker.send({"stop": True})
            if worker.memory_bytes > self._limits.job_memory_bytes:
                message = f"planning needed more than {self._limits.job_memory_bytes / 2**20:,.0f} MiB of memory"
                live.killed_because = {"outcome": "failed", "message": message}
                await worker.kill()
                return
            await asyncio.sleep(0.1)
        why = "it was asked to stop" if live.stopping else f"its {limit_s:.0f} s were over"
        live.killed_because = {"outcome": "stopped", "message": f"the job was ended {grace_s:.0f} s after {why}"}
        await worker.kill()

    def _keep_best(self, live: LiveJob) -> None:
        best = live.best
        assert best is not None
        values = {"best_robots": best["robots"], "best_met": best["met"], "best_plan": best["plan"]}
        set_job(self._database, live.job, elapsed_s=round(live.elapsed_s, 3), **values)

    def _keep_end(self, live: LiveJob, ended: Json) -> None:
        """Keep the outcome; of a job that was killed, the best plan until then."""
        state, message, plan = ended["outcome"], ended.get("message"), ended.get("plan")
        values: Json = {}
        if plan is None and live.best is not None and live.best["plan"] is not None:
            plan = live.best["plan"]
            finish_plan(self._database, plan)
        elif plan is not None:
            values = {"best_robots": ended["robots"], "best_met": ended["met"], "best_plan": plan}
        if live.killed_because is not None:
            message = f"{message}; {'this is the best plan until then' if plan else 'there was no plan yet'}"
        elapsed_s = round(live.elapsed_s, 3)
        values |= {"state": state, "message": message, "plan": plan, "ended_at": now(), "elapsed_s": elapsed_s}
        set_job(self._database, live.job, **values)

    async def stop(self, live: LiveJob) -> None:
        """Ask a running job to stop."""
        live.stopping = True
        live.tell()
        worker = self._workers.get(live.job)
        if worker is not None:
            try:
                await worker.send({"stop": True})
            except WorkerGone:
                log.info("job %s ended while it was asked to stop", live.job)

    async def close(self) -> None:
        """End the process that waits for a job, and start none any more."""
        self._prepares = False
        if self._ready is not None:
            await self._ready.kill()
            self._ready = None
