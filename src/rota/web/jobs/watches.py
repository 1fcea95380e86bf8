"""Live fleets: each watched by a process of its own for as long as the server runs and nobody stops it."""

from __future__ import annotations

import asyncio
import json
from collections import deque

from rota.web.jobs.live import Listener
from rota.web.limits import Limits
from rota.web.refusal import Json, Refusal, no_such
from rota.web.store.database import new_id, now
from rota.web.workers.process import WorkerGone, WorkerProcess

KEPT_NOTICES, KEPT_ENDED = 200, 20


class LiveWatch:
    """One fleet: its last state, its last notices, and who listens."""

    def __init__(self, plan: str, link: str) -> None:
        self.id, self.plan, self.link = new_id(), plan, link
        self.state, self.began_at = "starting", now()
        self.message: str | None = None
        self.last: bytes | None = None
        self.notices: deque[tuple[int, bytes]] = deque(maxlen=KEPT_NOTICES)
        self.told = 0
        self.listeners: set[Listener] = set()
        self.worker: WorkerProcess | None = None

    @property
    def over(self) -> bool:
        """Whether nothing comes any more."""
        return self.state in ("ended", "failed")

    def show(self) -> Json:
        """The watch as the interface shows it."""
        return {key: getattr(self, key) for key in ("id", "plan", "link", "state", "began_at", "message")}

    def take(self, told: Json, content: bytes) -> None:
        """What its process told."""
        if told["event"] == "state":
            self.last, self.state = content, "watching"
        elif told["event"] == "notice":
            self.told += 1
            self.notices.append((self.told, content))
        self.wake()

    def end(self, state: str, message: str | None) -> None:
        """Nothing comes any more."""
        self.state, self.message = state, message
        self.wake()

    def wake(self) -> None:
        """Wake up who listens."""
        for listener in self.listeners:
            listener.changed.set()


class WatchDesk:
    """All live fleets. Its methods belong to the server's loop."""

    def __init__(self, data: str, limits: Limits) -> None:
        self._data, self._limits = data, limits
        self._watches: dict[str, LiveWatch] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    def start(self, asked: Json) -> LiveWatch:
        """Watch the fleet of a plan; Refusal when too many are watched."""
        going = [watch for watch in self._watches.values() if not watch.over]
        if len(going) >= self._limits.watches:
            raise Refusal(429, f"{len(going)} fleets are watched already; stop one first")
        ended = [key for key, watch in self._watches.items() if watch.over]
        for key in ended[: max(len(ended) - KEPT_ENDED, 0)]:
            del self._watches[key]
        watch = LiveWatch(asked["plan"], asked["link"])
        self._watches[watch.id] = watch
        task = asyncio.create_task(self._run(watch, asked))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return watch

    async def _run(self, watch: LiveWatch, asked: Json) -> None:
        """Watch in a process of its own until it ends, and pass on what it tells."""
        worker = await WorkerProcess.start(self._limits.for_workers("watching", self._data))
        watch.worker = worker
        try:
            await worker.send(asked)
            while True:
                told, content = await worker.receive()
                if told["event"] == "ended":
                    watch.end(told["state"], told["message"])
                    return
                watch.take(told, content)
        except WorkerGone:
            watch.end("failed", "the process that watched ended")
        finally:
            watch.worker = None
            await asyncio.shield(worker.kill())

    async def stop(self, key: str) -> LiveWatch:
        """End a watch; Refusal for one that has ended."""
        watch = self.find(key)
        if watch.over:
            raise Refusal(409, "the watch has ended")
        if watch.worker is not None:
            try:
                await watch.worker.send({"stop": True})
            except WorkerGone:
                watch.end("failed", "the process that watched ended")
        return watch

    def find(self, key: str) -> LiveWatch:
        """A watch by its id; Refusal for one that there is not."""
        if key not in self._watches:
            raise no_such("watch", key)
        return self._watches[key]

    def show_all(self) -> list[Json]:
        """All watches, the newest first."""
        return [watch.show() for watch in reversed(self._watches.values())]

    async def close(self) -> None:
        """End all of them."""
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)


def notices_after(watch: LiveWatch, number: int) -> list[tuple[int, Json]]:
    """The notices that came after one, with their numbers."""
    return [(count, json.loads(content)) for count, content in watch.notices if count > number]
