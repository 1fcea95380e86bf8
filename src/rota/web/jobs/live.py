"""What is known of a job only while the server runs: its progress, and who listens to it."""

from __future__ import annotations

import asyncio
import time
from collections import deque

from rota.web.refusal import Json

MOST_BETTER = 100  # plans that a listener who is slow can be behind


class Listener:
    """Somebody who hears of a job: that it changed, and of each better plan."""

    def __init__(self) -> None:
        self.changed = asyncio.Event()
        self.better: deque[Json] = deque(maxlen=MOST_BETTER)


class LiveJob:
    """A job that waits or runs here."""

    def __init__(self, job: str) -> None:
        self.job = job
        self.fraction, self.doing = 0.0, ""
        self.best: Json | None = None
        self.began_s: float | None = None
        self.stopping = False
        self.killed_because: Json | None = None
        self.over = False
        self.listeners: set[Listener] = set()

    def begin(self) -> None:
        """From now on time counts."""
        self.began_s = time.monotonic()

    @property
    def elapsed_s(self) -> float:
        """Since it began; 0 before."""
        return 0.0 if self.began_s is None else time.monotonic() - self.began_s

    def progress(self, fraction: float, doing: str) -> None:
        """How far it has come."""
        self.fraction, self.doing = fraction, doing
        self.tell()

    def found(self, better: Json) -> None:
        """A better plan."""
        self.best = {key: better[key] for key in ("robots", "met", "plan")}
        for listener in self.listeners:
            listener.better.append({**better, "elapsed_s": round(self.elapsed_s, 3)})
        self.tell()

    def end(self) -> None:
        """Nothing comes any more."""
        self.over = True
        self.tell()

    def tell(self) -> None:
        """Wake up who listens."""
        for listener in self.listeners:
            listener.changed.set()

    def shown(self, kept: Json, place_in_queue: int | None) -> Json:
        """The job as it is kept, with what is known here."""
        doing = "stopping" if self.stopping else self.doing
        progress = {"fraction": self.fraction, "doing": doing, "elapsed_s": round(self.elapsed_s, 3)}
        return {**kept, "progress": progress, "best": self.best or kept["best"], "place_in_queue": place_in_queue}
