"""What is known of a job only while the server runs: its progress, and who listens to it."""

from __future__ import annotations

import asyncio
import time
from collections import deque

from rota.planning.progress import SteadyProgress
from rota.web.refusal import Json

MOST_BETTER = 100  # plans that a listener who is slow can be behind


class Listener:
    """Somebody who hears of a job: that it changed, and of each better plan."""

    def __init__(self) -> None:
        self.changed = asyncio.Event()
        self.better: deque[Json] = deque(maxlen=MOST_BETTER)


class LiveJob:
    """A job that waits or runs here."""

    def __init__(self, job: str, time_limit_s: float | None) -> None:
        self.job = job
        self.doing = ""
        self._progress = SteadyProgress(time_limit_s)
        self.best: Json | None = None
        self.began_s: float | None = None
        self.stopping = False
        self.killed_because: Json | None = None
        self.over = False
        self.listeners: set[Listener] = set()

    def begin(self) -> None:
        """From now on time counts."""
        self.began_s, self.doing = time.monotonic(), "starting"

    @property
    def elapsed_s(self) -> float:
        """Since it began; 0 before."""
        return 0.0 if self.began_s is None else time.monotonic() - self.began_s

    def progress(self, fraction: float, doing: str) -> None:
        """How far it has come."""
        self._progress.tell(fraction, self.elapsed_s)
        self.doing = doing
        self.tell()

    def note_better(self, better: Json) -> None:
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

    def show(self, kept: Json, place_in_queue: int | None) -> Json:
        """The job as it is kept, with what is known here."""
        doing = "stopping" if self.stopping else self.doing
        elapsed_s = self.elapsed_s
        left_s = self._progress.left_s(elapsed_s)
        progress = {
            "fraction": self._progress.share,
            "doing": doing,
            "elapsed_s": round(elapsed_s, 3),
            "left_s": None if left_s is None or self.stopping else round(left_s, 1),
        }
        return {**kept, "progress": progress, "best": self.best or kept["best"], "place_in_queue": place_in_queue}
